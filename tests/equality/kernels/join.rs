//! The join of photons and visible points, compared with a test of all pairs.

use super::inputs::{self, crowd, numbers};
use super::{check, lane_kinds, tell};
use crate::placement::log_uniform;
use fast::kernels::{Gathered, Join, Photon, Point};
use proptest::prelude::*;
use proptest::sample::Index;
use scene::Vec3;
use scene::aim::{AIMED_BOUNCES, EXPONENT_STEP, MOST_SCALE_BITS};
use scene::film::FLUX_ONE;

/// Weights are at most 8 as photons depart, and are doubled by so many surfaces.
const MOST_EXPONENT: u32 = (MOST_SCALE_BITS + 3 + AIMED_BOUNCES).next_multiple_of(EXPONENT_STEP);

/// Photons and visible points, scattered around a few places.
#[derive(Clone, Debug)]
struct Scatter {
    places: Vec<Vec3>,
    /// Largest offset from a place along each axis.
    spread: f32,
    photons: Vec<(Index, Vec3, Photon)>,
    points: Vec<Option<(Index, Vec3, Point, Radius)>>,
    radius: f32,
    cell_size: f32,
    buckets: usize,
}

/// The radius of a visible point.
#[derive(Clone, Debug)]
enum Radius {
    /// This share of the scatter's radius, at most 1.
    Times(f32),
    /// The distance to some photon: exactly, or with the squared radius one float larger, so that the photon is inside.
    To(Index, bool),
}

fn vector(side: f32) -> impl Strategy<Value = Vec3> {
    [-side..=side, -side..=side, -side..=side].prop_map(Vec3::from_array)
}

fn direction() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        1 => prop::sample::select(vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z]),
        3 => vector(1.0).prop_map(|v| v.normalize_or(Vec3::X)),
    ]
}

fn scatter(points: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Scatter> {
    let flux = || prop_oneof![1 => Just(0), 4 => 0..=FLUX_ONE, 1 => Just(FLUX_ONE)];
    // The largest exponent that a flux may have, and more photons that have none.
    let shift =
        prop_oneof![4 => Just(0), 1 => (1..=MOST_EXPONENT / EXPONENT_STEP).prop_map(|k| k * EXPONENT_STEP)];
    let photon = (direction(), 0..3_u32, any::<bool>(), [flux(), flux(), flux()], shift).prop_map(
        |(wi, sphere, is_safe, flux, shift)| Photon { point: Vec3::ZERO, wi, sphere, is_safe, flux, shift },
    );
    let offset = || prop_oneof![1 => Just(Vec3::ZERO), 6 => vector(1.0)];
    let photons = prop::collection::vec((any::<Index>(), offset(), photon), 0..120);
    let radius = prop_oneof![
        2 => (0.05..=1.0_f32).prop_map(Radius::Times),
        2 => Just(Radius::Times(1.0)),
        2 => (any::<Index>(), any::<bool>()).prop_map(|(photon, is_within)| Radius::To(photon, is_within)),
    ];
    let point = (direction(), 0..3_u32).prop_map(|(normal, sphere)| Point {
        point: Vec3::ZERO,
        normal,
        sphere,
        radius_squared: 0.0,
    });
    let points =
        prop::collection::vec(prop::option::weighted(0.9, (any::<Index>(), offset(), point, radius)), points);
    let places = prop_oneof![
        4 => prop::collection::vec(vector(10.0), 1..=1),
        2 => prop::collection::vec(vector(1e3), 2..=4),
        1 => prop::collection::vec(vector(1e6), 1..=3),
    ];
    let spread = prop_oneof![Just(0.0_f32), Just(1e-6), 0.1..2.0_f32, 2.0..8.0_f32];
    let cell_size = prop_oneof![2 => Just(1.5_f32), 1 => 0.5..4.0_f32];
    (places, spread, photons, points, log_uniform(1e-3, 30.0), cell_size, 1..100_000_usize).prop_map(
        |(places, spread, photons, points, radius, cell_size, buckets)| Scatter {
            places,
            spread: spread * radius,
            photons,
            points,
            radius,
            cell_size,
            buckets,
        },
    )
}

impl Scatter {
    fn resolve(&self) -> (Vec<Photon>, Vec<Option<Point>>) {
        let place = |index: &Index, offset: Vec3| *index.get(&self.places) + offset * self.spread;
        let photons: Vec<Photon> = self
            .photons
            .iter()
            .map(|(index, offset, photon)| Photon { point: place(index, *offset), ..*photon })
            .collect();
        let points = self.points.iter().map(|point| {
            let (index, offset, point, radius) = point.as_ref()?;
            let at = place(index, *offset);
            let largest = self.radius * self.radius;
            let radius_squared = match radius {
                Radius::To(photon, is_within) if !photons.is_empty() => {
                    let d = photon.get(&photons).point - at;
                    let exact = d.dot(d);
                    if *is_within { exact.next_up() } else { exact }
                }
                Radius::Times(share) => largest * (share * share),
                Radius::To(..) => largest,
            };
            // A radius must be above zero and at most the one that the cells are made for.
            let radius_squared = if radius_squared > 0.0 { radius_squared.min(largest) } else { largest };
            Some(Point { point: at, radius_squared, ..*point })
        });
        let points = points.collect();
        (photons, points)
    }
}

/// What a visible point gathers, by testing all photons: those within its radius that arrive on its side, or that are
/// safe (known to count at any point of the same sphere within reach).
fn all_pairs(photons: &[Photon], point: Option<&Point>) -> Gathered {
    let mut sum = Gathered::default();
    let Some(point) = point else { return sum };
    for photon in photons {
        let d = photon.point - point.point;
        let is_near = d.dot(d) < point.radius_squared;
        let is_seen = (photon.is_safe && photon.sphere == point.sphere) || photon.wi.dot(point.normal) > 0.0;
        if is_near && is_seen {
            sum.m += 1;
            for (total, flux) in sum.flux.iter_mut().zip(photon.flux) {
                *total += u128::from(flux) << photon.shift;
            }
        }
    }
    sum
}

/// Compares the join on all lanes with all pairs; returns the number of contributions.
fn compare(photons: &[Photon], points: &[Option<Point>], cell_size: f32, buckets: usize) -> u64 {
    let expected: Vec<Gathered> = points.iter().map(|point| all_pairs(photons, point.as_ref())).collect();
    for lanes in lane_kinds() {
        let half = photons.len() / 2;
        let join = Join::new(lanes, &[&photons[..half], &photons[half..]], points, cell_size, buckets);
        let (actual, candidates) = join.gather(lanes);
        assert_eq!(actual.len(), expected.len());
        for (k, (a, e)) in actual.iter().zip(&expected).enumerate() {
            assert_eq!(a, e, "{lanes:?}, point {k}: {:?}", points[k]);
        }
        let contributions: u64 = expected.iter().map(|gathered| u64::from(gathered.m)).sum();
        assert!(candidates >= contributions, "{lanes:?}: {candidates} candidates for {contributions}");
    }
    expected.iter().map(|gathered| u64::from(gathered.m)).sum()
}

/// Everything beyond 2^30 cells from the origin shares the last cell along that axis.
#[test]
fn photons_and_points_beyond_the_last_cell() {
    let radius = 1e-3_f32;
    let mut cases = 0;
    for far in [7.5e5_f32, 1e6, 1e9] {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE] {
            for at in [axis * far, -axis * far] {
                let photon =
                    Photon { point: at, wi: Vec3::X, sphere: 0, is_safe: false, flux: [1, 2, 3], shift: 0 };
                let point = Point { point: at, normal: Vec3::X, sphere: 0, radius_squared: radius * radius };
                // Alone, in a full group, and with a point too far away for both to fit in a window.
                let elsewhere = Point { point: Vec3::ZERO, ..point };
                for points in [vec![Some(point)], vec![Some(point); 16], vec![Some(elsewhere), Some(point)]] {
                    let expected = points.iter().filter(|p| p.is_some_and(|p| p.point == at)).count();
                    assert_eq!(compare(&[photon; 3], &points, 0.5 * radius, 1 << 12), 3 * expected as u64);
                    cases += 1;
                }
            }
        }
    }
    tell(cases, "joins beyond the last cell");
}

#[test]
fn groups_of_any_size() {
    check(1200, "the join", &scatter(0..=48), |scatter| {
        let (photons, points) = scatter.resolve();
        compare(&photons, &points, scatter.radius * scatter.cell_size, scatter.buckets);
        Ok(())
    });
}

/// Sums that exceed a 32-bit word, with photons in one cell and in several, for points in one group and far apart.
#[test]
fn more_photons_than_a_word_can_sum() {
    let mut cases = 0;
    let mut stream = numbers(60);
    for count in [1, 7, 8, 9, 1015, 1016, 1017, 2046, 2047, 2048, 2049, 4094, 4095, 5000] {
        for spread in [0.0, 1.0] {
            let mut offset = || Vec3::from_array([(); 3].map(|()| (stream.next_f32() - 0.5) * spread));
            let photon = |at: Vec3| Photon {
                point: at,
                wi: Vec3::Z,
                sphere: 0,
                is_safe: false,
                flux: [FLUX_ONE, FLUX_ONE - 1, 1],
                shift: 0,
            };
            let photons: Vec<Photon> = (0..count).map(|_| photon(offset())).collect();
            let point = |at: Vec3| Some(Point { point: at, normal: Vec3::Z, sphere: 0, radius_squared: 1.0 });
            let together = [point(Vec3::ZERO); 16];
            let mut apart = together;
            apart[5] = point(Vec3::splat(100.0));
            for points in [&together, &apart] {
                let contributions = compare(&photons, points, 1.5, 1000);
                assert!(contributions > 14 * count / 2);
                cases += 1;
            }
        }
    }
    tell(cases, "joins of up to 5000 photons");
}

/// Visible points as in an image, where neighbours are close together, and the same points in an order that spreads out
/// each group.
#[test]
fn crowds() {
    let mut cases = 0;
    for (density, points) in [(0.5, 160), (8.0, 250), (40.0, 31)] {
        let (photons, together) = crowd(points, density, 62);
        let apart: Vec<Option<Point>> = (0..points).map(|k| together[k * 17 % points]).collect();
        for (points, cell_size) in [(&together, 1.5), (&together, 0.5), (&apart, 1.5), (&apart, 3.0)] {
            assert!(compare(&photons, points, cell_size, photons.len()) > 0);
            cases += points.len();
        }
    }
    tell(cases, "points among photons on a plane");
}

/// Photons at cell borders, and points at a distance of their radius up to a few rounding errors. A look-up with
/// slightly too short a reach would miss a cell.
#[test]
fn photons_at_the_borders_of_cells() {
    let mut cases = 0;
    for (cell_size, radius) in [(1.5_f32, 1.0_f32), (0.75, 0.5), (3.0, 1.0), (0.5, 0.9), (0.3, 0.2)] {
        let inverse = 1.0 / cell_size;
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, -1.0_f32), (axis, 1.0)]) {
            for cell in [-37_i32, -1, 0, 1, 2, 90] {
                // The least coordinate in the cell, taking into account how the multiplication by `inverse` rounds.
                let mut border = cell as f32 * cell_size;
                while (border * inverse).floor() >= cell as f32 {
                    border = border.next_down();
                }
                let border = border.next_up();
                let at = |x: f32| {
                    let mut p = Vec3::new(0.1, 0.2, 0.3) * cell_size;
                    p[axis] = x;
                    p
                };
                let photon = |x: f32, number| Photon {
                    point: at(x),
                    wi: Vec3::Z,
                    sphere: 0,
                    is_safe: true,
                    flux: [number, 1, 0],
                    shift: 0,
                };
                let near = [border.next_down(), border, border.next_up(), border - 1e-7, border + 1e-7];
                let photons: Vec<Photon> = near.into_iter().zip(1..).map(|(x, k)| photon(x, k)).collect();
                let point = |roundings: i32| {
                    let x = border + sign * radius * (1.0 - roundings as f32 * f32::EPSILON);
                    let radius_squared = radius * radius;
                    Some(Point { point: at(x), normal: Vec3::Z, sphere: 0, radius_squared })
                };
                let points: Vec<Option<Point>> = (-3..12).map(point).collect();
                compare(&photons, &points, cell_size, 4096);
                for point in points {
                    compare(&photons, &[point], cell_size, 4096);
                }
                cases += 1;
            }
        }
    }
    tell(cases, "joins at the borders of cells");
}

/// Photons that arrive almost parallel to the surface, where the sign of a cosine decides; some of them are safe.
#[test]
fn grazing_photons() {
    let mut stream = numbers(61);
    let mut cases = 0;
    for round in 0..60 {
        let normal = inputs::direction(&mut stream);
        let (s, t) = reference::sampling::frame(normal);
        let photons: Vec<Photon> = (0..100)
            .map(|k| {
                let angle = reference::sampling::uniform_disk(1.0 - f32::EPSILON, stream.next_f32());
                let tilt = [0.0, 1e-7, -1e-7, 1e-9, -1e-9][k % 5];
                let wi = s * angle.0 + t * angle.1 + normal * tilt;
                let point = (s * stream.next_f32() + t * stream.next_f32()) * 0.6;
                Photon {
                    point,
                    wi,
                    sphere: k as u32 % 2,
                    is_safe: k % 3 == 0,
                    flux: [k as u32, 1, 2],
                    shift: 0,
                }
            })
            .collect();
        let points: Vec<Option<Point>> = (0..round % 35)
            .map(|k| {
                let point = (s * stream.next_f32() + t * stream.next_f32()) * 0.6;
                Some(Point { point, normal, sphere: k % 2, radius_squared: 0.25 })
            })
            .collect();
        compare(&photons, &points, 0.75, 4096);
        cases += 1;
    }
    tell(cases, "joins of grazing photons");
}
