//! What every layout of pixels can do, and what goes in and out of it.

use crate::flux::{IntegerSums, Photon};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// What one camera path per lane brings.
#[derive(Clone, Copy)]
pub(crate) struct Seen<V: Vector> {
    /// Radiance of lamps seen, and of direct light.
    pub(crate) direct: V,
    /// The path's throughput up to the visible point; zero where there is none.
    pub(crate) attenuation: V,
    /// The visible point: its place, unit normal, the direction in which it was met, sphere and colour.
    pub(crate) point: V,
    pub(crate) normal: V,
    pub(crate) incident: V,
    pub(crate) sphere: U<V>,
    pub(crate) colour: V,
    /// True where the sphere is met from inside.
    pub(crate) in_shell: M<V>,
}

/// What the spatial index needs to know of visible points.
pub(crate) struct Site<V: Vector> {
    /// Which of them there are.
    pub(crate) is_set: M<V>,
    pub(crate) point: V,
    pub(crate) radius_squared: F<V>,
    pub(crate) sphere: U<V>,
}

/// What a pixel has gathered over all iterations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelState {
    pub(crate) direct: Vec3,
    pub(crate) tau: Vec3,
    pub(crate) n: f32,
    pub(crate) radius_squared: f32,
}

/// A layout. Vertical ones take as many pixels at once as there are lanes, and have room past the last pixel.
pub(crate) trait Pixels {
    /// What is held of candidates while they are tested.
    type Held<V: Vector>: Copy;

    /// `count` pixels before the first iteration.
    fn new(count: usize, initial_radius: f32, sums: IntegerSums) -> Self;

    /// How flux is summed, if not in floats.
    fn sums(&self) -> &IntegerSums;

    /// Takes in what the camera paths of the pixels from `at` on have brought.
    fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>);

    /// The visible points of the pixels from `at` on.
    fn site<V: Vector>(&self, at: usize) -> Site<V>;

    /// Reads (or makes ready to read) the visible points `ids`.
    fn fetch<V: Vector>(&self, ids: U<V>) -> Self::Held<V>;
    /// True where the throughput is not zero in all channels.
    fn is_set<V: Vector>(&self, held: &Self::Held<V>) -> M<V>;
    /// Points and squared radii.
    fn reach<V: Vector>(&self, held: &Self::Held<V>) -> (V, F<V>);
    /// Normals.
    fn normal<V: Vector>(&self, held: &Self::Held<V>) -> V;
    /// True where the point was met from the side of its normal.
    fn is_seen<V: Vector>(&self, held: &Self::Held<V>, normal: V) -> M<V>;
    /// True where the point lies inside of shell `sphere`.
    fn is_in_shell<V: Vector>(&self, held: &Self::Held<V>, sphere: u32) -> M<V>;
    /// Colours.
    fn colour<V: Vector>(&self, tables: &Tables, held: &Self::Held<V>) -> V;

    /// Adds one photon to the pixels `ids[lane]` of the lanes whose bits are set.
    fn add<V: Vector>(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon, contribution: V);

    /// Takes in the iteration's photons for the pixels from `at` on, and clears their sums.
    fn consolidate<V: Vector>(&mut self, at: usize, nominal: f32);

    /// What pixel `index` has gathered.
    fn state(&self, index: usize) -> PixelState;

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// `incident`, or where by rounding a grazing ray seems to come from behind, the reverse of the normal: what was seen
/// was seen from its visible side.
#[inline(always)]
pub(crate) fn from_the_front<V: Vector>(seen: &Seen<V>) -> V {
    let is_in_front = V::L::lt(seen.incident.dot(seen.normal), V::L::f(0.0));
    V::select(is_in_front, seen.incident, -seen.normal)
}

/// True where a vector is not zero.
#[inline(always)]
pub(crate) fn is_not_zero<V: Vector>(v: V) -> M<V> {
    let ([x, y, z], zero) = (v.xyz(), V::L::f(0.0));
    // Not negative: the components are throughputs.
    V::L::lt(zero, x) | V::L::lt(zero, y) | V::L::lt(zero, z)
}
