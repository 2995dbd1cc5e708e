//! Which light to sample from a point: by what each may send there.
//!
//! Lamps are divided into two parts again and again ([`LightTree`]); one uniform number leads from all of them to one,
//! and at each pair says which half by what both are thought to send to the point:
//!
//! `intensity / max(d^2, r^2) * max(z, (z + r) / 2) / max(d, r)`
//!
//! where r is the radius of a ball around the lamps, d the distance of its centre, and z its height above the tangent
//! plane. For a lamp in full view that is its irradiance but for shadows. For a ball half below the horizon it is a
//! guess, and it is 0 where all of the ball is below: nothing is wasted there, and nothing that can be lit is left out.
//!
//! Rooms, which light all points alike, stand against all lamps together. What the lamps send is then a rough guess, so
//! neither gets less than [`LEAST`].

use scene::light_tree::{IS_LIGHT, LightNode, LightTree};
use scene::ray::SphereId;
use scene::{Still, Vec3};

/// The least probability of the rooms together and of the lamps together, where both may send light.
pub const LEAST: f32 = 0.125;

/// What heights are raised by, relative to the distance, so that no rounding puts a lamp below the horizon whose shadow
/// rays still rise above it: 16 roundings.
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

/// A light, and how likely it was to be chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The index into [`scene::still::Lights::entries`].
    pub light: u32,
    /// With which probability.
    pub probability: f32,
}

/// What the lamps of `node` are thought to send to `receiver`.
pub fn importance(node: &LightNode, receiver: &Receiver) -> f32 {
    let to_center = node.center - receiver.point;
    let (d2, r2) = (to_center.dot(to_center), node.radius * node.radius);
    let d2 = if d2 > r2 { d2 } else { r2 };
    let d = d2.sqrt();
    let z = receiver.normal.dot(to_center);
    let half_risen = 0.5 * (z + (node.radius + d * RAISED));
    let height = if z > half_risen { z } else { half_risen };
    if height > 0.0 { node.intensity / d2 * (height / d) } else { 0.0 }
}

/// The light that `u` in [0, 1) chooses for `receiver`; `None` if nothing is thought to send any light there.
pub fn choose(still: &Still, receiver: &Receiver, u: f32) -> Option<Choice> {
    let lights = &still.lights;
    if lights.entries.len() < 2 {
        return lights.entries.first().map(|_| Choice { light: 0, probability: 1.0 });
    }
    let tree = &lights.tree;
    let rooms = room_probability(tree, receiver)?;
    if u < rooms {
        let u = rescaled(u, rooms);
        let room = tree.rooms.iter().find(|room| u < room.cumulative).or(tree.rooms.last())?;
        return Some(Choice { light: room.light, probability: rooms * room.share });
    }
    let (mut u, mut probability) = (rescaled(u - rooms, 1.0 - rooms), 1.0 - rooms);
    let mut pair = 0;
    loop {
        let first = first_probability(tree, pair, receiver)?;
        let takes_first = u < first;
        let taken = if takes_first { first } else { 1.0 - first };
        u = rescaled(if takes_first { u } else { u - first }, taken);
        probability *= taken;
        let node = &tree.pairs[pair as usize][usize::from(!takes_first)];
        if node.link & IS_LIGHT != 0 {
            let light = side_towards(still, node.link & !IS_LIGHT, receiver);
            return Some(Choice { light, probability });
        }
        pair = node.link;
    }
}

/// The probability that [`choose`] gives for `light`, an index into [`scene::still::Lights::entries`]: the same
/// product, along the way that the tree notes for it. For one side of a glowing glass ball, that of the side which it
/// turns to the receiver.
pub fn probability(still: &Still, receiver: &Receiver, light: u32) -> f32 {
    let tree = &still.lights.tree;
    if still.lights.entries.len() < 2 {
        return 1.0;
    }
    let Some(rooms) = room_probability(tree, receiver) else {
        return 0.0;
    };
    if let Some(room) = tree.rooms.iter().find(|room| room.light == light) {
        return rooms * room.share;
    }
    let path = tree.paths[light as usize];
    let (mut probability, mut pair) = (1.0 - rooms, 0);
    for level in 0..path.levels {
        let Some(first) = first_probability(tree, pair, receiver) else {
            return 0.0;
        };
        let side = (path.bits >> level) & 1;
        probability *= if side == 0 { first } else { 1.0 - first };
        pair = tree.pairs[pair as usize][side as usize].link;
    }
    probability
}

/// How likely a room is chosen; `None` if there is nothing to choose.
fn room_probability(tree: &LightTree, receiver: &Receiver) -> Option<f32> {
    let lamps = tree.pairs.first().map_or(0.0, |[a, b]| importance(a, receiver) + importance(b, receiver));
    let all = tree.room_irradiance + lamps;
    (all > 0.0).then(|| {
        let rooms = tree.room_irradiance / all;
        let at_least = if tree.room_irradiance > 0.0 && rooms < LEAST { LEAST } else { rooms };
        if lamps > 0.0 && at_least > 1.0 - LEAST { 1.0 - LEAST } else { at_least }
    })
}

/// How likely the first node of a pair is chosen of the two; `None` if neither sends anything.
fn first_probability(tree: &LightTree, pair: u32, receiver: &Receiver) -> Option<f32> {
    let [a, b] = tree.pairs[pair as usize].map(|node| importance(&node, receiver));
    let both = a + b;
    (both > 0.0).then(|| a / both)
}

/// What is left of a uniform number after it has decided something of this probability.
fn rescaled(rest: f32, probability: f32) -> f32 {
    let u = rest / probability;
    if u < BELOW_ONE { u } else { BELOW_ONE }
}

/// The side of lamp `light` that the receiver sees: of glass both glow, and the inner one is seen from within.
fn side_towards(still: &Still, light: u32, receiver: &Receiver) -> u32 {
    let entry = &still.lights.entries[light as usize];
    let sphere = &still.spheres[entry.sphere as usize];
    let from_center = receiver.point - sphere.center;
    let is_within = from_center.dot(from_center) < sphere.radius * sphere.radius;
    let is_glass = !still.material(entry.sphere).is_opaque();
    light + u32::from(is_glass && is_within)
}
