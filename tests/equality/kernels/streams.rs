//! Kernels for random streams: initial states, words and floats.

use super::inputs::numbers;
use super::{check_map, edge_uniforms, tell};
use fast::kernels::{next_uniform, stream_state, unit_float};
use scene::rng::{Family, STATE_FOR_ZERO, StreamKey};

const FAMILIES: [Family; 6] =
    [Family::Camera, Family::Tile, Family::Photon, Family::Emission, Family::Shutter, Family::Path];

#[test]
fn streams_have_the_right_initial_states() {
    let mut cases = 0;
    for (k, family) in FAMILIES.into_iter().enumerate() {
        for seed in [0, 1, u64::MAX, 0x0123_4567_89ab_cdef] {
            let key = StreamKey::new(seed, family, 77 * k as u32);
            let spread =
                (0..2000_u32).chain((0..2000_u32).map(|k| k.wrapping_mul(0x9e37_79b9))).chain([u32::MAX]);
            let rows: Vec<[f32; 1]> = spread.map(|index| [f32::from_bits(index)]).collect();
            let kernel = |lanes, inputs: [&[f32]; 1], outputs: [&mut [f32]; 1]| {
                stream_state(lanes, key, inputs, outputs);
            };
            let definition = |[index]: [f32; 1]| [f32::from_bits(key.state(index.to_bits()))];
            cases += check_map("stream_state", &rows, kernel, definition);
        }
    }
    // The index that hashes to zero, and its neighbours.
    let key = StreamKey::new(1, Family::Photon, 0);
    assert_eq!(key.state(98_778_080), STATE_FOR_ZERO);
    let rows: Vec<[f32; 1]> = (98_778_070..98_778_090).map(|index| [f32::from_bits(index)]).collect();
    let kernel =
        |lanes, inputs: [&[f32]; 1], outputs: [&mut [f32]; 1]| stream_state(lanes, key, inputs, outputs);
    cases += check_map("stream_state", &rows, kernel, |[i]| [f32::from_bits(key.state(i.to_bits()))]);
    tell(cases, "start states");
}

#[test]
fn streams_advance_in_the_same_way() {
    let key = StreamKey::new(3, Family::Camera, 5);
    let states: Vec<u32> = (0..50_000).map(|index| key.state(index)).chain([1, u32::MAX, 1 << 31]).collect();
    // A stream's state is its last word.
    let step = |state: u32| {
        let x = state ^ (state << 13);
        let x = x ^ (x >> 17);
        x ^ (x << 5)
    };
    for index in 0..1000 {
        let mut stream = key.stream(index);
        assert_eq!(stream.next_u32(), step(key.state(index)));
        assert_eq!(stream.next_u32(), step(step(key.state(index))));
    }
    let rows: Vec<[f32; 1]> = states.iter().map(|state| [f32::from_bits(*state)]).collect();
    let definition = |[state]: [f32; 1]| {
        let next = step(state.to_bits());
        [f32::from_bits(next), scene::rng::unit_float(next)]
    };
    tell(check_map("next_uniform", &rows, next_uniform, definition), "steps of streams");
}

#[test]
fn words_become_floats_below_one() {
    let mut stream = numbers(0);
    let random = (0..100_000).map(|_| stream.next_u32());
    let edges = [0, 1, 255, 256, 257, 0x7fff_ffff, 0x8000_0000, 0xffff_feff, 0xffff_ff00, u32::MAX];
    let rows: Vec<[f32; 1]> = edges.into_iter().chain(random).map(|word| [f32::from_bits(word)]).collect();
    let definition = |[word]: [f32; 1]| [scene::rng::unit_float(word.to_bits())];
    let cases = check_map("unit_float", &rows, unit_float, definition);
    assert!(edge_uniforms().iter().all(|u| (0.0..1.0).contains(u)));
    tell(cases, "uniform floats");
}
