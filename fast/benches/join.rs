//! Sorting photons, joining them with visible points, and consolidating.

mod inputs;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fast::LaneKind;
use fast::kernels::{Consolidation, Join};
use inputs::{crowd, pixels};
use scene::film::FluxUnit;
use std::hint::black_box;

const POINTS: usize = 4096;
/// As in the renderer: cells of 1.5 times the largest radius.
const CELL_SIZE: f32 = 1.5;

/// With few and with many photons to a point; points in groups that gather together, and scattered ones.
fn join(c: &mut Criterion) {
    for density in [10.0, 100.0] {
        let (photons, together) = crowd(POINTS, density, 5);
        let apart: Vec<_> = (0..POINTS).map(|k| together[k * 17 % POINTS]).collect();
        for (arrangement, points) in [("together", &together), ("apart", &apart)] {
            for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
                let join = Join::new(lanes, &[&photons], points, CELL_SIZE, photons.len());
                let mut group = c.benchmark_group("join");
                group.throughput(Throughput::Elements(join.gather(lanes).1));
                group.bench_function(BenchmarkId::new(format!("{arrangement} {lanes:?}"), density), |b| {
                    b.iter(|| black_box(&join).gather(lanes));
                });
                group.finish();
            }
        }
    }
}

fn sort(c: &mut Criterion) {
    let (photons, _) = crowd(0, 100.0, 6);
    let mut group = c.benchmark_group("bin and sort");
    group.throughput(Throughput::Elements(photons.len() as u64));
    for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
        group.bench_function(BenchmarkId::from_parameter(format!("{lanes:?}")), |b| {
            b.iter(|| Join::new(lanes, &[black_box(&photons)], &[], CELL_SIZE, photons.len()));
        });
    }
    group.finish();
}

fn consolidate(c: &mut Criterion) {
    let (pixels, seen, gathered) = pixels(POINTS);
    let mut group = c.benchmark_group("consolidate");
    group.throughput(Throughput::Elements(POINTS as u64));
    for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
        group.bench_function(BenchmarkId::from_parameter(format!("{lanes:?}")), |b| {
            let fresh = || Consolidation::new(&pixels, &seen, &gathered);
            b.iter_batched_ref(fresh, |all| all.run(lanes, FluxUnit::new(3.0, 1.0)), BatchSize::SmallInput);
        });
    }
    group.finish();
}

criterion_group!(benches, join, sort, consolidate);
criterion_main!(benches);
