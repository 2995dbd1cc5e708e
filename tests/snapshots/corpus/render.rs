//! Renders of the corpus, and what is told of them.

use super::scenes::Sample;
use fast::LaneKind;
use render::{EngineChoice, Job, MethodName};
use scene::aim::Targets;
use scene::state::transfer;
use scene::{Automatic, Engine, Quality, Resumable, Rgb, Settings, Stats};
use std::fmt::{self, Write};

/// How a sample is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// By photon mapping.
    Sppm,
    /// By path tracing.
    Path,
    /// Not at all: its settings are chosen.
    Choice,
}

/// What is stored of a render.
pub(super) struct Found {
    /// Words on how its photons fly.
    pub(super) photons: &'static str,
    text: String,
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The render of a sample by the reference, or by the fast engine on these lanes.
pub(super) fn found(sample: &Sample, lanes: Option<LaneKind>) -> Found {
    let Sample { scene, settings, .. } = sample;
    match (sample.method, lanes) {
        (Method::Sppm, None) => {
            let engine = reference::Sppm::new(scene, settings);
            // Known beforehand where it is to be told, as the survey would be made twice.
            let targets = sample.tells_aim.then(|| reference::survey::survey(scene, settings));
            let photons = targets.as_ref().map_or("", told);
            rendered(match targets {
                Some(targets) => engine.aimed_at(targets),
                None => engine,
            })
            .with(photons)
        }
        (Method::Sppm, Some(lanes)) => {
            let photons =
                if sample.tells_aim { told(&fast::kernels::survey(scene, settings, lanes)) } else { "" };
            let new = || fast::Sppm::with_lanes(scene, settings, lanes);
            rendered(begun(sample, new)).with(photons)
        }
        (Method::Path, None) => rendered(reference::PathTracer::new(scene, settings)),
        (Method::Path, Some(lanes)) => {
            rendered(begun(sample, || fast::PathTracer::with_lanes(scene, settings, lanes)))
        }
        (Method::Choice, _) => chosen(sample),
    }
}

fn told(targets: &Targets) -> &'static str {
    match targets {
        Targets { guide: Some(_), .. } => "guided",
        Targets { shares, .. } if !shares.is_empty() => "aimed",
        _ => "",
    }
}

impl Found {
    fn with(self, photons: &'static str) -> Self {
        Self { photons, ..self }
    }
}

/// An engine that may have rendered the first iteration already, and handed what it holds to another: in every other scene.
fn begun<E: Resumable>(sample: &Sample, new: impl Fn() -> E) -> E {
    let mut engine = new();
    if sample.number % 2 == 1 {
        engine.iterate();
        let mut other = new();
        transfer(&engine, &mut other);
        engine = other;
    }
    engine
}

/// Renders all iterations that are left.
fn rendered(mut engine: impl Engine) -> Found {
    for _ in engine.iterations()..engine.settings().iterations {
        engine.iterate();
    }
    let mut text = format!("image {:08x}", crc(&floats(&engine.develop().pixels)));
    if let Some(direct) = engine.direct() {
        write!(text, " direct {:08x}", crc(&floats(&direct.pixels))).unwrap();
    }
    for (name, plane) in [("radius", engine.radius()), ("count", engine.count())] {
        if let Some(plane) = plane {
            write!(text, " {name} {:08x}", crc(&plane.values)).unwrap();
        }
    }
    let &Stats {
        camera_segments, shadow_rays, visible_points, photon_segments, deposits, contributions, ..
    } = engine.stats();
    write!(
        text,
        " | {camera_segments} {shadow_rays} {visible_points} {photon_segments} {deposits} {contributions}"
    )
    .unwrap();
    Found { photons: "", text }
}

/// The settings that are chosen, for each quality and method in turn. That is done by the fast engine, whose pilots are those of
/// the reference.
fn chosen(sample: &Sample) -> Found {
    let scene = scene::Scene { settings: sample.settings, ..sample.scene.clone() };
    let quality = [Quality::Draft, Quality::Good, Quality::Final][sample.number as usize % 3];
    let method = [MethodName::Sppm, MethodName::Sppm, MethodName::Path][sample.number as usize / 3 % 3];
    let mut job = Job::new(scene).choosing(Automatic::all(quality));
    job.engine = EngineChoice::new(method, None).unwrap();
    job.threads = Some(1);
    job.choose_settings().unwrap_or_else(|error| panic!("{}: {error}", sample.number));
    let Settings {
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        radius_pilots,
        radius_clearance,
        glint_samples,
        ..
    } = job.scene.settings;
    let text = format!(
        "{quality} by {method:?}: {iterations} iterations, {photons_per_iteration} photons, depth {max_depth}, radius {initial_radius}, \
         {radius_pilots} pilots, clearance {radius_clearance}, {glint_samples} rays for lamps"
    );
    Found { photons: "", text }
}

fn floats(pixels: &[Rgb]) -> Vec<f32> {
    pixels.iter().flat_map(Rgb::to_array).collect()
}

fn crc(values: &[f32]) -> u32 {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_bits().to_le_bytes()).collect();
    crc32fast::hash(&bytes)
}
