//! Writes the profile, with a record of the search.

use super::outcome::Outcome;
use super::subject::Subject;
use crate::error::Error;
use crate::found::Found;
use files::atomic_file;
use scene::text::one_line;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// The table `[tuned]`: what was tuned, and how much was gained.
#[derive(Serialize)]
struct Tuned<'a> {
    #[serde(flatten)]
    subject: &'a Subject,
    /// Whether the best point was measured again.
    is_confirmed: bool,
    /// Whether the best point is significantly faster than the defaults.
    is_gain: bool,
    /// The best point: the median ratio of its time to that of the defaults, its 95 % confidence interval, and the
    /// number of measured pairs.
    best_ratio: f64,
    best_interval: [f64; 2],
    best_pairs: usize,
}

/// The table `[search]`: the course of the search.
#[derive(Serialize)]
struct Search<'a> {
    optimiser: &'a str,
    seed: u32,
    pairs: u32,
    /// The median ratio of every point, the defaults first.
    ratios: Vec<f64>,
    /// For each point, the least ratio so far.
    best: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    length_scales: Option<BTreeMap<&'a str, f64>>,
}

/// Both tables.
#[derive(Serialize)]
struct Record<'a> {
    tuned: Tuned<'a>,
    search: Search<'a>,
}

/// Writes the profile.
pub(crate) fn write(path: &Path, outcome: &Outcome) -> Result<(), Error> {
    let record = Record { tuned: tuned(outcome), search: search(outcome) };
    let record = toml::to_string(&record)
        .map_err(|error| Error::Failed(format!("cannot write {}: {error}", path.display())))?;
    let text = format!(
        "# Free parameters of the fast engine for {}, by `sppm tune`. The image does not depend on them.\n\
         # sppm render SCENE --profile {}\n\n{}\n# For people: what they were tuned for, and how.\n{record}",
        one_line(&outcome.subject.scene),
        one_line(&path.display().to_string()),
        outcome.chosen().profile().to_text()
    );
    Ok(atomic_file::replace(path, |out| out.write_all(text.as_bytes()))?)
}

fn tuned(outcome: &Outcome) -> Tuned<'_> {
    let Found { best, is_confirmed, .. } = &outcome.found;
    Tuned {
        subject: &outcome.subject,
        is_confirmed: *is_confirmed,
        is_gain: outcome.found.is_gain(),
        best_ratio: digits(best.ratios.median()),
        best_interval: best.ratios.interval().map(digits),
        best_pairs: best.ratios.count(),
    }
}

fn search(outcome: &Outcome) -> Search<'_> {
    let Found { tried, learnt, .. } = &outcome.found;
    let scales = learnt
        .as_ref()
        .map(|learnt| learnt.length_scales.iter().map(|(name, scale)| (&name[..], digits(*scale))).collect());
    Search {
        optimiser: &outcome.optimiser,
        seed: outcome.seed,
        pairs: outcome.pairs,
        ratios: tried.iter().map(|tried| digits(tried.ratios.median())).collect(),
        best: outcome.found.best_so_far().into_iter().map(digits).collect(),
        noise: learnt.as_ref().and_then(|learnt| learnt.noise).map(digits),
        length_scales: scales,
    }
}

/// Rounds to four decimals, as times are not measured more precisely.
fn digits(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
