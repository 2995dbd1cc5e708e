//! The command `ladder`: times the optimisation stages of the paper (the rows of the ladder) side by side.

use crate::args::particles::ParticleArgs;
use crate::args::quick::measured;
use crate::args::scene::{SceneName, open};
use crate::args::settings::SettingsArgs;
use crate::args::values::whole;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::{Args, ValueEnum};
use ladder::report::{self, Case, Extras, Outputs, Plan, Sweep, films, generators::Generators};
use ladder::{Field, Options, ROWS, Random, Row};
use scene::text::list;
use scene::{Filter, RadiusSchedule};
use std::ffi::OsString;
use std::path::PathBuf;

/// Run the ladder of the paper's stages and time them
///
/// Every row renders the same physics; what differs is how. Runs of all rows are interleaved, on one thread, and the
/// median counts. Rows: the paper's stages 0 to 6, stage 3 with other unroll factors, the paper's failed attempts
/// (horizontal, sorted, blocked), the k-d trees that it proposes, and the fast engine of this program.
#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct LadderArgs {
    /// A scene, as for `render`; may be given more than once [default: the paper's five; with --quick, cornell]
    #[arg(long, value_name = "SCENE", value_parser = SceneName, hide_possible_values = true)]
    scene: Vec<OsString>,

    /// The rows to run, separated by commas [default: all; in a sweep, the stages and the fast engine]
    #[arg(long, value_name = "ROWS", value_delimiter = ',', value_parser = row)]
    rows: Vec<&'static Row>,

    /// Vary one parameter, as in the paper's figures 4, 6, 7 and 9
    #[arg(long, value_enum, value_name = "WHAT")]
    sweep: Option<SweepName>,

    /// Where random numbers come from
    #[arg(long, value_enum, default_value = "paper")]
    rng: RngName,

    /// Runs of every row, of which the median counts [default: 3; with --quick, 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 1000), allow_hyphen_values = true)]
    repeat: Option<u32>,

    /// Small images and few photons: less than a minute in all
    #[arg(long)]
    quick: bool,

    #[command(flatten)]
    also: AlsoArgs,

    /// Write every time and count as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,

    /// Write plots (.svg) into a folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,

    #[command(flatten)]
    settings: SettingsArgs,
}

/// What is done besides timing the rows, or instead.
#[allow(clippy::struct_excessive_bools)] // switches of a command line
#[derive(Debug, Args)]
struct AlsoArgs {
    /// Also count operations and bytes, which takes some ten times as long, and hold them against the machine's peaks
    ///
    /// Peaks and rows are measured here and now. Reports floating-point operations (FLOPs) per cycle and operational
    /// intensity; with --plots also writes rooflines, as in the paper's figures 10 to 12, roofline.csv and peaks.csv,
    /// and in a sweep FLOPs per cycle, as in figure 5. The fast engine is timed, but its operations are not counted.
    #[arg(long)]
    roofline: bool,

    /// In a sweep of iterations, also compare the rows' images with the first row's, as in the paper's figure 8
    #[arg(long, requires = "sweep")]
    similarity: bool,

    /// Also render with as many seeds as there are runs, and tell the rows' errors and what equal quality costs
    ///
    /// Compares the means of 8x8 pixels with those of a hundred times the iterations, at least 600, by the fast engine:
    /// the error is their mean square difference, relative to their mean square, and the cost the error times the
    /// seconds. With --plots also writes quality.csv.
    #[arg(long, conflicts_with = "sweep")]
    quality: bool,

    /// Write the rows' images into a folder instead of timing them: of 2, 4, 8, ... iterations, up to all
    ///
    /// They are called SCENE-ROW-ITERATIONS.pfm. A row renders once, on its way to the last.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["sweep", "repeat", "roofline", "similarity", "quality", "csv", "plots"])]
    images: Option<PathBuf>,

    /// Time generators of random numbers instead of rows
    #[arg(long, conflicts_with_all = ["scene", "rows", "sweep", "rng", "repeat", "quick", "roofline", "similarity", "quality", "images", "plots"])]
    numbers: bool,
}

const EXAMPLES: &str = "\
Examples:
  sppm ladder --quick
  sppm ladder --scene cornell --rows 0,6,fast --csv times.csv --plots plots
  sppm ladder --scene random --sweep spheres --plots plots
  sppm ladder --scene cornell --rows 0,4,6 --roofline --plots plots
  sppm ladder --rows 6,fast --quality --repeat 8

At the paper's settings the baseline takes half a minute per scene and run on machines of today.";

/// What a sweep varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SweepName {
    /// Iterations, from 2 to 64
    Iterations,
    /// Photons of an iteration, from 12500 to 800000
    Photons,
    /// Pixels, from 32x24 to 1024x768
    Size,
    /// The most segments of a path, from 1 to 10
    Depth,
    /// Spheres: the scene without most of its balls, up to all
    Spheres,
}

impl From<SweepName> for Sweep {
    fn from(name: SweepName) -> Self {
        match name {
            SweepName::Iterations => Self::Iterations,
            SweepName::Photons => Self::Photons,
            SweepName::Size => Self::Size,
            SweepName::Depth => Self::Depth,
            SweepName::Spheres => Self::Spheres,
        }
    }
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RngName {
    /// Each row's own generator: rand of the C library, from stage 3 on xorshift
    Paper,
    /// The reference's streams: every row traces the same paths
    Keyed,
}

impl From<RngName> for Random {
    fn from(rng: RngName) -> Self {
        match rng {
            RngName::Paper => Self::Paper,
            RngName::Keyed => Self::Keyed,
        }
    }
}

fn row(name: &str) -> Result<&'static Row, String> {
    let names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
    ladder::find(name).ok_or_else(|| format!("is no row; there are {}", list(&names)))
}

/// The scenes of the paper.
const SCENES: [&str; 5] = ["cornell", "large", "mirror", "random", "surgery"];

/// Runs the ladder. All options are checked before anything is measured.
pub(crate) fn run(args: &LadderArgs) -> Result<(), Error> {
    let outputs = Outputs { csv: args.csv.clone(), plots: args.plots.clone() };
    outputs.check().map_err(told)?;
    args.also.images.as_deref().map_or(Ok(()), films::check).map_err(told)?;
    if args.also.numbers {
        return numbers(&outputs);
    }
    let AlsoArgs { roofline, similarity, quality, .. } = args.also;
    let extras = Extras { roofline, similarity, quality };
    extras.check(args.sweep.map(Sweep::from)).map_err(told)?;
    let plan = plan(args)?;
    let mut progress = Stages::default();
    if let Some(folder) = &args.also.images {
        return films::write(folder, &plan.cases, &plan.rows, &plan.options, &mut progress).map_err(told);
    }
    let text = report::run(&plan, extras, &outputs, &mut progress).map_err(told)?;
    print(text.as_bytes())
}

/// Times generators of random numbers.
fn numbers(outputs: &Outputs) -> Result<(), Error> {
    let generators = Generators::measure();
    outputs.csv.as_deref().map_or(Ok(()), |path| generators.write(path)).map_err(told)?;
    print(generators.text().as_bytes())
}

fn plan(args: &LadderArgs) -> Result<Plan, Error> {
    Ok(Plan {
        cases: cases(args)?,
        rows: rows(args),
        sweep: args.sweep.map(Sweep::from),
        options: Options { random: args.rng.into(), ..Options::paper() },
        repeat: args.repeat.unwrap_or(if args.quick { 1 } else { 3 }),
    })
}

fn rows(args: &LadderArgs) -> Vec<&'static Row> {
    if !args.rows.is_empty() {
        return args.rows.clone();
    }
    let is_wanted = |row: &&Row| args.sweep.is_none() || row.is_stage || row.is_always_exact();
    ROWS.iter().filter(is_wanted).collect()
}

/// The cases of all scenes, in order.
fn cases(args: &LadderArgs) -> Result<Vec<Case>, Error> {
    let mut names = args.scene.clone();
    if names.is_empty() {
        let wanted = if args.quick { &SCENES[..1] } else { &SCENES[..] };
        names = wanted.iter().map(Into::into).collect();
    }
    let mut all = Vec::new();
    for name in names {
        let opened = open(&name, &ParticleArgs::default(), [None; 2], u64::MAX)?;
        let settings = measured(&opened.scene.settings, args.quick, &args.settings)?;
        if settings.filter != Filter::Box {
            let problem = format!("--filter: the ladder's rows have the box alone, not {}", settings.filter);
            return Err(Error::BadInput(problem));
        }
        if settings.radius_schedule != RadiusSchedule::PerPixel {
            let problem = "--radius-schedule: the ladder's rows have radii per pixel alone, not global";
            return Err(Error::BadInput(problem.into()));
        }
        if settings.radius_pilots > 0 {
            let problem = "--radius-pilots: the ladder's rows begin with one radius; it must be 0";
            return Err(Error::BadInput(problem.into()));
        }
        if settings.radius_clearance > 0.0 {
            let problem = "--radius-clearance: the ladder's rows begin with one radius; it must be 0";
            return Err(Error::BadInput(problem.into()));
        }
        if settings.light_samples > 1 {
            let problem =
                "--light-samples: the ladder's rows send one shadow ray from each point; it must be 1";
            return Err(Error::BadInput(problem.into()));
        }
        if settings.glint_samples > 1 {
            let problem = "--glint-samples: the ladder's rows send one ray through each pixel; it must be 1";
            return Err(Error::BadInput(problem.into()));
        }
        let (name, scene) = (opened.stem.to_string_lossy().into_owned(), opened.scene);
        match args.sweep.map(Sweep::from) {
            Some(sweep) => all.extend(sweep.cases(&name, &scene, settings, args.quick).map_err(told)?),
            None => all.push(Case { name, scene, settings, value: 0 }),
        }
    }
    Ok(all)
}

/// Describes an error of the ladder in terms of options.
fn told(error: ladder::Error) -> Error {
    match error {
        ladder::Error::Input { field: Field::Similarity, .. } => {
            Error::BadInput("--similarity: goes with --sweep iterations only".into())
        }
        ladder::Error::Input { field, problem } => Error::BadInput(format!("--{}: {problem}", field.name())),
        ladder::Error::Failed(problem) => Error::Failed(problem),
    }
}

/// Shows a progress bar for each stage of the work.
#[derive(Default)]
struct Stages {
    bar: Option<Bar>,
}

impl report::Progress for Stages {
    fn begin(&mut self, count: u32, noun: &'static str) {
        self.bar = Some(Bar::of(count, noun));
    }

    fn step(&mut self, done: u32, what: &str) {
        if let Some(bar) = &self.bar {
            bar.step(done, what);
        }
    }

    fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::Progress as _;

    /// Each stage has a bar of its own, which is cleared before the next begins.
    #[test]
    fn stages_have_bars_as_long_as_they_last() {
        let mut stages = Stages::default();
        stages.step(1, "nothing");
        for (count, noun) in [(4, "runs"), (2, "images")] {
            stages.begin(count, noun);
            stages.step(1, "row 6");
            let bar = stages.bar.as_ref().expect("a stage has begun");
            assert!(bar.line().contains(&format!(" 1/{count} {noun}  row 6  ")), "{}", bar.line());
            stages.end();
            assert!(stages.bar.is_none());
        }
    }

    #[test]
    fn rows_and_runs_are_as_many_as_are_asked_for() {
        use crate::commands::{Args as All, Command};
        use clap::Parser as _;
        let of = |words: &[&str]| {
            let args = All::try_parse_from(["sppm", "ladder"].iter().chain(words)).unwrap();
            let Command::Ladder(args) = args.command else { panic!("another command") };
            args
        };
        let names = |words: &[&str]| rows(&of(words)).iter().map(|row| row.name).collect::<Vec<_>>();
        assert_eq!(names(&[]).len(), ROWS.len());
        assert_eq!(names(&["--rows", "6,fast"]), ["6", "fast"]);
        let swept = names(&["--sweep", "depth"]);
        assert!(swept.len() < ROWS.len() && swept.contains(&"fast") && swept.contains(&"0"), "{swept:?}");
        assert!(row("none").unwrap_err().starts_with("is no row; there are "));
        assert_eq!(swept, ["0", "1", "2", "3", "4", "5", "6", "fast"]);
        let runs = |words: &[&str]| {
            plan(&of(&[words, &["--scene", "cornell"]].concat())).map(|plan| plan.repeat).unwrap()
        };
        assert_eq!([runs(&[]), runs(&["--quick"]), runs(&["--quick", "--repeat", "5"])], [3, 1, 5]);
        let scenes = |words: &[&str]| cases(&of(words)).map(|cases| cases.len()).unwrap();
        assert_eq!(
            [scenes(&[]), scenes(&["--quick"]), scenes(&["--scene", "mirror", "--scene", "cornell"])],
            [5, 1, 2]
        );
    }

    /// Rows have their own generators unless the reference's are asked for; all else is as in the paper.
    #[test]
    fn random_numbers_are_the_papers_unless_others_are_asked_for() {
        use crate::commands::{Args as All, Command};
        use clap::Parser as _;
        let options = |words: &[&str]| {
            let words = ["sppm", "ladder", "--scene", "cornell"].iter().chain(words);
            let Command::Ladder(args) = All::try_parse_from(words).unwrap().command else {
                panic!("another command")
            };
            plan(&args).map(|plan| plan.options).unwrap()
        };
        assert_eq!(options(&[]), Options::paper());
        assert_eq!(options(&["--rng", "paper"]), Options::paper());
        assert_eq!(options(&["--rng", "keyed"]), Options { random: Random::Keyed, ..Options::paper() });
    }

    /// What is asked for wrongly is bad input, and what goes wrong later is a failure.
    #[test]
    fn errors_are_told_by_their_options() {
        let input = |field| told(ladder::Error::Input { field, problem: "is wrong".into() });
        for (field, text) in [
            (Field::Csv, "--csv: is wrong"),
            (Field::Plots, "--plots: is wrong"),
            (Field::Images, "--images: is wrong"),
            (Field::Sweep, "--sweep: is wrong"),
            (Field::SweepSpheres, "--sweep spheres: is wrong"),
            (Field::Similarity, "--similarity: goes with --sweep iterations only"),
        ] {
            let error = input(field);
            assert_eq!((error.to_string(), error.code()), (text.into(), 2));
        }
        let failed = told(ladder::Error::Failed("a.csv: no room".into()));
        assert_eq!((failed.to_string(), failed.code()), ("a.csv: no room".into(), 1));
    }

    /// As far as the help says; a quick one less far.
    #[test]
    fn a_sweep_has_all_its_values() {
        use crate::commands::{Args as All, Command};
        use clap::Parser as _;
        let values = |words: &[&str]| -> Vec<u64> {
            let words = ["sppm", "ladder", "--scene", "random", "--sweep"].iter().chain(words);
            let Command::Ladder(args) = All::try_parse_from(words).unwrap().command else {
                panic!("another command")
            };
            cases(&args).unwrap().iter().map(|case| case.value).collect()
        };
        for (what, first, last) in [
            ("iterations", 2, 64),
            ("photons", 12_500, 800_000),
            ("size", 32 * 24, 1024 * 768),
            ("depth", 1, 10),
        ] {
            let (all, quick) = (values(&[what]), values(&[what, "--quick"]));
            assert_eq!((all.first(), all.last()), (Some(&first), Some(&last)), "{what}");
            assert!(quick.len() < all.len() && quick.last() < all.last(), "{what}: {quick:?}");
        }
    }

    /// What the rows do not have is refused by its option.
    #[test]
    fn settings_that_rows_do_not_have_are_refused() {
        use crate::commands::{Args as All, Command};
        use clap::Parser as _;
        for (words, option) in [
            (["--filter", "gaussian"], "--filter"),
            (["--radius-schedule", "global"], "--radius-schedule"),
            (["--radius-pilots", "1"], "--radius-pilots"),
            (["--radius-clearance", "1"], "--radius-clearance"),
            (["--light-samples", "2"], "--light-samples"),
            (["--glint-samples", "2"], "--glint-samples"),
        ] {
            let args = All::try_parse_from(["sppm", "ladder", "--quick"].iter().chain(&words)).unwrap();
            let Command::Ladder(args) = args.command else { panic!("another command") };
            let problem = cases(&args).err().unwrap().to_string();
            assert!(problem.starts_with(&format!("{option}: the ladder's rows ")), "{problem}");
        }
    }
}
