//! Finds pixels with a NaN or an infinity, for which no metric is defined.

use crate::error::CompareError;
use crate::strips::Strip;

/// What was found in images A and B.
#[derive(Default)]
pub(crate) struct Finite {
    found: [Found; 2],
}

/// The pixels of an image that are not finite: how many, and column and row of the first.
#[derive(Clone, Copy, Default)]
struct Found {
    count: usize,
    x: usize,
    y: usize,
}

impl Finite {
    /// Looks at the rows of a strip.
    pub(crate) fn add(&mut self, strip: &Strip) {
        let broken = strip.map_rows(|y| {
            strip.row(y).map(|row| {
                let mut places = row.iter().enumerate().filter(|(_, p)| !p.is_finite()).map(|(x, _)| x);
                places.next().map(|x| Found { count: 1 + places.count(), x, y })
            })
        });
        for rows in broken {
            for (found, row) in self.found.iter_mut().zip(rows) {
                if let Some(row) = row {
                    let first = if found.count > 0 { *found } else { row };
                    *found = Found { count: found.count + row.count, ..first };
                }
            }
        }
    }

    /// # Errors
    /// If a pixel was not finite.
    pub(crate) fn check(&self) -> Result<(), CompareError> {
        let broken = ['A', 'B'].into_iter().zip(self.found).find(|(_, found)| found.count > 0);
        broken.map_or(Ok(()), |(image, Found { count, x, y })| {
            Err(CompareError::NotFinite { image, count, x, y })
        })
    }
}
