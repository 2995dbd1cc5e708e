//! What is to be timed: scenes, and the values of a sweep.

use super::args::{LadderArgs, Sweep};
use crate::args::scene::open;
use crate::terminal::error::Error;
use files::named::Opened;
use scene::still::Role;
use scene::{Scene, Settings, Sphere};

/// One render that every row does.
pub(crate) struct Case {
    /// The scene's name on the command line.
    pub name: String,
    pub scene: Scene,
    pub settings: Settings,
    /// The value of what is varied.
    pub value: u64,
}

/// The scenes of the paper.
const SCENES: [&str; 5] = ["cornell", "large", "mirror", "random", "surgery"];

/// What `--quick` means for settings that are not given.
pub(crate) const QUICK: Settings = Settings {
    width: 128,
    height: 96,
    iterations: 2,
    photons_per_iteration: 20_000,
    max_depth: 5,
    initial_radius: 2.0,
    seed: 1,
};

/// All cases, scene by scene.
pub(crate) fn cases(args: &LadderArgs) -> Result<Vec<Case>, Error> {
    let mut names = args.scene.clone();
    if names.is_empty() {
        let wanted = if args.quick { &SCENES[..1] } else { &SCENES[..] };
        names = wanted.iter().map(Into::into).collect();
    }
    let mut all = Vec::new();
    for name in names {
        let mut opened = open(&name)?;
        if args.quick {
            opened.scene.settings = Settings { seed: opened.scene.settings.seed, ..QUICK };
        }
        let settings = args.settings.apply(&opened.scene.settings)?;
        all.extend(values(args, opened, settings)?);
    }
    Ok(all)
}

/// The cases of one scene.
fn values(args: &LadderArgs, opened: Opened, settings: Settings) -> Result<Vec<Case>, Error> {
    let Opened { scene, stem, .. } = opened;
    let name = stem.to_string_lossy().into_owned();
    let case = |scene: &Scene, settings: Settings, value: u64| {
        settings.validate().map_err(|error| Error::BadInput(format!("--sweep: {error}")))?;
        Ok(Case { name: name.clone(), scene: scene.clone(), settings, value })
    };
    let pick = |full: &[u32], quick: &[u32]| if args.quick { quick.to_vec() } else { full.to_vec() };
    match args.sweep {
        None => Ok(vec![case(&scene, settings, 0)?]),
        Some(Sweep::Iterations) => pick(&[2, 4, 8, 16, 32, 64], &[1, 2, 4])
            .into_iter()
            .map(|iterations| case(&scene, Settings { iterations, ..settings }, iterations.into()))
            .collect(),
        Some(Sweep::Photons) => {
            pick(&[12_500, 25_000, 50_000, 100_000, 200_000, 400_000, 800_000], &[5_000, 10_000, 20_000])
                .into_iter()
                .map(|photons| {
                    case(&scene, Settings { photons_per_iteration: photons, ..settings }, photons.into())
                })
                .collect()
        }
        Some(Sweep::Size) => pick(&[32, 64, 128, 256, 512, 1024], &[32, 64, 128])
            .into_iter()
            .map(|width| {
                let height = width / 4 * 3;
                case(&scene, Settings { width, height, ..settings }, u64::from(width) * u64::from(height))
            })
            .collect(),
        Some(Sweep::Depth) => pick(&[1, 2, 3, 4, 5, 6, 8, 10], &[1, 3, 5])
            .into_iter()
            .map(|depth| case(&scene, Settings { max_depth: depth, ..settings }, depth.into()))
            .collect(),
        Some(Sweep::Spheres) => thinned(&scene)
            .ok_or_else(|| {
                let too_few = format!("--sweep spheres: {name} has too few balls to leave some out");
                Error::BadInput(format!("{too_few}; random has enough"))
            })?
            .iter()
            .map(|scene| case(scene, settings, scene.spheres.len() as u64))
            .collect(),
    }
}

/// The scene with an eighth, a quarter, half and all of its balls; walls and lamps stay. `None` if it has less than
/// eight balls.
fn thinned(scene: &Scene) -> Option<Vec<Scene>> {
    let still = scene.at(scene.camera.shutter[0]);
    let is_ball =
        |(sphere, role): (&Sphere, &Role)| !sphere.is_emitter() && !matches!(role, Role::Enclosure(_));
    let balls: Vec<bool> = scene.spheres.iter().zip(&still.roles).map(is_ball).collect();
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
}
