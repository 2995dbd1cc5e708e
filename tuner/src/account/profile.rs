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

#[cfg(test)]
mod tests {
    use super::*;

    /// For people, who may want to know how much there was to gain, and how it was found.
    #[test]
    fn a_profile_tells_what_was_tuned_and_how() {
        let outcome = Outcome::example(vec![0.95, 0.9, 0.91, 0.94, 0.92, 0.933_333, 0.5, 0.96, 1.2], true);
        let record = Record { tuned: tuned(&outcome), search: search(&outcome) };
        let table: toml::Table = toml::to_string(&record).unwrap().parse().unwrap();
        let tuned: toml::Table =
            "scene = \"box\"\niterations = 9\nthreads = 2\nis_confirmed = true\nis_gain = true\n\
                                  best_ratio = 0.9333\nbest_interval = [0.9, 0.96]\nbest_pairs = 9"
                .parse()
                .unwrap();
        for (name, value) in &tuned {
            assert_eq!(&table["tuned"][name], value, "{name}");
        }
        let search: toml::Table = "optimiser = \"stub 1.0\"\nseed = 7\npairs = 3\nratios = [1.01, 0.9, 1.2]\n\
                                   best = [1.01, 0.9, 0.9]\nnoise = 0.0123\nlength_scales = { cell_size = 0.5679 }"
            .parse()
            .unwrap();
        assert_eq!(table["search"].as_table(), Some(&search));
    }

    /// An interrupted search has no model to tell of.
    #[test]
    fn what_is_not_known_is_left_out() {
        let outcome = Outcome::example(vec![0.9], false);
        let record = Record { tuned: tuned(&outcome), search: search(&outcome) };
        let table: toml::Table = toml::to_string(&record).unwrap().parse().unwrap();
        let search = table["search"].as_table().unwrap();
        assert!(!search.contains_key("noise") && !search.contains_key("length_scales"), "{search}");
        let [is_confirmed, is_gain] = ["is_confirmed", "is_gain"].map(|name| table["tuned"][name].as_bool());
        assert_eq!([is_confirmed, is_gain], [Some(false); 2]);
    }
}
