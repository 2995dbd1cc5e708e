//! What is said at the end of a render: what it wrote, why it ended, how to go on, and what to do about noise.

use super::instants;
use crate::terminal::error::Error;
use crate::terminal::signals::Requests;
use crate::terminal::text::quoted;
use render::{End, Job, MethodName, Outcome, Report};
use scene::Stats;
use scene::settings::MAX_ITERATIONS;
use scene::text::{counted, duration, list, mebibytes};
use std::time::Duration;
use tracing::{debug, info, warn};

/// Reports what the render wrote and why it ended.
pub(crate) fn conclude(outcome: &Outcome, requests: &Requests) -> Result<(), Error> {
    let Outcome { end, report, unsaved, written, failed, saved, .. } = outcome;
    let signal = requests.pending().filter(|_| *end == End::Stopped);
    let done = report.iterations;
    if let (Some(signal), 0) = (signal, done) {
        let what = "not one iteration was over, so nothing is written";
        return Err(Error::Interrupted(signal, what.into()));
    }
    // A part of a render has no image: its checkpoint is what it is for.
    let part = saved.as_ref().filter(|_| outcome.job.range.is_some()).map(|saved| &saved.path);
    let written = list(&part.into_iter().chain(written).map(|path| path.display()).collect::<Vec<_>>());
    if !failed.is_empty() {
        return Err(lament(outcome, &written));
    }
    account(report, outcome.writing);
    let (iterations, seconds) = (counted(done, "iteration"), duration(report.wall_seconds));
    if let Some(signal) = signal {
        let all = match outcome.job.wanted().len() as u32 {
            MAX_ITERATIONS => iterations,
            all => format!("{done} of {}", counted(all, "iteration")),
        };
        let unsaved = unsaved.as_ref().map_or(String::new(), |error| format!("; {error}"));
        let next = how_to_go_on(outcome).unwrap_or_default();
        let text = format!("wrote {written} after {all} in {seconds}{unsaved}{next}");
        return Err(Error::Interrupted(signal, text));
    }
    if let Some(error) = unsaved {
        let what = if has_image(&outcome.job) {
            "the image is written, but not its checkpoint"
        } else {
            "the part is not written"
        };
        let kept = match saved {
            Some(saved) if saved.iterations == done => format!("; it is in {} instead", saved.path.display()),
            _ => how_to_go_on(outcome).unwrap_or_default(),
        };
        return Err(Error::Failed(format!("{what}: {error}{kept}")));
    }
    let lacking = report.lacks_photons().then_some(outcome.job.engine.method());
    let why = why(*end, report.estimated_error, lacking);
    info!(
        iterations = done,
        wall_seconds = report.wall_seconds,
        ended_by = report.ended_by,
        "wrote {written}: {iterations} in {seconds}{why}{}{}",
        hint(outcome),
        instants::hint(&outcome.job.scene, done),
    );
    if report.lacks_photons() {
        warn!("{}", few_photons(outcome.job.engine.method(), &report.stats));
    }
    Ok(())
}

/// Whether a render has an image, or else is a part, which is its checkpoint alone.
fn has_image(job: &Job) -> bool {
    job.range.is_none() || job.outputs.image.is_some() || job.outputs.stream.is_some()
}

/// Why a render ended, unless all its iterations are done.
///
/// If its photons hardly counted, `lacking` is its method.
fn why(end: End, error: Option<f64>, lacking: Option<MethodName>) -> String {
    match (end, error) {
        (End::Time, _) => "; time is up".into(),
        (End::Error, Some(error)) => {
            let of = match lacking {
                Some(MethodName::Hybrid) => ", without caustics",
                Some(_) => ", of direct light alone",
                None => "",
            };
            format!("; the estimated error is {error:.3e}{of}")
        }
        _ => String::new(),
    }
}

/// The warning that light which comes over other surfaces is missing, and what helps.
fn few_photons(method: MethodName, stats: &Stats) -> String {
    let Stats { photons, contributions, .. } = *stats;
    let counted = match contributions {
        0 => "none".into(),
        n => n.to_string(),
    };
    if method == MethodName::Hybrid {
        return format!(
            "of {photons} photons {counted} counted at what is seen: caustics are nearly missing, unless there are hardly any; \
             a larger --radius helps a little"
        );
    }
    format!(
        "of {photons} photons {counted} counted at what is seen: light that comes over other surfaces or through glass is \
         nearly missing; --method path finds it where lamps are large or the sky is bright, a larger --radius helps a little"
    )
}

/// What to do about an image with visible noise.
fn hint(outcome: &Outcome) -> String {
    let is_told = is_noise_told(outcome.end, outcome.job.range.is_some());
    if outcome.report.iterations == 1 && is_told {
        // It cannot be compared with an earlier one to tell how noisy it is.
        return "; that is one sample in each pixel: more, as by `-n 16`, give a smoother image".into();
    }
    let Report { wall_seconds: seconds, iterations, resumed_after, .. } = outcome.report;
    let noise = outcome.noise.filter(|_| is_told);
    noise.map_or(String::new(), |noise| hint_of(noise, &Measured { seconds, iterations, resumed_after }))
}

/// Whether it helps to know how noisy an image is: not if its error was asked for, nor of a part, which more time gives no more
/// iterations.
fn is_noise_told(end: End, is_part: bool) -> bool {
    end != End::Error && !is_part
}

/// What a session took for the iterations that it has added.
struct Measured {
    seconds: f64,
    iterations: u32,
    resumed_after: u32,
}

/// The same of an image with this relative error.
fn hint_of(noise: f64, &Measured { seconds, iterations, resumed_after }: &Measured) -> String {
    /// From this relative error on, noise is seen at once.
    const NOISY: f64 = 0.1;
    /// At this one, it is hardly seen.
    const SMOOTH: f64 = 0.05;
    /// The error falls about as this power of the time (docs/lasting.md).
    const RATE: f64 = 0.4;
    if noise <= NOISY {
        return String::new();
    }
    // The time of all iterations, those of earlier sessions included.
    let whole = seconds * f64::from(iterations) / f64::from(iterations.saturating_sub(resumed_after).max(1));
    let seconds = whole * (noise / SMOOTH).powf(1.0 / RATE);
    format!(
        "; it is noisy, with an error of about {noise:.2}: `--time {}` gives a smoother one",
        at_least(seconds)
    )
}

/// The next round time, with its unit as `--time` takes it.
fn at_least(seconds: f64) -> String {
    const TIMES: [(f64, &str); 15] = [
        (1.0, "1s"),
        (2.0, "2s"),
        (5.0, "5s"),
        (10.0, "10s"),
        (20.0, "20s"),
        (30.0, "30s"),
        (60.0, "1m"),
        (120.0, "2m"),
        (300.0, "5m"),
        (600.0, "10m"),
        (1200.0, "20m"),
        (1800.0, "30m"),
        (3600.0, "1h"),
        (7200.0, "2h"),
        (18000.0, "5h"),
    ];
    match TIMES.iter().find(|(time, _)| *time >= seconds) {
        Some((_, text)) => (*text).into(),
        None => format!("{:.0}h", (seconds / 3600.0).ceil()),
    }
}

/// The error for files that could not be written: what was saved instead, and how to resume.
fn lament(outcome: &Outcome, written: &str) -> Error {
    let problems = outcome.failed.iter().map(|unwritten| match &unwritten.refuge {
        Some(refuge) => format!("{}; it is in {} instead", unwritten.error, refuge.display()),
        None => unwritten.error.to_string(),
    });
    let problems = problems.collect::<Vec<_>>().join("; ");
    let rest = if written.is_empty() { String::new() } else { format!("; wrote {written}") };
    let elsewhere =
        how_to_go_on(outcome).map_or(String::new(), |how| format!("{how}, by -o to another image"));
    Error::Failed(format!("{problems}{rest}{elsewhere}"))
}

fn how_to_go_on(outcome: &Outcome) -> Option<String> {
    let saved = outcome.saved.as_ref()?;
    let done = counted(saved.iterations, "iteration");
    let checkpoint = quoted(&saved.path.to_string_lossy());
    Some(format!("; `sppm resume {checkpoint}` goes on after {done}"))
}

/// Logs the time of each pass and the memory used.
fn account(report: &Report, writing: Duration) {
    let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, bytes, .. } =
        report.stats;
    let passes = [
        ("camera pass", camera_seconds),
        ("grid", build_grid_seconds),
        ("photon pass", photon_seconds),
        ("consolidation", consolidate_seconds),
        ("developing and writing", writing.as_secs_f64()),
    ];
    let times: Vec<String> =
        passes.iter().map(|(name, seconds)| format!("{name} {}", duration(*seconds))).collect();
    debug!(bytes, peak_bytes = report.peak_bytes, "{}; {}", times.join(", "), mebibytes(bytes));
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::atomic_file::FileError;
    use render::{Saved, Unwritten};
    use signal_hook::consts::{SIGINT, SIGTERM};
    use std::io::{self, Seek as _};
    use std::path::Path;
    use std::sync::Arc;

    /// What became of a render of one iteration, which wrote no file.
    fn outcome() -> Outcome {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let quick = scene::Settings {
            width: 8,
            height: 6,
            iterations: 1,
            photons_per_iteration: 100,
            ..scene.settings
        };
        scene.settings = quick;
        Job::new(scene).start(()).unwrap().wait().unwrap()
    }

    #[test]
    fn photons_that_did_not_count_are_told() {
        let few = |method, contributions| {
            few_photons(method, &Stats { photons: 40_000, contributions, ..Stats::default() })
        };
        let said = |contributions| few(MethodName::Sppm, contributions);
        let of_caustics = few(MethodName::Hybrid, 3);
        assert!(
            of_caustics.starts_with("of 40000 photons 3 counted at what is seen: caustics are"),
            "{of_caustics}"
        );
        assert!(said(0).starts_with("of 40000 photons none counted at what is seen: "), "{}", said(0));
        assert!(said(17).starts_with("of 40000 photons 17 counted at what is seen: "), "{}", said(17));
    }

    /// From 0.1 to 0.05 it takes the square root of two, to the power of five: 5.66 times as long.
    #[test]
    fn the_time_for_a_smooth_image_is_that_of_all_iterations() {
        let noisy = |noise, seconds, iterations, resumed_after| {
            hint_of(noise, &Measured { seconds, iterations, resumed_after })
        };
        assert_eq!(noisy(0.1, 10.0, 8, 0), "");
        let told = "; it is noisy, with an error of about 0.20: `--time 10m` gives a smoother one";
        assert_eq!(noisy(0.2, 10.0, 8, 0), told); // 320 seconds
        assert_eq!(noisy(0.2, 5.0, 8, 4), told);
        assert!(noisy(0.2, 10.0, 8, 4).contains("`--time 20m`")); // 640 seconds
        // 32 times as long as all has taken, not so much longer: a render begins anew.
        assert!(noisy(0.2, 9.37, 8, 0).contains("`--time 5m`")); // 299.84 seconds
        assert!(noisy(0.2, 9.38, 8, 0).contains("`--time 10m`")); // 300.16 seconds
    }

    #[test]
    fn noise_is_told_of_whole_renders_whose_error_was_not_asked_for() {
        for end in [End::Iterations, End::Time, End::Stopped] {
            assert!(is_noise_told(end, false) && !is_noise_told(end, true), "{end:?}");
        }
        assert!(!is_noise_told(End::Error, false) && !is_noise_told(End::Error, true));
    }

    /// Nothing is lost without a word: whoever asked for a checkpoint learns that there is none.
    #[test]
    fn a_checkpoint_that_was_not_written_is_an_error() {
        let mut outcome = outcome();
        outcome.written = vec!["a.png".into()];
        assert!(conclude(&outcome, &Requests::deaf()).is_ok());
        outcome.unsaved = Some(FileError::new(Path::new("a.png.sppm"), "the disk is full"));
        let error = conclude(&outcome, &Requests::deaf()).unwrap_err();
        let told = "the image is written, but not its checkpoint: a.png.sppm: the disk is full";
        assert_eq!((error.to_string(), error.code()), (told.into(), 1));
    }

    /// A part has no image that is written in any case, unless one is asked for.
    #[test]
    fn a_part_that_was_not_written_is_told_as_such() {
        let mut outcome = outcome();
        outcome.job.range = Some(0..1);
        outcome.unsaved = Some(FileError::new(Path::new("p.sppm"), "the disk is full"));
        let told = |outcome: &Outcome| conclude(outcome, &Requests::deaf()).unwrap_err().to_string();
        assert_eq!(told(&outcome), "the part is not written: p.sppm: the disk is full");
        outcome.saved = Some(Saved { path: "p.sppm".into(), iterations: 0 });
        let text = told(&outcome);
        assert!(
            text.ends_with("the disk is full; `sppm resume p.sppm` goes on after 0 iterations"),
            "{text}"
        );
        // All of it may be elsewhere.
        let done = outcome.report.iterations;
        outcome.saved = Some(Saved { path: "elsewhere/p.sppm".into(), iterations: done });
        let text = told(&outcome);
        assert!(text.ends_with("the disk is full; it is in elsewhere/p.sppm instead"), "{text}");
        outcome.job.outputs.image = Some("p.png".into());
        let text = told(&outcome);
        let first = "the image is written, but not its checkpoint: p.sppm: the disk is full; it is in ";
        assert!(text.starts_with(first), "{text}");
    }

    /// Whoever waits for the files learns that one of them is missing.
    #[test]
    fn an_interruption_hides_no_file_that_was_not_written() {
        let mut outcome = outcome();
        let error = FileError::new(Path::new("a.png"), "no room");
        (outcome.end, outcome.failed) = (End::Stopped, vec![Unwritten { error, refuge: None }]);
        let error = conclude(&outcome, &Requests::after(SIGINT)).unwrap_err();
        assert_eq!((error.code(), error.to_string()), (1, "a.png: no room".into()));
    }

    /// The file of a part is its checkpoint.
    #[test]
    fn a_part_is_among_the_files_that_were_written() {
        let mut outcome = outcome();
        outcome.job.range = Some(0..1);
        outcome.saved = Some(Saved { path: "p.sppm".into(), iterations: 1 });
        let error = FileError::new(Path::new("s.json"), "no room");
        outcome.failed = vec![Unwritten { error, refuge: None }];
        let text = conclude(&outcome, &Requests::deaf()).unwrap_err().to_string();
        assert!(text.starts_with("s.json: no room; wrote p.sppm; "), "{text}");
    }

    /// One that comes when the render has ended by itself is too late: all is done that was asked for.
    #[test]
    fn a_signal_ends_a_render_only_if_it_has_stopped_it() {
        let (mut outcome, late) = (outcome(), Requests::after(SIGTERM));
        for end in [End::Iterations, End::Time, End::Error] {
            outcome.end = end;
            assert!(conclude(&outcome, &late).is_ok(), "{end:?}");
        }
        outcome.end = End::Stopped;
        assert_eq!(conclude(&outcome, &late).unwrap_err().code(), 143);
    }

    /// Of how many iterations, unless there was to be no end; and that there is no checkpoint to go on from.
    #[test]
    fn an_interruption_tells_what_is_done_and_what_is_lost() {
        let mut outcome = outcome();
        (outcome.end, outcome.written) = (End::Stopped, vec!["a.png".into()]);
        let told = |outcome: &Outcome| conclude(outcome, &Requests::after(SIGINT)).unwrap_err().to_string();
        outcome.job.scene.settings.iterations = 9;
        let text = told(&outcome);
        assert!(text.starts_with("wrote a.png after 1 of 9 iterations in "), "{text}");
        outcome.job.scene.settings.iterations = MAX_ITERATIONS;
        let text = told(&outcome);
        assert!(text.starts_with("wrote a.png after 1 iteration in ") && !text.contains("; "), "{text}");
        outcome.unsaved = Some(FileError::new(Path::new("a.png.sppm"), "the disk is full"));
        let text = told(&outcome);
        assert!(text.ends_with("; a.png.sppm: the disk is full"), "{text}");
    }

    /// Each with where it is instead, if it is anywhere.
    #[test]
    fn all_files_that_could_not_be_written_are_told() {
        let mut outcome = outcome();
        let unwritten = |path: &str, refuge: Option<&str>| Unwritten {
            error: FileError::new(Path::new(path), "no room"),
            refuge: refuge.map(Into::into),
        };
        outcome.failed = vec![unwritten("a.exr", Some("elsewhere/a.exr")), unwritten("s.json", None)];
        outcome.written = vec!["r.exr".into()];
        outcome.saved = Some(Saved { path: "a.sppm".into(), iterations: 1 });
        let error = conclude(&outcome, &Requests::deaf()).unwrap_err();
        let told = "a.exr: no room; it is in elsewhere/a.exr instead; s.json: no room; wrote r.exr; `sppm resume a.sppm` goes on \
                    after 1 iteration, by -o to another image";
        assert_eq!((error.to_string(), error.code()), (told.into(), 1));
        // A shell can read what is told to do.
        outcome.saved = Some(Saved { path: "my image.sppm".into(), iterations: 1 });
        let error = conclude(&outcome, &Requests::deaf()).unwrap_err().to_string();
        assert!(error.contains("`sppm resume 'my image.sppm'` goes on"), "{error}");
    }

    #[test]
    fn each_pass_is_told_with_its_own_time() {
        let mut outcome = outcome();
        outcome.report.stats = Stats {
            camera_seconds: 1.0,
            build_grid_seconds: 2.0,
            photon_seconds: 3.0,
            consolidate_seconds: 4.0,
            bytes: 2048,
            ..outcome.report.stats
        };
        let mut lines = tempfile::tempfile().unwrap();
        let subscriber = tracing_subscriber::fmt()
            .with_ansi(false)
            .with_max_level(tracing::Level::DEBUG)
            .with_writer(Arc::new(lines.try_clone().unwrap()))
            .finish();
        let told = || account(&outcome.report, Duration::from_secs(5));
        tracing::subscriber::with_default(subscriber, told);
        lines.rewind().unwrap();
        let told = io::read_to_string(lines).unwrap();
        let [camera, grid, photons, consolidation, writing] = [1.0, 2.0, 3.0, 4.0, 5.0].map(duration);
        let expected = format!(
            "camera pass {camera}, grid {grid}, photon pass {photons}, consolidation {consolidation}, developing and writing \
             {writing}; 2.0 KiB"
        );
        assert!(told.contains(&expected), "{told}");
    }

    #[test]
    fn round_times_are_no_shorter() {
        for (seconds, text) in [(0.1, "1s"), (13.4, "20s"), (20.0, "20s"), (61.0, "2m"), (1e5, "28h")] {
            assert_eq!(at_least(seconds), text);
        }
    }

    /// The least of the round times that is long enough, and of whole hours beyond.
    #[test]
    fn round_times_are_told_as_the_option_takes_them() {
        for (seconds, text) in [
            (1.0, "1s"),
            (1.01, "2s"),
            (45.0, "1m"),
            (60.0, "1m"),
            (3600.0, "1h"),
            (18000.0, "5h"),
            (18001.0, "6h"),
        ] {
            assert_eq!(at_least(seconds), text);
            assert!(crate::args::values::time(text).unwrap().as_secs_f64() >= seconds);
        }
    }

    #[test]
    fn a_round_time_is_told_as_itself() {
        for seconds in [1_u32, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 18_000, 36_000] {
            let told = at_least(f64::from(seconds));
            let time = crate::args::values::time(&told).unwrap();
            assert_eq!(time, Duration::from_secs(seconds.into()), "{told}");
        }
    }

    #[test]
    fn it_is_told_why_a_render_ended() {
        assert_eq!(why(End::Time, Some(0.5), Some(MethodName::Sppm)), "; time is up");
        assert_eq!(why(End::Error, Some(0.0123), None), "; the estimated error is 1.230e-2");
        assert_eq!(
            why(End::Error, Some(0.5), Some(MethodName::Sppm)),
            "; the estimated error is 5.000e-1, of direct light alone"
        );
        let of_caustics = why(End::Error, Some(0.5), Some(MethodName::Hybrid));
        assert_eq!(of_caustics, "; the estimated error is 5.000e-1, without caustics");
        assert_eq!(
            [
                why(End::Iterations, Some(0.5), Some(MethodName::Sppm)),
                why(End::Stopped, None, Some(MethodName::Path))
            ],
            ["", ""]
        );
    }
}
