//! The search: proposals are measured one after the other, and the best is measured anew.

use super::measure::{Bench, Ratios};
use super::optimiser::{Learnt, Optimiser};
use super::space::{Candidate, Space};
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use std::time::{Duration, Instant};

/// Of the points that look best, so many are measured once more before one of them is chosen.
const FINALISTS: usize = 3;

/// How much is to be done.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub evaluations: u32,
    pub pairs: u32,
    pub final_pairs: u32,
    pub time: Option<Duration>,
}

impl Budget {
    /// Points spread over the space before the model proposes any.
    pub(super) fn initial(&self) -> u32 {
        (self.evaluations / 4).clamp(2, 12)
    }
}

/// A point that was measured.
#[derive(Clone, Debug)]
pub(super) struct Tried {
    pub candidate: Candidate,
    pub ratios: Ratios,
}

/// What has been found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// In the order of the proposals; the first are the defaults themselves.
    pub tried: Vec<Tried>,
    /// What the optimiser has learnt of them, unless the search was interrupted.
    pub learnt: Option<Learnt>,
    /// The best, and how it did when it was measured anew; or where that was interrupted, when it was tried.
    pub best: Tried,
    /// Whether it was measured anew.
    pub is_confirmed: bool,
}

impl Found {
    /// Whether the best is faster than the defaults, beyond chance.
    pub(super) fn is_gain(&self) -> bool {
        self.is_confirmed && self.best.ratios.interval()[1] < 1.0
    }

    /// The least ratio of those up to each point.
    pub(super) fn best_so_far(&self) -> Vec<f64> {
        let ratios = self.tried.iter().map(|tried| tried.ratios.median());
        let lower = |best: &mut f64, ratio| {
            *best = best.min(ratio);
            Some(*best)
        };
        ratios.scan(f64::INFINITY, lower).collect()
    }
}

/// Searches until the budget is spent, or a stop is asked for. `None` if not even the defaults were measured by then.
pub(super) fn search(
    bench: &Bench,
    space: &Space,
    optimiser: &mut Optimiser,
    budget: &Budget,
    progress: &Bar,
) -> Result<Option<Found>, Error> {
    let (tried, is_stopped) = try_points(bench, space, optimiser, budget, progress)?;
    let Some(best) = tried.iter().min_by(|a, b| a.ratios.median().total_cmp(&b.ratios.median())).cloned()
    else {
        return Ok(None);
    };
    let mut found = Found { tried, learnt: None, best, is_confirmed: false };
    if is_stopped {
        return Ok(Some(found));
    }
    let learnt = optimiser.conclude(found.tried.len())?;
    let finalists = finalists(&found.tried, &learnt.order, space.usual());
    found.learnt = Some(learnt);
    progress.step(budget.evaluations, "the best once more");
    if let Some(best) = final_round(bench, finalists, budget)? {
        found.best = best;
        progress.step(budget.evaluations, "the very best anew");
        // Measured anew: the best of many is best by luck, too.
        if let Some(ratios) = bench.ratios(found.best.candidate, budget.final_pairs)? {
            found.best.ratios = ratios;
            found.is_confirmed = true;
        }
    }
    Ok(Some(found))
}

/// The points that were measured, and whether a stop was asked for.
fn try_points(
    bench: &Bench,
    space: &Space,
    optimiser: &mut Optimiser,
    budget: &Budget,
    progress: &Bar,
) -> Result<(Vec<Tried>, bool), Error> {
    let began = Instant::now();
    let mut tried = Vec::<Tried>::new();
    let mut best = f64::INFINITY;
    while tried.len() < budget.evaluations as usize && budget.time.is_none_or(|time| began.elapsed() < time) {
        let point = match optimiser.ask() {
            Ok(point) => point,
            Err(_) if bench.is_stopped() => return Ok((tried, true)),
            Err(error) => return Err(error),
        };
        let candidate = space.candidate(&point)?;
        let Some(ratios) = bench.ratios(candidate, budget.pairs)? else { return Ok((tried, true)) };
        best = best.min(ratios.median());
        progress.step(tried.len() as u32 + 1, &format!("best {best:.3} of the defaults' time"));
        match optimiser.tell(&point, ratios.median().ln()) {
            Err(_) if bench.is_stopped() => return Ok((tried, true)),
            told => told?,
        }
        tried.push(Tried { candidate, ratios });
    }
    Ok((tried, false))
}

/// The best different points in this order, without the defaults; these where there is no other.
fn finalists(tried: &[Tried], order: &[usize], usual: Candidate) -> Vec<Tried> {
    let mut chosen: Vec<Tried> = Vec::new();
    for tried in order.iter().map(|place| &tried[*place]) {
        let is_new =
            tried.candidate != usual && chosen.iter().all(|other| other.candidate != tried.candidate);
        if is_new && chosen.len() < FINALISTS {
            chosen.push(tried.clone());
        }
    }
    if chosen.is_empty() {
        chosen.extend(tried.first().cloned());
    }
    chosen
}

/// The best of some, after a few more pairs of each; `None` if stopped.
fn final_round(bench: &Bench, finalists: Vec<Tried>, budget: &Budget) -> Result<Option<Tried>, Error> {
    let pairs = budget.final_pairs.div_ceil(FINALISTS as u32);
    let mut best: Option<Tried> = None;
    for finalist in finalists {
        let Some(more) = bench.ratios(finalist.candidate, pairs)? else { return Ok(None) };
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
    use fast::{LaneKind, Parameters};

    fn tried(cell_size: f64, ratio: f64) -> Tried {
        let parameters = Parameters::default().with("cell_size", cell_size).unwrap();
        let candidate = Candidate { lanes: LaneKind::Emulated, parameters };
        Tried { candidate, ratios: Ratios::new(vec![ratio]) }
    }

    fn found(best: Vec<f64>, is_confirmed: bool) -> Found {
        let all: Vec<Tried> =
            [(5.0, 1.01), (4.0, 0.9), (6.0, 1.2)].map(|(size, ratio)| tried(size, ratio)).into();
        let best = Tried { ratios: Ratios::new(best), ..all[1].clone() };
        Found { tried: all, learnt: None, best, is_confirmed }
    }

    #[test]
    fn finalists_differ_from_each_other_and_from_the_defaults() {
        let all: Vec<Tried> = [5.0, 4.0, 6.0, 4.0, 7.0, 8.0].map(|size| tried(size, 1.0)).into();
        let usual = all[0].candidate;
        let sizes = |order: &[usize]| -> Vec<_> {
            finalists(&all, order, usual).iter().map(|t| t.candidate.parameters.values()[0]).collect()
        };
        assert_eq!(sizes(&[0, 3, 1, 5, 4, 2]), [4.0, 8.0, 7.0]);
        assert_eq!(finalists(&all[..1], &[0], usual).len(), 1);
    }

    #[test]
    fn a_gain_is_beyond_chance_and_measured_anew() {
        let clear = vec![0.9, 0.91, 0.92, 0.93, 0.94, 0.95];
        let in_doubt = vec![0.9, 0.91, 0.92, 0.93, 0.94, 1.01];
        assert!(found(clear.clone(), true).is_gain());
        assert!(!found(clear, false).is_gain());
        assert!(!found(in_doubt, true).is_gain());
    }

    #[test]
    fn the_best_so_far_never_grows() {
        assert_eq!(found(vec![1.0], true).best_so_far(), [1.01, 0.9, 0.9]);
    }
}
