//! Options that choose some of a render's iterations.

use crate::terminal::error::Error;
use clap::Args as ClapArgs;
use render::Field;
use render::merge::part_of;
use scene::settings::MAX_ITERATIONS;
use std::ops::Range;
use std::str::FromStr;

/// Which iterations are rendered, if not all.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Parts (with --radius-schedule global; docs/farm.md)")]
pub(crate) struct PartArgs {
    /// Render part K of N of the iterations alone, such as 3/64, and write it to -o FILE.sppm, for `sppm merge`
    #[arg(long, value_name = "K/N", value_parser = part, conflicts_with = "range", allow_hyphen_values = true)]
    pub part: Option<[u32; 2]>,

    /// Render the iterations from A on and before B alone, counted from 0, and write them to -o FILE.sppm
    #[arg(long, value_name = "A..B", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<Range<u32>>,
}

impl PartArgs {
    /// What asks for a part, if anything does.
    pub(crate) fn field(&self) -> Option<Field> {
        let range = self.range.as_ref().map(|_| Field::Range);
        self.part.map(|_| Field::Part).or(range)
    }

    /// The iterations to render of so many; `None` for all.
    pub(crate) fn range(&self, iterations: u32) -> Result<Option<Range<u32>>, Error> {
        match self.part {
            Some(_) if iterations == MAX_ITERATIONS => {
                let problem = "--part: how many iterations there are in all is not known; state them by -n";
                Err(Error::BadInput(problem.into()))
            }
            Some([part, parts]) => Ok(Some(part_of(iterations, part, parts)?)),
            None => Ok(self.range.clone()),
        }
    }

    /// A name for the part's file, to be put between that of the scene and its extension.
    pub(crate) fn name(&self) -> String {
        match (self.part, &self.range) {
            (Some([part, parts]), _) => format!("{part}-of-{parts}"),
            (None, Some(range)) => format!("{}-{}", range.start, range.end),
            (None, None) => String::new(),
        }
    }
}

fn pair(text: &str, separator: &str) -> Option<[u32; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([u32::from_str(first).ok()?, u32::from_str(second).ok()?])
}

fn part(text: &str) -> Result<[u32; 2], String> {
    let found = pair(text, "/").filter(|[part, parts]| (1..=*parts).contains(part));
    found.ok_or_else(|| "is not a part such as 3/64: its number, from 1, and how many there are".into())
}

fn range(text: &str) -> Result<Range<u32>, String> {
    let found = pair(text, "..").filter(|[start, end]| start < end);
    let found = found.map(|[start, end]| start..end);
    found.ok_or_else(|| {
        "is not a range such as 128..192: the first, from 0, and the one after the last".into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files of all parts of a scene have names of their own.
    #[test]
    fn files_are_named_by_their_part() {
        let name = |part, range| PartArgs { part, range }.name();
        assert_eq!(name(Some([3, 64]), None), "3-of-64");
        assert_eq!(name(None, Some(128..192)), "128-192");
        assert_eq!(name(None, None), "");
    }

    #[test]
    fn parts_and_ranges_are_read() {
        assert_eq!(part("3/64"), Ok([3, 64]));
        assert_eq!(range("0..5"), Ok(0..5));
        for text in ["", "3", "0/4", "5/4", "-1/4", "a/b", "1/2/3", "1..2"] {
            assert!(part(text).is_err(), "{text}");
        }
        for text in ["", "3", "5..5", "6..5", "-1..4", "1..", "..4", "1/2", "1..=2"] {
            assert!(range(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_part_is_of_so_many_iterations_and_a_range_of_any() {
        let of = |part, range| PartArgs { part, range };
        assert_eq!(of(None, None).field(), None);
        assert_eq!(
            [of(Some([1, 2]), None).field(), of(None, Some(0..3)).field()],
            [Some(Field::Part), Some(Field::Range)]
        );
        assert_eq!(of(None, None).range(8).unwrap(), None);
        assert_eq!(of(Some([2, 4]), None).range(8).unwrap(), Some(2..4));
        assert_eq!(of(None, Some(3..5)).range(8).unwrap(), Some(3..5));
        assert_eq!(of(None, Some(3..5)).range(MAX_ITERATIONS).unwrap(), Some(3..5));
        let problem = of(Some([2, 4]), None).range(MAX_ITERATIONS).unwrap_err().to_string();
        assert_eq!(problem, "--part: how many iterations there are in all is not known; state them by -n");
    }
}
