//! A selection bound to the columns of a file.

use super::error::SelectionError;
use super::parser::{Comparison, Kind, Node, Value};
use crate::columns::{Column, Columns, unknown};

/// A test of particles by their index.
pub struct Test<'a>(Box<dyn Fn(usize) -> bool + Sync + 'a>);

impl Test<'_> {
    /// Whether particle `i` is selected.
    pub fn holds(&self, i: usize) -> bool {
        (self.0)(i)
    }
}

/// The test of a selection with this `text`, parsed to `root`, of particles with these `columns`.
///
/// # Errors
/// If a column does not exist, or is compared with what it cannot be.
pub(super) fn bind<'a>(
    text: &str,
    root: &Node,
    columns: &'a dyn Columns,
) -> Result<Test<'a>, SelectionError> {
    Binder { text, columns }.node(root)
}

/// One side of a comparison.
enum Side<'a> {
    Number(f64, String),
    Text(String),
    Column(String, Column<'a>),
}

struct Binder<'t, 'a> {
    text: &'t str,
    columns: &'a dyn Columns,
}

impl<'a> Binder<'_, 'a> {
    fn error(&self, at: usize, problem: impl Into<String>) -> SelectionError {
        SelectionError::new(self.text, at, problem)
    }

    fn node(&self, node: &Node) -> Result<Test<'a>, SelectionError> {
        let all = |nodes: &[Node]| nodes.iter().map(|node| self.node(node)).collect::<Result<Vec<_>, _>>();
        Ok(match node {
            Node::Or(nodes) => {
                let tests = all(nodes)?;
                test(move |i| tests.iter().any(|test| test.holds(i)))
            }
            Node::And(nodes) => {
                let tests = all(nodes)?;
                test(move |i| tests.iter().all(|test| test.holds(i)))
            }
            Node::Not(node) => {
                let inner = self.node(node)?;
                test(move |i| !inner.holds(i))
            }
            Node::Compare(left, comparison, right) => self.comparison(left, *comparison, right)?,
            Node::In(value, list, is_in) => {
                let one = |item| self.comparison(value, Comparison::Equal, item);
                let tests = list.iter().map(one).collect::<Result<Vec<_>, _>>()?;
                let is_in = *is_in;
                test(move |i| tests.iter().any(|test| test.holds(i)) == is_in)
            }
        })
    }

    fn side(&self, value: &Value) -> Result<Side<'a>, SelectionError> {
        Ok(match &value.kind {
            Kind::Number(number, written) => Side::Number(*number, written.clone()),
            Kind::Text(text) => Side::Text(text.clone()),
            Kind::Column(name) => match self.columns.column(name) {
                Some(column) => Side::Column(name.clone(), column),
                None => return Err(self.error(value.at, unknown(self.columns, name))),
            },
        })
    }

    fn comparison(
        &self,
        left: &Value,
        comparison: Comparison,
        right: &Value,
    ) -> Result<Test<'a>, SelectionError> {
        match (self.side(left)?, self.side(right)?) {
            (Side::Column(name, column), other) => self.compare(left.at, (&name, column), comparison, other),
            (other, Side::Column(name, column)) => {
                self.compare(right.at, (&name, column), comparison.turned(), other)
            }
            _ => Err(self.error(left.at, "this names no column, so it holds for all particles or for none")),
        }
    }

    /// Compares the column `name`, named at byte `at`, with `other`.
    fn compare(
        &self,
        at: usize,
        (name, column): (&str, Column<'a>),
        comparison: Comparison,
        other: Side<'a>,
    ) -> Result<Test<'a>, SelectionError> {
        match (column, other) {
            (Column::Number(value), Side::Number(number, _)) => {
                Ok(test(move |i| holds(comparison, value(i), number)))
            }
            (Column::Number(value), Side::Column(_, Column::Number(other))) => {
                Ok(test(move |i| holds(comparison, value(i), other(i))))
            }
            (Column::Number(_), _) => {
                Err(self.error(at, format!("`{name}` is a number, and is compared with a text")))
            }
            (Column::Text { .. }, _) if !matches!(comparison, Comparison::Equal | Comparison::Unequal) => {
                let problem =
                    format!("`{name}` is a text, which is neither above nor below another; use == or !=");
                Err(self.error(at, problem))
            }
            // The types of many simulations are texts that look like numbers.
            (Column::Text { index, names }, Side::Text(text) | Side::Number(_, text)) => {
                let equal: Vec<bool> = names.iter().map(|name| *name == text).collect();
                let wanted = comparison == Comparison::Equal;
                Ok(test(move |i| equal.get(index(i) as usize).copied().unwrap_or(false) == wanted))
            }
            (
                Column::Text { index, names },
                Side::Column(_, Column::Text { index: other, names: others }),
            ) => {
                let wanted = comparison == Comparison::Equal;
                let at = |names: &[String], i: u32| names.get(i as usize).cloned().unwrap_or_default();
                Ok(test(move |i| (at(&names, index(i)) == at(&others, other(i))) == wanted))
            }
            (Column::Text { .. }, Side::Column(other, Column::Number(_))) => {
                Err(self.error(at, format!("`{name}` is a text, and `{other}` a number")))
            }
        }
    }
}

fn test<'a>(holds: impl Fn(usize) -> bool + Sync + 'a) -> Test<'a> {
    Test(Box::new(holds))
}

/// NaN is unequal to all numbers, and neither above nor below any.
fn holds(comparison: Comparison, left: f64, right: f64) -> bool {
    match comparison {
        Comparison::Equal => left == right,
        Comparison::Unequal => left != right,
        Comparison::Below => left < right,
        Comparison::AtMost => left <= right,
        Comparison::Above => left > right,
        Comparison::AtLeast => left >= right,
    }
}
