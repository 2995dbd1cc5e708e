//! Describes the outcome of a search in two lines of text.

use super::outcome::Outcome;
use super::subject::Subject;
use crate::candidate::Candidate;
use crate::found::Found;
use fast::Parameters;
use render::LanesName;
use scene::text::counted;

/// What was tried, and on a second line the result.
pub(crate) fn text(outcome: &Outcome) -> String {
    format!("{}\n{}\n", tried(outcome), verdict(outcome))
}

fn tried(outcome: &Outcome) -> String {
    let Subject { scene, threads, .. } = &outcome.subject;
    let Found { tried, learnt, .. } = &outcome.found;
    let (points, threads) = (counted(tried.len() as u64, "point"), counted(*threads as u64, "thread"));
    let pairs = counted(outcome.pairs, "pair");
    let noise = learnt.as_ref().and_then(|learnt| learnt.noise);
    let noise = noise.map_or(String::new(), |noise| format!("; noise {:.1} %", 100.0 * noise));
    format!("{scene}, {threads}: {points} tried, each in {pairs} with the defaults{noise}")
}

fn verdict(outcome: &Outcome) -> String {
    let Found { best, is_confirmed, .. } = &outcome.found;
    let (median, [low, high]) = (best.ratios.median(), best.ratios.interval());
    let certainty = format!("95 % interval {low:.3} to {high:.3}, {} pairs", best.ratios.count());
    let difference = difference(best.candidate, outcome.defaults);
    match (is_confirmed, outcome.found.is_gain()) {
        (false, _) => format!("the best so far takes {median:.3} of the defaults' time: {difference}"),
        (true, true) => format!("a gain: {median:.3} of the defaults' time ({certainty}) by {difference}"),
        (true, false) => format!(
            "no gain: the best takes {median:.3} of the defaults' time ({certainty}), so the defaults are at the \
             optimum within {:.1} %; it was {difference}",
            100.0 * (1.0 - low).max(0.0)
        ),
    }
}

/// The values of a candidate that differ from the defaults, with the defaults in brackets.
fn difference(candidate: Candidate, defaults: Candidate) -> String {
    let values = candidate.parameters.values().into_iter().zip(defaults.parameters.values());
    let named = Parameters::ALL.iter().zip(values).filter(|(_, (value, default))| value != default);
    let mut parts: Vec<String> = named
        .map(|(parameter, (value, default))| {
            format!("{} {} ({})", parameter.name, value as f32, default as f32)
        })
        .collect();
    if candidate.lanes != defaults.lanes {
        let [lanes, default] = [candidate.lanes, defaults.lanes].map(|lanes| LanesName::from(lanes).name());
        parts.push(format!("lanes {lanes} ({default})"));
    }
    if parts.is_empty() { "the defaults themselves".into() } else { parts.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fast::LaneKind;

    /// What was tried, and what came of it: with its median, its interval, and how many pairs both are of.
    #[test]
    fn a_search_is_told_in_two_lines() {
        let gain = vec![0.95, 0.9, 0.91, 0.94, 0.92, 0.93, 0.5, 0.96, 1.2];
        let tried = "box, 2 threads: 3 points tried, each in 3 pairs with the defaults";
        assert_eq!(
            text(&Outcome::example(gain.clone(), true)),
            format!(
                "{tried}; noise 1.2 %\na gain: 0.930 of the defaults' time (95 % interval 0.900 to 0.960, 9 pairs) by \
                 cell_size 4 (5)\n"
            )
        );
        assert_eq!(
            text(&Outcome::example(vec![0.98, 0.99, 1.0, 1.0, 1.01, 1.05], true)),
            format!(
                "{tried}; noise 1.2 %\nno gain: the best takes 1.000 of the defaults' time (95 % interval 0.980 to 1.050, \
                 6 pairs), so the defaults are at the optimum within 2.0 %; it was cell_size 4 (5)\n"
            )
        );
        // One that was interrupted has neither a model nor a final measurement.
        assert_eq!(
            text(&Outcome::example(gain, false)),
            format!("{tried}\nthe best so far takes 0.930 of the defaults' time: cell_size 4 (5)\n")
        );
        // What is slower throughout leaves no doubt.
        let loss = text(&Outcome::example(vec![1.1; 6], true));
        assert!(loss.contains("at the optimum within 0.0 %"), "{loss}");
    }

    #[test]
    fn values_that_differ_are_told_beside_the_defaults() {
        let defaults = Candidate { lanes: LaneKind::Emulated, parameters: Parameters::default() };
        assert_eq!(difference(defaults, defaults), "the defaults themselves");
        let parameters = Parameters::default().with("cell_size", 4.5).unwrap();
        let other = Candidate { lanes: LaneKind::Avx2, parameters };
        assert_eq!(difference(other, defaults), "cell_size 4.5 (5), lanes avx2 (emulated)");
    }
}
