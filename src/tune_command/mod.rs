//! The command `tune`: a search for the free parameters by which a scene renders soonest.
//!
//! ```text
//! space      which parameters there are to search, and what a point stands for
//! optimiser  proposes points: a process in Python
//! measure    renders in turns with the defaults
//! search     proposes and measures until the budget is spent, and measures the best anew
//! account    profile, table, plot and lines
//! ```

mod account;
pub(crate) mod args;
mod measure;
mod optimiser;
mod search;
mod space;

use crate::args::files::check_distinct;
use crate::args::quick::quick;
use crate::args::scene::open;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use crate::terminal::signals::Requests;
use crate::terminal::text::print;
use account::{Account, Subject};
use args::TuneArgs;
use files::named::Opened;
use files::{atomic_file, scene_file};
use measure::Bench;
use optimiser::Optimiser;
use render::pool;
use render::{EngineChoice, EngineName};
use scene::Settings;
use search::{Budget, search};
use space::Space;
use std::path::{Path, PathBuf};

/// Searches, and writes what was found. Everything that can be refused is refused before.
pub(crate) fn run(args: &TuneArgs) -> Result<(), Error> {
    let mut opened = open(&args.scene.name)?;
    if args.quick {
        opened.scene.settings = quick(&opened.scene.settings);
    }
    let settings = args.settings.apply(&opened.scene.settings)?;
    let asked = args.lanes.map(|lanes| EngineChoice::new(EngineName::Fast, Some(lanes))).transpose()?;
    let profile = profile_path(args, &opened);
    check_files(args, &opened, &profile)?;
    let pool = pool(args.machine.threads)?;
    let threads = pool.current_num_threads();
    let budget = budget(args);
    let still = opened.scene.at(opened.scene.camera.shutter[0]);
    let space = Space::new(fast::ball_count(&still), threads, asked.map(EngineChoice::lane_kind));

    let requests = Requests::listen()?;
    let interrupted = |what: &str| {
        let ended = |signal| Error::Interrupted(signal, what.to_owned());
        requests.pending().map_or(Ok(()), |signal| Err(ended(signal)))
    };
    let nothing = "nothing has been tried, and nothing is written";
    let progress = Bar::of(budget.evaluations, "points");
    progress.step(0, "starting the optimiser; the first time it is installed");
    let optimiser = Optimiser::start(args.python.as_deref(), &space, budget.initial(), args.search_seed);
    let mut optimiser = optimiser.or_else(|error| interrupted(nothing).and(Err(error)))?;
    let bench = Bench::new(&opened.scene, &settings, pool, space.usual(), requests.stop());
    let found = match &bench {
        Some(bench) => search(bench, &space, &mut optimiser, &budget, &progress)?,
        None => None,
    };
    progress.clear();
    let Some(found) = found else { return interrupted(nothing) };

    let subject = subject(&opened, settings, threads);
    let account = Account {
        subject: &subject,
        space: &space,
        found: &found,
        optimiser: &optimiser.name,
        seed: args.search_seed,
        pairs: budget.pairs,
    };
    account.write_profile(&profile)?;
    if let Some(path) = &args.csv {
        account.write_csv(path)?;
    }
    if let Some(path) = &args.plot {
        account.write_plot(path)?;
    }
    let profile = profile.display();
    print(format!("{}wrote {profile}\n", account.text()).as_bytes())?;
    interrupted(&format!("{profile} holds the best so far; it has not been measured anew"))
}

fn profile_path(args: &TuneArgs, opened: &Opened) -> PathBuf {
    let usual = || {
        let mut name = opened.stem.clone();
        name.push(".profile.toml");
        name.into()
    };
    args.output.clone().unwrap_or_else(usual)
}

/// Every output can be written, and is no other file.
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

fn subject(opened: &Opened, settings: Settings, threads: usize) -> Subject {
    Subject {
        scene: opened.stem.to_string_lossy().into_owned(),
        scene_digest: scene_file::digest(&opened.scene),
        settings,
        threads,
        machine: processor(),
        version: env!("CARGO_PKG_VERSION"),
        date: jiff::Timestamp::now().strftime("%Y-%m-%d").to_string(),
    }
}

/// The processor, as far as the system tells.
fn processor() -> String {
    let about = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or(std::env::consts::ARCH, |(_, model)| model.trim()).to_owned()
}
