//! With keyed random numbers and flux summed in floats, as in the paper, every row must give the reference's radii and
//! counts exactly. The image may differ only by what the order of additions can cause.

use crate::difference::Outcome;
use crate::pair::{References, builtin};
use compare::PlaneKind;
use ladder::{Options, ROWS, Random};
use scene::{Scene, Settings};
use std::f64::consts::PI;

/// Relative error of one rounding of an `f32`.
const ROUNDING: f64 = 1.0 / 16_777_216.0;
/// Error of the reference's quantised flux, relative to the nominal power of a photon.
const QUANTISATION: f64 = 1.0 / 4_194_304.0;
/// Roundings of a term besides those of the sum, in both engines: BSDF times power, throughput, ratio and density.
const ROUNDINGS_OF_A_TERM: f64 = 16.0;

/// Bound on the difference in radiance of a pixel that has counted `photons` photons in all iterations together.
///
/// Each photon contributes at most `throughput / pi * nominal` before the density. A sum of n terms of the same sign,
/// in any order, has a relative error of at most n roundings (Higham 2002, section 4.2). Adding up the sums of the
/// iterations adds no more roundings than there are photons.
fn bound(throughput: f64, nominal: f64, photons: f64, density: f64) -> f64 {
    let most = throughput / PI * nominal * photons * density;
    most * ((photons + ROUNDINGS_OF_A_TERM) * ROUNDING + QUANTISATION)
}

/// Alpha of the radius reduction: what each photon adds to N.
const ALPHA: f64 = 2.0 / 3.0;

fn assert_within_the_bound(scene: &Scene, settings: &Settings) {
    let options = Options { random: Random::Keyed, ..Options::paper() };
    let mut references = References::new(scene, settings);
    for _ in 0..settings.iterations {
        references.iterate();
    }
    let nominal = f64::from(scene.at(0.0).lights.power);
    // Inside glass, radiance is scaled by the squared index of refraction, so the throughput of a path can exceed 1.
    let throughput = 1.5_f64.powi(2);
    let shot = f64::from(settings.iterations * settings.photons_per_iteration);
    for row in ROWS {
        let expected = references.of(row);
        let [_, counts, radii, image] = expected.planes.each_ref().map(|plane| &plane.values);
        let mut rung = row.start(scene, settings, &options);
        for _ in 0..settings.iterations {
            rung.iterate();
        }
        let actual = Outcome::of(&*rung);
        let exact = [PlaneKind::DirectLight, PlaneKind::Count, PlaneKind::Radius];
        let difference = expected.difference_in(&actual, &exact);
        assert_eq!(difference, None, "{}, row {}", scene.name, row.name);
        for (index, (&want, &have)) in image.iter().zip(&actual.planes[3].values).enumerate() {
            let (count, radius) = (f64::from(counts[index / 3]), f64::from(radii[index / 3]));
            let density = 1.0 / (shot * PI * radius * radius);
            let photons_may = bound(throughput, nominal, count / ALPHA, density);
            // Adding direct light rounds once more.
            let may = photons_may + 2.0 * ROUNDING * f64::from(want.abs());
            let difference = f64::from(want - have).abs();
            assert!(
                difference <= may,
                "{}, row {}: value {index} is {have:?} instead of {want:?}, {difference:e} away, more than {may:e}",
                scene.name,
                row.name
            );
        }
    }
}

#[test]
fn builtin_scenes() {
    for name in ["cornell", "large", "mirror", "random", "surgery", "motion"] {
        let (scene, settings) = builtin(name);
        assert_within_the_bound(&scene, &Settings { iterations: 4, ..settings });
    }
}

/// Pixels that sum up thousands of photons.
#[test]
fn many_photons_at_a_point() {
    let (scene, settings) = builtin("cornell");
    let settings =
        Settings { width: 9, height: 5, photons_per_iteration: 20_000, initial_radius: 60.0, ..settings };
    assert_within_the_bound(&scene, &settings);
}

/// The bound is tight enough: it is far below the effect of a single photon.
#[test]
fn the_bound_is_less_than_one_photon() {
    let (photons, density) = (1000.0, 1.0);
    let one_photon = density / PI;
    assert!(bound(1.0, 1.0, photons, density) < 0.1 * one_photon);
}
