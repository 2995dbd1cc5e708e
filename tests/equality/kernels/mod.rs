//! Tests of each kernel of the fast engine on every kind of lanes. It must give the same bits as the reference's
//! function, or as a plain definition in Rust where the reference has no such function.

mod consolidation;
mod grid;
#[path = "../../../fast/benches/inputs.rs"]
mod inputs;
mod intersection;
mod join;
mod light_choice;
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
use std::fmt::{self, Debug, Formatter};

/// Input lengths with every possible tail of a packet of 8 or 16.
const TAILS: std::ops::RangeInclusive<usize> = 0..=31;

/// Number of guard values after each output, which must not be overwritten.
const GUARDS: usize = 32;

/// A guard value, which no kernel computes.
const GUARD: f32 = f32::from_bits(0xdead_beef);

/// Every kind of lanes. Lanes that the processor does not support are emulated.
fn lane_kinds() -> impl Iterator<Item = LaneKind> {
    LaneKind::ALL.into_iter()
}

/// Reports how many cases a kernel has passed, and on which lanes.
fn tell(count: usize, kernel: &str) {
    let name =
        |lanes: LaneKind| format!("{lanes:?}{}", if lanes.is_available() { "" } else { " (emulated)" });
    let lanes: Vec<String> = lane_kinds().map(name).collect();
    cases::tell("equality", count, &format!("cases of {kernel} equal on {}", lanes.join(", ")));
}

/// Equality by bits, except that all NaNs are equal, as Rust does not specify their bits.
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// A float as a number and as bits.
fn shown(x: f32) -> String {
    format!("{x:?} ({:#010x})", x.to_bits())
}

/// Floats that are shown so, but only if they must be: millions are compared.
struct Shown<const N: usize>([f32; N]);

impl<const N: usize> Debug for Shown<N> {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.debug_list().entries(self.0.map(shown)).finish()
    }
}

/// Expects floats with equal bits.
#[track_caller]
fn assert_same(actual: &[f32], expected: &[f32], what: &dyn Debug) {
    assert_eq!(actual.len(), expected.len(), "{what:?}");
    for (index, (a, e)) in actual.iter().zip(expected).enumerate() {
        assert!(same(*a, *e), "{what:?}: [{index}] is {} instead of {}", shown(*a), shown(*e));
    }
}

/// Expects vectors with equal bits.
#[track_caller]
fn assert_same_vector(actual: Vec3, expected: Vec3, what: &dyn Debug) {
    assert_same(&actual.to_array(), &expected.to_array(), what);
}

/// Compares a kernel that maps rows to rows with its definition, on all lanes: for all rows at once, and for the first
/// rows in every length with an incomplete packet. Returns the number of rows compared.
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
                assert_same(&actual, &expected[index], &(name, lanes, count, Shown(rows[index])));
            }
            for column in &outputs {
                assert_same(&column[count..], &[GUARD; GUARDS], &(name, lanes, count, "guards"));
            }
            compared += count;
        }
    }
    compared
}

/// Tests a property on random inputs and reports their number; shows the simplest input that fails.
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

/// Uniform numbers as the streams give them: at the ends of the unit interval, and around multiples of an eighth.
fn edge_uniforms() -> Vec<f32> {
    let inner = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
    let around = inner.into_iter().flat_map(|u: f32| [u - UNIT, u, u + UNIT]);
    [0.0, UNIT, 1.0 - 2.0 * UNIT, 1.0 - UNIT].into_iter().chain(around).collect()
}

/// Unit vectors: along axes, with zeros of both signs; close to the lower pole; and in general directions.
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
