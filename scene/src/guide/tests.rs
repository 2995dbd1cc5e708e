//! Tests of tables, of departures, and of what is learnt from walks that are made up.

use super::table::CELL;
use super::*;
use crate::aim::{Arrival, RUN};
use glam::Vec3;
use std::f32::consts::TAU;

/// Shares that differ in all cells, and of which some are 0.
fn uneven(seed: usize) -> Shares {
    let value = |u: usize, v: usize| ((u * 5 + v * 3 + seed) % 11 % 7) as f64;
    let sum: f64 = (0..SIDE).flat_map(|u| (0..SIDE).map(move |v| value(u, v))).sum();
    std::array::from_fn(|u| std::array::from_fn(|v| value(u, v) / sum))
}

fn one(shares: &Shares) -> Guide {
    Guide::of_shares(Vec3::ZERO, 0.0, std::iter::once(*shares), &uneven(0))
}

/// Equally spaced numbers along both axes.
const NUMBERS: usize = 1 << 9;

/// Cumulative probabilities are rounded to 2^-16, and counts to one number of 2^9 at both ends of a cell.
const ROUNDED: f64 = 2.0 / NUMBERS as f64;

#[test]
fn each_cell_gets_its_share_and_weighs_one_over_it() {
    for seed in 0..4 {
        let (shares, guide) = (uneven(seed), one(&uneven(seed)));
        let (mut counts, mut weights) = ([[0_u32; SIDE]; SIDE], 0.0);
        let number = |k: usize| (k as f32 + 0.5) / NUMBERS as f32;
        for (j, k) in (0..NUMBERS).flat_map(|j| (0..NUMBERS).map(move |k| (j, k))) {
            let Guided { u, v, weight } = guide.guided(0, number(j), number(k));
            let cell = [u, v].map(|x| ((x * SIDE as f32) as usize).min(SIDE - 1));
            counts[cell[0]][cell[1]] += 1;
            weights += f64::from(weight);
            let probability = (1.0 - EVEN_SHARE) * shares[cell[0]][cell[1]] + EVEN_SHARE * CELL;
            let error = f64::from(weight) * probability / CELL - 1.0;
            assert!(error.abs() < 1e-2, "{cell:?} weighs {weight}, for a share of {probability}");
            assert!(f64::from(weight) < 1.01 / EVEN_SHARE);
        }
        let all = (NUMBERS * NUMBERS) as f64;
        assert!((weights / all - 1.0).abs() < 1e-2, "the mean weight is {}", weights / all);
        for (counts, shares) in counts.iter().flatten().zip(shares.iter().flatten()) {
            let (found, expected) =
                (f64::from(*counts) / all, (1.0 - EVEN_SHARE) * shares + EVEN_SHARE * CELL);
            assert!((found - expected).abs() < ROUNDED, "{found}, not {expected}");
        }
    }
}

/// The sum over cells of probability times weight is the area of all, whatever is rounded: what keeps weights without bias.
#[test]
fn probability_times_weight_is_the_area_of_a_cell() {
    let guide = one(&uneven(1));
    let mut sum = 0.0;
    for row in 0..SIDE {
        let width = |row: &[f32; SIDE], cell: usize| {
            f64::from(row[cell]) - if cell > 0 { f64::from(row[cell - 1]) } else { 0.0 }
        };
        for cell in 0..SIDE {
            let middle = |row: &[f32; SIDE], cell: usize| row[cell] - 0.5 * width(row, cell) as f32;
            let (u, v) = (middle(&guide.rows[0], row), middle(&guide.rows[1 + row], cell));
            let probability = width(&guide.rows[0], row) * width(&guide.rows[1 + row], cell);
            let product = probability * f64::from(guide.guided(0, u, v).weight);
            assert!((product / CELL - 1.0).abs() < 1e-6, "cell {row}, {cell}: {product}");
            sum += probability;
        }
    }
    assert!((sum - 1.0).abs() < 1e-12);
}

#[test]
fn numbers_at_the_ends_stay_within() {
    let guide = one(&uneven(2));
    let below_1 = 1.0 - f32::EPSILON / 2.0;
    let ends: Vec<f32> = guide.rows.iter().flatten().copied().filter(|end| *end < 1.0).collect();
    for u in ends.into_iter().chain([0.0, below_1]) {
        for v in [0.0, 0.5, below_1] {
            let Guided { u: a, v: b, weight } = guide.guided(0, u, v);
            assert!(
                (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b) && weight > 0.0,
                "{u}, {v}: {a}, {b}"
            );
        }
    }
}

#[test]
fn the_most_that_a_photon_weighs_is_below_2_to_7() {
    let surfaces = (1.0 / EVEN_SHARE).powi(GUIDED_BOUNCES as i32);
    for photons in [8192, 8193, 10_000, 200_000] {
        let least = Departures::new(&one(&uneven(0)).departures, photons).unwrap();
        let of_lamps = (0..photons).map(|photon| least.cell(photon).weight).fold(0.0, f32::max);
        assert!(surfaces * f64::from(of_lamps) * 1.01 < 128.0, "{of_lamps} of {photons}");
    }
}

/// Of each cell the weights together are its share of all photons, and runs are whole.
#[test]
fn photons_of_a_cell_together_weigh_the_same_as_those_of_others() {
    for photons in [8192_u32, 9999, 65_536, 200_000] {
        let departures = Departures::new(&one(&uneven(0)).departures, photons).unwrap();
        let (mut weights, mut before) = ([[0.0; SIDE]; SIDE], None);
        for photon in 0..photons {
            let cell = departures.cell(photon);
            assert!(photon % RUN == 0 || before == Some(cell), "photon {photon} begins a cell within a run");
            before = Some(cell);
            let [u, v] = cell.corner.map(|x| x as usize);
            weights[u][v] += f64::from(cell.weight);
            let (x, y) = cell.place(0.25, 0.75);
            assert_eq!([x, y], [(u as f32 + 0.25) / 8.0, (v as f32 + 0.75) / 8.0]);
        }
        for weight in weights.iter().flatten() {
            assert!((weight / f64::from(photons) / CELL - 1.0).abs() < 1e-6, "{weight} of {photons}");
        }
    }
    assert_eq!(Departures::new(&uneven(0), 8191), None);
}

#[test]
fn parts_and_faces_have_tables_of_their_own() {
    let guide = Guide { low: Vec3::new(-1.0, 0.0, 2.0), scale: 2.0, ..Guide::default() };
    let at = |x: f32, y: f32, z: f32| guide.low + Vec3::new(x, y, z) * 0.5;
    let mut tables = Vec::new();
    for (k, normal) in
        [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate()
    {
        for part in 0..64_u32 {
            let [x, y, z] = [part / 16, part / 4 % 4, part % 4].map(|k| k as f32 + 0.5);
            let table = guide.surface(at(x, y, z), normal);
            assert_eq!(table, part * FACES + k as u32);
            tables.push(table);
        }
        // What is outside belongs to the part nearest.
        assert_eq!(guide.surface(at(-9.0, 1.5, 1e9), normal), guide.surface(at(0.5, 1.5, 3.5), normal));
    }
    tables.sort_unstable();
    assert_eq!(tables, (0..SURFACES).collect::<Vec<_>>());
    // Of components that are alike the first counts.
    assert_eq!(guide.surface(guide.low, Vec3::new(0.5, 0.5, -0.5)), 0);
    assert_eq!(guide.surface(guide.low, Vec3::new(0.1, -0.5, 0.5)), 3);
}

const WALKS: u32 = 1024;

/// Walks that find lines from a floor of 40 x 40, in directions that `direction` gives by the number of the walk, and light from
/// above.
fn found(direction: impl Fn(u32) -> Vec3) -> Vec<Found> {
    found_with(&direction, &direction)
}

/// The same with light from other directions.
fn found_with(direction: impl Fn(u32) -> Vec3, to_light: impl Fn(u32) -> Vec3) -> Vec<Found> {
    let mut found = Found::default();
    for walk in 0..WALKS {
        let point = Vec3::new((walk % 40) as f32, 0.0, (walk * 7 % 40) as f32);
        found.edges.push(Edge { walk, point, normal: Vec3::Y, direction: direction(walk) });
        let arrival = Arrival { point, source: point + to_light(walk) * 5.0, flux: 1.0 };
        found.lit.push(Lit { walk, is_seen: false, arrival });
        found.lit.push(Lit { walk, is_seen: true, arrival });
    }
    vec![found]
}

/// Points of the unit sphere, all alike.
fn any(walk: u32) -> Vec3 {
    let (height, turn) = ((walk * 37 % 64) as f32 / 32.0 - 1.0, (walk * 13 % 101) as f32 / 101.0 * TAU);
    let radius = (1.0 - height * height).sqrt();
    Vec3::new(radius * turn.cos(), height, radius * turn.sin())
}

#[test]
fn where_lines_lead_photons_go() {
    let way = Vec3::new(0.3, 0.8, 0.52).normalize();
    let guide = Guide::learn(WALKS, &found(|_| way), 0.9).unwrap();
    assert!(guide.expected < 0.1, "{}", guide.expected);
    // Each part of the floor, and what faces up elsewhere; but not the ceiling, of which nothing is known.
    for (point, normal, is_known) in [
        (Vec3::new(3.0, 0.0, 3.0), Vec3::Y, true),
        (Vec3::new(33.0, 0.0, 8.0), Vec3::Y, true),
        (Vec3::new(20.0, 1e3, 20.0), Vec3::Y, true),
        (Vec3::new(20.0, 0.0, 20.0), Vec3::NEG_Y, false),
    ] {
        let table = guide.surface(point, normal);
        let weights = table::weights_of(guide.table(table));
        let least = weights.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        assert!(
            if is_known { least < 0.05 } else { (least - 1.0).abs() < 1e-3 },
            "{point}, {normal}: {least}"
        );
    }
    let most = guide.departures.iter().flatten().copied().fold(0.0, f64::max);
    assert!(most > 0.5, "{most}");
}

#[test]
fn few_lines_and_lines_to_everywhere_are_of_no_use() {
    let way = |_| Vec3::Y;
    let few = |count: usize| {
        let mut found = found(way);
        found[0].edges.truncate(count);
        found
    };
    assert!(Guide::learn(WALKS, &few(255), 0.9).is_none() && Guide::learn(WALKS, &few(256), 0.9).is_some());
    assert!(Guide::learn(WALKS, &[], 0.9).is_none());
    let by_cosine = |walk| (Vec3::Y + any(walk) * 0.999).normalize();
    assert!(Guide::learn(WALKS, &found_with(by_cosine, any), 0.9).is_none());
}

/// What a guide is expected to leave is of surfaces and of lamps together: either alone may make it worth having.
#[test]
fn surfaces_alone_and_lamps_alone_are_worth_a_guide() {
    let way = |_| Vec3::new(0.3, 0.8, 0.52).normalize();
    let by_cosine = |walk| (Vec3::Y + any(walk) * 0.999).normalize();
    let expected = |found: Vec<Found>| Guide::learn(WALKS, &found, 0.9).map_or(1.0, |guide| guide.expected);
    let [surfaces, lamps] = [found_with(way, any), found_with(by_cosine, way)].map(expected);
    let both = expected(found(way));
    assert!(surfaces < 0.5 && lamps < 0.5, "{surfaces}, {lamps}");
    // Where light comes from everywhere, a table that is learnt is a little worse than none.
    let even = (both / (surfaces * lamps)).sqrt();
    assert!((0.8..1.1).contains(&even), "{both} of {surfaces} and {lamps}");
}

/// Parts divide what nearly all lines leave: a few from afar make them no larger.
#[test]
fn a_few_lines_from_afar_do_not_widen_the_parts() {
    let way = Vec3::new(0.3, 0.8, 0.52).normalize();
    let of = |far: usize| {
        let mut found = found(|_| way);
        for edge in found[0].edges.iter_mut().step_by(WALKS as usize / far.max(1)).take(far) {
            edge.point *= 1e4;
        }
        Guide::learn(WALKS, &found, 0.9).unwrap()
    };
    let (none, few) = (of(0), of(10));
    assert!((few.scale / none.scale - 1.0).abs() < 0.1, "{} and {}", few.scale, none.scale);
    // The longest side, which is 40 long but for a fiftieth at either end, has as many parts as there are.
    assert!((none.scale * 38.5 / PARTS as f32 - 1.0).abs() < 0.05, "{}", none.scale);
}

/// Tables that suit one half of the walks alone are not trusted.
#[test]
fn what_one_half_of_the_walks_finds_is_judged_by_the_other() {
    let halves = |walk: u32| {
        if (walk / 64).is_multiple_of(2) { Vec3::Y } else { Vec3::new(0.9, 0.1, 0.1).normalize() }
    };
    assert!(Guide::learn(WALKS, &found(halves), 1.0).is_none());
}

/// It is judged by halves, and made of both: what one walk of four in the second half alone finds gets photons too.
#[test]
fn both_halves_of_the_walks_make_the_guide() {
    let (most, few) = (Vec3::new(0.3, 0.8, 0.52).normalize(), Vec3::new(-0.6, 0.5, 0.3).normalize());
    for half in [0, 1] {
        let way = |walk: u32| if walk / 64 % 2 == half && walk.is_multiple_of(4) { few } else { most };
        let guide = Guide::learn(WALKS, &found(way), 1.0).unwrap();
        let weights = table::weights_of(guide.table(guide.surface(Vec3::splat(3.0), Vec3::Y)));
        let light = weights.iter().flatten().filter(|weight| **weight < 0.5).count();
        let likely = guide.departures.iter().flatten().filter(|share| **share > 2.0 * CELL).count();
        assert_eq!((light, likely), (2, 2), "half {half}");
    }
}

/// Nine of ten walks find one way, in a bright part of the image, and the others another in a dark one.
#[test]
fn dark_parts_of_the_image_count_by_what_they_lack() {
    let (bright, dark) = (Vec3::new(0.3, 0.9, 0.1).normalize(), Vec3::new(-0.6, 0.7, 0.3).normalize());
    let place = |walk: u32| crate::sobol::sobol(walk, 0) < u32::MAX / 8;
    let way = |walk: u32| if place(walk) { dark } else { bright };
    let mut found = found(way);
    for lit in &mut found[0].lit {
        lit.arrival.flux = if place(lit.walk) { 0.1 } else { 1.0 };
    }
    let guide = Guide::learn(WALKS, &found, 0.9).unwrap();
    let weights = table::weights_of(guide.table(guide.surface(Vec3::splat(3.0), Vec3::Y)));
    let mut shares: Vec<f64> = weights.iter().flatten().map(|weight| CELL / weight).collect();
    shares.sort_by(f64::total_cmp);
    let ratio = shares[62] / shares[63];
    // An eighth of the walks, each with 1 / sqrt(0.01 + 0.01 m^2) for the others' 1 / sqrt(1 + 0.01 m^2): they find about as much.
    assert!((0.6..1.0).contains(&ratio), "{ratio}");
}

#[test]
fn what_the_eye_sees_itself_is_no_place_for_photons() {
    let found = found(any);
    assert_eq!(found[0].arrivals().count(), WALKS as usize);
    assert!(found[0].arrivals().all(|lit| !lit.is_seen));
}
