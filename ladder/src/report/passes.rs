//! The passes of an iteration: their names, their seconds, and how their work grows by the paper's analysis.

use super::sweep::Sweep;
use scene::Stats;

/// A pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassInfo {
    /// Its name in reports.
    pub name: &'static str,
    /// Its seconds.
    pub seconds: fn(&Stats) -> f64,
    /// The parameters with which its work grows at most proportionally, by the paper's analysis. With n iterations, p
    /// pixels, d segments of a path, l photons and |S| spheres, the camera pass takes O(n d p |S|), the index and the
    /// consolidation O(n p), and the photon pass O(n l d p |S|).
    grows_with: &'static [Sweep],
}

/// All passes, in the order of [`crate::Rung::operations`].
pub(crate) const PASSES: [PassInfo; 4] = [
    PassInfo {
        name: "camera pass",
        seconds: |stats| stats.camera_seconds,
        grows_with: &[Sweep::Iterations, Sweep::Size, Sweep::Depth, Sweep::Spheres],
    },
    PassInfo {
        name: "index",
        seconds: |stats| stats.build_grid_seconds,
        grows_with: &[Sweep::Iterations, Sweep::Size],
    },
    PassInfo {
        name: "photon pass",
        seconds: |stats| stats.photon_seconds,
        grows_with: &[Sweep::Iterations, Sweep::Size, Sweep::Depth, Sweep::Spheres, Sweep::Photons],
    },
    PassInfo {
        name: "consolidate",
        seconds: |stats| stats.consolidate_seconds,
        grows_with: &[Sweep::Iterations, Sweep::Size],
    },
];

impl PassInfo {
    /// The work that the paper's analysis predicts for `value`, up to a constant factor.
    pub(crate) fn predicted(&self, sweep: Sweep, value: u64) -> f64 {
        if self.grows_with.contains(&sweep) { value as f64 } else { 1.0 }
    }
}
