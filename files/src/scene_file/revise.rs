//! Changes the text of a scene file so that it states another camera, other settings or other spheres, and keeps the rest:
//! comments, order, names and spelling.

use super::parse_with_automatic;
use scene::{Automatic, Camera, Filter, Material, Scene, Settings, Sphere, Vec3};
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Longer texts are not revised: each value of theirs would take hundreds of bytes of memory.
const MAX_BYTES: usize = 1 << 24;

/// The scene file `text`, changed where it must be to state `scene` with its settings; everything else stays as it is.
///
/// `None` if that cannot be done: if the text is no scene file, or of other spheres, or longer than 16 MiB. Then
/// [`super::to_text`] states the scene.
pub fn revise(text: &str, scene: &Scene) -> Option<String> {
    if text.len() > MAX_BYTES {
        return None;
    }
    let (before, open) = parse_with_automatic("scene.toml", text).ok()?;
    let mut document: DocumentMut = text.parse().ok()?;
    if before.camera != scene.camera {
        revise_camera(document.get_mut("camera")?.as_table_like_mut()?, &before.camera, &scene.camera);
    }
    if before.settings != scene.settings || open.any() {
        let settings = document.entry("settings").or_insert(Item::Table(Table::new()));
        revise_settings(settings.as_table_like_mut()?, (&before.settings, open), &scene.settings)?;
    }
    let material = |scene: &Scene, sphere: &Sphere| scene.materials.get(sphere.material as usize).copied();
    let pairs = before.without_sky().iter().zip(scene.without_sky()).enumerate();
    for (i, (old, new)) in pairs {
        let materials = [material(&before, old)?, material(scene, new)?];
        let place = |sphere: &Sphere| (sphere.center, sphere.radius, sphere.emission, sphere.velocity);
        if place(old) != place(new) || materials[0] != materials[1] {
            let sphere = document.get_mut("sphere")?.as_array_of_tables_mut()?.get_mut(i)?;
            revise_sphere(sphere, [old, new], materials);
        }
    }
    let revised = document.to_string();
    let (after, still_open) = parse_with_automatic("scene.toml", &revised).ok()?;
    (is_same(&after, scene) && !still_open.any()).then_some(revised)
}

/// The names of the spheres in a scene file, in its order; empty if it cannot be read, or is too long to be revised.
pub fn sphere_names(text: &str) -> Vec<Option<String>> {
    if text.len() > MAX_BYTES {
        return Vec::new();
    }
    let Ok(document) = text.parse::<DocumentMut>() else { return Vec::new() };
    let spheres = document.get("sphere").and_then(Item::as_array_of_tables);
    let name = |sphere: &Table| sphere.get("name").and_then(Item::as_str).map(str::to_owned);
    spheres.into_iter().flatten().map(name).collect()
}

/// Whether two scenes render alike: all but their names and the order of their materials.
fn is_same(a: &Scene, b: &Scene) -> bool {
    let spheres = |scene: &Scene| -> Vec<(Sphere, Option<Material>)> {
        let material = |sphere: &Sphere| scene.materials.get(sphere.material as usize).copied();
        scene.spheres.iter().map(|sphere| (Sphere { material: 0, ..*sphere }, material(sphere))).collect()
    };
    let rest = |scene: &Scene| (scene.camera, scene.background, scene.transparent_background, scene.settings);
    rest(a) == rest(b) && spheres(a) == spheres(b)
}

fn revise_camera(table: &mut dyn TableLike, old: &Camera, new: &Camera) {
    if old.eye != new.eye {
        set(table, "eye", vector(new.eye));
    }
    // A target is where the direction leads from the eye, and it is in focus.
    let has_target = table.contains_key("target");
    if old.direction != new.direction || (has_target && old.eye != new.eye) {
        if has_target {
            replace_target(table, new.direction);
            set(table, "focus_distance", number(new.focus_distance));
        } else {
            set(table, "direction", vector(new.direction));
        }
    }
    if old.up != new.up {
        set(table, "up", vector(new.up));
    }
    let numbers = [
        ("vertical_fov_degrees", old.vertical_fov_degrees, new.vertical_fov_degrees),
        ("aperture_radius", old.aperture_radius, new.aperture_radius),
        ("focus_distance", old.focus_distance, new.focus_distance),
    ];
    for (key, old, new) in numbers {
        if old != new {
            set(table, key, number(new));
        }
    }
    if new.aperture_radius > 0.0 && !table.contains_key("focus_distance") {
        set(table, "focus_distance", number(new.focus_distance));
    }
    if old.shutter != new.shutter {
        set(table, "shutter", new.shutter.iter().map(|time| number(*time)).collect::<Array>().into());
    }
}

/// Puts a direction in place of the target.
fn replace_target(table: &mut dyn TableLike, direction: Vec3) {
    table.remove("target");
    set(table, "direction", vector(direction));
}

/// States what differs, and what was left to be chosen.
fn revise_settings(
    table: &mut dyn TableLike,
    (old, open): (&Settings, Automatic),
    new: &Settings,
) -> Option<()> {
    let whole = [
        ("width", old.width, new.width, false),
        ("height", old.height, new.height, false),
        ("iterations", old.iterations, new.iterations, open.iterations),
        (
            "photons_per_iteration",
            old.photons_per_iteration,
            new.photons_per_iteration,
            open.photons_per_iteration,
        ),
        ("max_depth", old.max_depth, new.max_depth, open.max_depth),
        ("light_samples", old.light_samples, new.light_samples, false),
    ];
    for (key, old, new, is_open) in whole {
        if old != new || is_open {
            set(table, key, i64::from(new).into());
        }
    }
    if old.initial_radius != new.initial_radius || open.initial_radius {
        set(table, "initial_radius", number(new.initial_radius));
    }
    // Once a radius is stated, pilots and clearance are not left open unless the file says so.
    let are_open = open.radius_pilots && table.contains_key("radius_pilots");
    if old.radius_pilots != new.radius_pilots || are_open {
        set(table, "radius_pilots", i64::from(new.radius_pilots).into());
    }
    let is_open = open.radius_clearance && table.contains_key("radius_clearance");
    if old.radius_clearance != new.radius_clearance || is_open {
        set(table, "radius_clearance", number(new.radius_clearance));
    }
    let is_open = open.glint_samples && table.contains_key("glint_samples");
    if old.glint_samples != new.glint_samples || is_open {
        set(table, "glint_samples", i64::from(new.glint_samples).into());
    }
    if old.seed != new.seed {
        set(table, "seed", i64::try_from(new.seed).ok()?.into());
    }
    if old.filter != new.filter {
        set(table, "filter", Filter::name(new.filter).into());
    }
    Some(())
}

fn revise_sphere(table: &mut Table, [old, new]: [&Sphere; 2], [before, after]: [Material; 2]) {
    for (key, old, new) in [
        ("center", old.center, new.center),
        ("emission", old.emission, new.emission),
        ("velocity", old.velocity, new.velocity),
    ] {
        if old != new {
            set(table, key, vector(new));
        }
    }
    if old.radius != new.radius {
        set(table, "radius", number(new.radius));
    }
    if before != after {
        set(table, "material", material(&after));
    }
}

/// Sets a value; what stands around it, such as a comment behind it, stays.
fn set(table: &mut dyn TableLike, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(there) => {
            *value.decor_mut() = there.decor().clone();
            *there = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

fn material(material: &Material) -> Value {
    let mut table = InlineTable::new();
    let kind = match material {
        Material::Diffuse { .. } => "diffuse",
        Material::Specular { .. } => "specular",
        Material::Dielectric { .. } => "dielectric",
    };
    table.insert("type", kind.into());
    table.insert("albedo", vector(material.albedo()));
    if let Material::Dielectric { ior, .. } = material {
        table.insert("ior", number(*ior));
    }
    table.into()
}

fn vector(vector: Vec3) -> Value {
    vector.to_array().iter().map(|v| number(*v)).collect::<Array>().into()
}

/// A number such that it reads back as the same `f32`: with as few digits as that takes, and without a point if it is
/// whole.
fn number(value: f32) -> Value {
    /// Whole numbers up to here are written without a point.
    const PLAIN: f32 = 1e6;
    if value.fract() == 0.0 && value.abs() <= PLAIN && !(value == 0.0 && value.is_sign_negative()) {
        return (value as i64).into();
    }
    let short = value.to_string().parse::<f64>().ok();
    short.filter(|short| *short as f32 == value).unwrap_or(f64::from(value)).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::SCENES;
    use crate::scene_file::parse;
    use scene::Rgb;

    #[test]
    fn a_scene_that_is_not_changed_keeps_its_text() {
        let stated: Vec<_> = SCENES.iter().filter(|builtin| !builtin.open().1.any()).collect();
        assert!(stated.len() >= 2);
        for builtin in stated {
            assert_eq!(revise(builtin.text, &builtin.scene()).as_deref(), Some(builtin.text));
        }
    }

    /// So that whoever renders the text renders the same.
    #[test]
    fn what_was_left_to_be_chosen_is_stated() {
        for builtin in SCENES {
            let revised = revise(builtin.text, &builtin.scene()).unwrap();
            let (scene, open) = parse_with_automatic("again.toml", &revised).unwrap();
            assert!(!open.any() && scene.settings == builtin.scene().settings, "{}: {revised}", builtin.name);
        }
        // Each by itself, whatever else is stated.
        let numbers = "iterations = 3\nphotons_per_iteration = 500\nmax_depth = 4\ninitial_radius = 2\n";
        let (head, rest) = crate::builtin::find("cornell").unwrap().text.split_once("[settings]").unwrap();
        let (_, rest) = rest.split_once("[materials.white]").unwrap();
        for key in ["radius_pilots", "radius_clearance", "glint_samples"] {
            let text = format!("{head}[settings]\n{numbers}{key} = \"auto\"\n[materials.white]{rest}");
            let (scene, open) = parse_with_automatic("open.toml", &text).unwrap();
            assert!(open.any(), "{key}");
            let revised = revise(&text, &scene).unwrap();
            assert!(!parse_with_automatic("again.toml", &revised).unwrap().1.any(), "{revised}");
        }
    }

    /// Every line but those changed stays, comments behind changed values too.
    #[test]
    fn only_what_is_changed_is_written() {
        let text = crate::builtin::find("cornell").unwrap().text;
        let mut scene = crate::builtin::scene("cornell").unwrap();
        scene.camera.direction = Vec3::new(0.1, -0.25, -1.0);
        scene.settings.iterations = 42;
        scene.spheres[6].center.x = 60.5;
        let red = Material::Dielectric { albedo: Rgb::new(1.0, 0.1, 0.1), ior: 1.5 };
        scene.spheres[6].material = scene.materials.len() as u32;
        scene.materials.push(red);
        scene.spheres[7].emission = Rgb::new(30.0, 10.0, 10.0);
        let revised = revise(text, &scene).unwrap();
        let mut changed = text.lines().zip(revised.lines()).filter(|(old, new)| old != new);
        let mut next = || changed.next().unwrap().1;
        assert_eq!(text.lines().count(), revised.lines().count());
        assert_eq!(
            next(),
            "direction = [0.1, -0.25, -1] # of any length; target = [x, y, z] would do as well"
        );
        assert_eq!(next(), "iterations = 42");
        assert_eq!(next(), "photons_per_iteration = 200000");
        assert_eq!(next(), "max_depth = 5");
        assert_eq!(next(), "initial_radius = 2 # in scene units");
        assert_eq!(next(), "center = [60.5, 16.5, 78]");
        assert_eq!(next(), "material = { type = \"dielectric\", albedo = [1, 0.1, 0.1], ior = 1.5 }");
        assert_eq!(next(), "emission = [30, 10, 10]");
        assert!(changed.next().is_none());
    }

    /// Cameras with a target and a lens, skies, and scenes without settings among them.
    #[test]
    fn what_is_written_is_the_scene_that_was_meant() {
        for builtin in SCENES {
            let mut scene = builtin.scene();
            let sky = scene.background;
            let spheres = scene.without_sky().len();
            scene.spheres.truncate(spheres);
            scene.materials.truncate(scene.materials.len() - usize::from(sky != Rgb::ZERO));
            scene.camera.eye += Vec3::new(0.125, 0.1, -0.3);
            scene.camera.vertical_fov_degrees *= 0.9;
            scene.settings = Settings {
                seed: 7,
                initial_radius: 0.1,
                filter: Filter::Mitchell,
                light_samples: 3,
                glint_samples: 5,
                radius_clearance: 0.6,
                ..scene.settings
            };
            let last = scene.spheres.len() - 1;
            scene.spheres[last].radius *= 0.99;
            scene.spheres[last].material = scene.materials.len() as u32;
            scene.materials.push(Material::Specular { albedo: Rgb::splat(1.0 / 3.0) });
            let scene = scene.with_sky();
            let revised = revise(builtin.text, &scene).unwrap_or_else(|| panic!("{}", builtin.name));
            assert!(is_same(&parse("again.toml", &revised).unwrap(), &scene), "{}", builtin.name);
        }
    }

    /// Readers round twice, to `f64` and to `f32`: what is short could become a neighbour.
    #[test]
    fn numbers_are_read_back_as_they_were() {
        for (value, text) in [
            (0.1, Some("0.1")),
            (-2.0, Some("-2")),
            (1e6, Some("1000000")),
            (f32::from_bits(0x15ae_43fd), None),
            (f32::MAX, None),
        ] {
            let written = number(value).to_string();
            assert_eq!((written.parse::<f64>().unwrap() as f32).to_bits(), value.to_bits(), "{written}");
            assert!(text.is_none_or(|text| text == written), "{written}");
        }
    }

    #[test]
    fn what_cannot_be_revised_is_not() {
        let scene = crate::builtin::scene("cornell").unwrap();
        let other = crate::builtin::find("mirror").unwrap().text;
        assert_eq!(revise("no scene", &scene), None);
        assert_eq!(revise(other, &scene), None);
    }

    /// The key of what is changed, and how it is.
    type Change = (&'static str, fn(&mut Scene));

    /// Beside the comments nothing is lost, whatever is changed, and whether or not the text has stated it before.
    #[test]
    fn each_part_of_a_scene_can_be_changed_by_itself() {
        const BARE: &str = "# a comment\n[camera]\neye = [0, 0, 10]\ndirection = [0, 0, -1]\nvertical_fov_degrees = 40\n\
            shutter = [0, 1]\n[settings]\niterations = 7\nphotons_per_iteration = 500\nmax_depth = 4\ninitial_radius = 1\n\
            [materials.white]\ntype = \"diffuse\"\nalbedo = [1, 1, 1]\n\
            [[sphere]]\ncenter = [0, 3, 0]\nradius = 1\nmaterial = \"white\"\nemission = [1, 1, 1]\n\
            [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"white\"\n";
        let stated = BARE
            .replace("shutter", "up = [0, 1, 0]\naperture_radius = 0\nfocus_distance = 1\nshutter")
            .replace(
                "iterations = 7",
                "width = 40\nheight = 30\niterations = 7\nseed = 1\nfilter = \"box\"\nradius_pilots = 2\n\
                radius_clearance = 0\nlight_samples = 1\nglint_samples = 1",
            )
            .replace(
                "[[sphere]]\ncenter = [0, 0, 0]",
                "[[sphere]]\nvelocity = [0, 0, 0]\ncenter = [0, 0, 0]",
            );
        let changes: [Change; 23] = [
            ("eye", |scene| scene.camera.eye.x = 0.5),
            ("direction", |scene| scene.camera.direction.y = 0.25),
            ("up", |scene| scene.camera.up = Vec3::new(0.5, 1.0, 0.0)),
            ("vertical_fov_degrees", |scene| scene.camera.vertical_fov_degrees = 33.5),
            ("aperture_radius", |scene| scene.camera.aperture_radius = 0.125),
            ("focus_distance", |scene| scene.camera.focus_distance = 9.5),
            ("shutter", |scene| scene.camera.shutter = [0.25, 0.5]),
            ("width", |scene| scene.settings.width = 123),
            ("height", |scene| scene.settings.height = 45),
            ("iterations", |scene| scene.settings.iterations = 8),
            ("photons_per_iteration", |scene| scene.settings.photons_per_iteration = 600),
            ("max_depth", |scene| scene.settings.max_depth = 9),
            ("initial_radius", |scene| scene.settings.initial_radius = 0.75),
            ("seed", |scene| scene.settings.seed = 99),
            ("filter", |scene| scene.settings.filter = Filter::Mitchell),
            ("radius_pilots", |scene| scene.settings.radius_pilots = 5),
            ("radius_clearance", |scene| scene.settings.radius_clearance = 0.5),
            ("light_samples", |scene| scene.settings.light_samples = 3),
            ("glint_samples", |scene| scene.settings.glint_samples = 6),
            ("center", |scene| scene.spheres[1].center.x = 0.5),
            ("radius", |scene| scene.spheres[1].radius = 0.5),
            ("emission", |scene| scene.spheres[1].emission = Rgb::X),
            ("velocity", |scene| scene.spheres[1].velocity = Vec3::X),
        ];
        for text in [BARE, &stated] {
            let before = parse("a.toml", text).unwrap();
            for (key, change) in changes {
                let mut scene = before.clone();
                change(&mut scene);
                assert_ne!(scene, before, "{key}");
                let revised = revise(text, &scene).unwrap_or_else(|| panic!("{key} in\n{text}"));
                assert_eq!(parse("a.toml", &revised).unwrap(), scene, "{key}");
                // Every line stays but for that of the key.
                let is_kept = |line: &str| line.starts_with(&format!("{key} = ")) || revised.contains(line);
                assert!(text.lines().all(is_kept), "{key}: {revised}");
            }
        }
    }

    /// A camera or settings in braces are revised within them.
    #[test]
    fn tables_in_braces_are_revised_as_well() {
        let text = "camera = { eye = [0, 0, 10], direction = [0, 0, -1], vertical_fov_degrees = 40 } # from the door\n\
            settings = { iterations = 3, photons_per_iteration = 500, max_depth = 4, initial_radius = 1 } # in a hurry\n\
            [[sphere]] # the lamp\ncenter = [0, 0, 0]\nradius = 1\nemission = [1, 1, 1]\n\
            material = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
        let mut scene = parse("a.toml", text).unwrap();
        scene.camera.eye = Vec3::new(0.5, 0.0, 10.0);
        scene.settings.max_depth = 9;
        let expected =
            text.replace("eye = [0, 0, 10]", "eye = [0.5, 0, 10]").replace("depth = 4", "depth = 9");
        assert_eq!(revise(text, &scene), Some(expected));
    }

    /// Rather than a text that states another scene, there is none.
    #[test]
    fn a_text_that_would_mean_another_scene_is_not_given() {
        let text = crate::builtin::find("cornell").unwrap().text;
        let scene = crate::builtin::scene("cornell").unwrap();
        assert!(revise(text, &scene).is_some());
        let changes: [fn(&mut Scene); 4] = [
            |scene| scene.settings.radius_schedule = scene::RadiusSchedule::Global,
            |scene| scene.settings.seed = u64::MAX,
            |scene| scene.transparent_background = true,
            |scene| scene.background = Rgb::ONE,
        ];
        for (k, change) in changes.into_iter().enumerate() {
            let mut other = scene.clone();
            change(&mut other);
            assert_eq!(revise(text, &other), None, "change {k}");
        }
    }

    #[test]
    fn names_are_in_the_order_of_the_file() {
        let names = sphere_names(crate::builtin::find("cornell").unwrap().text);
        assert_eq!(names.len(), 9);
        assert_eq!(names[6].as_deref(), Some("glass ball"));
        assert!(sphere_names("sphere = 1").is_empty() && sphere_names("{").is_empty());
    }

    /// Up to the longest; beyond it nothing is changed either.
    #[test]
    fn texts_have_names_as_long_as_they_can_be_changed() {
        let short = crate::builtin::find("cornell").unwrap();
        let of = |length: usize| short.text.to_owned() + &"#".repeat(length - short.text.len());
        let (longest, longer) = (of(MAX_BYTES), of(MAX_BYTES + 1));
        assert_eq!([longest.len(), longer.len()], [MAX_BYTES, MAX_BYTES + 1]);
        assert_eq!(sphere_names(&longest), sphere_names(short.text));
        assert!(sphere_names(&longer).is_empty());
        assert!(revise(&longer, &short.scene()).is_none());
    }

    /// Whatever else of the camera changes. Where it looks elsewhere, what was in focus by the target is stated.
    #[test]
    fn a_target_stays_while_the_camera_looks_at_it() {
        let text = "[camera]\neye = [0, 0, 10]\ntarget = [0, 0, 0] # the lamp\nvertical_fov_degrees = 40\n\
            [settings]\niterations = 3\nphotons_per_iteration = 500\nmax_depth = 4\ninitial_radius = 1\n\
            [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nemission = [1, 1, 1]\n\
            material = { type = \"diffuse\", albedo = [1, 1, 1] }\n";
        let scene = parse("a.toml", text).unwrap();
        let revised = |change: fn(&mut Camera)| {
            let mut scene = scene.clone();
            change(&mut scene.camera);
            revise(text, &scene).unwrap()
        };
        let narrow = revised(|camera| camera.vertical_fov_degrees = 35.0);
        assert_eq!(narrow, text.replace("degrees = 40", "degrees = 35"));
        let near = revised(|camera| camera.focus_distance = 9.0);
        assert_eq!(near, text.replace("degrees = 40\n", "degrees = 40\nfocus_distance = 9\n"));
        let aside = revised(|camera| camera.direction.x = 1.0);
        assert!(!aside.contains("target") && aside.contains("\ndirection = [1, 0, -10]\n"), "{aside}");
        assert!(aside.contains("\nfocus_distance = 10\n"), "{aside}");
    }

    /// A lens needs a distance of focus, though it is that which a pinhole would have.
    #[test]
    fn a_lens_gets_a_distance_of_focus() {
        let text = "[camera]\neye = [0, 0, 9]\ndirection = [0, 0, -1]\nvertical_fov_degrees = 30\n\
                    [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nemission = [1, 1, 1]\nmaterial = { type = \"diffuse\", albedo = [1, 1, 1] }\n\
                    [settings]\niterations = 1\nphotons_per_iteration = 1\nmax_depth = 1\ninitial_radius = 1\nradius_pilots = 0\n";
        let mut scene = parse("a.toml", text).unwrap();
        assert_eq!(revise(text, &scene).as_deref(), Some(text));
        scene.camera.aperture_radius = 0.5;
        let revised = revise(text, &scene).unwrap();
        assert!(
            revised.contains("aperture_radius = 0.5\n") && revised.contains("focus_distance = 1"),
            "{revised}"
        );
        scene.camera.shutter = [0.0, 2.0];
        assert!(revise(text, &scene).unwrap().contains("shutter = [0, 2]"));
        // A pinhole has none.
        scene.camera.aperture_radius = 0.0;
        assert!(!revise(text, &scene).unwrap().contains("focus_distance"));
    }
}
