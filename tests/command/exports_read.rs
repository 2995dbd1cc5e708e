//! Exported scenes, read by the rules of the renderers that they are for: every term of the camera, of materials, shapes
//! and lights, and which way is left.

use crate::sandbox::Sandbox;
use glam::{DMat4, DVec3};
use roxmltree::{Document, Node};
use scene::camera::Frame;
use scene::still::Role;
use scene::{Material, Rgb, Scene};

/// Everything that an export can hold: a lens, an oblique view of no unit length, glass, a mirror, a lamp, motion; and a room
/// so large that the world is moved for Mitsuba.
const EVERYTHING: &str = r#"
name = "everything"
[camera]
eye = [1.0, 2.5, 3.0]
direction = [0.6, -0.4, -4.0]
up = [0.2, 1.0, 0.3]
vertical_fov_degrees = 35.0
aperture_radius = 0.25
focus_distance = 4.5
shutter = [0.0, 2.0]
[settings]
width = 60
height = 30
filter = "mitchell"
[materials.room]
type = "diffuse"
albedo = [0.7, 0.6, 0.5]
[materials.glass]
type = "dielectric"
albedo = [0.9, 0.8, 0.7]
ior = 1.7
[materials.silver]
type = "specular"
albedo = [0.95, 0.93, 0.88]
[[sphere]]
center = [0.5, 0.25, -1.0]
radius = 5000.0
material = "room"
emission = [0.125, 0.25, 0.5]
[[sphere]]
center = [1.0, 2.0, -3.0]
velocity = [0.5, 0.0, 0.25]
radius = 1.25
material = "glass"
[[sphere]]
center = [-2.0, 1.0, -4.0]
radius = 1.5
material = "silver"
[[sphere]]
center = [0.0, 6.0, -2.0]
radius = 0.5
material = "room"
emission = [30.0, 20.0, 10.0]
"#;

/// The instant that is exported.
const TIME: f32 = 1.5;

/// What a renderer takes from a file.
#[derive(Debug)]
struct Read {
    eye: DVec3,
    /// Unit vectors in the world: to the right and to the top of the image, and ahead.
    right: DVec3,
    up: DVec3,
    ahead: DVec3,
    /// Of the image's height.
    fov_degrees: f64,
    aperture: f64,
    focus: f64,
    size: [f64; 2],
    filter: String,
    shapes: Vec<Shape>,
}

#[derive(Debug)]
struct Shape {
    center: DVec3,
    radius: f64,
    /// Whether it is seen from inside.
    turned: bool,
    emission: [f64; 3],
    material: Surface,
}

#[derive(Clone, Debug, PartialEq)]
enum Surface {
    Diffuse([f64; 3]),
    Mirror([f64; 3]),
    /// Interior index over exterior; tint of what is reflected and transmitted.
    Glass(f64, [f64; 3], [f64; 3]),
}

/// Relative tolerance: coordinates are written as `f32`, and the camera's frame is computed in `f64`.
const WRITTEN: f64 = 1e-5;

#[track_caller]
fn assert_near(actual: DVec3, expected: DVec3, what: &str) {
    let error = actual.distance(expected) / expected.length().max(1.0);
    assert!(error < WRITTEN, "{what}: {actual}, not {expected}");
}

/// The scene, read from the file that `sppm export` writes.
fn exported(format: &str, more: &[&str]) -> (Scene, String) {
    let sandbox = Sandbox::new();
    sandbox.write("everything.toml", EVERYTHING);
    let args = ["export", "everything.toml", "--format", format, "--time", "1.5"];
    let ended = sandbox.run(args.iter().chain(more));
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    (files::scene_file::parse("everything.toml", EVERYTHING).unwrap(), ended.stdout)
}

/// Asserts that `read`, whose world is moved by `shift`, is `scene`; of pbrt's materials, which have less, only what they
/// have.
#[track_caller]
fn assert_is(read: &Read, scene: &Scene, [width, height]: [u32; 2], shift: DVec3, is_pbrt: bool) {
    let (camera, frame): (_, Frame) = (scene.camera, scene.camera.frame(width, height));
    assert_near(read.eye, camera.eye.as_dvec3() + shift, "eye");
    assert_near(read.right, frame.right.as_dvec3(), "to the right");
    assert_near(read.up, frame.up.as_dvec3(), "to the top");
    assert_near(read.ahead, frame.forward.as_dvec3(), "ahead");
    assert!((read.fov_degrees / f64::from(camera.vertical_fov_degrees) - 1.0).abs() < WRITTEN, "{read:?}");
    assert_eq!((read.aperture, read.focus), (camera.aperture_radius.into(), camera.focus_distance.into()));
    assert_eq!(read.size, [width, height].map(f64::from));
    assert_eq!(read.filter, scene.settings.filter.name());
    let still = scene.at(TIME);
    assert_eq!(read.shapes.len(), still.spheres.len());
    for ((shape, sphere), role) in read.shapes.iter().zip(&*still.spheres).zip(still.roles.iter()) {
        assert_near(shape.center, sphere.center.as_dvec3() + shift, "centre");
        assert_eq!(shape.radius, f64::from(sphere.radius));
        assert_eq!(shape.turned, matches!(role, Role::Enclosure(_)));
        assert!(same(shape.emission, sphere.emission), "{shape:?}");
        match (&shape.material, scene.materials[sphere.material as usize]) {
            (Surface::Diffuse(a), Material::Diffuse { albedo })
            | (Surface::Mirror(a), Material::Specular { albedo }) => assert!(same(*a, albedo), "{shape:?}"),
            (Surface::Glass(index, r, t), Material::Dielectric { albedo, ior }) => {
                let tint = if is_pbrt { Rgb::ONE } else { albedo };
                assert!((index / f64::from(ior) - 1.0).abs() < WRITTEN, "{shape:?}");
                assert!(same(*r, tint) && same(*t, tint), "{shape:?}");
            }
            other => panic!("{other:?}"),
        }
    }
}

fn same(actual: [f64; 3], expected: Rgb) -> bool {
    actual.map(|v| v as f32) == expected.to_array()
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(|word| word.parse().unwrap_or_else(|_| panic!("{text}"))).collect()
}

fn three(text: &str) -> [f64; 3] {
    numbers(text).try_into().unwrap()
}

/// The child with this name, whatever its tag.
fn named<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.attribute("name") == Some(name))
}

fn value<'a>(node: Node<'a, 'a>, name: &str) -> Option<&'a str> {
    named(node, name)?.attribute("value")
}

fn float(node: Node, name: &str) -> f64 {
    value(node, name).unwrap_or_else(|| panic!("no {name}")).parse().unwrap()
}

/// Reads as Mitsuba 3 does.
fn read_mitsuba(text: &str) -> Read {
    let document = Document::parse(text).unwrap();
    let root = document.root_element();
    let sensor = root.children().find(|node| node.has_tag_name("sensor")).unwrap();
    assert_eq!(sensor.attribute("type"), Some("thinlens"));
    assert_eq!(value(sensor, "fov_axis"), Some("y"));
    let transform = named(sensor, "to_world").unwrap();
    let steps: Vec<Node> = transform.children().filter(Node::is_element).collect();
    assert!(steps.len() == 1 && steps[0].has_tag_name("lookat"), "a view by `lookat` alone is not mirrored");
    let [eye, target, up] = ["origin", "target", "up"].map(|name| {
        let text = steps[0].attribute(name).unwrap_or_else(|| panic!("no {name}"));
        DVec3::from_array(three(text))
    });
    let ahead = (target - eye).normalize();
    // `lookat` turns x to the left of the image, y to its top, z ahead.
    let left = up.cross(ahead).normalize();
    let film = sensor.children().find(|node| node.has_tag_name("film")).unwrap();
    let filter = film.children().find(|node| node.has_tag_name("rfilter")).unwrap();
    let (far, near) = (float(sensor, "far_clip"), float(sensor, "near_clip"));
    let shapes: Vec<Shape> = root
        .children()
        .filter(|node| node.has_tag_name("shape"))
        .map(|shape| {
            assert_eq!(shape.attribute("type"), Some("sphere"));
            let center = named(shape, "center").unwrap();
            let id = shape.children().find(|node| node.has_tag_name("ref")).unwrap().attribute("id");
            let bsdf = root.children().find(|node| node.has_tag_name("bsdf") && node.attribute("id") == id);
            let emitter = shape.children().find(|node| node.has_tag_name("emitter"));
            Shape {
                center: DVec3::from_array(
                    ["x", "y", "z"].map(|axis| center.attribute(axis).unwrap().parse().unwrap()),
                ),
                radius: float(shape, "radius"),
                turned: value(shape, "flip_normals") == Some("true"),
                emission: emitter.map_or([0.0; 3], |emitter| three(value(emitter, "radiance").unwrap())),
                material: mitsuba_surface(bsdf.unwrap()),
            }
        })
        .collect();
    let farthest = shapes.iter().map(|shape| shape.center.distance(eye) + shape.radius).fold(0.0, f64::max);
    assert!(near < 0.5 && far > farthest, "clips from {near} to {far}, of {farthest}");
    Read {
        eye,
        right: -left,
        up: ahead.cross(left),
        ahead,
        fov_degrees: float(sensor, "fov"),
        aperture: float(sensor, "aperture_radius"),
        focus: float(sensor, "focus_distance"),
        size: ["width", "height"].map(|name| float(film, name)),
        filter: filter.attribute("type").unwrap().into(),
        shapes,
    }
}

fn mitsuba_surface(bsdf: Node) -> Surface {
    let color = |name| three(value(bsdf, name).unwrap_or_else(|| panic!("no {name}")));
    match bsdf.attribute("type").unwrap() {
        "diffuse" => Surface::Diffuse(color("reflectance")),
        "conductor" => {
            assert_eq!(value(bsdf, "material"), Some("none"), "else a metal absorbs");
            Surface::Mirror(color("specular_reflectance"))
        }
        "dielectric" => Surface::Glass(
            float(bsdf, "int_ior") / float(bsdf, "ext_ior"),
            color("specular_reflectance"),
            color("specular_transmittance"),
        ),
        other => panic!("{other}"),
    }
}

/// The number or numbers of a parameter of pbrt, such as `"float fov" [ 30 ]`.
fn parameter(line: &str, name: &str) -> Option<Vec<f64>> {
    let (_, rest) = line.split_once(&format!("\"{name}\" [ "))?;
    Some(numbers(rest.split_once(']').unwrap().0))
}

/// Reads as pbrt-v4 does, which keeps a current transformation from the world to the camera.
fn read_pbrt(text: &str) -> Read {
    let lines = || text.lines().map(|line| line.split('#').next().unwrap().trim()).filter(|l| !l.is_empty());
    let mut world_to_camera = DMat4::IDENTITY;
    let (mut materials, mut shapes) = (Vec::new(), Vec::new());
    let (mut fov, mut lens, mut size, mut filter) = (0.0, [0.0, 1e6], [0.0; 2], String::new());
    let mut shape: Option<Shape> = None;
    for line in lines() {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "Scale" => world_to_camera *= DMat4::from_scale(DVec3::from_array(three(rest))),
            "LookAt" => world_to_camera *= pbrt_look_at(&numbers(rest)),
            "Camera" => {
                fov = parameter(line, "float fov").unwrap()[0];
                let of = |name| parameter(line, name).map(|values| values[0]);
                lens = [of("float lensradius").unwrap_or(0.0), of("float focaldistance").unwrap_or(1e6)];
            }
            "PixelFilter" => {
                filter = rest.split('"').nth(1).unwrap().into();
                let radius = parameter(line, "float xradius").unwrap()[0];
                assert_eq!(parameter(line, "float yradius").unwrap(), [radius]);
                assert_eq!(radius, if filter == "box" { 0.5 } else { 2.0 });
            }
            "Film" => {
                size = ["integer xresolution", "integer yresolution"].map(|n| parameter(line, n).unwrap()[0]);
            }
            "MakeNamedMaterial" => materials.push((rest.split('"').nth(1).unwrap(), pbrt_surface(line))),
            "AttributeBegin" => {
                let (center, material) = (DVec3::ZERO, Surface::Diffuse([0.0; 3]));
                shape = Some(Shape { center, radius: 0.0, turned: false, emission: [0.0; 3], material });
            }
            "AttributeEnd" => shapes.extend(shape.take()),
            "Sampler" | "Integrator" | "WorldBegin" => {}
            word => {
                let shape = shape.as_mut().unwrap_or_else(|| panic!("{line}"));
                match word {
                    "ReverseOrientation" => shape.turned = true,
                    "Translate" => shape.center = DVec3::from_array(three(rest)),
                    "Shape" => shape.radius = parameter(line, "float radius").unwrap()[0],
                    "AreaLightSource" => {
                        shape.emission = parameter(line, "rgb L").unwrap().try_into().unwrap();
                    }
                    "NamedMaterial" => {
                        let found = materials.iter().find(|(id, _)| Some(*id) == rest.split('"').nth(1));
                        shape.material = found.unwrap().1.clone();
                    }
                    other => panic!("{other}"),
                }
            }
        }
    }
    let camera_to_world = world_to_camera.inverse();
    // In the camera's space x is to the right, y to the top, z ahead; the screen of the shorter side is 1.
    let axis = |v: DVec3| camera_to_world.transform_vector3(v);
    let shorter = (fov / 2.0_f64).to_radians().tan();
    let half_height = if size[0] < size[1] { shorter * size[1] / size[0] } else { shorter };
    Read {
        eye: camera_to_world.transform_point3(DVec3::ZERO),
        right: axis(DVec3::X),
        up: axis(DVec3::Y),
        ahead: axis(DVec3::Z),
        fov_degrees: 2.0 * half_height.atan().to_degrees(),
        aperture: lens[0],
        focus: lens[1],
        size,
        filter,
        shapes,
    }
}

/// pbrt's `LookAt`: from the world to a left-handed camera.
fn pbrt_look_at(v: &[f64]) -> DMat4 {
    let [eye, target, up] = [0, 3, 6].map(|at| DVec3::from_slice(&v[at..at + 3]));
    let ahead = (target - eye).normalize();
    let right = up.normalize().cross(ahead).normalize();
    let up = ahead.cross(right);
    DMat4::from_cols(right.extend(0.0), up.extend(0.0), ahead.extend(0.0), eye.extend(1.0)).inverse()
}

fn pbrt_surface(line: &str) -> Surface {
    let kind = line.split("\"string type\" [ \"").nth(1).unwrap().split('"').next().unwrap();
    let color = || parameter(line, "rgb reflectance").unwrap().try_into().unwrap();
    match kind {
        "diffuse" => Surface::Diffuse(color()),
        "conductor" => Surface::Mirror(color()),
        "dielectric" => Surface::Glass(parameter(line, "float eta").unwrap()[0], [1.0; 3], [1.0; 3]),
        other => panic!("{other}"),
    }
}

#[test]
fn mitsuba_reads_the_scene() {
    for [width, height] in [[60, 30], [30, 60]] {
        let [w, h] = [width, height].map(|side: u32| side.to_string());
        let (scene, text) = exported("mitsuba", &["--width", &w, "--height", &h]);
        let moved = text.split("moved by ").nth(1).expect("a room of this size is moved");
        let shift: f64 = moved.split(' ').next().unwrap().parse().unwrap();
        assert!(shift > 1.0);
        assert_is(&read_mitsuba(&text), &scene, [width, height], DVec3::Z * shift, false);
    }
}

#[test]
fn pbrt_reads_the_scene() {
    for [width, height] in [[60, 30], [30, 60]] {
        let [w, h] = [width, height].map(|side: u32| side.to_string());
        let (scene, text) = exported("pbrt", &["--width", &w, "--height", &h]);
        assert_is(&read_pbrt(&text), &scene, [width, height], DVec3::ZERO, true);
    }
}
