//! The choice of a light for a point: by what each may send there.
//!
//! Lamps are divided into two parts again and again ([`LightTree`]). One uniform number leads from all of them to one:
//! at each pair of nodes it chooses one of the two in proportion to their [`importance`]. Ambient lights, which light all
//! points alike, stand against all lamps together.
//!
//! Estimates may be wrong, and nothing is known of shadows. So no side of a choice that has any importance gets less than
//! a least probability, [`LEAST`] or [`LEAST_AMBIENT`].

use scene::light_tree::{IS_LIGHT, LightNode, LightTree};
use scene::ray::SphereId;
use scene::{Still, Vec3};

/// The least probability of a node of a pair: large enough to find lamps behind brighter ones that are hidden, and small
/// enough that twenty levels waste at most one choice in fifty.
pub const LEAST: f32 = 1.0 / 1024.0;

/// The least probability of all ambient lights together, and of all lamps together. The importance of all lamps at once
/// is a rough estimate.
pub const LEAST_AMBIENT: f32 = 0.125;

/// What a lamp's height is raised by, relative to its distance, so that rounding puts no lamp below the horizon that
/// shadow rays still reach: 16 roundings.
const RAISED: f32 = 1.0 / 1_048_576.0;

/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A point to be lit.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point, on sphere `sphere`.
    pub point: Vec3,
    /// Unit normal of the side to be lit.
    pub normal: Vec3,
    /// The sphere that the point lies on.
    pub sphere: SphereId,
}

/// A light that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The index into [`scene::still::Lights::entries`].
    pub light: u32,
    /// The probability of this choice, above 0.
    pub probability: f32,
}

/// An estimate of the irradiance that the lamps of `node` would give `receiver` if nothing were in between, in the unit
/// of [`LightTree::ambient_irradiance`]: `intensity / d^2 * z / d`, where d is the distance of the node's centre and z
/// its height above the tangent plane. For a single lamp above the horizon this is exact.
///
/// Within the node's ball, of radius r, d is replaced by r. Where the ball meets the horizon, z is replaced by
/// `(z + r) / 2`, half the height of its highest point; so the estimate is 0 only if no light can arrive.
pub fn importance(node: &LightNode, receiver: &Receiver) -> f32 {
    let to_center = node.center - receiver.point;
    let (d2, r2) = (to_center.dot(to_center), node.radius * node.radius);
    let d2 = if d2 > r2 { d2 } else { r2 };
    let d = d2.sqrt();
    let z = receiver.normal.dot(to_center);
    let half_top = 0.5 * (z + (node.radius + d * RAISED));
    let height = if z > half_top { z } else { half_top };
    if height > 0.0 { node.intensity / d2 * (height / d) } else { 0.0 }
}

/// The light that `u` in [0, 1) chooses for `receiver`; `None` if no light can arrive from where `u` leads.
pub fn choose(still: &Still, receiver: &Receiver, u: f32) -> Option<Choice> {
    let lights = &still.lights;
    if lights.entries.len() < 2 {
        return lights.entries.first().map(|_| Choice { light: 0, probability: 1.0 });
    }
    let tree = &lights.tree;
    let (mut u, mut probability) = (u, 1.0);
    if decide(&mut u, &mut probability, ambient_probability(tree, receiver)?) {
        let chosen = tree.ambient.iter().find(|ambient| u < ambient.cumulative).or(tree.ambient.last())?;
        return Some(Choice { light: chosen.light, probability: probability * chosen.share });
    }
    let mut pair = tree.pairs.first()?;
    loop {
        let takes_first = decide(&mut u, &mut probability, first_probability(pair, receiver)?);
        let node = &pair[usize::from(!takes_first)];
        if node.link & IS_LIGHT != 0 {
            let light = side_towards(still, node.link & !IS_LIGHT, receiver);
            return (probability > 0.0).then_some(Choice { light, probability });
        }
        pair = &tree.pairs[node.link as usize];
    }
}

/// The probability that [`choose`] takes an ambient light; `None` if no light can arrive.
pub fn ambient_probability(tree: &LightTree, receiver: &Receiver) -> Option<f32> {
    let lamps = tree.pairs.first().map_or(0.0, |[a, b]| importance(a, receiver) + importance(b, receiver));
    share(tree.ambient_irradiance, lamps, LEAST_AMBIENT)
}

/// The probability that [`choose`], once it has come to a pair of nodes, takes the first; `None` if no light can arrive
/// from either.
pub fn first_probability(pair: &[LightNode; 2], receiver: &Receiver) -> Option<f32> {
    share(importance(&pair[0], receiver), importance(&pair[1], receiver), LEAST)
}

/// The probability of the first of two sides that matter `a` and `b`, at least `least` for each that matters at all;
/// `None` if neither does.
fn share(a: f32, b: f32, least: f32) -> Option<f32> {
    let both = a + b;
    let share = a / both;
    let is_low = a > 0.0 && share < least;
    let is_high = b > 0.0 && share > 1.0 - least;
    let share = if is_low { least } else { share };
    (both > 0.0).then_some(if is_high { 1.0 - least } else { share })
}

/// True with probability `p`, as `u` decides, which is then uniform again. Multiplies `probability` by that of the
/// outcome.
fn decide(u: &mut f32, probability: &mut f32, p: f32) -> bool {
    let outcome = *u < p;
    let (rest, of_outcome) = if outcome { (*u, p) } else { (*u - p, 1.0 - p) };
    let rescaled = rest / of_outcome;
    *u = if rescaled < BELOW_ONE { rescaled } else { BELOW_ONE };
    *probability *= of_outcome;
    outcome
}

/// The side of lamp `light` that `receiver` sees: of glass both sides glow, and the inner one is seen from within.
fn side_towards(still: &Still, light: u32, receiver: &Receiver) -> u32 {
    let entry = &still.lights.entries[light as usize];
    let sphere = &still.spheres[entry.sphere as usize];
    let to_center = sphere.center - receiver.point;
    let is_within = to_center.dot(to_center) < sphere.radius * sphere.radius;
    let is_glass = !still.material(entry.sphere).is_opaque();
    light + u32::from(is_glass && is_within)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_in_proportion_and_none_is_too_small() {
        assert_eq!(share(0.0, 0.0, LEAST), None);
        assert_eq!([share(1.0, 3.0, LEAST), share(3.0, 1.0, LEAST)], [Some(0.25), Some(0.75)]);
        // What does not matter at all gets nothing.
        assert_eq!([share(0.0, 1.0, LEAST), share(1.0, 0.0, LEAST)], [Some(0.0), Some(1.0)]);
        assert_eq!([share(1.0, 1e6, LEAST), share(1e6, 1.0, LEAST)], [Some(LEAST), Some(1.0 - LEAST)]);
        assert_eq!([share(1.0, 7.0, 0.125), share(7.0, 1.0, 0.125)], [Some(0.125), Some(0.875)]);
        assert_eq!([share(1.0, 8.0, 0.125), share(8.0, 1.0, 0.125)], [Some(0.125), Some(0.875)]);
    }

    /// After a decision the number is as uniform as before, and below 1.
    #[test]
    fn a_number_decides_again_and_again() {
        let after = |u: f32, p: f32| {
            let (mut u, mut probability) = (u, 0.5);
            (decide(&mut u, &mut probability, p), u, probability)
        };
        assert_eq!(after(0.125, 0.25), (true, 0.5, 0.125));
        assert_eq!(after(0.25, 0.25), (false, 0.0, 0.375));
        assert_eq!(after(0.625, 0.25), (false, 0.5, 0.375));
        let below = 0.3_f32.next_down();
        assert_eq!(after(below, 0.3), (true, (below / 0.3).min(BELOW_ONE), 0.15));
        assert!(after(BELOW_ONE, 1e-7).1 < 1.0);
    }

    fn node(center: Vec3, radius: f32) -> LightNode {
        LightNode { center, radius, intensity: 2.0, link: IS_LIGHT }
    }

    /// The intensity over the square of the distance, times the cosine; within the ball and at the horizon not more than that of
    /// its rim.
    #[test]
    fn importance_is_irradiance_from_the_middle() {
        let receiver = Receiver { point: Vec3::ZERO, normal: Vec3::Z, sphere: 0 };
        let of = |center, radius| importance(&node(center, radius), &receiver);
        assert_eq!(of(Vec3::Z * 4.0, 1.0), 2.0 / 16.0);
        let oblique = of(Vec3::new(4.0, 0.0, 3.0), 1.0);
        assert!((oblique - 2.0 / 25.0 * 0.6).abs() < 1e-7, "{oblique}");
        // Of a ball around the point, the radius counts in place of the distance.
        assert_eq!(of(Vec3::Z, 4.0), 2.0 / 16.0 * (2.5 + 2.0 / 1_048_576.0) / 4.0);
        // In the plane half of it is above; half the height of its top counts.
        let level = of(Vec3::X * 4.0, 1.0);
        assert!((level / (2.0 / 16.0 * 0.125) - 1.0).abs() < 1e-5, "{level}");
        assert_eq!(of(Vec3::new(4.0, 0.0, -1.1), 1.0), 0.0);
        assert!(of(Vec3::new(4.0, 0.0, -0.99), 1.0) > 0.0);
    }

    /// Of a glass lamp, what lies within sees its inner side.
    #[test]
    fn glass_glows_on_the_side_of_the_receiver() {
        let text = |kind: &str| {
            format!(
                "background = [0, 0, 0]\ncamera = {{ eye = [0, 0, 50], direction = [0, 0, -1], vertical_fov_degrees = 40 }}\n\
                 [[sphere]]\ncenter = [5, 0, 0]\nradius = 2\nemission = [1, 1, 1]\nmaterial = {{ type = {kind} }}\n"
            )
        };
        let side = |kind: &str, x: f32| {
            let scene = files::scene_file::parse("lamp.toml", &text(kind)).unwrap();
            let receiver = Receiver { point: Vec3::X * x, normal: Vec3::X, sphere: 0 };
            side_towards(&scene.at(0.0), 0, &receiver)
        };
        let glass = "\"dielectric\", albedo = [1, 1, 1], ior = 1.5";
        assert_eq!([2.9, 3.1, 5.0, 6.9, 7.1].map(|x| side(glass, x)), [0, 1, 1, 1, 0]);
        assert_eq!([2.9, 5.0].map(|x| side("\"diffuse\", albedo = [1, 1, 1]", x)), [0, 0]);
    }
}
