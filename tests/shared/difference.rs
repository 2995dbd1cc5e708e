//! Everything that an engine exposes of a render, and the first difference between two engines.

use compare::{EnginePlane, PlaneDifference, PlaneKind, first_difference, planes};
use scene::{Engine, Stats};

/// The planes of a render, and its counted work.
pub(crate) struct Outcome {
    pub(crate) planes: [EnginePlane; 4],
    pub(crate) work: [(&'static str, u64); 7],
}

impl Outcome {
    pub(crate) fn of(engine: &(impl Engine + ?Sized)) -> Self {
        Self { planes: planes(engine), work: work(engine.stats()) }
    }

    /// Describes the first difference of `actual` in the bits of any plane, and all differences in the work.
    pub(crate) fn difference(&self, actual: &Self) -> Option<String> {
        self.difference_in(actual, &PlaneKind::ALL)
    }

    /// The same for planes of the given kinds only.
    pub(crate) fn difference_in(&self, actual: &Self, kinds: &[PlaneKind]) -> Option<String> {
        let of_kinds = |planes: &[EnginePlane]| -> Vec<EnginePlane> {
            planes.iter().filter(|plane| kinds.contains(&plane.kind)).cloned().collect()
        };
        let in_planes = first_difference(&of_kinds(&self.planes), &of_kinds(&actual.planes)).map(|first| {
            let PlaneDifference::Value { count, .. } = first else { return first.to_string() };
            format!("{first}, {count} values in all")
        });
        let work = self.work.iter().zip(&actual.work).filter(|(expected, actual)| expected != actual);
        let in_work = work.map(|((name, e), (_, a))| format!("{name} is {a} instead of {e}"));
        let all: Vec<String> = in_planes.into_iter().chain(in_work).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// The counts that must be the same for every engine.
fn work(stats: &Stats) -> [(&'static str, u64); 7] {
    [
        ("camera_segments", stats.camera_segments),
        ("shadow_rays", stats.shadow_rays),
        ("visible_points", stats.visible_points),
        ("photons", stats.photons),
        ("photon_segments", stats.photon_segments),
        ("deposits", stats.deposits),
        ("contributions", stats.contributions),
    ]
}

#[test]
fn bits_and_counts_make_a_difference() {
    let outcome = |value: f32, deposits| Outcome {
        planes: PlaneKind::ALL.map(|kind| EnginePlane { kind, width: 1, channels: 1, values: vec![value] }),
        work: work(&Stats { deposits, ..Stats::default() }),
    };
    assert_eq!(outcome(f32::NAN, 1).difference(&outcome(f32::NAN, 1)), None);
    let difference = outcome(0.0, 1).difference(&outcome(-0.0, 1)).unwrap();
    assert!(
        difference.starts_with("camera pass: direct light of pixel (0, 0) is -0.0 (0x80000000) instead of"),
        "{difference}"
    );
    assert_eq!(outcome(0.0, 1).difference_in(&outcome(-0.0, 1), &[]), None);
    assert_eq!(outcome(0.0, 1).difference(&outcome(0.0, 2)).as_deref(), Some("deposits is 2 instead of 1"));
}
