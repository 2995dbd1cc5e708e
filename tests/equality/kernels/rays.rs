//! Generates random spheres and rays for cases in which rounding matters: tangent rays, rays that start on or inside
//! spheres, and rays along axes.

use super::inputs::scene_of;
use crate::placement::{Placement, among_others, around_all, log_uniform, point};
use proptest::prelude::*;
use proptest::sample::Index;
use reference::sampling::{frame, unit};
use scene::ray::NO_SPHERE;
use scene::{Ray, Rgb, Scene, Sphere, Vec3};

/// A scene and rays.
#[derive(Clone, Debug)]
pub(super) struct RayCase {
    pub(super) scene: Scene,
    pub(super) rays: Vec<Ray>,
}

/// A random sphere. Its kind is 0 (diffuse), 1 (mirror) or 2 (glass).
#[derive(Clone, Debug)]
struct BallSpec {
    placement: Placement,
    kind: u32,
    glows: bool,
}

#[derive(Clone, Debug)]
struct RaySpec {
    ball: Index,
    start: Start,
    aim: Aim,
    /// Whether the ray is marked as leaving the ball, if it starts on its surface.
    leaves: bool,
}

#[derive(Clone, Debug)]
enum Start {
    /// In this direction from the centre, at this many radii.
    Around(Vec3, f32),
    At(Vec3),
}

#[derive(Clone, Debug)]
enum Aim {
    /// Past the centre, at a distance of this many radii.
    Past(Vec3, f32),
    Center(Index),
    Any(Vec3),
}

/// Scenes with the given numbers of spheres and rays.
pub(super) fn ray_case(
    spheres: std::ops::RangeInclusive<usize>,
    rays: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = RayCase> {
    let eye = prop_oneof![3 => point(4.0), 1 => point(50.0)];
    let balls = prop::collection::vec(ball(), spheres);
    (eye, balls, prop::collection::vec(ray(), rays)).prop_map(|(eye, balls, rays)| {
        let mut places: Vec<(Vec3, f32)> = Vec::new();
        for ball in &balls {
            places.push(ball.placement.resolve(&places));
        }
        let spheres: Vec<Sphere> = balls
            .iter()
            .zip(&places)
            .map(|(ball, (center, radius))| sphere(ball, *center, *radius))
            .collect();
        let rays = rays.iter().map(|spec| spec.resolve(&places)).collect();
        RayCase { scene: scene_of(spheres, eye), rays }
    })
}

fn sphere(ball: &BallSpec, center: Vec3, radius: f32) -> Sphere {
    let emission = if ball.glows { Rgb::new(1.0, 2.0, 3.0) } else { Rgb::ZERO };
    Sphere { center, velocity: Vec3::ZERO, radius, material: ball.kind, emission }
}

fn ball() -> impl Strategy<Value = BallSpec> {
    let anywhere = (point(20.0), log_uniform(1e-3, 1e5));
    let placement = prop_oneof![
        8 => among_others(),
        2 => around_all(),
        1 => anywhere.prop_map(|(center, radius)| Placement::Loose { center, radius }),
    ];
    (placement, 0..3_u32, any::<bool>()).prop_map(|(placement, kind, glows)| BallSpec {
        placement,
        kind,
        glows,
    })
}

/// Unit vectors: some along an axis, with zeros of both signs, some in a coordinate plane.
fn direction() -> impl Strategy<Value = Vec3> {
    let axis = (0..3_usize, any::<bool>(), any::<bool>()).prop_map(|(axis, negative, negative_zero)| {
        let zero = if negative_zero { -0.0 } else { 0.0 };
        let mut v = Vec3::splat(zero);
        v[axis] = if negative { -1.0 } else { 1.0 };
        v
    });
    let plane = (point(1.0), 0..3_usize).prop_map(|(mut v, axis)| {
        v[axis] = 0.0;
        v.normalize_or(Vec3::Y)
    });
    prop_oneof![1 => axis, 1 => plane, 4 => point(1.0).prop_map(|v| v.normalize_or(Vec3::Z))]
}

/// Numbers within a few hundred floats of 1.
fn close_to_one() -> impl Strategy<Value = f32> {
    prop_oneof![-4..=4_i32, -400..=400_i32].prop_map(|steps| 1.0 + steps as f32 * f32::EPSILON)
}

fn ray() -> impl Strategy<Value = RaySpec> {
    let radii = prop_oneof![
        1 => Just(0.0_f32),
        3 => Just(1.0),
        2 => close_to_one(),
        2 => 0.0..1.0_f32,
        3 => 1.0..4.0_f32,
        1 => log_uniform(1.0, 1e4),
    ];
    let start = prop_oneof![
        4 => (direction(), radii).prop_map(|(d, radii)| Start::Around(d, radii)),
        2 => point(9.0).prop_map(Start::At),
    ];
    let past = prop_oneof![Just(0.0_f32), Just(1.0), close_to_one(), 0.0..1.5_f32];
    let aim = prop_oneof![
        2 => (direction(), past).prop_map(|(twist, radii)| Aim::Past(twist, radii)),
        2 => any::<Index>().prop_map(Aim::Center),
        3 => direction().prop_map(Aim::Any),
    ];
    (any::<Index>(), start, aim, any::<bool>()).prop_map(|(ball, start, aim, leaves)| RaySpec {
        ball,
        start,
        aim,
        leaves,
    })
}

impl RaySpec {
    fn resolve(&self, balls: &[(Vec3, f32)]) -> Ray {
        let nowhere = (Vec3::ZERO, 1.0);
        let pick = |index: &Index| if balls.is_empty() { nowhere } else { *index.get(balls) };
        let (center, radius) = pick(&self.ball);
        let origin = match self.start {
            Start::Around(d, radii) => center + d * (radius * radii),
            Start::At(p) => p,
        };
        let target = match &self.aim {
            Aim::Past(twist, radii) => {
                let to_center = center - origin;
                let axis = if to_center == Vec3::ZERO { *twist } else { unit(to_center) };
                let (s, t) = frame(axis);
                let sideways = s * twist.x + t * twist.y;
                let sideways = if sideways == Vec3::ZERO { s } else { unit(sideways) };
                Some(center + sideways * (radius * radii))
            }
            Aim::Center(other) => Some(pick(other).0),
            Aim::Any(_) => None,
        };
        let direction = match (target, &self.aim) {
            (Some(target), _) if (target - origin).length_squared() > 0.0 => unit(target - origin),
            (_, Aim::Any(direction)) => *direction,
            _ => Vec3::X,
        };
        let is_on = matches!(self.start, Start::Around(_, radii) if (radii - 1.0).abs() < 1e-4);
        let leaves = if self.leaves && is_on && !balls.is_empty() {
            self.ball.index(balls.len()) as u32
        } else {
            NO_SPHERE
        };
        Ray { origin, direction, leaves }
    }
}
