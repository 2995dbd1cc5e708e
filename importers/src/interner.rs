//! Columns of texts, as indices.

use crate::error::quote;
use crate::particles::Labels;
use std::collections::HashMap;

/// The most bytes of a label.
const LONGEST_LABEL: usize = 100;

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
    pub(crate) fn give_up(&mut self) {
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

    /// The index of each row, to be changed; all of them stand for texts of the column.
    pub(crate) fn rows_mut(&mut self) -> &mut Vec<u16> {
        &mut self.labels.index
    }

    /// The index of a text that some row has.
    pub(crate) fn find(&self, text: &[u8]) -> Option<u16> {
        self.known.get(text).copied()
    }

    /// Appends the rows of another column. A column that one of the two has given up is given up.
    pub(crate) fn append(&mut self, other: &Self) -> Result<(), String> {
        if self.is_given_up || other.is_given_up {
            self.give_up();
            return Ok(());
        }
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
