//! The scenes and settings with snapshots. Each row becomes two tests, `reference` and `fast`.

use crate::cases::tell;
use crate::golden;
use fast::LaneKind;
use files::scene_file;
use scene::{Engine, Scene, Settings};

/// A scene with the settings of its snapshot.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) scene: Scene,
    pub(crate) settings: Settings,
}

impl Row {
    fn new(name: &'static str, scene: Scene, change: impl Fn(Settings) -> Settings) -> Self {
        let small = Settings {
            width: 64,
            height: 48,
            iterations: 3,
            photons_per_iteration: 10_000,
            ..scene.settings
        };
        Self { name, settings: change(small), scene }
    }
}

fn builtin(name: &str) -> Scene {
    files::builtin::scene(name).unwrap()
}

/// Balls under an open sky, without walls, where most paths escape.
fn open_sky() -> Scene {
    const TEXT: &str = r#"
background = [0.4, 0.6, 1.0]
[camera]
eye = [0, 2, 8]
target = [0, 0.5, 0]
vertical_fov_degrees = 40
[settings]
max_depth = 12
initial_radius = 0.3
[[sphere]]
center = [0, -100, 0]
radius = 100
material = { type = "diffuse", albedo = [0.7, 0.6, 0.5] }
[[sphere]]
center = [-1.2, 1, 0]
radius = 1
material = { type = "dielectric", albedo = [1, 0.95, 0.9], ior = 1.5 }
[[sphere]]
center = [1.2, 1, 0]
radius = 1
material = { type = "specular", albedo = [0.9, 0.9, 0.9] }
[[sphere]]
center = [0, 0.3, 1.5]
radius = 0.3
material = { type = "diffuse", albedo = [0.2, 0.2, 0.2] }
emission = [12, 8, 4]
"#;
    scene_file::parse("open_sky", TEXT).unwrap()
}

fn run(mut engine: impl Engine, settings: &Settings) -> impl Engine {
    for _ in 0..settings.iterations {
        engine.iterate();
    }
    engine
}

fn check_reference(row: &Row) {
    golden::check_reference(row, &run(reference::Sppm::new(&row.scene, &row.settings), &row.settings));
    tell("snapshots", 1, &format!("render of {} as blessed, by the reference", row.name));
}

fn check_fast(row: &Row) {
    let mut renders = 0;
    for lanes in LaneKind::ALL {
        let engine = fast::Sppm::with_lanes(&row.scene, &row.settings, lanes);
        golden::check_other(row, &run(engine, &row.settings), &format!("fast-{lanes:?}").to_lowercase());
        renders += 1;
    }
    tell("snapshots", renders, &format!("renders of {} as blessed, by fast", row.name));
}

macro_rules! rows {
    ($($name:ident: $scene:expr, $change:expr;)*) => {$(
        mod $name {
            use super::*;

            fn row() -> Row {
                Row::new(stringify!($name), $scene, $change)
            }

            #[test]
            fn reference() {
                check_reference(&row());
            }

            #[test]
            fn fast() {
                check_fast(&row());
            }
        }
    )*};
}

rows! {
    cornell: builtin("cornell"), |s| s;
    large: builtin("large"), |s| s;
    mirror: builtin("mirror"), |s| s;
    random: builtin("random"), |s| s;
    surgery: builtin("surgery"), |s| s;
    focus: builtin("focus"), |s| s;
    motion: builtin("motion"), |s| Settings { iterations: 5, ..s };
    open_sky: open_sky(), |s| s;
    terrace: builtin("terrace"), |s| Settings { initial_radius: 0.3, ..s };
    heap: builtin("heap"), |s| Settings { initial_radius: 0.2, ..s };
    dusk: builtin("dusk"), |s| s;
    cornell_deep: builtin("cornell"), |s| Settings { width: 48, height: 27, max_depth: 64, seed: u64::MAX, ..s };
    cornell_one_pixel: builtin("cornell"), |s| Settings { width: 1, height: 1, iterations: 20, ..s };
    large_wide_radius: builtin("large"), |s| Settings { width: 36, height: 30, initial_radius: 30.0, ..s };
    mirror_one_photon: builtin("mirror"), |s| Settings { width: 17, height: 9, photons_per_iteration: 1, ..s };
    random_shallow: builtin("random"), |s| Settings { width: 33, height: 25, max_depth: 1, ..s };
    surgery_tall: builtin("surgery"), |s| Settings { width: 7, height: 61, photons_per_iteration: 257, ..s };
}

/// The path tracers have a snapshot of their own, as they render other images than photon mapping.
#[test]
fn path_tracer() {
    let row = Row::new("path_tracer", builtin("focus"), |s| Settings { width: 32, height: 24, ..s });
    let of_reference = reference::PathTracer::new(&row.scene, &row.settings);
    golden::check_reference(&row, &run(of_reference, &row.settings));
    for lanes in LaneKind::ALL {
        let engine = fast::PathTracer::with_lanes(&row.scene, &row.settings, lanes);
        golden::check_other(&row, &run(engine, &row.settings), &format!("fast-{lanes:?}").to_lowercase());
    }
    tell("snapshots", 1 + LaneKind::ALL.len(), "renders of focus as blessed, by the path tracers");
}
