//! Kernels that map uniform numbers to points, directions, camera rays and lights.

use super::inputs::{direction, numbers};
use super::{assert_same, check_map, edge_directions, edge_uniforms, lane_kinds, tell};
use fast::kernels::{
    camera_ray, choose_light, cosine_hemisphere, max_component, orthonormal_frame, sincos_turn, uniform_cone,
    uniform_disk, uniform_sphere, unit,
};
use reference::camera_pass::ray_through;
use reference::sampling as definition;
use scene::camera::Frame;
use scene::rng::unit_float;
use scene::{Vec3, max_component as largest};

const RANDOM: u32 = 30_000;

/// Pairs of uniform numbers: all pairs of edge cases, and random ones.
fn uniform_pairs() -> Vec<[f32; 2]> {
    let edges = edge_uniforms();
    let mut stream = numbers(20);
    let random = (0..RANDOM).map(|_| [stream.next_f32(), stream.next_f32()]);
    let edges = edges.iter().flat_map(|u| edges.iter().map(|v| [*u, *v]));
    edges.chain(random.collect::<Vec<_>>()).collect()
}

/// Directions combined with pairs of uniform numbers.
fn directions_and_uniforms() -> Vec<(Vec3, [f32; 2])> {
    let pairs = uniform_pairs();
    let mut stream = numbers(21);
    let edges = edge_directions();
    let many = edges.iter().flat_map(|d| pairs.iter().take(700).map(|pair| (*d, *pair)));
    let random = pairs.iter().map(|pair| (direction(&mut stream), *pair));
    many.chain(random.collect::<Vec<_>>()).collect()
}

/// Every float that a stream can give, in pieces that fit in the cache.
#[test]
fn sine_and_cosine_of_every_uniform_number() {
    const PIECE: u32 = 1 << 12;
    let mut cases = 0;
    for first in (0..1_u32 << 24).step_by(PIECE as usize) {
        let u: Vec<f32> = (first..first + PIECE).map(|top| unit_float(top << 8)).collect();
        let expected: (Vec<f32>, Vec<f32>) = u.iter().map(|u| definition::sincos_turn(*u)).unzip();
        for lanes in lane_kinds() {
            let (mut sin, mut cos) = (vec![0.0; u.len()], vec![0.0; u.len()]);
            sincos_turn(lanes, [&u], [&mut sin, &mut cos]);
            assert_same(&sin, &expected.0, &(lanes, first, "sine"));
            assert_same(&cos, &expected.1, &(lanes, first, "cosine"));
            cases += u.len();
        }
    }
    tell(cases, "sine and cosine");
}

#[test]
fn sine_and_cosine_with_the_signs_of_their_zeros() {
    let rows: Vec<[f32; 1]> = edge_uniforms().into_iter().map(|u| [u]).collect();
    let exact = |[u]: [f32; 1]| definition::sincos_turn(u).into();
    tell(check_map("sincos_turn", &rows, sincos_turn, exact), "sine and cosine at the edges");
}

#[test]
fn disks_and_spheres() {
    let pairs = uniform_pairs();
    let disk = |[u, v]: [f32; 2]| definition::uniform_disk(u, v).into();
    let sphere = |[u, v]: [f32; 2]| definition::uniform_sphere(u, v).to_array();
    let cases = check_map("uniform_disk", &pairs, uniform_disk, disk)
        + check_map("uniform_sphere", &pairs, uniform_sphere, sphere);
    tell(cases, "disks and spheres");
}

#[test]
fn hemispheres() {
    let mut rows: Vec<[f32; 5]> =
        directions_and_uniforms().into_iter().map(|(n, [u, v])| [n.x, n.y, n.z, u, v]).collect();
    // If the point on the sphere is opposite to the normal, their sum is zero and cannot be normalised.
    for [u, v] in uniform_pairs() {
        let n = -definition::uniform_sphere(u, v);
        rows.push([n.x, n.y, n.z, u, v]);
    }
    let exact =
        |[x, y, z, u, v]: [f32; 5]| definition::cosine_hemisphere(Vec3::new(x, y, z), u, v).to_array();
    tell(check_map("cosine_hemisphere", &rows, cosine_hemisphere, exact), "hemispheres");
}

#[test]
fn cones() {
    let heights = [0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0, 1.5, 2.0];
    let row = |(k, (a, [u, v])): (usize, (Vec3, [f32; 2]))| [a.x, a.y, a.z, heights[k % heights.len()], u, v];
    let rows: Vec<[f32; 6]> = directions_and_uniforms().into_iter().enumerate().map(row).collect();
    let exact = |[x, y, z, height, u, v]: [f32; 6]| {
        let (d, h) = definition::uniform_cone(Vec3::new(x, y, z), height, u, v);
        [d.x, d.y, d.z, h]
    };
    tell(check_map("uniform_cone", &rows, uniform_cone, exact), "cones");
}

#[test]
fn frames_and_unit_vectors() {
    let mut stream = numbers(22);
    let random = (0..RANDOM).map(|_| direction(&mut stream));
    let directions: Vec<Vec3> = edge_directions().into_iter().chain(random).collect();
    let rows: Vec<[f32; 3]> = directions.iter().map(Vec3::to_array).collect();
    let frame = |n: [f32; 3]| {
        let (s, t) = definition::frame(Vec3::from_array(n));
        [s.x, s.y, s.z, t.x, t.y, t.z]
    };
    // The frame depends on the sign of z, even that of a zero.
    let flat: Vec<[f32; 3]> = rows.iter().flat_map(|[x, y, _]| [[*x, *y, 0.0], [*x, *y, -0.0]]).collect();
    let mut cases = check_map("orthonormal_frame", &[rows.clone(), flat].concat(), orthonormal_frame, frame);
    let scaled: Vec<[f32; 3]> = rows
        .iter()
        .enumerate()
        .map(|(k, v)| v.map(|x| x * 10.0_f32.powi(k as i32 % 37 - 18)))
        .chain([[0.0; 3], [-0.0, 0.0, 1e-30]])
        .collect();
    let to_unit = |v: [f32; 3]| definition::unit(Vec3::from_array(v)).to_array();
    cases += check_map("unit", &scaled, unit, to_unit);
    tell(cases, "frames and unit vectors");
}

#[test]
fn the_largest_component() {
    let few = [0.0, -0.0, 1.0, -1.0, 2.0, f32::INFINITY];
    let row = |k: usize| [few[k / 36], few[k / 6 % 6], few[k % 6]];
    let rows: Vec<[f32; 3]> = (0..216).map(row).collect();
    let exact = |c: [f32; 3]| [largest(Vec3::from_array(c))];
    tell(check_map("max_component", &rows, max_component, exact), "largest components");
}

#[test]
fn camera_rays() {
    let frame = |aperture_radius| Frame {
        eye: Vec3::new(1.0, -2.0, 30.0),
        forward: Vec3::new(0.48, -0.6, -0.64),
        right: Vec3::new(0.8, 0.0, 0.6),
        up: Vec3::new(0.36, 0.8, -0.48),
        pixel: 0.004,
        half: [160.5, 120.0],
        aperture_radius,
        focus_distance: 7.5,
    };
    let mut cases = 0;
    for aperture in [0.0, 1e-3, 0.5] {
        let frame = frame(aperture);
        let mut stream = numbers(23);
        let mut rows: Vec<[f32; 4]> = Vec::new();
        for [u, v] in uniform_pairs() {
            rows.push([stream.next_f32() * 321.0, stream.next_f32() * 240.0, u, v]);
        }
        let kernel =
            |lanes, inputs: [&[f32]; 4], outputs: [&mut [f32]; 6]| camera_ray(lanes, frame, inputs, outputs);
        let exact = |[x, y, u, v]: [f32; 4]| {
            let ray = ray_through(&frame, (x, y), (aperture > 0.0).then_some((u, v)));
            let (o, d) = (ray.origin, ray.direction);
            [o.x, o.y, o.z, d.x, d.y, d.z]
        };
        cases += check_map("camera_ray", &rows, kernel, exact);
    }
    tell(cases, "camera rays");
}

/// Numbers of lights on both sides of 16, above which lights are found by a search, and uniform numbers at the
/// boundaries between lights.
#[test]
fn choices_of_lights() {
    let mut cases = 0;
    for lights in (1..40).chain([100, 1000]) {
        let mut stream = numbers(100 + lights);
        let weights: Vec<f32> =
            (0..lights).map(|k| if k % 5 == 4 { 0.0 } else { stream.next_f32() }).collect();
        let total: f32 = weights.iter().sum();
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = Vec::new();
        for weight in &weights[1..] {
            sum += weight;
            cumulative.push((sum / total).min(1.0));
        }
        let at_steps = cumulative.iter().flat_map(|c| [c.next_down(), *c, c.next_up()]);
        let rows: Vec<[f32; 1]> = edge_uniforms()
            .into_iter()
            .chain(at_steps)
            .chain((0..200).map(|_| stream.next_f32()))
            .map(|u| [u])
            .collect();
        let kernel = |lanes, inputs: [&[f32]; 1], outputs: [&mut [f32]; 1]| {
            choose_light(lanes, cumulative.clone(), inputs, outputs);
        };
        let exact = |[u]: [f32; 1]| [f32::from_bits(cumulative.iter().filter(|c| **c <= u).count() as u32)];
        cases += check_map("choose_light", &rows, kernel, exact);
    }
    tell(cases, "choices of lights");
}
