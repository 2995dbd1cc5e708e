//! The command `tune`: searches for the free parameters with which the fast engine renders a scene fastest.

use crate::args::engine::MachineArgs;
use crate::args::files::check_distinct;
use crate::args::quick::measured;
use crate::args::scene::SceneArg;
use crate::args::settings::SettingsArgs;
use crate::args::values::{time, whole};
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use crate::terminal::signals::Requests;
use crate::terminal::text::print;
use clap::{Args, ValueHint};
use files::atomic_file;
use files::named::Opened;
use render::{EngineChoice, EngineName, LanesName, pool};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tuner::{Budget, Request};

/// Search for the free parameters by which the fast engine renders a scene soonest
///
/// Sizes of cells, tables, batches and jobs, how balls are searched, and the lanes: the image does not depend on them,
/// only the time does. Bayesian optimisation proposes values (a Gaussian process with a Matern kernel and white noise,
/// an acquisition hedged among lower confidence bound, expected improvement and probability of improvement), and each
/// proposal is measured in turns with the defaults, on this machine. At the end the best is measured anew. If it
/// gains, the profile holds it, else the defaults; `sppm render SCENE --profile FILE` goes by it.
///
/// The optimiser is scikit-optimize, in Python. In a checkout it is installed by itself, once; elsewhere it must be
/// there (pip install scikit-optimize). Close other programs: what is measured is time.
///
/// Ctrl-C ends the search and keeps the best so far; the profile says that it was not measured anew.
#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct TuneArgs {
    #[command(flatten)]
    scene: SceneArg,

    /// The profile to write [default: the scene's name, .profile.toml]
    #[arg(short, long, value_name = "PROFILE.toml", help_heading = "Output")]
    output: Option<PathBuf>,

    /// Draw how the search went
    #[arg(long, value_name = "FILE.svg", help_heading = "Output")]
    plot: Option<PathBuf>,

    /// Write all that was tried, with its ratio, as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv", help_heading = "Output")]
    csv: Option<PathBuf>,

    /// Points to try, the defaults among them [default: 40; with --quick, 12]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(2, 10_000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    evaluations: Option<u32>,

    /// End the search after so much time, such as 90s or 10m
    #[arg(long, value_name = "T", value_parser = time, allow_hyphen_values = true, help_heading = "Search")]
    time: Option<Duration>,

    /// Pairs of renders, by the defaults and by the point, whose median ratio counts [default: 3; with --quick, 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 1000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    pairs: Option<u32>,

    /// Pairs by which the best is measured anew [default: 25; with --quick, 7]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(6, 1000), allow_hyphen_values = true)]
    #[arg(help_heading = "Search")]
    final_pairs: Option<u32>,

    /// Seed of the search
    #[arg(long, value_name = "S", value_parser = whole::<u32>(0, u32::MAX.into()), default_value = "1")]
    #[arg(allow_hyphen_values = true, help_heading = "Search")]
    search_seed: u32,

    /// Small images and few photons: to see that it works, not for what is best
    #[arg(long, help_heading = "Search")]
    quick: bool,

    /// Tune on these lanes alone [default: all but emulated ones are tried]
    #[arg(long, value_enum, value_name = "LANES", help_heading = "Machine")]
    lanes: Option<LanesName>,

    /// The Python that has scikit-optimize [default: the checkout's own, else python3]
    #[arg(long, value_name = "PYTHON", value_hint = ValueHint::ExecutablePath, help_heading = "Machine")]
    python: Option<PathBuf>,

    #[command(flatten)]
    machine: MachineArgs,

    #[command(flatten)]
    settings: SettingsArgs,
}

const EXAMPLES: &str = "\
Examples:
  sppm tune cornell && sppm render cornell --profile cornell.profile.toml
  sppm tune random --threads 1 --evaluations 100 --plot search.svg --csv tried.csv
  sppm verify cornell --width 64 --height 48 --profile cornell.profile.toml";

/// Runs the search and writes its results. All options are checked before the search begins.
pub(crate) fn run(args: &TuneArgs) -> Result<(), Error> {
    let opened = args.scene.open([None; 2])?;
    let settings = measured(&opened.scene.settings, args.quick, &args.settings)?;
    let asked = args.lanes.map(|lanes| EngineChoice::new(EngineName::Fast, Some(lanes))).transpose()?;
    let profile = profile_path(args, &opened);
    check_files(args, &opened, &profile)?;
    let request = Request {
        name: &opened.stem.to_string_lossy(),
        scene: &opened.scene,
        settings: &settings,
        pool: &pool(args.machine.threads)?,
        lanes: asked.map(EngineChoice::lane_kind),
        budget: budget(args),
        seed: args.search_seed,
        python: args.python.as_deref(),
    };
    search(args, &request, &profile)
}

fn search(args: &TuneArgs, request: &Request, profile: &Path) -> Result<(), Error> {
    let requests = Requests::listen()?;
    let interrupted = |what: &str| {
        let ended = |signal| Error::Interrupted(signal, what.to_owned());
        requests.pending().map_or(Ok(()), |signal| Err(ended(signal)))
    };
    let bar = Bar::of(request.budget.evaluations, "points");
    let account = request.run(requests.stop(), &mut |done, what| bar.step(done, what)).map_err(told)?;
    bar.clear();
    let Some(account) = account else {
        return interrupted("nothing has been tried, and nothing is written");
    };
    account.write_profile(profile).map_err(told)?;
    if let Some(path) = &args.csv {
        account.write_csv(path).map_err(told)?;
    }
    if let Some(path) = &args.plot {
        account.write_plot(path).map_err(told)?;
    }
    let profile = profile.display();
    print(format!("{}wrote {profile}\n", account.text()).as_bytes())?;
    interrupted(&format!("{profile} holds the best so far; it has not been measured anew"))
}

/// Describes an error of the tuner in terms of options.
fn told(error: tuner::Error) -> Error {
    Error::Failed(match error {
        tuner::Error::Optimiser { .. } => format!("--python: {error}"),
        tuner::Error::NoLibrary { .. } => format!(
            "{error}: install it (pip install scikit-optimize), name a Python that has it by --python, or run the \
             sppm of a checkout, which installs it"
        ),
        tuner::Error::Failed(problem) => problem,
    })
}

fn profile_path(args: &TuneArgs, opened: &Opened) -> PathBuf {
    let usual = || {
        let mut name = opened.stem.clone();
        name.push(".profile.toml");
        name.into()
    };
    args.output.clone().unwrap_or_else(usual)
}

/// Checks that every output can be written, and is neither the scene file nor another output.
fn check_files(args: &TuneArgs, opened: &Opened, profile: &Path) -> Result<(), Error> {
    let mut outputs = vec![("--output", profile)];
    outputs.extend(args.csv.as_deref().map(|path| ("--csv", path)));
    outputs.extend(args.plot.as_deref().map(|path| ("--plot", path)));
    let scene: Vec<_> = opened.file.as_deref().map(|path| ("the scene", path)).into_iter().collect();
    check_distinct(&scene, &outputs)?;
    for (option, path) in outputs {
        atomic_file::check(path).map_err(|error| Error::BadInput(format!("{option}: {error}")))?;
    }
    let is_svg = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "svg");
    match args.plot.as_ref().filter(|path| !is_svg(path)) {
        Some(path) => Err(Error::BadInput(format!("--plot: {} must end in .svg", path.display()))),
        None => Ok(()),
    }
}

fn budget(args: &TuneArgs) -> Budget {
    let usual = |full, quick| if args.quick { quick } else { full };
    Budget {
        evaluations: args.evaluations.unwrap_or(usual(40, 12)),
        pairs: args.pairs.unwrap_or(usual(3, 1)),
        final_pairs: args.final_pairs.unwrap_or(usual(25, 7)),
        time: args.time,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(words: &[&str]) -> TuneArgs {
        use crate::commands::{Args, Command};
        use clap::Parser as _;
        let args = Args::try_parse_from(["sppm", "tune", "cornell"].iter().chain(words)).unwrap();
        let Command::Tune(args) = args.command else { panic!("another command") };
        args
    }

    #[test]
    fn a_quick_search_is_smaller_and_what_is_given_counts() {
        let of = |words: &[&str]| {
            let Budget { evaluations, pairs, final_pairs, time } = budget(&args(words));
            (evaluations, pairs, final_pairs, time.map(|time| time.as_secs()))
        };
        assert_eq!(of(&[]), (40, 3, 25, None));
        assert_eq!(of(&["--quick"]), (12, 1, 7, None));
        assert_eq!(of(&["--pairs", "2"]), (40, 2, 25, None));
        assert_eq!(of(&["--final-pairs", "9"]), (40, 3, 9, None));
        let given = ["--evaluations", "5", "--pairs", "2", "--final-pairs", "9", "--time", "3s"];
        assert_eq!(of(&given), (5, 2, 9, Some(3)));
        assert_eq!(of(&[&given[..], &["--quick"]].concat()), (5, 2, 9, Some(3)));
    }

    /// Here, and not beside the scene; a dot in its name is part of the name.
    #[test]
    fn a_profile_is_called_after_its_scene() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("box-1.5.toml");
        std::fs::write(&path, files::builtin::find("cornell").unwrap().text).unwrap();
        let opened = files::named::open(path.as_os_str(), [None; 2], u64::MAX).unwrap();
        assert_eq!(profile_path(&args(&[]), &opened), Path::new("box-1.5.profile.toml"));
        assert_eq!(profile_path(&args(&["-o", "mine.toml"]), &opened), Path::new("mine.toml"));
    }

    #[test]
    fn errors_of_the_optimiser_say_what_helps() {
        let failed = told(tuner::Error::Failed("no".into()));
        assert_eq!((failed.to_string(), failed.code()), ("no".into(), 1));
        let (python, problem) = (PathBuf::from("py"), String::from("No module named skopt"));
        let lacks = told(tuner::Error::NoLibrary { python: python.clone(), problem: problem.clone() });
        let told_of = "py has no scikit-optimize (No module named skopt): install it (pip install scikit-optimize), name a Python \
                       that has it by --python, or run the sppm of a checkout, which installs it";
        assert_eq!((lacks.to_string(), lacks.code()), (told_of.into(), 1));
        let broken = told(tuner::Error::Optimiser { python, problem });
        assert_eq!((broken.to_string(), broken.code()), ("--python: py: No module named skopt".into(), 1));
    }
}
