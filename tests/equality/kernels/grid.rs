//! Grid cells, occupancy map and sorting: look-ups must visit every cell nearby exactly once, and few others.

use super::inputs::numbers;
use super::{GUARD, GUARDS, assert_same, check, check_map, lane_kinds};
use crate::placement::log_uniform;
use fast::LaneKind;
use fast::kernels::{Cells, Join, Occupancy, Photon, Query, Run};
use proptest::prelude::*;
use proptest::sample::Index;
use scene::Vec3;

/// Side of a window, in cells.
const WINDOW: i64 = 8;

/// Factor by which the engine enlarges a search radius when it looks up cells.
const WIDENED: f32 = 1.0 + 1.0 / 1_048_576.0;

/// Cell coordinates are clamped to this.
const FARTHEST: f32 = 1_073_741_824.0;

fn table() -> impl Strategy<Value = usize> {
    prop::sample::select(vec![0, 1, 4096, 4097, 10_000, 1 << 15, 200_000, 1 << 22, 1 << 23])
}

/// The cell of a coordinate, by its definition.
fn cell(x: f32, size: f32) -> i64 {
    let scaled = x * (1.0 / size);
    scaled.clamp(-FARTHEST, FARTHEST).floor() as i64
}

fn bucket(cells: Cells, lanes: LaneKind, p: Vec3) -> u32 {
    let mut bucket = [0.0];
    cells.buckets(lanes, [&[p.x], &[p.y], &[p.z]], &mut bucket);
    bucket[0].to_bits()
}

/// The bucket of a cell, by the point at its centre.
fn bucket_of_cell(cells: Cells, size: f32, [x, y, z]: [i64; 3]) -> u32 {
    let middle = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, z as f32 + 0.5) * size;
    bucket(cells, LaneKind::Emulated, middle)
}

#[test]
fn buckets_count_cells_modulo_their_number() {
    let coordinate = || {
        prop_oneof![
            4 => (-20..20_i32).prop_map(|k| k as f32),
            2 => (-20..20_i32).prop_map(|k| (k as f32).next_down()),
            4 => -1e3..1e3_f32,
            1 => -1e9..1e9_f32,
            1 => prop::sample::select(vec![1e30_f32, -1e30, f32::INFINITY, f32::NEG_INFINITY, FARTHEST, -FARTHEST]),
        ]
    };
    let point = [coordinate(), coordinate(), coordinate()];
    let inputs = (log_uniform(1e-6, 1e6), table(), prop::collection::vec(point, 33..=64));
    check(300, "buckets of points", &inputs, |(size, buckets, points)| {
        let cells = Cells::new(size, buckets);
        let count = i64::from(cells.count());
        prop_assert_eq!(count, buckets.next_power_of_two().clamp(1 << 12, 1 << 22) as i64);
        let [stride_y, stride_z] =
            [[0, 1, 0], [0, 0, 1]].map(|cell| i64::from(bucket_of_cell(cells, size, cell)));
        let rows: Vec<[f32; 3]> = points.into_iter().map(|p| p.map(|x| x * size)).collect();
        let definition = |p: [f32; 3]| {
            let [x, y, z] = p.map(|x| cell(x, size));
            [f32::from_bits((x + y * stride_y + z * stride_z).rem_euclid(count) as u32)]
        };
        let kernel = |lanes, [x, y, z]: [&[f32]; 3], [out]: [&mut [f32]; 1]| {
            cells.buckets(lanes, [x, y, z], out);
        };
        check_map("buckets", &rows, kernel, definition);
        Ok(())
    });
}

/// All buckets of some runs, in order.
fn buckets_of(runs: &[Run], cells: Cells) -> Vec<u32> {
    let one =
        |run: &Run| (0..run.length).map(|k| run.bucket.wrapping_add(k) % cells.count()).collect::<Vec<_>>();
    runs.iter().flat_map(one).collect()
}

/// The bounding box of a group of visible points, and photons near it. The unit of length is a cell.
#[derive(Clone, Debug)]
struct Near {
    corner: Vec3,
    extent: Vec3,
    radius: f32,
    /// For each photon: a relative position in the box, a direction from there, and a distance in radii.
    photons: Vec<(Vec3, Vec3, f32)>,
}

fn near() -> impl Strategy<Value = Near> {
    let vector = |low: f32, high: f32| [low..high, low..high, low..high].prop_map(Vec3::from_array);
    let far = prop_oneof![4 => Just(20.0_f32), 2 => Just(1e3), 1 => Just(3e5)];
    let corner = (vector(-1.0, 1.0), far, any::<bool>()).prop_map(|(corner, far, is_whole)| {
        let corner = corner * far;
        if is_whole { corner.round() } else { corner }
    });
    let extent = prop_oneof![1 => Just(Vec3::ZERO), 2 => vector(0.0, 0.5), 2 => vector(0.0, 7.0)];
    let radius = prop_oneof![Just(1.0_f32 / 1.5), Just(0.5), Just(1.0), log_uniform(1e-4, 4.0)];
    let roundings = (1..40_i32).prop_map(|k| 1.0 - k as f32 * (0.5 * f32::EPSILON));
    let distance = prop_oneof![Just(0.0_f32), roundings, 0.99..1.0_f32, 0.0..1.0_f32];
    let direction = prop_oneof![
        prop::sample::select(vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z]),
        vector(-1.0, 1.0).prop_map(|v| v.normalize_or(Vec3::X)),
    ];
    let photons = prop::collection::vec((vector(0.0, 1.0), direction, distance), 1..30);
    (corner, extent, radius, photons).prop_map(|(corner, extent, radius, photons)| Near {
        corner,
        extent,
        radius,
        photons,
    })
}

impl Near {
    fn query(&self, size: f32) -> Query {
        let low = self.corner * size;
        Query { low, high: low + self.extent * size, reach: self.radius * size * WIDENED }
    }

    /// Photons that are within the radius of their point in the box, by the join's own test.
    fn counted(&self, size: f32) -> Vec<Vec3> {
        let Query { low, high, .. } = self.query(size);
        let radius = self.radius * size;
        let photon = |(place, direction, radii): &(Vec3, Vec3, f32)| {
            let point = (low + (high - low) * *place).clamp(low, high);
            let photon = point + *direction * (radius * radii);
            let d = photon - point;
            (d.dot(d) < radius * radius).then_some(photon)
        };
        self.photons.iter().filter_map(photon).collect()
    }

    /// The number of cells within a distance of `reach` cells from the box, computed in `f64`.
    fn cells_within(&self, size: f32, reach: f64) -> usize {
        let Query { low, high, .. } = self.query(size);
        let [low, high] = [low, high].map(|corner| corner.as_dvec3() / f64::from(size));
        let range = |axis: usize| {
            ((low[axis] - reach).floor() as i64 - 1)..=((high[axis] + reach).floor() as i64 + 1)
        };
        let gap =
            |cell: i64, axis: usize| (low[axis] - (cell + 1) as f64).max(cell as f64 - high[axis]).max(0.0);
        let mut count = 0;
        for (x, y) in range(0).flat_map(|x| range(1).map(move |y| (x, y))) {
            for z in range(2) {
                let [dx, dy, dz] = [gap(x, 0), gap(y, 1), gap(z, 2)];
                count += usize::from(dx * dx + dy * dy + dz * dz <= reach * reach);
            }
        }
        count
    }
}

#[test]
fn queries_find_each_near_cell_once_and_few_others() {
    let inputs = (near(), log_uniform(1e-3, 1e3), table());
    check(6000, "queries of cells", &inputs, |(near, size, buckets)| {
        let cells = Cells::new(size, buckets);
        let query = near.query(size);
        let spanned = (0..3)
            .map(|axis| {
                cell(query.high[axis] + query.reach, size) - cell(query.low[axis] - query.reach, size) + 1
            })
            .max()
            .unwrap();
        let mut on_lanes = lane_kinds().map(|lanes| cells.runs(lanes, query));
        let runs = on_lanes.next().unwrap();
        for other in on_lanes {
            prop_assert_eq!(&runs, &other);
        }
        let Some(runs) = runs else {
            prop_assert!(spanned > WINDOW, "{} cells do not fit", spanned);
            return Ok(());
        };
        prop_assert!(spanned <= WINDOW, "{} cells are said to fit", spanned);
        let found = buckets_of(&runs, cells);
        let mut once = found.clone();
        once.sort_unstable();
        once.dedup();
        prop_assert_eq!(once.len(), found.len(), "a bucket is looked up twice: {:?}", runs);
        for photon in near.counted(size) {
            let bucket = bucket(cells, LaneKind::Emulated, photon);
            prop_assert!(once.binary_search(&bucket).is_ok(), "{} is not found", photon);
        }
        if near.corner.abs().max_element() <= 1e3 {
            // A tolerance for the rounding of coordinates, which the look-up allows for.
            let reach = f64::from(near.radius);
            let (least, most) =
                (near.cells_within(size, reach - 0.01), near.cells_within(size, reach + 0.01));
            let least = if reach > 0.01 { least } else { 1 };
            prop_assert!(
                (least..=most).contains(&found.len()),
                "{} of {}..={} cells",
                found.len(),
                least,
                most
            );
        }
        Ok(())
    });
}

fn touches(occupancy: &Occupancy, lanes: LaneKind, points: &[Vec3]) -> Vec<bool> {
    let column = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f32>>();
    let (x, y, z) = (column(0), column(1), column(2));
    let mut touched = vec![GUARD; points.len() + GUARDS];
    occupancy.touches(lanes, [&x, &y, &z], &mut touched[..points.len()]);
    assert_same(&touched[points.len()..], &[GUARD; GUARDS], &"guards");
    touched[..points.len()].iter().map(|t| *t > 0.0).collect()
}

#[test]
fn occupancy_contains_near_points_and_few_others() {
    let inputs = (prop::collection::vec(near(), 1..6), log_uniform(1e-3, 1e3));
    check(150, "occupancy", &inputs, |(boxes, size)| {
        let (mut all, mut first, mut rest) =
            (Occupancy::new(size), Occupancy::new(size), Occupancy::new(size));
        let mut photons = Vec::new();
        for (k, near) in boxes.iter().enumerate() {
            let query = near.query(size);
            let is_marked = all.mark(LaneKind::Emulated, query);
            prop_assert_eq!(is_marked, Cells::new(size, 1 << 19).runs(LaneKind::Emulated, query).is_some());
            if k == 0 {
                first.mark(LaneKind::best(), query)
            } else {
                rest.mark(LaneKind::best(), query)
            };
            if is_marked {
                photons.extend(near.counted(size));
            }
        }
        // Random points everywhere: at most 5 windows of 512 cells out of half a million are marked.
        let mut stream = numbers(50);
        let far: Vec<Vec3> = (0..1000)
            .map(|_| Vec3::from_array([(); 3].map(|()| (stream.next_f32() - 0.5) * 1e4 * size)))
            .collect();
        first.merge(&rest);
        for lanes in lane_kinds() {
            for occupancy in [&all, &first] {
                prop_assert!(touches(occupancy, lanes, &photons).into_iter().all(|touched| touched));
                let in_vain = touches(occupancy, lanes, &far).into_iter().filter(|touched| *touched).count();
                prop_assert!(in_vain < 50, "{} of 1000 points are taken to be near", in_vain);
            }
            prop_assert!(touches(&Occupancy::new(size), lanes, &far).into_iter().all(|touched| !touched));
        }
        Ok(())
    });
}

/// A photon that is identified by `number`.
fn photon(point: Vec3, number: u32) -> Photon {
    let wi = Vec3::new(number as f32, 0.5, -(number as f32));
    Photon { point, wi, sphere: number, is_safe: number % 2 == 1, flux: [number, number + 1, 7], shift: 0 }
}

#[test]
fn photons_are_sorted_by_bucket() {
    let spread = prop_oneof![Just(0.0_f32), Just(1.0), Just(30.0), Just(1e4)];
    let place = prop::collection::vec([-1.0..1.0_f32, -1.0..1.0_f32, -1.0..1.0_f32], 0..300);
    let inputs = (place, spread, table(), prop::collection::vec(any::<Index>(), 0..4));
    check(200, "sorting", &inputs, |(places, spread, buckets, cuts)| {
        let photons: Vec<Photon> =
            places.iter().zip(0..).map(|(p, number)| photon(Vec3::from_array(*p) * spread, number)).collect();
        // Split into the deposits of several workers, some of which may be empty.
        let mut ends: Vec<usize> = cuts.iter().map(|cut| cut.index(photons.len() + 1)).collect();
        ends.push(photons.len());
        ends.sort_unstable();
        let begins = std::iter::once(0).chain(ends.iter().copied());
        let parts: Vec<&[Photon]> = begins.zip(&ends).map(|(begin, end)| &photons[begin..*end]).collect();
        for lanes in lane_kinds() {
            let join = Join::new(lanes, &parts, &[], 1.0, buckets);
            let (sorted, starts) = (join.photons(), join.starts());
            prop_assert_eq!(sorted.len(), photons.len());
            prop_assert_eq!(starts[0], 0);
            prop_assert_eq!(starts.len(), Cells::new(1.0, buckets).count() as usize + 1);
            for (index, (photon, number)) in sorted.iter().enumerate() {
                let range = starts[*number as usize]..starts[*number as usize + 1];
                prop_assert!(range.contains(&(index as u32)), "{} is not in {:?}", index, range);
                prop_assert_eq!(*number, bucket(Cells::new(1.0, buckets), lanes, photon.point));
            }
            prop_assert!(starts.windows(2).all(|pair| pair[0] <= pair[1]));
            let mut back: Vec<Photon> = sorted.into_iter().map(|(photon, _)| photon).collect();
            back.sort_by_key(|photon| photon.sphere);
            prop_assert_eq!(&back, &photons);
        }
        Ok(())
    });
}
