//! What a guide learns from walks that are made up for it.

use crate::cases::tell;
use reference::sampling::{cosine_hemisphere, uniform_sphere};
use scene::Vec3;
use scene::aim::Arrival;
use scene::guide::{Edge, FACES, Found, Guide, Guided, Lit, PARTS, SIDE, SURFACES};
use scene::sobol::sobol;

type Cell = [usize; 2];

/// A point of a cell, not at its border, where roundings decide; `k` spreads them.
fn within([row, column]: Cell, k: u32) -> (f32, f32) {
    let inner = |cell: usize, k: u32| (cell as f32 + 0.1 + 0.8 * (k % 16) as f32 / 15.0) / SIDE as f32;
    (inner(row, k), inner(column, k / 16))
}

/// A line that leaves a surface by a cell.
fn edge(walk: u32, (point, normal): (Vec3, Vec3), cell: Cell) -> Edge {
    let (u, v) = within(cell, walk);
    Edge { walk, point, normal, direction: cosine_hemisphere(normal, u, v) }
}

/// Light that leaves lamps by a cell.
fn lit(walk: u32, cell: Cell, flux: f32) -> Lit {
    let (u, v) = within(cell, walk);
    let arrival = Arrival { point: Vec3::ZERO, source: -3.0 * uniform_sphere(u, v), flux };
    Lit { walk, is_seen: false, arrival }
}

/// The share of photons that a surface scatters into a cell.
fn share(guide: &Guide, point: Vec3, normal: Vec3, cell: Cell) -> f64 {
    const NUMBERS: u32 = 64;
    let table = guide.surface(point, normal);
    let number = |k: u32| (k as f32 + 0.5) / NUMBERS as f32;
    let hits = (0..NUMBERS * NUMBERS).filter(|k| {
        let Guided { u, v, .. } = guide.guided(table, number(k / NUMBERS), number(k % NUMBERS));
        [u, v].map(|x| ((x * SIDE as f32) as usize).min(SIDE - 1)) == cell
    });
    hits.count() as f64 / f64::from(NUMBERS * NUMBERS)
}

/// The normal of each of the six faces, not along an axis.
fn normals() -> impl Iterator<Item = Vec3> {
    [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [1.0, -1.0].map(|sign| (sign * axis + Vec3::new(0.1, -0.2, 0.15)).normalize()))
}

/// The parts of a scene of parts of side 1, by their lower corners.
fn parts() -> impl Iterator<Item = Vec3> {
    let side = |k: u32| (k % PARTS) as f32;
    (0..PARTS.pow(3)).map(move |k| Vec3::new(side(k), side(k / PARTS), side(k / PARTS / PARTS)))
}

/// Surfaces in each part of the scene, and on each side of it, scatter photons their own way, wherever the scene is.
#[test]
fn every_part_of_the_scene_and_every_side_has_what_it_has_learnt() {
    const LINES: u32 = 192;
    let surfaces: Vec<(Vec3, Vec3)> =
        parts().flat_map(|part| normals().map(move |normal| (part, normal))).collect();
    assert_eq!(surfaces.len() as u32, SURFACES);
    // Neighbours along any axis, and opposite sides, differ in theirs.
    let cell = |k: usize| [(k * 5 + k / 6) % SIDE, (k * 3 + k / 48 + k % 6 / 2) % SIDE];
    for origin in [Vec3::ZERO, Vec3::new(64.0, -32.0, 16.0)] {
        let mut found = Found::default();
        for line in 0..LINES {
            // In the middle of the part, so that its borders may be anywhere near.
            let offset = Vec3::from_array([1, 3, 5].map(|step| 0.2 + 0.6 * (line * step % 32) as f32 / 31.0));
            for (k, (part, normal)) in surfaces.iter().enumerate() {
                found.edges.push(edge(line, (origin + *part + offset, *normal), cell(k)));
            }
        }
        let guide = Guide::learn(LINES, &[found], 1.0).expect("a guide");
        for (k, (part, normal)) in surfaces.iter().enumerate() {
            // Three parts of five are its own lines, of which 5/8 count.
            let share = share(&guide, origin + *part + 0.5, *normal, cell(k));
            assert!(share > 0.3, "{share} of the photons at {part} that face {normal}");
        }
    }
    tell("physics", 2 * surfaces.len(), "surfaces that have learnt their own");
}

/// A surface of which next to nothing is known does as others that face the same way.
#[test]
fn surfaces_that_are_hardly_known_do_as_others_that_face_the_same_way() {
    const WALKS: u32 = 2048;
    let known = |face: usize| [face + 1, 6 - face];
    let mut found = Found::default();
    for walk in 0..WALKS {
        for (face, normal) in normals().enumerate() {
            found.edges.push(edge(walk, (Vec3::splat(0.5), normal), known(face)));
        }
        // The box of parts reaches as far as this.
        if walk % 16 == 0 {
            found.edges.push(edge(walk, (Vec3::splat(3.5), Vec3::Y), known(2)));
        }
    }
    let guide = Guide::learn(WALKS, &[found], 1.0).expect("a guide");
    for (face, normal) in normals().enumerate() {
        let share = share(&guide, Vec3::new(1.5, 2.5, 0.5), normal, known(face));
        assert!(share > 0.5, "{share} of the photons that face {normal}");
    }
    tell("physics", FACES as usize, "faces of which the scene is likely to be alike");
}

/// Whether a walk begins in the left half of the image, by its Sobol point.
fn is_left(walk: u32) -> bool {
    sobol(walk, 0) >> 31 == 0
}

const WALKS: u32 = 4096;
const LEFT: Cell = [1, 2];
const RIGHT: Cell = [5, 6];

/// A place in one of four parts of a scene.
fn somewhere(walk: u32) -> Vec3 {
    Vec3::splat((walk / 16 % 4) as f32)
}

/// What a guide learns if walks of both halves of the image leave surfaces by a cell of their own, and so much light comes to
/// either.
fn halves(left: f32, right: f32) -> Guide {
    let mut found = Found::default();
    for walk in 0..WALKS {
        let (cell, flux) = if is_left(walk) { (LEFT, left) } else { (RIGHT, right) };
        found.edges.push(edge(walk, (somewhere(walk), Vec3::Y), cell));
        found.lit.push(lit(walk, cell, flux));
    }
    Guide::learn(WALKS, &[found], 1.0).expect("a guide")
}

/// How many times as many photons go to the left as to the right, but for what is spread evenly: what a cell has that
/// nothing leads to.
fn left_over_right(of: impl Fn(Cell) -> f64) -> f64 {
    (of(LEFT) - of([0, 0])) / (of(RIGHT) - of([0, 0]))
}

/// Errors count relative to the brightness around them, so what is bright needs no more photons than what is dark. Lamps,
/// which send as much to either as light arrives there, spread them alike. Of lines it is not known how much light comes by
/// them: those that lead to where it is bright count as much less.
#[test]
fn bright_and_dark_halves_of_the_image_get_photons_alike() {
    /// The least brightness that counts, a tenth of the mean square, is 3 % of the darker half's; and tables of 2^-16.
    const NEAR: f64 = 0.05;
    for (left, right) in [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (100.0, 100.0)] {
        let guide = halves(left, right);
        let surface = left_over_right(|cell| share(&guide, Vec3::ZERO, Vec3::Y, cell));
        let lamps = left_over_right(|[row, column]| guide.departures[row][column]);
        assert!((lamps - 1.0).abs() < NEAR, "{left} and {right}: {lamps} from lamps");
        let expected = f64::from(right / left);
        assert!((surface / expected - 1.0).abs() < NEAR, "{left} and {right}: {surface}, not {expected}");
    }
}

/// Lamps send photons where they give light, in proportion to it.
#[test]
fn lamps_send_photons_in_proportion_to_the_light_that_arrives() {
    /// Sums of `f32`.
    const NEAR: f64 = 1e-3;
    let mut found = Found::default();
    for walk in 0..WALKS {
        found.edges.push(edge(walk, (somewhere(walk), Vec3::Y), LEFT));
        found.lit.push(lit(walk, LEFT, 3.0));
        found.lit.push(lit(walk, RIGHT, 1.0));
    }
    let guide = Guide::learn(WALKS, &[found], 1.0).expect("a guide");
    let ratio = left_over_right(|[row, column]| guide.departures[row][column]);
    assert!((ratio / 3.0 - 1.0).abs() < NEAR, "{ratio} times as many photons for three times the light");
}
