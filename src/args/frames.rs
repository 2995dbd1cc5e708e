//! Ranges of the frames of a trajectory, and the names of the files that each gets.

use files::paths::around;
use std::fmt;
use std::path::{Path, PathBuf};

/// The frames `start, start + step, ...` before `end`, or to the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frames {
    start: usize,
    end: Option<usize>,
    step: usize,
}

/// In the name of an output: the frame's number.
const PLACEHOLDER: &str = "{frame}";

impl Frames {
    /// Reads `A..B` or `A..B:STEP`, where A and B may be left out.
    ///
    /// # Errors
    /// What would be right.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let read = || {
            let (range, step) = text.split_once(':').unwrap_or((text, "1"));
            let (start, end) = range.split_once("..")?;
            let start = if start.is_empty() { 0 } else { start.parse().ok()? };
            let end = if end.is_empty() { None } else { Some(end.parse().ok()?) };
            let step = step.parse().ok()?;
            (step > 0 && end.is_none_or(|end| start < end)).then_some(Self { start, end, step })
        };
        read().ok_or_else(|| {
            format!(
                "`{text}` is not a range of frames such as 3..10, 3.. or 0..100:5: the first, from 0, the one after the last, \
                 and the step"
            )
        })
    }

    /// Those from the frame `start` on.
    pub(crate) fn beginning_at(self, start: usize) -> Self {
        Self { start, ..self }
    }

    /// The numbers of those that are in a file of `count` frames. If their number is not known, it is said why.
    ///
    /// # Errors
    /// If there are none, or if the end is that of a file whose frames cannot be counted.
    pub(crate) fn numbers(self, count: Result<usize, String>) -> Result<Vec<usize>, String> {
        let end = match (self.end, count) {
            (Some(end), Ok(count)) if end > count => {
                return Err(format!("there is no frame {}; the file has {count}, from 0", end - 1));
            }
            (Some(end), _) => end,
            (None, Ok(count)) if self.start >= count => {
                return Err(format!("there is no frame {}; the file has {count}, from 0", self.start));
            }
            (None, Ok(count)) => count,
            (None, Err(problem)) => {
                return Err(format!("{problem}; so its frames cannot be counted: give the range an end"));
            }
        };
        Ok((self.start..end).step_by(self.step).collect())
    }
}

/// As [`Frames::parse`] reads it.
impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..", self.start)?;
        if let Some(end) = self.end {
            write!(f, "{end}")?;
        }
        if self.step == 1 { Ok(()) } else { write!(f, ":{}", self.step) }
    }
}

/// The file of frame `number`: with its number in place of `{frame}`, or else before the extension.
pub(crate) fn numbered(path: &Path, number: usize) -> PathBuf {
    let digits = format!("{number:04}");
    match path.to_str() {
        Some(text) if text.contains(PLACEHOLDER) => text.replace(PLACEHOLDER, &digits).into(),
        _ => {
            let stem = path.with_file_name(path.file_stem().unwrap_or_default());
            let extension =
                path.extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
            around(&stem, "", &format!("-{digits}{extension}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str, count: usize) -> Result<Vec<usize>, String> {
        Frames::parse(text)?.numbers(Ok(count))
    }

    #[test]
    fn ranges_leave_out_their_end() {
        assert_eq!(numbers("3..6", 10), Ok(vec![3, 4, 5]));
        assert_eq!(numbers("..", 3), Ok(vec![0, 1, 2]));
        assert_eq!(numbers("..2", 3), Ok(vec![0, 1]));
        assert_eq!(numbers("1..:2", 6), Ok(vec![1, 3, 5]));
        assert_eq!(numbers("0..10:4", 10), Ok(vec![0, 4, 8]));
        assert!(numbers("3..11", 10).unwrap_err().contains("no frame 10; the file has 10"));
        assert!(numbers("7..", 7).unwrap_err().contains("no frame 7; the file has 7"));
        for wrong in ["3..3", "4..3", "a..b", "1..2:0", "-1..2", "1..2..3", "..:"] {
            assert!(Frames::parse(wrong).unwrap_err().contains("range of frames"), "{wrong}");
        }
    }

    /// What goes on with a range ends where the range ends, and leaves out what the range leaves out.
    #[test]
    fn the_rest_of_a_range_has_its_end_and_its_step() {
        for (text, start, rest) in
            [("..", 3, "3.."), ("0..9", 3, "3..9"), ("1..:2", 5, "5..:2"), ("0..100:10", 30, "30..100:10")]
        {
            let range = Frames::parse(text).unwrap().beginning_at(start);
            assert_eq!(range.to_string(), rest);
            assert_eq!(Frames::parse(rest), Ok(range));
        }
    }

    #[test]
    fn frames_that_cannot_be_counted_need_an_end() {
        let damaged = || Err("a.xyz:9: ends too early".into());
        assert_eq!(Frames::parse("1..3").unwrap().numbers(damaged()), Ok(vec![1, 2]));
        assert!(
            Frames::parse("1..").unwrap().numbers(damaged()).unwrap_err().contains("give the range an end")
        );
    }

    #[test]
    fn every_frame_has_a_file_of_its_own() {
        for (path, expected) in [
            ("a/b.png", "a/b-0007.png"),
            ("a/{frame}.exr", "a/0007.exr"),
            ("{frame}/b-{frame}.png", "0007/b-0007.png"),
            ("b", "b-0007"),
            ("b.png.sppm", "b.png-0007.sppm"),
        ] {
            assert_eq!(numbered(Path::new(path), 7), Path::new(expected));
        }
        assert_eq!(numbered(Path::new("b.png"), 12345), Path::new("b-12345.png"));
    }
}
