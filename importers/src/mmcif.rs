//! PDBx/mmCIF, with Cartesian coordinates, and CIF of small molecules and crystals, with coordinates along the vectors
//! of the cell, which are repeated by the symmetry operations that the file lists.

use crate::altloc::{self, Alternative, Disordered, Residue, packed};
use crate::cell::by_angles;
use crate::elements::element_of;
use crate::error::{Fault, no_such_frame, quote};
use crate::format::Format;
use crate::layout::{Kind, Layout, Role};
use crate::names;
use crate::particles::{Cell, Particles, title};
use crate::request::Request;
use crate::rows::{most_rows, too_many};
use crate::star::{Token, Tokens};
use crate::symmetry::{Operation, images};
use crate::table::Table;
use crate::text::{Position, Source, Text, integer, number};
use std::collections::HashMap;
use std::mem::take;

/// The most symmetry operations: a cubic cell with all of its centring has 192.
const MOST_OPERATIONS: usize = 1024;

/// What of an atom is read. Several items may stand for the same; the first in [`ITEMS`] is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Item {
    Id,
    Symbol,
    Name,
    Mark,
    Residue,
    Chain,
    Number,
    Insertion,
    X,
    Y,
    Z,
    Occupancy,
    BFactor,
    Model,
    Assembly,
    Group,
}

const ITEM_COUNT: usize = Item::Group as usize + 1;

/// The names of items after `_atom_site.` or `_atom_site_`. Authors' numbers are those of PDB files.
const ITEMS: [(&str, Item); 24] = [
    ("id", Item::Id),
    ("type_symbol", Item::Symbol),
    ("label_atom_id", Item::Name),
    ("auth_atom_id", Item::Name),
    ("label", Item::Name),
    ("label_alt_id", Item::Mark),
    ("auth_comp_id", Item::Residue),
    ("label_comp_id", Item::Residue),
    ("auth_asym_id", Item::Chain),
    ("label_asym_id", Item::Chain),
    ("auth_seq_id", Item::Number),
    ("label_seq_id", Item::Number),
    ("pdbx_pdb_ins_code", Item::Insertion),
    ("cartn_x", Item::X),
    ("cartn_y", Item::Y),
    ("cartn_z", Item::Z),
    ("occupancy", Item::Occupancy),
    ("b_iso_or_equiv", Item::BFactor),
    ("pdbx_pdb_model_num", Item::Model),
    ("fract_x", Item::X),
    ("fract_y", Item::Y),
    ("fract_z", Item::Z),
    ("disorder_assembly", Item::Assembly),
    ("disorder_group", Item::Group),
];

/// The number of models.
pub(crate) fn frames(source: &mut dyn Source) -> Result<usize, Fault> {
    let request = Request::default();
    let reader = parse(source, None, &request)?;
    Ok(reader.models)
}

/// Reads a model.
pub(crate) fn read(source: &mut dyn Source, frame: usize, request: &Request) -> Result<Particles, Fault> {
    let reader = parse(source, Some(frame), request)?;
    match reader.models {
        0 => Err(Fault::file("has no atoms: there is no loop of _atom_site")),
        models if models <= frame => Err(no_such_frame(frame, models)),
        _ => reader.finish(request),
    }
}

/// Reads the first block that has atoms; those of the model `wanted` are kept.
fn parse(source: &mut dyn Source, wanted: Option<usize>, request: &Request) -> Result<Reader, Fault> {
    let mut text = Text::new(source, Position::START)?;
    let mut tokens = Tokens::new(&mut text);
    let mut reader = Reader::new(wanted, request);
    while let Some(token) = tokens.next_token()? {
        match token {
            Token::Block => {
                reader.end_single_atom()?;
                if reader.models > 0 {
                    break;
                }
                reader = Reader::new(wanted, request);
            }
            Token::Loop => reader.loop_of(&mut tokens)?,
            Token::Name(name) => {
                if tokens.peek()? == Some(&Token::Value) {
                    tokens.next_token()?;
                    reader.single(&name, &tokens)?;
                } else {
                    return Err(tokens.fault(format!("{} has no value", quote(name.as_bytes()))));
                }
            }
            Token::Value => {
                let problem =
                    format!("{} belongs to no name; is a quotation mark missing?", quote(tokens.value()));
                return Err(tokens.fault(problem));
            }
            Token::Other => {}
        }
    }
    reader.end_single_atom()?;
    reader.end_single_bond();
    Ok(reader)
}

/// A bond of `_struct_conn`: both ends.
type Link = [End; 2];

/// An atom by its chain, residue number, insertion code and name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct End {
    chain: Vec<u8>,
    number: i32,
    name: Vec<u8>,
}

/// A row of `_struct_conn` that is being read.
struct LinkRow {
    /// The columns of the kind of the bond; per end, of its image, chain, number and name.
    kind: Option<usize>,
    images: [Option<usize>; 2],
    ends: [[Option<usize>; 3]; 2],
    is_bond: bool,
    image: [Vec<u8>; 2],
    link: Link,
}

impl LinkRow {
    fn new(names: &[String]) -> Self {
        let item =
            |name: &str| names.iter().position(|other| other.strip_prefix("_struct_conn.") == Some(name));
        Self {
            kind: item("conn_type_id"),
            images: ["ptnr1_symmetry", "ptnr2_symmetry"].map(item),
            ends: [1, 2].map(|end| {
                ["auth_asym_id", "auth_seq_id", "label_atom_id"]
                    .map(|name| item(&format!("ptnr{end}_{name}")))
            }),
            is_bond: true,
            image: Default::default(),
            link: Link::default(),
        }
    }

    fn take(&mut self, column: usize, value: &[u8]) {
        let column = Some(column);
        if column == self.kind {
            self.is_bond = !value.starts_with(b"hydrog");
        }
        for (end, [chain, number, name]) in self.ends.into_iter().enumerate() {
            let at = &mut self.link[end];
            if column == chain {
                at.chain = value.to_vec();
            } else if column == number {
                at.number = integer(value).and_then(|number| i32::try_from(number).ok()).unwrap_or(0);
            } else if column == name {
                at.name = value.to_vec();
            } else if column == self.images[end] {
                self.image[end] = value.to_vec();
            }
        }
    }

    /// The bond of the row, unless it is one of hydrogen or leads to another image of the crystal.
    fn bond(&self) -> Option<Link> {
        (self.is_bond && self.image[0] == self.image[1]).then(|| self.link.clone())
    }
}

struct Reader {
    wanted: Option<usize>,
    layout: Layout,
    table: Table,
    others: [Role; 2],
    most: u64,
    alternatives: Vec<Alternative>,
    disordered: Vec<Disordered>,
    models: usize,
    model: Vec<u8>,
    is_fractional: bool,
    lengths: [f64; 3],
    angles: [f64; 3],
    operations: Vec<Operation>,
    space_group: String,
    links: Vec<Link>,
    title: String,
    /// The fields of an atom that is not in a loop.
    single: Vec<(String, Vec<u8>)>,
    /// Those of a bond that is not in a loop.
    single_bond: Vec<(String, Vec<u8>)>,
    /// The fields of the row that is being read.
    fields: [Vec<u8>; ITEM_COUNT],
}

impl Reader {
    fn new(wanted: Option<usize>, request: &Request) -> Self {
        let (layout, others) = Layout::of_atoms(&request.properties);
        Self {
            wanted,
            table: Table::new(&layout),
            most: most_rows(&layout, request),
            layout,
            others,
            alternatives: Vec::new(),
            disordered: Vec::new(),
            models: 0,
            model: Vec::new(),
            is_fractional: false,
            lengths: [0.0; 3],
            angles: [90.0; 3],
            operations: Vec::new(),
            space_group: String::new(),
            links: Vec::new(),
            title: String::new(),
            single: Vec::new(),
            single_bond: Vec::new(),
            fields: Default::default(),
        }
    }

    fn loop_of(&mut self, tokens: &mut Tokens) -> Result<(), Fault> {
        let mut names = Vec::new();
        while let Some(Token::Name(name)) = tokens.peek()? {
            names.push(name.clone());
            tokens.next_token()?;
        }
        if names.is_empty() {
            return Err(tokens.fault("a loop_ without names"));
        }
        let begins = |with: &str| names[0].starts_with(with) && !names[0].starts_with("_atom_site_aniso");
        if begins("_atom_site.") || begins("_atom_site_") {
            self.atoms(&names, tokens)
        } else if begins("_struct_conn.") {
            self.bonds(&names, tokens)
        } else {
            let operations = names.iter().position(|name| is_operation(name));
            rows(
                &names,
                tokens,
                |column, tokens| {
                    if operations == Some(column) { self.operation(tokens) } else { Ok(()) }
                },
            )
        }
    }

    fn operation(&mut self, tokens: &Tokens) -> Result<(), Fault> {
        let text = String::from_utf8_lossy(tokens.value());
        let operation = Operation::parse(&text).filter(|_| self.operations.len() < MOST_OPERATIONS);
        let problem = || format!("{} is no symmetry operation, such as -x,y+1/2,z", quote(text.as_bytes()));
        self.operations.push(operation.ok_or_else(|| tokens.fault(problem()))?);
        Ok(())
    }

    /// A name with one value.
    fn single(&mut self, name: &str, tokens: &Tokens) -> Result<(), Fault> {
        let value = tokens.value();
        let cell = name.strip_prefix("_cell.").or_else(|| name.strip_prefix("_cell_"));
        if let Some(item) = cell {
            let items = ["length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"];
            if let Some(at) = items.iter().position(|known| *known == item)
                && !tokens.is_null()
            {
                let problem = || format!("{} is no length or angle of a cell", quote(value));
                let value = number(without_error(value)).filter(|v| v.is_finite());
                let value = value.ok_or_else(|| tokens.fault(problem()))?;
                if at < 3 { self.lengths[at] = value } else { self.angles[at - 3] = value }
            }
        } else if is_operation(name) {
            self.operation(tokens)?;
        } else if name.starts_with("_atom_site.") {
            self.single.push((name.to_owned(), if tokens.is_null() { Vec::new() } else { value.to_vec() }));
        } else if name.starts_with("_struct_conn.") {
            self.single_bond.push((name.to_owned(), value.to_vec()));
        } else if name == "_struct.title" {
            self.title = title(&String::from_utf8_lossy(value));
        } else if ["_symmetry_space_group_name_h-m", "_space_group_name_h-m_alt"].contains(&name) {
            self.space_group = String::from_utf8_lossy(value).into_owned();
        }
        Ok(())
    }

    /// The rows of `_atom_site`.
    fn atoms(&mut self, names: &[String], tokens: &mut Tokens) -> Result<(), Fault> {
        let items = items(names);
        if !have_place(&items) {
            // Some files list what is known of each atom before its place.
            return rows(names, tokens, |_, _| Ok(()));
        }
        self.is_fractional = !names.iter().any(|name| name.ends_with("cartn_x"));
        let last = names.len() - 1;
        rows(names, tokens, |column, tokens| {
            if let Some(item) = items[column] {
                let field = &mut self.fields[item as usize];
                field.clear();
                if !tokens.is_null() {
                    field.extend_from_slice(tokens.value());
                }
            }
            if column == last { self.atom().map_err(|problem| tokens.fault(problem)) } else { Ok(()) }
        })
    }

    /// An atom whose items stand alone.
    fn end_single_atom(&mut self) -> Result<(), Fault> {
        let single = take(&mut self.single);
        let names: Vec<String> = single.iter().map(|(name, _)| name.clone()).collect();
        let items = items(&names);
        if self.models > 0 || !have_place(&items) {
            return Ok(());
        }
        self.is_fractional = !names.iter().any(|name| name.ends_with("cartn_x"));
        for (item, (_, value)) in items.into_iter().zip(single) {
            if let Some(item) = item {
                self.fields[item as usize] = value;
            }
        }
        self.atom().map_err(Fault::file)
    }

    /// Takes the atom whose fields are there.
    fn atom(&mut self) -> Result<(), String> {
        if self.models == 0 || self.fields[Item::Model as usize] != self.model {
            self.models += 1;
            self.model.clone_from(&self.fields[Item::Model as usize]);
        }
        if self.wanted.is_none_or(|wanted| wanted + 1 != self.models) {
            return Ok(());
        }
        let field = |item: Item| self.fields[item as usize].as_slice();
        for (axis, item) in [Item::X, Item::Y, Item::Z].into_iter().enumerate() {
            let value = if self.is_fractional { without_error(field(item)) } else { field(item) };
            self.table.field(Role::Axis(axis), value)?;
        }
        let (name, residue) = (field(Item::Name), field(Item::Residue));
        self.table.elements.push(element(field(Item::Symbol), name, residue, self.is_fractional));
        for (kind, text) in [(Kind::Name, name), (Kind::Residue, residue), (Kind::Chain, field(Item::Chain))]
        {
            self.table.push_label(kind, text)?;
        }
        let whole = |item: Item| integer(field(item));
        let residue_number = whole(Item::Number).and_then(|number| i32::try_from(number).ok()).unwrap_or(0);
        self.table.residue_numbers.push(residue_number);
        let last = self.table.ids.last().copied().unwrap_or(0);
        let id = whole(Item::Id).and_then(|id| u64::try_from(id).ok()).unwrap_or(last.saturating_add(1));
        self.table.ids.push(id);
        let [occupancy, b_factor] =
            [Item::Occupancy, Item::BFactor].map(|item| number(without_error(field(item))));
        for (role, value) in self.others.into_iter().zip([occupancy, b_factor]) {
            self.table.number(role, value.unwrap_or(f64::NAN))?;
        }
        if !field(Item::Mark).is_empty() {
            let index = |kind: Kind| self.table.labels[kind as usize].last();
            let residue = Residue {
                chain: index(Kind::Chain),
                number: residue_number,
                insertion: packed(field(Item::Insertion)),
            };
            self.alternatives.push(Alternative {
                row: self.table.len() as u32,
                residue,
                residue_name: index(Kind::Residue),
                name: index(Kind::Name),
                mark: packed(field(Item::Mark)),
                occupancy: occupancy.unwrap_or(1.0) as f32,
                b_factor: b_factor.unwrap_or(0.0) as f32,
            });
        }
        if !field(Item::Group).is_empty() {
            self.disordered.push(Disordered {
                row: self.table.len() as u32,
                assembly: packed(field(Item::Assembly)),
                group: packed(field(Item::Group)),
                occupancy: occupancy.unwrap_or(1.0) as f32,
            });
        }
        self.table.end_row(true, false);
        if self.table.len() as u64 > self.most {
            return Err(format!(
                "there are more than the {} atoms that fit into memory; allow more",
                self.most
            ));
        }
        Ok(())
    }

    /// The rows of `_struct_conn`.
    fn bonds(&mut self, names: &[String], tokens: &mut Tokens) -> Result<(), Fault> {
        let mut row = LinkRow::new(names);
        let last = names.len() - 1;
        rows(names, tokens, |column, tokens| {
            row.take(column, tokens.value());
            if column == last {
                self.links.extend(row.bond());
            }
            Ok(())
        })
    }

    /// A bond whose items stand alone, as the only one of a structure does.
    fn end_single_bond(&mut self) {
        let single = take(&mut self.single_bond);
        if single.is_empty() {
            return;
        }
        let names: Vec<String> = single.iter().map(|(name, _)| name.clone()).collect();
        let mut row = LinkRow::new(&names);
        for (column, (_, value)) in single.iter().enumerate() {
            row.take(column, value);
        }
        self.links.extend(row.bond());
    }

    fn finish(mut self, request: &Request) -> Result<Particles, Fault> {
        let (alternatives, disordered) = (take(&mut self.alternatives), take(&mut self.disordered));
        if let Some(keep) = altloc::kept(alternatives, disordered, self.table.len()) {
            self.table.retain(&keep);
        }
        let mut particles = Particles::new(Format::Mmcif);
        particles.title = take(&mut self.title);
        // The unit cube of structures that are no crystals stands for none.
        if self.lengths != [1.0; 3] {
            particles.cell = by_angles(self.lengths, self.angles);
        }
        if self.is_fractional {
            self.expand(particles.cell, request)?;
        } else {
            particles.bonds = self.bonds_of_rows();
        }
        self.table.finish(self.layout, None, &mut particles);
        Ok(particles)
    }

    /// Repeats the atoms by the symmetry operations, and places them by the cell.
    fn expand(&mut self, cell: Option<Cell>, request: &Request) -> Result<(), Fault> {
        let cell = cell.ok_or_else(|| {
            Fault::file(
                "has coordinates along the vectors of a cell, but _cell_length_a and the others give no cell",
            )
        })?;
        if self.operations.is_empty() && !["", "P1"].contains(&&*self.space_group.replace(' ', "")) {
            return Err(Fault::file(format!(
                "has space group {} but lists no _space_group_symop_operation_xyz; expand it to P 1 first",
                quote(self.space_group.as_bytes())
            )));
        }
        if !self.operations.iter().all(Operation::is_identity) {
            let (mut rows, mut positions) = (Vec::new(), Vec::new());
            for (row, position) in self.table.positions.iter().enumerate() {
                let images = images(&self.operations, *position);
                rows.extend(std::iter::repeat_n(row, images.len()));
                positions.extend(images);
                if positions.len() as u64 > self.most {
                    return Err(too_many(&self.layout, request));
                }
            }
            self.table.gather(&rows);
            self.table.positions = positions;
        }
        for position in &mut self.table.positions {
            *position = cell.point(*position);
        }
        Ok(())
    }

    fn bonds_of_rows(&self) -> Vec<[u32; 2]> {
        if self.links.is_empty() {
            return Vec::new();
        }
        let label = |kind: Kind, text: &[u8]| self.table.labels[kind as usize].find(text);
        let key =
            |end: &End| Some((label(Kind::Chain, &end.chain)?, end.number, label(Kind::Name, &end.name)?));
        let mut rows: HashMap<(u16, i32, u16), u32> =
            self.links.iter().flatten().filter_map(key).map(|key| (key, u32::MAX)).collect();
        let chains = self.table.labels[Kind::Chain as usize].rows();
        let names = self.table.labels[Kind::Name as usize].rows();
        for (row, ((&chain, &number), &name)) in
            chains.iter().zip(&self.table.residue_numbers).zip(names).enumerate()
        {
            if let Some(found) = rows.get_mut(&(chain, number, name)) {
                *found = (*found).min(row as u32);
            }
        }
        let row = |end: &End| key(end).and_then(|key| rows.get(&key)).copied().filter(|&row| row < u32::MAX);
        let pairs = self.links.iter().filter_map(|[a, b]| Some([row(a)?, row(b)?]));
        let mut bonds: Vec<_> = pairs.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        bonds.sort_unstable();
        bonds.dedup();
        bonds
    }
}

/// Calls `take` with each value of a loop and its column.
fn rows(
    names: &[String],
    tokens: &mut Tokens,
    mut take: impl FnMut(usize, &Tokens) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut column = 0;
    while tokens.peek()? == Some(&Token::Value) {
        tokens.next_token()?;
        take(column, tokens)?;
        column = (column + 1) % names.len();
    }
    if column > 0 {
        let problem = format!(
            "a row of the loop has {column} of {} values; the next is {}",
            names.len(),
            names[column]
        );
        return Err(tokens.fault(problem));
    }
    Ok(())
}

/// The item of each column, each item once.
fn items(names: &[String]) -> Vec<Option<Item>> {
    fn item(name: &str) -> &str {
        name.strip_prefix("_atom_site.").or_else(|| name.strip_prefix("_atom_site_")).unwrap_or("")
    }
    let rank = |name: &String| ITEMS.iter().position(|(known, _)| *known == item(name));
    let ranks: Vec<Option<usize>> = names.iter().map(rank).collect();
    let best = |wanted: Item| ranks.iter().flatten().copied().filter(|&rank| ITEMS[rank].1 == wanted).min();
    ranks
        .iter()
        .map(|rank| {
            rank.map(|rank| (rank, ITEMS[rank].1))
                .filter(|(rank, item)| best(*item) == Some(*rank))
                .map(|(_, item)| item)
        })
        .collect()
}

/// Whether these are items of atoms that have a place.
fn have_place(items: &[Option<Item>]) -> bool {
    [Item::X, Item::Y, Item::Z].into_iter().all(|item| items.contains(&Some(item)))
}

fn is_operation(name: &str) -> bool {
    ["_symmetry_equiv_pos_as_xyz", "_space_group_symop_operation_xyz", "_space_group_symop.operation_xyz"]
        .contains(&name)
}

/// A number without its standard error: `1.234(5)`.
fn without_error(value: &[u8]) -> &[u8] {
    value.split(|byte| *byte == b'(').next().unwrap_or(value)
}

/// The element by its symbol, which may have a charge (`Fe3+`), or by the name of the atom.
fn element(symbol: &[u8], name: &[u8], residue: &[u8], is_fractional: bool) -> u8 {
    let letters = |text: &[u8]| {
        let end = text.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(text.len());
        element_of(std::str::from_utf8(&text[..end]).unwrap_or_default())
    };
    match letters(symbol) {
        0 if is_fractional => letters(name),
        0 => names::element(name, residue),
        number => number,
    }
}
