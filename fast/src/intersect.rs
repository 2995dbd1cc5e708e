//! Intersection of rays in lanes with one sphere at a time: `reference::intersect`, operation by operation.

use crate::shapes::{BallShape, Shape};
use lanes::{Lanes, V3};
use scene::ray::NO_SPHERE;
use scene::still::{Enclosure, Ground};

/// Rays in lanes.
#[derive(Clone, Copy)]
pub(crate) struct RayLanes<L: Lanes> {
    pub(crate) origin: V3<L>,
    pub(crate) direction: V3<L>,
    pub(crate) leaves: L::U,
}

/// The nearest hits among some shapes: distance (infinite if none) and sphere ([`NO_SPHERE`] if none).
#[inline(always)]
pub(crate) fn nearest<L: Lanes>(shapes: &[Shape], ray: &RayLanes<L>) -> (L::F, L::U) {
    let (mut t, mut hit) = (L::f(f32::INFINITY), L::u(NO_SPHERE));
    for shape in shapes {
        let (candidate, valid, sphere) = distance(shape, ray);
        let nearer = valid & L::lt(candidate, t);
        t = L::select(nearer, candidate, t);
        hit = L::select_u(nearer, L::u(sphere), hit);
    }
    (t, hit)
}

/// The lanes whose ray hits a shape nearer than `t`, other than the sphere `light`.
#[inline(always)]
pub(crate) fn occluded<L: Lanes>(shapes: &[Shape], ray: &RayLanes<L>, t: L::F, light: L::U) -> L::M {
    let mut blocked = L::first(0);
    for shape in shapes {
        let (candidate, valid, sphere) = distance(shape, ray);
        blocked = blocked | (valid & L::lt(candidate, t) & !L::eq(L::u(sphere), light));
    }
    blocked
}

/// The distance to a shape, whether it is valid (NaN never counts as nearer, valid or not), and the sphere.
#[inline(always)]
fn distance<L: Lanes>(shape: &Shape, ray: &RayLanes<L>) -> (L::F, L::M, u32) {
    match shape {
        Shape::Solid(ball) => {
            let (t, valid) = from_outside(ball, ray);
            (t, valid, ball.sphere)
        }
        Shape::Glass(ball) => {
            let (t, valid) = from_either_side(ball, ray);
            (t, valid, ball.sphere)
        }
        Shape::Ground(ground) => {
            let (t, valid) = from_above(ground, ray);
            (t, valid, ground.sphere)
        }
        Shape::Enclosure(e) => {
            let t = from_inside(e, ray);
            (t, L::le(t, t), e.sphere)
        }
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
