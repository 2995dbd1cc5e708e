//! Photon pass: traces photons from the lamps and deposits them wherever they meet a diffuse surface.

use crate::direct_light::choose_light;
use crate::intersect::{Hit, intersect};
use crate::sampling::{cosine_hemisphere, uniform_sphere};
use crate::scatter::{dielectric, reflect};
use scene::film::FLUX_ONE;
use scene::ray::SphereId;
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, sobol};
use scene::still::{Light, Role};
use scene::{Material, Ray, Rgb, Settings, Stats, Still, Vec3, max_component};
use std::ops::Range;

/// A photon's power per channel, in units of the nominal power divided by `FLUX_ONE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flux(pub [u32; 3]);

/// A photon that arrives at a diffuse surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deposit {
    /// The point of arrival.
    pub point: Vec3,
    /// Unit direction from the surface to where the photon came from.
    pub wi: Vec3,
    /// The sphere that it hits.
    pub sphere: SphereId,
    /// Its power; `FLUX_ONE` stands for the nominal power [`scene::still::Lights::power`].
    pub flux: Flux,
}

/// Which dimensions of a photon's Sobol point are used for what.
mod dimension {
    pub(super) const DIRECTION: [usize; 2] = [0, 1];
    pub(super) const POSITION: [usize; 2] = [2, 3];
    pub(super) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(super) const LIGHT: usize = 6;
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

    fn stratified<const N: usize>(&self, photon: u32, dimensions: [usize; N]) -> [f32; N] {
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
    settings: &Settings,
    iteration: u32,
    photons: Range<u32>,
    stats: &mut Stats,
    mut deposit: impl FnMut(&Deposit, &mut Stats),
) {
    let numbers = PhotonNumbers::new(settings.seed, iteration);
    for photon in photons {
        stats.photons += 1;
        trace(still, settings.max_depth, &numbers, photon, stats, &mut deposit);
    }
}

fn trace(
    still: &Still,
    max_depth: u32,
    numbers: &PhotonNumbers,
    photon: u32,
    stats: &mut Stats,
    deposit: &mut impl FnMut(&Deposit, &mut Stats),
) {
    let Some((mut ray, mut power)) = emit(still, numbers, photon) else {
        return;
    };
    let mut stream = numbers.key.stream(photon);
    for bounce in 0..max_depth {
        stats.photon_segments += 1;
        let Some(hit) = intersect(still, &ray) else { return };
        let material = still.material(hit.sphere);
        if bounce > 0 && matches!(material, Material::Diffuse { .. }) {
            stats.deposits += 1;
            let flux = quantise(power);
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

/// Emits a photon from a uniform point of a lamp, in a cosine-distributed direction. `None` if another sphere covers
/// that point.
fn emit(still: &Still, numbers: &PhotonNumbers, photon: u32) -> Option<(Ray, Rgb)> {
    let [choice] = numbers.stratified(photon, [dimension::LIGHT]);
    let light = choose_light(&still.lights, choice)?;
    let lamp = &still.spheres[light.sphere as usize];
    let [u, v] = numbers.stratified(photon, dimension::POSITION);
    let outward = uniform_sphere(u, v);
    let origin = lamp.center + outward * lamp.radius;
    if is_blocked(still, light, origin) {
        return None;
    }
    let normal = if light.inside { -outward } else { outward };
    let [u, v] = numbers.stratified(photon, dimension::DIRECTION);
    let ray = Ray { origin, direction: cosine_hemisphere(normal, u, v), leaves: light.sphere };
    Some((ray, light.photon_power))
}

/// True if `point` of the lamp lies inside an opaque ball, or outside of a shell around the eye.
fn is_blocked(still: &Still, light: &Light, point: Vec3) -> bool {
    let blockers = light.blockers.start as usize..light.blockers.end as usize;
    still.lights.blockers[blockers].iter().any(|&id| {
        let sphere = &still.spheres[id as usize];
        let from_center = point - sphere.center;
        let within = from_center.dot(from_center) < sphere.radius * sphere.radius;
        within == (still.roles[id as usize] == Role::Solid)
    })
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

/// Rounds a power, in units of the nominal power, to the nearest multiple of `1 / FLUX_ONE`, with an error of 2^-22 of
/// the nominal power at most. As the result is an integer, sums of fluxes do not depend on their order.
///
/// A photon's brightest channel may exceed the nominal power by rounding, so the result is clamped. No flux exceeds
/// `FLUX_ONE` = 2^21, and fewer than 2^31 photons are deposited ([`scene::settings::MAX_DEPOSITS`]). So every sum stays
/// below 2^52, which fits a `u64` and is exact as an `f64`.
pub fn quantise(power: Rgb) -> Flux {
    Flux(power.to_array().map(|p| ((p * FLUX_ONE as f32 + 0.5) as u32).min(FLUX_ONE)))
}
