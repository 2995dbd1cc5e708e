//! The columns of particles, by the names that styles use.

use crate::columns::{Column, Columns};
use importers::elements::{COUNT, element};
use importers::{Labels, Particles};

/// The columns of a file's particles. `radius` is as the style has made it so far.
pub(crate) struct Table<'a> {
    pub(crate) particles: &'a Particles,
    pub(crate) radii: &'a [f32],
}

impl Table<'_> {
    fn labels(&self, name: &str) -> Option<&Labels> {
        let particles = self.particles;
        match name {
            "type" => particles.types.as_ref(),
            "name" => particles.names.as_ref(),
            "residue" => particles.residues.as_ref(),
            "chain" => particles.chains.as_ref(),
            _ => None,
        }
    }

    fn number<'s>(&'s self, name: &str) -> Option<Box<dyn Fn(usize) -> f64 + Sync + 's>> {
        let particles = self.particles;
        let axis = ["x", "y", "z"].into_iter().position(|axis| axis == name);
        if let Some(axis) = axis {
            return Some(Box::new(move |i| particles.positions[i][axis]));
        }
        match name {
            "radius" => Some(Box::new(|i| f64::from(self.radii[i]))),
            "molecule" => {
                let molecules = particles.molecules.as_ref()?;
                Some(Box::new(move |i| f64::from(molecules[i])))
            }
            "resid" => {
                let numbers = particles.residue_numbers.as_ref()?;
                Some(Box::new(move |i| f64::from(numbers[i])))
            }
            "id" => {
                let ids = particles.ids.as_ref()?;
                Some(Box::new(move |i| ids[i] as f64))
            }
            _ => {
                let values = particles.property(name)?;
                Some(Box::new(move |i| f64::from(values[i])))
            }
        }
    }
}

impl Columns for Table<'_> {
    fn names(&self) -> Vec<String> {
        const BUILT_IN: [&str; 12] = [
            "x", "y", "z", "radius", "element", "type", "name", "residue", "resid", "chain", "molecule", "id",
        ];
        let has = |name: &&&str| self.column(name).is_some();
        let built_in = BUILT_IN.iter().filter(has).map(ToString::to_string);
        built_in.chain(self.particles.available.iter().cloned()).collect()
    }

    fn column(&self, name: &str) -> Option<Column<'_>> {
        if name == "element" {
            let elements = self.particles.elements.as_ref()?;
            let names = (0..=COUNT)
                .map(|number| element(number).map_or("", |element| element.symbol).into())
                .collect();
            return Some(Column::Text { index: Box::new(move |i| u32::from(elements[i])), names });
        }
        if let Some(labels) = self.labels(name) {
            let index = Box::new(|i: usize| u32::from(labels.index[i]));
            return Some(Column::Text { index, names: labels.names.clone() });
        }
        self.number(name).map(Column::Number)
    }
}
