//! Kernels that update pixels after an iteration and develop them.

use super::{assert_same, assert_same_vector, check, lane_kinds};
use crate::placement::log_uniform;
use fast::kernels::{Consolidation, Gathered, Pixel, Seen};
use proptest::prelude::*;
use reference::consolidate;
use scene::aim::MOST_SCALE_BITS;
use scene::film::FluxUnit;
use scene::guide::GUIDED_BITS;
use scene::{Rgb, Settings};

/// Zero, values of any size, and the largest possible sums.
fn photons() -> impl Strategy<Value = Gathered> {
    let m = prop_oneof![4 => Just(0_u32), 1 => Just(1), 8 => 1..5000_u32, 1 => Just(16_777_217), 1 => Just((1 << 31) - 1)];
    let flux = || {
        prop_oneof![
            1 => Just(0_u128),
            6 => 0..1_u128 << 30,
            2 => 0..1_u128 << 52,
            1 => Just(1 << 52),
            1 => 0..1_u128 << 127,
            1 => Just(1 << 127),
        ]
    };
    (m, flux(), flux(), flux()).prop_map(|(m, r, g, b)| Gathered { m, flux: [r, g, b] })
}

/// Of any power, in the units of photons that weigh alike or are guided, and of those that are aimed.
fn units() -> impl Strategy<Value = FluxUnit> {
    let bits = -(GUIDED_BITS as i32)..=MOST_SCALE_BITS as i32;
    (log_uniform(1e-30, 1e20), bits).prop_map(|(nominal, bits)| FluxUnit::new(nominal, 2.0_f32.powi(bits)))
}

fn color() -> impl Strategy<Value = Rgb> {
    let channel = || prop_oneof![1 => Just(0.0), 4 => 0.0..2.0_f32, 1 => log_uniform(1e-30, 1e20)];
    [channel(), channel(), channel()].prop_map(Rgb::from_array)
}

fn pixel() -> impl Strategy<Value = Pixel> {
    let n = prop_oneof![1 => Just(0.0), 3 => 0.0..1e4_f32, 1 => Just(16_777_216.0)];
    (color(), color(), n, log_uniform(1e-15, 1e15)).prop_map(|(direct, tau, n, radius)| Pixel {
        direct,
        tau,
        n,
        radius_squared: radius * radius,
    })
}

fn of_reference(pixel: &Pixel) -> consolidate::Pixel {
    let Pixel { direct, tau, n, radius_squared } = *pixel;
    consolidate::Pixel { direct, tau, n, radius_squared }
}

#[test]
fn pixels_are_consolidated() {
    let seen = (color(), color(), log_uniform(1e-15, 1e15)).prop_map(|(direct, beta, radius)| Seen {
        direct,
        beta,
        radius_squared: radius * radius,
    });
    let inputs = (prop::collection::vec((pixel(), seen, photons()), 0..=48), units());
    check(400, "consolidate", &inputs, |(rows, unit)| {
        let (pixels, rest): (Vec<_>, Vec<_>) = rows.iter().map(|(p, s, g)| (*p, (*s, *g))).unzip();
        let (seen, gathered): (Vec<_>, Vec<_>) = rest.into_iter().unzip();
        for lanes in lane_kinds() {
            let mut all = Consolidation::new(&pixels, &seen, &gathered);
            all.run(lanes, unit);
            let actual = all.pixels();
            prop_assert_eq!(actual.len(), pixels.len());
            for (actual, (pixel, seen, gathered)) in actual.iter().zip(&rows) {
                let mut expected = of_reference(pixel);
                expected.direct += seen.direct;
                let Gathered { m, flux } = *gathered;
                expected.consolidate(
                    (seen.beta, seen.radius_squared),
                    &consolidate::Gathered { m, flux },
                    unit,
                );
                let what = (lanes, pixel, seen, gathered);
                assert_same_vector(actual.direct, expected.direct, &what);
                assert_same_vector(actual.tau, expected.tau, &what);
                assert_same(
                    &[actual.n, actual.radius_squared],
                    &[expected.n, expected.radius_squared],
                    &what,
                );
            }
        }
        Ok(())
    });
}

#[test]
fn pixels_are_developed() {
    let settings = (1..=1_u32 << 28, any::<u64>()).prop_map(|(photons_per_iteration, seed)| Settings {
        photons_per_iteration,
        seed,
        ..Settings::default()
    });
    check(2000, "develop", &(pixel(), settings, 1..=1_u32 << 30), |(pixel, settings, iterations)| {
        let actual = pixel.develop(&settings, iterations);
        let expected = of_reference(&pixel).develop(&settings, iterations);
        assert_same_vector(actual, expected, &(pixel, settings, iterations));
        Ok(())
    });
}

#[test]
fn pixels_begin_with_their_radius() {
    check(200, "new pixels", &log_uniform(1e-15, 1e15), |radius| {
        let (actual, expected) = (Pixel::new(radius), consolidate::Pixel::new(radius));
        prop_assert_eq!(of_reference(&actual), expected);
        Ok(())
    });
}
