//! The search space: a dimension for each free parameter that can matter, and the mapping from points to candidates.

use crate::candidate::Candidate;
use crate::error::Error;
use fast::{LaneKind, Parameters, Search, Values};
use render::LanesName;
use serde::Serialize;
use serde_json::Value;

/// The largest number of balls for which testing them one by one is tried. With more, a single render takes too long.
const MOST_IN_TURN: usize = 512;
/// The parameters that limit the number of balls for each search method.
const IN_TURN: &str = "most_balls_in_turn";
const IN_CLUSTERS: &str = "most_balls_in_clusters";

/// A dimension, as sent to the optimiser.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Dimension {
    pub(crate) name: &'static str,
    #[serde(flatten)]
    pub(crate) kind: Kind,
}

/// The kind of coordinates of a dimension.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub(crate) enum Kind {
    /// Numbers on a logarithmic scale.
    Real { least: f64, most: f64 },
    /// Powers of two, by their exponents.
    Whole { least: i32, most: i32 },
    /// One of a few names.
    Choice { choices: Vec<&'static str> },
}

/// The dimensions, for one scene on one machine.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    pub(crate) dimensions: Vec<Dimension>,
    balls: usize,
    /// The lanes of the defaults.
    lanes: LaneKind,
}

impl Space {
    /// The space for a scene with this number of `balls`. On one thread the sizes of jobs are left out, as they do not
    /// matter. Lanes are a dimension unless they are `asked` for.
    pub(crate) fn new(balls: usize, threads: usize, asked: Option<LaneKind>) -> Self {
        let is_job = |name: &str| name.ends_with("_per_job");
        let is_number = |name: &str| name != IN_TURN && name != IN_CLUSTERS && (threads > 1 || !is_job(name));
        let numbers = Parameters::ALL.iter().filter(|parameter| is_number(parameter.name));
        let mut dimensions: Vec<Dimension> = numbers
            .map(|parameter| {
                let (least, most) = (parameter.least, parameter.most);
                let kind = match parameter.values {
                    Values::Any => Kind::Real { least, most },
                    Values::Whole | Values::PowersOfTwo => {
                        Kind::Whole { least: least.log2() as i32, most: most.log2() as i32 }
                    }
                };
                Dimension { name: parameter.name, kind }
            })
            .collect();
        let mut choose = |name, choices: Vec<&'static str>| {
            if choices.len() > 1 {
                dimensions.push(Dimension { name, kind: Kind::Choice { choices } });
            }
        };
        choose("search", searches(balls).map(search_name).collect());
        let wide = LaneKind::ALL.into_iter().filter(|lanes| *lanes != LaneKind::Emulated);
        let lanes = wide.filter(|lanes| asked.is_none() && lanes.is_available());
        choose("lanes", lanes.map(|lanes| LanesName::from(lanes).name()).collect());
        Self { dimensions, balls, lanes: asked.unwrap_or_else(LaneKind::best) }
    }

    /// The defaults.
    pub(crate) fn defaults(&self) -> Candidate {
        Candidate { lanes: self.lanes, parameters: Parameters::default() }
    }

    /// The point of the defaults.
    pub(crate) fn start(&self) -> Vec<Value> {
        let usual = self.defaults();
        let of = |name: &str| {
            let place = Parameters::ALL.iter().position(|parameter| parameter.name == name);
            place.map(|place| usual.parameters.values()[place])
        };
        let coordinate = |dimension: &Dimension| match (&dimension.kind, of(dimension.name)) {
            (Kind::Real { .. }, Some(value)) => value.into(),
            (Kind::Whole { .. }, Some(value)) => (value.log2() as i32).into(),
            _ if dimension.name == "search" => search_name(usual.parameters.search(self.balls)).into(),
            _ => LanesName::from(usual.lanes).name().into(),
        };
        self.dimensions.iter().map(coordinate).collect()
    }

    /// The candidate at a point that the optimiser proposes.
    ///
    /// # Errors
    /// If the point is not in the space.
    pub(crate) fn candidate(&self, point: &[Value]) -> Result<Candidate, Error> {
        let mut candidate = self.defaults();
        let fault = |what: String| Error::Failed(format!("the optimiser proposed what cannot be: {what}"));
        if point.len() != self.dimensions.len() {
            return Err(fault(format!("{} coordinates", point.len())));
        }
        for (Dimension { name, kind }, coordinate) in self.dimensions.iter().zip(point) {
            let wrong = || fault(format!("{name} {coordinate}"));
            if let Kind::Choice { choices } = kind {
                let word = coordinate.as_str().filter(|word| choices.contains(word)).ok_or_else(wrong)?;
                if *name == "search" {
                    candidate.parameters = self.searched(candidate.parameters, word).ok_or_else(wrong)?;
                } else {
                    let named = |lanes: &LaneKind| LanesName::from(*lanes).name() == word;
                    candidate.lanes = LaneKind::ALL.into_iter().find(named).ok_or_else(wrong)?;
                }
                continue;
            }
            let number = coordinate.as_f64().ok_or_else(wrong)?;
            let value = if matches!(kind, Kind::Real { .. }) { rounded(number) } else { number.exp2() };
            candidate.parameters = candidate.parameters.with(name, value).map_err(|_| wrong())?;
        }
        Ok(candidate)
    }

    /// `parameters` with limits such that this scene's balls are searched by the method `word`. For other numbers of
    /// balls the default limits stay where possible.
    fn searched(&self, parameters: Parameters, word: &str) -> Option<Parameters> {
        let (usual_in_turn, usual_in_clusters) = (12, 1024);
        let fewer = self.balls.saturating_sub(1);
        let (in_turn, in_clusters) = match searches(self.balls).find(|search| search_name(*search) == word)? {
            Search::InTurn => (self.balls.max(usual_in_turn), usual_in_clusters),
            Search::Clusters => (fewer.min(usual_in_turn), self.balls.max(usual_in_clusters)),
            Search::Tree => (fewer.min(usual_in_turn), fewer.min(usual_in_clusters)),
        };
        let limited = parameters.with(IN_TURN, in_turn as f64);
        limited.and_then(|limited| limited.with(IN_CLUSTERS, in_clusters as f64)).ok()
    }
}

/// The search methods worth trying for this number of balls.
fn searches(balls: usize) -> impl Iterator<Item = Search> {
    let most = Parameters::ALL.iter().find(|parameter| parameter.name == IN_CLUSTERS).map_or(0.0, |p| p.most);
    [Search::InTurn, Search::Clusters, Search::Tree].into_iter().filter(move |search| match search {
        Search::InTurn => balls <= MOST_IN_TURN,
        Search::Clusters => (1..=most as usize).contains(&balls),
        Search::Tree => balls > 0,
    })
}

fn search_name(search: Search) -> &'static str {
    match search {
        Search::InTurn => "in_turn",
        Search::Clusters => "clusters",
        Search::Tree => "tree",
    }
}

/// Rounds to three digits; more would have no measurable effect.
fn rounded(value: f64) -> f64 {
    let digits = 10_f64.powf(2.0 - value.abs().log10().floor());
    (value * digits).round() / digits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_start_stands_for_the_defaults() {
        for balls in [0, 1, 2, 12, 13, 172, 513, 1024, 1025, 5000] {
            for threads in [1, 2] {
                let space = Space::new(balls, threads, None);
                let start = space.candidate(&space.start()).unwrap();
                assert_eq!(start.lanes, LaneKind::best());
                let of = |c: Candidate| (c.parameters.search(balls), c.parameters.values()[..9].to_vec());
                assert_eq!(of(start), of(space.defaults()), "{balls} balls");
            }
        }
    }

    #[test]
    fn every_search_is_what_it_says() {
        for balls in [1, 12, 13, 172, 1025] {
            let space = Space::new(balls, 1, Some(LaneKind::Emulated));
            for search in searches(balls) {
                let parameters = space.searched(Parameters::default(), search_name(search)).unwrap();
                assert_eq!(parameters.search(balls), search, "{balls} balls");
            }
        }
        assert_eq!(searches(0).collect::<Vec<_>>(), [Search::InTurn]);
        assert_eq!(searches(10_000).collect::<Vec<_>>(), [Search::Tree]);
    }

    /// A profile is used for other scenes too, in which nothing is known to be faster than the defaults.
    #[test]
    fn other_numbers_of_balls_are_searched_as_by_default_where_possible() {
        let searches_of = |parameters: Parameters, balls: &[usize]| -> Vec<Search> {
            balls.iter().map(|balls| parameters.search(*balls)).collect()
        };
        for (balls, search, others) in [
            (6, Search::InTurn, [12, 13, 1024, 1025].as_slice()),
            (172, Search::InTurn, &[1, 12, 173, 1024, 1025]),
            (172, Search::Clusters, &[1, 12, 13, 171, 173, 1024, 1025]),
            (1100, Search::Clusters, &[1, 12, 13, 1024, 1101]),
            (172, Search::Tree, &[1, 12, 13, 171, 1025]),
            (1100, Search::Tree, &[1, 12, 13, 1024, 1025]),
        ] {
            let space = Space::new(balls, 1, Some(LaneKind::Emulated));
            let tuned = space.searched(Parameters::default(), search_name(search)).unwrap();
            let usual = searches_of(Parameters::default(), others);
            assert_eq!(searches_of(tuned, others), usual, "{balls} balls by {search:?}");
        }
    }

    #[test]
    fn jobs_and_lanes_are_searched_where_they_matter() {
        let names = |space: &Space| -> Vec<_> { space.dimensions.iter().map(|d| d.name).collect() };
        let one = Space::new(0, 1, Some(LaneKind::Emulated));
        assert!(
            !names(&one)
                .iter()
                .any(|name| name.ends_with("_per_job") || *name == "lanes" || *name == "search")
        );
        let two = Space::new(172, 2, Some(LaneKind::Emulated));
        assert!(
            ["pixels_per_job", "photons_per_job", "search"].iter().all(|name| names(&two).contains(name))
        );
    }

    #[test]
    fn coordinates_become_values() {
        let space = Space::new(172, 1, Some(LaneKind::Emulated));
        let mut point = space.start();
        point[0] = 4.234_567.into();
        point[2] = (-2).into();
        *point.last_mut().unwrap() = "tree".into();
        let candidate = space.candidate(&point).unwrap();
        let usual = Parameters::default().with("cell_size", 4.23).unwrap();
        let expected = usual.with("buckets_per_photon", 0.25).unwrap().with(IN_CLUSTERS, 171.0).unwrap();
        assert_eq!(candidate, Candidate { lanes: LaneKind::Emulated, parameters: expected });
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let space = Space::new(172, 1, Some(LaneKind::Emulated));
        let mut point = space.start();
        point[0] = 99.0.into();
        assert!(space.candidate(&point).is_err());
        assert!(space.candidate(&point[1..]).is_err());
    }
}
