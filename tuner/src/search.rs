//! The search: measures the optimiser's proposals one by one, and then measures the best one again.

use crate::budget::Budget;
use crate::candidate::Candidate;
use crate::error::Error;
use crate::found::{Found, Tried};
use crate::optimiser::Optimiser;
use crate::space::Space;
use crate::stopwatch::Stopwatch;
use std::time::Instant;

/// The number of most promising points that are measured once more before one is chosen.
const FINALISTS: usize = 3;

/// Called with the number of points done and a text on the current step.
pub type Progress<'a> = dyn FnMut(u32, &str) + 'a;

/// Searches until the budget is spent or a stop is requested. `None` if not even the defaults were measured by then.
pub(crate) fn search(
    stopwatch: &Stopwatch,
    space: &Space,
    optimiser: &mut Optimiser,
    budget: &Budget,
    progress: &mut Progress,
) -> Result<Option<Found>, Error> {
    let (tried, is_stopped) = try_points(stopwatch, space, optimiser, budget, progress)?;
    let Some(best) = tried.iter().min_by(|a, b| a.ratios.median().total_cmp(&b.ratios.median())).cloned()
    else {
        return Ok(None);
    };
    let mut found = Found { tried, learnt: None, best, is_confirmed: false };
    if is_stopped {
        return Ok(Some(found));
    }
    let learnt = optimiser.conclude(found.tried.len())?;
    let finalists = finalists(&found.tried, &learnt.order, space.defaults());
    found.learnt = Some(learnt);
    progress(budget.evaluations, "the best once more");
    if let Some(best) = final_round(stopwatch, finalists, budget)? {
        found.best = best;
        progress(budget.evaluations, "the very best anew");
        // The best of many measurements is best partly by luck, so it is measured again.
        if let Some(ratios) = stopwatch.ratios(found.best.candidate, budget.final_pairs)? {
            found.best.ratios = ratios;
            found.is_confirmed = true;
        }
    }
    Ok(Some(found))
}

/// Measures points; returns them, and whether a stop was requested.
fn try_points(
    stopwatch: &Stopwatch,
    space: &Space,
    optimiser: &mut Optimiser,
    budget: &Budget,
    progress: &mut Progress,
) -> Result<(Vec<Tried>, bool), Error> {
    let began = Instant::now();
    let mut tried = Vec::<Tried>::new();
    let mut best = f64::INFINITY;
    while tried.len() < budget.evaluations as usize && budget.time.is_none_or(|time| began.elapsed() < time) {
        let point = match optimiser.ask() {
            Ok(point) => point,
            Err(_) if stopwatch.is_stopped() => return Ok((tried, true)),
            Err(error) => return Err(error),
        };
        let candidate = space.candidate(&point)?;
        let Some(ratios) = stopwatch.ratios(candidate, budget.pairs)? else { return Ok((tried, true)) };
        best = best.min(ratios.median());
        progress(tried.len() as u32 + 1, &format!("best {best:.3} of the defaults' time"));
        match optimiser.tell(&point, ratios.median().ln()) {
            Err(_) if stopwatch.is_stopped() => return Ok((tried, true)),
            told => told?,
        }
        tried.push(Tried { candidate, ratios });
    }
    Ok((tried, false))
}

/// The first distinct points in this order, without the defaults. If there is none, the defaults.
fn finalists(tried: &[Tried], order: &[usize], defaults: Candidate) -> Vec<Tried> {
    let mut chosen: Vec<Tried> = Vec::new();
    for tried in order.iter().map(|place| &tried[*place]) {
        let is_new =
            tried.candidate != defaults && chosen.iter().all(|other| other.candidate != tried.candidate);
        if is_new && chosen.len() < FINALISTS {
            chosen.push(tried.clone());
        }
    }
    if chosen.is_empty() {
        chosen.extend(tried.first().cloned());
    }
    chosen
}

/// Measures a few more pairs of each finalist and returns the best one; `None` if stopped.
fn final_round(
    stopwatch: &Stopwatch,
    finalists: Vec<Tried>,
    budget: &Budget,
) -> Result<Option<Tried>, Error> {
    let pairs = budget.final_pairs.div_ceil(FINALISTS as u32);
    let mut best: Option<Tried> = None;
    for finalist in finalists {
        let Some(more) = stopwatch.ratios(finalist.candidate, pairs)? else { return Ok(None) };
        let finalist = Tried { ratios: finalist.ratios.and(more), ..finalist };
        if best.as_ref().is_none_or(|best| finalist.ratios.median() < best.ratios.median()) {
            best = Some(finalist);
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finalists_differ_from_each_other_and_from_the_defaults() {
        let all: Vec<Tried> = [5.0, 4.0, 6.0, 4.0, 7.0, 8.0].map(|size| Tried::example(size, 1.0)).into();
        let defaults = all[0].candidate;
        let sizes = |order: &[usize]| -> Vec<_> {
            finalists(&all, order, defaults).iter().map(|t| t.candidate.parameters.values()[0]).collect()
        };
        assert_eq!(sizes(&[0, 3, 1, 5, 4, 2]), [4.0, 8.0, 7.0]);
        assert_eq!(finalists(&all[..1], &[0], defaults).len(), 1);
    }
}
