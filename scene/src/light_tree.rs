//! A hierarchy over the lamps, by which direct light is chosen for the point that receives it.
//!
//! After Conty Estevez and Kulla, "Importance sampling of many lights with adaptive tree splitting" (2018), as pbrt-v4 has
//! it. Lamps are spheres and shine to all sides, so nodes need no cones of normals. What a node is thought to send to a
//! point is left to the engines (`reference::light_choice`); here is what it is computed from. Glowing enclosures, the
//! sky above all, are in no node: they light every point alike, and are [`Room`]s.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Most levels of the tree: the way to a lamp fits the bits of a `u32`.
pub const MAX_LEVELS: u32 = 32;

/// What [`LightNode::link`] has set if it leads to a light.
pub const IS_LIGHT: u32 = 1 << 31;

/// Slabs that the centres of lamps are sorted into where a node is split.
const SLABS: usize = 16;

/// What radii of nodes are widened by: some roundings of `f32`.
const WIDENED: f64 = 1.0 + 1e-6;

/// The least squared radius of a node over that of the root. Keeps importances finite at the centre of a tiny lamp.
const LEAST_SQUARED_RADIUS: f64 = 1e-24;

/// Lamps that stand together, or one of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightNode {
    /// Centre of a ball around them.
    pub center: Vec3,
    /// Radius of that ball.
    pub radius: f32,
    /// The irradiance, far away, times the square of the distance; in the unit of
    /// [`LightTree::room_irradiance`].
    pub intensity: f32,
    /// Which pair of nodes these lamps are divided into, or with [`IS_LIGHT`] which light this is. Of a lamp of glass,
    /// both sides of which glow, the outer one; the inner is the next.
    pub link: u32,
}

/// A light that lights every point alike: a glowing enclosure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Which light this is.
    pub light: u32,
    /// The share of all rooms up to and including this one.
    pub cumulative: f32,
    /// Its own share.
    pub share: f32,
}

/// The way from the root to a lamp: bit k is set if it goes to the second node of the pair at level k.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Path {
    /// The bits.
    pub bits: u32,
    /// How many of them count.
    pub levels: u32,
}

/// The hierarchy. A scene with one light has an empty one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTree {
    /// Nodes in pairs; the lamps of the first pair are all that there are. Empty if there are none.
    pub pairs: Vec<[LightNode; 2]>,
    /// The glowing enclosures.
    pub rooms: Vec<Room>,
    /// The irradiance by all rooms together, in a unit of the tree's own.
    pub room_irradiance: f32,
    /// For every light that is in the tree the way to it; of no level for rooms.
    pub paths: Vec<Path>,
}

/// A lamp to be put into the tree.
#[derive(Clone, Copy)]
pub(crate) struct Lamp {
    /// Which light this is.
    pub(crate) light: u32,
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    /// Its share of the power of all lights.
    pub(crate) power: f64,
}

impl LightTree {
    /// The tree over `lamps` and rooms, each with its light and radiance. There are `lights` lights in all, of power
    /// `power`.
    pub(crate) fn new(lights: usize, mut lamps: Vec<Lamp>, rooms: &[(u32, f64)], power: f64) -> Self {
        let mut tree = Self { paths: vec![Path::default(); lights], ..Self::default() };
        if lights < 2 {
            return tree;
        }
        let extent = if lamps.is_empty() { 1.0 } else { Ball::around(&lamps).radius };
        match lamps[..] {
            [] => {}
            [lamp] => {
                tree.pairs.push([node(&lamps, IS_LIGHT | lamp.light, extent), LightNode::default()]);
                tree.paths[lamp.light as usize] = Path { bits: 0, levels: 1 };
            }
            _ => tree.add_pair(&mut lamps, Path::default(), extent),
        }
        tree.add_rooms(rooms, PI / power * extent * extent);
        tree
    }

    /// A tree that chooses by power alone, for lights of these probabilities: every light is a room.
    pub fn by_power(probabilities: impl IntoIterator<Item = f32>, cumulative: &[f32]) -> Self {
        let cumulative = cumulative.iter().copied().chain([1.0]);
        let room = |(light, (share, cumulative))| Room { light, cumulative, share };
        let rooms = (0..).zip(probabilities.into_iter().zip(cumulative)).map(room).collect();
        Self { rooms, room_irradiance: 1.0, ..Self::default() }
    }

    /// Adds the pair of nodes that at least two lamps are divided into, and all below it.
    fn add_pair(&mut self, lamps: &mut [Lamp], way: Path, extent: f64) {
        let index = self.pairs.len();
        self.pairs.push([LightNode::default(); 2]);
        let middle = divide(lamps, MAX_LEVELS - 1 - way.levels);
        let (first, second) = lamps.split_at_mut(middle);
        for (side, lamps) in [first, second].into_iter().enumerate() {
            let path = Path { bits: way.bits | (side as u32) << way.levels, levels: way.levels + 1 };
            let link = if let [lamp] = lamps { IS_LIGHT | lamp.light } else { self.pairs.len() as u32 };
            self.pairs[index][side] = node(lamps, link, extent);
            if let [lamp] = lamps {
                self.paths[lamp.light as usize] = path;
            } else {
                self.add_pair(lamps, path, extent);
            }
        }
    }

    /// Adds the rooms; `unit` is the irradiance by a radiance of 1.
    fn add_rooms(&mut self, rooms: &[(u32, f64)], unit: f64) {
        let sum: f64 = rooms.iter().map(|(_, radiance)| radiance).sum();
        let mut cumulative = 0.0;
        for &(light, radiance) in rooms {
            let share = radiance / sum;
            cumulative += share;
            self.rooms.push(Room { light, cumulative: cumulative as f32, share: share as f32 });
        }
        // Where there is nothing else any unit will do.
        self.room_irradiance = if self.pairs.is_empty() { 1.0 } else { (unit * sum) as f32 };
    }
}

/// A ball around lamps.
struct Ball {
    center: DVec3,
    radius: f64,
}

impl Ball {
    fn around(lamps: &[Lamp]) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for lamp in lamps {
            (low, high) = (low.min(lamp.center - lamp.radius), high.max(lamp.center + lamp.radius));
        }
        // Rounded, so that the radius is right about the centre that engines see.
        let center = (0.5 * (low + high)).as_vec3().as_dvec3();
        let reach = |lamp: &Lamp| lamp.center.distance(center) + lamp.radius;
        Self { center, radius: lamps.iter().map(reach).fold(0.0, f64::max) }
    }
}

/// The node of `lamps`; `extent` is the radius of the ball around all lamps, the tree's unit of length.
fn node(lamps: &[Lamp], link: u32, extent: f64) -> LightNode {
    let Ball { center, radius } = Ball::around(lamps);
    let power: f64 = lamps.iter().map(|lamp| lamp.power).sum();
    LightNode {
        center: center.as_vec3(),
        radius: (radius.max(extent * LEAST_SQUARED_RADIUS.sqrt()) * WIDENED) as f32,
        // A lamp of power P, which is 4 pi^2 r^2 times its radiance L, gives pi L r^2 / d^2.
        intensity: (power / (4.0 * PI) * extent * extent) as f32,
        link,
    }
}

/// Sorts lamps into two parts, none empty, that make a good pair, and says where the second begins. Below either there
/// are at most `levels` levels.
fn divide(lamps: &mut [Lamp], levels: u32) -> usize {
    let fits = |count: usize| count > 0 && (count as u64) <= 1_u64 << levels;
    if let Some((axis, from, width, slab)) = best_plane(lamps) {
        let is_first = |lamp: &Lamp| slab_of(lamp.center[axis], from, width) <= slab;
        let count = lamps.iter().filter(|lamp| is_first(lamp)).count();
        if fits(count) && fits(lamps.len() - count) {
            lamps.sort_by_key(|lamp| !is_first(lamp));
            return count;
        }
    }
    let axis = spread(lamps).1.max_position();
    let middle = lamps.len() / 2;
    let key = |a: &Lamp, b: &Lamp| a.center[axis].total_cmp(&b.center[axis]).then(a.light.cmp(&b.light));
    lamps.select_nth_unstable_by(middle, key);
    middle
}

/// The lowest centre and by how much centres spread from there.
fn spread(lamps: &[Lamp]) -> (DVec3, DVec3) {
    let low = lamps.iter().fold(DVec3::INFINITY, |low, lamp| low.min(lamp.center));
    let high = lamps.iter().fold(DVec3::NEG_INFINITY, |high, lamp| high.max(lamp.center));
    (low, high - low)
}

fn slab_of(place: f64, from: f64, width: f64) -> usize {
    ((place - from) / width * SLABS as f64).clamp(0.0, (SLABS - 1) as f64) as usize
}

/// Where to cut for the least sum of power times squared radius: the axis, where slabs begin and how wide all are, and
/// the last slab of the first part.
fn best_plane(lamps: &[Lamp]) -> Option<(usize, f64, f64, usize)> {
    let (low, widths) = spread(lamps);
    let mut best = (f64::INFINITY, None);
    for axis in 0..3 {
        let (from, width) = (low[axis], widths[axis]);
        if width <= 0.0 {
            continue;
        }
        let mut slabs = [Slab::default(); SLABS];
        for lamp in lamps {
            slabs[slab_of(lamp.center[axis], from, width)].add(lamp);
        }
        for slab in 0..SLABS - 1 {
            let join = |part: &[Slab]| part.iter().fold(Slab::default(), |sum, slab| sum.joined(slab)).cost();
            let cost = join(&slabs[..=slab]) + join(&slabs[slab + 1..]);
            if cost < best.0 {
                best = (cost, Some((axis, from, width, slab)));
            }
        }
    }
    best.1
}

/// Lamps of a slab: the box around them, and their power.
#[derive(Clone, Copy)]
struct Slab {
    low: DVec3,
    high: DVec3,
    power: f64,
}

impl Default for Slab {
    fn default() -> Self {
        Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, power: 0.0 }
    }
}

impl Slab {
    fn add(&mut self, lamp: &Lamp) {
        self.low = self.low.min(lamp.center - lamp.radius);
        self.high = self.high.max(lamp.center + lamp.radius);
        self.power += lamp.power;
    }

    fn joined(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            power: self.power + other.power,
        }
    }

    fn cost(&self) -> f64 {
        if self.power > 0.0 { self.power * (self.high - self.low).length_squared() } else { 0.0 }
    }
}
