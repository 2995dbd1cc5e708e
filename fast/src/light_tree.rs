//! Which light to sample from a point, by what each may send there: `reference::light_choice` over lanes.
//!
//! ```text
//! all lanes: what do both nodes of the first pair send?
//! if there are rooms: choose between them and the lamps; the lanes that choose a room are done
//! until all lanes are done, at most MAX_LEVELS times:
//!     choose a node of the pair; the lanes whose node is a lamp are done, and so are those to which neither sends
//!     fetch the node's pair: what do both of its nodes send?
//! the lanes within a glowing ball of glass take its inner side
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. All lanes descend together. Near the root most lanes read the same rows; those that are done read the first pair
//!    again, which is in the cache.
//! 2. The first pair is the same for all lanes: it is broadcast, not fetched, and its sum serves both the choice between
//!    rooms and lamps and the first choice of a node. With two lamps nothing is fetched.
//! 3. Without rooms their probability is exactly 0, which leaves the random number as it is: nothing is computed.
//! 4. A scene with one light has no tree ([`LightTree::new`]), and its direct light divides by no probability.

use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::light_tree::{IS_LIGHT, LightNode, MAX_LEVELS, Room};
use scene::still::Role;
use scene::{Still, Vec3};

/// As `reference::light_choice::LEAST`.
const LEAST: f32 = 0.125;

/// As in `reference::light_choice`.
const RAISED: f32 = 1.0 / 1_048_576.0;

/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A node's row. The two of a pair follow each other.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct NodeRow {
    center: [f32; 3],
    radius: f32,
    intensity: f32,
    link: u32,
    unused: [u32; 2],
}

/// A lamp of glass, of which both sides glow.
struct GlassLamp {
    /// The light that is its outer side; the next is the inner one.
    outer: u32,
    center: Vec3,
    radius_squared: f32,
}

/// The hierarchy over lamps, for lanes to descend.
pub(crate) struct LightTree {
    /// [`NodeRow`]s. Empty if all lights are rooms.
    nodes: Vec<Row>,
    /// The first pair.
    root: [LightNode; 2],
    rooms: Vec<Room>,
    room_irradiance: f32,
    glass: Vec<GlassLamp>,
}

/// The lights that lanes have chosen.
pub(crate) struct Choice<L: Lanes> {
    /// The lanes that have chosen one.
    pub(crate) found: L::M,
    /// The number of a light, in every lane.
    pub(crate) light: L::U,
    pub(crate) probability: L::F,
}

/// Nodes in lanes.
struct Nodes<L: Lanes> {
    center: V3<L>,
    radius: L::F,
    intensity: L::F,
    link: L::U,
}

impl LightTree {
    /// `None` if there is nothing to choose between.
    pub(crate) fn new(still: &Still) -> Option<Self> {
        let lights = &still.lights;
        if lights.entries.len() < 2 {
            return None;
        }
        let row = |node: &LightNode| {
            let &LightNode { center, radius, intensity, link } = node;
            bytemuck::cast(NodeRow { center: center.into(), radius, intensity, link, unused: [0; 2] })
        };
        let outer_sides = (0..).zip(&lights.entries).filter(|(_, light)| !light.inside);
        let glass = outer_sides.filter(|(_, light)| still.roles[light.sphere as usize] == Role::Glass);
        let glass = glass.map(|(outer, light)| {
            let s = &still.spheres[light.sphere as usize];
            GlassLamp { outer, center: s.center, radius_squared: s.radius * s.radius }
        });
        Some(Self {
            nodes: lights.tree.pairs.as_flattened().iter().map(row).collect(),
            root: lights.tree.pairs.first().copied().unwrap_or_default(),
            rooms: lights.tree.rooms.clone(),
            room_irradiance: lights.tree.room_irradiance,
            glass: glass.collect(),
        })
    }

    /// The lights that `u`, in [0, 1), chooses for the `live` lanes.
    #[inline(always)]
    pub(crate) fn choose<L: Lanes>(&self, live: L::M, point: V3<L>, normal: V3<L>, u: L::F) -> Choice<L> {
        let (zero, one) = (L::f(0.0), L::f(1.0));
        let mut pair = [Nodes::<L>::broadcast(&self.root[0]), Nodes::<L>::broadcast(&self.root[1])];
        let mut sent = [zero; 2];
        if !self.nodes.is_empty() {
            sent = [pair[0].importance(point, normal), pair[1].importance(point, normal)];
        }
        let mut u = u;
        let mut chosen = Choice { found: L::first(0), light: L::u(0), probability: one };
        let mut descends = live;
        if self.room_irradiance != 0.0 {
            let (some, rooms) = self.room_probability::<L>(sent[0] + sent[1]);
            let takes_room = live & some & L::lt(u, rooms);
            chosen = self.choose_room::<L>(takes_room, u, rooms);
            descends = live & some & !takes_room;
            u = rescaled::<L>(u - rooms, one - rooms);
        }
        if self.nodes.is_empty() {
            return chosen;
        }
        let is_light = L::u(IS_LIGHT);
        for _ in 0..MAX_LEVELS {
            let both = sent[0] + sent[1];
            descends = descends & L::lt(zero, both);
            let first = sent[0] / both;
            let takes_first = L::lt(u, first);
            let taken = L::select(takes_first, first, one - first);
            u = rescaled::<L>(L::select(takes_first, u, u - first), taken);
            chosen.probability = L::select(descends, chosen.probability * taken, chosen.probability);
            let link = L::select_u(takes_first, pair[0].link, pair[1].link);
            let arrives = descends & L::eq(link & is_light, is_light);
            chosen.light = L::select_u(arrives, link ^ is_light, chosen.light);
            chosen.found = chosen.found | arrives;
            descends = descends & !arrives;
            if !L::any(descends) {
                break;
            }
            pair = self.fetch::<L>(L::select_u(descends, link, L::u(0)));
            sent = [pair[0].importance(point, normal), pair[1].importance(point, normal)];
        }
        for lamp in &self.glass {
            let from_center = point - V3::splat(lamp.center);
            let is_within = L::lt(from_center.dot(from_center), L::f(lamp.radius_squared));
            let is_it = L::eq(chosen.light, L::u(lamp.outer));
            chosen.light = L::add_where(is_it & is_within, chosen.light, L::u(1));
        }
        chosen
    }

    /// The pairs with these numbers.
    #[inline(always)]
    fn fetch<L: Lanes>(&self, pair: L::U) -> [Nodes<L>; 2] {
        let (mut first, mut second) = ([0; MOST_LANES], [0; MOST_LANES]);
        let row = pair + pair;
        L::store_u(row, &mut first);
        L::store_u(row + L::u(1), &mut second);
        [Nodes::gather(&self.nodes, &first), Nodes::gather(&self.nodes, &second)]
    }

    /// Where anything sends light, and how likely a room is chosen there. The lamps send `lamps`.
    #[inline(always)]
    fn room_probability<L: Lanes>(&self, lamps: L::F) -> (L::M, L::F) {
        let (zero, irradiance) = (L::f(0.0), L::f(self.room_irradiance));
        let all = irradiance + lamps;
        let rooms = irradiance / all;
        let (least, most) = (L::f(LEAST), L::f(1.0 - LEAST));
        let is_rare = L::lt(zero, irradiance) & L::lt(rooms, least);
        let at_least = L::select(is_rare, least, rooms);
        let is_frequent = L::lt(zero, lamps) & L::lt(most, at_least);
        (L::lt(zero, all), L::select(is_frequent, most, at_least))
    }

    /// The choice after that for the rooms together, which are as likely as `rooms`: one of them where `takes_room`,
    /// elsewhere none yet.
    #[inline(always)]
    fn choose_room<L: Lanes>(&self, takes_room: L::M, u: L::F, rooms: L::F) -> Choice<L> {
        let mut chosen = Choice { found: takes_room, light: L::u(0), probability: L::f(1.0) - rooms };
        let Some(last) = self.rooms.last() else {
            return chosen;
        };
        if !L::any(takes_room) {
            return chosen;
        }
        let u = rescaled::<L>(u, rooms);
        let (mut light, mut share) = (L::u(last.light), L::f(last.share));
        // Backwards, so that the first whose sum exceeds the number stays.
        for room in self.rooms.iter().rev() {
            let is_before = L::lt(u, L::f(room.cumulative));
            light = L::select_u(is_before, L::u(room.light), light);
            share = L::select(is_before, L::f(room.share), share);
        }
        chosen.light = L::select_u(takes_room, light, chosen.light);
        chosen.probability = L::select(takes_room, rooms * share, chosen.probability);
        chosen
    }
}

impl<L: Lanes> Nodes<L> {
    /// The same node in every lane.
    #[inline(always)]
    fn broadcast(node: &LightNode) -> Self {
        Self {
            center: V3::splat(node.center),
            radius: L::f(node.radius),
            intensity: L::f(node.intensity),
            link: L::u(node.link),
        }
    }

    /// The nodes of these rows.
    #[inline(always)]
    fn gather(nodes: &[Row], rows: &[u32]) -> Self {
        let [cx, cy, cz, radius, intensity, link, _, _] = L::gather_rows(nodes, rows);
        Self { center: V3::new(cx, cy, cz), radius, intensity, link: L::bits(link) }
    }

    /// What the lamps of the nodes are thought to send to the points.
    #[inline(always)]
    fn importance(&self, point: V3<L>, normal: V3<L>) -> L::F {
        let zero = L::f(0.0);
        let to_center = self.center - point;
        let d2 = L::max(to_center.dot(to_center), self.radius * self.radius);
        let d = L::sqrt(d2);
        let z = normal.dot(to_center);
        let half_risen = L::f(0.5) * (z + (self.radius + d * L::f(RAISED)));
        let height = L::max(z, half_risen);
        L::select(L::lt(zero, height), self.intensity / d2 * (height / d), zero)
    }
}

/// What is left of uniform numbers after they have decided something of this probability.
#[inline(always)]
fn rescaled<L: Lanes>(rest: L::F, probability: L::F) -> L::F {
    L::min(rest / probability, L::f(BELOW_ONE))
}
