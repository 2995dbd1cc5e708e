//! Units of lengths.

/// The unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// 10^-10 m: PDB, mmCIF and, by custom, XYZ; LAMMPS dumps that say `ITEM: UNITS metal` or `real`.
    Angstrom,
    /// 10^-9 m: GRO, and LAMMPS dumps that say `ITEM: UNITS nano`.
    Nanometre,
    /// LAMMPS dumps that say `ITEM: UNITS si`.
    Metre,
    /// The file does not say: GSD, PLY, CSV, `NumPy`, most LAMMPS dumps.
    Unknown,
}

impl Unit {
    /// The length of the unit in angstrom, if it is known.
    pub fn in_angstrom(self) -> Option<f64> {
        match self {
            Self::Angstrom => Some(1.0),
            Self::Nanometre => Some(10.0),
            Self::Metre => Some(1e10),
            Self::Unknown => None,
        }
    }
}
