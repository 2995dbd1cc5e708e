//! Sweeps: the parameter that is varied, and its values.

use super::case::Case;
use crate::error::{Error, Field};
use scene::still::Role;
use scene::{Scene, Settings, Sphere};
use serde::Serialize;

/// The parameter that a sweep varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sweep {
    /// Iterations.
    Iterations,
    /// Photons of an iteration.
    Photons,
    /// Pixels.
    Size,
    /// The largest number of segments of a path.
    Depth,
    /// Spheres: from a scene without most of its balls to the whole scene.
    Spheres,
}

impl Sweep {
    /// The name of the parameter in reports.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Iterations => "iterations",
            Self::Photons => "photons",
            Self::Size => "pixels",
            Self::Depth => "depth",
            Self::Spheres => "spheres",
        }
    }

    /// The cases of a scene, by increasing value. A quick sweep has fewer and smaller values.
    ///
    /// # Errors
    /// If the settings do not allow a value, or the scene has too few balls to leave some out.
    pub fn cases(
        self,
        name: &str,
        scene: &Scene,
        settings: Settings,
        is_quick: bool,
    ) -> Result<Vec<Case>, Error> {
        let cases = if self == Self::Spheres {
            let case = |scene: Scene| {
                let value = scene.spheres.len() as u64;
                Case { name: name.into(), scene, settings, value }
            };
            thinned(scene).ok_or_else(|| too_few_balls(name))?.into_iter().map(case).collect()
        } else {
            let case = |&value: &u32| {
                let (settings, value) = self.with(settings, value);
                Case { name: name.into(), scene: scene.clone(), settings, value }
            };
            self.values(is_quick).iter().map(case).collect::<Vec<_>>()
        };
        match cases.iter().find_map(|case| case.settings.validate().err()) {
            Some(error) => Err(Error::input(Field::Sweep, error.to_string())),
            None => Ok(cases),
        }
    }

    /// The values of a setting; for the size, the width. There are none for spheres, which are not a setting.
    fn values(self, is_quick: bool) -> &'static [u32] {
        match (self, is_quick) {
            (Self::Iterations, false) => &[2, 4, 8, 16, 32, 64],
            (Self::Iterations, true) => &[1, 2, 4],
            (Self::Photons, false) => &[12_500, 25_000, 50_000, 100_000, 200_000, 400_000, 800_000],
            (Self::Photons, true) => &[5_000, 10_000, 20_000],
            (Self::Size, false) => &[32, 64, 128, 256, 512, 1024],
            (Self::Size, true) => &[32, 64, 128],
            (Self::Depth, false) => &[1, 2, 3, 4, 5, 6, 8, 10],
            (Self::Depth, true) => &[1, 3, 5],
            (Self::Spheres, _) => &[],
        }
    }

    /// Settings with a value of [`Sweep::values`], and the value shown in tables.
    fn with(self, settings: Settings, value: u32) -> (Settings, u64) {
        let (width, height) = (value, value / 4 * 3);
        match self {
            Self::Iterations => (Settings { iterations: value, ..settings }, value.into()),
            Self::Photons => (Settings { photons_per_iteration: value, ..settings }, value.into()),
            Self::Size => (Settings { width, height, ..settings }, u64::from(width) * u64::from(height)),
            Self::Depth => (Settings { max_depth: value, ..settings }, value.into()),
            Self::Spheres => (settings, value.into()),
        }
    }
}

fn too_few_balls(name: &str) -> Error {
    let problem = format!("{name} has too few balls to leave some out; random has enough");
    Error::input(Field::SweepSpheres, problem)
}

/// The scene with an eighth, a quarter, half and all of its balls; walls and lamps always stay. `None` if it has fewer
/// than eight balls.
fn thinned(scene: &Scene) -> Option<Vec<Scene>> {
    let still = scene.at(scene.camera.shutter[0]);
    let is_ball =
        |(sphere, role): (&Sphere, &Role)| !sphere.is_emitter() && !matches!(role, Role::Enclosure(_));
    let balls: Vec<bool> = scene.spheres.iter().zip(still.roles.iter()).map(is_ball).collect();
    let all = balls.iter().filter(|is_ball| **is_ball).count();
    let keep = |share: usize| {
        let mut left = all / share;
        let stays = |is_ball: bool| {
            let stays = !is_ball || left > 0;
            left -= usize::from(is_ball && stays);
            stays
        };
        let flags: Vec<bool> = balls.iter().copied().map(stays).collect();
        let mut scene = scene.clone();
        let mut flags = flags.iter();
        scene.spheres.retain(|_| *flags.next().unwrap_or(&true));
        scene
    };
    (all >= 8).then(|| [8, 4, 2, 1].map(keep).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_left_out_and_walls_and_lamps_stay() {
        let scene = files::builtin::scene("random").unwrap();
        let thinned = thinned(&scene).unwrap();
        let counts: Vec<usize> = thinned.iter().map(|scene| scene.spheres.len()).collect();
        assert!(counts.windows(2).all(|pair| pair[0] < pair[1]), "{counts:?}");
        assert_eq!(thinned.last(), Some(&scene));
        let emitters = |scene: &Scene| scene.spheres.iter().filter(|s| s.is_emitter()).count();
        assert!(thinned.iter().all(|thin| emitters(thin) == emitters(&scene)));
    }

    /// An eighth, a quarter, half and all of them, rounded down.
    #[test]
    fn shares_of_the_balls_are_kept() {
        let scene = files::builtin::scene("random").unwrap();
        let counts: Vec<usize> = thinned(&scene).unwrap().iter().map(|thin| thin.spheres.len()).collect();
        let balls = 172; // as the list of scenes says
        let left_out = [8, 4, 2, 1].map(|share| balls - balls / share);
        assert_eq!(counts, left_out.map(|balls| scene.spheres.len() - balls));
    }

    /// And is called after it in tables and names of files.
    #[test]
    fn a_sweep_varies_its_setting_and_no_other() {
        let scene = files::builtin::scene("cornell").unwrap();
        let own = scene.settings;
        let of = |sweep: Sweep| sweep.cases("cornell", &scene, own, true).unwrap();
        let settings = |sweep| of(sweep).into_iter().map(|case| case.settings).collect::<Vec<_>>();
        let all =
            |with: fn(Settings, u32) -> Settings, values: [u32; 3]| values.map(|value| with(own, value));
        assert_eq!(
            settings(Sweep::Iterations),
            all(|own, iterations| Settings { iterations, ..own }, [1, 2, 4])
        );
        let photons = all(
            |own, photons_per_iteration| Settings { photons_per_iteration, ..own },
            [5_000, 10_000, 20_000],
        );
        assert_eq!(settings(Sweep::Photons), photons);
        assert_eq!(settings(Sweep::Depth), all(|own, max_depth| Settings { max_depth, ..own }, [1, 3, 5]));
        let sizes = all(|own, width| Settings { width, height: width * 3 / 4, ..own }, [32, 64, 128]);
        assert_eq!(settings(Sweep::Size), sizes);
        let named = [Sweep::Iterations, Sweep::Photons, Sweep::Size, Sweep::Depth, Sweep::Spheres];
        assert_eq!(named.map(Sweep::noun), ["iterations", "photons", "pixels", "depth", "spheres"]);
        assert!(of(Sweep::Depth).iter().all(|case| case.name == "cornell" && case.scene == scene));
    }

    /// A sweep does not begin if one of its renders cannot be.
    #[test]
    fn settings_that_cannot_be_are_refused_as_values_of_the_sweep() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { initial_radius: 0.0, ..scene.settings };
        let error = Sweep::Depth.cases("cornell", &scene, settings, true).unwrap_err();
        assert!(matches!(error, Error::Input { field: Field::Sweep, .. }), "{error}");
    }

    #[test]
    fn sizes_keep_the_shape_of_the_picture() {
        let scene = files::builtin::scene("cornell").unwrap();
        let cases = Sweep::Size.cases("cornell", &scene, scene.settings, true).unwrap();
        assert_eq!(cases.iter().map(|case| case.value).collect::<Vec<_>>(), [32 * 24, 64 * 48, 128 * 96]);
        assert!(cases.iter().all(|case| case.settings.pixels() as u64 == case.value));
    }

    #[test]
    fn a_scene_of_few_balls_is_refused() {
        let scene = files::builtin::scene("cornell").unwrap();
        let error = Sweep::Spheres.cases("cornell", &scene, scene.settings, true).unwrap_err();
        assert!(matches!(error, Error::Input { field: Field::SweepSpheres, .. }), "{error}");
    }
}
