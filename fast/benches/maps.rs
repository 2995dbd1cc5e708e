//! Kernels that act on every lane by itself, 4096 values at a time.

mod inputs;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fast::LaneKind;
use fast::kernels::{
    cosine_hemisphere, dielectric, next_uniform, quantise, sincos_turn, stream_state, uniform_cone,
};
use inputs::uniforms;
use scene::rng::{Family, StreamKey};
use std::array::from_fn;
use std::hint::black_box;

const COUNT: usize = 4096;

/// Benches a map of `A` columns of uniform numbers on every kind of lanes.
fn map<const A: usize, const B: usize>(
    c: &mut Criterion,
    name: &str,
    kernel: impl Fn(LaneKind, [&[f32]; A], [&mut [f32]; B]),
) {
    let inputs: [Vec<f32>; A] = uniforms(COUNT);
    let mut outputs: [Vec<f32>; B] = from_fn(|_| vec![0.0; COUNT]);
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(COUNT as u64));
    for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
        group.bench_function(BenchmarkId::from_parameter(format!("{lanes:?}")), |b| {
            b.iter(|| {
                let inputs = black_box(&inputs).each_ref().map(|column| &column[..]);
                kernel(lanes, inputs, outputs.each_mut().map(|column| &mut column[..]));
            });
        });
    }
    group.finish();
}

fn maps(c: &mut Criterion) {
    let key = StreamKey::new(1, Family::Photon, 0);
    map(c, "stream start", |lanes, inputs: [&[f32]; 1], outputs: [&mut [f32]; 1]| {
        stream_state(lanes, key, inputs, outputs);
    });
    map(c, "stream step", next_uniform);
    map(c, "sincos", sincos_turn);
    map(c, "cosine hemisphere", cosine_hemisphere);
    map(c, "cone", uniform_cone);
    map(c, "dielectric", dielectric);
    map(c, "quantise", quantise);
}

criterion_group!(benches, maps);
criterion_main!(benches);
