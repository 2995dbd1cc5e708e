//! The report of a render, which `--stats` writes as JSON: settings, seconds per pass, and counted work.

use crate::names::{LanesName, Renderer};
use scene::{Settings, Stats};
use serde::Serialize;
use std::io::{self, Write};

/// Measurements of a render.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of sppm.
    pub version: &'static str,
    /// The scene's own name.
    pub scene: String,
    /// The method and the engine.
    #[serde(flatten)]
    pub renderer: Renderer,
    /// The lanes that it ran on, if it has any.
    pub lanes: Option<LanesName>,
    /// Number of threads.
    pub threads: usize,
    /// The requested settings.
    pub settings: Settings,
    /// Iterations in the image; fewer than requested if the render ended early.
    pub iterations: u32,
    /// Whether a stop request ended the render.
    pub interrupted: bool,
    /// What ended the render.
    pub ended_by: &'static str,
    /// Iterations that were resumed from a checkpoint.
    pub resumed_after: u32,
    /// The last estimate of the relative error, if there is an error goal.
    pub estimated_error: Option<f64>,
    /// Seconds from the start of the first iteration to the end of the last, in this session. If the render was
    /// stopped, writing its last checkpoint is included.
    pub wall_seconds: f64,
    /// Seconds for developing and writing images, in this session. All but the final images are part of `wall_seconds`.
    pub write_seconds: f64,
    /// The bound on memory that was computed before the start.
    pub bytes_at_most: u64,
    /// Peak memory of the process, where the system provides it.
    pub peak_bytes: Option<u64>,
    /// The engine's own counts and times, over all sessions.
    #[serde(flatten)]
    pub stats: Stats,
}

impl Report {
    /// Whether so few photons reached what is seen that the light that comes over other surfaces is as good as missing.
    ///
    /// Its error then does not show in the image, and [`Report::estimated_error`] is that of direct light alone.
    pub fn lacks_photons(&self) -> bool {
        stats_lack_photons(&self.stats)
    }

    /// Writes the report as indented JSON.
    ///
    /// # Errors
    /// If writing to `out` fails.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        out.write_all(b"\n")
    }
}

/// See [`Report::lacks_photons`].
fn stats_lack_photons(&Stats { photons, contributions, visible_points, .. }: &Stats) -> bool {
    /// Of fewer photons nothing is said: a render so small is a test.
    const LEAST_PHOTONS: u64 = 10_000;
    /// Photons that were emitted for each that counted at a visible point.
    const MOST_PER_CONTRIBUTION: u64 = 1000;
    photons >= LEAST_PHOTONS && visible_points > 0 && contributions < photons / MOST_PER_CONTRIBUTION
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photons_lack_where_less_than_one_in_a_thousand_counts() {
        let lacks = |photons, contributions, visible_points| {
            let stats = Stats { photons, contributions, visible_points, ..Stats::default() };
            stats_lack_photons(&stats)
        };
        assert!(lacks(1_000_000, 0, 1) && lacks(1_000_000, 999, 500));
        assert!(!lacks(1_000_000, 1000, 500) && !lacks(1_000_000, 5_000_000, 500));
        // So few photons are a test, and where nothing is seen that they could reach, none is missing.
        assert!(lacks(10_000, 9, 1) && !lacks(9_999, 0, 1));
        assert!(!lacks(1_000_000, 0, 0));
    }

    #[test]
    fn a_report_is_one_json_object_on_lines() {
        let report = Report {
            version: "1",
            scene: "a".into(),
            renderer: Renderer::default(),
            lanes: None,
            threads: 3,
            settings: Settings::default(),
            iterations: 4,
            interrupted: true,
            ended_by: "stop",
            resumed_after: 2,
            estimated_error: Some(0.5),
            wall_seconds: 1.5,
            write_seconds: 0.25,
            bytes_at_most: 7,
            peak_bytes: None,
            stats: Stats { photons: 20_000, visible_points: 1, ..Stats::default() },
        };
        assert!(report.lacks_photons());
        let mut out = Vec::new();
        report.write(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.starts_with("{\n") && text.ends_with("\n}\n"), "{text}");
        let read: serde_json::Value = serde_json::from_str(&text).unwrap();
        for (key, value) in [("threads", 3), ("iterations", 4), ("resumed_after", 2), ("photons", 20_000)] {
            assert_eq!(read[key], value, "{key}");
        }
        assert_eq!((&read["method"], &read["ended_by"]), (&"sppm".into(), &"stop".into()));
    }
}
