//! Parts of a render, and what a file says that they were merged into.

use crate::small;
use fast::Sppm;
use files::checkpoint::Store;
use files::lock::Lock;
use render::merge::{Merge, part_of};
use render::{EngineChoice, EngineName, Every, Job, Made, Save};
use scene::{Engine, RadiusSchedule, Resumable, Scene, Settings, Stats};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A scene whose iterations are independent of each other.
fn global(iterations: u32) -> Scene {
    let scene = small(iterations);
    let settings = Settings { radius_schedule: RadiusSchedule::Global, ..scene.settings };
    Scene { settings, ..scene }
}

/// The checkpoint of the iterations `range` of a render of so many.
fn part(folder: &Path, range: Range<u32>, iterations: u32, engine: EngineName) -> PathBuf {
    let path = folder.join(format!("{}-{}.sppm", range.start, range.end));
    let mut job = Job::new(global(iterations));
    job.engine = EngineChoice::new(engine, None).unwrap();
    job.range = Some(range);
    kept(job, path)
}

/// The checkpoint `path` of a render.
fn kept(mut job: Job, path: PathBuf) -> PathBuf {
    job.save = Some(Save { path: path.clone(), every: Every::default(), keep: true });
    job.start(()).unwrap().wait().unwrap();
    path
}

fn stats_of(path: &Path) -> Stats {
    Store::new(path).load().unwrap().unwrap().checkpoint.account.stats
}

#[test]
fn parts_have_each_iteration_once_and_are_of_a_size() {
    for iterations in [1, 2, 5, 12, 13, 100, 1_000_003, u32::MAX] {
        for parts in 1..=7.min(iterations) {
            let all: Vec<Range<u32>> = (1..=parts).map(|k| part_of(iterations, k, parts).unwrap()).collect();
            assert_eq!((all[0].start, all[all.len() - 1].end), (0, iterations), "{all:?}");
            assert!(all.windows(2).all(|pair| pair[0].end == pair[1].start), "{all:?}");
            let sizes = all.iter().map(|range| range.end - range.start);
            assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1, "{all:?}");
        }
        assert!(part_of(iterations, 0, 3).is_err() && part_of(iterations, 4, 3).is_err());
    }
}

/// Whatever their order: the most iterations that were asked for, the radius and the next iteration after the last one that is
/// there, and the sum of what was counted.
#[test]
fn a_merge_has_what_follows_from_all_of_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (0..2, 5..6);
    let parts =
        [part(folder.path(), first, 9, EngineName::Fast), part(folder.path(), second, 12, EngineName::Fast)];
    let [a, b] = [0, 1].map(|k| stats_of(&parts[k]));
    for files in [[parts[0].clone(), parts[1].clone()], [parts[1].clone(), parts[0].clone()]] {
        let merge = Merge::open(&files).unwrap();
        assert_eq!(merge.scene().settings.iterations, 12);
        assert_eq!(merge.missing().ranges().collect::<Vec<_>>(), [2..5, 6..12]);
        let sum = merge.add_up().unwrap();
        assert_eq!((sum.iterations(), sum.progress().next), (3, 6));
        let mut engine = Sppm::new(merge.scene(), &merge.scene().settings);
        engine.skip_to(6);
        assert_eq!(sum.probe(3, 4).radius, engine.probe(3, 4).radius);
        let out = folder.path().join("all.sppm");
        merge.write(&out).unwrap();
        let all = stats_of(&out);
        assert_eq!(all.photons, 3 * u64::from(merge.scene().settings.photons_per_iteration));
        assert_eq!(all.photon_segments, a.photon_segments + b.photon_segments);
        assert_eq!(all.contributions, a.contributions + b.contributions);
        assert!(b.photon_segments > 0 && a.photon_segments > b.photon_segments);
        std::fs::remove_file(&out).unwrap();
    }
}

#[test]
fn a_merged_image_says_which_engine_rendered_its_parts() {
    let folder = tempfile::tempdir().unwrap();
    for engine in EngineName::ALL {
        let parts = [part(folder.path(), 0..1, 2, engine), part(folder.path(), 1..2, 2, engine)];
        let out = folder.path().join("merged.exr");
        Merge::open(&parts).unwrap().write(&out).unwrap();
        let Made::Image(made) = Made::read(&out).unwrap() else { panic!("no image") };
        assert_eq!(made.renderer.engine, engine);
        assert_eq!(made.photons, 2 * u64::from(made.settings.photons_per_iteration));
        // So does an image of what was merged to be merged again, or resumed.
        let again = folder.path().join("merged.sppm");
        Merge::open(&parts).unwrap().write(&again).unwrap();
        Merge::open(std::slice::from_ref(&again)).unwrap().write(&out).unwrap();
        let Made::Image(made) = Made::read(&out).unwrap() else { panic!("no image") };
        assert_eq!(made.renderer.engine, engine);
        for file in parts.iter().chain([&out, &again]) {
            std::fs::remove_file(file).unwrap();
        }
    }
}

/// Image or checkpoint: what is merged is written to no file that another render is about to replace.
#[test]
fn a_merge_writes_no_file_of_another_render() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [0..1, 1..2].map(|range| part(folder.path(), range, 2, EngineName::Fast));
    for name in ["merged.pfm", "merged.sppm"] {
        let out = folder.path().join(name);
        let lock = Lock::take(&out).unwrap();
        let refused = Merge::open(&parts).unwrap().write(&out).unwrap_err().to_string();
        assert!(refused.contains(&format!("{name}: is in use by another render")), "{refused}");
        assert!(!out.exists());
        drop(lock);
        Merge::open(&parts).unwrap().write(&out).unwrap();
        assert!(out.is_file());
    }
}

/// A merge replaces a checkpoint only if it holds all that is in it.
#[test]
fn a_merge_loses_no_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [0..1, 1..2, 2..3].map(|range| part(folder.path(), range, 3, EngineName::Fast));
    let out = folder.path().join("merged.sppm");
    let merge = |parts: &[PathBuf]| Merge::open(parts).unwrap().write(&out);
    merge(&parts[..2]).unwrap();
    merge(&parts[..2]).unwrap();
    merge(&parts).unwrap();
    let all = std::fs::read(&out).unwrap();
    let refused = merge(&parts[..2]).unwrap_err().to_string();
    assert!(refused.contains("merged.sppm holds the iterations 2..3, which are in no part"), "{refused}");
    assert_eq!(std::fs::read(&out).unwrap(), all);

    let shrinking = kept(Job::new(small(1)), folder.path().join("shrinking.sppm"));
    let mut job = Job::new(global(3));
    job.scene.spheres.iter_mut().for_each(|sphere| sphere.radius *= 0.5);
    let other_scene = kept(job, folder.path().join("other.sppm"));
    let nothing = folder.path().join("nothing.sppm");
    std::fs::write(&nothing, "a letter").unwrap();
    for (there, told) in [
        (shrinking, "whose sums cannot be merged"),
        (other_scene, "other.sppm is of another scene than "),
        (nothing, "nothing.sppm: "),
    ] {
        let before = std::fs::read(&there).unwrap();
        let refused = Merge::open(&parts).unwrap().write(&there).unwrap_err().to_string();
        assert!(refused.contains(told), "{refused}");
        assert!(refused.ends_with("; remove it, or name another file to write"), "{refused}");
        assert_eq!(std::fs::read(&there).unwrap(), before);
    }
}

/// Another render may replace a part between the look at it and its sums.
#[test]
fn a_part_that_has_changed_meanwhile_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let parts = [0..1, 1..2].map(|range| part(folder.path(), range, 4, EngineName::Fast));
    let other = part(folder.path(), 2..3, 4, EngineName::Fast);
    let merge = Merge::open(&parts).unwrap();
    merge.add_up().unwrap();
    std::fs::copy(&other, &parts[1]).unwrap();
    let Err(error) = merge.add_up() else { panic!("iteration 2 was taken for iteration 1") };
    assert!(error.to_string().contains("has changed while it was merged"), "{error}");
}
