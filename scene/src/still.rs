//! A scene at one instant of the shutter, sorted out for tracing: what can be hit from which side, and what glows.
//!
//! Everything that light does between the eye and the lights happens in one connected region, the free space. An
//! opaque sphere is therefore only ever met from one side, and which one is known beforehand: a sphere around the
//! eye from inside ([`Role::Enclosure`]), any other from outside ([`Role::Solid`], [`Role::Ground`]). Only glass is met from
//! both ([`Role::Glass`]). This is more than an economy. A point where surfaces meet may be computed to lie behind one
//! of them by a rounding error; knowing that it cannot be there, the intersection closes such leaks exactly.

pub use crate::anchored::{Enclosure, Ground, NEAR};
use crate::color::{Rgb, max_component};
use crate::light_tree::{Lamp, LightTree};
use crate::material::Material;
use crate::neighbours::Neighbours;
use crate::ray::SphereId;
pub use crate::roles::{Role, Roles};
use crate::sphere::Sphere;
use crate::world::Scene;
use glam::Vec3;
use std::borrow::Cow;
use std::f64::consts::PI;
use std::ops::{ControlFlow, Range};

/// One side of a glowing sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Which sphere this is.
    pub sphere: SphereId,
    /// True for the side towards the centre.
    pub inside: bool,
    /// Probability that a photon chooses this light: its share of [`Lights::power`].
    pub probability: f32,
    /// What a photon of this light carries, `pi * area * emission / probability`, per channel and in multiples of
    /// [`Lights::power`]: its largest channel is 1 for every light.
    pub photon_power: Rgb,
    /// The opaque spheres that part of this one is sunk into, as a range of [`Lights::blockers`].
    pub blockers: Range<u32>,
}

/// All the lights that free space sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// The lights, in order of their spheres.
    pub entries: Vec<Light>,
    /// For each light but the last, the sum of the probabilities up to and including it.
    pub cumulative: Vec<f32>,
    /// The sum over all lights of the power in their brightest channel, in W: the nominal power of a photon
    /// (times the number of photons).
    pub power: f32,
    /// See [`Light::blockers`].
    pub blockers: Vec<SphereId>,
    /// For the choice of a light for the point that receives it.
    pub tree: LightTree,
}

/// Which light photons carry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Carried {
    /// All that comes to visible points by way of other surfaces, as in photon mapping; the camera pass adds direct light.
    #[default]
    All,
    /// That of lamps whose first surface is a mirror or glass, and no other: what is left to it by a path tracer
    /// ([`crate::Hybrid`]).
    Caustics,
}

/// A scene at one instant.
#[derive(Clone, Debug)]
pub struct Still<'a> {
    /// The spheres where they stand at this instant. Ids index them.
    pub spheres: Cow<'a, [Sphere]>,
    /// The materials that spheres refer to.
    pub materials: &'a [Material],
    /// The role of each sphere.
    pub roles: Roles,
    /// The opaque spheres that the eye is close to the outside of, in order of their ids.
    pub grounds: Vec<Ground>,
    /// The spheres around the eye, in order of their ids.
    pub enclosures: Vec<Enclosure>,
    /// What glows; for photons that carry caustics alone, lamps alone.
    pub lights: Lights,
    /// What photons carry.
    pub carried: Carried,
}

/// Relative slack within which surfaces count as touching, so that rounding never hides a blocker.
const TOUCHING: f64 = 1e-5;

/// Up to so many lamps, every sphere is examined for every lamp: less work and memory than to build a hierarchy.
const FEW_LAMPS: usize = 16;

/// The solid spheres, for lamps to find those that are near.
enum Solids {
    /// Every one is examined.
    All,
    /// In a hierarchy.
    Sorted(Neighbours),
}

/// Whether a sphere hides some of another's surface, and all of it.
struct Cover {
    some: bool,
    all: bool,
}

impl Scene {
    /// The scene at shutter time `time`.
    pub fn at(&self, time: f32) -> Still<'_> {
        self.at_for(time, Carried::All)
    }

    /// The same, with the lights whose light photons carry.
    pub fn at_for(&self, time: f32, carried: Carried) -> Still<'_> {
        let mut still = self.without_light_tree(time, carried);
        still.lights.tree = still.light_tree();
        still
    }

    /// The lights at shutter time `time`, without [`Lights::tree`].
    pub(crate) fn lights_at(&self, time: f32) -> Lights {
        self.without_light_tree(time, Carried::All).lights
    }

    fn without_light_tree(&self, time: f32, carried: Carried) -> Still<'_> {
        let spheres = if self.moves() {
            Cow::Owned(self.spheres.iter().map(|s| s.at(time)).collect())
        } else {
            Cow::Borrowed(&self.spheres[..])
        };
        let mut still = Still {
            spheres,
            materials: &self.materials,
            roles: Roles::default(),
            grounds: Vec::new(),
            enclosures: Vec::new(),
            lights: Lights::default(),
            carried,
        };
        still.assign_roles(self.camera.eye);
        still.find_lights();
        still
    }
}

impl Still<'_> {
    /// The material of sphere `id`.
    #[inline]
    pub fn material(&self, id: SphereId) -> &Material {
        &self.materials[self.spheres[id as usize].material as usize]
    }

    /// The same, but that the choice of a light for direct light ([`Lights::tree`]) is among lamps alone: for renderers
    /// whose paths meet glowing enclosures by themselves.
    #[must_use]
    pub fn with_choice_of_lamps(mut self) -> Self {
        self.lights.tree.leave_out_ambient();
        self
    }

    /// True if photons may carry light at all: for caustics there must be a lamp, and a mirror or glass.
    pub fn has_photons(&self) -> bool {
        let can_scatter = self.carried == Carried::All || self.materials.iter().any(|m| !m.is_diffuse());
        !self.lights.entries.is_empty() && can_scatter
    }

    /// True if a light is no glowing enclosure.
    pub fn has_lamps(&self) -> bool {
        self.lights.entries.iter().any(|light| !self.is_enclosure(light.sphere))
    }

    /// True if a light is a glowing enclosure, such as the sky.
    pub fn has_ambient_lights(&self) -> bool {
        let lights = &self.lights.entries;
        let is_light = |id: &SphereId| lights.binary_search_by_key(id, |light| light.sphere).is_ok();
        self.enclosures.iter().any(|enclosure| is_light(&enclosure.sphere))
    }

    /// True if a blocker of a lamp ([`Light::blockers`]) hides this point of it: if the point lies within an opaque ball, or
    /// outside of a shell around the eye.
    pub fn is_hidden(&self, light: &Light, point: Vec3) -> bool {
        let blockers = light.blockers.start as usize..light.blockers.end as usize;
        self.lights.blockers[blockers].iter().any(|&id| {
            let sphere = &self.spheres[id as usize];
            let from_center = point - sphere.center;
            let power = match self.roles[id as usize] {
                Role::Ground(g) => self.grounds[g as usize].power(point),
                _ => from_center.dot(from_center) - sphere.radius * sphere.radius,
            };
            (power < 0.0) == self.roles[id as usize].is_solid()
        })
    }

    /// True if sphere `id` is around the eye, and opaque.
    pub fn is_enclosure(&self, id: SphereId) -> bool {
        matches!(self.roles[id as usize], Role::Enclosure(_))
    }

    fn assign_roles(&mut self, eye: Vec3) {
        self.roles = Roles::with_capacity(self.spheres.len());
        for (id, s) in self.spheres.iter().enumerate() {
            let (away, radius) = (distance(eye, s.center), f64::from(s.radius));
            let role = if !self.materials[s.material as usize].is_opaque() {
                Role::Glass
            } else if away < radius {
                self.enclosures.push(Enclosure::new(id as SphereId, s, eye));
                Role::Enclosure(self.enclosures.len() as u32 - 1)
            } else if Ground::is_near(away - radius, s) {
                self.grounds.push(Ground::new(id as SphereId, s, eye));
                Role::Ground(self.grounds.len() as u32 - 1)
            } else {
                Role::Solid
            };
            self.roles.push(role);
        }
    }

    fn find_lights(&mut self) {
        let mut weights = Vec::new();
        let solids = self.solids();
        for (id, s) in self.spheres.iter().enumerate().filter(|(_, s)| s.is_emitter()) {
            if self.carried == Carried::Caustics && self.is_enclosure(id as SphereId) {
                continue;
            }
            let Some(blockers) = self.blockers(id, &solids) else {
                continue;
            };
            let start = self.lights.blockers.len() as u32;
            self.lights.blockers.extend(blockers);
            let blockers = start..self.lights.blockers.len() as u32;
            let sides: &[bool] = match self.roles[id] {
                Role::Solid | Role::Ground(_) => &[false],
                Role::Enclosure(_) => &[true],
                Role::Glass => &[false, true],
            };
            for &inside in sides {
                weights.push(power_of(s));
                let blockers = blockers.clone();
                let (sphere, probability, photon_power) = (id as SphereId, 0.0, Rgb::ZERO);
                self.lights.entries.push(Light { sphere, inside, probability, photon_power, blockers });
            }
        }
        let total: f64 = weights.iter().sum();
        self.lights.power = total as f32;
        let mut sum = 0.0;
        for (light, weight) in self.lights.entries.iter_mut().zip(weights) {
            sum += weight / total;
            light.probability = (weight / total) as f32;
            let emission = self.spheres[light.sphere as usize].emission;
            let (color, brightest) = (emission.as_dvec3(), f64::from(max_component(emission)));
            light.photon_power = (color / brightest).as_vec3();
            self.lights.cumulative.push(sum as f32);
        }
        self.lights.cumulative.pop();
        self.find_shadow_casters();
    }

    /// The opaque spheres that hide part of the surface of sphere `id` from free space, in order of their ids; `None`
    /// if one of them hides all of it. `solids` finds candidates among the solid spheres; all enclosures are candidates.
    fn blockers(&self, id: usize, solids: &Solids) -> Option<Vec<SphereId>> {
        let mut blockers = Vec::new();
        let mut examine = |other: SphereId| {
            let Cover { some, all } = self.cover(id, other);
            if some {
                blockers.push(other);
            }
            // What else covers a hidden light does not matter; among many coincident ones that would be all of them.
            if all { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut examine_all = || {
            match solids {
                Solids::All => self.solid_ids().try_for_each(&mut examine),
                Solids::Sorted(neighbours) => neighbours.visit(&self.spheres[id], &mut examine),
            }?;
            self.enclosures.iter().try_for_each(|enclosure| examine(enclosure.sphere))
        };
        if examine_all().is_break() {
            return None;
        }
        blockers.sort_unstable();
        Some(blockers)
    }

    /// How much of the surface of sphere `id` is hidden from free space by sphere `other`.
    fn cover(&self, id: usize, other: SphereId) -> Cover {
        let (light, s) = (&self.spheres[id], &self.spheres[other as usize]);
        let (d, r) = (distance(light.center, s.center), f64::from(s.radius));
        // The surface of the light lies at distances from `nearest` to `farthest` of the other centre.
        let (nearest, farthest) = ((d - f64::from(light.radius)).abs(), d + f64::from(light.radius));
        match self.roles[other as usize] {
            _ if other as usize == id => Cover { some: false, all: false },
            Role::Solid | Role::Ground(_) => {
                Cover { some: nearest < r * (1.0 + TOUCHING), all: farthest <= r }
            }
            Role::Enclosure(_) => Cover { some: farthest > r * (1.0 - TOUCHING), all: nearest >= r },
            Role::Glass => Cover { some: false, all: false },
        }
    }

    /// The solid spheres, to find those near a lamp.
    fn solids(&self) -> Solids {
        let lamps = self.spheres.iter().filter(|s| s.is_emitter()).count();
        if lamps <= FEW_LAMPS {
            Solids::All
        } else {
            Solids::Sorted(Neighbours::new(&self.spheres, self.solid_ids().collect()))
        }
    }

    fn solid_ids(&self) -> impl Iterator<Item = SphereId> {
        let is_solid = |id: &SphereId| self.roles[*id as usize].is_solid();
        (0..self.spheres.len() as SphereId).filter(is_solid)
    }

    /// The hierarchy over the lights that were found.
    fn light_tree(&self) -> LightTree {
        if self.lights.entries.len() < 2 {
            return LightTree::default();
        }
        let (mut lamps, mut ambient) = (Vec::new(), Vec::new());
        for (number, light) in (0..).zip(&self.lights.entries) {
            let s = &self.spheres[light.sphere as usize];
            match self.roles[light.sphere as usize] {
                Role::Enclosure(_) => ambient.push((number, f64::from(max_component(s.emission)))),
                // The inner side of glass is chosen with the outer one.
                Role::Glass if light.inside => {}
                Role::Glass | Role::Solid | Role::Ground(_) => lamps.push(Lamp {
                    light: number,
                    center: s.center.as_dvec3(),
                    radius: f64::from(s.radius),
                    power: power_of(s),
                }),
            }
        }
        LightTree::new(lamps, &ambient)
    }

    fn find_shadow_casters(&mut self) {
        for id in &self.lights.blockers {
            if let Role::Enclosure(e) = self.roles[*id as usize] {
                self.enclosures[e as usize].casts_shadow = true;
            }
        }
    }
}

/// The power of one side of a glowing sphere in its brightest channel, in W.
fn power_of(s: &Sphere) -> f64 {
    let area = 4.0 * PI * f64::from(s.radius) * f64::from(s.radius);
    PI * area * f64::from(max_component(s.emission))
}

/// Distance in `f64`, from `f32` points.
fn distance(a: Vec3, b: Vec3) -> f64 {
    let v = a.as_dvec3() - b.as_dvec3();
    v.dot(v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::settings::Settings;
    use proptest::prelude::*;

    /// A scene of balls, by places on a coarse lattice so that many touch, nest or coincide; every other one glows.
    fn scene(balls: &[([i8; 3], u8, u8)], scale: f32, offset: f32) -> Scene {
        let materials = vec![
            Material::Diffuse { albedo: Rgb::splat(0.5) },
            Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 },
        ];
        let sphere = |(index, (place, radius, kind)): (usize, &([i8; 3], u8, u8))| Sphere {
            center: (Vec3::from_array(place.map(f32::from)) + offset) * scale,
            velocity: Vec3::ZERO,
            radius: f32::from(*radius) * 0.5 * scale,
            material: u32::from(*kind == 0),
            emission: if index % 2 == 0 { Rgb::ONE } else { Rgb::ZERO },
        };
        let spheres = balls.iter().enumerate().map(sphere).collect();
        let camera = Camera { eye: Vec3::splat(offset) * scale, ..Camera::default() };
        let settings = Settings::default();
        Scene {
            name: String::new(),
            camera,
            materials,
            spheres,
            background: Rgb::ZERO,
            transparent_background: false,
            settings,
            imports: Vec::new(),
        }
    }

    /// What [`Still::blockers`] says, asking every sphere.
    fn blockers_one_by_one(still: &Still, id: usize) -> Option<Vec<SphereId>> {
        let covers = || (0..still.spheres.len() as SphereId).map(|other| (other, still.cover(id, other)));
        let some = covers().filter(|(_, cover)| cover.some).map(|(other, _)| other);
        covers().all(|(_, cover)| !cover.all).then(|| some.collect())
    }

    proptest! {
        #[test]
        fn the_hierarchy_finds_the_blockers_that_a_search_of_all_finds(
            balls in prop::collection::vec((prop::array::uniform3(-12_i8..12), 1_u8..9, 0_u8..4), 1..120),
            enclosures in prop::collection::vec(20_u8..60, 0..4),
            exponent in -3_i32..7,
            offset in prop::sample::select(vec![0.0_f32, 1.0, 3000.0]),
        ) {
            let enclosures = enclosures.into_iter().map(|radius| ([1, 0, 0], radius, 1));
            let balls: Vec<_> = balls.into_iter().chain(enclosures).collect();
            let scene = scene(&balls, 10_f32.powi(exponent), offset);
            let still = scene.at(0.0);
            let solids = still.solids();
            for id in 0..still.spheres.len() {
                prop_assert_eq!(still.blockers(id, &solids), blockers_one_by_one(&still, id), "sphere {}", id);
            }
        }
    }

    #[test]
    fn surfaces_that_touch_are_found_at_every_place_of_the_hierarchy() {
        // A row of balls of radius 1, each touching the next two, but for rounding.
        let balls: Vec<_> = (0..100).map(|i| ([(i - 50) as i8 * 2, 3, 0], 2, 1)).collect();
        let scene = scene(&balls, 0.1, 0.3);
        let still = scene.at(0.0);
        let solids = still.solids();
        for id in 1..99_usize {
            let neighbours = [id as SphereId - 1, id as SphereId + 1];
            assert_eq!(still.blockers(id, &solids).as_deref(), Some(&neighbours[..]), "ball {id}");
        }
    }

    fn of(balls: &[(Vec3, f32, f32)]) -> Scene {
        crate::test_scenes::balls(balls)
    }

    /// A lamp of radius r and radiance L sends `4 pi^2 r^2 L`, and lights are chosen by that.
    #[test]
    fn lights_are_chosen_by_their_power() {
        let mut scene =
            of(&[(Vec3::X * 10.0, 1.0, 2.0), (Vec3::X * 20.0, 2.0, 1.0), (Vec3::X * 30.0, 1.0, 0.0)]);
        let mut spheres = scene.spheres.to_vec();
        spheres[1].emission = Rgb::new(0.25, 1.0, 0.5);
        scene.spheres = spheres.into();
        let still = scene.at(0.0);
        let lights = &still.lights;
        assert_eq!(lights.entries.len(), 2);
        assert!((f64::from(lights.power) / (4.0 * PI * PI * (2.0 + 4.0)) - 1.0).abs() < 1e-6);
        for (light, share) in lights.entries.iter().zip([1.0 / 3.0, 2.0 / 3.0]) {
            assert!((light.probability - share).abs() < 1e-6 && !light.inside, "{light:?}");
        }
        assert_eq!(lights.entries[0].photon_power, Rgb::ONE);
        assert_eq!(lights.entries[1].photon_power, Rgb::new(0.25, 1.0, 0.5));
        assert_eq!(lights.cumulative, [lights.entries[0].probability]);
        assert!(still.has_lamps() && !still.has_ambient_lights() && !still.is_enclosure(0));
    }

    /// What touches a lamp is looked at when light leaves it, whatever rounding, and what holds it leaves nothing.
    #[test]
    fn what_touches_a_lamp_may_hide_some_of_it() {
        let blockers = |balls: &[(Vec3, f32, f32)]| {
            let still_of = of(balls);
            let still = still_of.at(0.0);
            let range = still.lights.entries.first()?.blockers.clone();
            Some(still.lights.blockers[range.start as usize..range.end as usize].to_vec())
        };
        let lamp = (Vec3::X * 10.0, 2.0, 1.0);
        // Beside it, at a distance of both radii and a bit more or less.
        assert_eq!(blockers(&[lamp, (Vec3::X * 15.0, 3.0, 0.0)]), Some(vec![1]));
        assert_eq!(blockers(&[lamp, (Vec3::X * 15.01, 3.0, 0.0)]), Some(vec![]));
        // Around it, or as large as it at the same place.
        assert_eq!(blockers(&[lamp, (Vec3::X * 11.0, 3.0, 0.0)]), None);
        assert_eq!(blockers(&[lamp, (Vec3::X * 11.01, 3.0, 0.0)]), Some(vec![1]));
        // A room around eye and lamp, which touches it, stands off, or leaves it outside. The eye is at (0, -3, 0).
        assert_eq!(blockers(&[lamp, (Vec3::ZERO, 12.0, 0.0)]), Some(vec![1]));
        assert_eq!(blockers(&[lamp, (Vec3::ZERO, 12.01, 0.0)]), Some(vec![]));
        assert_eq!(blockers(&[lamp, (Vec3::ZERO, 8.0, 0.0)]), None);
        assert_eq!(blockers(&[lamp, (Vec3::ZERO, 8.01, 0.0)]), Some(vec![1]));
    }

    /// A room that cuts a lamp casts a shadow, one that holds it whole casts none.
    #[test]
    fn only_rooms_that_cut_lamps_cast_shadows() {
        let lamp = (Vec3::X * 10.0, 2.0, 1.0);
        for (radius, casts_shadow) in [(11.0, true), (20.0, false)] {
            let scene = of(&[lamp, (Vec3::ZERO, radius, 0.0)]);
            let still = scene.at(0.0);
            assert_eq!(still.enclosures.len(), 1);
            let enclosure = &still.enclosures[0];
            assert_eq!((enclosure.sphere, enclosure.casts_shadow), (1, casts_shadow));
            // The anchor is on the surface, on the side of the eye.
            assert!(
                (enclosure.anchor - Vec3::NEG_Y * radius).length() < 1e-5
                    && enclosure.offset == enclosure.anchor
            );
            assert_eq!(enclosure.twice_offset, 2.0 * enclosure.offset);
            assert!(
                (enclosure.minus_inverse_radius + 1.0 / radius).abs() < 1e-7 && enclosure.power.abs() < 1e-4
            );
            assert!(still.is_enclosure(1) && !still.is_enclosure(0));
        }
    }

    /// The sky is no lamp, and paths that meet it choose among lamps alone.
    #[test]
    fn ambient_lights_are_rooms_that_glow() {
        let mut scene = of(&[(Vec3::X * 10.0, 2.0, 1.0)]);
        scene.background = Rgb::splat(0.5);
        let scene = scene.with_sky();
        let still = scene.at(0.0);
        assert!(still.has_lamps() && still.has_ambient_lights());
        assert_eq!((still.lights.tree.ambient.len(), still.lights.entries.len()), (1, 2));
        let chosen = still.with_choice_of_lamps();
        assert!(chosen.lights.tree.ambient.is_empty() && chosen.lights.tree.ambient_irradiance == 0.0);
        let mut sky = of(&[(Vec3::X * 10.0, 2.0, 0.0)]);
        sky.background = Rgb::ONE;
        let sky = sky.with_sky();
        assert!(!sky.at(0.0).has_lamps() && sky.at(0.0).has_ambient_lights());
    }

    /// What glows is no ground, however close the eye is; glass is neither ground nor room.
    #[test]
    fn roles_follow_from_material_light_and_the_place_of_the_eye() {
        let role = |y: f32, radius: f32, radiance: f32, material: Material| {
            let mut scene = of(&[(Vec3::Y * y, radius, radiance)]);
            scene.materials = vec![material];
            scene.at(0.0).roles[0]
        };
        let albedo = Rgb::splat(0.5);
        let (diffuse, mirror) = (Material::Diffuse { albedo }, Material::Specular { albedo });
        let glass = Material::Dielectric { albedo, ior: 1.5 };
        // The eye is at (0, -3, 0), so 1 over a ball of radius 16 around (0, -20, 0).
        for (material, glows, expected) in [
            (diffuse, 0.0, [Role::Ground(0), Role::Solid, Role::Enclosure(0)]),
            (mirror, 0.0, [Role::Ground(0), Role::Solid, Role::Enclosure(0)]),
            (diffuse, 1.0, [Role::Solid, Role::Solid, Role::Enclosure(0)]),
            (glass, 0.0, [Role::Glass; 3]),
            (glass, 1.0, [Role::Glass; 3]),
        ] {
            let found =
                [(-20.0, 16.0), (-20.01, 16.0), (-4.0, 2.0)].map(|(y, r)| role(y, r, glows, material));
            assert_eq!(found, expected, "{material:?}, which glows by {glows}");
        }
    }

    /// For caustics there must be a lamp that is no sky, and something that makes them.
    #[test]
    fn photons_have_something_to_carry_or_there_are_none() {
        let has_photons = |radiance: f32, material: Material, background: Rgb| {
            let mut scene = of(&[(Vec3::X * 10.0, 1.0, radiance)]);
            scene.materials.push(material);
            let scene = Scene { background, ..scene }.with_sky();
            [Carried::All, Carried::Caustics].map(|carried| scene.at_for(0.0, carried).has_photons())
        };
        let albedo = Rgb::splat(0.5);
        let (diffuse, mirror) = (Material::Diffuse { albedo }, Material::Specular { albedo });
        let glass = Material::Dielectric { albedo, ior: 1.5 };
        assert_eq!(has_photons(1.0, mirror, Rgb::ZERO), [true, true]);
        assert_eq!(has_photons(1.0, glass, Rgb::ONE), [true, true]);
        assert_eq!(has_photons(1.0, diffuse, Rgb::ONE), [true, false]);
        assert_eq!(has_photons(0.0, mirror, Rgb::ONE), [true, false]);
        assert_eq!(has_photons(0.0, glass, Rgb::ZERO), [false, false]);
    }
}
