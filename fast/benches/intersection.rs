//! Rays against spheres: one by one, in clusters, in a tree of up to a million; and building the tree.

mod inputs;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fast::{Intersector, LaneKind, Search};
use inputs::{scattered, scene_of};
use scene::Vec3;
use scene::ray::NO_SPHERE;
use std::hint::black_box;

const RAYS: usize = 4096;
/// Spheres, and the searches worth trying on so many.
const SIZES: [(usize, &[Search]); 7] = [
    (8, &[Search::InTurn, Search::Clusters]),
    (64, &[Search::InTurn, Search::Clusters, Search::Tree]),
    (512, &[Search::Clusters, Search::Tree]),
    (1_000, &[Search::Clusters, Search::Tree]),
    (10_000, &[Search::Tree]),
    (100_000, &[Search::Tree]),
    (1_000_000, &[Search::Tree]),
];

fn traverse(c: &mut Criterion) {
    for (spheres, searches) in SIZES {
        let (spheres, rays) = scattered(spheres, 1, RAYS, 3);
        let scene = scene_of(spheres, Vec3::splat(1e4));
        let still = scene.at(0.0);
        let (limits, lamps) = (vec![1.0; RAYS], vec![NO_SPHERE; RAYS]);
        for search in searches {
            for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
                let intersector = Intersector::with_search(&still, lanes, *search);
                let id = |what| BenchmarkId::new(format!("{what} {search:?} {lanes:?}"), still.spheres.len());
                let mut group = c.benchmark_group("rays");
                group.throughput(Throughput::Elements(RAYS as u64));
                group.bench_function(id("nearest"), |b| b.iter(|| intersector.nearest(black_box(&rays))));
                group.bench_function(id("any"), |b| {
                    b.iter(|| intersector.occluded(black_box(&rays), &limits, &lamps));
                });
                group.finish();
            }
        }
    }
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        let (spheres, _) = scattered(count, 1, 0, 4);
        let scene = scene_of(spheres, Vec3::splat(1e4));
        let still = scene.at(0.0);
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| Intersector::with_search(black_box(&still), LaneKind::best(), Search::Tree));
        });
    }
    group.finish();
}

criterion_group!(benches, traverse, build);
criterion_main!(benches);
