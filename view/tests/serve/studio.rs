//! A scene that is edited.

use crate::client::{Page, project, studio};
use serde_json::{Value, json};
use view::{Place, View};

/// The camera, moved sideways.
fn moved(camera: &Value, x: f64) -> Value {
    let mut camera = camera.clone();
    camera["eye"][0] = json!(camera["eye"][0].as_f64().unwrap() + x);
    camera
}

#[test]
fn a_picture_comes_and_converges() {
    let view = studio();
    let mut page = Page::open(&view);
    let scene = page.typed("scene");
    assert_eq!((&scene["mode"], &scene["total"]), (&json!("studio"), &json!(9)));
    assert_eq!(scene["spheres"][6]["name"], "glass ball");
    let picture = page.picture(|picture| picture.is_whole() && picture.iterations > 3);
    assert_eq!((picture.size, picture.version), ([64, 48], 1));
    let status = page.text(|text| text["type"] == "status" && text["iterations"].as_u64() > Some(3));
    assert!(
        status["mean_radius"].as_f64().unwrap() < 2.0 && status["error"].as_f64().unwrap() > 0.0,
        "{status}"
    );
    // It has no end.
    let [limit, preview, waiting] = ["limit", "preview", "waiting"].map(|name| &status[name]);
    assert_eq!((limit, preview, waiting), (&Value::Null, &json!(false), &json!(false)), "{status}");
}

/// While the camera turns, and when it rests.
#[test]
fn no_picture_of_an_older_camera_follows_one_of_a_newer() {
    let view = studio();
    let mut page = Page::open(&view);
    let camera = page.camera();
    let (mut newest, mut last) = (0, 0);
    for id in 0..60_u32 {
        let moving = id % 20 != 19;
        page.send(&json!({ "type": "camera", "id": id, "camera": moved(&camera, f64::from(id) * 0.1), "moving": moving }));
        let taken = page.text(|text| text["type"] == "taken" && text["id"] == id);
        let version = taken["version"].as_u64().unwrap() as u32;
        assert!(version > newest);
        newest = version;
        let is_due = id % 5 == 0;
        if is_due {
            let picture = page.picture(|picture| {
                assert!(picture.version >= last);
                last = picture.version;
                picture.version == newest
            });
            assert_eq!(picture.whole, [64, 48]);
        }
    }
    let picture = page.picture(|picture| {
        assert!(picture.version >= last);
        last = picture.version;
        picture.version == newest && picture.is_whole()
    });
    assert!(picture.iterations > 0);
}

#[test]
fn what_cannot_be_is_refused_and_the_page_learns_what_there_is() {
    let view = studio();
    let mut page = Page::open(&view);
    let camera = page.camera();
    // Beyond the wall.
    page.send(&json!({ "type": "camera", "id": 5, "camera": moved(&camera, 500.0) }));
    let refused = page.typed("refused");
    assert!(refused["problem"].as_str().unwrap().contains("no light reaches the eye"), "{refused}");
    assert_eq!(page.camera(), camera);
    page.send(&json!({ "type": "sphere", "index": 99, "radius": 1 }));
    assert_eq!(page.typed("refused")["problem"], "there is no sphere 100; there are 9");
    page.send(&json!({ "type": "settings", "seed": "x" }));
    page.typed("refused");
    page.send(&json!({ "type": "nonsense" }));
    assert_eq!(page.typed("refused")["problem"], "that request is unknown");
}

#[test]
fn balls_are_picked_painted_and_changes_taken_back() {
    let view = studio();
    let mut page = Page::open(&view);
    page.typed("scene");
    page.send(&json!({ "type": "pick", "id": 8, "x": 0.68, "y": 0.75 }));
    let picked = page.typed("picked");
    assert_eq!((&picked["id"], &picked["sphere"]), (&json!(8), &json!(6)));
    let red = json!({ "type": "diffuse", "albedo": [1.0, 0.0, 0.0] });
    page.send(&json!({ "type": "sphere", "index": 6, "material": red, "center": [60, 16.5, 78] }));
    let scene = page.typed("scene");
    assert_eq!((&scene["spheres"][6]["material"], &scene["spheres"][6]["center"][0]), (&red, &json!(60.0)));
    let setup = page.text(|text| text["type"] == "setup" && text["changed"] == true);
    assert_eq!((&setup["can_undo"], &setup["can_redo"]), (&json!(true), &json!(false)));
    page.send(&json!({ "type": "undo" }));
    assert_eq!(page.typed("scene")["spheres"][6]["material"]["type"], "dielectric");
    page.send(&json!({ "type": "redo" }));
    assert_eq!(page.typed("scene")["spheres"][6]["material"], red);
}

#[test]
fn layers_come_while_the_render_goes_on_and_while_it_is_paused() {
    let view = studio();
    let mut page = Page::open(&view);
    for layer in 1..4 {
        page.send(&json!({ "type": "layer", "layer": layer }));
        page.picture(|picture| picture.layer == layer);
    }
    page.send(&json!({ "type": "pause", "paused": true }));
    page.text(|text| text["type"] == "status" && text["waiting"] == true);
    page.send(&json!({ "type": "layer", "layer": 0 }));
    let paused = page.picture(|picture| picture.layer == 0);
    page.send(&json!({ "type": "layer", "layer": 2 }));
    let again = page.picture(|picture| picture.layer == 2);
    assert_eq!(again.iterations, paused.iterations);
    page.send(&json!({ "type": "pause", "paused": false }));
    page.picture(|picture| picture.iterations > again.iterations);
}

/// The image of the new camera comes too, after the picture of reduced size, which does not wait.
#[test]
fn a_paused_render_follows_the_camera() {
    let mut project = project();
    (project.scene.settings.width, project.scene.settings.height) = (256, 192);
    let view = View::studio(project, None, None, &Place::default()).unwrap();
    let mut page = Page::open(&view);
    let camera = page.camera();
    let is_waiting =
        |text: &Value| text["type"] == "status" && text["waiting"] == true && text["preview"] == false;
    page.send(&json!({ "type": "pause", "paused": true }));
    page.text(is_waiting);
    page.send(&json!({ "type": "camera", "id": 3, "camera": moved(&camera, 1.0) }));
    let version = page.text(|text| text["type"] == "taken")["version"].clone();
    page.text(|text| is_waiting(text) && text["version"] == version);
}

/// A page that is slow is never more than a picture behind.
#[test]
fn the_next_picture_comes_when_the_last_is_drawn_and_is_the_newest() {
    let view = studio();
    let (mut slow, mut quick) = (Page::open(&view), Page::open(&view));
    slow.draws = false;
    let first = slow.picture(|_| true);
    let later = quick.picture(|picture| picture.number > first.number + 2);
    slow.send(&json!({ "type": "ack" }));
    let next = slow.picture(|_| true);
    assert!(next.number >= later.number, "{} after {}", next.number, first.number);
}

/// It is in the picture, as another page looks at it, and no other picture will come.
#[test]
fn a_layer_that_the_picture_has_comes_while_the_render_is_paused() {
    let view = studio();
    let (mut one, mut other) = (Page::open(&view), Page::open(&view));
    other.send(&json!({ "type": "layer", "layer": 2 }));
    other.picture(|picture| picture.layer == 2);
    one.send(&json!({ "type": "pause", "paused": true }));
    one.text(|text| text["type"] == "status" && text["waiting"] == true);
    one.send(&json!({ "type": "layer", "layer": 2 }));
    one.picture(|picture| picture.layer == 2);
}

#[test]
fn a_render_waits_at_its_limit() {
    let project = view::Project { limit: Some(3), ..project() };
    let view = View::studio(project, None, None, &Place::default()).unwrap();
    let mut page = Page::open(&view);
    let status = page.text(|text| text["type"] == "status" && text["waiting"] == true);
    assert_eq!((&status["iterations"], &status["limit"]), (&json!(3), &json!(3)));
    assert_eq!(page.keep().1, 3);
}

#[test]
fn other_methods_and_engines_render_the_scene() {
    let view = studio();
    let mut page = Page::open(&view);
    for (method, engine) in [("path", "fast"), ("path", "reference"), ("sppm", "reference")] {
        page.send(&json!({ "type": "engine", "method": method, "engine": engine }));
        let setup =
            page.text(|text| text["type"] == "setup" && text["method"] == method && text["engine"] == engine);
        let version = setup["version"].as_u64().unwrap() as u32;
        page.picture(|picture| picture.version == version && picture.is_whole());
        assert_eq!(setup["changed"], true, "{setup}");
    }
    // What rendered it first comes back with the rest.
    page.send(&json!({ "type": "reset" }));
    let is_first =
        |text: &Value| text["type"] == "setup" && text["method"] == "sppm" && text["engine"] == "fast";
    assert_eq!(page.text(is_first)["changed"], false);
}

/// More balls than are listed: the others are described when they are asked for, and changed with their style.
#[test]
fn balls_beyond_the_list_are_described_and_restyled() {
    const BALLS: usize = 5000;
    let mut project = project();
    let first = project.scene.spheres.len();
    let of_glass = project.scene.spheres[6].material;
    let ball = |i: usize| scene::Sphere {
        center: scene::Vec3::new(20.0 + 0.01 * i as f32, 40.0, 60.0),
        radius: 0.002,
        material: of_glass,
        ..project.scene.spheres[6]
    };
    let balls: Vec<_> = (0..BALLS).map(ball).collect();
    project.scene.spheres.extend(balls);
    (project.text, project.stem) = (None, "many".into());
    let view = View::studio(project, None, None, &Place::default()).unwrap();
    let mut page = Page::open(&view);
    let scene = page.typed("scene");
    assert_eq!(scene["total"], json!(first + BALLS));
    assert!(scene["spheres"].as_array().unwrap().len() < BALLS);
    // The style of most balls comes first.
    assert_eq!(scene["styles"][0]["style"], json!(of_glass));
    assert_eq!((&scene["styles"][0]["first"], &scene["styles"][0]["count"]), (&json!(6), &json!(BALLS + 1)));
    let describe = |page: &mut Page, id: u32, index: usize| {
        page.send(&json!({ "type": "describe", "id": id, "index": index }));
        page.text(|text| text["id"] == id)["sphere"].clone()
    };
    let last = first + BALLS - 1;
    let before = describe(&mut page, 1, last);
    assert_eq!(before["style"], json!(of_glass));
    assert_eq!(describe(&mut page, 2, last + 1), Value::Null);
    let red = json!({ "type": "diffuse", "albedo": [1.0, 0.0, 0.0] });
    page.send(&json!({ "type": "sphere", "index": last, "material": red, "radius": 0.004, "styled": true }));
    page.text(|text| text["type"] == "scene" && text["version"].as_u64() > Some(1));
    for (id, index) in [(3, first), (4, last)] {
        let after = describe(&mut page, id, index);
        assert_eq!(after["material"]["type"], "diffuse");
        assert_eq!(after["radius"], json!(0.004_f32));
    }
    // The glass ball itself grew as the others did.
    let ratio = describe(&mut page, 5, 6)["radius"].as_f64().unwrap()
        / scene["spheres"][6]["radius"].as_f64().unwrap();
    assert!((ratio - 2.0).abs() < 1e-5, "{ratio}");
}
