//! The scene as it is edited, with what was before and can be returned to.

use crate::message::{CameraParts, SettingsParts, SphereParts};
use render::EngineChoice;
use scene::{Camera, Material, Rgb, Scene, Settings, Sphere, Spheres, Vec3};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// So many steps can be taken back, or fewer if they take more than [`MOST_BYTES`].
const MOST_STEPS: usize = 200;
/// Steps that change spheres hold all spheres. One can be taken back in any case.
const MOST_BYTES: usize = 1 << 28;
/// Changes of one thing that follow each other within this time are one step.
const PAUSE: Duration = Duration::from_secs(1);

/// What is rendered.
#[derive(Clone, Debug)]
pub(crate) struct State {
    body: Arc<Body>,
    pub(crate) camera: Camera,
    pub(crate) settings: Settings,
    pub(crate) engine: EngineChoice,
}

/// What moves of the camera leave alone.
#[derive(Clone, Debug, PartialEq)]
struct Body {
    name: String,
    materials: Vec<Material>,
    /// Without the sky.
    spheres: Spheres,
    background: Rgb,
    transparent_background: bool,
}

/// A change of the scene, or of how it is rendered.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    Camera(CameraParts),
    Sphere(usize, SphereParts),
    /// Of all spheres of the style of this one, those of its material. Radii change in proportion, centres do not.
    Style(usize, SphereParts),
    Settings(SettingsParts),
    Engine(EngineChoice),
}

/// What a change is of, to tell which changes make one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    Camera,
    Sphere(usize),
    Style(usize),
    Settings,
    Engine,
}

/// The edited scene.
#[derive(Debug)]
pub(crate) struct Model {
    first: State,
    now: State,
    past: Vec<State>,
    future: Vec<State>,
    last: Option<(Subject, Instant)>,
}

impl State {
    /// The scene, with its sky.
    pub(crate) fn scene(&self) -> Scene {
        let Body { name, materials, spheres, background, transparent_background } = &*self.body;
        let scene = Scene {
            name: name.clone(),
            camera: self.camera,
            materials: materials.clone(),
            spheres: spheres.clone(),
            background: *background,
            transparent_background: *transparent_background,
            settings: self.settings,
            // Each may be changed, so spheres from files of particles are written out.
            imports: Vec::new(),
        };
        scene.with_sky()
    }

    fn is_like(&self, other: &Self) -> bool {
        let has_body = Arc::ptr_eq(&self.body, &other.body) || self.body == other.body;
        let has_engine = self.engine.renderer() == other.engine.renderer();
        has_body && has_engine && self.camera == other.camera && self.settings == other.settings
    }
}

/// The most bytes that the model of a scene takes, whatever is changed: the scene as it was first, as it is, as it becomes, and
/// in the steps that can be taken back.
pub(crate) fn bytes_at_most(scene: &Scene) -> usize {
    most_held(bytes_of(&scene.spheres, &scene.materials))
}

/// The same of a scene whose spheres and materials take `body` bytes.
fn most_held(body: usize) -> usize {
    3 * body + (MOST_STEPS * body).min(MOST_BYTES.max(body))
}

fn bytes_of(spheres: &[Sphere], materials: &[Material]) -> usize {
    size_of_val(spheres) + size_of_val(materials)
}

impl Model {
    /// The model of a scene, rendered by `engine`.
    pub(crate) fn new(scene: &Scene, engine: EngineChoice) -> Self {
        let skies = scene.spheres.len() - scene.without_sky().len();
        let body = Body {
            name: scene.name.clone(),
            // The sky's own material is the last.
            materials: scene.materials[..scene.materials.len() - skies].to_vec(),
            spheres: if skies == 0 { scene.spheres.clone() } else { scene.without_sky().to_vec().into() },
            background: scene.background,
            transparent_background: scene.transparent_background,
        };
        let (camera, settings) = (scene.camera, scene.settings);
        let now = State { body: Arc::new(body), camera, settings, engine };
        Self { first: now.clone(), now, past: Vec::new(), future: Vec::new(), last: None }
    }

    /// What is rendered now.
    pub(crate) fn now(&self) -> &State {
        &self.now
    }

    /// Whether the spheres or materials are others than those of `other`.
    pub(crate) fn has_other_body(&self, other: &State) -> bool {
        !Arc::ptr_eq(&self.now.body, &other.body)
    }

    /// The spheres, without the sky.
    pub(crate) fn spheres(&self) -> &[Sphere] {
        &self.now.body.spheres
    }

    /// The materials that spheres refer to.
    pub(crate) fn materials(&self) -> &[Material] {
        &self.now.body.materials
    }

    /// The scene's own name.
    pub(crate) fn name(&self) -> &str {
        &self.now.body.name
    }

    /// Whether a change can be taken back; whether one can be made again; whether anything is changed.
    pub(crate) fn steps(&self) -> [bool; 3] {
        [!self.past.is_empty(), !self.future.is_empty(), !self.now.is_like(&self.first)]
    }

    /// Makes a change, or says why the scene could not be rendered then.
    pub(crate) fn apply(&mut self, change: Change) -> Result<(), String> {
        let subject = change.subject();
        let next = self.after(change)?;
        next.settings.validate().map_err(|error| error.to_string())?;
        next.scene().check().map_err(|flaw| flaw.to_string())?;
        let goes_on = self.last.is_some_and(|(last, at)| last == subject && at.elapsed() < PAUSE);
        if !goes_on {
            self.past.push(self.now.clone());
            self.forget(MOST_BYTES);
        }
        self.future.clear();
        (self.now, self.last) = (next, Some((subject, Instant::now())));
        Ok(())
    }

    /// Takes back the last change; says whether there was one.
    pub(crate) fn undo(&mut self) -> bool {
        let Some(before) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.now, before));
        self.last = None;
        true
    }

    /// Makes the change again that was taken back last; says whether there was one.
    pub(crate) fn redo(&mut self) -> bool {
        let Some(after) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.now, after));
        self.last = None;
        true
    }

    /// Returns to the scene as it was first, as one step.
    pub(crate) fn reset(&mut self) -> bool {
        if self.now.is_like(&self.first) {
            return false;
        }
        self.past.push(std::mem::replace(&mut self.now, self.first.clone()));
        self.future.clear();
        self.last = None;
        true
    }

    fn after(&self, change: Change) -> Result<State, String> {
        let mut next = self.now.clone();
        match change {
            Change::Camera(parts) => next.camera = parts.onto(next.camera),
            Change::Settings(parts) => next.settings = parts.onto(next.settings)?,
            Change::Engine(engine) => next.engine = engine,
            Change::Style(index, parts) => {
                self.find(index)?;
                Arc::make_mut(&mut next.body).restyle(index, &parts);
            }
            Change::Sphere(index, parts) => {
                self.find(index)?;
                let body = Arc::make_mut(&mut next.body);
                let sphere = &mut body.spheres[index];
                sphere.center = parts.center.map_or(sphere.center, Vec3::from);
                sphere.radius = parts.radius.unwrap_or(sphere.radius);
                sphere.emission = parts.emission.map_or(sphere.emission, Rgb::from);
                if let Some(material) = parts.material {
                    body.assign(index, material);
                }
            }
        }
        Ok(next)
    }

    fn find(&self, index: usize) -> Result<(), String> {
        let count = self.spheres().len();
        if index < count {
            Ok(())
        } else {
            Err(format!("there is no sphere {}; there are {count}", index + 1))
        }
    }

    /// Forgets the oldest steps if there are too many, or if they take more than `most_bytes`.
    fn forget(&mut self, most_bytes: usize) {
        while self.past.len() > MOST_STEPS || (self.past.len() > 1 && self.bytes_of_past() > most_bytes) {
            self.past.remove(0);
        }
    }

    /// What the steps that can be taken back hold for themselves: moves of the camera share the spheres of the next step.
    fn bytes_of_past(&self) -> usize {
        let following = self.past.iter().skip(1).chain([&self.now]);
        let own = self.past.iter().zip(following).filter(|(step, next)| {
            ![next, &&self.first].iter().any(|other| Arc::ptr_eq(&step.body, &other.body))
        });
        own.map(|(step, _)| bytes_of(&step.body.spheres, &step.body.materials)).sum()
    }
}

impl Body {
    /// Changes all spheres of the material of sphere `index`.
    fn restyle(&mut self, index: usize, parts: &SphereParts) {
        let Sphere { material, radius, .. } = self.spheres[index];
        let growth = parts.radius.map_or(1.0, |asked| asked / radius);
        for sphere in self.spheres.iter_mut().filter(|sphere| sphere.material == material) {
            sphere.radius *= growth;
            sphere.emission = parts.emission.map_or(sphere.emission, Rgb::from);
        }
        if let Some(asked) = parts.radius {
            // Not rounded.
            self.spheres[index].radius = asked;
        }
        if let Some(asked) = parts.material {
            self.materials[material as usize] = asked;
        }
    }

    /// Gives a sphere a material of its own.
    fn assign(&mut self, index: usize, material: Material) {
        let there = self.spheres[index].material;
        let is_shared = self.spheres.iter().filter(|sphere| sphere.material == there).nth(1).is_some();
        if is_shared {
            self.spheres[index].material = self.materials.len() as u32;
            self.materials.push(material);
        } else {
            self.materials[there as usize] = material;
        }
    }
}

impl Change {
    fn subject(&self) -> Subject {
        match self {
            Self::Camera(_) => Subject::Camera,
            Self::Sphere(index, _) => Subject::Sphere(*index),
            Self::Style(index, _) => Subject::Style(*index),
            Self::Settings(_) => Subject::Settings,
            Self::Engine(_) => Subject::Engine,
        }
    }
}

impl CameraParts {
    /// The parts of a camera that a page may change.
    pub(crate) fn of(camera: &Camera) -> Self {
        Self {
            eye: camera.eye.into(),
            direction: camera.direction.into(),
            up: camera.up.into(),
            vertical_fov_degrees: camera.vertical_fov_degrees,
            aperture_radius: camera.aperture_radius,
            focus_distance: camera.focus_distance,
        }
    }

    fn onto(self, camera: Camera) -> Camera {
        Camera {
            eye: self.eye.into(),
            direction: self.direction.into(),
            up: self.up.into(),
            vertical_fov_degrees: self.vertical_fov_degrees,
            aperture_radius: self.aperture_radius,
            focus_distance: self.focus_distance,
            ..camera
        }
    }
}

impl SettingsParts {
    fn onto(self, settings: Settings) -> Result<Settings, String> {
        let seed = self.seed.map(|seed| seed.parse());
        let bad = "seed is not a whole number from 0 to 18446744073709551615";
        Ok(Settings {
            width: self.width.unwrap_or(settings.width),
            height: self.height.unwrap_or(settings.height),
            photons_per_iteration: self.photons_per_iteration.unwrap_or(settings.photons_per_iteration),
            max_depth: self.max_depth.unwrap_or(settings.max_depth),
            initial_radius: self.initial_radius.unwrap_or(settings.initial_radius),
            seed: seed.transpose().map_err(|_| bad)?.unwrap_or(settings.seed),
            ..settings
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Filter, RadiusSchedule};

    fn model(name: &str) -> Model {
        Model::new(&files::builtin::scene(name).unwrap(), EngineChoice::default())
    }

    fn moved(model: &Model, x: f32) -> Change {
        let mut parts = CameraParts::of(&model.now().camera);
        parts.eye[0] += x;
        Change::Camera(parts)
    }

    #[test]
    fn an_unchanged_model_is_the_scene() {
        for name in ["cornell", "terrace"] {
            let model = model(name);
            assert_eq!(model.now().scene(), files::builtin::scene(name).unwrap());
            assert_eq!(model.steps(), [false; 3]);
        }
    }

    /// Also what no page shows or changes, such as a transparent background.
    #[test]
    fn all_of_the_scene_that_is_not_changed_stays() {
        // Radii that are the same in all pixels cannot be chosen for each.
        for (name, radius_schedule, radius_pilots, radius_clearance) in
            [("cornell", RadiusSchedule::PerPixel, 2, 0.5), ("terrace", RadiusSchedule::Global, 0, 0.0)]
        {
            let builtin = files::builtin::scene(name).unwrap();
            let first = Scene {
                name: "other".into(),
                camera: Camera { shutter: [0.25, 0.75], ..builtin.camera },
                transparent_background: !builtin.transparent_background,
                settings: Settings {
                    iterations: builtin.settings.iterations + 1,
                    filter: Filter::Mitchell,
                    radius_schedule,
                    radius_pilots,
                    radius_clearance,
                    light_samples: 2,
                    glint_samples: 3,
                    ..builtin.settings
                },
                ..builtin
            };
            let mut model = Model::new(&first, EngineChoice::default());
            let mut expected = first.clone();
            assert_eq!(model.now().scene(), expected);
            model.apply(moved(&model, 1.0)).unwrap();
            expected.camera.eye.x += 1.0;
            assert_eq!(model.now().scene(), expected);
            model.apply(lit(0, 7.0)).unwrap();
            expected.spheres[0].emission = Rgb::splat(7.0);
            assert_eq!(model.now().scene(), expected);
            let parts = SettingsParts { seed: Some("5".into()), ..SettingsParts::default() };
            model.apply(Change::Settings(parts)).unwrap();
            expected.settings.seed = 5;
            assert_eq!(model.now().scene(), expected);
            assert!(model.reset());
            assert_eq!(model.now().scene(), first);
        }
    }

    fn lit(index: usize, emission: f32) -> Change {
        Change::Sphere(index, SphereParts { emission: Some([emission; 3]), ..SphereParts::default() })
    }

    /// Bytes of all spheres and materials that a model holds.
    fn held(model: &Model) -> usize {
        let states = model.past.iter().chain(&model.future).chain([&model.first, &model.now]);
        let mut bodies: Vec<_> = states.map(|state| Arc::as_ptr(&state.body)).collect();
        bodies.sort();
        bodies.dedup();
        bodies.len() * bytes_of(model.spheres(), model.materials())
    }

    #[test]
    fn memory_covers_all_that_is_held() {
        let mut model = model("cornell");
        let scene = model.now().scene();
        let body = bytes_of(&scene.spheres, &scene.materials);
        for step in 0..MOST_STEPS + 20 {
            model.apply(lit(step % 2, 1.0 + step as f32)).unwrap();
            if step % 3 == 0 {
                assert!(model.reset());
            }
            assert!(held(&model) + body <= bytes_at_most(&scene), "step {step}");
        }
        for step in 0..MOST_STEPS + 20 {
            model.apply(lit(step % 2, 1.0 + step as f32)).unwrap();
        }
        // All steps, the first state and the present one; as the next one comes, there is one more.
        assert_eq!((model.past.len(), held(&model)), (MOST_STEPS, (MOST_STEPS + 2) * body));
        assert_eq!(bytes_at_most(&scene), held(&model) + body);
        // Of many spheres, fewer steps are held, and of very many a single one.
        assert_eq!(most_held(MOST_BYTES / 2), 3 * (MOST_BYTES / 2) + MOST_BYTES);
        assert_eq!(most_held(2 * MOST_BYTES), 4 * (2 * MOST_BYTES));
    }

    #[test]
    fn moves_of_the_camera_are_kept_however_many_spheres_there_are() {
        let mut model = model("cornell");
        let most = bytes_of(model.spheres(), model.materials()) / 2;
        for step in 0..10 {
            model.apply(moved(&model, 1.0)).unwrap();
            let parts = SettingsParts { seed: Some(step.to_string()), ..SettingsParts::default() };
            model.apply(Change::Settings(parts)).unwrap();
            model.forget(most);
        }
        assert_eq!(model.past.len(), 20);
        for step in 0..5 {
            model.apply(lit(step % 2, 1.0 + step as f32)).unwrap();
            model.forget(most);
        }
        assert_eq!(model.past.len(), 1);
        assert!(model.undo());
    }

    #[test]
    fn steps_are_taken_back_and_made_again() {
        let mut model = model("cornell");
        let first = model.now().scene();
        model.apply(moved(&model, 1.0)).unwrap();
        model.apply(moved(&model, 1.0)).unwrap();
        let turned = model.now().scene();
        let red = Material::Diffuse { albedo: Rgb::new(1.0, 0.0, 0.0) };
        let parts = SphereParts { material: Some(red), ..SphereParts::default() };
        model.apply(Change::Sphere(6, parts)).unwrap();
        let painted = model.now().scene();
        assert_eq!(painted.materials[painted.spheres[6].material as usize], red);
        // The two moves follow each other at once: they are one step.
        assert!(model.undo());
        assert_eq!(model.now().scene(), turned);
        assert!(model.undo());
        assert_eq!(model.now().scene(), first);
        assert!(!model.undo() && model.redo() && model.redo() && !model.redo());
        assert_eq!(model.now().scene(), painted);
        assert!(model.reset() && !model.reset());
        assert_eq!(model.now().scene(), first);
        assert!(model.undo());
        assert_eq!(model.now().scene(), painted);
    }

    #[test]
    fn a_change_after_others_were_taken_back_is_a_step_of_its_own() {
        let mut model = model("cornell");
        let first = model.now().scene();
        model.apply(moved(&model, 1.0)).unwrap();
        assert!(model.undo());
        // Of the same thing, and at once.
        model.apply(moved(&model, 2.0)).unwrap();
        let second = model.now().scene();
        assert_eq!(model.steps(), [true, false, true]);
        // What was taken back belongs to a scene that there is no more.
        assert!(!model.redo());
        assert_eq!(model.now().scene(), second);
        assert!(model.undo() && model.redo());
        model.apply(moved(&model, 4.0)).unwrap();
        assert!(model.undo());
        assert_eq!(model.now().scene(), second);
        assert!(model.reset());
        model.apply(moved(&model, 8.0)).unwrap();
        assert!(model.undo());
        assert_eq!(model.now().scene(), first);
    }

    /// Steps are a list with a place in it, whatever is done in whichever order.
    #[test]
    fn the_history_is_a_list_with_a_place() {
        let scenes = |model: &Model| (model.now().scene(), model.steps());
        for seed in 0..40_u32 {
            let mut model = model("cornell");
            let first = model.now().scene();
            let (mut list, mut place) = (vec![first.clone()], 0);
            let mut random = seed.wrapping_mul(747_796_405).wrapping_add(1);
            for step in 0..30 {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let done = match random >> 29 {
                    0 | 1 => {
                        place > 0 && {
                            place -= 1;
                            true
                        }
                    }
                    2 | 3 => {
                        place + 1 < list.len() && {
                            place += 1;
                            true
                        }
                    }
                    4 => {
                        list[place] != first && {
                            list.truncate(place + 1);
                            list.push(first.clone());
                            place += 1;
                            true
                        }
                    }
                    // Another sphere each time, so that each change is a step.
                    _ => {
                        model.apply(lit(step % 9, 1.0 + step as f32)).unwrap();
                        list.truncate(place + 1);
                        list.push(model.now().scene());
                        place += 1;
                        true
                    }
                };
                let is_done = match random >> 29 {
                    0 | 1 => model.undo(),
                    2 | 3 => model.redo(),
                    4 => model.reset(),
                    _ => true,
                };
                let expected = [place > 0, place + 1 < list.len(), list[place] != first];
                assert_eq!(
                    (is_done, scenes(&model)),
                    (done, (list[place].clone(), expected)),
                    "seed {seed}, step {step}"
                );
            }
        }
    }

    /// A page changes what it names, and nothing else.
    #[test]
    fn each_setting_is_changed_by_itself() {
        let none = SettingsParts::default();
        let parts = [
            SettingsParts { width: Some(33), ..none.clone() },
            SettingsParts { height: Some(22), ..none.clone() },
            SettingsParts { photons_per_iteration: Some(77), ..none.clone() },
            SettingsParts { max_depth: Some(9), ..none.clone() },
            SettingsParts { initial_radius: Some(0.75), ..none.clone() },
            SettingsParts { seed: Some("5".into()), ..none },
        ];
        let model = model("cornell");
        let own = model.now().settings;
        let expected = [
            Settings { width: 33, ..own },
            Settings { height: 22, ..own },
            Settings { photons_per_iteration: 77, ..own },
            Settings { max_depth: 9, ..own },
            Settings { initial_radius: 0.75, ..own },
            Settings { seed: 5, ..own },
        ];
        for (parts, expected) in parts.into_iter().zip(expected) {
            assert_eq!(parts.onto(own), Ok(expected));
        }
        let other = Camera { shutter: [1.0, 2.0], ..Camera::default() };
        let mut parts = CameraParts::of(&model.now().camera);
        (parts.vertical_fov_degrees, parts.aperture_radius, parts.focus_distance) = (11.0, 0.5, 7.0);
        let given = parts.onto(other);
        // The shutter is no part.
        assert_eq!((CameraParts::of(&given), given.shutter), (parts, [1.0, 2.0]));
        let camera = Camera { shutter: [1.0, 2.0], ..model.now().camera };
        assert_eq!(CameraParts::of(&camera).onto(other), camera);
    }

    /// What is not named stays, of a sphere too.
    #[test]
    fn each_part_of_a_sphere_is_changed_by_itself() {
        let before = model("cornell").now().scene().spheres[6];
        let after = |parts| {
            let mut model = model("cornell");
            model.apply(Change::Sphere(6, parts)).unwrap();
            model.now().scene().spheres[6]
        };
        let none = SphereParts::default();
        let center = before.center + Vec3::new(1.0, 2.0, 3.0);
        let moved = after(SphereParts { center: Some(center.to_array()), ..none.clone() });
        assert_eq!(moved, Sphere { center, ..before });
        assert_eq!(
            after(SphereParts { radius: Some(3.0), ..none.clone() }),
            Sphere { radius: 3.0, ..before }
        );
        let emission = Rgb::new(1.0, 2.0, 3.0);
        let glowing = after(SphereParts { emission: Some(emission.to_array()), ..none });
        assert_eq!(glowing, Sphere { emission, ..before });
    }

    #[test]
    fn a_shared_material_changes_for_one_sphere_alone() {
        let mut model = model("cornell");
        let before = model.now().scene();
        let black = Material::Diffuse { albedo: Rgb::ZERO };
        let parts = SphereParts { material: Some(black), ..SphereParts::default() };
        model.apply(Change::Sphere(3, parts)).unwrap();
        let after = model.now().scene();
        let material = |scene: &Scene, i: usize| scene.materials[scene.spheres[i].material as usize];
        assert_eq!(material(&after, 3), black);
        for i in (0..9).filter(|i| *i != 3) {
            assert_eq!(material(&after, i), material(&before, i));
        }
    }

    /// Two are enough to share one.
    #[test]
    fn a_material_of_two_spheres_changes_for_one_alone() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let (shared, black) =
            (Material::Diffuse { albedo: Rgb::splat(0.25) }, Material::Diffuse { albedo: Rgb::ZERO });
        scene.materials.push(shared);
        for i in [3, 4] {
            scene.spheres[i].material = scene.materials.len() as u32 - 1;
        }
        let mut model = Model::new(&scene, EngineChoice::default());
        let parts = SphereParts { material: Some(black), ..SphereParts::default() };
        model.apply(Change::Sphere(3, parts.clone())).unwrap();
        let of = |model: &Model, i: usize| model.materials()[model.spheres()[i].material as usize];
        assert_eq!([of(&model, 3), of(&model, 4)], [black, shared]);
        // The last that has it needs no other.
        let count = model.materials().len();
        model.apply(Change::Sphere(4, parts)).unwrap();
        assert_eq!((of(&model, 4), model.materials().len()), (black, count));
    }

    /// The walls of cornell that share a material.
    #[test]
    fn a_style_is_changed_of_all_its_spheres() {
        let mut model = model("cornell");
        let before = model.now().scene();
        let styles = before.spheres.iter().map(|sphere| sphere.material);
        let style =
            styles.clone().find(|style| styles.clone().filter(|other| other == style).count() > 1).unwrap();
        let index = before.spheres.iter().position(|sphere| sphere.material == style).unwrap();
        let black = Material::Diffuse { albedo: Rgb::ZERO };
        let radius = Some(before.spheres[index].radius * 1.5);
        let emission = Some([1.0, 2.0, 3.0]);
        let parts = SphereParts { material: Some(black), radius, emission, ..SphereParts::default() };
        model.apply(Change::Style(index, parts)).unwrap();
        let after = model.now().scene();
        for (old, new) in before.spheres.iter().zip(&after.spheres) {
            let is_styled = old.material == style;
            assert_eq!(new.center, old.center);
            assert_eq!(new.radius, if is_styled { old.radius * 1.5 } else { old.radius });
            assert_eq!(new.emission, if is_styled { Rgb::new(1.0, 2.0, 3.0) } else { old.emission });
            let [was, is] = [(&before, old), (&after, new)]
                .map(|(scene, sphere)| scene.materials[sphere.material as usize]);
            assert_eq!(is, if is_styled { black } else { was });
        }
        assert!(model.undo());
        assert_eq!(model.now().scene(), before);
        let problem = model.apply(Change::Style(99, SphereParts::default())).unwrap_err();
        assert_eq!(problem, "there is no sphere 100; there are 9");
    }

    #[test]
    fn what_cannot_be_rendered_is_refused_and_changes_nothing() {
        let mut model = model("cornell");
        let before = model.now().scene();
        let sphere = |parts| Change::Sphere(5, parts);
        let settings = |seed: &str| SettingsParts { seed: Some(seed.into()), ..SettingsParts::default() };
        for (change, told) in [
            (moved(&model, 49.0), "cuts through"),
            (moved(&model, f32::NAN), "eye"),
            (moved(&model, 1000.0), "no light reaches the eye"),
            (sphere(SphereParts { radius: Some(-1.0), ..SphereParts::default() }), "radius"),
            (Change::Sphere(9, SphereParts::default()), "there is no sphere 10; there are 9"),
            (Change::Settings(SettingsParts { width: Some(0), ..SettingsParts::default() }), "width"),
            (Change::Settings(settings("-1")), "seed"),
        ] {
            let problem = model.apply(change.clone()).expect_err("it cannot be rendered");
            assert!(problem.contains(told) || told == "cuts through", "{change:?}: {problem}");
            assert!(!problem.contains('\n'));
        }
        assert_eq!(model.now().scene(), before);
        assert_eq!(model.steps(), [false; 3]);
        model.apply(Change::Settings(settings("18446744073709551615"))).unwrap();
        assert_eq!(model.now().settings.seed, u64::MAX);
    }
}
