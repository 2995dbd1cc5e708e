//! Bounds the memory of a render before it starts, and rejects renders that need too much.

use crate::backdrop::settings_behind;
use crate::choice::EngineChoice;
use crate::error::{Error, Field};
use crate::names::{EngineName, MethodName};
use scene::aim::survey;
use scene::clearance;
use scene::text::mebibytes;
use scene::{Scene, Settings};

/// Memory of the process itself, with its libraries.
const BYTES_OF_PROCESS: u64 = 16 << 20;
/// Memory per column and thread while an image is written. EXR has blocks of 16 rows, each in memory as pixels, as
/// channels, and compressed.
const BYTES_PER_WRITTEN_COLUMN: u64 = 1 << 10;
/// Memory per pixel for the estimate of the error: the earlier image and the current one.
const BYTES_PER_PAST_PIXEL: u64 = 24;
/// Memory per pixel of the reference: 156 for sums, visible points and what these gather; and while its grid is built, for
/// each of about eight entries, 20 as they are collected, 10 to sort them and 16 as they are kept. The rest is reserve.
const BYTES_PER_REFERENCE_PIXEL: u64 = 512;
/// Memory per pixel of the reference's path tracer: sums and samples.
const BYTES_PER_TRACED_PIXEL: u64 = 36;
/// Memory per sphere: in the scene, and in the still.
const BYTES_PER_SPHERE: u64 = 64;
/// Memory per sphere of a scene in which something moves, in addition: where it is at one instant.
const BYTES_PER_MOVED_SPHERE: u64 = 64;
/// Memory per lamp, in addition: what is found out about its light, the tree of lamps, and an engine's tables of both.
const BYTES_PER_LAMP: u64 = 448;
/// Memory per material.
const BYTES_PER_MATERIAL: u64 = 64;
/// Deposits of a photon that there is room for: the Cornell box has 2 at a depth of 16, other scenes fewer. Where there are
/// more, photons take several rounds.
const DEPOSITS_PER_PHOTON: u32 = 3;
/// Least number of deposits to hold at a time, if memory is not limited.
const USUAL_DEPOSITS: u32 = 1 << 18;
/// Least number of deposits to hold at a time.
const FEWEST_DEPOSITS: u32 = 1 << 16;

/// The memory that a render needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Need {
    /// Upper bound in bytes.
    pub bytes: u64,
    /// Deposits held at a time, on which the bound depends.
    pub deposits: u32,
}

impl Need {
    /// The memory that a render needs. Holds fewer deposits at a time if that is necessary to stay within `limit`.
    /// `has_past` says that the error is estimated, for which an earlier image is kept.
    ///
    /// # Errors
    /// If the limit is too low even with the fewest deposits, or if the system cannot provide the memory.
    pub(crate) fn new(
        engine: EngineChoice,
        scene: &Scene,
        threads: usize,
        has_past: bool,
        limit: Option<u64>,
    ) -> Result<Self, Error> {
        let with = |deposits| Self { bytes: bytes(engine, scene, threads, has_past, deposits), deposits };
        let usual = scene.settings.photons_per_iteration.saturating_mul(DEPOSITS_PER_PHOTON);
        let all = with(usual.clamp(USUAL_DEPOSITS, fast::DEPOSITS_AT_ONCE));
        let need = match limit {
            Some(limit) if all.bytes > limit => {
                let fewer = std::iter::successors(Some(all.deposits / 2), |deposits| Some(deposits / 2));
                let fewer = fewer.take_while(|&deposits| deposits > FEWEST_DEPOSITS);
                let mut fewer = fewer.chain([FEWEST_DEPOSITS]).map(with);
                fewer
                    .find(|need| need.bytes <= limit)
                    .ok_or_else(|| too_much(with(FEWEST_DEPOSITS).bytes, limit))?
            }
            _ => all,
        };
        need.ask_the_system()?;
        Ok(need)
    }

    /// The same after other work that took up to `before` bytes, and has freed them.
    pub(crate) fn after(self, before: u64) -> Self {
        Self { bytes: self.bytes.max(before + BYTES_OF_PROCESS), ..self }
    }

    /// Allocates the memory and frees it again. Without this check, a lack of memory would abort the process later.
    fn ask_the_system(self) -> Result<(), Error> {
        let granted =
            usize::try_from(self.bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
        if granted {
            return Ok(());
        }
        let need = mebibytes(self.bytes);
        Err(Error::failed(format!(
            "the render needs up to {need}, which the system refuses; ask for fewer pixels or photons"
        )))
    }
}

fn bytes(engine: EngineChoice, scene: &Scene, threads: usize, has_past: bool, deposits: u32) -> u64 {
    let (settings, spheres) = (&scene.settings, scene.spheres.len());
    let pixels = settings.pixels() as u64;
    let photons = |settings: &Settings| match engine.name() {
        EngineName::Fast => {
            fast::Sppm::bytes_at_most(settings, spheres, threads, deposits, engine.parameters())
        }
        EngineName::Reference => {
            let survey = survey::bytes_at_most(settings.photons_per_iteration, settings.max_depth);
            pixels * BYTES_PER_REFERENCE_PIXEL + survey + clearance::bytes_at_most(settings, spheres)
        }
    };
    let paths = |settings: &Settings| match engine.name() {
        EngineName::Fast => fast::PathTracer::bytes_at_most(settings, spheres, threads),
        EngineName::Reference => pixels * BYTES_PER_TRACED_PIXEL,
    };
    let of_engine = |settings: &Settings| match engine.method() {
        MethodName::Sppm => photons(settings),
        MethodName::Path => paths(settings),
        MethodName::Hybrid => photons(settings) + paths(settings),
    };
    let past = if has_past { BYTES_PER_PAST_PIXEL } else { 0 };
    let behind = if scene.transparent_background {
        of_engine(&settings_behind(settings)) + of_spheres(scene)
    } else {
        0
    };
    of_engine(settings)
        + behind
        + BYTES_OF_PROCESS
        + threads as u64 * u64::from(settings.width) * BYTES_PER_WRITTEN_COLUMN
        + pixels * past
        + bytes_of_scene(scene)
}

/// What a scene takes while it is rendered, besides what grows with its pixels and photons and the engine's tables.
pub(crate) fn bytes_of_scene(scene: &Scene) -> u64 {
    of_spheres(scene) + lamps(scene) * BYTES_PER_LAMP + scene.materials.len() as u64 * BYTES_PER_MATERIAL
}

/// How many spheres glow.
pub(crate) fn lamps(scene: &Scene) -> u64 {
    scene.spheres.iter().filter(|sphere| sphere.is_emitter()).count() as u64
}

fn of_spheres(scene: &Scene) -> u64 {
    scene.spheres.len() as u64 * (BYTES_PER_SPHERE + if scene.moves() { BYTES_PER_MOVED_SPHERE } else { 0 })
}

fn too_much(bytes: u64, limit: u64) -> Error {
    let (need, limit) = (mebibytes(bytes), mebibytes(limit));
    Error::named(
        Field::MemoryLimit,
        format_args!(
            "the render needs up to {need}, more than {limit}; raise the limit, or ask for fewer pixels"
        ),
    )
}

/// Checks that `bytes`, besides those of the process, are within `limit`.
///
/// # Errors
/// If they are not.
pub(crate) fn check_limit(bytes: u64, limit: Option<u64>) -> Result<(), Error> {
    let bytes = bytes + BYTES_OF_PROCESS;
    limit.filter(|limit| bytes > *limit).map_or(Ok(()), |limit| Err(too_much(bytes, limit)))
}

/// The peak memory of this process so far, where `/proc` provides it.
pub(crate) fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::Renderer;

    fn scene(settings: Settings) -> Scene {
        Scene { settings, ..files::builtin::scene("cornell").unwrap() }
    }

    fn fast(settings: Settings, limit: Option<u64>) -> Result<Need, Error> {
        Need::new(EngineChoice::new(EngineName::Fast, None).unwrap(), &scene(settings), 2, false, limit)
    }

    #[test]
    fn fewer_deposits_are_held_under_a_limit() {
        let settings =
            Settings { width: 64, height: 48, photons_per_iteration: 10_000_000, ..Settings::default() };
        let all = fast(settings, None).unwrap();
        assert_eq!(all.deposits, fast::DEPOSITS_AT_ONCE);
        let less = fast(settings, Some(all.bytes / 3)).unwrap();
        assert!(less.bytes <= all.bytes / 3 && less.deposits < all.deposits, "{less:?}");
        let line = fast(settings, Some(1 << 20)).unwrap_err().to_string();
        assert!(line.contains("more than 1.0 MiB") && line.contains("needs up to"), "{line}");
    }

    /// What is told to be needed is the least by which the render starts, and all that it needs is no more than its limit.
    #[test]
    fn the_memory_that_is_asked_for_is_enough() {
        let settings =
            Settings { width: 64, height: 48, photons_per_iteration: 10_000_000, ..Settings::default() };
        let all = fast(settings, None).unwrap();
        assert_eq!(fast(settings, Some(all.bytes)).unwrap(), all);
        let choice = EngineChoice::new(EngineName::Fast, None).unwrap();
        let least = bytes(choice, &scene(settings), 2, false, FEWEST_DEPOSITS);
        assert!(least < all.bytes / 2, "{least} of {}", all.bytes);
        assert_eq!(fast(settings, Some(least)).unwrap().bytes, least);
        // Also where halving does not end at the fewest.
        let odd = Settings { photons_per_iteration: 100_000, ..settings };
        let least_of_odd = bytes(choice, &scene(odd), 2, false, FEWEST_DEPOSITS);
        assert_eq!(fast(odd, Some(least_of_odd)).unwrap().deposits, FEWEST_DEPOSITS);
        let line = fast(settings, Some(least - 1)).unwrap_err().to_string();
        assert!(line.contains(&format!("needs up to {}, more than", mebibytes(least))), "{line}");
    }

    /// Three for each photon, within bounds.
    #[test]
    fn deposits_that_are_held_follow_the_photons() {
        let of = |photons_per_iteration| {
            let settings = Settings { width: 8, height: 6, photons_per_iteration, ..Settings::default() };
            fast(settings, None).unwrap().deposits
        };
        let found = [1, 1000, 500_000, 1_000_000, 2_000_000, 10_000_000].map(of);
        let most = fast::DEPOSITS_AT_ONCE;
        assert_eq!(found, [USUAL_DEPOSITS, USUAL_DEPOSITS, 1_500_000, 3_000_000, most, most]);
    }

    #[test]
    fn a_limit_is_kept_to_the_byte() {
        let limit = Some(BYTES_OF_PROCESS + 1000);
        assert!(check_limit(0, limit).is_ok() && check_limit(1000, limit).is_ok());
        assert!(check_limit(1001, limit).is_err() && check_limit(1 << 40, limit).is_err());
        assert!(check_limit(1 << 40, None).is_ok());
    }

    fn chosen(method: MethodName, engine: EngineName) -> EngineChoice {
        EngineChoice::new(Renderer { method, engine }, None).unwrap()
    }

    /// Every term is by itself: what one more of something takes does not depend on the rest.
    #[test]
    fn each_thing_takes_its_own_bytes() {
        let settings = Settings { width: 64, height: 32, ..Settings::default() };
        let (fast, reference) = (EngineName::Fast, EngineName::Reference);
        let pixels_of = |per_pixel: Option<u64>| per_pixel.unwrap_or(0) * 64 * 32;
        for (engine, per_pixel, of_spheres) in [
            (chosen(MethodName::Sppm, fast), None, 256),
            (chosen(MethodName::Path, fast), Some(BYTES_PER_TRACED_PIXEL), 256),
            (chosen(MethodName::Sppm, reference), Some(BYTES_PER_REFERENCE_PIXEL), 0),
            (chosen(MethodName::Path, reference), Some(BYTES_PER_TRACED_PIXEL), 0),
            (chosen(MethodName::Hybrid, fast), None, 2 * 256),
            (
                chosen(MethodName::Hybrid, reference),
                Some(BYTES_PER_REFERENCE_PIXEL + BYTES_PER_TRACED_PIXEL),
                0,
            ),
        ] {
            let base = scene(settings);
            let with = |scene: &Scene, threads, has_past| bytes(engine, scene, threads, has_past, 1 << 20);
            let more = |scene: &Scene| with(scene, 2, false) - with(&base, 2, false);
            let dark = base.spheres.iter().find(|sphere| !sphere.is_emitter()).unwrap();
            let lit = base.spheres.iter().find(|sphere| sphere.is_emitter()).unwrap();
            let mut one_more = base.clone();
            one_more.spheres.push(*dark);
            assert_eq!(more(&one_more), BYTES_PER_SPHERE + of_spheres);
            *one_more.spheres.last_mut().unwrap() = *lit;
            assert_eq!(more(&one_more), BYTES_PER_SPHERE + of_spheres + BYTES_PER_LAMP);
            one_more.spheres.last_mut().unwrap().velocity = scene::Vec3::X;
            let moved = one_more.spheres.len() as u64 * BYTES_PER_MOVED_SPHERE;
            assert_eq!(more(&one_more), BYTES_PER_SPHERE + of_spheres + BYTES_PER_LAMP + moved);
            let mut one_more = base.clone();
            one_more.materials.push(base.materials[0]);
            assert_eq!(more(&one_more), BYTES_PER_MATERIAL);
            let mut transparent = base.clone();
            transparent.transparent_background = true;
            let again = base.spheres.len() as u64 * (BYTES_PER_SPHERE + of_spheres) + pixels_of(per_pixel);
            assert!(more(&transparent) >= again, "{engine:?}");
            let past = with(&base, 2, true) - with(&base, 2, false);
            assert_eq!(past, BYTES_PER_PAST_PIXEL * 64 * 32);
            // A thread has rows to write, and in the fast engine what that says itself.
            let thread = with(&base, 3, false) - with(&base, 2, false);
            let rows = 64 * BYTES_PER_WRITTEN_COLUMN;
            assert!(if of_spheres == 0 { thread == rows } else { thread > rows + (1 << 18) }, "{thread}");
            if let Some(bytes) = per_pixel {
                let taller = scene(Settings { height: 64, ..settings });
                assert_eq!(more(&taller), bytes * 64 * 32);
            }
        }
        // The structures that these bytes are for.
        assert!(BYTES_PER_SPHERE as usize > size_of::<scene::Sphere>() + size_of::<scene::still::Role>());
        assert!(BYTES_PER_MOVED_SPHERE as usize > size_of::<scene::Sphere>());
        assert!(
            BYTES_PER_LAMP as usize
                > size_of::<scene::still::Light>() + size_of::<[scene::light_tree::LightNode; 2]>()
        );
        assert!(BYTES_PER_MATERIAL as usize > size_of::<scene::Material>());
        assert_eq!(BYTES_PER_PAST_PIXEL as usize, 2 * size_of::<scene::Rgb>());
    }

    /// Of the path tracer that is plain code it is known; photon mapping has the survey of its photons in addition.
    #[test]
    fn a_render_takes_the_sum_of_its_parts() {
        let scene = scene(Settings { width: 64, height: 32, ..Settings::default() });
        let of = |method| bytes(chosen(method, EngineName::Reference), &scene, 3, false, 1 << 20);
        let rows = 3 * 64 * BYTES_PER_WRITTEN_COLUMN;
        let rest = BYTES_OF_PROCESS + rows + bytes_of_scene(&scene);
        assert_eq!(of(MethodName::Path), 64 * 32 * BYTES_PER_TRACED_PIXEL + rest);
        let Settings { photons_per_iteration, max_depth, .. } = scene.settings;
        let survey = survey::bytes_at_most(photons_per_iteration, max_depth);
        assert!(survey > 0);
        assert_eq!(of(MethodName::Sppm), 64 * 32 * BYTES_PER_REFERENCE_PIXEL + survey + rest);
        let both = 64 * 32 * (BYTES_PER_REFERENCE_PIXEL + BYTES_PER_TRACED_PIXEL);
        assert_eq!(of(MethodName::Hybrid), both + survey + rest);
        // What is behind a scene whose background is transparent is rendered too.
        let clear = Scene { transparent_background: true, ..scene.clone() };
        let path = chosen(MethodName::Path, EngineName::Reference);
        let behind = 64 * 32 * BYTES_PER_TRACED_PIXEL + of_spheres(&scene);
        assert_eq!(bytes(path, &clear, 3, false, 1 << 20), of(MethodName::Path) + behind);
    }

    /// Settings are chosen by other renders, whose memory is free again when this one begins.
    #[test]
    fn what_came_before_counts_if_it_took_more() {
        let need = Need { bytes: 100 << 20, deposits: 7 };
        assert_eq!(need.after(0), need);
        assert_eq!(need.after((100 << 20) - BYTES_OF_PROCESS), need);
        assert_eq!(need.after(1 << 30), Need { bytes: (1 << 30) + BYTES_OF_PROCESS, ..need });
    }

    #[test]
    fn the_peak_does_not_fall_when_memory_is_freed() {
        let before = peak();
        assert!(before.is_some() || !cfg!(target_os = "linux"), "Linux tells the peak");
        let Some(before) = before else { return };
        let held = vec![1_u8; 64 << 20];
        assert!(held.iter().map(|byte| u64::from(*byte)).sum::<u64>() == 64 << 20);
        drop(held);
        assert!(peak().unwrap() >= before.max(64 << 20));
    }

    #[test]
    fn memory_that_the_system_cannot_provide_is_an_error() {
        let need = Need { bytes: u64::MAX / 4, deposits: 1 };
        let line = need.ask_the_system().unwrap_err().to_string();
        assert!(line.contains("which the system refuses"), "{line}");
    }
}
