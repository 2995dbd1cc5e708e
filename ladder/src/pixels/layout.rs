//! The trait of all layouts of pixels, and the data that goes in and out of them.

use crate::flux::{IntegerSums, Photon};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// The results of camera paths, one per lane.
#[derive(Clone, Copy)]
pub(crate) struct Seen<V: Vector> {
    /// Radiance of lamps seen, and of direct light.
    pub(crate) direct: V,
    /// The path's throughput up to the visible point; zero where there is none.
    pub(crate) attenuation: V,
    /// The visible point: its position, unit normal, the direction that it was seen from, sphere and colour.
    pub(crate) point: V,
    pub(crate) normal: V,
    pub(crate) incident: V,
    pub(crate) sphere: U<V>,
    pub(crate) colour: V,
    /// True where a shell is hit from inside.
    pub(crate) in_shell: M<V>,
}

/// The visible points as the spatial index needs them.
pub(crate) struct Site<V: Vector> {
    /// Which lanes hold a visible point.
    pub(crate) is_set: M<V>,
    pub(crate) point: V,
    pub(crate) radius_squared: F<V>,
    pub(crate) sphere: U<V>,
}

/// The state of a pixel, accumulated over all iterations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelState {
    pub(crate) direct: Vec3,
    pub(crate) tau: Vec3,
    pub(crate) n: f32,
    pub(crate) radius_squared: f32,
}

/// A layout of pixels. Vertical layouts process one pixel per lane, and have room past the last pixel.
pub(crate) trait Pixels {
    /// The data held of candidates while they are tested.
    type Held<V: Vector>: Copy;

    /// `count` pixels before the first iteration.
    fn new(count: usize, initial_radius: f32, sums: IntegerSums) -> Self;

    /// The integer sums, if flux is not summed in floats.
    fn sums(&self) -> &IntegerSums;

    /// Stores the results of the camera paths of the pixels from `at` on.
    fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>);

    /// The visible points of the pixels from `at` on.
    fn site<V: Vector>(&self, at: usize) -> Site<V>;

    /// Reads the visible points `ids`, or prepares to read them.
    fn fetch<V: Vector>(&self, ids: U<V>) -> Self::Held<V>;
    /// True where the throughput is not zero in all channels.
    fn is_set<V: Vector>(&self, held: &Self::Held<V>) -> M<V>;
    /// Points and squared radii.
    fn reach<V: Vector>(&self, held: &Self::Held<V>) -> (V, F<V>);
    /// Normals.
    fn normal<V: Vector>(&self, held: &Self::Held<V>) -> V;
    /// True where the point was seen from the side of its normal.
    fn is_seen<V: Vector>(&self, held: &Self::Held<V>, normal: V) -> M<V>;
    /// True where the point lies inside of shell `sphere`.
    fn is_in_shell<V: Vector>(&self, held: &Self::Held<V>, sphere: u32) -> M<V>;
    /// Colours.
    fn colour<V: Vector>(&self, tables: &Tables, held: &Self::Held<V>) -> V;

    /// Adds one photon to the pixels `ids[lane]` of the lanes whose bits are set.
    fn add<V: Vector>(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon, contribution: V);

    /// Adds the iteration's photons to the pixels from `at` on, and clears their sums.
    fn consolidate<V: Vector>(&mut self, at: usize, nominal: f32);

    /// The accumulated state of pixel `index`.
    fn state(&self, index: usize) -> PixelState;

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// The direction `incident`. Where a grazing ray seems to come from behind by rounding, the reverse of the normal, as
/// every visible point was seen from its visible side.
#[inline(always)]
pub(crate) fn from_the_front<V: Vector>(seen: &Seen<V>) -> V {
    let is_in_front = V::L::lt(seen.incident.dot(seen.normal), V::L::f(0.0));
    V::select(is_in_front, seen.incident, -seen.normal)
}

/// True where a vector is not zero.
#[inline(always)]
pub(crate) fn is_not_zero<V: Vector>(v: V) -> M<V> {
    let ([x, y, z], zero) = (v.xyz(), V::L::f(0.0));
    // The components are throughputs, so they are not negative.
    V::L::lt(zero, x) | V::L::lt(zero, y) | V::L::lt(zero, z)
}
