//! The choice of a light for a point.

use super::inputs::{direction, numbers, place, scene_of};
use super::{assert_same, edge_uniforms, lane_kinds, tell};
use fast::kernels::{Receiver, choose_for_points};
use reference::light_choice::choose;
use scene::ray::NO_SPHERE;
use scene::rng::Stream;
use scene::{Rgb, Scene, Sphere, Vec3};

/// Points per scene: one length for every tail of a packet.
const POINTS: usize = 16 * 20 + 7;

/// Lamps of all sizes and brightnesses in a cube of side 2, some of glass, some in heaps or at one place.
fn lamps(count: u32, enclosures: u32, sky: bool, (scale, offset): (f32, f32), stream: &mut Stream) -> Scene {
    let mut spheres = Vec::new();
    for index in 0..count + enclosures {
        let is_enclosure = index >= count;
        let size = stream.next_f32();
        let heap = [1.0, 0.05, 0.05, 0.0][index as usize % 4];
        let strength = [1.0, 1e-6, 1.0, 1e6, 1.0][index as usize % 5];
        let radius = if is_enclosure { 20.0 + size } else { 0.001 + 0.1 * size * size };
        spheres.push(Sphere {
            center: (place(stream, if is_enclosure { 1.0 } else { 2.0 * heap }) + offset) * scale,
            velocity: Vec3::ZERO,
            radius: radius * scale,
            material: if is_enclosure { 0 } else { index % 3 },
            emission: Rgb::new(1.0, 0.5, 0.0) * (0.01 + strength * stream.next_f32()),
        });
    }
    let eye = (Vec3::Z * 5.0 + offset) * scale;
    let background = if sky { Rgb::splat(0.02) } else { Rgb::ZERO };
    Scene { background, ..scene_of(spheres, eye) }.with_sky()
}

/// A point among the lamps, or at a lamp's centre or surface.
fn receiver(scene: &Scene, (scale, offset): (f32, f32), stream: &mut Stream) -> Receiver {
    let normal = direction(stream);
    let lamp = &scene.spheres[(stream.next_f32() * scene.spheres.len() as f32) as usize];
    let point = match (stream.next_f32() * 8.0) as u32 {
        0 => lamp.center,
        1 => lamp.center + normal * lamp.radius,
        2 => lamp.center + normal * lamp.radius * 0.5,
        _ => (place(stream, 3.0) + offset) * scale,
    };
    Receiver { point, normal, sphere: NO_SPHERE }
}

#[test]
fn lights_chosen_for_points() {
    let mut cases = 0;
    let mut stream = numbers(90);
    let (mut found, mut ambient_found, mut inner_found) = (0, 0, 0);
    for count in [0, 1, 2, 3, 4, 9, 17, 60, 300, 2000] {
        for (enclosures, sky) in [(0, false), (0, true), (1, false), (3, true)] {
            for unit in [(1.0, 0.0), (1e-4, 0.0), (1e5, 0.0), (1.0, 3000.0)] {
                let scene = lamps(count, enclosures, sky, unit, &mut stream);
                let still = scene.at(0.0);
                if still.lights.entries.is_empty() {
                    continue;
                }
                let receivers: Vec<Receiver> =
                    (0..POINTS).map(|_| receiver(&scene, unit, &mut stream)).collect();
                let mut choice = edge_uniforms();
                choice.resize_with(POINTS, || stream.next_f32());
                let expected: Vec<_> = receivers
                    .iter()
                    .zip(&choice)
                    .map(|(r, u)| {
                        let Receiver { point, normal, sphere } = *r;
                        choose(&still, &reference::light_choice::Receiver { point, normal, sphere }, *u)
                    })
                    .collect();
                for light in expected.iter().flatten().map(|choice| choice.light) {
                    found += 1;
                    ambient_found +=
                        usize::from(still.lights.tree.ambient.iter().any(|ambient| ambient.light == light));
                    inner_found += usize::from(still.lights.entries[light as usize].inside);
                }
                for lanes in lane_kinds() {
                    let actual = choose_for_points(&still, &receivers, &choice, lanes);
                    assert_eq!(actual.len(), expected.len());
                    for (k, (a, e)) in actual.iter().zip(&expected).enumerate() {
                        let what = (lanes, count, enclosures, sky, unit, receivers[k], choice[k]);
                        assert_eq!(a.map(|a| a.0), e.map(|e| e.light), "{what:?}");
                        if let (Some(a), Some(e)) = (a, e) {
                            assert_same(&[a.1], &[e.probability], &what);
                        }
                    }
                    cases += actual.len();
                }
            }
        }
    }
    assert!(ambient_found > 1000 && inner_found > ambient_found + 100 && found > 10_000, "a kind is missing");
    tell(cases, "lights chosen for points");
}
