//! Which balls may meet a given sphere: a hierarchy of bounding boxes, so that the blockers of n lamps are found in
//! n log n.

use crate::ray::SphereId;
use crate::sphere::Sphere;
use glam::DVec3;
use std::ops::ControlFlow;

/// Most balls per leaf.
const LEAF: usize = 8;

/// What boxes are enlarged by, relative to the balls: more than the tolerance within which callers of
/// [`Neighbours::visit`] count spheres as touching.
const ENLARGED: f64 = 1e-4;

/// What boxes and queries are enlarged by, relative to their coordinates: a thousand roundings of `f64`. (What boxes are
/// enlarged by relative to radii is far more.)
const ROUNDING: f64 = 1e-13;

/// A hierarchy over some of a scene's balls.
pub(crate) struct Neighbours {
    /// In preorder: the left child of an inner node comes right after it.
    nodes: Vec<Node>,
    /// The balls, those of each leaf next to each other.
    ids: Vec<SphereId>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    content: Content,
}

enum Content {
    /// A range of [`Neighbours::ids`].
    Leaf { first: usize, end: usize },
    /// The other child.
    Inner { right: usize },
}

impl Neighbours {
    /// The hierarchy over the balls `ids` of `spheres`.
    pub(crate) fn new(spheres: &[Sphere], mut ids: Vec<SphereId>) -> Self {
        let mut nodes = Vec::with_capacity(most_nodes(ids.len()));
        if !ids.is_empty() {
            build(spheres, &mut ids, 0, &mut nodes);
        }
        Self { nodes, ids }
    }

    /// The most bytes that the hierarchy over so many balls takes.
    pub(crate) fn bytes_at_most(balls: usize) -> u64 {
        (most_nodes(balls) * size_of::<Node>() + balls * size_of::<SphereId>()) as u64
    }

    /// Calls `found` for every ball that the surface of `sphere` meets or almost meets, and for some that it does not,
    /// in no particular order, until it breaks off.
    pub(crate) fn visit(
        &self,
        sphere: &Sphere,
        mut found: impl FnMut(SphereId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let center = sphere.center.as_dvec3();
        let radius = f64::from(sphere.radius);
        let slack = ROUNDING * (center.abs().max_element() + radius);
        if self.nodes.is_empty() {
            return ControlFlow::Continue(());
        }
        self.visit_below(0, center, [radius - slack, radius + slack], &mut found)
    }

    /// Calls `found` for every ball of which some point is within `reach` of `place`, and for some others, in no particular
    /// order, until it breaks off.
    pub(crate) fn visit_near(
        &self,
        place: DVec3,
        reach: f64,
        mut found: impl FnMut(SphereId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if self.nodes.is_empty() {
            return ControlFlow::Continue(());
        }
        let slack = ROUNDING * (place.abs().max_element() + reach);
        self.visit_below(0, place, [0.0, reach + slack], &mut found)
    }

    /// As [`Neighbours::visit`], for the balls below node `index` and surfaces between two radii.
    fn visit_below(
        &self,
        index: usize,
        center: DVec3,
        radii: [f64; 2],
        found: &mut impl FnMut(SphereId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let node = &self.nodes[index];
        let nearest = center.clamp(node.low, node.high).distance_squared(center);
        let farthest = (center - node.low).abs().max((center - node.high).abs()).length_squared();
        let [least, most] = radii;
        if nearest > most * most || (least > 0.0 && farthest < least * least) {
            return ControlFlow::Continue(());
        }
        match node.content {
            Content::Leaf { first, end } => self.ids[first..end].iter().try_for_each(|&id| found(id)),
            Content::Inner { right } => {
                self.visit_below(index + 1, center, radii, found)?;
                self.visit_below(right, center, radii, found)
            }
        }
    }
}

/// The most nodes of the hierarchy over so many balls: each leaf but an only one has half of [`LEAF`] at least.
fn most_nodes(balls: usize) -> usize {
    2 * balls.div_ceil(LEAF / 2)
}

/// Adds the node over `ids`, the first of which is at index `first` of all, and those below it.
fn build(spheres: &[Sphere], ids: &mut [SphereId], first: usize, nodes: &mut Vec<Node>) {
    let center = |id: SphereId| spheres[id as usize].center.as_dvec3();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut low_center, mut high_center) = (low, high);
    for &id in &*ids {
        let (c, radius) = (center(id), f64::from(spheres[id as usize].radius));
        let reach = radius * (1.0 + ENLARGED) + ROUNDING * c.abs().max_element();
        (low, high) = (low.min(c - reach), high.max(c + reach));
        (low_center, high_center) = (low_center.min(c), high_center.max(c));
    }
    let index = nodes.len();
    nodes.push(Node { low, high, content: Content::Leaf { first, end: first + ids.len() } });
    if ids.len() <= LEAF {
        return;
    }
    let axis = (high_center - low_center).max_position();
    let middle = ids.len() / 2;
    ids.select_nth_unstable_by(middle, |a, b| center(*a)[axis].total_cmp(&center(*b)[axis]).then(a.cmp(b)));
    let (left, right) = ids.split_at_mut(middle);
    build(spheres, left, first, nodes);
    nodes[index].content = Content::Inner { right: nodes.len() };
    build(spheres, right, first + middle, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb;
    use glam::Vec3;

    fn ball(center: Vec3, radius: f32) -> Sphere {
        Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO }
    }

    /// For any number of balls, nothing is allocated anew while it is built.
    #[test]
    fn nodes_are_no_more_than_are_made_room_for() {
        let place = |k: u32| Vec3::new((k * 37 % 101) as f32, (k * 61 % 89) as f32, k as f32);
        for count in (0..300).chain([1023, 1024, 1025, 4099]) {
            let balls: Vec<Sphere> = (0..count).map(|k| ball(place(k), 1.0)).collect();
            let Neighbours { nodes, ids } = Neighbours::new(&balls, (0..count as SphereId).collect());
            assert!(nodes.len() <= most_nodes(count as usize), "{} for {count}", nodes.len());
            assert!(nodes.capacity() <= most_nodes(count as usize).max(4), "{count}");
            let told = Neighbours::bytes_at_most(count as usize);
            assert_eq!(told, (most_nodes(ids.len()) * size_of::<Node>() + size_of_val(&ids[..])) as u64);
        }
    }

    /// Balls within reach of a place are found, whether they are small or contain it, and few others.
    #[test]
    fn places_find_the_balls_near_them() {
        let mut balls: Vec<Sphere> =
            (0..4096).map(|k| ball(Vec3::new((k % 64) as f32, (k / 64) as f32, 0.0), 0.25)).collect();
        balls.push(ball(Vec3::splat(30.0), 200.0));
        let neighbours = Neighbours::new(&balls, (0..balls.len() as SphereId).collect());
        for (place, reach) in [([10.0, 20.0, 0.0], 1.0), ([31.5, 31.5, 2.0], 3.0), ([0.0; 3], 0.0)] {
            let (place, mut found) = (DVec3::from(place), Vec::new());
            let _ = neighbours.visit_near(place, reach, |id| {
                found.push(id);
                ControlFlow::Continue(())
            });
            for (id, ball) in (0..).zip(&balls) {
                let away = place.distance(ball.center.as_dvec3()) - f64::from(ball.radius);
                assert!(away > reach || found.contains(&id), "{id} near {place}");
            }
            assert!(found.len() < 130, "{} near {place}", found.len());
        }
        let mut calls = 0;
        let end = neighbours.visit_near(DVec3::ZERO, 10.0, |_| {
            calls += 1;
            ControlFlow::Break(())
        });
        assert!(end.is_break() && calls == 1);
    }

    /// Balls on a lattice around `middle`, and surfaces among them: every ball that a surface meets is found, and few others.
    #[test]
    fn surfaces_find_the_balls_that_they_meet_and_few_others() {
        const SIDE: u32 = 24;
        for (middle, radius) in
            [(Vec3::ZERO, 0.3), (Vec3::new(-3e5, 2e5, 1e5), 0.3), (Vec3::splat(700.0), 0.02)]
        {
            let at = |k: u32| {
                let place =
                    [k % SIDE, k / SIDE % SIDE, k / (SIDE * SIDE)].map(|i| i as f32 - SIDE as f32 / 2.0);
                middle + Vec3::from(place)
            };
            let balls: Vec<Sphere> = (0..SIDE.pow(3)).map(|k| ball(at(k), radius)).collect();
            let neighbours = Neighbours::new(&balls, (0..balls.len() as SphereId).collect());
            // Where the surface is, its radius, and how many balls it may find: a fifth more than it did.
            let surfaces = [
                (0.0, 0.5, 8),
                (0.5, 1.0, 100),
                (3.0, 0.7, 42),
                (0.25, 6.0, 1600),
                (11.0, 12.0, 1300),
                (40.0, 28.0, 0),
            ];
            for (aside, surface, most) in surfaces {
                let sphere = ball(middle + Vec3::new(aside, aside * 0.5, -aside), surface);
                let mut found = Vec::new();
                let visited = neighbours.visit(&sphere, |id| {
                    found.push(id);
                    ControlFlow::Continue(())
                });
                assert!(visited.is_continue());
                let meets = |ball: &Sphere| {
                    let apart = ball.center.as_dvec3().distance(sphere.center.as_dvec3());
                    (apart - f64::from(surface)).abs() <= f64::from(ball.radius)
                };
                let expected: Vec<SphereId> =
                    (0..).zip(&balls).filter(|(_, ball)| meets(ball)).map(|(id, _)| id).collect();
                assert!(expected.iter().all(|id| found.contains(id)), "{middle} {aside} {surface}");
                assert!(
                    found.len() <= most,
                    "{} for {} at {middle} {aside} {surface}",
                    found.len(),
                    expected.len()
                );
            }
            let mut few = 0;
            let broken = neighbours.visit(&ball(middle, 6.0), |_| {
                few += 1;
                if few == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            assert_eq!((broken, few), (ControlFlow::Break(()), 3));
        }
    }
}
