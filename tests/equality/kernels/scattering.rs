//! Kernels for mirrors, glass, the quantisation of flux, and Russian roulette.

use super::inputs::{direction, numbers};
use super::{check_map, edge_directions, edge_uniforms, tell};
use fast::kernels::{dielectric, dielectric_by_roots, fresnel, quantise, quantise_aimed, reflect, survive};
use reference::intersect::Hit;
use reference::photon_pass::Flux;
use reference::{photon_pass, scatter};
use scene::aim::{Aim, MOST_SCALE_BITS};
use scene::film::FLUX_ONE;
use scene::{Rgb, Vec3};

const INDICES: [f32; 7] = [1.0, 1.000_001, 1.1, 1.5, 2.4, 10.0, 100.0];

/// Pairs of a direction and a normal: perpendicular to the surface, grazing, parallel to it, and from behind.
fn meetings() -> Vec<(Vec3, Vec3)> {
    let mut stream = numbers(30);
    let mut all = Vec::new();
    for n in edge_directions() {
        for d in edge_directions() {
            all.push((d, n));
        }
        let tangent = reference::sampling::frame(n).0;
        for grazing in [1e-7, 1e-5, 1e-3, 0.1, 0.5] {
            all.push((reference::sampling::unit(tangent - n * grazing), n));
            all.push((reference::sampling::unit(tangent + n * grazing), n));
        }
    }
    all.extend((0..20_000).map(|_| (direction(&mut stream), direction(&mut stream))));
    all
}

#[test]
fn mirrors() {
    let rows: Vec<[f32; 6]> = meetings().into_iter().map(|(d, n)| [d.x, d.y, d.z, n.x, n.y, n.z]).collect();
    let exact = |[dx, dy, dz, nx, ny, nz]: [f32; 6]| {
        scatter::reflect(Vec3::new(dx, dy, dz), Vec3::new(nx, ny, nz)).to_array()
    };
    tell(check_map("reflect", &rows, reflect, exact), "mirrors");
}

#[test]
fn reflectances() {
    let cosines = [0.0, 1e-30, 1e-6, 1e-3, 0.1, 0.5, 0.707_106_77, 0.9, 1.0, 1.000_000_1];
    let mut rows = Vec::new();
    for eta in INDICES.into_iter().flat_map(|ior| [ior, 1.0 / ior]) {
        rows.extend(cosines.iter().flat_map(|a| cosines.iter().map(move |b| [eta, *a, *b])));
    }
    let mut stream = numbers(31);
    rows.extend((0..20_000).map(|_| [0.2 + 3.0 * stream.next_f32(), stream.next_f32(), stream.next_f32()]));
    let exact = |[eta, a, b]: [f32; 3]| [scatter::fresnel(eta, a, b)];
    tell(check_map("fresnel", &rows, fresnel, exact), "reflectances");
}

/// Some random numbers are equal to the probability of reflection or next to it, to test ties.
#[test]
fn glass() {
    let uniforms = edge_uniforms();
    let mut rows = Vec::new();
    for (k, (d, n)) in meetings().into_iter().enumerate() {
        let ior = INDICES[k % INDICES.len()];
        let is_inside = k % 2 == 1;
        let eta = if is_inside { ior } else { 1.0 / ior };
        let cos_i = -d.dot(n);
        let cos2_t = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
        let share = scatter::fresnel(eta, cos_i, if cos2_t > 0.0 { cos2_t.sqrt() } else { 0.0 });
        let inside = f32::from(u8::from(is_inside));
        let [reflected, refracted] = [share.sqrt(), (1.0 - share).sqrt()];
        let by_roots = reflected / (reflected + refracted);
        let ties = [share, by_roots].into_iter().flat_map(|tie| [tie, tie.next_up(), tie.next_down()]);
        for u in ties.chain([uniforms[k % uniforms.len()], 0.0, 0.999_999_94]) {
            rows.push([d.x, d.y, d.z, n.x, n.y, n.z, inside, ior, u]);
        }
    }
    let exact = |by: fn(Vec3, &Hit, f32, f32) -> (Vec3, f32)| {
        move |[dx, dy, dz, nx, ny, nz, inside, ior, u]: [f32; 9]| {
            let normal = Vec3::new(nx, ny, nz);
            let hit = Hit { sphere: 0, t: 1.0, point: Vec3::ZERO, normal, inside: inside > 0.0 };
            let (d, scale) = by(Vec3::new(dx, dy, dz), &hit, ior, u);
            [d.x, d.y, d.z, scale]
        }
    };
    let cases = check_map("dielectric", &rows, dielectric, exact(scatter::dielectric))
        + check_map("dielectric_by_roots", &rows, dielectric_by_roots, exact(scatter::dielectric_by_roots));
    tell(cases, "glass");
}

/// Half units of flux, the largest flux, and values that rounding can bring above it.
#[test]
fn fluxes() {
    let unit = 1.0 / FLUX_ONE as f32;
    let mut powers = vec![0.0, 1e-30, unit, 1.0, 1.0_f32.next_up(), 1.0_f32.next_down(), 1.000_01, 1.1];
    for k in [0.5, 1.5, 2.5, 1000.5, 1_048_575.5, 2_097_150.5, 2_097_151.5] {
        let half: f32 = unit * k;
        powers.extend([half.next_down(), half, half.next_up()]);
    }
    let mut stream = numbers(32);
    powers.extend((0..50_000).map(|_| stream.next_f32()));
    let rows: Vec<[f32; 1]> = powers.into_iter().map(|power| [power]).collect();
    let exact = |[power]: [f32; 1]| {
        [f32::from_bits(photon_pass::quantise(&Aim::default(), Rgb::splat(power)).units[2])]
    };
    tell(check_map("quantise", &rows, quantise, exact), "quantised fluxes");
}

/// In every unit, by powers of every magnitude that fluxes may have, next to powers of two above all.
#[test]
fn quantised_fluxes_of_aimed_photons() {
    let mut stream = numbers(34);
    let mut count = 0;
    for scale_bits in 0..=MOST_SCALE_BITS {
        let aim = Aim { ends: vec![1], scale_bits, ..Aim::default() };
        let mut rows: Vec<[f32; 3]> = vec![[0.0; 3]];
        for exponent in -(scale_bits as i32) - 24..=5 {
            let one = 2_f32.powi(exponent);
            for brightest in [one, one.next_down(), one.next_up(), one * (1.0 + stream.next_f32())] {
                let mut row = [brightest, brightest * stream.next_f32(), brightest * stream.next_f32()];
                row.rotate_left(rows.len() % 3);
                rows.push(row);
            }
        }
        let exact = |power: [f32; 3]| {
            let Flux { units: [r, g, b], shift } = photon_pass::quantise(&aim, Rgb::from_array(power));
            let [r, g, b] = [r | shift << 24, g, b].map(f32::from_bits);
            [r, g, b, if shift > 0 { 1.0 } else { 0.0 }]
        };
        let kernel = |lanes, inputs: [&[f32]; 3], outputs: [&mut [f32]; 4]| {
            quantise_aimed(lanes, aim.scale(), inputs, outputs);
        };
        count += check_map("quantise_aimed", &rows, kernel, exact);
    }
    tell(count, "quantised fluxes of aimed photons");
}

/// Some random numbers are equal to the survival probability or next to it, to test ties.
#[test]
fn roulette() {
    let shares = [0.0, 1e-30, 0.25, 0.5, 0.75, 1.0];
    let mut stream = numbers(33);
    let mut rows: Vec<[f32; 7]> = Vec::new();
    for k in 0..30_000 {
        let mut number =
            |k: usize| if k.is_multiple_of(3) { shares[k / 3 % shares.len()] } else { stream.next_f32() };
        let power = [1.0, number(k), number(k / 2)];
        let albedo = [number(k / 5), number(k + 1), number(k + 2)];
        let after = scene::max_component(Rgb::from_array(power) * Rgb::from_array(albedo));
        for u in [after, after.next_up(), after.next_down().max(0.0), 0.0, 0.5, number(k + 4)] {
            rows.push([power[0], power[1], power[2], albedo[0], albedo[1], albedo[2], u]);
        }
    }
    let exact = |[px, py, pz, ax, ay, az, u]: [f32; 7]| {
        let survivor = photon_pass::survive(Vec3::new(px, py, pz), Vec3::new(ax, ay, az), u);
        survivor.map_or([0.0; 4], |p| [1.0, p.x, p.y, p.z])
    };
    // The power of a photon that does not survive is unspecified; set it to zero for the comparison.
    let kernel = |lanes, inputs: [&[f32]; 7], [survives, x, y, z]: [&mut [f32]; 4]| {
        survive(lanes, inputs, [&mut *survives, &mut *x, &mut *y, &mut *z]);
        for (k, survives) in survives.iter().enumerate().filter(|(_, survives)| **survives == 0.0) {
            (x[k], y[k], z[k]) = (*survives, *survives, *survives);
        }
    };
    tell(check_map("survive", &rows, kernel, exact), "roulette");
}
