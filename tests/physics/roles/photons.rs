//! The roles of the random numbers of photons: a scene for each that shows its number.

use super::camera::half_mirror;
use super::{Role, hemisphere_numbers, sphere_numbers};
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, pinhole, settings};
use glam::DVec3;
use reference::photon_pass::{Deposit, photon_pass};
use scene::aim::Aim;
use scene::{Rgb, Scene, Settings, Stats, Still, Vec3};

/// The last bounce that is tested: one beyond the first that has numbers of the stream.
const LAST_BOUNCE: u32 = 2;

/// Radius of the shell around everything, which is sphere 0.
const SHELL: f32 = 100.0;

/// A photon of an iteration, whatever the seed.
#[derive(Clone, Copy)]
struct Photon {
    iteration: u32,
    index: u32,
}

impl Photon {
    /// What the photon deposits on the shell.
    fn deposits(self, still: &Still, seed: u64, depth: u32) -> Vec<Deposit> {
        let settings = Settings { seed, ..settings(1, 1, self.index + 1, depth, 1.0) };
        let mut deposits = Vec::new();
        let photons = self.index..self.index + 1;
        let (aim, mut stats) = (Aim::default(), Stats::default());
        photon_pass(still, &aim, &settings, self.iteration, photons, &mut stats, |deposit, _| {
            deposits.push(*deposit);
        });
        deposits.retain(|deposit| deposit.sphere == 0);
        deposits
    }
}

/// True for the two numbers of a bounce of which only one is used: the first of a direction, which chooses the lobe at
/// glass.
pub(super) fn is_either(a: &str, b: &str) -> bool {
    let bounce = |name: &str, role: &str| name.strip_prefix(role).map(str::to_owned);
    let height = bounce(a, "direction's height at bounce ");
    height.is_some() && height == bounce(b, "lobe at bounce ")
}

/// The roles of a photon.
pub(super) fn roles(iteration: u32, index: u32) -> Vec<Role> {
    let photon = Photon { iteration, index };
    let mut roles = vec![lamp(photon)];
    roles.extend(emission(photon));
    for bounce in 0..=LAST_BOUNCE {
        roles.extend(direction(photon, bounce));
        roles.push(roulette(photon, bounce));
        roles.push(lobe(photon, bounce));
    }
    roles
}

pub(super) fn shell(albedo: f32) -> Scene {
    empty_scene(pinhole(Vec3::Z * 90.0, Vec3::ZERO, 60.0)).ball(Vec3::ZERO, SHELL, diffuse(albedo))
}

/// Two lamps of different colours, each in glass of index 1, so that photons are deposited where they hit the shell.
fn lamp(photon: Photon) -> Role {
    let scene =
        [(Vec3::X, Rgb::X), (Vec3::NEG_X, Rgb::Y)].into_iter().fold(shell(0.0), |scene, (at, color)| {
            scene.lamp(at * 20.0, 1.0, BLACK, color).ball(at * 20.0, 2.0, glass(1.0, 1.0))
        });
    let still = scene.at(0.0);
    Role::of_few("choice of lamp by photons", |seed| {
        let deposits = photon.deposits(&still, seed, 2);
        deposits.first().map(|deposit| usize::from(deposit.flux.units[0] > 0))
    })
}

/// Where on the lamp photons start, and in which direction.
fn emission(photon: Photon) -> [Role; 4] {
    let scene = shell(0.0).lamp(Vec3::ZERO, 1.0, BLACK, Rgb::ONE).ball(Vec3::ZERO, 1.5, glass(1.0, 1.0));
    let still = scene.at(0.0);
    let start = |seed| {
        let deposits = photon.deposits(&still, seed, 2);
        let (point, wi) = (deposits[0].point.as_dvec3(), deposits[0].wi.as_dvec3());
        let b = point.dot(wi);
        let half_chord = (1.0 - (point.length_squared() - b * b)).max(0.0).sqrt();
        ((point + wi * (-b - half_chord)).normalize(), -wi)
    };
    let place = |seed, i: usize| Some(sphere_numbers(start(seed).0)[i]);
    let direction = |seed, i: usize| {
        let (normal, direction) = start(seed);
        Some(hemisphere_numbers(normal, direction)[i])
    };
    [
        Role::of_many("start on the lamp, height", |seed| place(seed, 0)),
        Role::of_many("start on the lamp, angle", |seed| place(seed, 1)),
        Role::of_many("direction from the lamp, height", |seed| direction(seed, 0)),
        Role::of_many("direction from the lamp, angle", |seed| direction(seed, 1)),
    ]
}

/// A tiny lamp in `covers` balls of glass of index 1, one within the other: as many bounces that change nothing.
pub(super) fn covered(scene: Scene, covers: u32) -> Scene {
    let scene = scene.lamp(Vec3::ZERO, 1e-3, BLACK, Rgb::ONE);
    (0..covers).fold(scene, |scene, i| scene.ball(Vec3::ZERO, 0.01 * (1.0 + i as f32), glass(1.0, 1.0)))
}

/// The direction in which a photon leaves a white shell, told by where it arrives again.
fn direction(photon: Photon, bounce: u32) -> [Role; 2] {
    let scene = covered(shell(1.0), bounce);
    let still = scene.at(0.0);
    let number = |seed, i: usize| {
        let deposits = photon.deposits(&still, seed, bounce + 2);
        let last = deposits.last().filter(|_| deposits.len() == 1 + usize::from(bounce > 0))?;
        let (point, wi) = (last.point.as_dvec3(), last.wi.as_dvec3());
        let before: DVec3 = point - wi * (2.0 * point.dot(wi));
        Some(hemisphere_numbers(-before.normalize(), -wi)[i])
    };
    [
        Role::of_many(format!("direction's height at bounce {bounce}"), |seed| number(seed, 0)),
        Role::of_many(format!("direction's angle at bounce {bounce}"), |seed| number(seed, 1)),
    ]
}

/// Whether a photon survives at a grey shell.
fn roulette(photon: Photon, bounce: u32) -> Role {
    let scene = covered(shell(0.5), bounce);
    let still = scene.at(0.0);
    Role::of_two(format!("roulette at bounce {bounce}"), |seed| {
        photon.deposits(&still, seed, bounce + 2).len() > usize::from(bounce > 0)
    })
}

/// Whether a photon passes through glass that reflects half.
fn lobe(photon: Photon, bounce: u32) -> Role {
    let scene = covered(shell(0.0), bounce).ball(Vec3::ZERO, 10.0, glass(1.0, half_mirror()));
    let still = scene.at(0.0);
    Role::of_two(format!("lobe at bounce {bounce}"), |seed| {
        !photon.deposits(&still, seed, bounce + 2).is_empty()
    })
}
