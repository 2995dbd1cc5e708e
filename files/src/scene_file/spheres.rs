//! The spheres of a scene file, read one at a time.

use super::error::Fault;
use super::material::Materials;
use super::pieces::{Head, Kind, Piece, Pieces};
use super::reader::Section;
use super::sphere::{array, section, sphere};
use scene::Sphere;
use toml::de::{DeArray, DeTable};

/// Where the spheres stand.
pub(super) enum Spheres<'a> {
    /// So many pieces of the text, `[[sphere]]`.
    Pieces(usize),
    /// An array in the head, `sphere = [{ ... }, ...]`.
    Array(&'a DeArray<'a>),
}

impl<'a> Spheres<'a> {
    /// `pieces` spheres in pieces of their own, or those in the field `sphere` of the head's `root`.
    pub(super) fn new(pieces: usize, root: &Section<'a>) -> Result<Self, Fault> {
        const EXAMPLE: &str = "[[sphere]] with center, radius and material";
        match (pieces, root.key_at("sphere")) {
            // All of them may come from files of particles, and a background can be seen by itself.
            (0, None) if ["particles", "background"].iter().any(|key| root.get(key).is_some()) => {
                Ok(Self::Pieces(0))
            }
            (0, _) => Ok(Self::Array(array(root.require("sphere", EXAMPLE)?)?)),
            (_, None) => Ok(Self::Pieces(pieces)),
            (_, Some(at)) => Err(Fault::new(at, "head every sphere with [[sphere]]")),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Pieces(count) => *count,
            Self::Array(array) => array.len(),
        }
    }

    /// Reads all spheres, with room for one more.
    pub(super) fn read(
        &self,
        text: &str,
        head: &Head,
        materials: &mut Materials<'_>,
    ) -> Result<Vec<Sphere>, Fault> {
        let mut spheres = Vec::with_capacity(self.len() + 1);
        let mut read = |i, section: &Section<'_>| {
            debug_assert_eq!(i, spheres.len());
            spheres.push(sphere(section, materials)?);
            Ok(())
        };
        match self {
            Self::Pieces(_) => {
                for (i, piece) in pieces(text).enumerate() {
                    piece.parse(text, |root| read(i, &of_piece(i, root)?))?;
                }
            }
            Self::Array(array) => {
                for (i, value) in array.iter().enumerate() {
                    section(i, value)
                        .and_then(|section| read(i, &section))
                        .map_err(|fault| head.fault(fault))?;
                }
            }
        }
        Ok(spheres)
    }

    /// Finds a place in sphere `i` with `find`, as a place in the whole text.
    pub(super) fn nth(
        &self,
        text: &str,
        head: &Head,
        i: usize,
        find: impl FnOnce(&Section<'_>) -> Result<usize, Fault>,
    ) -> Result<usize, Fault> {
        match self {
            Self::Pieces(_) => match pieces(text).nth(i) {
                Some(piece) => {
                    let at = piece.parse(text, |root| find(&of_piece(i, root)?))?;
                    Ok(at + piece.span.start)
                }
                None => Ok(0),
            },
            Self::Array(array) => match array.get(i) {
                Some(value) => section(i, value).and_then(|s| find(&s)).map(|at| head.place(at)),
                None => Ok(0),
            },
        }
    }
}

fn pieces(text: &str) -> impl Iterator<Item = Piece> {
    Pieces::new(text).filter(|piece| piece.kind == Kind::Sphere)
}

/// The section of sphere `i`, the only one in a piece with this root.
fn of_piece<'a>(i: usize, root: &'a DeTable<'a>) -> Result<Section<'a>, Fault> {
    match root.get("sphere").and_then(|value| value.get_ref().as_array()) {
        Some(spheres) => section(i, &spheres[0]),
        None => Err(Fault::new(0, "head every sphere with [[sphere]]")),
    }
}
