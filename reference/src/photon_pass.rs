//! Photon pass: traces photons from the lamps and deposits them wherever they meet a diffuse surface.

use crate::emission::{Emitted, emit};
use crate::intersect::{Hit, intersect};
use crate::photon_numbers::PhotonNumbers;
use crate::sampling::{cosine_hemisphere, uniform_cone};
use crate::scatter::{dielectric, reflect};
use scene::aim::{AIMED_BOUNCES, Aim, EXPONENT_STEP, Target, cone};
use scene::film::FLUX_ONE;
use scene::guide::{GUIDED_BOUNCES, Guided};
use scene::ray::SphereId;
use scene::still::Carried;
use scene::{Material, Ray, Rgb, Settings, Stats, Still, Vec3, max_component};
use std::ops::Range;

/// A photon's power per channel: `units * 2^shift`, in the nominal power over [`FLUX_ONE`] and [`Aim::scale`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flux {
    /// At most `FLUX_ONE` per channel.
    pub units: [u32; 3],
    /// A multiple of [`EXPONENT_STEP`]; 0 where all photons weigh the same.
    pub shift: u32,
}

impl Flux {
    /// As integers, whose sums are exact in any order.
    pub fn values(self) -> [u128; 3] {
        self.units.map(|units| u128::from(units) << self.shift)
    }
}

/// A photon that arrives at a diffuse surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit {
    /// The point of arrival.
    pub point: Vec3,
    /// Unit direction from the surface to where the photon came from.
    pub wi: Vec3,
    /// The sphere that it hits.
    pub sphere: SphereId,
    /// Its power; `FLUX_ONE` times [`Aim::scale`] stands for the nominal power [`scene::still::Lights::power`].
    pub flux: Flux,
}

/// Traces the photons with indices `photons` of one iteration, and calls `deposit` wherever one arrives at a diffuse
/// surface from bounce 1 on. At bounce 0 it would bring direct light, which the camera pass has counted. Photons that carry
/// caustics end there.
pub fn photon_pass(
    still: &Still,
    aim: &Aim,
    settings: &Settings,
    iteration: u32,
    photons: Range<u32>,
    stats: &mut Stats,
    mut deposit: impl FnMut(&Deposit, &mut Stats),
) {
    let numbers = PhotonNumbers::new(settings.seed, iteration);
    for photon in photons {
        stats.photons += 1;
        trace(still, aim, settings.max_depth, &numbers, photon, stats, &mut deposit);
    }
}

fn trace(
    still: &Still,
    aim: &Aim,
    max_depth: u32,
    numbers: &PhotonNumbers,
    photon: u32,
    stats: &mut Stats,
    deposit: &mut impl FnMut(&Deposit, &mut Stats),
) {
    let Some(Emitted { mut ray, mut power }) = emit(still, aim, numbers, photon) else {
        return;
    };
    let mut stream = numbers.stream(photon);
    for bounce in 0..max_depth {
        stats.photon_segments += 1;
        let Some(hit) = intersect(still, &ray) else { return };
        let material = still.material(hit.sphere);
        if bounce == 0 && still.carried == Carried::Caustics && material.is_diffuse() {
            return;
        }
        if bounce > 0 && matches!(material, Material::Diffuse { .. }) {
            stats.deposits += 1;
            let flux = quantise(aim, power);
            deposit(&Deposit { point: hit.point, wi: -ray.direction, sphere: hit.sphere, flux }, stats);
        }
        let [u, v, roulette] = numbers.bounce(photon, bounce, &mut stream);
        let Some(survivor) = survive(power, material.albedo(), roulette) else {
            return;
        };
        let (direction, weight) = match *material {
            Material::Diffuse { .. } => scatter(aim, bounce, &hit, u, v),
            Material::Specular { .. } => (reflect(ray.direction, hit.normal), 1.0),
            Material::Dielectric { ior, .. } => (dielectric(ray.direction, &hit, ior, u).0, 1.0),
        };
        if weight == 0.0 {
            return;
        }
        power = survivor * weight;
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
}

/// The direction in which a diffuse surface scatters a photon, and what that multiplies its power by: by the cosine, which may be
/// guided, or towards what is aimed at.
fn scatter(aim: &Aim, bounce: u32, hit: &Hit, u: f32, v: f32) -> (Vec3, f32) {
    if let Some(guide) = aim.guide.as_ref().filter(|_| bounce < GUIDED_BOUNCES) {
        let Guided { u, v, weight } = guide.guided(guide.surface(hit.point, hit.normal), u, v);
        return (cosine_hemisphere(hit.normal, u, v), weight);
    }
    match aim.region.as_ref().filter(|_| bounce < AIMED_BOUNCES) {
        Some(ball) => scatter_towards(ball, hit.point, hit.normal, u, v),
        None => (cosine_hemisphere(hit.normal, u, v), 1.0),
    }
}

/// Russian roulette: a photon survives with the probability by which its brightest channel is scaled down, and a
/// survivor's brightest channel is restored to its old value. So all photons keep the nominal power.
pub fn survive(power: Rgb, albedo: Rgb, roulette: f32) -> Option<Rgb> {
    let scattered = power * albedo;
    let (before, after) = (max_component(power), max_component(scattered));
    if roulette * before < after { Some(scattered * (before / after)) } else { None }
}

/// `1 - cos` of the half angle of a cone of all directions, which [`cone`] gives for a point within the ball.
const ALL_DIRECTIONS: f32 = 2.0;

/// The direction of a photon that a diffuse surface scatters at `point` outside of a ball, as often as not towards the ball;
/// and what that multiplies its power by, at most 2. Within the ball, by the cosine alone, and 1.
///
/// Of the power that is scattered by the cosine, `cos / pi` per steradian, little meets a small ball far away. So few photons
/// would, each as heavy as at the surface: sparks. Half of them are drawn from the cone of directions to the ball, evenly,
/// of which `h` is `1 - cos` of the half angle. The density of both together is `cos / (2 pi) + 1 / (4 pi h)` in the cone
/// and `cos / (2 pi)` elsewhere, and the weight is `cos / pi` over that (the balance heuristic of Veach 1997):
/// `4 h cos / (1 + 2 h cos)`, and 2. Weight 0 stands for a direction into the surface, or one that rounding has kept
/// from the ball, which [`Target::is_crossed`] decides for all directions alike.
pub fn scatter_towards(ball: &Target, point: Vec3, normal: Vec3, u: f32, v: f32) -> (Vec3, f32) {
    let (axis, height) = cone(point, 0.0, ball.center, ball.radius);
    if height >= ALL_DIRECTIONS {
        return (cosine_hemisphere(normal, u, v), 1.0);
    }
    // The first bit of the number decides; the others are as good as new.
    let twice = u * 2.0;
    let is_aimed = twice < 1.0;
    let direction = if is_aimed {
        uniform_cone(axis, height, twice, v).0
    } else {
        cosine_hemisphere(normal, twice - 1.0, v)
    };
    if ball.is_crossed(point, direction) {
        let cos = direction.dot(normal);
        let ratio = 2.0 * (height * if cos > 0.0 { cos } else { 0.0 });
        return (direction, 2.0 * (ratio / (1.0 + ratio)));
    }
    (direction, if is_aimed { 0.0 } else { 2.0 })
}

/// Rounds a power, in units of the nominal power, to an integer: so sums of fluxes do not depend on their order.
///
/// If photons leave all lamps alike, to the nearest multiple of `1 / FLUX_ONE`, with an error of 2^-22 of the nominal
/// power at most. A photon's brightest channel may exceed the nominal power by rounding, so the result is clamped: no flux
/// exceeds `FLUX_ONE` = 2^21.
///
/// Aimed photons weigh more or less than that, and so do those scattered towards what they are aimed at. They are counted
/// in a unit of 2^-s of it ([`Aim::scale_bits`]), and heavy ones in a multiple of that unit by a power of two, with an
/// error of 2^-14 of the brightest channel at most. As weights are at most 8 as photons depart, doubled by at most three
/// surfaces, and s is at most 69, no flux exceeds 2^96. A photon lighter than 2^-14 of the lightest that depart may count
/// for nothing.
///
/// Guided photons ([`scene::guide`]) are counted in a unit of 2^3 of that of photons that weigh the same, and weigh less than 2^7.
///
/// Fewer than 2^31 photons are deposited ([`scene::settings::MAX_DEPOSITS`]). So sums stay below 2^52 without aiming, and
/// below 2^127 with it.
pub fn quantise(aim: &Aim, power: Rgb) -> Flux {
    let one = FLUX_ONE as f32;
    if aim.is_empty() {
        return Flux { units: power.to_array().map(|p| ((p * one + 0.5) as u32).min(FLUX_ONE)), shift: 0 };
    }
    let scaled = power * aim.scale();
    let shift = exponent_of(max_component(scaled));
    // A shift of up to 80: more than 64 bits.
    let unit = one / (1_u128 << shift) as f32;
    Flux { units: scaled.to_array().map(|p| (p * unit + 0.5) as u32), shift }
}

/// The least multiple k of [`EXPONENT_STEP`] from 0 on for which `x` is below 2^k.
fn exponent_of(x: f32) -> u32 {
    /// The exponent of 1 as `f32` stores it.
    const OF_ONE: u32 = 127;
    let exponent = x.to_bits() >> 23;
    if exponent < OF_ONE { 0 } else { ((exponent - OF_ONE) / EXPONENT_STEP + 1) * EXPONENT_STEP }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::aim::MOST_SCALE_BITS;

    /// Photons that survive keep the power of their brightest channel, and as many do as light is left.
    #[test]
    fn survivors_keep_their_power() {
        let (power, albedo) = (Rgb::new(1.0, 0.5, 0.25), Rgb::new(0.5, 0.8, 0.0));
        assert_eq!(survive(power, albedo, 0.499), Some(Rgb::new(1.0, 0.8, 0.0)));
        assert_eq!([survive(power, albedo, 0.5), survive(power, Rgb::ZERO, 0.0)], [None, None]);
        assert_eq!(survive(power, Rgb::ONE, 0.999), Some(power));
        assert_eq!(survive(power * 4.0, albedo, 0.499), Some(Rgb::new(4.0, 3.2, 0.0)));
    }

    #[test]
    fn fluxes_are_rounded_to_the_nearest_and_never_exceed_one() {
        let units = |p: f32| quantise(&Aim::default(), Rgb::splat(p)).units[0];
        let unit = 1.0 / FLUX_ONE as f32;
        assert_eq!([0.0, 0.49 * unit, 0.51 * unit, 1.4 * unit, 1.0].map(units), [0, 0, 1, 1, FLUX_ONE]);
        assert_eq!([1.0 + f32::EPSILON, 1.5].map(units), [FLUX_ONE; 2]);
        assert_eq!(quantise(&Aim::default(), Rgb::ONE).shift, 0);
        assert_eq!(Flux { units: [1, 2, 3], shift: 8 }.values(), [256, 512, 768]);
    }

    /// Half a unit of at least 14 bits.
    const ROUNDING: f64 = 1.0 / 16384.0;

    /// In every unit, for every weight that a photon may have after three surfaces.
    #[test]
    fn aimed_fluxes_are_within_2_14_of_their_power() {
        for scale_bits in 0..=MOST_SCALE_BITS {
            let aim = Aim { ends: vec![1], scale_bits, ..Aim::default() };
            let least = -(scale_bits as i32) - 11;
            for power in
                (least..=6).flat_map(|k| [1.0, 1.3, 1.999].map(|m| m * 2_f32.powi(k))).filter(|&p| p <= 64.0)
            {
                let flux = quantise(&aim, Rgb::new(power, 0.5 * power, 0.0));
                assert!(
                    flux.units[0] <= FLUX_ONE && flux.shift <= MOST_SCALE_BITS + 11,
                    "{scale_bits}, {power}: {flux:?}"
                );
                let unit = f64::from(FLUX_ONE) * 2_f64.powi(scale_bits as i32);
                let [red, green, blue] = flux.values().map(|value| value as f64 / unit / f64::from(power));
                let error = (red - 1.0).abs().max((green - 0.5).abs());
                // Half a unit, of the green half.
                let lightest = 1.0 / (unit * f64::from(power));
                assert!(error <= ROUNDING.max(lightest) && blue == 0.0, "{scale_bits}, {power}: {flux:?}");
            }
        }
    }

    #[test]
    fn exponents_are_the_least_multiples_that_hold_a_number() {
        for (x, exponent) in [
            (0.0, 0),
            (0.5, 0),
            (0.999, 0),
            (1.0, 8),
            (255.9, 8),
            (256.0, 16),
            (65_535.0, 16),
            (65_536.0, 24),
        ] {
            assert_eq!(exponent_of(x), exponent, "{x}");
        }
    }

    /// From afar half of the photons fly towards the ball; weights undo that, and none is above 2.
    #[test]
    fn photons_scatter_towards_what_they_are_aimed_at() {
        let ball = Target::ball(Vec3::Z * 10.0, 1.0);
        let mut hits = [0.0, 0.0];
        let (mut count, side) = (0, 64);
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|k| (k as f32 + 0.5) / side as f32);
            let (direction, weight) = scatter_towards(&ball, Vec3::ZERO, Vec3::Z, u, v);
            let is_met = ball.is_crossed(Vec3::ZERO, direction);
            assert!(
                (0.0..=2.0).contains(&weight) && (is_met || weight == 2.0 || u < 0.5),
                "{direction}, {weight}"
            );
            hits[usize::from(is_met)] += weight;
            count += u32::from(is_met);
        }
        let all = (side * side) as f32;
        // By the cosine a share of 1 / 100 meets it, the square of the sine of the half angle.
        assert!((hits[1] / all - 0.01).abs() < 1e-3 && (hits[0] / all - 0.99).abs() < 0.02, "{hits:?}");
        assert!((count as f32 / all - 0.505).abs() < 0.02, "{count}");
        // Numbers from a half on are those of the others.
        let (other, _) = scatter_towards(&ball, Vec3::ZERO, Vec3::Z, 0.5, 0.6);
        assert_eq!(other, cosine_hemisphere(Vec3::Z, 0.0, 0.6));
        // Within the ball there is nothing to aim at.
        let within = scatter_towards(&ball, Vec3::Z * 9.5, Vec3::Z, 0.3, 0.6);
        assert_eq!(within, (cosine_hemisphere(Vec3::Z, 0.3, 0.6), 1.0));
    }
}
