//! The command `verify`: engines must agree on every bit of every plane after every iteration.

use crate::args::VerifyArgs;
use crate::error::Error;
use crate::text::{counted, print};
use crate::{scenes, threads};
use reference::Sppm;
use scene::{Engine, Plane, Rgb, Scene, Settings};

/// A way to render that must give the reference's bits.
struct Variant {
    label: &'static str,
    start: for<'a> fn(&'a Scene, &Settings) -> Box<dyn Engine + 'a>,
}

/// What is compared with the reference. Cells of other sizes find the same candidates in another order.
const VARIANTS: &[Variant] = &[
    Variant {
        label: "the reference with grid cells of 1 radius",
        start: |scene, settings| Box::new(Sppm::with_cell_size(scene, settings, 1.0)),
    },
    Variant {
        label: "the reference with grid cells of 3.7 radii",
        start: |scene, settings| Box::new(Sppm::with_cell_size(scene, settings, 3.7)),
    },
];

/// Renders by the reference and by every variant, and says that they are identical or where they first differ.
pub(crate) fn verify(args: &VerifyArgs) -> Result<(), Error> {
    let opened = scenes::open(&args.scene)?;
    let settings = args.settings.apply(&opened)?;
    threads::start(args.machine.threads)?;
    let mut reference = Sppm::new(&opened.scene, &settings);
    let mut others: Vec<(&str, Box<dyn Engine + '_>)> =
        VARIANTS.iter().map(|v| (v.label, (v.start)(&opened.scene, &settings))).collect();
    match first_difference(&mut reference, &mut others, settings.iterations) {
        Some(difference) => Err(Error::Failed(difference)),
        None => print(verdict(&opened.scene.name, &settings).as_bytes()),
    }
}

fn verdict(scene: &str, settings: &Settings) -> String {
    let Settings { width, height, iterations, .. } = settings;
    let iterations = counted(*iterations, "iteration");
    let labels: Vec<&str> = VARIANTS.iter().map(|v| v.label).collect();
    let labels = labels.join("\n  ");
    format!(
        "{scene}: identical in every bit of image, radius and count, {width} x {height} pixels, after each of \
         {iterations}:\n  the reference\n  {labels}\nThere is no second engine yet; the reference was compared with itself.\n"
    )
}

/// Iterates all in step and describes the first difference from `reference`.
fn first_difference(
    reference: &mut dyn Engine,
    others: &mut [(&str, Box<dyn Engine + '_>)],
    iterations: u32,
) -> Option<String> {
    (1..=iterations).find_map(|iteration| {
        reference.iterate();
        let expected = planes(reference);
        others.iter_mut().find_map(|(label, engine)| {
            engine.iterate();
            let place = compare(&expected, &planes(&**engine))?;
            Some(format!("{label} differs from the reference after iteration {iteration}, {place}"))
        })
    })
}

/// Everything that an engine has to show: each plane by name, with its values per pixel.
fn planes(engine: &dyn Engine) -> Vec<Shown> {
    let film = engine.develop();
    let image = film.pixels.iter().flat_map(Rgb::to_array).collect();
    let plane = |name, plane: Option<Plane>| {
        let values = plane.map_or(Vec::new(), |p| p.values);
        Shown { name, width: film.width, channels: 1, values }
    };
    vec![
        Shown { name: "image", width: film.width, channels: 3, values: image },
        plane("radius", engine.radius()),
        plane("count", engine.count()),
    ]
}

struct Shown {
    name: &'static str,
    width: u32,
    channels: usize,
    values: Vec<f32>,
}

/// The first difference of `actual` from `expected`, by bits and not by value: 0 is not -0.
fn compare(expected: &[Shown], actual: &[Shown]) -> Option<String> {
    expected.iter().zip(actual).find_map(|(expected, actual)| {
        let name = expected.name;
        if expected.values.len() != actual.values.len() {
            let (want, have) = (expected.values.len(), actual.values.len());
            return Some(format!("plane {name}: {have} values instead of {want}"));
        }
        let index = expected.values.iter().zip(&actual.values).position(|(e, a)| e.to_bits() != a.to_bits())?;
        let (want, have) = (expected.values[index], actual.values[index]);
        let pixel = index / expected.channels;
        let (x, y) = (pixel % expected.width as usize, pixel / expected.width as usize);
        let (have_bits, want_bits) = (have.to_bits(), want.to_bits());
        Some(format!(
            "plane {name}, pixel ({x}, {y}): {have:?} ({have_bits:#010x}) instead of {want:?} ({want_bits:#010x})"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Film, Stats};

    /// Shows what it is told to; from iteration `from` on, `spoil` has its way with it.
    struct Fake {
        done: u32,
        from: u32,
        spoil: fn(&mut Film, &mut Plane, &mut Plane),
        stats: Stats,
    }

    impl Fake {
        fn boxed(from: u32, spoil: fn(&mut Film, &mut Plane, &mut Plane)) -> Box<dyn Engine> {
            Box::new(Self { done: 0, from, spoil, stats: Stats::default() })
        }

        fn show(&self) -> (Film, Plane, Plane) {
            let plane = |value| Plane { width: 3, height: 2, values: vec![value; 6] };
            let (mut film, mut radius, mut count) = (Film::new(3, 2), plane(1.5), plane(0.0));
            film.pixels.fill(Rgb::splat(0.25));
            if self.done >= self.from {
                (self.spoil)(&mut film, &mut radius, &mut count);
            }
            (film, radius, count)
        }
    }

    impl Engine for Fake {
        fn iterate(&mut self) {
            self.done += 1;
        }
        fn iterations(&self) -> u32 {
            self.done
        }
        fn develop(&self) -> Film {
            self.show().0
        }
        fn radius(&self) -> Option<Plane> {
            Some(self.show().1)
        }
        fn count(&self) -> Option<Plane> {
            Some(self.show().2)
        }
        fn stats(&self) -> &Stats {
            &self.stats
        }
    }

    fn differ(from: u32, spoil: fn(&mut Film, &mut Plane, &mut Plane)) -> Option<String> {
        let mut reference = Fake::boxed(u32::MAX, |_, _, _| ());
        let mut others =
            vec![("twin", Fake::boxed(u32::MAX, |_, _, _| ())), ("other", Fake::boxed(from, spoil))];
        first_difference(&mut *reference, &mut others, 4)
    }

    #[test]
    fn equals_are_identical() {
        assert_eq!(differ(u32::MAX, |_, _, _| ()), None);
    }

    #[test]
    fn a_bit_of_the_image_is_found() {
        let spoil =
            |film: &mut Film, _: &mut Plane, _: &mut Plane| film.pixels[4].z = f32::from_bits(0x3e80_0001);
        assert_eq!(
            differ(3, spoil).as_deref(),
            Some(
                "other differs from the reference after iteration 3, plane image, pixel (1, 1): \
                 0.25000003 (0x3e800001) instead of 0.25 (0x3e800000)"
            )
        );
    }

    #[test]
    fn a_radius_is_found() {
        let difference = differ(1, |_, radius, _| radius.values[2] = 1.25).unwrap();
        assert!(difference.contains("after iteration 1, plane radius, pixel (2, 0): 1.25"), "{difference}");
    }

    #[test]
    fn a_negative_zero_is_a_difference() {
        let difference = differ(4, |_, _, count| count.values[3] = -0.0).unwrap();
        assert!(difference.contains("after iteration 4, plane count, pixel (0, 1): -0.0"), "{difference}");
    }

    #[test]
    fn a_missing_value_is_a_difference() {
        let difference = differ(1, |_, _, count| count.values.truncate(5)).unwrap();
        assert!(difference.contains("plane count: 5 values instead of 6"), "{difference}");
    }
}
