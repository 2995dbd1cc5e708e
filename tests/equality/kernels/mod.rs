//! Each kernel of the fast engine by itself: on every kind of lanes the bits of the reference's function, or those of
//! a plain definition where the reference needs no such kernel.

mod consolidation;
mod grid;
#[path = "../../../fast/benches/inputs.rs"]
mod inputs;
mod intersection;
mod join;
mod operations;
mod passes;
mod rays;
mod sampling;
mod scattering;
mod streams;
mod work;

use crate::cases;
use crate::pair::effort;
use fast::LaneKind;
use proptest::prelude::*;
use proptest::test_runner::{TestCaseResult, TestError, TestRunner};
use scene::Vec3;
use scene::rng::UNIT;
use std::cell::Cell;
use std::fmt::Debug;

/// Lengths around whole packets of 8 and 16: every tail.
const TAILS: std::ops::RangeInclusive<usize> = 0..=31;

/// Behind each output stand so many floats that must not be touched.
const GUARDS: usize = 32;

/// A float that no kernel gives.
const GUARD: f32 = f32::from_bits(0xdead_beef);

/// Every kind of lanes; one that this processor lacks is emulated.
fn lane_kinds() -> impl Iterator<Item = LaneKind> {
    LaneKind::ALL.into_iter()
}

/// Tells how many cases a kernel has passed, and on which lanes, past the capture of the test harness.
fn tell(count: usize, kernel: &str) {
    let name =
        |lanes: LaneKind| format!("{lanes:?}{}", if lanes.is_available() { "" } else { " (emulated)" });
    let lanes: Vec<String> = lane_kinds().map(name).collect();
    cases::tell("equality", count, &format!("cases of {kernel} equal on {}", lanes.join(", ")));
}

/// Equality by bits, but that any NaN is as good as another: the language leaves its bits open.
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// A float as it reads and as it is.
fn shown(x: f32) -> String {
    format!("{x:?} ({:#010x})", x.to_bits())
}

/// Expects equal floats, by bits.
#[track_caller]
fn assert_same(actual: &[f32], expected: &[f32], what: &dyn Debug) {
    assert_eq!(actual.len(), expected.len(), "{what:?}");
    for (index, (a, e)) in actual.iter().zip(expected).enumerate() {
        assert!(same(*a, *e), "{what:?}: [{index}] is {} instead of {}", shown(*a), shown(*e));
    }
}

/// Expects equal vectors, by bits.
#[track_caller]
fn assert_same_vector(actual: Vec3, expected: Vec3, what: &dyn Debug) {
    assert_same(&actual.to_array(), &expected.to_array(), what);
}

/// Compares a map on all lanes with its definition, row by row: all rows at once, and the first ones at every
/// length that ends within a packet. Gives the number of rows compared.
fn check_map<const A: usize, const B: usize>(
    name: &str,
    rows: &[[f32; A]],
    kernel: impl Fn(LaneKind, [&[f32]; A], [&mut [f32]; B]),
    definition: impl Fn([f32; A]) -> [f32; B],
) -> usize {
    let columns: [Vec<f32>; A] = std::array::from_fn(|k| rows.iter().map(|row| row[k]).collect());
    let expected: Vec<[f32; B]> = rows.iter().map(|row| definition(*row)).collect();
    let mut compared = 0;
    for lanes in lane_kinds() {
        for count in TAILS.filter(|count| *count < rows.len()).chain([rows.len()]) {
            let inputs = std::array::from_fn(|k| &columns[k][..count]);
            let mut outputs: [Vec<f32>; B] = std::array::from_fn(|_| vec![GUARD; count + GUARDS]);
            kernel(lanes, inputs, outputs.each_mut().map(|column| &mut column[..count]));
            for index in 0..count {
                let actual: [f32; B] = std::array::from_fn(|k| outputs[k][index]);
                assert_same(&actual, &expected[index], &(name, lanes, count, rows[index].map(shown)));
            }
            for column in &outputs {
                assert_same(&column[count..], &[GUARD; GUARDS], &(name, lanes, count, "guards"));
            }
            compared += count;
        }
    }
    compared
}

/// Tries a property on random inputs, and tells how many there were; for one that fails, shows the simplest.
fn check<S: Strategy>(cases: u32, what: &str, inputs: &S, property: impl Fn(S::Value) -> TestCaseResult)
where
    S::Value: Debug,
{
    let tried = Cell::new(0);
    let result = TestRunner::new(effort(cases)).run(inputs, |input| {
        tried.set(tried.get() + 1);
        property(input)
    });
    match result {
        Ok(()) => tell(tried.get(), what),
        Err(TestError::Fail(why, input)) => panic!("{what}: {why}\n{input:?}"),
        Err(TestError::Abort(why)) => panic!("{what}: {why}"),
    }
}

/// Uniform numbers as the streams give them, the ends of the unit interval and of its quarters among them.
fn edge_uniforms() -> Vec<f32> {
    let inner = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
    let around = inner.into_iter().flat_map(|u: f32| [u - UNIT, u, u + UNIT]);
    [0.0, UNIT, 1.0 - 2.0 * UNIT, 1.0 - UNIT].into_iter().chain(around).collect()
}

/// Unit vectors: axes, with zeros of both signs; close to the lower pole; and of no symmetry.
fn edge_directions() -> Vec<Vec3> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let others = [
        Vec3::new(1e-4, -1e-4, -1.0),
        Vec3::new(-1.0, 1.0, -1e-7),
        Vec3::new(1.0, 1e-20, 0.0),
        Vec3::new(1e-38, 1.0, 1e-38),
        Vec3::new(0.36, -0.48, 0.8),
        Vec3::new(-0.6, 0.0, -0.8),
    ];
    axes.chain(others.into_iter().map(reference::sampling::unit)).collect()
}
