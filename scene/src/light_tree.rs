//! A hierarchy over the lamps, by which direct light is chosen for the point that receives it.
//!
//! After Conty Estevez and Kulla, "Importance sampling of many lights with adaptive tree splitting" (2018), as in
//! pbrt-v4. Lamps are spheres and shine in all directions, so nodes need no cones of normals. How much a node matters to
//! a point is computed by the engines (see `reference::light_choice`); this is what they compute it from. Glowing
//! enclosures, such as the sky, light all points alike. They are in no node, but in a list of their own.

use glam::{DVec3, Vec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Most levels of the tree, so that every descent is short, wherever the lamps are.
pub const MAX_LEVELS: u32 = 32;

/// Set in [`LightNode::link`] if it leads to a light.
pub const IS_LIGHT: u32 = 1 << 31;

/// Slabs that the centres of lamps are sorted into where a node is split.
const SLABS: usize = 16;

/// What radii of nodes are enlarged by: some roundings of `f32`.
const ENLARGED: f64 = 1.0 + 1e-6;

/// The least radius of a node, relative to that of the ball around all lamps. Keeps importances finite at the centre of
/// a tiny lamp.
const LEAST_RADIUS: f64 = 1e-12;

/// The largest [`LightTree::ambient_irradiance`]. Sums with the importance of lamps stay finite.
const MOST_AMBIENT: f64 = 1e37;

/// One or more lamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightNode {
    /// Centre of a ball around them.
    pub center: Vec3,
    /// Radius of that ball.
    pub radius: f32,
    /// Irradiance times squared distance, far away; in the unit of [`LightTree::ambient_irradiance`] and the scene's
    /// unit of length.
    pub intensity: f32,
    /// Index of the pair of nodes that these lamps are divided into. Or, with [`IS_LIGHT`], index of the light; for a
    /// lamp of glass, that of its outer side, which its inner side follows.
    pub link: u32,
}

/// A light that lights all points alike: a glowing enclosure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientLight {
    /// Index of the light.
    pub light: u32,
    /// Its share of the irradiance of all ambient lights.
    pub share: f32,
    /// The sum of the shares up to and including this one.
    pub cumulative: f32,
}

/// The hierarchy. It is empty if the scene has fewer than two lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTree {
    /// Nodes in pairs. The first pair has all lamps; empty if there are none.
    pub pairs: Vec<[LightNode; 2]>,
    /// The lights that are not in the hierarchy.
    pub ambient: Vec<AmbientLight>,
    /// The irradiance by all ambient lights together, in a unit that only the tree uses.
    pub ambient_irradiance: f32,
}

/// A lamp to be put into the tree.
#[derive(Clone, Copy)]
pub(crate) struct Lamp {
    /// Index of the light.
    pub(crate) light: u32,
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    /// In W.
    pub(crate) power: f64,
}

impl LightTree {
    /// The tree over `lamps` and ambient lights; for each of the latter, index and radiance.
    pub(crate) fn new(mut lamps: Vec<Lamp>, ambient: &[(u32, f64)]) -> Self {
        let mut tree = Self::default();
        let unit = Unit::of(&lamps);
        match lamps[..] {
            [] => {}
            [lamp] => {
                let node = node(&lamps, IS_LIGHT | lamp.light, &unit);
                // The other node of the pair sends nothing, and is never chosen.
                tree.pairs.push([node, LightNode { intensity: 0.0, ..node }]);
            }
            _ => tree.add_pair(&mut lamps, MAX_LEVELS, &unit),
        }
        tree.add_ambient(ambient, &unit);
        tree
    }

    /// A tree that chooses by power alone, from the lights' probabilities and the sums of these for all but the last
    /// light: no light is in the hierarchy.
    pub fn by_power(probabilities: impl IntoIterator<Item = f32>, cumulative: &[f32]) -> Self {
        let cumulative = cumulative.iter().copied().chain([1.0]);
        let ambient = (0..).zip(probabilities.into_iter().zip(cumulative));
        let ambient = ambient.map(|(light, (share, cumulative))| AmbientLight { light, share, cumulative });
        Self { ambient: ambient.collect(), ambient_irradiance: 1.0, ..Self::default() }
    }

    /// Leaves out the ambient lights: the choice is among the lamps of the hierarchy.
    pub(crate) fn leave_out_ambient(&mut self) {
        self.ambient.clear();
        self.ambient_irradiance = 0.0;
    }

    /// The lights of the hierarchy in runs of neighbours, at most `most` of them (at least two); of a lamp of glass the
    /// outer side. Neighbouring runs come after each other.
    ///
    /// A run is what is below one node. From the first pair on, the node is divided whose power is spread most, by power
    /// times squared radius: so a lamp far from all others, such as a sun, is a run by itself.
    pub fn runs(&self, most: usize) -> Vec<Vec<u32>> {
        let divided = self.divided(most);
        let (mut runs, mut rest) = (Vec::new(), Vec::new());
        rest.extend(self.pairs.first().map(|pair| (0, pair, false)));
        while let Some((side, pair, is_in_run)) = rest.pop() {
            let link = pair[side].link;
            // The second node of a single lamp's pair repeats the first.
            if side == 0 && link != pair[1].link {
                rest.push((1, pair, is_in_run));
            }
            let is_light = link & IS_LIGHT != 0;
            let begins = !is_in_run && (is_light || !divided[link as usize]);
            if begins {
                runs.push(Vec::new());
            }
            if !is_light {
                rest.push((0, &self.pairs[link as usize], is_in_run || begins));
            } else if let Some(run) = runs.last_mut() {
                run.push(link & !IS_LIGHT);
            }
        }
        runs
    }

    /// Which pairs the nodes above them are divided into, if there are to be `most` parts.
    fn divided(&self, most: usize) -> Vec<bool> {
        let mut divided = vec![false; self.pairs.len()];
        // The bits of floats that are not negative are in the order of the floats.
        let spread = |node: &LightNode| {
            (f64::from(node.intensity) * f64::from(node.radius) * f64::from(node.radius)).to_bits()
        };
        let waiting = |pair: &[LightNode; 2]| {
            pair.map(|node| (node.link & IS_LIGHT == 0).then(|| (spread(&node), Reverse(node.link))))
        };
        let mut nodes: BinaryHeap<_> = self.pairs.first().into_iter().flat_map(waiting).flatten().collect();
        for _ in 2..most {
            let Some((_, Reverse(pair))) = nodes.pop() else { break };
            divided[pair as usize] = true;
            nodes.extend(waiting(&self.pairs[pair as usize]).into_iter().flatten());
        }
        divided
    }

    /// Adds the pair of nodes that at least two lamps are divided into, and all below it: at most `levels` levels.
    fn add_pair(&mut self, lamps: &mut [Lamp], levels: u32, unit: &Unit) {
        let index = self.pairs.len();
        self.pairs.push([LightNode::default(); 2]);
        let middle = divide(lamps, levels - 1);
        let (first, second) = lamps.split_at_mut(middle);
        for (side, lamps) in [first, second].into_iter().enumerate() {
            let link = if let [lamp] = lamps { IS_LIGHT | lamp.light } else { self.pairs.len() as u32 };
            self.pairs[index][side] = node(lamps, link, unit);
            if lamps.len() > 1 {
                self.add_pair(lamps, levels - 1, unit);
            }
        }
    }

    fn add_ambient(&mut self, ambient: &[(u32, f64)], unit: &Unit) {
        let sum: f64 = ambient.iter().map(|(_, radiance)| radiance).sum();
        let mut cumulative = 0.0;
        for &(light, radiance) in ambient {
            let share = radiance / sum;
            cumulative += share;
            self.ambient.push(AmbientLight { light, share: share as f32, cumulative: cumulative as f32 });
        }
        if !ambient.is_empty() {
            let irradiance = unit.intensity(4.0 * PI * PI * sum);
            self.ambient_irradiance = irradiance.clamp(f64::from(f32::MIN_POSITIVE), MOST_AMBIENT) as f32;
        }
    }
}

/// The units of intensities and lengths, which keep both within the range of `f32`.
struct Unit {
    /// The radius of the ball around all lamps.
    extent: f64,
    /// The sum over all lamps, in W.
    power: f64,
}

impl Unit {
    fn of(lamps: &[Lamp]) -> Self {
        match lamps {
            [] => Self { extent: 1.0, power: 1.0 },
            _ => {
                Self { extent: Ball::around(lamps).radius, power: lamps.iter().map(|lamp| lamp.power).sum() }
            }
        }
    }

    /// The intensity of lamps of power `power`. A lamp of radius r and radiance L has the power 4 pi^2 r^2 L, and at a
    /// great distance d it gives the irradiance pi L r^2 / d^2.
    fn intensity(&self, power: f64) -> f64 {
        power / self.power / (4.0 * PI) * self.extent * self.extent
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
        // Rounded first, so that the radius fits the centre that engines read.
        let center = (0.5 * (low + high)).as_vec3().as_dvec3();
        let reach = |lamp: &Lamp| lamp.center.distance(center) + lamp.radius;
        Self { center, radius: lamps.iter().map(reach).fold(0.0, f64::max) }
    }
}

/// The node of `lamps`.
fn node(lamps: &[Lamp], link: u32, unit: &Unit) -> LightNode {
    let Ball { center, radius } = Ball::around(lamps);
    let power = lamps.iter().map(|lamp| lamp.power).sum();
    LightNode {
        center: center.as_vec3(),
        radius: (radius.max(unit.extent * LEAST_RADIUS) * ENLARGED) as f32,
        intensity: unit.intensity(power) as f32,
        link,
    }
}

/// Sorts at least two lamps into two parts, which are not empty and make a good pair. Returns where the second part
/// begins. For each, at most `levels` levels will do.
fn divide(lamps: &mut [Lamp], levels: u32) -> usize {
    let fits = |count: usize| count > 0 && (count as u64) <= 1_u64 << levels;
    if let Some(plane) = best_plane(lamps) {
        let mut before = 0;
        for index in 0..lamps.len() {
            if plane.is_before(&lamps[index]) {
                lamps.swap(index, before);
                before += 1;
            }
        }
        if fits(before) && fits(lamps.len() - before) {
            return before;
        }
    }
    let axis = spread(lamps).1.max_position();
    // Sorted entirely, so that sums over either part are in an order that nothing else decides.
    lamps.sort_unstable_by(|a, b| a.center[axis].total_cmp(&b.center[axis]).then(a.light.cmp(&b.light)));
    lamps.len() / 2
}

/// The least coordinates of centres, and how far centres spread from there.
fn spread(lamps: &[Lamp]) -> (DVec3, DVec3) {
    let low = lamps.iter().fold(DVec3::INFINITY, |low, lamp| low.min(lamp.center));
    let high = lamps.iter().fold(DVec3::NEG_INFINITY, |high, lamp| high.max(lamp.center));
    (low, high - low)
}

/// Slabs of equal width along an axis.
#[derive(Clone, Copy)]
struct Slabs {
    axis: usize,
    from: f64,
    width: f64,
}

impl Slabs {
    /// The slab of a lamp's centre.
    fn of(&self, lamp: &Lamp) -> usize {
        ((lamp.center[self.axis] - self.from) / self.width * SLABS as f64).clamp(0.0, (SLABS - 1) as f64)
            as usize
    }
}

/// A plane between slabs.
struct Plane {
    slabs: Slabs,
    /// The last slab before the plane.
    last: usize,
}

impl Plane {
    fn is_before(&self, lamp: &Lamp) -> bool {
        self.slabs.of(lamp) <= self.last
    }
}

/// The plane for which the sum of power times squared extent is least; `None` if all centres coincide, or for two lamps,
/// which can be divided in one way only.
fn best_plane(lamps: &[Lamp]) -> Option<Plane> {
    if lamps.len() == 2 {
        return None;
    }
    let (low, widths) = spread(lamps);
    let mut best = (f64::INFINITY, None);
    for axis in 0..3 {
        let slabs = Slabs { axis, from: low[axis], width: widths[axis] };
        if slabs.width <= 0.0 {
            continue;
        }
        let mut parts = [Part::EMPTY; SLABS];
        for lamp in lamps {
            let part = &mut parts[slabs.of(lamp)];
            *part = part.joined(&Part::of(lamp));
        }
        // What is behind each slab.
        let mut behind = [Part::EMPTY; SLABS];
        for slab in (1..SLABS).rev() {
            behind[slab - 1] = behind[slab].joined(&parts[slab]);
        }
        let mut before = Part::EMPTY;
        for last in 0..SLABS - 1 {
            before = before.joined(&parts[last]);
            let cost = before.cost() + behind[last].cost();
            if cost < best.0 {
                best = (cost, Some(Plane { slabs, last }));
            }
        }
    }
    best.1
}

/// Some lamps: the box around them, and their power.
#[derive(Clone, Copy)]
struct Part {
    low: DVec3,
    high: DVec3,
    power: f64,
}

impl Part {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, power: 0.0 };

    fn of(lamp: &Lamp) -> Self {
        Self { low: lamp.center - lamp.radius, high: lamp.center + lamp.radius, power: lamp.power }
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lamp((light, (place, radius, power)): (u32, ([f64; 3], f64, f64))) -> Lamp {
        let center = DVec3::from_array(place).as_vec3().as_dvec3();
        Lamp { light, center, radius: f64::from(radius as f32), power }
    }

    /// Checks that each node's ball contains its lamps, that its intensity is theirs, and that at most `levels` levels
    /// follow. Returns the lamps.
    fn check(tree: &LightTree, node: &LightNode, lamps: &[Lamp], levels: u32) -> Vec<u32> {
        let lights = if node.link & IS_LIGHT == 0 {
            assert!(levels > 0, "too many levels");
            let [first, second] = &tree.pairs[node.link as usize];
            let second = check(tree, second, lamps, levels - 1);
            [check(tree, first, lamps, levels - 1), second].concat()
        } else {
            vec![node.link & !IS_LIGHT]
        };
        let unit = Unit::of(lamps);
        let power: f64 = lights.iter().map(|light| lamps[*light as usize].power).sum();
        let off = f64::from(node.intensity) / unit.intensity(power) - 1.0;
        assert!(off.abs() < 1e-6, "the intensity is off by {off}");
        for light in &lights {
            let lamp = &lamps[*light as usize];
            let reach = lamp.center.distance(node.center.as_dvec3()) + lamp.radius;
            assert!(reach <= f64::from(node.radius), "lamp {light} is outside of its node");
        }
        lights
    }

    /// Checks that runs are as many as asked for, and together all `lights` in their order.
    fn check_runs(tree: &LightTree, lights: &[u32]) {
        for most in [2, 3, 10, 64] {
            let runs = tree.runs(most);
            assert_eq!(runs.len(), most.min(lights.len()));
            assert!(runs.iter().all(|run| !run.is_empty()));
            assert_eq!(runs.concat(), lights);
        }
    }

    fn check_tree(lamps: &[Lamp]) {
        let tree = LightTree::new(lamps.to_vec(), &[]);
        let nodes = tree.pairs[0].iter();
        let mut lights: Vec<u32> = nodes.flat_map(|node| check(&tree, node, lamps, MAX_LEVELS - 1)).collect();
        assert_eq!(
            tree.runs(usize::MAX),
            lights.iter().map(|l| vec![*l]).collect::<Vec<_>>(),
            "neighbours in a row"
        );
        check_runs(&tree, &lights);
        lights.sort_unstable();
        assert_eq!(lights, (0..lamps.len() as u32).collect::<Vec<_>>());
        assert_eq!(tree.pairs.len(), lamps.len() - 1);
    }

    proptest! {
        #[test]
        fn every_lamp_is_in_the_tree_once(
            lamps in prop::collection::vec(
                (prop::array::uniform3((-9_i8..9).prop_map(|x| f64::from(x) / 3.0)), 1e-3..1.0, 1e-6..1e6),
                2..200,
            ),
            exponent in -6_i32..9,
        ) {
            let scale = 10_f64.powi(exponent);
            let scaled = |(place, radius, power): ([f64; 3], f64, f64)| (place.map(|x| x * scale), radius * scale, power);
            check_tree(&(0..).zip(lamps.into_iter().map(scaled)).map(lamp).collect::<Vec<_>>());
        }
    }

    /// Of all planes between slabs the one that is chosen leaves the least power times squared extent.
    #[test]
    fn lamps_are_divided_where_it_costs_least() {
        let lamps: Vec<Lamp> = (0..60_u32)
            .map(|light| {
                let part = |step: u32| f64::from(light * step % 61) / 61.0;
                lamp((
                    light,
                    ([9.0 * part(17), part(23).powi(3), 4.0 * part(41)], 0.02, 1.0 + 50.0 * part(7).powi(4)),
                ))
            })
            .collect();
        let cost = |plane: &Plane| {
            let of = |is_before: bool| {
                let side = lamps.iter().filter(|lamp| plane.is_before(lamp) == is_before);
                side.fold(Part::EMPTY, |part, lamp| part.joined(&Part::of(lamp))).cost()
            };
            of(true) + of(false)
        };
        let (low, widths) = spread(&lamps);
        let slabs = [0, 1, 2].map(|axis| Slabs { axis, from: low[axis], width: widths[axis] });
        let planes = slabs.iter().flat_map(|slabs| (0..SLABS - 1).map(|last| Plane { slabs: *slabs, last }));
        let least = planes.map(|plane| cost(&plane)).fold(f64::INFINITY, f64::min);
        let found = cost(&best_plane(&lamps).unwrap());
        assert!((found / least - 1.0).abs() < 1e-9, "{found}, not {least}");
    }

    /// Far away, a lamp of radius r and radiance L gives the irradiance `pi L r^2 / d^2`, and a sky of radiance L `pi L`.
    #[test]
    fn ambient_lights_have_the_unit_of_lamps_and_shares_by_their_radiance() {
        let (r, radiance) = (0.5_f64, 3.0);
        let power = 4.0 * PI * PI * r * r * radiance;
        let lamps = [([0.0; 3], power), ([100.0, 0.0, 0.0], 2.0 * power)];
        let lamps = (0..).zip(lamps).map(|(light, (place, power))| lamp((light, (place, r, power))));
        let skies = [(5, 0.25), (2, 1.0), (9, 0.75)];
        let tree = LightTree::new(lamps.collect(), &skies);
        let of_first = tree.pairs[0].iter().find(|node| node.link == IS_LIGHT).unwrap();
        let share = f64::from(tree.ambient_irradiance) / f64::from(of_first.intensity);
        let exact = 2.0 / (radiance * r * r);
        assert!((share / exact - 1.0).abs() < 1e-6, "{share}, not {exact}");
        let expected = [(5, 0.125, 0.125), (2, 0.5, 0.625), (9, 0.375, 1.0)];
        let expected = expected.map(|(light, share, cumulative)| AmbientLight { light, share, cumulative });
        assert_eq!(tree.ambient, expected);
    }

    /// A sun, two lanterns far from each other, and a hundred lamps close together, which have more power than the lanterns: each
    /// of the former is a run by itself before these are divided at all.
    #[test]
    fn lamps_far_from_others_are_runs_by_themselves() {
        let close = (0..100).map(|k| ([f64::from(k % 10), 0.0, f64::from(k / 10)], 0.1, 1.0));
        let far = [([1e6, 2e6, 0.0], 1e4, 1e9), ([1e3, 0.0, 0.0], 0.1, 1.0), ([1e3, 0.0, 1e3], 0.1, 1.0)];
        let tree = LightTree::new((0..).zip(close.chain(far)).map(lamp).collect(), &[]);
        let mut runs = tree.runs(4);
        runs.sort_unstable_by_key(Vec::len);
        let mut alone = runs[..3].concat();
        alone.sort_unstable();
        assert_eq!(alone, [100, 101, 102]);
        assert_eq!(runs[3].len(), 100);
        assert_eq!(LightTree::default().runs(4), Vec::<Vec<u32>>::new());
    }

    #[test]
    fn trees_are_not_deep_wherever_the_lamps_are() {
        // Lamps at one place; and lamps ever closer to one, so that each plane cuts off a few only.
        let same = (0..5000).map(|light| lamp((light, ([1.0; 3], 0.5, 1.0))));
        check_tree(&same.collect::<Vec<_>>());
        let closer = (0..200).map(|light| {
            let x = 0.6_f64.powi(light as i32);
            lamp((light, ([x, 0.0, 0.0], 1e-3 * x, 1.0)))
        });
        check_tree(&closer.collect::<Vec<_>>());
    }

    /// By power times squared radius, and neither by one alone.
    #[test]
    fn the_node_whose_power_is_spread_most_is_divided_first() {
        let divided = |[a, b]: [(f32, f32); 2]| {
            let node = |(intensity, radius): (f32, f32), link| LightNode {
                center: Vec3::ZERO,
                radius,
                intensity,
                link,
            };
            let light = |light: u32| node((1.0, 1.0), IS_LIGHT | light);
            let pairs = vec![[node(a, 1), node(b, 2)], [light(0), light(1)], [light(2), light(3)]];
            let tree = LightTree { pairs, ..LightTree::default() };
            tree.runs(3)
        };
        let (first, second) = (vec![vec![0], vec![1], vec![2, 3]], vec![vec![0, 1], vec![2], vec![3]]);
        assert_eq!(divided([(10.0, 1.0), (1.0, 4.0)]), second);
        assert_eq!(divided([(10.0, 2.0), (1.0, 5.0)]), first);
        assert_eq!(divided([(10.0, 0.5), (2.0, 1.0)]), first);
        assert_eq!(divided([(1.0, 0.2), (0.9, 0.25)]), second);
        // Of equals the first.
        assert_eq!(divided([(1.0, 2.0), (4.0, 1.0)]), first);
    }

    /// Sums with the importance of lamps stay finite, and a sky that is hardly anything beside them is still something.
    #[test]
    fn the_irradiance_of_ambient_lights_is_a_normal_number() {
        let of = |power: f64, radiance: f64| {
            let lamps = [([0.0; 3], 1.0, power), ([9.0, 0.0, 0.0], 1.0, power)];
            let lamps = (0..).zip(lamps).map(lamp).collect();
            LightTree::new(lamps, &[(2, radiance)]).ambient_irradiance
        };
        assert_eq!(of(1e-30, 1e15), MOST_AMBIENT as f32);
        assert_eq!(of(1e30, 1e-30), f32::MIN_POSITIVE);
    }

    /// Else what is at the centre of a tiny lamp would be infinitely close to it.
    #[test]
    fn nodes_are_no_smaller_than_a_part_of_the_ball_around_all_lamps() {
        let lamps = [([0.0; 3], 1e-30, 1.0), ([1000.0, 0.0, 0.0], 1e-30, 1.0)];
        let tree = LightTree::new((0..).zip(lamps).map(lamp).collect(), &[]);
        for node in tree.pairs[0] {
            assert!((f64::from(node.radius) / 5e-10 - 1.0).abs() < 1e-5, "{node:?}");
        }
    }

    /// Its other node repeats it and sends nothing: it has all of the power of lamps, and is one run.
    #[test]
    fn a_single_lamp_is_a_pair_by_itself() {
        let tree = LightTree::new(vec![lamp((0, ([3.0; 3], 0.5, 2.0)))], &[(1, 1.0)]);
        let [[first, second]] = tree.pairs[..] else { panic!("{} pairs", tree.pairs.len()) };
        assert_eq!((first.link, second), (IS_LIGHT, LightNode { intensity: 0.0, ..first }));
        assert!(first.intensity > 0.0 && tree.ambient_irradiance > 0.0);
        assert_eq!(tree.runs(5), [[0]]);
    }

    #[test]
    fn a_tree_by_power_lists_all_lights_with_their_probabilities() {
        let tree = LightTree::by_power([0.25, 0.5, 0.25], &[0.25, 0.75]);
        let expected = [(0, 0.25, 0.25), (1, 0.5, 0.75), (2, 0.25, 1.0)];
        let expected = expected.map(|(light, share, cumulative)| AmbientLight { light, share, cumulative });
        assert_eq!((&tree.ambient[..], tree.ambient_irradiance), (&expected[..], 1.0));
        assert!(tree.pairs.is_empty());
    }
}
