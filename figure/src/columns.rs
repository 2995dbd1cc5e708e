//! Columns of particles by name, for selections and styles.

/// What a column has for each particle.
pub enum Column<'a> {
    /// A number by the particle's index.
    Number(Box<dyn Fn(usize) -> f64 + Sync + 'a>),
    /// One of some texts.
    Text {
        /// The index of the text by that of the particle.
        index: Box<dyn Fn(usize) -> u32 + Sync + 'a>,
        /// The texts; a particle whose index is beyond them has none.
        names: Vec<String>,
    },
}

/// Something with columns.
pub trait Columns {
    /// The names of all columns, for messages.
    fn names(&self) -> Vec<String>;

    /// The column called `name`.
    fn column(&self, name: &str) -> Option<Column<'_>>;
}

/// The message that there is no column `name`: what is near, and what there is.
pub fn unknown(columns: &dyn Columns, name: &str) -> String {
    let names = columns.names();
    let near = names
        .iter()
        .map(|known| (strsim::damerau_levenshtein(name, known), known))
        .filter(|(distance, known)| *distance <= known.len() / 2)
        .min_by_key(|(distance, _)| *distance)
        .map_or(String::new(), |(_, known)| format!(" (did you mean {known}?)"));
    format!("there is no column `{name}`{near}; the file has {}", names.join(", "))
}
