//! Intersection of rays in lanes with one sphere at a time: `reference::intersect`, operation by operation.
//!
//! A batch of rays meets one shape after the other, so that what is known of a shape stays in registers.

use crate::paths::{Floats, Words};
use crate::rays::{BLOCKED, Rays};
use crate::shape_list::Chosen;
use crate::shapes::{BallShape, Shape};
use lanes::{Lanes, V3};
use scene::ray::{NO_SPHERE, SphereId};
use scene::still::{Enclosure, Ground};

/// Rays in lanes.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<L: Lanes> {
    pub(crate) origin: V3<L>,
    pub(crate) direction: V3<L>,
    pub(crate) leaves: L::U,
}

impl<L: Lanes> RayLanes<L> {
    /// The rays of a batch from `at` on.
    #[inline(always)]
    fn load(rays: &Rays, at: usize) -> Self {
        let leaves = L::load_u(&rays.leaves[at..]);
        Self { origin: rays.origin.load(at), direction: rays.direction.load(at), leaves }
    }
}

/// The nearest hits of the rays of a batch among some shapes: distance (infinite if none) and sphere ([`NO_SPHERE`] if none).
#[inline(always)]
pub(crate) fn nearest<L: Lanes>(chosen: Chosen, rays: &Rays, t: &mut Floats, hit: &mut Words) {
    for at in (0..rays.count).step_by(L::N) {
        L::store(L::f(f32::INFINITY), &mut t[at..]);
        L::store_u(L::u(NO_SPHERE), &mut hit[at..]);
    }
    for place in chosen.places {
        match &chosen.shapes[*place as usize] {
            Shape::Solid(ball) => lower::<L>(&Ball::<false>(*ball), rays, t, hit),
            Shape::Glass(ball) => lower::<L>(&Ball::<true>(*ball), rays, t, hit),
            Shape::Ground(ground) => lower::<L>(ground, rays, t, hit),
            Shape::Enclosure(enclosure) => lower::<L>(enclosure, rays, t, hit),
        }
    }
}

/// Sets `t` to [`BLOCKED`] where a shadow ray hits a shape nearer than `t`, other than the sphere that it ignores.
#[inline(always)]
pub(crate) fn occlude<L: Lanes>(chosen: Chosen, rays: &Rays, t: &mut Floats) {
    for place in chosen.places {
        match &chosen.shapes[*place as usize] {
            Shape::Solid(ball) => block::<L>(&Ball::<false>(*ball), rays, t),
            Shape::Glass(ball) => block::<L>(&Ball::<true>(*ball), rays, t),
            Shape::Ground(ground) => block::<L>(ground, rays, t),
            Shape::Enclosure(enclosure) => block::<L>(enclosure, rays, t),
        }
    }
}

/// Lowers the nearest hits to those on one surface.
#[inline(always)]
fn lower<L: Lanes>(surface: &impl Surface, rays: &Rays, t: &mut Floats, hit: &mut Words) {
    let surface = *surface; // for all that the compiler knows, `t` might be part of the original
    for at in (0..rays.count).step_by(L::N) {
        let (least, of) = (L::load(&t[at..]), L::load_u(&hit[at..]));
        let (distance, is_nearer) = surface.meet_before(&RayLanes::<L>::load(rays, at), least);
        // By a minimum: a choice and a store would become a store by a mask, which some processors do slowly.
        let nearer = L::select(is_nearer, distance, L::f(f32::INFINITY));
        L::store(L::min(nearer, least), &mut t[at..]);
        L::store_u(L::select_u(is_nearer, L::u(surface.sphere()), of), &mut hit[at..]);
    }
}

/// The same for shadow rays.
#[inline(always)]
fn block<L: Lanes>(surface: &impl Surface, rays: &Rays, t: &mut Floats) {
    let surface = *surface; // as above
    for at in (0..rays.count).step_by(L::N) {
        let (limit, ignores) = (L::load(&t[at..]), L::load_u(&rays.ignores[at..]));
        let (_, is_nearer) = surface.meet_before(&RayLanes::<L>::load(rays, at), limit);
        let blocked = is_nearer & !L::eq(L::u(surface.sphere()), ignores);
        let end = L::select(blocked, L::f(BLOCKED), L::f(f32::INFINITY));
        L::store(L::min(end, limit), &mut t[at..]);
    }
}

/// What rays meet.
trait Surface: Copy {
    /// Its sphere.
    fn sphere(&self) -> SphereId;

    /// The distances, and the lanes in which they are those of hits nearer than `limit`.
    fn meet_before<L: Lanes>(&self, ray: &RayLanes<L>, limit: L::F) -> (L::F, L::M);
}

/// A ball that rays meet from outside, or of glass, which they meet from both sides.
#[derive(Clone, Copy)]
struct Ball<const IS_GLASS: bool>(BallShape);

impl<const IS_GLASS: bool> Surface for Ball<IS_GLASS> {
    #[inline(always)]
    fn sphere(&self) -> SphereId {
        self.0.sphere
    }

    #[inline(always)]
    fn meet_before<L: Lanes>(&self, ray: &RayLanes<L>, limit: L::F) -> (L::F, L::M) {
        let (t, valid) = if IS_GLASS { from_either_side(&self.0, ray) } else { from_outside(&self.0, ray) };
        (t, valid & L::lt(t, limit))
    }
}

impl Surface for Ground {
    #[inline(always)]
    fn sphere(&self) -> SphereId {
        self.sphere
    }

    #[inline(always)]
    fn meet_before<L: Lanes>(&self, ray: &RayLanes<L>, limit: L::F) -> (L::F, L::M) {
        let (t, valid) = from_above(self, ray);
        (t, valid & L::lt(t, limit))
    }
}

impl Surface for Enclosure {
    #[inline(always)]
    fn sphere(&self) -> SphereId {
        self.sphere
    }

    #[inline(always)]
    fn meet_before<L: Lanes>(&self, ray: &RayLanes<L>, limit: L::F) -> (L::F, L::M) {
        let t = from_inside(self, ray);
        // False where the distance is NaN.
        (t, L::lt(t, limit))
    }
}

/// As `reference::intersect::from_outside`.
#[inline(always)]
pub(crate) fn from_outside<L: Lanes>(ball: &BallShape, ray: &RayLanes<L>) -> (L::F, L::M) {
    let zero = L::f(0.0);
    let (b, power, discriminant) = chord(ball, ray);
    let valid = L::lt(b, zero) & L::le(zero, discriminant);
    let counts = L::lt(zero, power) & !L::eq(ray.leaves, L::u(ball.sphere));
    let power = L::select(counts, power, zero);
    (power / (L::sqrt(discriminant) - b), valid)
}

/// As `reference::intersect::from_either_side`.
#[inline(always)]
pub(crate) fn from_either_side<L: Lanes>(ball: &BallShape, ray: &RayLanes<L>) -> (L::F, L::M) {
    let zero = L::f(0.0);
    let (b, power, discriminant) = chord(ball, ray);
    let power = L::select(L::eq(ray.leaves, L::u(ball.sphere)), zero, power);
    let q = L::abs(b) + L::sqrt(discriminant);
    let leaving = L::lt(zero, b);
    let ratio = L::select(leaving, -power, power) / q;
    let t = L::select(leaving | L::lt(zero, power), ratio, q);
    (t, L::lt(zero, t))
}

/// As `reference::intersect::from_above`.
#[inline(always)]
pub(crate) fn from_above<L: Lanes>(ground: &Ground, ray: &RayLanes<L>) -> (L::F, L::M) {
    let zero = L::f(0.0);
    let (offset, twice_offset) = (V3::splat(ground.offset), V3::splat(ground.twice_offset));
    let g = ray.origin - V3::splat(ground.anchor);
    let along = g.dot(ray.direction);
    let nearest = g - ray.direction.scale(along);
    let b = offset.dot(ray.direction);
    let nearest_power = nearest.dot(nearest + twice_offset);
    let discriminant = b * b - nearest_power;
    let valid = L::lt(along + b, zero) & L::le(zero, discriminant);
    let root = L::sqrt(discriminant);
    let t = L::select(L::lt(b, zero), nearest_power / (root - b), -b - root) - along;
    let is_above = L::lt(zero, power(ground, ray.origin)) & !L::eq(ray.leaves, L::u(ground.sphere));
    (L::select(is_above & L::lt(zero, t), t, zero), valid)
}

/// As `scene::still::Ground::power`.
#[inline(always)]
pub(crate) fn power<L: Lanes>(ground: &Ground, point: V3<L>) -> L::F {
    let from_anchor = point - V3::splat(ground.anchor);
    from_anchor.dot(from_anchor + V3::splat(ground.twice_offset))
}

/// As `reference::intersect::from_inside`.
#[inline(always)]
pub(crate) fn from_inside<L: Lanes>(e: &Enclosure, ray: &RayLanes<L>) -> L::F {
    let zero = L::f(0.0);
    let g = ray.origin - V3::splat(e.anchor);
    let b = (g + V3::splat(e.offset)).dot(ray.direction);
    let power = g.dot(g + V3::splat(e.twice_offset)) + L::f(e.power);
    let counts = L::lt(power, zero) & !L::eq(ray.leaves, L::u(e.sphere));
    let power = L::select(counts, power, zero);
    let q = L::abs(b) + L::sqrt(b * b - power);
    L::select(L::lt(zero, b), -power / q, q)
}

/// As `from_outside` where the ball is solid and `from_either_side` where it is glass, for a ball per lane. The two share
/// root, quotient and power but for signs.
#[inline(always)]
pub(crate) fn meet<L: Lanes>(
    origin: V3<L>,
    direction: V3<L>,
    leaves: L::M,
    center: V3<L>,
    radius_squared: L::F,
    is_glass: L::M,
) -> (L::F, L::M) {
    let zero = L::f(0.0);
    let f = origin - center;
    let b = f.dot(direction);
    let nearest = f - direction.scale(b);
    let discriminant = radius_squared - nearest.dot(nearest);
    let in_reach = L::le(zero, discriminant);
    let plausible = in_reach & (is_glass | L::lt(b, zero));
    if !L::any(plausible) {
        return (zero, plausible);
    }
    let power = L::select(leaves, zero, f.dot(f) - radius_squared);
    let (is_outside, is_leaving) = (L::lt(zero, power), L::lt(zero, b));
    let power = L::select(is_outside | is_glass, power, zero);
    let q = L::abs(b) + L::sqrt(discriminant);
    let ratio = L::select(is_leaving, -power, power) / q;
    let t = L::select(is_glass & !is_leaving & !is_outside, q, ratio);
    (t, plausible & (!is_glass | L::lt(zero, t)))
}

/// As `reference::intersect::Chord`.
#[inline(always)]
fn chord<L: Lanes>(ball: &BallShape, ray: &RayLanes<L>) -> (L::F, L::F, L::F) {
    let f = ray.origin - V3::splat(ball.center);
    let b = f.dot(ray.direction);
    let radius_squared = L::f(ball.radius_squared);
    let nearest = f - ray.direction.scale(b);
    (b, f.dot(f) - radius_squared, radius_squared - nearest.dot(nearest))
}
