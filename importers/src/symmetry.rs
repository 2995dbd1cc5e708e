//! Crystals: atoms of the asymmetric unit repeated by symmetry operations such as `-x, y+1/2, z`.

use crate::text::number;

/// A symmetry operation on coordinates along the cell's vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Operation {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

/// Images of an atom that are closer than this along each vector of the cell are one: it is on a symmetry element, and
/// coordinates are often given to three or four digits.
const SAME: f64 = 2e-3;

impl Operation {
    /// An operation in the notation of the International Tables; `None` if it is not.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split(',');
        let mut operation = Self { rotation: [[0.0; 3]; 3], translation: [0.0; 3] };
        for axis in 0..3 {
            let part: String =
                parts.next()?.chars().filter(|c| !c.is_whitespace() && !matches!(c, '\'' | '"')).collect();
            let (row, shift) = linear(&part.to_ascii_lowercase())?;
            operation.rotation[axis] = row;
            operation.translation[axis] = shift;
        }
        parts.next().is_none().then_some(operation)
    }

    pub(crate) fn is_identity(&self) -> bool {
        self.rotation == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] && self.translation == [0.0; 3]
    }

    fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let [a, b, c] = self.rotation[axis];
            a * point[0] + b * point[1] + c * point[2] + self.translation[axis]
        })
    }
}

/// The different images of a point in the cell, by coordinates from 0 to 1.
pub(crate) fn images(operations: &[Operation], point: [f64; 3]) -> Vec<[f64; 3]> {
    let mut images: Vec<[f64; 3]> = Vec::with_capacity(operations.len());
    for operation in operations {
        let image = operation.apply(point).map(into_cell);
        let is_same =
            |other: &[f64; 3]| image.iter().zip(other).all(|(a, b)| (a - b - (a - b).round()).abs() < SAME);
        if !images.iter().any(is_same) {
            images.push(image);
        }
    }
    images
}

/// The fraction from 0 to 1; what is 1 but for rounding is 0.
fn into_cell(coordinate: f64) -> f64 {
    /// Of sums of coordinates and thirds.
    const ROUNDING: f64 = 1e-9;
    let fraction = coordinate - coordinate.floor();
    if fraction > 1.0 - ROUNDING { 0.0 } else { fraction }
}

/// The coefficients of x, y and z, and the constant, of a sum such as `-x+y+1/3`.
fn linear(text: &str) -> Option<([f64; 3], f64)> {
    let (mut row, mut shift) = ([0.0; 3], 0.0);
    let mut rest = text;
    while !rest.is_empty() {
        let sign = if rest.starts_with('-') { -1.0 } else { 1.0 };
        rest = rest.strip_prefix(['+', '-']).unwrap_or(rest);
        let end = rest.find(['+', '-']).unwrap_or(rest.len());
        let (term, after) = rest.split_at(end);
        rest = after;
        match term {
            "x" => row[0] += sign,
            "y" => row[1] += sign,
            "z" => row[2] += sign,
            _ => shift += sign * fraction(term)?,
        }
    }
    (row != [0.0; 3]).then_some((row, shift))
}

fn fraction(text: &str) -> Option<f64> {
    let value = |text: &str| number(text.as_bytes()).filter(|value| value.is_finite());
    match text.split_once('/') {
        Some((above, below)) => Some(value(above)? / value(below).filter(|below| *below != 0.0)?),
        None => value(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_read_in_their_notation() {
        let operation = Operation::parse("-y, x-y , 'z+1/3'").unwrap();
        assert_eq!(operation.rotation, [[0.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(operation.translation, [0.0, 0.0, 1.0 / 3.0]);
        assert_eq!(Operation::parse("1/2+X,Y,-Z").unwrap().translation, [0.5, 0.0, 0.0]);
        assert!(Operation::parse("x,y,z").unwrap().is_identity());
        for wrong in ["x,y", "x,y,z,x", "x,y,w", "x,y,1/0", "x,y,", "x,y,1"] {
            assert_eq!(Operation::parse(wrong), None, "{wrong}");
        }
    }

    /// Terms in any order, each with its own sign: what an operation makes of a point is what its text says.
    #[test]
    fn operations_do_what_they_say() {
        let [x, y, z] = [0.1, 0.25, 0.7];
        for (text, expected) in [
            ("x,y,z", [x, y, z]),
            ("x-1/2,y-1/4,z-0.5", [x - 0.5, y - 0.25, z - 0.5]),
            ("1/2-x,-y+1/2,-z-1/2", [0.5 - x, 0.5 - y, -z - 0.5]),
            ("-1/3+y,2/3+x,-5/6-z", [y - 1.0 / 3.0, 2.0 / 3.0 + x, -5.0 / 6.0 - z]),
            ("x-y,y+x,-x-y+1/4", [x - y, x + y, 0.25 - x - y]),
            ("y,z,x", [y, z, x]),
        ] {
            let found = Operation::parse(text).unwrap().apply([x, y, z]);
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(is_near, "{text}: {found:?}, not {expected:?}");
        }
    }

    #[test]
    fn atoms_on_symmetry_elements_have_fewer_images() {
        let operations = ["x,y,z", "-x,-y,-z"].map(|text| Operation::parse(text).unwrap());
        assert_eq!(images(&operations, [0.1, 0.2, 0.3]).len(), 2);
        assert_eq!(images(&operations, [0.5, 0.0, 0.5]), [[0.5, 0.0, 0.5]]);
        assert_eq!(images(&operations, [0.9999, 0.0, 0.0]).len(), 1);
    }
}
