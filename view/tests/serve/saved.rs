//! What is saved.

use crate::client::{Header, Page, get, project, studio};
use files::image_file::{self, Format, Tone};
use files::scene_file;
use render::{Image, Job, Made, Observer, Outputs};
use serde_json::json;
use view::{Place, Relay, View};

/// "Save" gives what `sppm render` of the saved scene gives.
#[test]
fn saved_files_are_those_of_a_render_of_the_saved_scene_bit_for_bit() {
    let view = studio();
    let mut page = Page::open(&view);
    let mut camera = page.camera();
    camera["eye"][0] = json!(52.345_678);
    camera["aperture_radius"] = json!(1.5);
    camera["focus_distance"] = json!(217.3);
    page.send(&json!({ "type": "camera", "id": 1, "camera": camera }));
    let glass = json!({ "type": "dielectric", "albedo": [1.0, 0.1, 0.1], "ior": 1.33 });
    page.send(&json!({ "type": "sphere", "index": 6, "material": glass, "center": [61.7, 16.5, 80.25] }));
    page.send(&json!({ "type": "sphere", "index": 7, "emission": [30, 12.3, 10] }));
    page.send(&json!({ "type": "settings", "seed": "12345", "max_depth": 9 }));
    let setup = page.text(|text| text["type"] == "setup" && text["settings"]["seed"] == "12345");
    let version = setup["version"].as_u64().unwrap() as u32;
    page.picture(|picture| picture.version == version && picture.is_whole() && picture.iterations > 2);
    let (path, iterations) = page.keep();
    let load = |name: &str| {
        let reply = get(&view, &format!("{path}{name}"));
        assert_eq!(reply.status, 200, "{name}");
        assert!(
            reply.head.contains("content-disposition: attachment; filename=\"cornell."),
            "{}",
            reply.head
        );
        reply.body
    };
    let text = String::from_utf8(load("scene.toml")).unwrap();
    assert!(
        text.starts_with("# The Cornell Box") && text.contains("# Materials that several spheres share.")
    );
    let scene = scene_file::parse("saved.toml", &text).unwrap();
    assert_eq!(u64::from(scene.settings.iterations), iterations);
    let folder = tempfile::tempdir().unwrap();
    let image = |name: &str, outputs: Outputs| {
        let mut job = Job::new(scene.clone());
        job.outputs = Outputs { image: Some(folder.path().join(name)), ..outputs };
        job.start(()).unwrap().wait().unwrap();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let pixels = |format, bytes: &[u8]| image_file::decode_bytes(format, bytes).unwrap();
    let rendered = image("rendered.exr", Outputs::default());
    assert_eq!(pixels(Format::Exr, &load("image.exr")), pixels(Format::Exr, &rendered));
    let outputs = Outputs { exposure: Some(1.5), tone: Some(Tone::Aces), ..Outputs::default() };
    let shown = pixels(Format::Png, &image("rendered.png", outputs));
    assert_eq!(pixels(Format::Png, &load("image.png?exposure=1.5&tone=aces")), shown);
    for (name, kind) in [
        ("image.png", "image/png"),
        ("image.exr", "image/x-exr"),
        ("scene.toml", "application/toml"),
        ("state.sppm", "application/octet-stream"),
    ] {
        let head = get(&view, &format!("{path}{name}")).head;
        assert!(head.lines().any(|line| line == format!("content-type: {kind}")), "{name}: {head}");
    }
    // Each says how it was made: what is shown otherwise, how it is shown too.
    for (name, query, exposure, tone) in [
        ("image.png", "?exposure=1.5&tone=aces", Some(1.5), Some(Tone::Aces)),
        ("image.png", "?exposure=0&tone=clamp", None, Some(Tone::Clamp)),
        ("image.exr", "", None, None),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, load(&format!("{name}{query}"))).unwrap();
        let Made::Image(made) = Made::read(&path).unwrap() else { panic!("{name} is no image") };
        assert_eq!((made.exposure, made.tone), (exposure, tone), "{name}{query}");
        assert_eq!(made.settings, scene.settings);
        assert_eq!(made.photons, iterations * u64::from(scene.settings.photons_per_iteration));
    }
    // The checkpoint holds as many iterations, and goes on to the image of more.
    let state = folder.path().join("state.sppm");
    std::fs::write(&state, load("state.sppm")).unwrap();
    let mut job = Job::resume(&state).unwrap();
    assert_eq!(job.resumed_after().map(u64::from), Some(iterations));
    job.scene.settings.iterations += 1;
    let more = job.scene.settings.iterations;
    let resumed = job.start(()).unwrap().wait().unwrap().last.unwrap();
    let mut job = Job::new(scene);
    job.scene.settings.iterations = more;
    assert_eq!(job.start(()).unwrap().wait().unwrap().last.unwrap().film, resumed.film);
}

#[test]
fn what_is_not_saved_when_the_view_ends_is_not_lost() {
    let view = studio();
    let mut page = Page::open(&view);
    page.send(&json!({ "type": "sphere", "index": 6, "radius": 12.5 }));
    page.typed("setup");
    page.picture(|picture| picture.version == 2 && picture.is_whole());
    drop(page);
    let legacy = view.end().unwrap();
    assert!(legacy.is_unsaved);
    let kept = legacy.kept.unwrap();
    let scene = scene_file::parse("kept.toml", &kept.text).unwrap();
    assert_eq!(scene.spheres[6].radius, 12.5);
    assert!(kept.iterations > 0);
}

/// Whoever has taken all changes back has nothing to lose.
#[test]
fn nothing_is_unsaved_where_all_changes_were_taken_back() {
    let view = studio();
    let mut page = Page::open(&view);
    page.typed("scene");
    page.send(&json!({ "type": "sphere", "index": 6, "radius": 12.5 }));
    page.text(|text| text["type"] == "setup" && text["changed"] == true);
    page.send(&json!({ "type": "undo" }));
    // Not the setup at the beginning, in which nothing was changed yet.
    page.text(|text| text["type"] == "setup" && text["version"] == 3 && text["changed"] == false);
    // At once, or one by one.
    page.send(&json!({ "type": "redo" }));
    page.text(|text| text["type"] == "setup" && text["version"] == 4 && text["changed"] == true);
    page.send(&json!({ "type": "reset" }));
    page.text(|text| text["type"] == "setup" && text["version"] == 5 && text["changed"] == false);
    drop(page);
    assert!(!view.end().unwrap().is_unsaved);
}

/// Only what was changed after it would be lost.
#[test]
fn what_was_downloaded_is_saved() {
    for changes_after in [false, true] {
        let view = studio();
        let mut page = Page::open(&view);
        page.send(&json!({ "type": "sphere", "index": 6, "radius": 12.5 }));
        page.text(|text| text["type"] == "setup" && text["version"] == 2);
        page.keep();
        if changes_after {
            page.send(&json!({ "type": "sphere", "index": 5, "radius": 13.5 }));
            page.text(|text| text["type"] == "setup" && text["version"] == 3);
        }
        drop(page);
        assert_eq!(view.end().unwrap().is_unsaved, changes_after);
    }
}

/// The last picture of a render that is watched tells its iterations, though nobody was told of any before.
#[test]
fn the_last_picture_of_a_watched_render_tells_all_its_iterations() {
    struct Watched(Relay);
    impl Observer for Watched {
        fn wants_image(&mut self, is_last: bool) -> bool {
            is_last
        }

        fn image(&mut self, image: Image) {
            self.0.last(image);
        }
    }
    let (view, relay) = View::relay("cornell", None, Some(&Place::default())).unwrap();
    let view = view.unwrap();
    let mut page = Page::open(&view);
    let mut job = Job::new(project().scene);
    job.scene.settings.iterations = 3;
    job.start(Watched(relay)).unwrap().wait().unwrap();
    assert_eq!(page.picture(Header::is_whole).iterations, 3);
}

/// The image and the checkpoint tell the method and the engine that made them, whichever these are.
#[test]
fn saved_files_tell_what_rendered_them() {
    let view = studio();
    let mut page = Page::open(&view);
    // What the page is told first is of the same method and engine as the last change below.
    page.typed("setup");
    let folder = tempfile::tempdir().unwrap();
    for (method, engine) in [("sppm", "reference"), ("path", "fast"), ("path", "reference"), ("sppm", "fast")]
    {
        page.send(&json!({ "type": "engine", "method": method, "engine": engine }));
        let setup =
            page.text(|text| text["type"] == "setup" && text["method"] == method && text["engine"] == engine);
        let version = setup["version"].as_u64().unwrap() as u32;
        page.picture(|picture| picture.version == version && picture.is_whole());
        let (path, _) = page.keep();
        for name in ["image.exr", "state.sppm"] {
            let file = folder.path().join(name);
            std::fs::write(&file, get(&view, &format!("{path}{name}")).body).unwrap();
            let renderer = match Made::read(&file).unwrap() {
                Made::Image(metadata) => metadata.renderer,
                Made::Checkpoint(loaded) => render::Note::of(&loaded).renderer.unwrap(),
            };
            assert_eq!((renderer.method.name(), renderer.engine.name()), (method, engine), "{name}");
        }
    }
}
