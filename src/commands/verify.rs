//! The command `verify`: engines must agree on every bit of every plane after every iteration.

use crate::args::{MachineArgs, SceneArg, SettingsArgs};
use crate::engines::{LanesName, available_lanes};
use crate::error::Error;
use crate::profile::Profile;
use crate::progress::Progress;
use crate::text::{counted, print};
use crate::{scenes, threads};
use clap::{Args, ValueHint};
use compare::planes;
use fast::Parameters;
use rayon::ThreadPool;
use scene::{Engine, Scene, Settings};
use std::path::PathBuf;

/// Check that engines agree, bit for bit
///
/// Renders the scene by the reference and by the fast engine, this on every kind of lanes that the processor has, on
/// one thread and on several (--threads, or else one per core and at least 2), and compares direct light, photon
/// count, radius and image of every pixel after every iteration. The reference with other cells of its hash grid is
/// compared too. On no bit may they differ; exits with 1 and names iteration, pass and pixel of the first difference
/// if there is one.
///
/// The reference is plain code and takes seconds for an iteration at full size; a small image is as good a test.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:\n  sppm verify cornell --width 64 --height 48 --photons 10000")]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    scene: SceneArg,

    /// Have the fast engine go by the free parameters of this profile, which `sppm tune` wrote, on all lanes
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Machine")]
    profile: Option<PathBuf>,

    #[command(flatten)]
    settings: SettingsArgs,

    #[command(flatten)]
    machine: MachineArgs,
}

/// The cell size of the reference's other grid, in largest radii: it gives the same candidates in another order.
const OTHER_CELL_SIZE: f32 = 3.7;

/// A render that must give the reference's bits.
struct Variant<'a> {
    label: String,
    engine: Box<dyn Engine + Send + 'a>,
    /// The threads that it iterates on.
    pool: &'a ThreadPool,
}

/// Renders by the reference and by every variant, and says that they are identical or where they first differ.
pub(crate) fn run(args: &VerifyArgs) -> Result<(), Error> {
    let opened = scenes::open(&args.scene.name)?;
    let settings = args.settings.apply(&opened)?;
    let most = args.machine.threads.unwrap_or_else(|| threads::cores().max(2));
    let mut counts = vec![1, most];
    counts.dedup();
    let pools: Vec<ThreadPool> = counts.into_iter().map(threads::pool).collect::<Result<_, _>>()?;
    let profile = args.profile.as_deref().map(Profile::read).transpose()?;
    let parameters = profile.unwrap_or_default().parameters;
    let mut variants = variants(&opened.scene, &settings, &pools, &parameters);
    let verdict = verdict(&opened.scene.name, &settings, &variants);
    let mut reference = reference::Sppm::new(&opened.scene, &settings);
    let progress = Progress::new(settings.iterations, false);
    let difference = first_difference(&mut reference, &mut variants, settings.iterations, &progress);
    progress.clear();
    match difference {
        Some(difference) => Err(Error::Failed(difference)),
        None => print(verdict.as_bytes()),
    }
}

/// Everything that is compared with the reference.
fn variants<'a>(
    scene: &'a Scene,
    settings: &Settings,
    pools: &'a [ThreadPool],
    parameters: &Parameters,
) -> Vec<Variant<'a>> {
    let on = |pool: &ThreadPool| counted(pool.current_num_threads() as u64, "thread");
    let fast = available_lanes().flat_map(|lanes| pools.iter().map(move |pool| (lanes, pool)));
    let fast = fast.map(|(lanes, pool)| Variant {
        label: format!("fast on {} lanes and {}", LanesName::from(lanes).name(), on(pool)),
        engine: Box::new(fast::Sppm::with_parameters(scene, settings, lanes, parameters)),
        pool,
    });
    let other_grid = pools.first().map(|pool| Variant {
        label: format!("the reference with grid cells of {OTHER_CELL_SIZE} radii"),
        engine: Box::new(reference::Sppm::with_cell_size(scene, settings, OTHER_CELL_SIZE)),
        pool,
    });
    fast.chain(other_grid).collect()
}

fn verdict(scene: &str, settings: &Settings, variants: &[Variant]) -> String {
    let Settings { width, height, iterations, .. } = settings;
    let iterations = counted(*iterations, "iteration");
    let labels: Vec<&str> = variants.iter().map(|v| &v.label[..]).collect();
    let labels = labels.join("\n  ");
    format!(
        "{scene}: identical in every bit of direct light, count, radius and image, {width} x {height} pixels, after \
         each of {iterations}:\n  the reference\n  {labels}\n"
    )
}

/// Iterates all in step and describes the first difference from `reference`.
fn first_difference(
    reference: &mut dyn Engine,
    variants: &mut [Variant],
    iterations: u32,
    progress: &Progress,
) -> Option<String> {
    (1..=iterations).find_map(|iteration| {
        progress.step(iteration - 1, "the reference");
        reference.iterate();
        let expected = planes(reference);
        variants.iter_mut().find_map(|Variant { label, engine, pool }| {
            progress.step(iteration - 1, label);
            let actual = pool.install(|| {
                engine.iterate();
                planes(&**engine)
            });
            let difference = compare::first_difference(&expected, &actual)?;
            Some(format!("{label} differs from the reference in iteration {iteration}, {difference}"))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Film, Plane, Rgb, Stats};

    /// The planes of [`Fake`].
    struct Planes {
        direct: Film,
        count: Plane,
        radius: Plane,
        image: Film,
    }

    /// An engine with constant planes; from iteration `from` on, `spoil` changes them.
    struct Fake {
        done: u32,
        from: u32,
        spoil: fn(&mut Planes),
        stats: Stats,
    }

    impl Fake {
        fn new(from: u32, spoil: fn(&mut Planes)) -> Self {
            Self { done: 0, from, spoil, stats: Stats::default() }
        }

        fn planes(&self) -> Planes {
            let plane = |value| Plane { width: 3, height: 2, values: vec![value; 6] };
            let film = |value| Film { width: 3, height: 2, pixels: vec![Rgb::splat(value); 6] };
            let mut planes =
                Planes { direct: film(0.5), count: plane(0.0), radius: plane(1.5), image: film(0.25) };
            if self.done >= self.from {
                (self.spoil)(&mut planes);
            }
            planes
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
            self.planes().image
        }
        fn direct(&self) -> Option<Film> {
            Some(self.planes().direct)
        }
        fn radius(&self) -> Option<Plane> {
            Some(self.planes().radius)
        }
        fn count(&self) -> Option<Plane> {
            Some(self.planes().count)
        }
        fn stats(&self) -> &Stats {
            &self.stats
        }
    }

    fn differ(from: u32, spoil: fn(&mut Planes)) -> Option<String> {
        let pool = threads::pool(1).unwrap();
        let variant =
            |label: &str, engine| Variant { label: label.into(), engine: Box::new(engine), pool: &pool };
        let mut variants =
            [variant("twin", Fake::new(u32::MAX, |_| ())), variant("other", Fake::new(from, spoil))];
        let mut reference = Fake::new(u32::MAX, |_| ());
        first_difference(&mut reference, &mut variants, 4, &Progress::new(4, true))
    }

    #[test]
    fn equals_are_identical() {
        assert_eq!(differ(u32::MAX, |_| ()), None);
    }

    #[test]
    fn a_bit_of_the_image_is_found() {
        assert_eq!(
            differ(3, |planes| planes.image.pixels[4].z = f32::from_bits(0x3e80_0001)).as_deref(),
            Some(
                "other differs from the reference in iteration 3, flux of the photon pass, or develop: \
                 image of pixel (1, 1) is 0.25000003 (0x3e800001) instead of 0.25 (0x3e800000)"
            )
        );
    }

    #[test]
    fn the_first_pass_with_a_difference_is_named() {
        let all = differ(2, |planes| {
            planes.image.pixels[0].x = 0.0;
            planes.radius.values[2] = 1.25;
            planes.count.values[3] = 1.0;
            planes.direct.pixels[5].y = 0.0;
        });
        let (place, values) = ("in iteration 2, camera pass: direct light of pixel (2, 1)", "is 0.0 (");
        assert!(all.as_deref().is_some_and(|d| d.contains(place) && d.contains(values)), "{all:?}");

        let radius = differ(1, |planes| planes.radius.values[2] = 1.25).unwrap();
        assert!(radius.contains("in iteration 1, consolidate: radius of pixel (2, 0) is 1.25"), "{radius}");
    }

    #[test]
    fn a_negative_zero_is_a_difference() {
        let zero = differ(4, |planes| planes.count.values[3] = -0.0).unwrap();
        assert!(zero.contains("in iteration 4, photon pass: count of pixel (0, 1) is -0.0"), "{zero}");
    }
}
