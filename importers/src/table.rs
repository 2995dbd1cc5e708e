//! Columns that grow row by row.

use crate::changes::{Change, Gather, Keep, Permute, Reserve};
use crate::elements::{element_of, elements_of};
use crate::error::quote;
use crate::interner::Interner;
use crate::layout::{Kind, Layout, Role};
use crate::particles::{Particles, Property};
use crate::text::{integer, number};

/// The columns of some rows. Those that no role fills stay empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) positions: Vec<[f64; 3]>,
    /// Atomic numbers, from readers that find them row by row.
    pub(crate) elements: Vec<u8>,
    pub(crate) labels: [Interner; Kind::ALL.len()],
    pub(crate) radii: Vec<f32>,
    pub(crate) colors: Vec<[f32; 3]>,
    pub(crate) ids: Vec<u64>,
    pub(crate) molecules: Vec<u32>,
    pub(crate) residue_numbers: Vec<i32>,
    pub(crate) properties: Vec<Vec<f32>>,
    /// The row that is being read.
    position: [f64; 3],
    color: [f32; 3],
}

impl Table {
    pub(crate) fn new(layout: &Layout) -> Self {
        Self { properties: vec![Vec::new(); layout.properties().len()], ..Self::default() }
    }

    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn label(&mut self, kind: Kind) -> &mut Interner {
        &mut self.labels[kind as usize]
    }

    /// Takes a label of the row. A column that is not needed is given up if it cannot be had.
    #[inline]
    pub(crate) fn push_label(&mut self, kind: Kind, text: &[u8]) -> Result<(), String> {
        let column = self.label(kind);
        needed(kind, column.push(text), column)
    }

    /// Takes a field of the row. The error continues the place.
    #[inline]
    pub(crate) fn field(&mut self, role: Role, field: &[u8]) -> Result<(), String> {
        match role {
            Role::Skip => Ok(()),
            Role::Axis(axis) => {
                let value = number(field).ok_or_else(|| no_coordinate(field))?;
                self.coordinate(axis, value)
            }
            Role::Label(kind) => self.push_label(kind, field),
            Role::Id => {
                let id = integer(field).and_then(|id| u64::try_from(id).ok());
                self.ids.push(
                    id.ok_or_else(|| format!("{} is no id; ids are whole numbers from 0", quote(field)))?,
                );
                Ok(())
            }
            Role::Molecule => {
                let molecule = integer(field).and_then(|id| u32::try_from(id).ok());
                let problem = || format!("{} is no molecule; these are whole numbers from 0", quote(field));
                self.molecules.push(molecule.ok_or_else(problem)?);
                Ok(())
            }
            Role::Property(index) => {
                self.properties[index].push(property(field)?);
                Ok(())
            }
            Role::Radius | Role::Diameter | Role::Color(_) => {
                let value = number(field).ok_or_else(|| format!("{} is no number", quote(field)))?;
                self.number(role, value)
            }
        }
    }

    /// Takes a field of the row that is a number in the file.
    #[inline]
    pub(crate) fn number(&mut self, role: Role, value: f64) -> Result<(), String> {
        match role {
            Role::Skip => {}
            Role::Axis(axis) => self.coordinate(axis, value)?,
            Role::Radius => self.radius(value)?,
            Role::Diameter => self.radius(0.5 * value)?,
            Role::Color(channel) if value.is_finite() => self.color[channel] = value as f32,
            Role::Color(_) => return Err(format!("the colour {value} is not finite")),
            Role::Property(index) => self.properties[index].push(value as f32),
            Role::Id | Role::Molecule | Role::Label(_) => {
                // As whole numbers these are written without a point.
                let text = value.to_string();
                self.field(role, text.as_bytes())?;
            }
        }
        Ok(())
    }

    #[inline]
    fn coordinate(&mut self, axis: usize, value: f64) -> Result<(), String> {
        if value.abs() <= Particles::FARTHEST {
            self.position[axis] = value;
            return Ok(());
        }
        Err(if value.is_finite() {
            format!("the coordinate {value:e} is too far away: at most {:e}", Particles::FARTHEST)
        } else {
            format!("the coordinate is {value}; coordinates are finite numbers")
        })
    }

    fn radius(&mut self, value: f64) -> Result<(), String> {
        if !(0.0..=Particles::FARTHEST).contains(&value) {
            return Err(format!("the radius is {value}; radii are finite and not negative"));
        }
        self.radii.push(value as f32);
        Ok(())
    }

    /// Ends the row, which has a position, a colour or both.
    #[inline]
    pub(crate) fn end_row(&mut self, has_position: bool, has_colors: bool) {
        if has_position {
            self.positions.push(self.position);
        }
        if has_colors {
            self.colors.push(self.color);
        }
    }

    /// Takes a number of a file in which columns follow each other, the row given.
    pub(crate) fn number_of_column(&mut self, role: Role, row: usize, value: f64) -> Result<(), String> {
        fn at<T: Copy + Default>(column: &mut Vec<T>, row: usize) -> &mut T {
            if row == column.len() {
                column.push(T::default());
            }
            &mut column[row]
        }
        match role {
            Role::Axis(axis) => {
                self.coordinate(axis, value)?;
                at(&mut self.positions, row)[axis] = value;
            }
            Role::Color(channel) => {
                self.number(role, value)?;
                at(&mut self.colors, row)[channel] = value as f32;
            }
            _ => self.number(role, value)?,
        }
        Ok(())
    }

    /// The length of a column that has not as many values as there are rows, if any.
    pub(crate) fn other_length(&self) -> Option<usize> {
        let lengths = [
            self.elements.len(),
            self.radii.len(),
            self.colors.len(),
            self.ids.len(),
            self.molecules.len(),
            self.residue_numbers.len(),
        ];
        let labels = self.labels.iter().map(|column| column.rows().len());
        let properties = self.properties.iter().map(Vec::len);
        let all = lengths.into_iter().chain(labels).chain(properties);
        all.filter(|length| *length > 0).find(|length| *length != self.len())
    }

    /// Appends rows of the same layout.
    pub(crate) fn append(&mut self, other: &mut Self) -> Result<(), String> {
        for (kind, other) in Kind::ALL.into_iter().zip(&other.labels) {
            let column = self.label(kind);
            needed(kind, column.append(other), column)?;
        }
        for (column, other) in self.properties.iter_mut().zip(&mut other.properties) {
            column.append(other);
        }
        self.positions.append(&mut other.positions);
        self.elements.append(&mut other.elements);
        self.radii.append(&mut other.radii);
        self.colors.append(&mut other.colors);
        self.ids.append(&mut other.ids);
        self.molecules.append(&mut other.molecules);
        self.residue_numbers.append(&mut other.residue_numbers);
        Ok(())
    }

    /// Makes room for `rows` in all columns that have any.
    pub(crate) fn reserve_total(&mut self, rows: usize) {
        self.change(&mut Reserve(rows));
    }

    /// Puts the rows in the order of their ids, if they have any. Rows with the same id keep their order.
    pub(crate) fn sort_by_id(&mut self) {
        if !self.ids.is_sorted() {
            self.change(&mut Permute::sorting(&self.ids));
        }
    }

    /// Keeps the rows that `keep` names.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        self.change(&mut Keep(keep));
    }

    /// Replaces the rows by those of these indices, which may repeat.
    pub(crate) fn gather(&mut self, rows: &[usize]) {
        self.change(&mut Gather(rows));
    }

    /// Changes all columns that have rows.
    fn change(&mut self, change: &mut impl Change) {
        fn apply<T: Copy>(change: &mut impl Change, column: &mut Vec<T>) {
            if !column.is_empty() {
                change.apply(column);
            }
        }
        apply(change, &mut self.positions);
        apply(change, &mut self.elements);
        apply(change, &mut self.radii);
        apply(change, &mut self.colors);
        apply(change, &mut self.ids);
        apply(change, &mut self.molecules);
        apply(change, &mut self.residue_numbers);
        self.properties.iter_mut().for_each(|column| apply(change, column));
        self.labels.iter_mut().for_each(|column| apply(change, column.rows_mut()));
    }

    /// Moves the columns into `particles`. `full` is the number that stands for a colour's full intensity; without it,
    /// 255 if any is above 1.
    pub(crate) fn finish(mut self, layout: Layout, full: Option<f32>, particles: &mut Particles) {
        let is_above = || self.colors.iter().flatten().any(|component| *component > 1.0);
        let full = full.unwrap_or_else(|| if is_above() { 255.0 } else { 1.0 });
        for component in self.colors.iter_mut().flatten() {
            *component = (*component / full).clamp(0.0, 1.0);
        }
        let [element, kind, name, residue, chain] = self.labels.map(Interner::finish);
        particles.elements = filled(self.elements).filter(|all| all.iter().any(|&number| number > 0));
        if let Some(labels) = element {
            particles.elements = elements_of(&labels, element_of);
        }
        (particles.types, particles.names, particles.residues, particles.chains) =
            (kind, name, residue, chain);
        particles.radii = filled(self.radii);
        particles.colors = filled(self.colors);
        particles.ids = filled(self.ids);
        particles.molecules = filled(self.molecules);
        particles.residue_numbers = filled(self.residue_numbers);
        let names = layout.properties().iter().cloned();
        let columns = self.properties.into_iter().map(shrunk);
        particles.properties = names.zip(columns).map(|(name, values)| Property { name, values }).collect();
        particles.available = layout.available;
        particles.positions = shrunk(self.positions);
    }
}

/// What became of a change of the column of this kind, which is given up if that failed and it is not needed.
#[inline]
fn needed(kind: Kind, result: Result<(), String>, column: &mut Interner) -> Result<(), String> {
    if result.is_ok() || kind.is_needed() {
        return result;
    }
    column.give_up();
    Ok(())
}

fn shrunk<T>(mut column: Vec<T>) -> Vec<T> {
    column.shrink_to_fit();
    column
}

/// The column, if it has rows.
fn filled<T>(column: Vec<T>) -> Option<Vec<T>> {
    (!column.is_empty()).then(|| shrunk(column))
}

/// A number that may be missing or a truth value.
#[inline]
pub(crate) fn property(field: &[u8]) -> Result<f32, String> {
    match number(field) {
        Some(value) => Ok(value as f32),
        None => match field {
            b"" | b"NA" | b"." | b"?" => Ok(f32::NAN),
            b"T" | b"t" | b"True" | b"true" | b"TRUE" => Ok(1.0),
            b"F" | b"f" | b"False" | b"false" | b"FALSE" => Ok(0.0),
            _ => Err(format!("{} is no number", quote(field))),
        },
    }
}

fn no_coordinate(field: &[u8]) -> String {
    format!("{} is no number; a coordinate is one, such as 1.5", quote(field))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Labels;
    use crate::request::Properties;

    #[test]
    fn rows_are_sorted_by_id_in_place() {
        let mut table = Table::default();
        for (id, label) in [(5, "e"), (3, "c"), (3, "d"), (1, "a"), (2, "b"), (9, "f")] {
            table.field(Role::Id, id.to_string().as_bytes()).unwrap();
            table.field(Role::Label(Kind::Type), label.as_bytes()).unwrap();
            table.number(Role::Axis(2), f64::from(id)).unwrap();
            table.end_row(true, false);
        }
        table.sort_by_id();
        assert_eq!(table.ids, [1, 2, 3, 3, 5, 9]);
        assert_eq!(table.positions.iter().map(|p| p[2]).collect::<Vec<_>>(), [1.0, 2.0, 3.0, 3.0, 5.0, 9.0]);
        let labels = table.labels[Kind::Type as usize].clone().finish().unwrap();
        assert_eq!((0..6).map(|row| labels.name(row)).collect::<String>(), "abcdef");
    }

    /// A table whose rows have, in every column, what follows from a key.
    fn keyed(keys: &[u16]) -> Table {
        let mut layout = Layout::default();
        layout.push_property("q", &Properties::All);
        let mut table = Table::new(&layout);
        for &key in keys {
            let value = f64::from(key);
            let axes = [0, 1, 2].map(Role::Axis);
            let colors = [0, 1, 2].map(Role::Color);
            for role in axes.into_iter().chain(colors).chain([Role::Radius, Role::Property(0)]) {
                table.number(role, value).unwrap();
            }
            let kinds = [Kind::Element, Kind::Type, Kind::Name, Kind::Residue, Kind::Chain].map(Role::Label);
            for role in kinds.into_iter().chain([Role::Id, Role::Molecule]) {
                table.field(role, key.to_string().as_bytes()).unwrap();
            }
            table.elements.push(key as u8);
            table.residue_numbers.push(key.into());
            table.end_row(true, true);
        }
        table
    }

    /// Checks that `table` has the rows of `keys`, whole.
    fn check_rows(table: &Table, keys: &[u16]) {
        assert_eq!(table.len(), keys.len());
        assert_eq!(table.other_length(), None);
        for (row, &key) in keys.iter().enumerate() {
            let (value, number) = (f64::from(key), f32::from(key));
            assert_eq!((table.positions[row], table.colors[row]), ([value; 3], [number; 3]));
            assert_eq!((table.radii[row], table.properties[0][row]), (number, number));
            assert_eq!((table.ids[row], table.molecules[row]), (key.into(), key.into()));
            assert_eq!((table.elements[row], table.residue_numbers[row]), (key as u8, key.into()));
            for column in &table.labels {
                assert_eq!(column.clone().finish().unwrap().name(row), key.to_string());
            }
        }
    }

    /// Whatever is done with rows is done in every column.
    #[test]
    fn rows_stay_whole() {
        let keys = [7, 3, 300, 12, 1, 5];
        check_rows(&keyed(&keys), &keys);
        let mut table = keyed(&keys);
        table.sort_by_id();
        check_rows(&table, &[1, 3, 5, 7, 12, 300]);
        let mut table = keyed(&keys);
        table.retain(&[true, false, true, true, false, true]);
        check_rows(&table, &[7, 300, 12, 5]);
        let mut table = keyed(&keys);
        table.gather(&[2, 2, 0, 5]);
        check_rows(&table, &[300, 300, 7, 5]);
        // Pieces number labels as they come.
        let mut table = keyed(&keys);
        table.append(&mut keyed(&[5, 9, 7])).unwrap();
        check_rows(&table, &[7, 3, 300, 12, 1, 5, 5, 9, 7]);
    }

    #[test]
    fn too_many_names_are_given_up_and_too_many_types_refused() {
        let with = |kind: Kind| {
            let (mut a, mut b) = (Table::default(), Table::default());
            for at in 0..Labels::MOST {
                a.push_label(kind, format!("a{at}").as_bytes()).unwrap();
            }
            b.push_label(kind, b"b").unwrap();
            let joined = a.clone().append(&mut b).is_ok();
            let (pushed, again) = (a.push_label(kind, b"b").is_ok(), a.push_label(kind, b"a1").is_ok());
            (joined, pushed, again, a.labels[kind as usize].clone().finish())
        };
        assert_eq!(with(Kind::Name), (true, true, true, None));
        assert!(matches!(with(Kind::Type), (false, false, true, Some(_))));
    }
}
