//! The photons of a batch, from the lights to their deposits.

use super::emission::Emission;
use crate::hierarchy::SearchBuffers;
use crate::join::{Binned, Cells, EXPONENT_SHIFT, HEAVY, Occupancy, Record, SAFE, Writer, bin_shift};
use crate::material::{Materials, kind};
use crate::paths::{Packet, Paths, Vectors};
use crate::sampling::{cosine_hemisphere, next_uniform};
use crate::scatter::{dielectric, reflect};
use crate::surface::{Hit, tag};
use crate::tables::Tables;
use crate::trace::{hits, intersect_batch};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::aim::{AIMED_BOUNCES, EXPONENT_STEP};
use scene::film::FLUX_ONE;
use scene::guide::GUIDED_BOUNCES;
use scene::still::{Carried, Role};
use scene::{Sphere, Still, Vec3};
use std::ops::Range;

/// What the photon pass of one iteration reads.
pub(crate) struct PhotonPass<'a> {
    pub(crate) emission: Emission<'a>,
    pub(crate) tables: &'a Tables,
    pub(crate) max_depth: u32,
    /// What photons carry.
    pub(crate) carried: Carried,
    /// The cells of the join.
    pub(crate) cells: Cells,
    /// The cells that visible points reach.
    pub(crate) occupancy: &'a Occupancy,
    /// The largest search radius.
    pub(crate) reach: f32,
    /// How far off points and normals may be.
    pub(crate) rounding: Rounding,
    /// Photons of a batch: a multiple of the lanes, at most [`BATCH`](crate::paths::BATCH).
    pub(crate) at_once: usize,
}

/// Buffers of one batch.
pub(crate) struct PhotonBatch {
    paths: Box<Paths>,
    search: SearchBuffers,
    /// The stratified numbers of bounce 0.
    first_bounce: Box<Vectors>,
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PhotonCounts {
    pub(crate) segments: u64,
    pub(crate) deposits: u64,
}

impl PhotonBatch {
    pub(crate) fn new() -> Self {
        Self { paths: Paths::new(), search: SearchBuffers::new(), first_bounce: Box::new(Vectors::ZERO) }
    }
}

impl PhotonPass<'_> {
    /// Traces the photons of a range of indices, whose start is a multiple of the lanes.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &self,
        batch: &mut PhotonBatch,
        photons: Range<u32>,
        out: &mut Binned,
    ) -> PhotonCounts {
        let mut counts = PhotonCounts::default();
        for first in photons.clone().step_by(self.at_once) {
            let count = (photons.end - first).min(self.at_once as u32);
            let PhotonBatch { paths, first_bounce, .. } = &mut *batch;
            let mut live = self.emission.emit::<L::Pair>(paths, first_bounce, first, count as usize);
            for bounce in 0..self.max_depth {
                let are_close = bounce == 0 && self.emission.are_close();
                if live == 0 {
                    break;
                }
                counts.segments += live as u64;
                intersect_batch::<L>(self.tables, &mut batch.paths, &mut batch.search, live, are_close);
                live = self.bounce::<L::Pair>(batch, live, bounce, out, &mut counts);
            }
        }
        counts
    }

    /// One bounce of the first `live` photons; returns the number of those that survive.
    #[inline(always)]
    fn bounce<L: Lanes>(
        &self,
        batch: &mut PhotonBatch,
        live: usize,
        bounce: u32,
        out: &mut Binned,
        counts: &mut PhotonCounts,
    ) -> usize {
        let surfaces = self.tables.surfaces(&batch.paths.hit[..live]);
        let mut out = out.writer(live);
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let here = L::first(live - at);
            let mut p = batch.paths.load::<L>(at);
            let (t, hit, arrived) = hits::<L>(&batch.paths, at, here);
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::gather(&self.tables.materials, surface.tag);
            let is_diffuse = L::eq(material.kind, L::u(kind::DIFFUSE));
            if bounce > 0 {
                let lands = arrived & is_diffuse;
                counts.deposits += u64::from(L::mask_bits(lands).count_ones());
                self.deposit::<L>(lands, &surface, hit, &p, &mut out);
            }
            let V3 { x: u, y: v, z: roulette } = if bounce == 0 {
                batch.first_bounce.load::<L>(at)
            } else {
                let u = next_uniform::<L>(&mut p.stream);
                let v = next_uniform::<L>(&mut p.stream);
                V3::new(u, v, next_uniform::<L>(&mut p.stream))
            };
            let (survives, survivor) = survive::<L>(p.weight, material.albedo, roulette);
            let mut survives = arrived & survives;
            if bounce == 0 && self.carried == Carried::Caustics {
                survives = survives & !is_diffuse;
            }
            p.weight = survivor;
            let (mut direction, weight) = self.scatter::<L>(bounce, &surface, u, v);
            if let Some(weight) = weight {
                p.weight = V3::select(is_diffuse, survivor.scale(weight), survivor);
                survives = survives & (!is_diffuse | L::lt(L::f(0.0), weight));
            }
            if L::any(survives & !is_diffuse) {
                let is_glass = L::eq(material.kind, L::u(kind::DIELECTRIC));
                let (through, _) = dielectric(p.direction, surface.normal, surface.inside, material.ior, u);
                let smooth = V3::select(is_glass, through, reflect(p.direction, surface.normal));
                direction = V3::select(is_diffuse, direction, smooth);
            }
            p.direction = direction;
            p.origin = surface.point;
            p.leaves = hit;
            go_on = batch.paths.append(go_on, survives, &p);
        }
        go_on
    }

    /// As `reference::photon_pass::scatter`; the weights only if there are any but 1.
    #[inline(always)]
    fn scatter<L: Lanes>(&self, bounce: u32, surface: &Hit<L>, u: L::F, v: L::F) -> (V3<L>, Option<L::F>) {
        let (point, normal) = (surface.point, surface.normal);
        if let Some(guide) = self.emission.guide().filter(|_| bounce < GUIDED_BOUNCES) {
            let (direction, weight) = guide.scatter::<L>(point, normal, u, v);
            return (direction, Some(weight));
        }
        match self.emission.aim().filter(|_| bounce < AIMED_BOUNCES) {
            Some(aim) => {
                let (direction, weight) = aim.scatter(point, normal, u, v);
                (direction, Some(weight))
            }
            None => (cosine_hemisphere(normal, u, v), None),
        }
    }

    /// Bins the deposits of the lanes `lands`; drops those that no visible point can reach.
    #[inline(always)]
    fn deposit<L: Lanes>(&self, lands: L::M, surface: &Hit<L>, hit: L::U, p: &Packet<L>, out: &mut Writer) {
        let in_reach = lands & self.occupancy.touches::<L>(surface.point);
        let mut rest = L::mask_bits(in_reach);
        if rest == 0 {
            return;
        }
        let safe = L::select_u(self.is_safe::<L>(surface, p), L::u(SAFE), L::u(0));
        let bucket = L::from_bits(self.cells.buckets::<L>(surface.point));
        let (point, power) = (surface.point, p.weight);
        let ([r, g, b], heavy) = match self.emission.scale() {
            None => ([quantise::<L>(power.x), quantise::<L>(power.y), quantise::<L>(power.z)], L::u(0)),
            Some(scale) => quantise_aimed::<L>(scale, power),
        };
        let columns = [point.x, point.y, point.z, L::from_bits(hit | safe | heavy), r, g, b, bucket];
        // As `Record` has them.
        let mut records = [Row::default(); MOST_LANES];
        L::transpose(columns, &mut records);
        let mut directions = [[0.0; MOST_LANES]; 3];
        L::store(-p.direction.x, &mut directions[0]);
        L::store(-p.direction.y, &mut directions[1]);
        L::store(-p.direction.z, &mut directions[2]);
        let shift = bin_shift(self.cells);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let from = [directions[0][lane], directions[1][lane], directions[2][lane], 0.0];
            out.push(bytemuck::cast::<Row, Record>(records[lane]), from, shift);
        }
    }

    /// The lanes whose photon is safe: for all visible points on its sphere within reach it arrives on the visible side.
    ///
    /// Inside of a shell that is always so. On a ball it is so if the cosine at the photon's own point is large enough.
    #[inline(always)]
    fn is_safe<L: Lanes>(&self, surface: &Hit<L>, p: &Packet<L>) -> L::M {
        let in_shell = tag::has::<L>(surface.tag, tag::ENCLOSURE);
        let cos = -p.direction.dot(surface.normal);
        let on_ground = tag::has::<L>(surface.tag, tag::GROUND);
        let safe = safe_cosine::<L>(self.reach, self.rounding.points, surface.scale);
        let safe_on_ground = L::f(self.reach) * surface.scale + L::f(self.rounding.tilt + MORE);
        in_shell | L::lt(L::select(on_ground, safe_on_ground, safe), cos)
    }
}

/// What cosines may be off by for their own rounding, and more.
const MORE: f32 = 1e-5;

/// If the cosine at one point of a ball is above this, cosines at all points within `reach` are positive: normals of points
/// at a distance d differ by d / radius. Points are off by up to `slack`, and cosines by some roundings.
#[inline(always)]
fn safe_cosine<L: Lanes>(reach: f32, slack: f32, radius: L::F) -> L::F {
    L::f(reach + slack) / radius + L::f(MORE)
}

/// As `reference::photon_pass::survive`: which photons survive the roulette, and their power if they do.
#[inline(always)]
pub(crate) fn survive<L: Lanes>(power: V3<L>, albedo: V3<L>, roulette: L::F) -> (L::M, V3<L>) {
    let scattered = power * albedo;
    let (before, after) = (power.max_component(), scattered.max_component());
    (L::lt(roulette * before, after), scattered.scale(before / after))
}

/// As `reference::photon_pass::quantise`; the integer is returned as the bits of a float.
#[inline(always)]
pub(crate) fn quantise<L: Lanes>(power: L::F) -> L::F {
    let flux = power * L::f(FLUX_ONE as f32) + L::f(0.5);
    L::from_bits(L::min_u(L::truncate(flux), L::u(FLUX_ONE)))
}

/// The same for aimed and for guided photons, as [`Flux::pack`](crate::join::Flux::pack) has it; and [`HEAVY`] where there is an
/// exponent.
#[inline(always)]
pub(crate) fn quantise_aimed<L: Lanes>(scale: f32, power: V3<L>) -> ([L::F; 3], L::U) {
    let scaled = power.scale(L::f(scale));
    let shift = exponent_of::<L>(scaled.max_component());
    // 2^-shift times `FLUX_ONE`, by its bits.
    let unit = L::from_bits(L::u((FLUX_ONE as f32).to_bits()) + L::shl::<23>(shift) * L::u(u32::MAX));
    let units = scaled.scale(unit) + V3::<L>::splat(Vec3::splat(0.5));
    let heavy = L::select_u(L::eq(shift, L::u(0)), L::u(0), L::u(HEAVY));
    let first = L::truncate(units.x) | L::shl::<EXPONENT_SHIFT>(shift);
    let [second, third] = [L::truncate(units.y), L::truncate(units.z)];
    ([L::from_bits(first), L::from_bits(second), L::from_bits(third)], heavy)
}

/// As `reference::photon_pass::exponent_of`.
#[inline(always)]
fn exponent_of<L: Lanes>(x: L::F) -> L::U {
    const STEP_BITS: i32 = EXPONENT_STEP.trailing_zeros() as i32;
    const _: () = assert!(EXPONENT_STEP.is_power_of_two());
    let one = L::f(1.0);
    let exponent = L::shr::<23>(L::bits(x)) + L::u(127_u32.wrapping_neg());
    let steps = L::shr::<STEP_BITS>(exponent) + L::u(1);
    L::select_u(L::lt(x, one), L::u(0), L::shl::<STEP_BITS>(steps))
}

/// Bounds on how far off from each other points and normals of surfaces are that are met from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Of how far a point computed to lie on a solid ball is from where its normal says: some ulps of the largest coordinate
    /// of any such ball.
    points: f32,
    /// The same for grounds, over their radius: by how much a normal may be tilted.
    tilt: f32,
}

impl Rounding {
    pub(crate) fn of(still: &Still) -> Self {
        let largest = |s: &Sphere| s.center.abs().max_element() + s.radius;
        let solid = still.spheres.iter().zip(still.roles.iter()).filter(|(_, role)| **role == Role::Solid);
        let points = solid.map(|(s, _)| largest(s)).fold(0.0, f32::max) * 1e-6;
        let grounds = still.grounds.iter().map(|ground| &still.spheres[ground.sphere as usize]);
        let tilt = grounds.map(|s| largest(s) / s.radius).fold(0.0, f32::max) * 1e-6;
        Self { points, tilt }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lanes::Emulated;
    use scene::Rgb;

    /// A dot product of unit vectors that are themselves rounded is off by some 10 roundings of 1.
    const LEAST: f64 = 10.0 * f32::EPSILON as f64;
    /// With so little more, one photon in some 25 000 is tested in vain.
    const MOST: f64 = 2e-5;

    #[test]
    fn safe_cosines_allow_for_reach_slack_and_roundings_and_hardly_more() {
        for (reach, slack, radius) in [(1e-3_f32, 0.0_f32, 1.0_f32), (0.2, 1e-2, 0.5), (3.0, 0.5, 16.0)] {
            let mut cosines = [0.0; MOST_LANES];
            let radii = <Emulated as Lanes>::f(radius);
            Emulated::store(safe_cosine::<Emulated>(reach, slack, radii), &mut cosines);
            let exact = (f64::from(reach) + f64::from(slack)) / f64::from(radius);
            let spare = f64::from(cosines[0]) - exact;
            assert!((LEAST..MOST).contains(&spare), "{} at {exact}", cosines[0]);
        }
    }

    #[test]
    fn points_are_trusted_to_a_few_roundings_of_the_largest_coordinate_of_a_ball() {
        let sphere = |x: f32, radius| Sphere {
            center: Vec3::new(x, 1.0, 2.0),
            velocity: Vec3::ZERO,
            radius,
            material: 0,
            emission: Rgb::ZERO,
        };
        let bound = |balls: &[Sphere]| {
            let mut scene = files::builtin::scene("cornell").unwrap();
            // Walls do not count.
            scene.spheres.retain(|sphere| sphere.radius > 1e3);
            scene.spheres.extend_from_slice(balls);
            Rounding::of(&scene.at(0.0))
        };
        assert_eq!([bound(&[]).points, bound(&[]).tilt], [0.0, 0.0]);
        let roundings = |largest: f32| 4.0 * f32::EPSILON * largest..16.0 * f32::EPSILON * largest;
        assert!(roundings(40.0).contains(&bound(&[sphere(-30.0, 10.0), sphere(5.0, 20.0)]).points));
        assert!(roundings(302.0).contains(&bound(&[sphere(-300.0, 2.0), sphere(5.0, 20.0)]).points));
    }

    /// A large ground is tilted no more than a small one that is as many radii away.
    #[test]
    fn normals_of_grounds_are_trusted_to_roundings_of_their_coordinates_over_their_radius() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        for radius in [1.0_f32, 100.0, 1e4] {
            let center = Vec3::new(-3.0 * radius, radius, 0.0);
            scene.spheres.retain(|_| false);
            scene.spheres.extend_from_slice(&[Sphere {
                center,
                velocity: Vec3::ZERO,
                radius,
                material: 0,
                emission: Rgb::ZERO,
            }]);
            scene.camera.eye = center + Vec3::Y * (1.03 * radius);
            let still = scene.at(0.0);
            assert_eq!(still.grounds.len(), 1);
            let Rounding { points, tilt } = Rounding::of(&still);
            let roundings = 4.0 * f32::EPSILON * 4.0..16.0 * f32::EPSILON * 4.0;
            assert!(
                points == 0.0 && roundings.contains(&tilt),
                "{points} and {tilt} for a radius of {radius}"
            );
        }
    }
}
