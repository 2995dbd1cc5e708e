//! The mixture of photons that leave all lamps alike and photons that are aimed: who is drawn from what, and what a photon
//! weighs.

use super::core::Core;
use super::groups::{Group, flux, fluxes, groups};
use super::target::Target;
use super::targets::{Targets, UNIFORM_SHARE};
use super::units::{EXPONENT_STEP, MOST_SCALE_BITS};
use crate::guide::{Departures, GUIDED_BITS, Guide, RUN};
use crate::still::Still;
use glam::Vec3;
use std::sync::Arc;

/// Of the surfaces that a photon meets, those up to this one scatter it towards the [`region`](Aim::region).
pub const AIMED_BOUNCES: u32 = 3;

/// All that aimed emission from the lamps of one instant needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Aim {
    /// The targets of the components from 1 on.
    pub balls: Vec<Target>,
    /// The first photon after those of each component. Empty if nothing is aimed.
    pub ends: Vec<u32>,
    /// What the weight's denominator has of each component, where a line belongs to it.
    pub densities: Vec<f32>,
    /// For each ball, for each group the probability of it or one before, but the last.
    pub cumulative: Vec<Vec<f32>>,
    /// Lamps as they are aimed.
    pub groups: Vec<Group>,
    /// The lights of the groups, in a row.
    pub order: Vec<u32>,
    /// For each place in the order, the share that lights up to it have of their group's power.
    pub within: Vec<f32>,
    /// The ball around the middle of the places where photons should land, to be crossed in any direction: photons that a surface
    /// outside of it scatters go towards it as often as not. `None` if nothing is aimed.
    pub region: Option<Target>,
    /// Where photons of far lamps start.
    pub core: Option<Core>,
    /// Fluxes count in units of `2^-scale_bits` of what they are without aiming.
    pub scale_bits: u32,
    /// How surfaces guide photons; only where nothing is aimed.
    pub guide: Option<Arc<Guide>>,
    /// Directions of guided photons as they leave their lamps; `None` if they leave in all directions alike.
    pub departures: Option<Departures>,
}

impl Aim {
    /// How `photons` of an iteration are aimed from the lamps of `still`.
    pub fn new(still: &Still, targets: &Targets, photons: u32) -> Self {
        if targets.shares.is_empty() || still.lights.entries.is_empty() {
            let guide = targets.guide.clone();
            let departures = guide.as_ref().and_then(|guide| Departures::new(&guide.departures, photons));
            return Self { guide, departures, ..Self::default() };
        }
        let (groups, order) = groups(still);
        let mut aim = Self { balls: targets.balls.clone(), groups, order, ..Self::default() };
        aim.allot(targets, photons);
        let fluxes = fluxes(&aim.balls, &aim.groups);
        let count = |k: usize| f64::from(aim.ends[k] - if k > 0 { aim.ends[k - 1] } else { 0 });
        let density = |k: usize| {
            let flux = if k > 0 { fluxes[k - 1] } else { 1.0 };
            // Nothing to be sent there, where lamps have moved away.
            if flux > 0.0 { count(k) / f64::from(photons) / flux } else { 0.0 }
        };
        aim.densities = (0..aim.ends.len()).map(|k| density(k) as f32).collect();
        aim.cumulative = aim.balls.iter().zip(&fluxes).map(|(ball, sum)| aim.cumulate(ball, *sum)).collect();
        aim.within = aim.cumulate_groups(still);
        aim.region = aim.balls.get(targets.middle).map(|middle| Target::ball(middle.center, middle.radius));
        aim.core = Core::new(still, &aim.balls);
        let most: f64 = aim.densities.iter().map(|&d| f64::from(d)).sum();
        while aim.scale_bits < MOST_SCALE_BITS && most >= (1_u128 << (aim.scale_bits + EXPONENT_STEP)) as f64
        {
            aim.scale_bits += 1;
        }
        aim
    }

    /// Gives each component a run of the photons, so that each has its own run of Sobol points.
    fn allot(&mut self, targets: &Targets, photons: u32) {
        // However few there are, some leave all lamps alike.
        let least = ((f64::from(photons) * UNIFORM_SHARE) as u32 + 1).next_multiple_of(RUN);
        let mut sum = 0.0;
        for share in &targets.shares {
            sum += share;
            let end = (sum * f64::from(photons)) as u32;
            self.ends.push((end - end % RUN).max(least).min(photons));
        }
        if let Some(last) = self.ends.last_mut() {
            *last = photons;
        }
    }

    fn cumulate(&self, ball: &Target, all: f64) -> Vec<f32> {
        let mut sum = 0.0;
        let step = |group: &Group| {
            sum += flux(group, ball) / all;
            sum as f32
        };
        self.groups[..self.groups.len() - 1].iter().map(step).collect()
    }

    fn cumulate_groups(&self, still: &Still) -> Vec<f32> {
        let mut within = Vec::with_capacity(self.order.len());
        for group in &self.groups {
            let mut sum = 0.0;
            for &light in &self.order[group.first as usize..group.end as usize] {
                sum += f64::from(still.lights.entries[light as usize].probability) / group.share;
                within.push(sum as f32);
            }
        }
        within
    }

    /// The component that photon `photon` is drawn from: 0 for uniform emission, else one more than its ball.
    pub fn component(&self, photon: u32) -> usize {
        self.ends.partition_point(|&end| end <= photon)
    }

    /// The light that `u` chooses for a photon aimed at `ball`, where it has chosen `group`.
    pub fn light_of(&self, ball: usize, group: usize, u: f32) -> u32 {
        let (cumulative, Group { first, end, .. }) = (&self.cumulative[ball], self.groups[group]);
        let (first, end) = (first as usize, end as usize);
        if end - first == 1 {
            return self.order[first];
        }
        let before = if group > 0 { cumulative[group - 1] } else { 0.0 };
        let after = cumulative.get(group).copied().unwrap_or(1.0);
        let rest = (u - before) / (after - before);
        self.order[first + self.within[first..end - 1].partition_point(|&c| c <= rest)]
    }

    /// What multiplies a photon's power, where [`FLUX_ONE`](crate::film::FLUX_ONE) stands for the nominal one: a power of two.
    pub fn scale(&self) -> f32 {
        match self.guide {
            Some(_) => 1.0 / (1_u64 << GUIDED_BITS) as f32,
            None => (1_u128 << self.scale_bits) as f32,
        }
    }

    /// True if all photons weigh the same: they are neither aimed nor guided.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.guide.is_none()
    }

    /// The weight of a photon that leaves its lamp along this half line; 1 if nothing is aimed.
    pub fn weight(&self, origin: Vec3, direction: Vec3) -> f32 {
        let Some((&uniform, aimed)) = self.densities.split_first() else { return 1.0 };
        let mut sum = uniform;
        for (ball, density) in self.balls.iter().zip(aimed) {
            if ball.is_crossed(origin, direction) {
                sum += density;
            }
        }
        1.0 / sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also of few photons, and of a number that is a multiple of runs, and if what was learnt leaves none alike.
    #[test]
    fn as_many_photons_as_must_leave_all_lamps_alike() {
        let targets = Targets { shares: vec![0.0, 0.75, 0.25], ..Targets::default() };
        for photons in (1..4 * RUN).chain([8 * RUN, 64 * RUN, 1_000_003]) {
            let mut aim = Aim::default();
            aim.allot(&targets, photons);
            let alike = aim.ends[0];
            assert!(
                alike > 0 && f64::from(alike) >= f64::from(photons) * UNIFORM_SHARE,
                "{alike} of {photons}"
            );
            assert!(aim.ends.is_sorted() && aim.ends[2] == photons, "{:?} of {photons}", aim.ends);
        }
    }

    /// One number chooses the group, and then is as good as new for the lamp in it.
    #[test]
    fn lamps_of_groups_are_chosen_by_their_power() {
        const COUNT: u32 = 1 << 16;
        let group =
            |first: u32, end: u32, share: f64| Group { center: Vec3::ZERO, radius: 1.0, first, end, share };
        let aim = Aim {
            cumulative: vec![vec![0.25, 0.375]],
            groups: vec![group(0, 3, 0.5), group(3, 4, 0.1), group(4, 6, 0.4)],
            order: vec![5, 0, 3, 2, 4, 1],
            within: vec![0.5, 0.75, 1.0, 1.0, 0.125, 1.0],
            ..Aim::default()
        };
        let mut counts = [0_u32; 6];
        for i in 0..COUNT {
            let u = i as f32 / COUNT as f32;
            let number = aim.cumulative[0].partition_point(|&c| c <= u);
            counts[aim.light_of(0, number, u) as usize] += 1;
        }
        // By light: of the groups' 0.25, 0.125 and 0.625.
        let exact = [0.0625, 0.625 * 0.875, 0.125, 0.0625, 0.625 * 0.125, 0.125];
        for (count, exact) in counts.into_iter().zip(exact) {
            let found = f64::from(count) / f64::from(COUNT);
            // A few numbers at the ends of their ranges.
            assert!((found - exact).abs() < 1e-4, "{counts:?}: {found}, not {exact}");
        }
    }

    fn aim() -> Aim {
        Aim {
            balls: vec![Target::ball(Vec3::X * 10.0, 1.0), Target::ball(Vec3::X * 10.0, 2.0)],
            ends: vec![32, 48, 100],
            densities: vec![0.25, 0.5, 1.25],
            ..Aim::default()
        }
    }

    /// What a line weighs is one over the density of all components that it belongs to.
    #[test]
    fn weights_are_of_the_balls_that_are_crossed() {
        let weight = |y: f32| aim().weight(Vec3::new(0.0, y, 0.0), Vec3::X);
        assert_eq!([weight(0.0), weight(1.5), weight(3.0)], [0.5, 1.0 / 1.5, 4.0]);
        assert_eq!(Aim::default().weight(Vec3::ZERO, Vec3::X), 1.0);
        assert!(Aim::default().is_empty() && !aim().is_empty());
        for scale_bits in [0, 5, MOST_SCALE_BITS] {
            assert_eq!(Aim { scale_bits, ..aim() }.scale(), 2.0_f32.powi(scale_bits as i32));
        }
    }

    #[test]
    fn components_have_their_runs_of_photons() {
        let of = |photon| aim().component(photon);
        assert_eq!([of(0), of(31), of(32), of(47), of(48), of(99)], [0, 0, 1, 1, 2, 2]);
    }

    /// In each group the lights' shares of its power add up to 1.
    #[test]
    fn shares_within_a_group_are_of_its_power() {
        let lamps = [(Vec3::X * 9.0, 0.5, 1.0), (Vec3::X * 12.0, 0.5, 3.0), (Vec3::Y * 50.0, 1.0, 2.0)];
        let scene = crate::test_scenes::balls(&lamps);
        let still = scene.at(0.0);
        let probability = |light: usize| f64::from(still.lights.entries[light].probability);
        let group = |first, end, share| Group { center: Vec3::ZERO, radius: 1.0, first, end, share };
        let groups = vec![group(0, 2, probability(1) + probability(0)), group(2, 3, probability(2))];
        let within = Aim { groups, order: vec![1, 0, 2], ..Aim::default() }.cumulate_groups(&still);
        let exact = [probability(1) / (probability(1) + probability(0)), 1.0, 1.0];
        for (found, exact) in within.iter().zip(exact) {
            assert!((f64::from(*found) - exact).abs() < 1e-6, "{within:?}");
        }
        assert_eq!(within.len(), 3);
    }

    /// At an instant at which no lamp is left, or at which lamps have moved to where no light of theirs crosses a target.
    #[test]
    fn lamps_that_are_gone_send_nothing_to_targets() {
        let up = Target { axis: Vec3::Z, height: 0.1, ..Target::ball(Vec3::ZERO, 1.0) };
        let targets = Targets { balls: vec![up], shares: vec![0.5, 0.5], ..Targets::default() };
        let dark = crate::test_scenes::balls(&[(Vec3::ZERO, 1.0, 0.0)]);
        assert_eq!(Aim::new(&dark.at(0.0), &targets, 1000), Aim::default());
        let below = crate::test_scenes::balls(&[(Vec3::ZERO, 1.0, 0.0), (Vec3::NEG_Z * 50.0, 2.0, 1.0)]);
        let aim = Aim::new(&below.at(0.0), &targets, 1000);
        assert!(aim.densities[1] > aim.densities[0] && aim.densities[1].is_finite(), "{:?}", aim.densities);
        let above = crate::test_scenes::balls(&[(Vec3::ZERO, 1.0, 0.0), (Vec3::Z * 50.0, 2.0, 1.0)]);
        let aim = Aim::new(&above.at(0.0), &targets, 1000);
        // Half of the photons, in whole runs, leave all lamps alike.
        assert_eq!((aim.ends, aim.densities, aim.scale_bits), (vec![496, 1000], vec![0.496, 0.0], 0));
    }
}
