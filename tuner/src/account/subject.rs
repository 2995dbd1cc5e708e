//! What was tuned: scene, settings, threads and processor.

use files::scene_file;
use scene::{Scene, Settings};
use serde::Serialize;

use std::time::SystemTime;

/// What was tuned, as recorded in the profile.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Subject {
    /// The scene's name on the command line.
    pub(crate) scene: String,
    /// SHA-256 of the scene.
    pub(crate) scene_digest: String,
    #[serde(flatten)]
    pub(crate) settings: Settings,
    pub(crate) threads: usize,
    pub(crate) machine: String,
    pub(crate) version: &'static str,
    pub(crate) date: String,
}

impl Subject {
    /// Describes a scene on this machine today. `settings` are those of the renders, not the scene's own.
    pub(crate) fn new(name: &str, scene: &Scene, settings: Settings, threads: usize) -> Self {
        Self {
            scene: name.into(),
            scene_digest: scene_file::digest(scene),
            settings,
            threads,
            machine: processor(),
            version: env!("CARGO_PKG_VERSION"),
            date: today(),
        }
    }
}

/// The name of the processor, or the architecture if the system does not provide the name.
fn processor() -> String {
    let about = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or(std::env::consts::ARCH, |(_, model)| model.trim()).to_owned()
}

/// The date in UTC, as `2026-01-31`.
fn today() -> String {
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    now.split('T').next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The settings are those of the renders, and the digest that of the scene, as in images of it.
    #[test]
    fn what_was_tuned_is_told_as_it_was() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 9, ..scene.settings };
        let subject = Subject::new("my box", &scene, settings, 3);
        assert_eq!((&subject.scene[..], subject.threads, subject.settings), ("my box", 3, settings));
        assert_eq!(subject.scene_digest, scene_file::digest(&scene));
        assert!(!subject.machine.is_empty() && !subject.machine.contains(['\n', ':']), "{}", subject.machine);
        let parts: Vec<&str> = subject.date.split('-').collect();
        assert_eq!(parts.iter().map(|part| part.len()).collect::<Vec<_>>(), [4, 2, 2], "{}", subject.date);
        assert!(parts.iter().all(|part| part.parse::<u32>().is_ok()), "{}", subject.date);
    }
}
