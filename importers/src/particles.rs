//! What every reader returns: the particles of one frame, as columns.

use crate::format::Format;
use crate::unit::Unit;

/// The particles of one frame, as columns of equal length. Columns that the file does not have are `None`.
///
/// Particles are in the order of the file; where LAMMPS dumps have ids, in the order of these.
#[derive(Clone, Debug, PartialEq)]
pub struct Particles {
    /// The format of the file.
    pub format: Format,
    /// The frame in the file, from 0.
    pub frame: usize,
    /// Title or comment of the frame, on one line of at most [`Particles::TITLE`] characters; empty if there is none.
    pub title: String,
    /// The unit of positions, radii and cell.
    pub unit: Unit,
    /// Positions in the file's unit; finite, and at most [`Particles::FARTHEST`] from 0 along each axis.
    pub positions: Vec<[f64; 3]>,
    /// Atomic numbers, 1 to 118; 0 if unknown. `None` if no particle's element is known.
    pub elements: Option<Vec<u8>>,
    /// Types: of LAMMPS (`1`, `2`), of GSD, columns called `type`, and labels of XYZ files of which some are not plain
    /// symbols of elements.
    pub types: Option<Labels>,
    /// Radii in the file's unit: finite, not negative. Diameters are halved.
    pub radii: Option<Vec<f32>>,
    /// Red, green, blue as the file has them, 0 to 1 (bytes are divided by 255; others are clamped): display values
    /// (sRGB), not linear light.
    pub colors: Option<Vec<[f32; 3]>>,
    /// Names of atoms, such as `CA`.
    pub names: Option<Labels>,
    /// Names of residues, such as `ALA` or `SOL`.
    pub residues: Option<Labels>,
    /// Numbers of residues.
    pub residue_numbers: Option<Vec<i32>>,
    /// Chains.
    pub chains: Option<Labels>,
    /// Numbers of molecules, as the file has them.
    pub molecules: Option<Vec<u32>>,
    /// Ids or serial numbers, as the file has them.
    pub ids: Option<Vec<u64>>,
    /// The other numeric columns that were asked for, in the order of the file.
    pub properties: Vec<Property>,
    /// The names of all other numeric columns of the file, whether they were asked for or not.
    pub available: Vec<String>,
    /// Bonds that the file states (PDB `CONECT`, mmCIF `_struct_conn`, GSD), as pairs of indices of particles, the lower
    /// first, sorted, each once.
    pub bonds: Vec<[u32; 2]>,
    /// The cell, if the file states one.
    pub cell: Option<Cell>,
}

impl Particles {
    /// The most characters of a title.
    pub const TITLE: usize = 200;
    /// The largest magnitude of a coordinate: squares of distances stay finite in `f64`, and in `f32` once scaled.
    pub const FARTHEST: f64 = 1e30;
    /// The most particles of a frame: indices are `u32`.
    pub const MOST: usize = u32::MAX as usize - 1;

    /// No particles, frame 0.
    pub fn new(format: Format) -> Self {
        Self {
            format,
            frame: 0,
            title: String::new(),
            unit: format.unit(),
            positions: Vec::new(),
            elements: None,
            types: None,
            radii: None,
            colors: None,
            names: None,
            residues: None,
            residue_numbers: None,
            chains: None,
            molecules: None,
            ids: None,
            properties: Vec::new(),
            available: Vec::new(),
            bonds: Vec::new(),
            cell: None,
        }
    }

    /// The number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The numeric column `name`, if the file has it and it was asked for.
    pub fn property(&self, name: &str) -> Option<&[f32]> {
        self.properties.iter().find(|property| property.name == name).map(|property| &*property.values)
    }
}

/// A column of texts of which few are different: names, and for each particle the index of its name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    /// The different texts, in the order of their first appearance. At most [`Labels::MOST`].
    pub names: Vec<String>,
    /// Per particle, an index into `names`.
    pub index: Vec<u16>,
}

impl Labels {
    /// The most different texts.
    pub const MOST: usize = 1 << 16;

    /// The text of a particle.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn name(&self, particle: usize) -> &str {
        &self.names[usize::from(self.index[particle])]
    }
}

/// A numeric column.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name in the file. Columns of several components end in `_x`, `_y`, `_z`, or else in `_0`, `_1` and so on.
    pub name: String,
    /// A value per particle. May be NaN or infinite, if the file says so.
    pub values: Vec<f32>,
}

/// The cell of a frame: a parallelepiped, which may repeat along its vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// A corner, in the file's unit.
    pub origin: [f64; 3],
    /// The edges that start there, in the file's unit. Finite; linearly independent.
    pub vectors: [[f64; 3]; 3],
    /// Along which vectors it repeats.
    pub periodic: [bool; 3],
}

/// A title of at most [`Particles::TITLE`] characters, on one line.
pub(crate) fn title(text: &str) -> String {
    let clean = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c });
    clean.take(Particles::TITLE).collect()
}
