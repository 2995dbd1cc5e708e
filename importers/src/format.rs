//! The formats, and how a file's is told.

use crate::unit::Unit;
use std::path::Path;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// XYZ and extended XYZ.
    Xyz,
    /// Protein Data Bank, fixed columns.
    Pdb,
    /// Crystallographic information of macromolecules (PDBx/mmCIF).
    Mmcif,
    /// GROMACS coordinates.
    Gro,
    /// LAMMPS dump, as text.
    Dump,
    /// General simulation data of HOOMD-blue.
    Gsd,
    /// Points in the polygon file format.
    Ply,
    /// A table of numbers with a header, separated by commas, semicolons or tabs.
    Csv,
    /// A `NumPy` array.
    Npy,
    /// Several `NumPy` arrays in an archive.
    Npz,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 10] = [
        Self::Xyz,
        Self::Pdb,
        Self::Mmcif,
        Self::Gro,
        Self::Dump,
        Self::Gsd,
        Self::Ply,
        Self::Csv,
        Self::Npy,
        Self::Npz,
    ];

    /// The format's name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Xyz => "XYZ",
            Self::Pdb => "PDB",
            Self::Mmcif => "mmCIF",
            Self::Gro => "GRO",
            Self::Dump => "LAMMPS dump",
            Self::Gsd => "GSD",
            Self::Ply => "PLY",
            Self::Csv => "CSV",
            Self::Npy => "NPY",
            Self::Npz => "NPZ",
        }
    }

    /// The endings of file names that stand for the format; text formats may have `.gz` after it.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Xyz => &["xyz", "extxyz", "exyz"],
            Self::Pdb => &["pdb", "ent", "pdb1"],
            Self::Mmcif => &["cif", "mmcif", "pdbx"],
            Self::Gro => &["gro"],
            Self::Dump => &["dump", "lammpstrj", "lammpsdump"],
            Self::Gsd => &["gsd"],
            Self::Ply => &["ply"],
            Self::Csv => &["csv", "tsv"],
            Self::Npy => &["npy"],
            Self::Npz => &["npz"],
        }
    }

    /// The format of a file by its name alone, without looking into it; `None` if the name does not tell. This is the
    /// question whether a path given to the command is a scene or particles.
    pub fn of_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let (stem, extension) = name.rsplit_once('.')?;
        let by_extension = Self::ALL.into_iter().find(|format| format.extensions().contains(&extension));
        // LAMMPS numbers its dumps: `dump.melt.1000`, `melt.dump.0`.
        let is_dump = || stem.split('.').any(|part| part == "dump");
        by_extension.or_else(|| is_dump().then_some(Self::Dump))
    }

    /// The unit of lengths that the format prescribes.
    pub fn unit(self) -> Unit {
        match self {
            Self::Xyz | Self::Pdb | Self::Mmcif => Unit::Angstrom,
            Self::Gro => Unit::Nanometre,
            Self::Dump | Self::Gsd | Self::Ply | Self::Csv | Self::Npy | Self::Npz => Unit::Unknown,
        }
    }
}
