//! Measures a candidate: renders with it and with the defaults in turns, and compares the times.

use crate::candidate::Candidate;
use crate::error::Error;
use crate::ratios::Ratios;
use compare::differing_pixels;
use rayon::ThreadPool;
use scene::{Engine, Film, Scene, Settings, Stop};
use std::time::Instant;

/// Times renders of one scene, and checks their images.
pub(crate) struct Stopwatch<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    pool: &'a ThreadPool,
    defaults: Candidate,
    /// The image of the defaults, which every candidate must reproduce.
    image: Film,
    stop: &'a Stop,
}

impl<'a> Stopwatch<'a> {
    /// Renders once with the defaults to obtain the image; `None` if stopped.
    pub(crate) fn new(
        scene: &'a Scene,
        settings: &'a Settings,
        pool: &'a ThreadPool,
        defaults: Candidate,
        stop: &'a Stop,
    ) -> Option<Self> {
        let mut stopwatch = Self { scene, settings, pool, defaults, image: Film::new(0, 0), stop };
        stopwatch.image = stopwatch.render(defaults)?.1;
        Some(stopwatch)
    }

    /// Whether a stop was requested.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_requested()
    }

    /// Seconds from the start to the developed image, and the image; `None` if stopped.
    fn render(&self, candidate: Candidate) -> Option<(f64, Film)> {
        let Candidate { lanes, parameters } = candidate;
        self.pool.install(|| {
            let began = Instant::now();
            let mut engine = fast::Sppm::with_parameters(self.scene, self.settings, lanes, &parameters);
            for _ in 0..self.settings.iterations {
                if !engine.iterate_unless(self.stop) {
                    return None;
                }
            }
            let image = engine.develop();
            Some((began.elapsed().as_secs_f64(), image))
        })
    }

    /// The seconds of [`Self::render`]. It is an error if the image differs from that of the defaults in any bit.
    fn seconds(&self, candidate: Candidate) -> Result<Option<f64>, Error> {
        let Some((seconds, image)) = self.render(candidate) else { return Ok(None) };
        if differing_pixels(&image, &self.image).is_ok_and(|pixels| pixels.is_empty()) {
            return Ok(Some(seconds));
        }
        let profile = candidate.profile().to_text().replace('\n', ", ");
        Err(Error::Failed(format!("another image by other free parameters, a fault of sppm: {profile}")))
    }

    /// The ratios of `pairs` pairs of renders; `None` if stopped.
    pub(crate) fn ratios(&self, candidate: Candidate, pairs: u32) -> Result<Option<Ratios>, Error> {
        let seconds = |side| match side {
            Side::Defaults => self.seconds(self.defaults),
            Side::Candidate => self.seconds(candidate),
        };
        Ok(in_turns(pairs, seconds)?.map(Ratios::new))
    }
}

/// What is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Defaults,
    Candidate,
}

/// The seconds of the candidate over those of the defaults, for each of `pairs` pairs; `None` once there is no time. The
/// defaults come first in every other pair, as the first of a pair may always be slower.
fn in_turns(
    pairs: u32,
    mut seconds: impl FnMut(Side) -> Result<Option<f64>, Error>,
) -> Result<Option<Vec<f64>>, Error> {
    let mut ratios = Vec::new();
    for pair in 0..pairs {
        let is_reversed = pair % 2 == 1;
        let [first, second] =
            if is_reversed { [Side::Candidate, Side::Defaults] } else { [Side::Defaults, Side::Candidate] };
        let (Some(first), Some(second)) = (seconds(first)?, seconds(second)?) else { return Ok(None) };
        ratios.push(if is_reversed { first / second } else { second / first });
    }
    Ok(Some(ratios))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fast::{LaneKind, Parameters};

    #[test]
    fn renders_are_in_turns_and_alike() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings =
            Settings { width: 16, height: 12, iterations: 1, photons_per_iteration: 200, ..scene.settings };
        let pool = render::pool(Some(1)).unwrap();
        let defaults = Candidate { lanes: LaneKind::best(), parameters: Parameters::default() };
        let stop = Stop::new();
        let stopwatch = Stopwatch::new(&scene, &settings, &pool, defaults, &stop).unwrap();
        let other = Candidate { parameters: defaults.parameters.with("cell_size", 4.0).unwrap(), ..defaults };
        let ratios = stopwatch.ratios(other, 3).unwrap().unwrap();
        assert!(ratios.count() == 3 && ratios.median() > 0.0);
        stop.request();
        assert_eq!(stopwatch.ratios(other, 3).unwrap(), None);
        assert!(!differing_pixels(&stopwatch.image, &Film::new(16, 12)).unwrap().is_empty());
    }

    #[test]
    fn ratios_are_of_the_candidate_whichever_comes_first() {
        let mut asked = Vec::new();
        let ratios = in_turns(3, |side| {
            asked.push(side);
            Ok(Some(if side == Side::Defaults { 2.0 } else { 3.0 }))
        });
        assert_eq!(ratios.unwrap(), Some(vec![1.5; 3]));
        let [defaults, candidate] = [Side::Defaults, Side::Candidate];
        assert_eq!(asked, [defaults, candidate, candidate, defaults, defaults, candidate]);
        assert_eq!(in_turns(3, |_| Ok(None)).unwrap(), None);
    }
}
