//! Selections: small expressions that say which particles a style is for, such as `element == "O" and z > 3`.
//!
//! ```text
//! any    = all { "or" all }
//! all    = one { "and" one }
//! one    = "not" one | "(" any ")" | test
//! test   = value ( "==" | "!=" | "<" | "<=" | ">" | ">=" ) value | value [ "not" ] "in" "(" value { "," value } ")"
//! value  = number | "text" | 'text' | column
//! ```
//!
//! A [`Selection`] is parsed without knowing any file. [`Selection::bind`] finds its columns, and gives a [`Test`].

mod error;
mod lexer;
mod parser;
mod test;

pub use error::SelectionError;
pub use test::Test;

use crate::columns::Columns;
use parser::Node;
use std::fmt;

/// A parsed selection.
#[derive(Clone, Debug)]
pub struct Selection {
    text: String,
    root: Node,
}

impl Selection {
    /// Parses `text`.
    ///
    /// # Errors
    /// At the first token that does not fit.
    pub fn parse(text: &str) -> Result<Self, SelectionError> {
        Ok(Self { text: text.into(), root: parser::parse(text)? })
    }

    /// The text that it was parsed from.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The test of particles with these `columns`.
    ///
    /// # Errors
    /// If a column does not exist, or is compared with what it cannot be.
    pub fn bind<'a>(&self, columns: &'a dyn Columns) -> Result<Test<'a>, SelectionError> {
        test::bind(&self.text, &self.root, columns)
    }

    /// The columns that it names.
    pub fn columns(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.root.columns(&mut names);
        names
    }
}

impl PartialEq for Selection {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::Column;

    /// Four particles: an element, a height, and a property with a gap.
    struct Few;

    impl Columns for Few {
        fn names(&self) -> Vec<String> {
            ["element", "type", "z", "c_pe[1]"].map(Into::into).to_vec()
        }

        fn column(&self, name: &str) -> Option<Column<'_>> {
            let names = |all: &[&str]| all.iter().map(ToString::to_string).collect();
            match name {
                "element" => {
                    let index = Box::new(|i: usize| [0, 1, 1, 2][i]);
                    Some(Column::Text { index, names: names(&["O", "H", ""]) })
                }
                "type" => Some(Column::Text {
                    index: Box::new(|i: usize| [0, 0, 1, 1][i]),
                    names: names(&["1", "2"]),
                }),
                "z" => Some(Column::Number(Box::new(|i: usize| [1.0, 2.0, 3.0, -4.5][i]))),
                "c_pe[1]" => Some(Column::Number(Box::new(|i: usize| [0.5, f64::NAN, 1e-3, -2e3][i]))),
                _ => None,
            }
        }
    }

    fn selected(text: &str) -> Result<Vec<usize>, String> {
        let selection = Selection::parse(text).map_err(|error| error.to_string())?;
        let test = selection.bind(&Few).map_err(|error| error.to_string())?;
        Ok((0..4).filter(|&i| test.holds(i)).collect())
    }

    #[test]
    fn particles_are_selected() {
        let rows: [(&str, &[usize]); 22] = [
            ("element == \"O\"", &[0]),
            ("element != 'O'", &[1, 2, 3]),
            ("z > 1", &[1, 2]),
            ("1 < z", &[1, 2]),
            ("z >= 2 and z <= 3", &[1, 2]),
            ("z == -4.5", &[3]),
            ("element == \"O\" or element == \"H\" and z > 2", &[0, 2]),
            ("(element == \"O\" or element == \"H\") and z > 2", &[2]),
            ("not z > 1", &[0, 3]),
            ("not not z > 1", &[1, 2]),
            // `not` binds the condition after it alone.
            ("not z > 1 and element == 'O'", &[0]),
            ("not z > 2 and type == 2", &[3]),
            ("not element == 'H' or z > 2", &[0, 2, 3]),
            ("not (z > 1 or element == 'O')", &[3]),
            ("element in (\"O\", \"H\")", &[0, 1, 2]),
            ("element not in ('H', 'He')", &[0, 3]),
            ("z in (1, 3, 7)", &[0, 2]),
            ("type == 2", &[2, 3]),
            ("type in (1)", &[0, 1]),
            ("c_pe[1] < 1e-2", &[2, 3]),
            // NaN is not equal to anything, and neither above nor below.
            ("c_pe[1] == c_pe[1]", &[0, 2, 3]),
            ("\"O\" == element", &[0]),
        ];
        for (text, expected) in rows {
            assert_eq!(selected(text).as_deref(), Ok(expected), "{text}");
        }
    }

    /// Two columns of texts, each with a list of its own, in which the same texts have other places.
    struct Texts;

    const NAMES: [&str; 7] = ["NA", "CL", "O", "NA", "", "CL", "H"];
    const RESIDUES: [&str; 7] = ["NA", "SOL", "O", "CL", "", "CL", "SOL"];

    impl Columns for Texts {
        fn names(&self) -> Vec<String> {
            ["name", "residue"].map(Into::into).to_vec()
        }

        fn column(&self, name: &str) -> Option<Column<'_>> {
            let (texts, list) = match name {
                "name" => (NAMES, vec!["CL", "H", "NA", "O", ""]),
                "residue" => (RESIDUES, vec!["SOL", "", "CL", "unused", "O", "NA"]),
                _ => return None,
            };
            let names = list.iter().map(ToString::to_string).collect();
            let place = move |i: usize| list.iter().position(|text| *text == texts[i]).unwrap() as u32;
            Some(Column::Text { index: Box::new(place), names })
        }
    }

    #[test]
    fn columns_of_texts_are_compared_by_their_texts() {
        for (text, wanted) in [
            ("name == residue", true),
            ("residue == name", true),
            ("name != residue", false),
            ("not residue != name", true),
        ] {
            let selection = Selection::parse(text).unwrap();
            let test = selection.bind(&Texts).unwrap();
            for i in 0..NAMES.len() {
                let is_same = NAMES[i] == RESIDUES[i];
                assert_eq!(test.holds(i), is_same == wanted, "{text}: {} and {}", NAMES[i], RESIDUES[i]);
            }
        }
    }

    #[test]
    fn faults_are_told_with_their_column() {
        for (text, expected) in [
            ("", "column 1: this ends where a column, a number or a text is needed"),
            ("z >", "column 4: this ends where a column"),
            ("z = 3", "column 3: `=` is no comparison; write `==`"),
            ("z > 3 und x < 2", "column 7: `und` does not fit here; join conditions by `and` or `or`"),
            ("0 < z < 3", "column 7: one comparison at a time; write `0 < z and z < 3`"),
            ("z", "column 2: a comparison is missing"),
            ("(z > 3", "column 7: this ends where `)` is needed"),
            ("z > 3)", "column 6: `)` does not fit here"),
            ("element == \"O", "column 12: this text has no end; close it with \""),
            ("elemnt == \"O\"", "column 1: there is no column `elemnt` (did you mean element?)"),
            ("z == \"O\"", "column 1: `z` is a number, and is compared with a text"),
            ("element > \"O\"", "column 1: `element` is a text, which is neither above nor below another"),
            ("z in 3", "column 6: `3` does not fit here; write a list, as in `type in (1, 2)`"),
            ("z in ()", "column 7: `)` does not fit here; a column, a number or a text is needed"),
            ("z in (x)", "column 7: a list holds numbers and texts alone"),
            ("é == 1", "column 1: `é` does not belong in a selection"),
            (
                "z > 3 & x < 2",
                "column 7: `&` does not belong in a selection; join conditions by `and` or `or`",
            ),
            ("z > 1.2.3", "column 5: `1.2.3` is no number"),
            ("not", "column 4: this ends where"),
            ("3 > 2", "column 1: this names no column"),
        ] {
            let error = selected(text).unwrap_err();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }

    #[test]
    fn deep_nesting_is_refused() {
        let text = format!("{}z > 1{}", "(".repeat(10_000), ")".repeat(10_000));
        assert!(selected(&text).unwrap_err().contains("nested deeper than"));
        let text = format!("{} z > 1", "not ".repeat(10_000));
        assert!(selected(&text).unwrap_err().contains("nested deeper than"));
        let nested = |depth: usize| selected(&format!("{}z > 1{}", "(".repeat(depth), ")".repeat(depth)));
        assert_eq!(nested(100), Ok(vec![1, 2]));
        assert!(nested(101).unwrap_err().contains("nested deeper than 100"));
        // However many stand beside each other.
        assert_eq!(selected(&format!("{}z > 2", "(z > 1) and not (z > 9) and ".repeat(200))), Ok(vec![2]));
    }
}
