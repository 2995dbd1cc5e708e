//! Columns that grow row by row, and what each field of a row is.

use crate::elements;
use crate::error::quote;
use crate::particles::{Labels, Particles, Property};
use crate::request::Properties;
use crate::text::{integer, number};
use std::collections::HashMap;

/// The most columns of a file.
pub(crate) const MOST_COLUMNS: usize = 1024;
/// The most bytes of a label.
const LONGEST_LABEL: usize = 100;

/// What a field of a row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Skip,
    /// A coordinate.
    Axis(usize),
    /// A radius, or a diameter.
    Radius,
    Diameter,
    /// A component of a colour.
    Color(usize),
    Label(Kind),
    Id,
    Molecule,
    /// A numeric column beyond these, by its index.
    Property(usize),
}

/// A column of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Symbols of elements, or atomic numbers.
    Element,
    Type,
    Name,
    Residue,
    Chain,
}

const KINDS: usize = 5;

/// The roles of a row's fields, in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) roles: Vec<Role>,
    /// The names of the properties that are read.
    properties: Vec<String>,
    /// The names of all properties.
    pub(crate) available: Vec<String>,
}

impl Layout {
    /// The fields of an atom in PDB and mmCIF, in order: position, labels, number of the residue, serial number, occupancy and
    /// temperature factor. Also returns the roles of the last two, which are read if they are wanted.
    pub(crate) fn of_atoms(wanted: &Properties) -> (Self, [Role; 2]) {
        let mut layout = Self::default();
        (0..3).for_each(|axis| layout.push(Role::Axis(axis)));
        let labels = [Kind::Name, Kind::Residue, Kind::Chain].map(Role::Label);
        labels.into_iter().chain([Role::Molecule, Role::Id]).for_each(|role| layout.push(role));
        let others = ["occupancy", "b_factor"].map(|name| layout.property(name, wanted));
        layout.roles.extend(others);
        (layout, others)
    }

    pub(crate) fn push(&mut self, role: Role) {
        self.roles.push(role);
    }

    /// A field that is no more than a number with a name: read if it is wanted.
    pub(crate) fn push_property(&mut self, name: &str, wanted: &Properties) {
        let role = self.property(name, wanted);
        self.push(role);
    }

    /// The role of a number with a name.
    pub(crate) fn property(&mut self, name: &str, wanted: &Properties) -> Role {
        self.available.push(name.to_owned());
        if !is_wanted(name, wanted) {
            return Role::Skip;
        }
        self.properties.push(name.to_owned());
        Role::Property(self.properties.len() - 1)
    }

    /// The number of properties that are read.
    pub(crate) fn property_count(&self) -> usize {
        self.properties.len()
    }

    pub(crate) fn has(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    /// Bytes per row of a [`Table`] and of what becomes of it.
    pub(crate) fn bytes_per_row(&self) -> u64 {
        let bytes = |role: &Role| match role {
            Role::Skip => 0,
            Role::Axis(_) | Role::Id => 8,
            Role::Label(_) => 2,
            Role::Radius | Role::Diameter | Role::Color(_) | Role::Molecule | Role::Property(_) => 4,
        };
        self.roles.iter().map(bytes).sum::<u64>() + 5
    }
}

/// Whether a numeric column is asked for, by its own name or by the name that its components share.
pub(crate) fn is_wanted(name: &str, wanted: &Properties) -> bool {
    match wanted {
        Properties::None => false,
        Properties::All => true,
        Properties::Named(names) => {
            let shared = name.rsplit_once('_').map_or(name, |(shared, _)| shared);
            names.iter().any(|wanted| wanted == name || wanted == shared)
        }
    }
}

/// The names of the components of a column.
pub(crate) fn components(name: &str, count: usize) -> Vec<String> {
    match count {
        1 => vec![name.to_owned()],
        3 => ["x", "y", "z"].map(|axis| format!("{name}_{axis}")).to_vec(),
        _ => (0..count).map(|index| format!("{name}_{index}")).collect(),
    }
}

/// Texts of which few are different, as indices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interner {
    labels: Labels,
    known: HashMap<Box<[u8]>, u16>,
    /// The last text, which is often the next one too.
    last: u16,
    is_given_up: bool,
}

impl Interner {
    #[inline]
    pub(crate) fn push(&mut self, text: &[u8]) -> Result<(), String> {
        if self.is_given_up {
            return Ok(());
        }
        let index = self.index(text)?;
        self.labels.index.push(index);
        Ok(())
    }

    #[inline]
    fn index(&mut self, text: &[u8]) -> Result<u16, String> {
        let last = self.labels.names.get(usize::from(self.last));
        if last.is_some_and(|last| last.as_bytes() == text) {
            return Ok(self.last);
        }
        if let Some(&known) = self.known.get(text) {
            self.last = known;
            return Ok(known);
        }
        self.add(text)
    }

    fn add(&mut self, text: &[u8]) -> Result<u16, String> {
        if text.len() > LONGEST_LABEL {
            return Err(format!("{} is longer than {LONGEST_LABEL} bytes; labels are short", quote(text)));
        }
        let index = u16::try_from(self.labels.names.len()).map_err(|_| {
            format!("{} is one label too many: a column may have {}", quote(text), Labels::MOST)
        })?;
        self.labels.names.push(String::from_utf8_lossy(text).into_owned());
        self.known.insert(text.into(), index);
        self.last = index;
        Ok(index)
    }

    /// Forgets the column, and what comes of it.
    fn give_up(&mut self) {
        *self = Self { is_given_up: true, ..Self::default() };
    }

    /// The index of the last text.
    pub(crate) fn last(&self) -> u16 {
        self.last
    }

    /// The index of each row.
    pub(crate) fn rows(&self) -> &[u16] {
        &self.labels.index
    }

    /// The index of a text that some row has.
    pub(crate) fn find(&self, text: &[u8]) -> Option<u16> {
        self.known.get(text).copied()
    }

    /// Appends the rows of another column.
    fn append(&mut self, other: &Self) -> Result<(), String> {
        let to: Vec<u16> =
            other.labels.names.iter().map(|name| self.index(name.as_bytes())).collect::<Result<_, _>>()?;
        self.labels.index.extend(other.labels.index.iter().map(|&index| to[usize::from(index)]));
        Ok(())
    }

    /// The column, if it has rows.
    pub(crate) fn finish(mut self) -> Option<Labels> {
        self.labels.index.shrink_to_fit();
        (!self.labels.index.is_empty()).then_some(self.labels)
    }
}

/// The columns of some rows. Those that no role fills stay empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) positions: Vec<[f64; 3]>,
    /// Atomic numbers, from readers that find them row by row.
    pub(crate) elements: Vec<u8>,
    pub(crate) labels: [Interner; KINDS],
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
        Self { properties: vec![Vec::new(); layout.properties.len()], ..Self::default() }
    }

    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn label(&mut self, kind: Kind) -> &mut Interner {
        &mut self.labels[kind as usize]
    }

    /// Takes a label of the row. Names that are too many or too long are nothing to tell particles apart by, and their
    /// column is given up; elements and types are needed.
    #[inline]
    pub(crate) fn push_label(&mut self, kind: Kind, text: &[u8]) -> Result<(), String> {
        let column = self.label(kind);
        match column.push(text) {
            Err(_) if !matches!(kind, Kind::Element | Kind::Type) => column.give_up(),
            result => return result,
        }
        Ok(())
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
        let labels = self.labels.iter().map(|column| column.labels.index.len());
        let properties = self.properties.iter().map(Vec::len);
        let all = lengths.into_iter().chain(labels).chain(properties);
        all.filter(|length| *length > 0).find(|length| *length != self.len())
    }

    /// Appends rows of the same layout.
    pub(crate) fn append(&mut self, other: &mut Self) -> Result<(), String> {
        for (at, other) in other.labels.iter().enumerate() {
            let column = &mut self.labels[at];
            let is_needed = at == Kind::Element as usize || at == Kind::Type as usize;
            if column.is_given_up || other.is_given_up {
                column.give_up();
            } else if let Err(problem) = column.append(other) {
                if is_needed {
                    return Err(problem);
                }
                column.give_up();
            }
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
        fn grow<T>(column: &mut Vec<T>, rows: usize) {
            if !column.is_empty() {
                column.reserve_exact(rows.saturating_sub(column.len()));
            }
        }
        grow(&mut self.positions, rows);
        grow(&mut self.elements, rows);
        grow(&mut self.radii, rows);
        grow(&mut self.colors, rows);
        grow(&mut self.ids, rows);
        grow(&mut self.molecules, rows);
        grow(&mut self.residue_numbers, rows);
        self.properties.iter_mut().for_each(|column| grow(column, rows));
        self.labels.iter_mut().for_each(|column| grow(&mut column.labels.index, rows));
    }

    /// Puts the rows in the order of their ids, if they have any. Rows with the same id keep their order.
    pub(crate) fn sort_by_id(&mut self) {
        if self.ids.is_sorted() {
            return;
        }
        let mut order: Vec<u32> = (0..self.ids.len() as u32).collect();
        order.sort_by_key(|&row| self.ids[row as usize]);
        let mut cycles = Cycles { order, is_done: vec![false; self.ids.len()] };
        cycles.permute(&mut self.positions);
        cycles.permute(&mut self.elements);
        cycles.permute(&mut self.radii);
        cycles.permute(&mut self.colors);
        cycles.permute(&mut self.ids);
        cycles.permute(&mut self.molecules);
        cycles.permute(&mut self.residue_numbers);
        self.properties.iter_mut().for_each(|column| cycles.permute(column));
        self.labels.iter_mut().for_each(|column| cycles.permute(&mut column.labels.index));
    }

    /// Keeps the rows that `keep` names.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        fn sift<T>(column: &mut Vec<T>, keep: &[bool]) {
            if !column.is_empty() {
                let mut rows = keep.iter();
                column.retain(|_| rows.next().copied().unwrap_or(false));
            }
        }
        sift(&mut self.positions, keep);
        sift(&mut self.elements, keep);
        sift(&mut self.radii, keep);
        sift(&mut self.colors, keep);
        sift(&mut self.ids, keep);
        sift(&mut self.molecules, keep);
        sift(&mut self.residue_numbers, keep);
        self.properties.iter_mut().for_each(|column| sift(column, keep));
        self.labels.iter_mut().for_each(|column| sift(&mut column.labels.index, keep));
    }

    /// Replaces the rows by those of these indices, which may repeat.
    pub(crate) fn gather(&mut self, rows: &[usize]) {
        fn pick<T: Copy>(column: &mut Vec<T>, rows: &[usize]) {
            if !column.is_empty() {
                *column = rows.iter().map(|&row| column[row]).collect();
            }
        }
        pick(&mut self.positions, rows);
        pick(&mut self.elements, rows);
        pick(&mut self.radii, rows);
        pick(&mut self.colors, rows);
        pick(&mut self.ids, rows);
        pick(&mut self.molecules, rows);
        pick(&mut self.residue_numbers, rows);
        self.properties.iter_mut().for_each(|column| pick(column, rows));
        self.labels.iter_mut().for_each(|column| pick(&mut column.labels.index, rows));
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
        let columns = self.properties.into_iter().map(shrunk);
        particles.properties = layout
            .properties
            .into_iter()
            .zip(columns)
            .map(|(name, values)| Property { name, values })
            .collect();
        particles.available = layout.available;
        particles.positions = shrunk(self.positions);
    }
}

/// A permutation of rows, applied in place: columns of ten million rows are not held twice.
struct Cycles {
    /// For each row, which one comes there.
    order: Vec<u32>,
    is_done: Vec<bool>,
}

impl Cycles {
    fn permute<T: Copy>(&mut self, column: &mut [T]) {
        if column.is_empty() {
            return;
        }
        self.is_done.fill(false);
        for start in 0..self.order.len() {
            if self.is_done[start] {
                continue;
            }
            let (first, mut row) = (column[start], start);
            loop {
                self.is_done[row] = true;
                let next = self.order[row] as usize;
                if next == start {
                    break;
                }
                column[row] = column[next];
                row = next;
            }
            column[row] = first;
        }
    }
}

fn shrunk<T>(mut column: Vec<T>) -> Vec<T> {
    column.shrink_to_fit();
    column
}

/// The column, if it has rows.
fn filled<T>(column: Vec<T>) -> Option<Vec<T>> {
    (!column.is_empty()).then(|| shrunk(column))
}

/// The atomic numbers of a column of labels, unless none is known.
pub(crate) fn elements_of(labels: &Labels, of: impl Fn(&str) -> u8) -> Option<Vec<u8>> {
    let numbers: Vec<u8> = labels.names.iter().map(|name| of(name)).collect();
    let is_known = numbers.iter().any(|&number| number > 0);
    is_known.then(|| labels.index.iter().map(|&index| numbers[usize::from(index)]).collect())
}

/// The atomic number of a symbol or of an atomic number; 0 if it is neither.
pub(crate) fn element_of(text: &str) -> u8 {
    let by_number = || text.parse().ok().filter(|&number| elements::element(number).is_some());
    elements::by_symbol(text).or_else(by_number).unwrap_or(0)
}

/// A number that may be missing or a truth value.
#[inline]
fn property(field: &[u8]) -> Result<f32, String> {
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

    #[test]
    fn labels_of_pieces_are_joined() {
        let (mut a, mut b) = (Interner::default(), Interner::default());
        for (interner, text) in [(&mut a, "x y"), (&mut b, "z y z")] {
            text.split(' ').for_each(|label| interner.push(label.as_bytes()).unwrap());
        }
        a.append(&b).unwrap();
        let labels = a.finish().unwrap();
        assert_eq!(
            (labels.names, labels.index),
            (["x", "y", "z"].map(str::to_owned).to_vec(), vec![0, 1, 2, 1, 2])
        );
    }

    #[test]
    fn labels_have_bounds() {
        let mut interner = Interner::default();
        assert!(interner.push(&[b'a'; LONGEST_LABEL + 1]).is_err());
        for label in 0..Labels::MOST {
            interner.push(label.to_string().as_bytes()).unwrap();
        }
        assert!(interner.push(b"one").is_err());
        assert!(interner.push(b"0").is_ok());
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

    #[test]
    fn wanted_names_are_those_of_columns_or_of_all_their_components() {
        let named = |name: &str| Properties::Named(vec![name.into()]);
        assert!(is_wanted("forces_x", &named("forces")) && is_wanted("forces_x", &named("forces_x")));
        assert!(!is_wanted("forces_x", &named("forces_y")) && !is_wanted("q", &Properties::None));
        assert!(is_wanted("q", &Properties::All) && is_wanted("q", &named("q")));
    }
}
