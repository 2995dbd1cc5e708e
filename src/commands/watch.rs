//! Runs a render for `render` and `resume`: shows its progress, obeys signals, and reports the outcome.

use super::conclusion::conclude;
use crate::args::messages::MessageArgs;
use crate::args::view::WatchArgs;
use crate::terminal::bar::{Bar, Lines, Progress};
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::line::Work;
use crate::terminal::logs;
use crate::terminal::radii::own_radii;
use crate::terminal::signals::Requests;
use crate::terminal::told::Told;
use files::atomic_file::reason;
use render::{Image, Job, LanesName, MethodName, Notice, Observer, Renderer, Step};
use scene::settings::MAX_ITERATIONS;
use scene::text::{counted, mebibytes, one_line};
use scene::{Automatic, Filter, RadiusSchedule, Resumable, Settings, TRANSPORT};
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tracing::{debug, info, warn};
use view::Relay;

/// Runs `job` to its end and reports what became of it. The `title`, if it has one, is told once it has begun: what is refused
/// has none.
pub(crate) fn run(
    mut job: Job,
    title: Option<String>,
    messages: &MessageArgs,
    (viewers, has_page): (&WatchArgs, bool),
    requests: &Requests,
) -> Result<(), Error> {
    let is_json = messages.progress == Progress::Json;
    if is_json && job.outputs.stream.is_some() {
        let problem = "--progress json: standard output is taken by --output; write the image to a file";
        return Err(Error::BadInput(problem.into()));
    }
    let is_taken = is_json || job.outputs.stream.is_some();
    let (page, relay) = viewers.start(has_page, &job.scene.name, is_taken)?.unzip();
    // The command does not show intermediate images.
    (job.live, job.stop) = (false, requests.stop().clone());
    let problem = Problem::default();
    let watch = Watch {
        title,
        busy: (!is_json).then(|| Busy::with("preparing the render")),
        bar: None,
        has_bar: !is_json && logs::has_bars(),
        limit: job.goals.time,
        told: Told::default(),
        lines: is_json.then(Lines::default),
        problem: problem.clone(),
        requests: requests.clone(),
        relay,
    };
    let outcome = job.start(watch)?.wait()?;
    let concluded = conclude(&outcome, requests);
    // The page had the last image when it was shown; files were written since.
    drop(page);
    concluded?;
    // The image is written, but lines of progress were lost: fail, so that their reader does not miss it.
    match problem.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) => Err(Error::Failed(format!("cannot write to standard output: {}", reason(&error)))),
        None => Ok(()),
    }
}

/// Why lines of progress could not be written.
type Problem = Arc<Mutex<Option<io::Error>>>;

/// The observer of the render; it is called on the render's thread.
struct Watch {
    /// Until the render begins.
    title: Option<String>,
    /// Until the render begins.
    busy: Option<Busy>,
    /// From then on.
    bar: Option<Bar>,
    has_bar: bool,
    /// The time limit of the render.
    limit: Option<Duration>,
    told: Told,
    lines: Option<Lines>,
    problem: Problem,
    requests: Requests,
    /// Shows the render to a page or to another viewer.
    relay: Option<Relay>,
}

impl Observer for Watch {
    fn follows(&self) -> bool {
        self.relay.as_ref().is_some_and(Relay::wants)
            || self.lines.is_some()
            || self.bar.as_ref().is_some_and(|bar| !bar.is_hidden())
    }

    fn after(&mut self, step: &Step, engine: &dyn Resumable) {
        if let Some(relay) = self.relay.as_mut().filter(|relay| relay.wants()) {
            relay.after(step, engine);
        }
        if let Some(bar) = &self.bar {
            bar.show(step);
        }
        if let Some(lines) = &mut self.lines {
            lines.tell(step);
            if let Some(error) = lines.problem.take() {
                *self.problem.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
        }
    }

    fn wants_image(&mut self, is_last: bool) -> bool {
        is_last && self.relay.is_some()
    }

    fn image(&mut self, image: Image) {
        if let Some(relay) = &mut self.relay {
            relay.last(image);
        }
    }

    fn notice(&mut self, notice: &Notice) {
        match notice {
            Notice::Begun { settings, renderer, chosen, wanted, .. } => {
                self.busy = None;
                if let Some(title) = self.title.take() {
                    info!("{title}");
                }
                if let Some(choice) = choice(settings, renderer.method, *chosen) {
                    info!("{choice}");
                }
                tell_beginning(notice);
                self.bar = self.has_bar.then(|| self.new_bar(*wanted));
            }
            Notice::Resumed { path, iterations, of, fallback } => {
                if let Some(fault) = fallback {
                    warn!("{fault}; going on from the older generation");
                }
                if let Some(bar) = &self.bar {
                    bar.go_on_after(*iterations);
                }
                let path = path.display();
                let of = if *of == MAX_ITERATIONS { String::new() } else { format!(" of {of}") };
                info!(iterations, "going on from {path} after {iterations}{of} iterations");
            }
            Notice::OtherTransport { path, transport } => warn!(
                "{} was made by version {transport} of the light transport, and this program computes version {TRANSPORT}: the \
                 image will be another",
                one_line(&path.to_string_lossy())
            ),
            Notice::Saved { iterations } => {
                let after = counted(*iterations, "iteration");
                if self.told.is_mended() {
                    info!(iterations, "saved again, after {after}");
                } else {
                    debug!(iterations, "saved after {after}");
                }
            }
            Notice::NotSaved(error) if self.told.is_new(&error.path, error) => {
                self.told.is_unsaved = true;
                warn!("{error}; rendering goes on");
            }
            Notice::NotRefreshed(error) if self.told.is_new(&error.path, error) => {
                warn!("{error}; rendering goes on");
            }
            // Every snapshot is another file, and all of them fail alike.
            Notice::NoSnapshot(error) if self.told.is_new(Path::new("snapshots"), error) => {
                warn!("{error}; rendering goes on");
            }
            Notice::NotSaved(_) | Notice::NotRefreshed(_) | Notice::NoSnapshot(_) => {}
            Notice::NotLocked(error) => warn!("{error}; let no other render write it"),
        }
    }

    fn stopped_by(&self) -> &'static str {
        self.requests.pending().map_or("stop", |signal| signal.name())
    }
}

impl Watch {
    fn new_bar(&self, iterations: u32) -> Bar {
        Bar::new(work(iterations, self.limit), self.requests.stop().meter().clone())
    }
}

/// The work of so many iterations; of the most there can be, how many it will be is not known.
fn work(iterations: u32, limit: Option<Duration>) -> Work {
    let all = (iterations != MAX_ITERATIONS).then_some(iterations);
    Work { noun: "iterations", all, limit, ..Work::default() }
}

impl Drop for Watch {
    /// Clears the bar when the render is over.
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.clear();
        }
    }
}

/// Which settings were chosen, if any were: by the options that would repeat the choice.
fn choice(settings: &Settings, by: MethodName, chosen: Automatic) -> Option<String> {
    let Automatic {
        quality,
        method,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        radius_pilots,
        radius_clearance,
        glint_samples,
    } = chosen;
    let options = [
        method.then(|| format!("--method {}", by.name())),
        iterations.then(|| format!("-n {}", settings.iterations)),
        photons_per_iteration.then(|| format!("--photons {}", settings.photons_per_iteration)),
        initial_radius.then(|| format!("--radius {}", settings.initial_radius)),
        radius_pilots.then(|| format!("--radius-pilots {}", settings.radius_pilots)),
        radius_clearance.then(|| format!("--radius-clearance {}", settings.radius_clearance)),
        max_depth.then(|| format!("--depth {}", settings.max_depth)),
        glint_samples.then(|| format!("--glint-samples {}", settings.glint_samples)),
    ];
    let options: Vec<String> = options.into_iter().flatten().collect();
    (!options.is_empty()).then(|| format!("chosen for quality {quality}: {}", options.join(" ")))
}

fn tell_beginning(notice: &Notice) {
    if let Notice::Begun { scene, settings, renderer, lanes, threads, bytes_at_most, .. } = notice {
        let machine = machine(*renderer, *lanes, *threads);
        debug!(
            bytes_at_most,
            "{scene}: {}; {machine}; up to {}",
            all_settings(settings),
            mebibytes(*bytes_at_most)
        );
    }
}

/// What the image does not depend on, but for the method.
fn machine(renderer: Renderer, lanes: Option<LanesName>, threads: usize) -> String {
    let lanes = lanes.map_or(String::new(), |lanes| format!(" on {} lanes", lanes.name()));
    let (method, engine) = (renderer.method.name(), renderer.engine.name());
    format!("method {method}, engine {engine}{lanes}, {}", counted(threads as u64, "thread"))
}

fn all_settings(settings: &Settings) -> String {
    let Settings {
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        radius_schedule,
        radius_pilots: _,
        radius_clearance: _,
        light_samples,
        glint_samples,
    } = settings;
    let iterations = match *iterations {
        MAX_ITERATIONS => "iterations without end".into(),
        n => counted(n, "iteration"),
    };
    let filter = match filter {
        Filter::Box => String::new(),
        filter => format!(", filter {filter}"),
    };
    let schedule = match radius_schedule {
        RadiusSchedule::PerPixel => String::new(),
        schedule @ RadiusSchedule::Global => format!(" ({schedule})"),
    };
    let own = own_radii(settings).map_or(String::new(), |own| format!(" ({own})"));
    let samples = match light_samples {
        1 => String::new(),
        n => format!(", {}", counted(*n, "light sample")),
    };
    let glints = match glint_samples {
        1 => String::new(),
        n => format!(", {n} samples of glints"),
    };
    format!(
        "{width} x {height} pixels, {iterations}, {} each, depth {max_depth}, radius \
         {initial_radius}{schedule}{own}{samples}{glints}, seed {seed}{filter}",
        counted(*photons_per_iteration, "photon"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Quality;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use std::io::Seek as _;

    #[test]
    fn as_many_iterations_as_it_takes_are_no_number() {
        assert_eq!(work(8, None).all, Some(8));
        assert_eq!(work(MAX_ITERATIONS - 1, None).all, Some(MAX_ITERATIONS - 1));
        let limit = Some(Duration::from_secs(3));
        assert_eq!((work(MAX_ITERATIONS, limit).all, work(MAX_ITERATIONS, limit).limit), (None, limit));
    }

    #[test]
    fn a_choice_is_told_by_the_options_that_repeat_it() {
        let settings = Settings {
            iterations: 7,
            photons_per_iteration: 1000,
            max_depth: 16,
            initial_radius: 0.5,
            radius_pilots: 3,
            radius_clearance: 0.5,
            glint_samples: 8,
            ..Settings::default()
        };
        let all = "chosen for quality final: --method hybrid -n 7 --photons 1000 --radius 0.5 --radius-pilots 3 --radius-clearance 0.5 \
                   --depth 16 --glint-samples 8";
        let by = MethodName::Hybrid;
        assert_eq!(choice(&settings, by, Automatic::all(Quality::Final)).as_deref(), Some(all));
        let none = Automatic { quality: Quality::Draft, ..Automatic::default() };
        let only = |chosen: Automatic| choice(&settings, by, chosen);
        assert_eq!(only(none), None);
        for (chosen, option) in [
            (Automatic { method: true, ..none }, "--method hybrid"),
            (Automatic { iterations: true, ..none }, "-n 7"),
            (Automatic { photons_per_iteration: true, ..none }, "--photons 1000"),
            (Automatic { initial_radius: true, ..none }, "--radius 0.5"),
            (Automatic { radius_pilots: true, ..none }, "--radius-pilots 3"),
            (Automatic { radius_clearance: true, ..none }, "--radius-clearance 0.5"),
            (Automatic { max_depth: true, ..none }, "--depth 16"),
            (Automatic { glint_samples: true, ..none }, "--glint-samples 8"),
        ] {
            assert_eq!(only(chosen), Some(format!("chosen for quality draft: {option}")));
        }
    }

    #[test]
    fn what_is_not_as_usual_is_told_of_the_settings() {
        let usual = Settings { width: 64, height: 48, ..Settings::default() };
        let Settings { iterations, photons_per_iteration, max_depth, initial_radius, seed, .. } = usual;
        let text = format!(
            "64 x 48 pixels, {iterations} iterations, {photons_per_iteration} photons each, depth {max_depth}, radius \
             {initial_radius}, seed {seed}"
        );
        assert_eq!(all_settings(&usual), text);
        let other = Settings {
            iterations: MAX_ITERATIONS,
            photons_per_iteration: 1,
            max_depth: 3,
            initial_radius: 0.5,
            seed: 9,
            filter: Filter::Gaussian,
            radius_schedule: RadiusSchedule::Global,
            radius_pilots: 1,
            light_samples: 2,
            glint_samples: 3,
            ..usual
        };
        let text = "64 x 48 pixels, iterations without end, 1 photon each, depth 3, radius 0.5 (global) (at most, by pilots \
                    of 1 iteration), 2 light samples, 3 samples of glints, seed 9, filter gaussian";
        assert_eq!(all_settings(&other), text);
        assert_eq!(machine(Renderer::default(), None, 1), "method sppm, engine fast, 1 thread");
        let text = "method sppm, engine fast on avx2 lanes, 8 threads";
        assert_eq!(machine(Renderer::default(), Some(LanesName::Avx2), 8), text);
    }

    fn watch() -> Watch {
        Watch {
            title: None,
            busy: None,
            bar: None,
            has_bar: false,
            limit: None,
            told: Told::default(),
            lines: None,
            problem: Problem::default(),
            requests: Requests::deaf(),
            relay: None,
        }
    }

    fn begun(settings: Settings) -> Notice {
        let (scene, chosen, renderer) = ("a".into(), Automatic::default(), Renderer::default());
        // A third of it is asked for.
        let wanted = settings.iterations / 3;
        Notice::Begun { scene, settings, chosen, wanted, renderer, lanes: None, threads: 1, bytes_at_most: 1 }
    }

    /// Who shows nothing need not be told of every iteration.
    #[test]
    fn a_render_is_followed_by_who_shows_it() {
        let mut watch = watch();
        assert!(!watch.follows() && !watch.wants_image(true) && !watch.wants_image(false));
        // In tests the bar is hidden.
        watch.bar = Some(Bar::of(3, "iterations"));
        assert_eq!(watch.follows(), !watch.bar.as_ref().unwrap().is_hidden());
        watch.lines = Some(Lines::default());
        assert!(watch.follows());
    }

    /// As it stands in the statistics.
    #[test]
    fn a_render_is_stopped_by_the_signal_that_came() {
        let mut watch = watch();
        assert_eq!(watch.stopped_by(), "stop");
        for (signal, name) in [(SIGINT, "SIGINT"), (SIGTERM, "SIGTERM"), (SIGHUP, "SIGHUP")] {
            watch.requests = Requests::after(signal);
            assert_eq!(watch.stopped_by(), name);
        }
    }

    /// What is said of these notices, and of nothing less than `level`.
    fn said(level: logs::Level, notices: &[Notice]) -> Vec<String> {
        let mut lines = tempfile::tempfile().unwrap();
        let format =
            tracing_subscriber::fmt::format().without_time().with_target(false).with_ansi(false).compact();
        let subscriber = tracing_subscriber::fmt()
            .event_format(format)
            .with_max_level(level)
            .with_writer(Arc::new(lines.try_clone().unwrap()))
            .finish();
        let mut watch = watch();
        tracing::subscriber::with_default(subscriber, || notices.iter().for_each(|n| watch.notice(n)));
        lines.rewind().unwrap();
        io::read_to_string(lines).unwrap().lines().map(|line| line.trim().to_owned()).collect()
    }

    /// What fails again and again is told once, until something has changed.
    #[test]
    fn a_failure_is_told_once() {
        let error = |path: &str| files::atomic_file::FileError::new(Path::new(path), "no room");
        let (unsaved, unrefreshed) =
            (Notice::NotSaved(error("a.sppm")), Notice::NotRefreshed(error("a.png")));
        let saved = Notice::Saved { iterations: 3 };
        let twice = [unsaved.clone(), unrefreshed.clone(), unsaved.clone(), unrefreshed.clone()];
        let told = ["WARN a.sppm: no room; rendering goes on", "WARN a.png: no room; rendering goes on"];
        assert_eq!(said(logs::Level::INFO, &twice), told);
        // What could not be refreshed is an image: every checkpoint was saved, and none is saved "again".
        assert_eq!(said(logs::Level::INFO, &[unrefreshed, saved.clone()]), told[1..]);
        // Each snapshot is a file of its own.
        let snapshots = [1, 2].map(|n| Notice::NoSnapshot(error(&format!("a-{n}.png"))));
        assert_eq!(said(logs::Level::INFO, &snapshots), ["WARN a-1.png: no room; rendering goes on"]);
        let mended = [saved.clone(), unsaved.clone(), saved.clone(), saved, unsaved];
        let [first, again, second] = &said(logs::Level::INFO, &mended)[..] else { panic!("{mended:?}") };
        assert_eq!((&first[..], &second[..]), (told[0], told[0]));
        assert!(again.starts_with("INFO saved again, after 3 iterations"), "{again}");
        let all = said(logs::Level::DEBUG, &mended);
        assert_eq!(all.iter().filter(|line| line.starts_with("DEBUG saved after 3 iterations")).count(), 2);
    }

    /// Nothing but the warning keeps two renders from writing one file where the file system has no locks.
    #[test]
    fn a_file_that_is_not_locked_is_told() {
        let error = files::atomic_file::FileError::new(Path::new("a.png"), "cannot be locked");
        let told = ["WARN a.png: cannot be locked; let no other render write it"];
        assert_eq!(said(logs::Level::WARN, &[Notice::NotLocked(error)]), told);
    }

    #[test]
    fn it_is_told_how_a_render_goes_on() {
        let resumed = |of, fallback| {
            said(logs::Level::INFO, &[Notice::Resumed { path: "a.sppm".into(), iterations: 5, of, fallback }])
        };
        let told = |of, text: &str| {
            let lines = resumed(of, None);
            assert!(lines.len() == 1 && lines[0].starts_with(text), "{lines:?}");
        };
        told(9, "INFO going on from a.sppm after 5 of 9 iterations");
        told(MAX_ITERATIONS, "INFO going on from a.sppm after 5 iterations");
        let fault = files::atomic_file::FileError::new(Path::new("a.sppm"), "is damaged");
        let lines = resumed(9, Some(fault));
        assert_eq!(lines[0], "WARN a.sppm: is damaged; going on from the older generation");
        assert!(lines.len() == 2 && lines[1].starts_with("INFO going on from "), "{lines:?}");
    }

    /// One has its bar once the render has begun, if it is to have one.
    #[test]
    fn a_bar_begins_with_the_render() {
        let begun = begun(Settings::default());
        for has_bar in [true, false] {
            let mut watch = watch();
            (watch.has_bar, watch.busy) = (has_bar, Some(Busy::with("preparing")));
            watch.notice(&begun);
            assert_eq!((watch.bar.is_some(), watch.busy.is_none()), (has_bar, true));
        }
    }

    /// It counts from where the render begins, and to the goal that the render has: of a part, to that of the part.
    #[test]
    fn a_bar_shows_how_far_the_render_is() {
        let mut watch = watch();
        (watch.has_bar, watch.limit) = (true, Some(Duration::from_hours(1)));
        watch.notice(&begun(Settings { iterations: 27, ..Settings::default() }));
        let line = |watch: &Watch| watch.bar.as_ref().expect("the render has begun").line();
        assert!(line(&watch).ends_with(" 0/9 iterations  0s elapsed, 1h 0m left"), "{}", line(&watch));
        watch.notice(&Notice::Resumed { path: "a.sppm".into(), iterations: 5, of: 9, fallback: None });
        assert!(line(&watch).contains(" 5/9 iterations  "), "{}", line(&watch));
        let scene = files::builtin::scene("cornell").unwrap();
        let engine = reference::Sppm::new(&scene, &Settings { width: 1, height: 1, ..scene.settings });
        watch.after(&Step { iteration: 6, mean_radius: Some(0.5), ..Step::default() }, &engine);
        assert!(
            line(&watch).contains(" 6/9 iterations  0.00 photons/s  mean radius 0.5000  "),
            "{}",
            line(&watch)
        );
    }
}
