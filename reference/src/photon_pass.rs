//! Photon pass: traces photons from the lamps and deposits them wherever they meet a diffuse surface.

use crate::emission::{Emitted, emit};
use crate::intersect::{Hit, intersect};
use crate::sampling::cosine_hemisphere;
use crate::scatter::{dielectric, reflect};
use scene::aim::{Aim, EXPONENT_STEP};
use scene::film::FLUX_ONE;
use scene::ray::SphereId;
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, sobol};
use scene::{Material, Ray, Rgb, Settings, Stats, Still, Vec3, max_component};
use std::ops::Range;

/// A photon's power per channel: `units * 2^shift`, in the nominal power over [`FLUX_ONE`] and [`Aim::scale`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flux {
    /// At most `FLUX_ONE` per channel.
    pub units: [u32; 3],
    /// A multiple of [`EXPONENT_STEP`]; 0 where nothing is aimed.
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

/// Which dimensions of a photon's Sobol point are used for what.
pub(crate) mod dimension {
    pub(crate) const DIRECTION: [usize; 2] = [0, 1];
    pub(crate) const POSITION: [usize; 2] = [2, 3];
    pub(crate) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(crate) const LIGHT: usize = 6;
}

/// The random numbers of the photons of one iteration.
///
/// Emission and the first bounce use the photon's Sobol point, with new digital shifts in each iteration. Later
/// bounces draw from the photon's own stream.
pub struct PhotonNumbers {
    shifts: [u32; DIMENSIONS],
    key: StreamKey,
}

impl PhotonNumbers {
    /// The numbers of iteration `iteration`.
    pub fn new(seed: u64, iteration: u32) -> Self {
        let mut shifts = StreamKey::new(seed, Family::Emission, iteration).stream(0);
        Self {
            shifts: std::array::from_fn(|_| shifts.next_u32()),
            key: StreamKey::new(seed, Family::Photon, iteration),
        }
    }

    pub(crate) fn stratified<const N: usize>(&self, photon: u32, dimensions: [usize; N]) -> [f32; N] {
        dimensions.map(|d| unit_float(sobol(photon, d) ^ self.shifts[d]))
    }

    /// The three numbers of a bounce: two for the direction (at glass, the first chooses between reflection and
    /// refraction), one for roulette.
    fn bounce(&self, photon: u32, bounce: u32, stream: &mut Stream) -> [f32; 3] {
        if bounce == 0 {
            self.stratified(photon, dimension::FIRST_BOUNCE)
        } else {
            std::array::from_fn(|_| stream.next_f32())
        }
    }
}

/// Traces the photons with indices `photons` of one iteration, and calls `deposit` wherever one arrives at a diffuse
/// surface from bounce 1 on. At bounce 0 it would bring direct light, which the camera pass has counted.
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
    let mut stream = numbers.key.stream(photon);
    for bounce in 0..max_depth {
        stats.photon_segments += 1;
        let Some(hit) = intersect(still, &ray) else { return };
        let material = still.material(hit.sphere);
        if bounce > 0 && matches!(material, Material::Diffuse { .. }) {
            stats.deposits += 1;
            let flux = quantise(aim, power);
            deposit(&Deposit { point: hit.point, wi: -ray.direction, sphere: hit.sphere, flux }, stats);
        }
        let [u, v, roulette] = numbers.bounce(photon, bounce, &mut stream);
        let Some(survivor) = survive(power, material.albedo(), roulette) else {
            return;
        };
        power = survivor;
        ray = Ray { origin: hit.point, direction: scatter(material, &ray, &hit, u, v), leaves: hit.sphere };
    }
}

/// Russian roulette: a photon survives with the probability by which its brightest channel is scaled down, and a
/// survivor's brightest channel is restored to its old value. So all photons keep the nominal power.
pub fn survive(power: Rgb, albedo: Rgb, roulette: f32) -> Option<Rgb> {
    let scattered = power * albedo;
    let (before, after) = (max_component(power), max_component(scattered));
    if roulette * before < after { Some(scattered * (before / after)) } else { None }
}

fn scatter(material: &Material, ray: &Ray, hit: &Hit, u: f32, v: f32) -> Vec3 {
    match *material {
        Material::Diffuse { .. } => cosine_hemisphere(hit.normal, u, v),
        Material::Specular { .. } => reflect(ray.direction, hit.normal),
        Material::Dielectric { ior, .. } => dielectric(ray.direction, hit, ior, u).0,
    }
}

/// Rounds a power, in units of the nominal power, to an integer: so sums of fluxes do not depend on their order.
///
/// If photons leave all lamps alike, to the nearest multiple of `1 / FLUX_ONE`, with an error of 2^-22 of the nominal
/// power at most. A photon's brightest channel may exceed the nominal power by rounding, so the result is clamped: no flux
/// exceeds `FLUX_ONE` = 2^21.
///
/// Aimed photons weigh more or less than that. They are counted in a unit of 2^-s of it ([`Aim::scale_bits`]), and heavy
/// ones in a multiple of that unit by a power of two, with an error of 2^-14 of the brightest channel at most. As weights
/// are at most 8, and s at most 38, no flux exceeds 2^62.
///
/// Fewer than 2^31 photons are deposited ([`scene::settings::MAX_DEPOSITS`]). So sums stay below 2^52 without aiming, and
/// below 2^93 with it.
pub fn quantise(aim: &Aim, power: Rgb) -> Flux {
    let one = FLUX_ONE as f32;
    if aim.is_empty() {
        return Flux { units: power.to_array().map(|p| ((p * one + 0.5) as u32).min(FLUX_ONE)), shift: 0 };
    }
    let scaled = power * aim.scale();
    let shift = exponent_of(max_component(scaled));
    let unit = one / (1_u64 << shift) as f32;
    Flux { units: scaled.to_array().map(|p| (p * unit + 0.5) as u32), shift }
}

/// The least multiple k of [`EXPONENT_STEP`] from 0 on for which `x` is below 2^k.
fn exponent_of(x: f32) -> u32 {
    /// The exponent of 1 as `f32` stores it.
    const OF_ONE: u32 = 127;
    let exponent = x.to_bits() >> 23;
    if exponent < OF_ONE { 0 } else { ((exponent - OF_ONE) / EXPONENT_STEP + 1) * EXPONENT_STEP }
}
