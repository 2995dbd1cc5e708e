//! What a search leaves: the profile with its record, the table of all that was tried, the plot, and some lines.

use super::search::{Found, Tried};
use super::space::{Candidate, Space};
use crate::terminal::error::Error;
use fast::Parameters;
use files::atomic_file;
use plots::{Canvas, Drawn, save};
use plotters::prelude::*;
use render::LanesName;
use render::Profile;
use scene::Settings;
use scene::text::counted;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;

/// What was tuned, for those who read its profile.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Subject {
    /// The scene's name on the command line.
    pub scene: String,
    /// SHA-256 of it.
    pub scene_digest: String,
    #[serde(flatten)]
    pub settings: Settings,
    pub threads: usize,
    pub machine: String,
    pub version: &'static str,
    pub date: String,
}

/// The table `[tuned]`: what for, and with what success.
#[derive(Serialize)]
struct Tuned<'a> {
    #[serde(flatten)]
    subject: &'a Subject,
    /// Whether the best was measured anew.
    is_confirmed: bool,
    /// Whether the parameters above are the best found; else they are the defaults.
    is_gain: bool,
    /// The best found: its time over the defaults', the median of pairs, the interval that this lies in with 95 %
    /// confidence, and the pairs.
    best_ratio: f64,
    best_interval: [f64; 2],
    best_pairs: usize,
}

/// The table `[search]`: how it came to that.
#[derive(Serialize)]
struct Search<'a> {
    optimiser: &'a str,
    seed: u32,
    pairs: u32,
    /// Of every point in turn, the defaults first.
    ratios: Vec<f64>,
    /// The least ratio so far.
    best: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    length_scales: Option<BTreeMap<&'a str, f64>>,
}

#[derive(Serialize)]
struct Record<'a> {
    tuned: Tuned<'a>,
    search: Search<'a>,
}

/// A search that is over.
pub(super) struct Account<'a> {
    pub subject: &'a Subject,
    pub space: &'a Space,
    pub found: &'a Found,
    /// The library and its version.
    pub optimiser: &'a str,
    pub seed: u32,
    pub pairs: u32,
}

impl Account<'_> {
    /// What to render by: the best, unless it was measured anew and is no gain.
    fn profile(&self) -> Profile {
        let Found { best, is_confirmed, .. } = self.found;
        let is_usual = *is_confirmed && !self.found.is_gain();
        if is_usual { self.space.usual().profile() } else { best.candidate.profile() }
    }

    /// Writes the profile.
    pub(super) fn write_profile(&self, path: &Path) -> Result<(), Error> {
        let Subject { scene, .. } = self.subject;
        let Found { tried, learnt, best, is_confirmed } = self.found;
        let scales = learnt.as_ref().map(|learnt| {
            learnt.length_scales.iter().map(|(name, scale)| (&name[..], digits(*scale))).collect()
        });
        let record = Record {
            tuned: Tuned {
                subject: self.subject,
                is_confirmed: *is_confirmed,
                is_gain: self.found.is_gain(),
                best_ratio: digits(best.ratios.median()),
                best_interval: best.ratios.interval().map(digits),
                best_pairs: best.ratios.count(),
            },
            search: Search {
                optimiser: self.optimiser,
                seed: self.seed,
                pairs: self.pairs,
                ratios: tried.iter().map(|tried| digits(tried.ratios.median())).collect(),
                best: self.found.best_so_far().into_iter().map(digits).collect(),
                noise: learnt.as_ref().and_then(|learnt| learnt.noise).map(digits),
                length_scales: scales,
            },
        };
        let record = toml::to_string(&record)
            .map_err(|error| Error::Failed(format!("cannot write {}: {error}", path.display())))?;
        let text = format!(
            "# Free parameters of the fast engine for {}, by `sppm tune`. The image does not depend on them.\n\
             # sppm render SCENE --profile {}\n\n{}\n# For people: what they were tuned for, and how.\n{record}",
            scene::text::one_line(scene),
            scene::text::one_line(&path.display().to_string()),
            self.profile().to_text()
        );
        let written = atomic_file::replace(path, |out| out.write_all(text.as_bytes()));
        written.map_err(|error| Error::Failed(error.to_string()))
    }

    /// Writes all that was tried as a table of comma-separated values; the last line is the best, measured anew.
    pub(super) fn write_csv(&self, path: &Path) -> Result<(), Error> {
        let names = Parameters::ALL.iter().map(|parameter| parameter.name);
        let header = ["evaluation", "ratio", "least", "most", "pairs", "lanes"].into_iter().chain(names);
        let record = |number: usize, Tried { candidate, ratios }: &Tried| {
            let [least, most] = ratios.ends();
            let lanes = LanesName::from(candidate.lanes).name();
            let figures = [ratios.median(), least, most].map(|ratio| format!("{ratio:.5}"));
            let start =
                [vec![number.to_string()], figures.into(), vec![ratios.count().to_string(), lanes.into()]];
            let values = candidate.parameters.values().into_iter().map(|value| (value as f32).to_string());
            start.concat().into_iter().chain(values).collect::<Vec<_>>()
        };
        let fill = |out: &mut atomic_file::Output| {
            let mut csv = csv::Writer::from_writer(out);
            csv.write_record(header).map_err(io::Error::other)?;
            let anew = self.found.is_confirmed.then_some(&self.found.best);
            for (number, tried) in self.found.tried.iter().chain(anew).enumerate() {
                csv.write_record(record(number + 1, tried)).map_err(io::Error::other)?;
            }
            csv.flush()
        };
        atomic_file::replace(path, fill).map_err(|error| Error::Failed(error.to_string()))
    }

    /// Draws the ratio of every point, the least so far, and the best with its interval.
    pub(super) fn write_plot(&self, path: &Path) -> Result<(), Error> {
        save(path, |canvas| self.draw(canvas)).map_err(|error| Error::Failed(error.to_string()))
    }

    fn draw(&self, root: &Canvas) -> Drawn {
        let ratios: Vec<f64> = self.found.tried.iter().map(|tried| tried.ratios.median()).collect();
        let [low, high] = self.found.best.ratios.interval();
        let all = || ratios.iter().copied().chain([low, high, 1.0]);
        // A few points may be very slow; what is near the defaults is what one looks at.
        let (least, most) = (all().fold(1.0, f64::min), all().fold(1.0, f64::max).min(1.5));
        let last = ratios.len() as f64 + 1.0;
        let mut chart = ChartBuilder::on(root)
            .caption(format!("{}: time over the defaults'", self.subject.scene), ("sans-serif", 20))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(50)
            .build_cartesian_2d(0.0..last + 1.0, least - 0.02..most + 0.02)?;
        chart
            .configure_mesh()
            .x_desc("points tried; at last the best, measured anew")
            .y_desc("ratio")
            .draw()?;
        let numbered = |values: Vec<f64>| (1..).map(f64::from).zip(values).collect::<Vec<_>>();
        chart.draw_series(LineSeries::new([(0.0, 1.0), (last + 1.0, 1.0)], BLACK))?;
        let (point, line) = (Palette99::pick(0).filled(), Palette99::pick(1).stroke_width(2));
        chart
            .draw_series(numbered(ratios).into_iter().map(|(x, y)| Circle::new((x, y.min(most)), 3, point)))?
            .label("a point")
            .legend(move |(x, y)| Circle::new((x + 7, y), 3, point));
        chart
            .draw_series(LineSeries::new(numbered(self.found.best_so_far()), line))?
            .label("the least so far")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], line));
        let bar = Palette99::pick(3).stroke_width(3);
        let median = self.found.best.ratios.median();
        chart
            .draw_series([PathElement::new([(last, low), (last, high)], bar)])?
            .label("the best, 95 % interval")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], bar));
        chart.draw_series([Circle::new((last, median), 5, bar)])?;
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .border_style(BLACK)
            .draw()?;
        Ok(())
    }

    /// What has been found, for people.
    pub(super) fn text(&self) -> String {
        let Found { tried, learnt, best, is_confirmed } = self.found;
        let Subject { scene, threads, .. } = self.subject;
        let (points, threads) = (counted(tried.len() as u64, "point"), counted(*threads as u64, "thread"));
        let pairs = counted(self.pairs, "pair");
        let mut text = format!("{scene}, {threads}: {points} tried, each in {pairs} with the defaults");
        if let Some(noise) = learnt.as_ref().and_then(|learnt| learnt.noise) {
            let _ = write!(text, "; noise {:.1} %", 100.0 * noise);
        }
        let (median, [low, high]) = (best.ratios.median(), best.ratios.interval());
        let certainty = format!("95 % interval {low:.3} to {high:.3}, {} pairs", best.ratios.count());
        let difference = difference(best.candidate, self.space.usual());
        let _ = match (is_confirmed, self.found.is_gain()) {
            (false, _) => {
                write!(text, "\nthe best so far takes {median:.3} of the defaults' time: {difference}")
            }
            (true, true) => {
                write!(text, "\na gain: {median:.3} of the defaults' time ({certainty}) by {difference}")
            }
            (true, false) => write!(
                text,
                "\nno gain: the best takes {median:.3} of the defaults' time ({certainty}), so the defaults are at \
                 the optimum within {:.1} %; it was {difference}",
                100.0 * (1.0 - low).max(0.0)
            ),
        };
        text + "\n"
    }
}

/// In what a candidate differs from the defaults.
fn difference(candidate: Candidate, usual: Candidate) -> String {
    let values = candidate.parameters.values().into_iter().zip(usual.parameters.values());
    let named = Parameters::ALL.iter().zip(values).filter(|(_, (value, usual))| value != usual);
    let mut parts: Vec<String> = named
        .map(|(parameter, (value, usual))| format!("{} {} ({})", parameter.name, value as f32, usual as f32))
        .collect();
    if candidate.lanes != usual.lanes {
        let [lanes, usual] = [candidate.lanes, usual.lanes].map(|lanes| LanesName::from(lanes).name());
        parts.push(format!("lanes {lanes} ({usual})"));
    }
    if parts.is_empty() { "the defaults themselves".into() } else { parts.join(", ") }
}

/// To four decimals: more would pretend to be measured.
fn digits(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
