//! The command `verify`: checks that engines agree in every bit of every plane after every iteration.

use crate::args::engine::MachineArgs;
use crate::args::scene::SceneArg;
use crate::args::settings::SettingsArgs;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::{Args, ValueHint};
use compare::planes;
use fast::Parameters;
use rayon::ThreadPool;
use render::{LanesName, MethodName, Profile, available_lanes, cores, pool};
use scene::text::counted;
use scene::{Engine, Scene, Settings};
use std::path::PathBuf;

/// Check that engines agree, bit for bit
///
/// Renders the scene by the reference and by the fast engine, this on every kind of lanes that the processor has, on
/// one thread and on several (--threads, or else one per core and at least 2), and compares direct light, photon
/// count, radius and image of every pixel after every iteration; of the path tracers, the image. For photon mapping the
/// reference with other cells of its hash grid is compared too. On no bit may they differ; exits with 1 and names iteration, pass and pixel of the first difference
/// if there is one.
///
/// The reference is plain code and takes seconds for an iteration at full size; a small image is as good a test.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:\n  sppm verify cornell --width 64 --height 48 --photons 10000")]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    scene: SceneArg,

    /// The method whose engines are compared
    #[arg(long, value_enum, default_value = "sppm", help_heading = "Method")]
    method: MethodName,

    /// Have the fast engine go by the free parameters of this profile, which `sppm tune` wrote, on all lanes
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Machine")]
    profile: Option<PathBuf>,

    #[command(flatten)]
    settings: SettingsArgs,

    #[command(flatten)]
    machine: MachineArgs,
}

/// The cell size of the reference's other grid, in units of the largest radius. The grid gives the same contributions
/// in another order.
const OTHER_CELL_SIZE: f32 = 3.7;

/// A render that must give the same bits as the reference.
struct Variant<'a> {
    label: String,
    engine: Box<dyn Engine + Send + 'a>,
    /// The threads that run its iterations.
    pool: &'a ThreadPool,
}

/// Renders with the reference and with every variant. Prints that they are identical, or fails with their first
/// difference.
pub(crate) fn run(args: &VerifyArgs) -> Result<(), Error> {
    let opened = args.scene.open([args.settings.width, args.settings.height])?;
    let settings = args.settings.apply_numbers(&opened.scene.settings)?;
    let most = args.machine.threads.unwrap_or_else(|| cores().max(2));
    let mut counts = vec![1, most];
    counts.dedup();
    let pools: Vec<ThreadPool> =
        counts.into_iter().map(|threads| pool(Some(threads))).collect::<Result<_, _>>()?;
    let profile = args.profile.as_deref().map(Profile::read).transpose()?;
    let parameters = profile.unwrap_or_default().parameters;
    let mut variants = variants(args.method, &opened.scene, &settings, &pools, &parameters);
    let verdict = verdict(args.method, (&opened.scene.name, &settings), &variants);
    let mut reference: Box<dyn Engine> = match args.method {
        MethodName::Sppm => Box::new(reference::Sppm::new(&opened.scene, &settings)),
        MethodName::Path => Box::new(reference::PathTracer::new(&opened.scene, &settings)),
        MethodName::Hybrid => Box::new(reference::hybrid(
            reference::PathTracer::new(&opened.scene, &settings),
            reference::Sppm::new(&opened.scene, &settings),
        )),
    };
    let progress = Bar::of(settings.iterations, "iterations");
    let difference = first_difference(&mut *reference, &mut variants, settings.iterations, &progress);
    progress.clear();
    match difference {
        Some(difference) => Err(Error::Failed(difference)),
        None => print(verdict.as_bytes()),
    }
}

/// All renders to compare with the reference.
fn variants<'a>(
    method: MethodName,
    scene: &'a Scene,
    settings: &Settings,
    pools: &'a [ThreadPool],
    parameters: &Parameters,
) -> Vec<Variant<'a>> {
    let on = |pool: &ThreadPool| counted(pool.current_num_threads() as u64, "thread");
    let fast = available_lanes().flat_map(|lanes| pools.iter().map(move |pool| (lanes, pool)));
    let fast = fast.map(|(lanes, pool)| Variant {
        label: format!("fast on {} lanes and {}", LanesName::from(lanes).name(), on(pool)),
        engine: match method {
            MethodName::Sppm => Box::new(fast::Sppm::with_parameters(scene, settings, lanes, parameters)),
            MethodName::Path => {
                Box::new(fast::PathTracer::with_parameters(scene, settings, lanes, parameters))
            }
            MethodName::Hybrid => Box::new(fast::hybrid(
                fast::PathTracer::with_parameters(scene, settings, lanes, parameters),
                fast::Sppm::with_parameters(scene, settings, lanes, parameters),
            )),
        },
        pool,
    });
    let other_grid = pools.first().filter(|_| method == MethodName::Sppm).map(|pool| Variant {
        label: format!("the reference with grid cells of {OTHER_CELL_SIZE} radii"),
        engine: Box::new(reference::Sppm::with_cell_size(scene, settings, OTHER_CELL_SIZE)),
        pool,
    });
    fast.chain(other_grid).collect()
}

fn verdict(method: MethodName, (scene, settings): (&str, &Settings), variants: &[Variant]) -> String {
    let planes = match method {
        MethodName::Sppm => "direct light, count, radius and image",
        MethodName::Path => "the path tracer's image",
        MethodName::Hybrid => "count, radius and image",
    };
    let Settings { width, height, iterations, .. } = settings;
    let iterations = counted(*iterations, "iteration");
    let labels: Vec<&str> = variants.iter().map(|v| &v.label[..]).collect();
    let labels = labels.join("\n  ");
    format!(
        "{scene}: identical in every bit of {planes}, {width} x {height} pixels, after \
         each of {iterations}:\n  the reference\n  {labels}\n"
    )
}

/// Runs all engines in lockstep and describes the first difference from `reference`.
fn first_difference(
    reference: &mut dyn Engine,
    variants: &mut [Variant],
    iterations: u32,
    progress: &Bar,
) -> Option<String> {
    (0..iterations).find_map(|done| {
        progress.step(done, "the reference");
        reference.iterate();
        let expected = planes(reference);
        variants.iter_mut().find_map(|Variant { label, engine, pool }| {
            progress.step(done, label);
            let actual = pool.install(|| {
                engine.iterate();
                planes(&**engine)
            });
            let difference = compare::first_difference(&expected, &actual)?;
            Some(format!("{label} differs from the reference in iteration {}, {difference}", done + 1))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Probe, Progress, Rgb, Stop};

    /// Changes the values of the pixel in a given column and row.
    type Spoil = fn([u32; 2], &mut Probe);

    /// An engine whose pixels are all equal, until `spoil` changes them from iteration `from` on.
    struct Fake {
        from: u32,
        spoil: Spoil,
        progress: Progress,
    }

    impl Fake {
        fn new(from: u32, spoil: Spoil) -> Self {
            let settings = Settings { width: 3, height: 2, ..Settings::default() };
            Self { from, spoil, progress: Progress::new(&settings) }
        }
    }

    impl Engine for Fake {
        fn progress(&self) -> &Progress {
            &self.progress
        }
        fn iterate_unless(&mut self, _: &Stop) -> bool {
            self.progress.advance();
            true
        }
        fn probe(&self, x: u32, y: u32) -> Probe {
            let mut probe =
                Probe { radiance: Rgb::splat(0.25), direct: Rgb::splat(0.5), radius: 1.5, count: 0.0 };
            if self.progress.iterations >= self.from {
                (self.spoil)([x, y], &mut probe);
            }
            probe
        }
    }

    fn differ(from: u32, spoil: Spoil) -> Option<String> {
        let pool = pool(Some(1)).unwrap();
        let variant =
            |label: &str, engine| Variant { label: label.into(), engine: Box::new(engine), pool: &pool };
        let mut variants =
            [variant("twin", Fake::new(u32::MAX, |_, _| ())), variant("other", Fake::new(from, spoil))];
        let mut reference = Fake::new(u32::MAX, |_, _| ());
        first_difference(&mut reference, &mut variants, 4, &Bar::of(4, "iterations"))
    }

    #[test]
    fn equals_are_identical() {
        assert_eq!(differ(u32::MAX, |_, _| ()), None);
    }

    #[test]
    fn a_bit_of_the_image_is_found() {
        let spoil: Spoil = |place, probe| {
            if place == [1, 1] {
                probe.radiance.z = f32::from_bits(0x3e80_0001);
            }
        };
        assert_eq!(
            differ(3, spoil).as_deref(),
            Some(
                "other differs from the reference in iteration 3, flux of the photon pass, or develop: \
                 image of pixel (1, 1) is 0.25000003 (0x3e800001) instead of 0.25 (0x3e800000)"
            )
        );
    }

    #[test]
    fn the_first_pass_with_a_difference_is_named() {
        let all = differ(2, |place, probe| match place {
            [0, 0] => probe.radiance.x = 0.0,
            [2, 0] => probe.radius = 1.25,
            [0, 1] => probe.count = 1.0,
            [2, 1] => probe.direct.y = 0.0,
            _ => (),
        });
        let (place, values) = ("in iteration 2, camera pass: direct light of pixel (2, 1)", "is 0.0 (");
        assert!(all.as_deref().is_some_and(|d| d.contains(place) && d.contains(values)), "{all:?}");
    }

    /// The last iterations are compared too, and no more.
    #[test]
    fn all_iterations_are_compared() {
        assert!(differ(4, |_, probe| probe.count = 1.0).unwrap().contains("in iteration 4, "));
        assert_eq!(differ(5, |_, probe| probe.count = 1.0), None);
    }

    #[test]
    fn a_verdict_names_what_was_compared() {
        let pool = pool(Some(1)).unwrap();
        let settings = Settings { width: 3, height: 2, iterations: 4, ..Settings::default() };
        let engine = || Box::new(Fake::new(u32::MAX, |_, _| ()));
        let variants = ["a", "b"].map(|label| Variant { label: label.into(), engine: engine(), pool: &pool });
        let said = verdict(MethodName::Sppm, ("box", &settings), &variants);
        assert_eq!(
            said,
            "box: identical in every bit of direct light, count, radius and image, 3 x 2 pixels, after each of 4 \
             iterations:\n  the reference\n  a\n  b\n"
        );
        let said = verdict(MethodName::Path, ("box", &settings), &variants);
        assert!(
            said.starts_with("box: identical in every bit of the path tracer's image, 3 x 2 pixels"),
            "{said}"
        );
        let said = verdict(MethodName::Hybrid, ("box", &settings), &variants);
        assert!(said.starts_with("box: identical in every bit of count, radius and image, 3 x 2"), "{said}");
    }

    /// The image does not show them, but what is looked at on the way does.
    #[test]
    fn the_fast_engine_goes_by_the_parameters_of_a_profile() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 16, height: 12, photons_per_iteration: 500, ..scene.settings };
        let pools = [pool(Some(1)).unwrap()];
        let candidates = |method, cell_size| {
            let parameters = Parameters::default().with("cell_size", cell_size).unwrap();
            let mut all = variants(method, &scene, &settings, &pools, &parameters);
            all[0].engine.iterate();
            all[0].engine.stats().candidates
        };
        for method in [MethodName::Sppm, MethodName::Hybrid] {
            assert_ne!(candidates(method, 2.0), candidates(method, 12.0), "{method:?}");
        }
    }

    /// On every kind of lanes and every number of threads, and the reference with another grid, which path tracing has none of.
    #[test]
    fn every_engine_is_compared() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 3, height: 2, ..scene.settings };
        let pools = [pool(Some(1)).unwrap(), pool(Some(2)).unwrap()];
        let labels = |method| -> Vec<String> {
            let all = variants(method, &scene, &settings, &pools, &Parameters::default());
            assert!(all.iter().all(|variant| variant.engine.has_photons() == method.has_photons()));
            all.into_iter().map(|variant| variant.label).collect()
        };
        let (sppm, path) = (labels(MethodName::Sppm), labels(MethodName::Path));
        assert_eq!(labels(MethodName::Hybrid), path);
        assert_eq!(path.len(), 2 * available_lanes().count());
        assert_eq!(
            path[..2],
            ["fast on emulated lanes and 1 thread", "fast on emulated lanes and 2 threads"]
        );
        assert_eq!(sppm[..path.len()], path);
        assert_eq!(sppm[path.len()..], ["the reference with grid cells of 3.7 radii"]);
    }
}
