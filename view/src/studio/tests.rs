//! Tests of what a studio makes of requests, one thread at a time.

use super::*;
use crate::hub::Board;
use crate::kept::Look;
use crate::message::{SettingsParts, SphereParts};
use files::image_file::{self, Format};
use tokio::sync::mpsc;

/// A studio of the Cornell Box, whose picture while the camera moves is half as wide as the whole image.
fn studio(display: Option<Arc<Display>>) -> Studio {
    let mut scene = files::builtin::scene("cornell").unwrap();
    scene.settings = Settings { width: 256, height: 192, photons_per_iteration: 2000, ..scene.settings };
    let project = Project {
        scene,
        text: None,
        stem: "cornell".into(),
        engine: EngineChoice::default(),
        threads: Some(2),
        memory_limit: None,
        limit: None,
    };
    Studio::new(project, Arc::new(Hub::new(true, Vec::new())), display)
}

/// Tev shows it without a page. The times are so far away that it does not matter how long the test takes.
#[test]
fn a_render_is_held_only_when_no_page_is_open_and_no_viewer_is_sent_to() {
    let past = Instant::now().checked_sub(2 * FIRST_ABSENCE).unwrap();
    let future = Instant::now() + Duration::from_hours(1);
    // When the studio was opened, when a page was open last, and whether nobody is there any more.
    let cases = [
        (future, None, false),
        (past, None, true),
        (future, Some(past), true),
        (past, Some(past), true),
        (past, Some(future), false),
    ];
    let display = Display::new("127.0.0.1:14158".into(), "cornell".into()).unwrap();
    for (display, has_display) in [(None, false), (Some(Arc::new(display)), true)] {
        let mut studio = studio(display);
        for (opened, watched, is_alone) in cases {
            (studio.opened, studio.watched) = (opened, watched);
            assert_eq!(studio.is_abandoned(), is_alone && !has_display, "{opened:?}, {watched:?}");
        }
    }
}

/// Also when it is asked for while a picture of reduced size is rendered, as after every change.
#[test]
fn only_the_whole_image_is_kept() {
    let mut studio = studio(None);
    let _page = studio.hub.enter(1).unwrap();
    let (answers, mut answered) = mpsc::channel(1);
    studio.obey(vec![Asked::new(Request::Keep { id: 5 }, answers)]);
    studio.mind_render();
    assert_eq!(studio.stage, Stage::Small);
    let until = Instant::now() + Duration::from_mins(1);
    let number = loop {
        studio.hub.requests.take(TICK);
        studio.hand_out();
        match answered.try_recv() {
            Ok(Answer::Kept { id: 5, number, .. }) => break number,
            Ok(answer) => panic!("{answer:?}"),
            Err(_) => assert!(Instant::now() < until, "no image is kept"),
        }
        studio.mind_render();
    };
    studio.stop();
    let file = studio.hub.kept(number).unwrap().file("image.exr", Look::default());
    let image = image_file::decode_bytes(Format::Exr, &file.unwrap().unwrap().bytes).unwrap();
    assert_eq!([image.width, image.height], [256, 192]);
}

/// What is asked for just after a change is not answered by the render of the scene before.
#[test]
fn what_is_kept_is_rendered_after_the_last_change() {
    let mut studio = studio(None);
    let _page = studio.hub.enter(1).unwrap();
    let until = Instant::now() + Duration::from_mins(1);
    while studio.stage != Stage::Whole {
        assert!(Instant::now() < until, "no whole image is rendered");
        studio.mind_render();
        studio.hub.requests.take(TICK);
    }
    let asked = [sized(12.5, false), Request::Keep { id: 5 }];
    studio.obey(asked.map(|request| Asked::new(request, mpsc::channel(1).0)).into());
    assert_eq!((studio.version, studio.rendered, studio.stage), (2, 2, Stage::Small));
    studio.stop();
}

/// Asks for something whose answer nobody reads.
fn ask(studio: &mut Studio, request: Request) {
    studio.obey(vec![Asked::new(request, mpsc::channel(1).0)]);
}

/// A request that moves the camera of `studio` sideways.
fn moved(studio: &Studio, id: u32, x: f32, moving: bool) -> Request {
    let mut camera = CameraParts::of(&studio.model.now().camera);
    camera.eye[0] += x;
    Request::Camera { id, camera, moving }
}

/// A request that gives the glass ball this radius.
fn sized(radius: f32, moving: bool) -> Request {
    let parts = SphereParts { radius: Some(radius), ..SphereParts::default() };
    Request::Sphere { index: 6, parts, styled: false, moving }
}

fn told(board: &Board) -> Value {
    serde_json::from_str(&board.borrow()).unwrap()
}

/// Whoever turns the camera faster than pictures come waits for none that it has left behind, but for every answer. What was
/// asked between two moves is done between them.
#[test]
fn of_moves_that_waited_together_the_last_is_made_and_all_are_answered() {
    let mut studio = studio(None);
    let first = studio.model.now().camera.eye.x;
    let (answers, mut answered) = mpsc::channel(8);
    let mut waiting: Vec<_> = (1..=5).map(|id| moved(&studio, id, id as f32, id < 5)).collect();
    waiting.insert(2, sized(12.5, false));
    studio.obey(waiting.into_iter().map(|request| Asked::new(request, answers.clone())).collect());
    let mut taken = Vec::new();
    while let Ok(answer) = answered.try_recv() {
        let Answer::Taken { id, version } = answer else { panic!("{answer:?}") };
        taken.push((id, version));
    }
    taken.sort_unstable();
    assert_eq!(taken, [(1, 2), (2, 2), (3, 4), (4, 4), (5, 4)]);
    assert_eq!((studio.version, studio.is_moving), (4, false));
    // The steps that can be taken back.
    let place = |studio: &Studio| studio.model.now().camera.eye.x - first;
    assert_eq!(place(&studio), 5.0);
    assert!(studio.model.undo() && studio.model.undo());
    assert_eq!(place(&studio), 2.0);
    assert!(studio.model.undo() && !studio.model.undo());
    assert_eq!(place(&studio), 0.0);
}

/// The page repeats the camera then: what is rendered of it goes on.
#[test]
fn the_end_of_a_drag_is_no_change() {
    let mut studio = studio(None);
    let request = moved(&studio, 1, 3.0, true);
    ask(&mut studio, request);
    assert_eq!((studio.version, studio.is_moving), (2, true));
    let request = moved(&studio, 2, 0.0, false);
    ask(&mut studio, request);
    assert_eq!((studio.version, studio.is_moving), (2, false));
    assert_eq!(studio.model.now().camera.eye.x, 53.0);
}

/// Not while one of them is dragged, as the list may be long; then with whatever comes next.
#[test]
fn balls_that_were_dragged_are_listed_when_they_rest() {
    let mut studio = studio(None);
    studio.show_scene();
    ask(&mut studio, sized(12.5, true));
    let listed = |studio: &Studio| {
        let scene = told(&studio.hub.scene);
        (scene["version"].clone(), scene["spheres"][6]["radius"].clone())
    };
    assert_eq!(listed(&studio), (json!(1), json!(16.5)));
    let request = moved(&studio, 1, 3.0, false);
    ask(&mut studio, request);
    assert_eq!(listed(&studio), (json!(3), json!(12.5)));
}

/// Also on the pages that did not ask for it.
#[test]
fn a_pause_is_shown_on_all_pages() {
    let mut studio = studio(None);
    for paused in [true, false] {
        ask(&mut studio, Request::Pause { paused });
        assert_eq!(told(&studio.hub.setup)["paused"], json!(paused));
    }
    assert_eq!(studio.version, 1);
}

/// So the page shows the settings of what it sees, and the next change does not fail as well.
#[test]
fn a_change_that_cannot_be_rendered_is_taken_back() {
    let mut studio = studio(None);
    studio.memory_limit = Some(200 << 20);
    let side = Some(1 << 14);
    let parts = SettingsParts { width: side, height: side, ..SettingsParts::default() };
    ask(&mut studio, Request::Settings(parts));
    assert_eq!(told(&studio.hub.setup)["settings"]["width"], json!(1 << 14));
    studio.mind_render();
    let problem = told(&studio.hub.status)["problem"].to_string();
    assert!(problem.contains("more than 200.0 MiB"), "{problem}");
    let setup = told(&studio.hub.setup);
    assert_eq!((&setup["settings"]["width"], &setup["version"]), (&json!(256), &json!(3)));
    assert_eq!(setup["changed"], json!(false));
    studio.mind_render();
    assert_eq!((studio.stage, studio.rendered), (Stage::Small, 3));
    studio.stop();
}

/// What a single ball has is no style, as it is changed with the ball.
#[test]
fn styles_are_the_materials_that_several_balls_have() {
    let studio = studio(None);
    let style = |first: usize, count: usize| {
        let style = studio.model.spheres()[first].material;
        let material = studio.model.materials()[style as usize];
        json!({ "style": style, "first": first, "count": count, "material": material })
    };
    // Back wall, floor and ceiling; the lamps.
    assert_eq!(studio.styles(), [style(2, 3), style(7, 2)]);
}

/// Every term is by itself, and covers the structures that it is for.
#[test]
fn each_sphere_and_material_takes_its_own_bytes() {
    let scene = files::builtin::scene("cornell").unwrap();
    let base = bytes_at_most(&scene) - model::bytes_at_most(&scene) as u64;
    let mut more = scene.clone();
    more.spheres.push(scene.spheres[0]);
    let per_sphere = bytes_at_most(&more) - model::bytes_at_most(&more) as u64 - base;
    let still = size_of::<Sphere>() + size_of::<scene::still::Role>();
    let name = size_of::<Option<String>>();
    // A copy of the scene, what is searched, of which a tree takes 32, and the name.
    assert!(per_sphere as usize >= size_of::<Sphere>() + still + 32 + name, "{per_sphere}");
    let mut more = scene.clone();
    more.materials.push(scene.materials[0]);
    let per_material = bytes_at_most(&more) - model::bytes_at_most(&more) as u64 - base;
    assert_eq!(per_material as usize, size_of_val(&scene.materials[0]));
}
