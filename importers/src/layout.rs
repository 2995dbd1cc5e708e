//! What the fields of a row are.

use crate::request::Properties;

/// The most columns of a file.
pub(crate) const MOST_COLUMNS: usize = 1024;
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

impl Kind {
    pub(crate) const ALL: [Self; 5] = [Self::Element, Self::Type, Self::Name, Self::Residue, Self::Chain];

    /// Whether particles cannot do without the column. Names that are too many or too long are nothing to tell particles apart
    /// by, and are left out.
    pub(crate) fn is_needed(self) -> bool {
        matches!(self, Self::Element | Self::Type)
    }
}

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

    /// The names of the properties that are read.
    pub(crate) fn properties(&self) -> &[String] {
        &self.properties
    }

    /// Whether there is a field of this role. Radius and diameter are the same: a particle has one of them.
    pub(crate) fn has(&self, role: Role) -> bool {
        let plain = |role: Role| if role == Role::Diameter { Role::Radius } else { role };
        self.roles.iter().any(|other| plain(*other) == plain(role))
    }

    /// Bytes per row of a [`crate::table::Table`] and of what becomes of it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wanted_names_are_those_of_columns_or_of_all_their_components() {
        let named = |name: &str| Properties::Named(vec![name.into()]);
        assert!(is_wanted("forces_x", &named("forces")) && is_wanted("forces_x", &named("forces_x")));
        assert!(!is_wanted("forces_x", &named("forces_y")) && !is_wanted("q", &Properties::None));
        assert!(is_wanted("q", &Properties::All) && is_wanted("q", &named("q")));
    }
}
