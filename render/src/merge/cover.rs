//! The choice of parts that hold each iteration exactly once.

use scene::Iterations;
use std::collections::HashSet;

/// Choices that are tried before the search is given up.
const MOST_STEPS: usize = 1 << 17;

/// Two parts that have some iterations in common, where no choice of parts has all iterations once.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Conflict {
    pub(super) parts: [usize; 2],
    pub(super) common: Iterations,
}

/// A choice among the `parts` in which each iteration that any of them has is in exactly one, as indices in ascending order.
///
/// It is found by depth-first search: of the parts that have the first iteration which is still missing, and none that is not,
/// the largest is tried first. Without partial overlaps that succeeds at once.
pub(super) fn cover(parts: &[Iterations]) -> Result<Vec<usize>, Conflict> {
    let all = parts.iter().fold(Iterations::default(), |all, part| all.with(part));
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&part| (u32::MAX - parts[part].count(), part));
    // The parts chosen, each with what is covered with it and the candidates that may replace it.
    let mut chosen: Vec<(usize, Iterations, Vec<usize>)> = Vec::new();
    let mut failed = HashSet::new();
    let mut covered = Iterations::default();
    for _ in 0..MOST_STEPS {
        let Some(next) = all.without(&covered).ranges().next().map(|range| range.start) else {
            let mut found: Vec<usize> = chosen.iter().map(|(part, ..)| *part).collect();
            found.sort_unstable();
            return Ok(found);
        };
        let fits = |part: &usize| {
            let ours = &parts[*part];
            ours.first_missing(&(next..next + 1)).is_none() && ours.common(&covered).is_empty()
        };
        // The best last, from where they are taken.
        let mut candidates: Vec<usize> = if failed.contains(&covered) {
            Vec::new()
        } else {
            order.iter().copied().filter(fits).rev().collect()
        };
        while candidates.is_empty() {
            failed.insert(covered);
            let Some((part, with, others)) = chosen.pop() else { return Err(conflict(parts)) };
            (covered, candidates) = (with.without(&parts[part]), others);
        }
        if let Some(part) = candidates.pop() {
            covered = covered.with(&parts[part]);
            chosen.push((part, covered.clone(), candidates));
        }
    }
    Err(conflict(parts))
}

/// The first two parts that overlap, and are not the same.
fn conflict(parts: &[Iterations]) -> Conflict {
    let pairs = (0..parts.len()).flat_map(|a| (a + 1..parts.len()).map(move |b| [a, b]));
    let overlap = |[a, b]: [usize; 2]| {
        let common = parts[a].common(&parts[b]);
        let is_partial = !common.is_empty() && common != parts[a] && common != parts[b];
        is_partial.then_some(Conflict { parts: [a, b], common })
    };
    let nested = |[a, b]: [usize; 2]| {
        let common = parts[a].common(&parts[b]);
        (!common.is_empty()).then_some(Conflict { parts: [a, b], common })
    };
    let found = pairs.clone().find_map(overlap).or_else(|| pairs.clone().find_map(nested));
    found.unwrap_or(Conflict { parts: [0, 0], common: Iterations::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets(ranges: &[&[[u32; 2]]]) -> Vec<Iterations> {
        let set = |ranges: &&[[u32; 2]]| {
            ranges.iter().fold(Iterations::default(), |all, [start, end]| all.with(&(*start..*end).into()))
        };
        ranges.iter().map(set).collect()
    }

    fn cover_of(ranges: &[&[[u32; 2]]]) -> Result<Vec<usize>, Conflict> {
        cover(&sets(ranges))
    }

    #[test]
    fn each_iteration_is_taken_once() {
        assert_eq!(cover_of(&[&[[0, 4]], &[[4, 8]]]), Ok(vec![0, 1]));
        assert_eq!(cover_of(&[&[[4, 8]], &[[0, 4]], &[[4, 8]], &[[0, 4]]]), Ok(vec![0, 1]));
        // A whole instead of its parts.
        assert_eq!(cover_of(&[&[[0, 2]], &[[0, 6]], &[[2, 6]], &[[9, 10]]]), Ok(vec![1, 3]));
        // The largest does not fit: the smaller ones do.
        assert_eq!(cover_of(&[&[[2, 9]], &[[0, 5]], &[[5, 9]], &[[9, 10]]]), Ok(vec![1, 2, 3]));
        // Merged files with gaps.
        assert_eq!(cover_of(&[&[[0, 2], [4, 6]], &[[2, 4]], &[[0, 4]], &[[4, 6]]]), Ok(vec![0, 1]));
        // The larger of two, though by one of many.
        assert_eq!(cover_of(&[&[[0, 100_000]], &[[100_000, 100_001]], &[[0, 100_001]]]), Ok(vec![2]));
        assert_eq!(cover_of(&[]), Ok(vec![]));
    }

    #[test]
    fn a_choice_that_leads_nowhere_is_taken_back() {
        // The largest with iteration 0 is the first, after which 6..8 is in no part that fits.
        assert_eq!(cover_of(&[&[[0, 6]], &[[0, 3]], &[[3, 8]]]), Ok(vec![1, 2]));
    }

    #[test]
    fn overlaps_that_no_choice_resolves_are_named() {
        let conflict = cover_of(&[&[[8, 9]], &[[0, 5]], &[[3, 8]]]).unwrap_err();
        assert_eq!(conflict, Conflict { parts: [1, 2], common: (3..5).into() });
    }

    /// Against all choices, for random parts of eight iterations.
    #[test]
    fn a_choice_is_found_if_there_is_one() {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 16
        };
        let (mut found, mut none) = (0, 0);
        for _ in 0..2000 {
            let bits: Vec<u32> = (0..6).map(|_| random() % 256).filter(|bits| *bits > 0).collect();
            let set = |bits: &u32| {
                (0..8)
                    .filter(|k| bits >> k & 1 == 1)
                    .fold(Iterations::default(), |all, k| all.with(&(k..k + 1).into()))
            };
            let parts: Vec<Iterations> = bits.iter().map(set).collect();
            let all = bits.iter().fold(0, |all, bits| all | bits);
            let is_cover = |choice: u32| {
                let chosen = (0..bits.len()).filter(|k| choice >> k & 1 == 1).map(|k| bits[k]);
                chosen.clone().sum::<u32>() == all && chosen.fold(0, |all, bits| all | bits) == all
            };
            let there_is = (0..1 << bits.len()).any(is_cover);
            let choice = cover(&parts);
            assert_eq!(choice.is_ok(), there_is, "{bits:?}");
            if let Ok(choice) = choice {
                assert!(is_cover(choice.iter().fold(0, |all, k| all | 1 << k)), "{bits:?}: {choice:?}");
                found += 1;
            } else {
                none += 1;
            }
        }
        assert!(found > 100 && none > 100, "{found} with and {none} without");
    }

    #[test]
    fn many_parts_take_little_time() {
        let parts: Vec<Iterations> = (0..3000_u32).rev().map(|k| (4 * k..4 * k + 4).into()).collect();
        assert_eq!(cover(&parts).unwrap().len(), 3000);
    }

    /// Two that overlap in part come before one that holds another, and the first of them before others.
    #[test]
    fn the_first_two_that_overlap_in_part_are_named() {
        let set = |start: u32, end: u32| Iterations::from(start..end);
        let of = |parts: &[Iterations]| {
            let Conflict { parts, common } = conflict(parts);
            (parts, common)
        };
        let (outer, inner, partial) = (set(0, 9), set(2, 4), set(3, 12));
        assert_eq!(of(&[outer.clone(), inner.clone()]), ([0, 1], set(2, 4)));
        assert_eq!(of(&[set(20, 30), outer.clone(), inner.clone()]), ([1, 2], set(2, 4)));
        assert_eq!(of(&[outer.clone(), inner.clone(), partial.clone()]), ([0, 2], set(3, 9)));
        assert_eq!(of(&[inner.clone(), set(20, 30), partial.clone()]), ([0, 2], set(3, 4)));
        assert_eq!(of(&[inner.clone(), set(20, 30), inner.clone()]), ([0, 2], set(2, 4)));
        assert_eq!(of(&[outer, set(20, 30)]), ([0, 0], Iterations::default()));
    }
}
