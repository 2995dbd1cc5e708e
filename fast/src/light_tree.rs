//! The choice of a light for a point, by what each may send there: `reference::light_choice` over lanes.
//!
//! ```text
//! all lanes: the importance of both nodes of the first pair
//! if there are ambient lights: choose between them and the lamps; lanes that choose an ambient light are done
//! until all lanes are done:
//!     choose a node of the pair; lanes whose node is a lamp are done, and so are those for which neither matters
//!     fetch the node's pair, and compute the importance of both nodes
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. All lanes descend together. Near the root most lanes read the same rows. Lanes that are done read the first pair
//!    again, which is in the cache.
//! 2. The first pair is the same for all lanes: it is broadcast, not fetched. Its importance serves both the choice
//!    between ambient lights and lamps and the first choice of a node. With two lamps nothing is fetched.
//! 3. Without ambient lights their probability is exactly 0, which leaves the random number as it is: nothing is
//!    computed.
//! 4. A scene with one light has no tree.
//! 5. Which side of a lamp of glass a point sees is found with the lamp's row (`LightTable::choose`).

use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::Still;
use scene::light_tree::{AmbientLight, IS_LIGHT, LightNode};

/// As in `reference::light_choice`.
const LEAST: f32 = 1.0 / 1024.0;
/// As in `reference::light_choice`.
const LEAST_AMBIENT: f32 = 0.125;
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

/// The hierarchy over lamps, for lanes to descend.
pub(crate) struct LightTree {
    /// [`NodeRow`]s. Empty if all lights are ambient.
    nodes: Vec<Row>,
    /// The first pair.
    root: [LightNode; 2],
    ambient: Vec<AmbientLight>,
    ambient_irradiance: f32,
}

/// The lights that lanes have chosen.
pub(crate) struct Choice<L: Lanes> {
    /// The lanes that have chosen one.
    pub(crate) found: L::M,
    /// The index of a light, in every lane. For a lamp of glass, its outer side.
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

/// What the choice between nodes needs of them.
#[derive(Clone, Copy)]
struct Weighed<L: Lanes> {
    importance: L::F,
    link: L::U,
}

/// Uniform numbers that decide one thing after another, and the probability of all that they have decided.
struct Decisions<L: Lanes> {
    u: L::F,
    probability: L::F,
}

impl LightTree {
    /// `None` if there is nothing to choose between.
    pub(crate) fn new(still: &Still) -> Option<Self> {
        if still.lights.entries.len() < 2 {
            return None;
        }
        let tree = &still.lights.tree;
        let row = |node: &LightNode| {
            let &LightNode { center, radius, intensity, link } = node;
            bytemuck::cast(NodeRow { center: center.into(), radius, intensity, link, unused: [0; 2] })
        };
        Some(Self {
            nodes: tree.pairs.as_flattened().iter().map(row).collect(),
            root: tree.pairs.first().copied().unwrap_or_default(),
            ambient: tree.ambient.clone(),
            ambient_irradiance: tree.ambient_irradiance,
        })
    }

    /// The lights that `u`, in [0, 1), chooses for the `live` lanes.
    #[inline(always)]
    pub(crate) fn choose<L: Lanes>(&self, live: L::M, point: V3<L>, normal: V3<L>, u: L::F) -> Choice<L> {
        let (zero, none) = (L::f(0.0), L::first(0));
        let mut decisions = Decisions::<L> { u, probability: L::f(1.0) };
        let mut chosen = Choice { found: none, light: L::u(0), probability: L::f(1.0) };
        let mut pair = self.root.map(|node| Weighed { importance: zero, link: L::u(node.link) });
        if !self.nodes.is_empty() {
            pair = self.first(point, normal);
        }
        let mut descends = live;
        if self.ambient_irradiance > 0.0 {
            let lamps = pair[0].importance + pair[1].importance;
            let (matters, p) = share::<L>(L::f(self.ambient_irradiance), lamps, LEAST_AMBIENT);
            let outcome = decisions.decide(p);
            let takes_ambient = live & matters & outcome;
            if L::any(takes_ambient) {
                chosen = self.choose_ambient::<L>(takes_ambient, &decisions);
            }
            descends = live & matters & !outcome;
        }
        while L::any(descends) {
            let (matters, p) = share::<L>(pair[0].importance, pair[1].importance, LEAST);
            descends = descends & matters;
            let takes_first = decisions.decide(p);
            let link = L::select_u(takes_first, pair[0].link, pair[1].link);
            let arrives = descends & L::eq(link & L::u(IS_LIGHT), L::u(IS_LIGHT));
            chosen.light = L::select_u(arrives, link ^ L::u(IS_LIGHT), chosen.light);
            chosen.probability = L::select(arrives, decisions.probability, chosen.probability);
            chosen.found = chosen.found | (arrives & L::lt(zero, decisions.probability));
            descends = descends & !arrives;
            if !L::any(descends) {
                break;
            }
            pair = self.fetch::<L>(L::select_u(descends, link, L::u(0)), point, normal);
        }
        chosen
    }

    /// The first pair.
    #[inline(always)]
    fn first<L: Lanes>(&self, point: V3<L>, normal: V3<L>) -> [Weighed<L>; 2] {
        let first = Nodes::broadcast(&self.root[0]).weigh(point, normal);
        [first, Nodes::broadcast(&self.root[1]).weigh(point, normal)]
    }

    /// The pairs with these numbers. The first node is weighed before the second is fetched, as there are too few registers for
    /// both.
    #[inline(always)]
    fn fetch<L: Lanes>(&self, pair: L::U, point: V3<L>, normal: V3<L>) -> [Weighed<L>; 2] {
        let mut numbers = [0; MOST_LANES];
        L::store_u(pair + pair, &mut numbers);
        let first = Nodes::gather(&self.nodes, &numbers).weigh(point, normal);
        // The second of each pair has the same number among all nodes but the first.
        [first, Nodes::gather(&self.nodes[1..], &numbers).weigh(point, normal)]
    }

    /// One of the ambient lights where `takes_ambient`, of which there is one at least; elsewhere none.
    #[inline(always)]
    fn choose_ambient<L: Lanes>(&self, takes_ambient: L::M, decisions: &Decisions<L>) -> Choice<L> {
        let (mut light, mut share) = (L::u(0), L::f(1.0));
        // Backwards, so that the first whose sum exceeds the number stays; the last does without.
        for (index, ambient) in self.ambient.iter().rev().enumerate() {
            let takes = L::lt(decisions.u, L::f(if index == 0 { 1.0 } else { ambient.cumulative }));
            light = L::select_u(takes, L::u(ambient.light), light);
            share = L::select(takes, L::f(ambient.share), share);
        }
        Choice {
            found: takes_ambient,
            light: L::select_u(takes_ambient, light, L::u(0)),
            probability: L::select(takes_ambient, decisions.probability * share, L::f(1.0)),
        }
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

    #[inline(always)]
    fn weigh(self, point: V3<L>, normal: V3<L>) -> Weighed<L> {
        Weighed { importance: self.importance(point, normal), link: self.link }
    }

    /// As `reference::light_choice::importance`.
    #[inline(always)]
    fn importance(&self, point: V3<L>, normal: V3<L>) -> L::F {
        let zero = L::f(0.0);
        let to_center = self.center - point;
        let d2 = L::max(to_center.dot(to_center), self.radius * self.radius);
        let d = L::sqrt(d2);
        let z = normal.dot(to_center);
        let half_top = L::f(0.5) * (z + (self.radius + d * L::f(RAISED)));
        let height = L::max(z, half_top);
        L::select(L::lt(zero, height), self.intensity / d2 * (height / d), zero)
    }
}

impl<L: Lanes> Decisions<L> {
    /// As `reference::light_choice::decide`.
    #[inline(always)]
    fn decide(&mut self, p: L::F) -> L::M {
        let outcome = L::lt(self.u, p);
        let of_outcome = L::select(outcome, p, L::f(1.0) - p);
        let rest = L::select(outcome, self.u, self.u - p);
        self.u = L::min(rest / of_outcome, L::f(BELOW_ONE));
        self.probability = self.probability * of_outcome;
        outcome
    }
}

/// As `reference::light_choice::share`: the lanes in which either side matters, and the probability of the first.
#[inline(always)]
fn share<L: Lanes>(a: L::F, b: L::F, least: f32) -> (L::M, L::F) {
    let (zero, low, high) = (L::f(0.0), L::f(least), L::f(1.0 - least));
    let both = a + b;
    let share = a / both;
    let is_low = L::lt(zero, a) & L::lt(share, low);
    let is_high = L::lt(zero, b) & L::lt(high, share);
    let share = L::select(is_low, low, share);
    (L::lt(zero, both), L::select(is_high, high, share))
}
