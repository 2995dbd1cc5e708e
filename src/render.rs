//! The command `render`.

use crate::args::RenderArgs;
use crate::engines::EngineName;
use crate::error::Error;
use crate::outputs::Outputs;
use crate::progress::Progress;
use crate::report::Report;
use crate::session::{self, Outcome};
use crate::text::{complain, counted, duration};
use crate::{scenes, threads};
use scene::{Settings, Stats};

/// Renders a scene and writes the files that were asked for. Everything that can be refused is refused before.
pub(crate) fn render(args: &RenderArgs) -> Result<(), Error> {
    let opened = scenes::open(&args.scene)?;
    let settings = args.settings.apply(&opened)?;
    let outputs = Outputs::new(args, &opened)?;
    let threads = threads::start(args.machine.threads)?;
    let name = opened.scene.name.clone();
    if args.verbose {
        complain(&introduction(&name, args.engine.name(), threads, &settings));
    }
    let progress = Progress::new(settings.iterations, args.quiet);
    let outcome = session::run(args.engine, opened.scene, settings, |snapshot| {
        progress.show(snapshot);
    });
    progress.clear();
    let outcome = outcome?;
    let report = report(name, args.engine, threads, settings, &outcome);
    let written = outputs.write(&outcome.last, &report)?;
    if args.verbose {
        complain(&account(&report));
    }
    let (done, seconds) = (report.iterations, duration(report.wall_seconds));
    if let Some(signal) = outcome.interrupted {
        let all = counted(settings.iterations, "iteration");
        return Err(Error::Interrupted(
            signal,
            format!("wrote {written} after {done} of {all} in {seconds}"),
        ));
    }
    if !args.quiet {
        complain(&format!("wrote {written}: {} in {seconds}", counted(done, "iteration")));
    }
    Ok(())
}

fn report(
    scene: String,
    engine: EngineName,
    threads: usize,
    settings: Settings,
    outcome: &Outcome,
) -> Report {
    let last = &outcome.last;
    Report {
        version: env!("CARGO_PKG_VERSION"),
        scene,
        engine,
        threads,
        settings,
        iterations: last.iterations,
        interrupted: outcome.interrupted.is_some(),
        wall_seconds: outcome.elapsed.as_secs_f64(),
        develop_seconds: last.develop.as_secs_f64(),
        stats: last.stats,
    }
}

fn introduction(scene: &str, engine: &str, threads: usize, settings: &Settings) -> String {
    let Settings { width, height, iterations, photons_per_iteration, max_depth, initial_radius, seed } =
        settings;
    format!(
        "{scene}: {width} x {height} pixels, {}, {} each, depth {max_depth}, radius {initial_radius}, seed {seed}; \
         engine {engine}, {}",
        counted(*iterations, "iteration"),
        counted(*photons_per_iteration, "photon"),
        counted(threads as u64, "thread"),
    )
}

/// Where time and memory went.
fn account(report: &Report) -> String {
    let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, bytes, .. } =
        report.stats;
    let passes = [
        ("camera pass", camera_seconds),
        ("grid", build_grid_seconds),
        ("photon pass", photon_seconds),
        ("consolidation", consolidate_seconds),
        ("developing", report.develop_seconds),
    ];
    let times: Vec<String> =
        passes.iter().map(|(name, seconds)| format!("{name} {}", duration(*seconds))).collect();
    format!("{}; {:.1} MiB", times.join(", "), bytes as f64 / f64::from(1 << 20))
}
