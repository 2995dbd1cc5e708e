//! The hierarchy: which of many balls does each ray of a batch hit?
//!
//! Balls are the spheres that rays meet from outside: solid ones and glass. Few balls are tested one by one like the
//! walls, without a hierarchy; more stand in [`clusters`], many in a [`tree`]. The limits between them are parameters
//! (`Parameters::search`), measured by `benches/intersection.rs`. All searches find the same hits, bit for bit.
//!
//! Every search lowers [`keys`]: integers of distance and sphere, whose minimum is the nearest hit.

mod boxes;
mod candidates;
mod clusters;
mod cull;
mod keys;
mod leaves;
mod top;
mod tree;

use crate::parameters::Parameters;
use crate::paths::{Floats, ROOM, Words};
use crate::rays::{BLOCKED, Rays};
use crate::search::{Search, Work, ball_count};
use candidates::{Candidates, SurfaceRows};
use clusters::{Clusters, Queues};
use keys::{hit_key, key_distance, limit_key};
use lanes::{Lanes, Row};
use leaves::{arranged, balls};
use rayon::prelude::*;
use scene::Still;
use tree::{Tree, Wave};

/// Buffers of a search, kept from batch to batch.
pub(crate) struct SearchBuffers {
    queues: Queues,
    /// Made when a tree is searched first: it is large.
    wave: Option<Box<Wave>>,
    candidates: Candidates,
    /// The [`keys`] of the rays. A new array for each batch would be cleared first.
    keys: Box<[u64; ROOM]>,
    /// Room for the places of shapes, see [`ShapeList`](crate::shape_list::ShapeList).
    pub(crate) places: Box<Words>,
}

impl SearchBuffers {
    pub(crate) fn new() -> Self {
        let (candidates, keys, places) = (Candidates::new(), Box::new([0; ROOM]), Box::new([0; ROOM]));
        Self { queues: Queues::new(), wave: None, candidates, keys, places }
    }

    /// Counted work of all searches with these buffers.
    pub(crate) fn work(&self) -> Work {
        self.candidates.work
    }
}

/// The balls of a still, arranged for one search.
#[derive(Debug)]
pub(crate) enum Hierarchy {
    /// No balls: they are tested one by one, like the walls.
    InTurn,
    /// See [`clusters`].
    Clusters(Clusters),
    /// See [`tree`].
    Tree(Tree),
}

impl Hierarchy {
    /// With the search that is usually fastest for the number of balls.
    pub(crate) fn new(still: &Still) -> Self {
        Self::with_search(still, Parameters::default().search(ball_count(still)))
    }

    /// With the given search.
    pub(crate) fn with_search(still: &Still, search: Search) -> Self {
        let count = if search == Search::InTurn { 0 } else { ball_count(still) };
        if count == 0 {
            return Self::InTurn;
        }
        if search == Search::Clusters {
            Self::Clusters(Clusters::new(balls(still).collect()))
        } else {
            Self::Tree(Tree::new(arranged(still, count)))
        }
    }

    /// The hierarchy that `old` is if it holds the same balls for the same search; else a new one.
    pub(crate) fn reuse(old: Option<Self>, still: &Still, search: Search) -> Self {
        old.filter(|old| old.is_of(still, search)).unwrap_or_else(|| Self::with_search(still, search))
    }

    /// Whether it holds the balls of `still`, and no others, for `search`. Where the squares of two radii are equal the
    /// radii differ by a rounding, for which bounding spheres and boxes have room.
    pub(crate) fn is_of(&self, still: &Still, search: Search) -> bool {
        let (leaves, arranged_for) = match self {
            Self::InTurn => return false,
            Self::Clusters(clusters) => (clusters.leaves(), Search::Clusters),
            Self::Tree(tree) => (tree.leaves(), Search::Tree),
        };
        // Leaves hold no ball twice, so equal counts mean that none is missing.
        let counts = leaves.par_iter().map(|leaf| leaf.count_in(still));
        arranged_for == search && counts.sum::<Option<usize>>() == Some(ball_count(still))
    }

    /// True if this holds the balls; otherwise they must be tested one by one.
    pub(crate) fn holds_balls(&self) -> bool {
        !matches!(self, Self::InTurn)
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::InTurn => 0,
            Self::Clusters(clusters) => clusters.bytes(),
            Self::Tree(tree) => tree.bytes(),
        }
    }

    /// Lowers `t` and `hit`, the nearest hits on anything else, to the nearest hits.
    #[inline(always)]
    pub(crate) fn nearest<L: Lanes>(
        &self,
        surfaces: &[Row],
        rays: &Rays,
        buffers: &mut SearchBuffers,
        t: &mut Floats,
        hit: &mut Words,
    ) {
        if !self.holds_balls() {
            return;
        }
        let SearchBuffers { queues, wave, candidates, keys, .. } = buffers;
        // Slices of one length, so that these loops run in vectors.
        let count = rays.count.min(ROOM);
        for (key, (t, hit)) in keys[..count].iter_mut().zip(t[..count].iter().zip(&hit[..count])) {
            *key = hit_key(*t, *hit);
        }
        match self {
            Self::InTurn => {}
            Self::Clusters(clusters) => {
                clusters.search::<L, false>(&SurfaceRows(surfaces), rays, t, queues, candidates, keys);
            }
            Self::Tree(tree) => {
                tree.search::<L, false>(rays, t, wave.get_or_insert_with(Wave::new), candidates, keys);
            }
        }
        for (key, (t, hit)) in keys[..count].iter().zip(t[..count].iter_mut().zip(&mut hit[..count])) {
            // Where no ball is nearer, the distance stays, even if it is minus zero.
            let is_nearer = *key != hit_key(*t, *hit);
            *t = if is_nearer { key_distance(*key) } else { *t };
            *hit = *key as u32;
        }
    }

    /// Sets `t` to [`BLOCKED`] where the ray hits a ball nearer than `t`.
    #[inline(always)]
    pub(crate) fn occlude<L: Lanes>(
        &self,
        surfaces: &[Row],
        rays: &Rays,
        buffers: &mut SearchBuffers,
        t: &mut Floats,
    ) {
        if !self.holds_balls() {
            return;
        }
        let SearchBuffers { queues, wave, candidates, keys, .. } = buffers;
        let count = rays.count.min(ROOM);
        for (key, t) in keys[..count].iter_mut().zip(&t[..count]) {
            *key = limit_key(*t);
        }
        match self {
            Self::InTurn => {}
            Self::Clusters(clusters) => {
                clusters.search::<L, true>(&SurfaceRows(surfaces), rays, t, queues, candidates, keys);
            }
            Self::Tree(tree) => {
                tree.search::<L, true>(rays, t, wave.get_or_insert_with(Wave::new), candidates, keys);
            }
        }
        for (key, t) in keys[..count].iter().zip(&mut t[..count]) {
            *t = if *key == limit_key(*t) { *t } else { BLOCKED };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::still::Role;
    use scene::{Material, Rgb, Scene, Vec3};

    /// A hierarchy is used again exactly if it holds the same balls.
    #[test]
    fn a_hierarchy_is_of_the_balls_that_it_was_built_for() {
        let scene = files::builtin::scene("random").unwrap();
        let reused_by = |scene: &Scene, search| {
            let old = files::builtin::scene("random").unwrap();
            Hierarchy::with_search(&old.at(0.0), search).is_of(&scene.at(0.0), search)
        };
        let reused = |scene: &Scene| {
            let [clusters, tree] = [Search::Clusters, Search::Tree].map(|search| reused_by(scene, search));
            assert_eq!(clusters, tree);
            tree
        };
        assert!(reused(&scene));
        let ball = ball_of(&scene);
        let changes: [fn(&mut Scene, usize); 5] = [
            |scene, ball| scene.spheres[ball].center.x += 1.0,
            |scene, ball| {
                scene.spheres[ball].material = scene.materials.len() as u32;
                scene.materials.push(Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 });
            },
            |scene, ball| scene.spheres[ball].radius *= 1.5,
            |scene, ball| _ = scene.spheres.remove(ball),
            |scene, ball| scene.spheres.extend_from_within(ball..=ball),
        ];
        for change in changes {
            let mut other = scene.clone();
            change(&mut other, ball);
            assert!(!reused(&other));
        }
        let mut recoloured = scene.clone();
        recoloured.spheres[ball].emission = Rgb::ONE;
        recoloured.camera.eye += Vec3::splat(0.5);
        assert!(reused(&recoloured));
    }

    /// A sphere that is met from outside.
    fn ball_of(scene: &Scene) -> usize {
        let still = scene.at(0.0);
        still.roles.iter().rposition(|role| *role == Role::Solid).unwrap()
    }
}
