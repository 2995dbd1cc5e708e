//! Whether particles that were made in code are such as readers return.

use crate::cell::cell;
use crate::elements::COUNT;
use crate::particles::{Cell, Labels, Particles};

impl Particles {
    /// Checks what readers ensure: columns are of equal length, and every value is in the range that its field states.
    ///
    /// # Errors
    /// The first fault, by the name of the field; indices count from 0.
    pub fn check(&self) -> Result<(), String> {
        let count = self.len();
        if count > Self::MOST {
            return Err(format!("there are {count} particles; at most {} can be taken", Self::MOST));
        }
        let is_near = |x: &f64| x.abs() <= Self::FARTHEST; // not NaN either
        if let Some(i) = self.positions.iter().position(|position| !position.iter().all(is_near)) {
            return Err(format!("positions [{i}] must be finite, and at most {:e}", Self::FARTHEST));
        }
        let elements = |&element: &u8| (element > COUNT).then(|| element.to_string());
        column("elements", self.elements.as_deref(), count, &format!("from 0 to {COUNT}"), elements)?;
        let radius = |&radius: &f32| (!(0.0..f32::INFINITY).contains(&radius)).then(|| radius.to_string());
        column("radii", self.radii.as_deref(), count, "finite, and not negative", radius)?;
        let color = |color: &[f32; 3]| {
            color.iter().find(|value| !(0.0..=1.0).contains(*value)).map(ToString::to_string)
        };
        column("colors", self.colors.as_deref(), count, "from 0 to 1", color)?;
        self.check_labels(count)?;
        column("residue_numbers", self.residue_numbers.as_deref(), count, "", |_| None)?;
        column("molecules", self.molecules.as_deref(), count, "", |_| None)?;
        column("ids", self.ids.as_deref(), count, "", |_| None)?;
        for property in &self.properties {
            let name = format!("properties[{:?}]", property.name);
            column(&name, Some(&property.values), count, "", |_| None)?;
        }
        self.check_bonds(count)?;
        self.cell.map_or(Ok(()), |Cell { origin, vectors, periodic }| match cell(origin, vectors, periodic) {
            Some(_) => Ok(()),
            None => Err("the vectors of cell must be finite and linearly independent".into()),
        })
    }

    fn check_labels(&self, count: usize) -> Result<(), String> {
        let all = [
            ("types", &self.types),
            ("names", &self.names),
            ("residues", &self.residues),
            ("chains", &self.chains),
        ];
        for (name, labels) in all {
            let Some(Labels { names, index }) = labels else { continue };
            let unknown = |&i: &u16| (usize::from(i) >= names.len()).then(|| format!("the text number {i}"));
            column(name, Some(index), count, &format!("one of the {} texts", names.len()), unknown)?;
        }
        Ok(())
    }

    fn check_bonds(&self, count: usize) -> Result<(), String> {
        let is_wrong = |&[a, b]: &[u32; 2]| a >= b || b as usize >= count;
        if let Some(i) = self.bonds.iter().position(is_wrong) {
            let [a, b] = self.bonds[i];
            return Err(format!("bonds [{i}] joins {a} and {b}; it must join two of {count} particles"));
        }
        if self.bonds.is_sorted_by(|a, b| a < b) { Ok(()) } else { Err("bonds are not sorted".into()) }
    }
}

/// Checks a column of which `wrong` gives a value that is out of range, as it is told.
fn column<T>(
    name: &str,
    values: Option<&[T]>,
    count: usize,
    right: &str,
    wrong: impl Fn(&T) -> Option<String>,
) -> Result<(), String> {
    let Some(values) = values else { return Ok(()) };
    if values.len() != count {
        return Err(format!("{name} has {} values for {count} particles", values.len()));
    }
    let fault = values.iter().enumerate().find_map(|(i, value)| Some((i, wrong(value)?)));
    fault.map_or(Ok(()), |(i, value)| Err(format!("{name} [{i}] is {value}; it must be {right}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;
    use crate::particles::Property;

    fn two() -> Particles {
        Particles { positions: vec![[0.0; 3], [1.0, 2.0, 3.0]], ..Particles::new(Format::Npy) }
    }

    #[test]
    fn what_readers_return_is_right() {
        let text = "2\n\nC 0 0 0\nO 0 0 1.2\n";
        let request = crate::Request::default();
        let read = crate::read_from("a.xyz", std::io::Cursor::new(text), Format::Xyz, &request).unwrap();
        assert_eq!(read.check(), Ok(()));
        assert_eq!(two().check(), Ok(()));
        assert_eq!(Particles::new(Format::Npy).check(), Ok(()));
    }

    #[test]
    fn every_fault_is_told_with_its_column() {
        let labels = |index| Some(Labels { names: vec!["a".into()], index });
        let flat = Cell { origin: [0.0; 3], vectors: [[1.0, 0.0, 0.0]; 3], periodic: [true; 3] };
        let property = Property { name: "q".into(), values: vec![f32::NAN] };
        let cases: Vec<(Particles, &str)> = vec![
            (Particles { positions: vec![[0.0, f64::NAN, 0.0]], ..two() }, "positions [0] must be finite"),
            (Particles { positions: vec![[2e30, 0.0, 0.0]], ..two() }, "positions [0]"),
            (
                Particles { elements: Some(vec![6, 119]), ..two() },
                "elements [1] is 119; it must be from 0 to 118",
            ),
            (Particles { radii: Some(vec![1.0, -1.0]), ..two() }, "radii [1] is -1; it must be finite"),
            (Particles { radii: Some(vec![1.0]), ..two() }, "radii has 1 values for 2 particles"),
            (Particles { colors: Some(vec![[0.0; 3], [0.0, 2.0, 0.0]]), ..two() }, "colors [1] is 2"),
            (Particles { types: labels(vec![0, 1]), ..two() }, "types [1] is the text number 1"),
            (Particles { chains: labels(vec![0]), ..two() }, "chains has 1 values"),
            (Particles { names: labels(vec![0; 3]), ..two() }, "names has 3 values for 2 particles"),
            (Particles { residues: labels(vec![1, 0]), ..two() }, "residues [0] is the text number 1"),
            (Particles { residue_numbers: Some(vec![7]), ..two() }, "residue_numbers has 1 values"),
            (Particles { molecules: Some(vec![7; 3]), ..two() }, "molecules has 3 values"),
            (Particles { elements: Some(vec![6]), ..two() }, "elements has 1 values"),
            (
                Particles { radii: Some(vec![0.0, f32::INFINITY]), ..two() },
                "radii [1] is inf; it must be finite",
            ),
            (Particles { colors: Some(vec![[0.0, f32::NAN, 0.0], [1.0; 3]]), ..two() }, "colors [0] is NaN"),
            (Particles { ids: Some(vec![1; 3]), ..two() }, "ids has 3 values"),
            (Particles { properties: vec![property], ..two() }, "properties[\"q\"] has 1 values"),
            (Particles { bonds: vec![[0, 2]], ..two() }, "bonds [0] joins 0 and 2"),
            (Particles { bonds: vec![[1, 1]], ..two() }, "bonds [0] joins 1 and 1"),
            (Particles { bonds: vec![[0, 1], [0, 1]], ..two() }, "bonds are not sorted"),
            (Particles { cell: Some(flat), ..two() }, "the vectors of cell"),
        ];
        for (particles, said) in cases {
            let fault = particles.check().unwrap_err();
            assert!(fault.starts_with(said), "{fault}");
        }
    }
}
