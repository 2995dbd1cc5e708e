//! The budget of a search: numbers of points and renders, and a time limit.

use std::time::Duration;

/// The budget of a search.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Points to try, including the defaults; at least 2.
    pub evaluations: u32,
    /// Pairs of renders per point, one with the defaults and one with the point; at least 1.
    pub pairs: u32,
    /// Pairs of renders in the final measurement of the best point; at least 1.
    pub final_pairs: u32,
    /// The time after which no further point is tried.
    pub time: Option<Duration>,
}

impl Budget {
    /// The number of points spread over the space before the model proposes any.
    pub(crate) fn initial(&self) -> u32 {
        (self.evaluations / 4).clamp(2, 12)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of the points, but at least two, and no more than a dozen.
    #[test]
    fn few_points_are_tried_before_the_model_proposes_any() {
        let initial = |evaluations| Budget { evaluations, pairs: 1, final_pairs: 6, time: None }.initial();
        assert_eq!([2, 8, 12, 40, 48, 1000].map(initial), [2, 2, 3, 10, 12, 12]);
    }
}
