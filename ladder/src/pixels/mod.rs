//! Pixels and their visible points, laid out in memory as the paper's stages do it.

mod columns;
mod lines;
mod scalar;

pub(crate) use columns::Columns;
pub(crate) use lines::{Line8, Line16, Lines};
pub(crate) use scalar::{Objects, ScalarPixels, TypedArrays};

use crate::flux::{IntegerSums, Photon};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// The share of new photons that is kept, as in the reference.
const ALPHA: f32 = 2.0 / 3.0;

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

/// What changes of pixels as an iteration ends.
pub(crate) struct Gathered<V: Vector> {
    pub(crate) tau: V,
    pub(crate) n: F<V>,
    pub(crate) radius_squared: F<V>,
}

impl<V: Vector> Gathered<V> {
    /// `N' = N + alpha M`, `R'^2 = R^2 (N + alpha M) / (N + M)`, `tau' = (tau + attenuation phi) R'^2 / R^2`, as
    /// `reference::consolidate`, for one pixel per lane.
    #[inline(always)]
    pub(crate) fn consolidated(self, attenuation: V, sums: &[[f32; 4]; MOST_LANES]) -> Self {
        let (mut m, mut flux) = ([0.0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
        for lane in 0..V::L::N {
            [flux[0][lane], flux[1][lane], flux[2][lane], m[lane]] = sums[lane];
        }
        let m = V::L::load(&m);
        let phi = V::new(V::L::load(&flux[0]), V::L::load(&flux[1]), V::L::load(&flux[2]));
        let n = self.n + V::L::f(ALPHA) * m;
        let ratio = n / (self.n + m);
        let tau = (self.tau + attenuation * phi).scale(ratio);
        let counts = V::L::lt(V::L::f(0.0), m);
        Self {
            tau: V::select(counts, tau, self.tau),
            n: V::L::select(counts, n, self.n),
            radius_squared: V::L::select(counts, self.radius_squared * ratio, self.radius_squared),
        }
    }
}

/// `incident`, or where by rounding a grazing ray seems to come from behind, the reverse of the normal: what was seen
/// was seen from its visible side.
#[inline(always)]
fn from_the_front<V: Vector>(seen: &Seen<V>) -> V {
    let is_in_front = V::L::lt(seen.incident.dot(seen.normal), V::L::f(0.0));
    V::select(is_in_front, seen.incident, -seen.normal)
}

/// True where a vector is not zero.
#[inline(always)]
fn is_not_zero<V: Vector>(v: V) -> M<V> {
    let ([x, y, z], zero) = (v.xyz(), V::L::f(0.0));
    // Not negative: the components are throughputs.
    V::L::lt(zero, x) | V::L::lt(zero, y) | V::L::lt(zero, z)
}
