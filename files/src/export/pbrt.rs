//! Exports a scene to pbrt-v4: its text format with analytic spheres.

use super::view::{Exported, View, comment};
use scene::still::Role;
use scene::{Material, Rgb, Sphere};
use std::fmt::Write as _;

/// Maximum path depth, in effect unlimited: pbrt has no value for that.
const MAX_DEPTH: u32 = 100_000;

/// The scene as a file for pbrt.
pub(super) fn write(view: &View) -> Exported {
    let notes: Vec<String> = view.still.materials.iter().enumerate().filter_map(note).collect();
    let mut lines: Vec<String> =
        view.introduction().iter().chain(&notes).map(|line| format!("# {}", comment(line))).collect();
    lines.extend(camera(view));
    lines.push("WorldBegin".into());
    for (index, material) in view.still.materials.iter().enumerate() {
        lines.push(format!("MakeNamedMaterial \"material-{index}\" {}", parameters(material)));
    }
    let mut text = lines.join("\n") + "\n";
    // One at a time: millions of lines would take several times the memory of their text.
    for (sphere, role) in view.still.spheres.iter().zip(view.still.roles.iter()) {
        for line in shape(sphere, *role) {
            text += &line;
            text.push('\n');
        }
    }
    Exported { text, notes }
}

/// How pbrt's material differs from ours, if it does.
fn note((index, material): (usize, &Material)) -> Option<String> {
    match *material {
        Material::Specular { .. } => Some(format!(
            "material-{index}: mirrors of pbrt are metals, which reflect more at grazing angles than sppm's do"
        )),
        Material::Dielectric { albedo, .. } if albedo != Rgb::ONE => {
            Some(format!("material-{index}: glass of pbrt has no tint; left out was {}", color(albedo)))
        }
        Material::Diffuse { .. } | Material::Dielectric { .. } => None,
    }
}

fn camera(view: &View) -> Vec<String> {
    let camera = view.camera;
    // pbrt's field of view is that of the shorter side of the image.
    let (width, height) = (f64::from(view.width), f64::from(view.height));
    let vertical = f64::from(camera.vertical_fov_degrees);
    let fov = if width < height {
        2.0 * ((vertical.to_radians() / 2.0).tan() * width / height).atan().to_degrees()
    } else {
        vertical
    };
    let [eye, up] = [camera.eye, camera.up].map(|v| v.as_dvec3().to_array());
    let look: Vec<String> = [eye, view.target(), up].iter().map(|v| numbers(v)).collect();
    let mut perspective = format!("Camera \"perspective\" \"float fov\" [ {fov} ]");
    if camera.aperture_radius > 0.0 {
        let (radius, distance) = (camera.aperture_radius, camera.focus_distance);
        let _ =
            write!(perspective, " \"float lensradius\" [ {radius} ] \"float focaldistance\" [ {distance} ]");
    }
    vec![
        "Scale -1 1 1 # pbrt is left-handed".into(),
        format!("LookAt {}", look.join("  ")),
        perspective,
        format!("Sampler \"independent\" \"integer pixelsamples\" [ {} ]", view.samples),
        format!("Integrator \"path\" \"integer maxdepth\" [ {MAX_DEPTH} ]"),
        {
            let (name, radius) = (view.filter, view.filter.radius());
            // The other parameters are the defaults of pbrt-v4.
            format!("PixelFilter \"{name}\" \"float xradius\" [ {radius} ] \"float yradius\" [ {radius} ]")
        },
        format!(
            "Film \"rgb\" \"integer xresolution\" [ {} ] \"integer yresolution\" [ {} ] \"string filename\" [ \"out.exr\" ]",
            view.width, view.height
        ),
    ]
}

/// Type and parameters of a material.
fn parameters(material: &Material) -> String {
    match *material {
        Material::Diffuse { albedo } => {
            format!("\"string type\" [ \"diffuse\" ] \"rgb reflectance\" [ {} ]", color(albedo))
        }
        Material::Specular { albedo } => {
            format!("\"string type\" [ \"conductor\" ] \"rgb reflectance\" [ {} ]", color(albedo))
        }
        Material::Dielectric { ior, .. } => {
            format!("\"string type\" [ \"dielectric\" ] \"float eta\" [ {ior} ]")
        }
    }
}

fn shape(sphere: &Sphere, role: Role) -> Vec<String> {
    let mut lines = vec!["AttributeBegin".to_owned()];
    if matches!(role, Role::Enclosure(_)) {
        lines.push("  ReverseOrientation # seen, and lit, from inside".into());
    }
    lines.push(format!("  NamedMaterial \"material-{}\"", sphere.material));
    if sphere.is_emitter() {
        let both = if role == Role::Glass { " \"bool twosided\" [ true ]" } else { "" };
        lines.push(format!("  AreaLightSource \"diffuse\" \"rgb L\" [ {} ]{both}", color(sphere.emission)));
    }
    lines.push(format!("  Translate {}", numbers(&sphere.center.to_array())));
    lines.push(format!("  Shape \"sphere\" \"float radius\" [ {} ]", sphere.radius));
    lines.push("AttributeEnd".into());
    lines
}

fn color(color: Rgb) -> String {
    numbers(&color.to_array())
}

fn numbers<T: ToString>(values: &[T]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Told is what pbrt shows otherwise, and nothing else.
    #[test]
    fn notes_are_of_mirrors_and_tinted_glass() {
        let glass = |albedo| Material::Dielectric { albedo, ior: 1.5 };
        let tint = Rgb::new(1.0, 0.5, 1.0);
        let notes = |material| note((3, &material));
        assert_eq!(notes(Material::Diffuse { albedo: tint }), None);
        assert_eq!(notes(glass(Rgb::ONE)), None);
        let tinted = notes(glass(tint)).unwrap();
        assert!(tinted.starts_with("material-3: ") && tinted.ends_with("left out was 1 0.5 1"), "{tinted}");
        let mirror = notes(Material::Specular { albedo: Rgb::ONE }).unwrap();
        assert!(mirror.starts_with("material-3: mirrors"), "{mirror}");
    }
}
