//! Intersects rays with spheres, one sphere at a time: the operations of `reference::intersect` on any lanes.
//!
//! On one lane, branches skip computations that cannot affect the result, as in the paper's scalar stages. On eight
//! lanes everything is computed and blended by masks, as in the paper from stage 4 on.

use crate::tables::{Ball, Shape, Tables, kind, tag};
use crate::vector::{F, M, U, Vector, callable};
use lanes::{Lanes, MOST_LANES};
use scene::ray::NO_SPHERE;
use scene::still::{Enclosure, Ground};

/// Rays.
#[derive(Clone, Copy)]
pub(crate) struct Rays<V: Vector> {
    pub(crate) origin: V,
    pub(crate) direction: V,
    /// The spheres that they leave.
    pub(crate) leaves: U<V>,
}

callable! {
    /// The nearest hits: distance (infinite if none) and sphere (`NO_SPHERE` if none).
    pub(crate) fn nearest<V: Vector>(shapes: &[Shape], rays: &Rays<V>) -> (F<V>, U<V>) {
        let (mut t, mut hit) = (V::L::f(f32::INFINITY), V::L::u(NO_SPHERE));
        for shape in shapes {
            let (candidate, valid, sphere) = distance::<V>(shape, rays);
            let nearer = valid & V::L::lt(candidate, t);
            t = V::L::select(nearer, candidate, t);
            hit = V::L::select_u(nearer, V::L::u(sphere), hit);
        }
        (t, hit)
    }

    /// The lanes of `live` whose ray hits a shape other than the sphere `light` nearer than `t`.
    pub(crate) fn occluded<V: Vector>(
        shapes: &[Shape],
        rays: &Rays<V>,
        t: F<V>,
        light: U<V>,
        live: M<V>,
    ) -> M<V> {
        let mut open = live;
        for shape in shapes {
            let (candidate, valid, sphere) = distance::<V>(shape, rays);
            let blocks = valid & V::L::lt(candidate, t) & !V::L::eq(V::L::u(sphere), light);
            open = open & !blocks;
            if !V::L::any(open) {
                break;
            }
        }
        live & !open
    }

    /// Distances to a shape, which of them are valid, and the shape's sphere. A NaN never counts as a distance.
    fn distance<V: Vector>(shape: &Shape, rays: &Rays<V>) -> (F<V>, M<V>, u32) {
        match shape {
            Shape::Solid(ball) => {
                let (t, valid) = from_outside::<V>(ball, rays);
                (t, valid, ball.sphere)
            }
            Shape::Glass(ball) => {
                let (t, valid) = from_either_side::<V>(ball, rays);
                (t, valid, ball.sphere)
            }
            Shape::Ground(ground) => {
                let (t, valid) = from_above::<V>(ground, rays);
                (t, valid, ground.sphere)
            }
            Shape::Enclosure(e) => {
                let t = from_inside::<V>(e, rays);
                (t, V::L::le(t, t), e.sphere)
            }
        }
    }
}

/// True if a scalar row can skip what follows, as no lane needs it. Vertical rows never skip.
#[inline(always)]
fn is_idle<L: Lanes>(matters: L::M) -> bool {
    L::N == 1 && !L::any(matters)
}

/// As `reference::intersect::from_outside`.
#[inline(always)]
fn from_outside<V: Vector>(ball: &Ball, rays: &Rays<V>) -> (F<V>, M<V>) {
    let zero = V::L::f(0.0);
    let Chord { f, b, discriminant } = Chord::new(ball, rays);
    let valid = V::L::lt(b, zero) & V::L::le(zero, discriminant);
    if is_idle::<V::L>(valid) {
        return (zero, valid);
    }
    let power = f.dot(f) - V::L::f(ball.radius_squared);
    let counts = V::L::lt(zero, power) & !V::L::eq(rays.leaves, V::L::u(ball.sphere));
    let power = V::L::select(counts, power, zero);
    (power / (V::L::sqrt(discriminant) - b), valid)
}

/// As `reference::intersect::from_either_side`.
#[inline(always)]
pub(crate) fn from_either_side<V: Vector>(ball: &Ball, rays: &Rays<V>) -> (F<V>, M<V>) {
    let zero = V::L::f(0.0);
    let Chord { f, b, discriminant } = Chord::new(ball, rays);
    let meets = V::L::le(zero, discriminant);
    if is_idle::<V::L>(meets) {
        return (zero, meets);
    }
    let power = f.dot(f) - V::L::f(ball.radius_squared);
    let power = V::L::select(V::L::eq(rays.leaves, V::L::u(ball.sphere)), zero, power);
    let q = V::L::abs(b) + V::L::sqrt(discriminant);
    let leaving = V::L::lt(zero, b);
    let ratio = V::L::select(leaving, -power, power) / q;
    let t = V::L::select(leaving | V::L::lt(zero, power), ratio, q);
    (t, V::L::lt(zero, t))
}

/// As `reference::intersect::from_above`.
#[inline(always)]
fn from_above<V: Vector>(ground: &Ground, rays: &Rays<V>) -> (F<V>, M<V>) {
    let zero = V::L::f(0.0);
    let (offset, twice_offset) = (V::splat(ground.offset), V::splat(ground.twice_offset));
    let g = rays.origin - V::splat(ground.anchor);
    let along = g.dot(rays.direction);
    let nearest = g - rays.direction.scale(along);
    let b = offset.dot(rays.direction);
    let nearest_power = nearest.dot(nearest + twice_offset);
    let discriminant = b * b - nearest_power;
    let valid = V::L::lt(along + b, zero) & V::L::le(zero, discriminant);
    if is_idle::<V::L>(valid) {
        return (zero, valid);
    }
    let root = V::L::sqrt(discriminant);
    let t = V::L::select(V::L::lt(b, zero), nearest_power / (root - b), -b - root) - along;
    let is_above = V::L::lt(zero, g.dot(g + twice_offset)) & !V::L::eq(rays.leaves, V::L::u(ground.sphere));
    (V::L::select(is_above & V::L::lt(zero, t), t, zero), valid)
}

/// As `reference::intersect::from_inside`.
#[inline(always)]
pub(crate) fn from_inside<V: Vector>(e: &Enclosure, rays: &Rays<V>) -> F<V> {
    let zero = V::L::f(0.0);
    let g = rays.origin - V::splat(e.anchor);
    let b = (g + V::splat(e.offset)).dot(rays.direction);
    let power = g.dot(g + V::splat(e.twice_offset)) + V::L::f(e.power);
    let counts = V::L::lt(power, zero) & !V::L::eq(rays.leaves, V::L::u(e.sphere));
    let power = V::L::select(counts, power, zero);
    let q = V::L::abs(b) + V::L::sqrt(b * b - power);
    V::L::select(V::L::lt(zero, b), -power / q, q)
}

/// As `reference::intersect::Chord`, but without the power, which not every caller needs.
struct Chord<V: Vector> {
    f: V,
    b: F<V>,
    discriminant: F<V>,
}

impl<V: Vector> Chord<V> {
    #[inline(always)]
    fn new(ball: &Ball, rays: &Rays<V>) -> Self {
        let f = rays.origin - V::splat(ball.center);
        let b = f.dot(rays.direction);
        let nearest = f - rays.direction.scale(b);
        Self { f, b, discriminant: V::L::f(ball.radius_squared) - nearest.dot(nearest) }
    }
}

/// The surfaces that rays have hit: point, normal, and the properties of the sphere.
pub(crate) struct Surface<V: Vector> {
    pub(crate) point: V,
    pub(crate) normal: V,
    pub(crate) inside: M<V>,
    pub(crate) albedo: V,
    pub(crate) emission: V,
    pub(crate) ior: F<V>,
    pub(crate) is_diffuse: M<V>,
    pub(crate) is_glass: M<V>,
}

callable! {
    /// The surfaces at distance `t` along the rays, on the spheres `hit` (each a valid id).
    pub(crate) fn surface_at<V: Vector>(
        tables: &Tables,
        rays: &Rays<V>,
        t: F<V>,
        hit: U<V>,
        from_columns: bool,
    ) -> Surface<V> {
        let mut ids = [0; MOST_LANES];
        V::L::store_u(hit, &mut ids);
        let [[ax, ay, az, scale, bx, by, bz, tag], [r, g, b, ior, er, eg, eb, kind]] =
            tables.fetch::<V::L>(&ids, from_columns);
        let (a, tag, kind) = (V::new(ax, ay, az), V::L::bits(tag), V::L::bits(kind));
        let point = rays.origin + rays.direction.scale(t);
        let from_a = point - a;
        let in_shell = V::L::eq(tag & V::L::u(tag::ENCLOSURE), V::L::u(tag::ENCLOSURE));
        let mut surface = Surface {
            point,
            normal: from_a,
            inside: in_shell,
            albedo: V::new(r, g, b),
            emission: V::new(er, eg, eb),
            ior,
            is_diffuse: V::L::eq(kind, V::L::u(kind::DIFFUSE)),
            is_glass: V::L::eq(kind, V::L::u(kind::DIELECTRIC)),
        };
        if V::L::any(in_shell) {
            let normal = (from_a + V::new(bx, by, bz)).scale(scale);
            // Normalised by a Newton step, as in the reference.
            surface.normal = normal.scale(V::L::f(1.5) - V::L::f(0.5) * normal.dot(normal));
        }
        if V::L::any(!in_shell) {
            let mut outward = from_a.scale(V::L::f(1.0) / V::L::sqrt(from_a.dot(from_a)));
            let mut on_ball = a + outward.scale(scale);
            let on_ground = V::L::eq(tag & V::L::u(tag::GROUND), V::L::u(tag::GROUND));
            if V::L::any(on_ground) {
                let (point, normal) = on_to_ground::<V>(from_a, V::new(bx, by, bz), scale);
                on_ball = V::select(on_ground, a + point, on_ball);
                outward = V::select(on_ground, normal, outward);
            }
            let is_glass = V::L::eq(tag & V::L::u(tag::GLASS), V::L::u(tag::GLASS));
            let inside = is_glass & V::L::lt(V::L::f(0.0), outward.dot(rays.direction));
            surface.point = V::select(in_shell, point, on_ball);
            surface.normal = V::select(in_shell, surface.normal, V::select(inside, -outward, outward));
            surface.inside = in_shell | inside;
        }
        surface
    }
}

/// The point on a ground below a point, both from its anchor, and the normal there: as `reference::intersect::surface_at`.
#[inline(always)]
fn on_to_ground<V: Vector>(from_a: V, offset: V, inverse_radius: F<V>) -> (V, V) {
    let outward = (from_a + offset).scale(inverse_radius);
    let height = from_a.dot(from_a + (offset + offset)) * (V::L::f(0.5) * inverse_radius);
    let point = from_a - outward.scale(height);
    let normal = (point + offset).scale(inverse_radius);
    (point, normal.scale(V::L::f(1.5) - V::L::f(0.5) * normal.dot(normal)))
}
