//! Exports a scene to Mitsuba 3: XML with analytic spheres.

use super::view::{Exported, View, comment};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use scene::still::Role;
use scene::{Material, Rgb, Sphere, Vec3};
use std::io;

/// Least distance of visible points from the world's origin, as a share of the largest radius.
///
/// Mitsuba starts rays at an offset of `9e-5 * (1 + max |p|)` from the surface at p. Near the origin that is less than
/// the rounding error of a point on a large sphere of radius r, about `6e-8 * r` per component, so the sphere would
/// shadow itself. Where |p| is at least this share of r, the offset is eight times the rounding error.
const SHIFT_PER_RADIUS: f32 = 1.0 / 200.0;

/// Bounces after which Russian roulette may end paths. More than Mitsuba's default of 5, because paths through glass
/// and mirrors take many.
const ROULETTE_DEPTH: &str = "16";

type Xml = Writer<Vec<u8>>;

/// The scene as a file for Mitsuba, or an error that says what Mitsuba cannot represent.
pub(super) fn write(view: &View) -> Result<Exported, String> {
    let spheres = view.still.spheres.iter().zip(view.still.roles.iter());
    if let Some((id, _)) = spheres.enumerate().find(|(_, (s, role))| s.is_emitter() && **role == Role::Glass)
    {
        return Err(format!(
            "{}: sphere {} of the file is of glass and glows; in Mitsuba a surface glows to one side only; export to pbrt",
            view.name,
            id + 1
        ));
    }
    let text = Scene { view, shift: shift(view) }
        .write()
        .and_then(|bytes| String::from_utf8(bytes).map_err(io::Error::other))
        .map_err(|error| format!("cannot make XML: {error}"))?;
    Ok(Exported { text, notes: Vec::new() })
}

/// How far the scene is moved along z, to keep visible surfaces away from the origin. A whole number, so that
/// coordinates lose few digits.
fn shift(view: &View) -> f32 {
    let spheres = &view.still.spheres;
    let margin = SHIFT_PER_RADIUS * spheres.iter().map(|s| s.radius).fold(0.0, f32::max);
    let things = spheres.iter().filter(|s| s.radius <= margin).map(|s| s.center.z - s.radius);
    let lowest = things.fold(view.camera.eye.z, f32::min);
    // Walls behind the objects are even lower; twice the margin covers a room that extends as far back.
    if lowest < 2.0 * margin { (2.0 * margin - lowest).ceil() } else { 0.0 }
}

struct Scene<'a> {
    view: &'a View<'a>,
    shift: f32,
}

impl Scene<'_> {
    fn write(&self) -> io::Result<Vec<u8>> {
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)))?;
        let mut lines = self.view.introduction();
        if self.shift != 0.0 {
            lines.push(format!(
                "The world is moved by {} along z, where Mitsuba loses light: see docs/oracle.md of sppm.",
                self.shift
            ));
        }
        for line in lines {
            let line = format!(" {} ", comment(&line));
            xml.write_event(Event::Comment(BytesText::from_escaped(line)))?;
        }
        xml.create_element("scene").with_attribute(("version", "3.0.0")).write_inner_content(|xml| {
            plugin(xml, "integrator", "path", |xml| {
                value(xml, "integer", "max_depth", "-1")?;
                value(xml, "integer", "rr_depth", ROULETTE_DEPTH)
            })?;
            self.sensor(xml)?;
            for (index, material) in self.view.still.materials.iter().enumerate() {
                bsdf(xml, index, material)?;
            }
            for (sphere, role) in self.view.still.spheres.iter().zip(self.view.still.roles.iter()) {
                self.shape(xml, sphere, *role)?;
            }
            Ok(())
        })?;
        let mut bytes = xml.into_inner();
        bytes.push(b'\n');
        Ok(bytes)
    }

    fn moved(&self, point: Vec3) -> Vec3 {
        point + Vec3::new(0.0, 0.0, self.shift)
    }

    fn sensor(&self, xml: &mut Xml) -> io::Result<()> {
        let (view, camera) = (self.view, self.view.camera);
        let is_pinhole = camera.aperture_radius == 0.0;
        plugin(xml, "sensor", if is_pinhole { "perspective" } else { "thinlens" }, |xml| {
            value(xml, "string", "fov_axis", "y")?;
            value(xml, "float", "fov", &camera.vertical_fov_degrees.to_string())?;
            if !is_pinhole {
                value(xml, "float", "aperture_radius", &camera.aperture_radius.to_string())?;
                value(xml, "float", "focus_distance", &camera.focus_distance.to_string())?;
            }
            let [near, far] = self.clip();
            value(xml, "float", "near_clip", &near.to_string())?;
            value(xml, "float", "far_clip", &far.to_string())?;
            let mut target = view.target();
            target[2] += f64::from(self.shift);
            xml.create_element("transform").with_attribute(("name", "to_world")).write_inner_content(
                |xml| {
                    let look = [
                        ("origin", numbers(&self.moved(camera.eye).to_array())),
                        ("target", numbers(&target)),
                        ("up", numbers(&camera.up.to_array())),
                    ];
                    let look = look.iter().map(|(name, value)| (*name, value.as_str()));
                    xml.create_element("lookat").with_attributes(look).write_empty().map(drop)
                },
            )?;
            plugin(xml, "sampler", "independent", |xml| {
                value(xml, "integer", "sample_count", &view.samples.to_string())
            })?;
            plugin(xml, "film", "hdrfilm", |xml| {
                value(xml, "integer", "width", &view.width.to_string())?;
                value(xml, "integer", "height", &view.height.to_string())?;
                value(xml, "string", "pixel_format", "rgb")?;
                value(xml, "string", "component_format", "float32")?;
                // Mitsuba's Gaussian has a standard deviation of 0.5 pixels as well, and its cubic B = C = 1/3.
                plugin(xml, "rfilter", view.filter.name(), |_| Ok(()))
            })
        })
    }

    /// Near and far clip distances that enclose all surfaces.
    fn clip(&self) -> [f32; 2] {
        let (eye, spheres) = (self.view.camera.eye, &self.view.still.spheres);
        let smallest = spheres.iter().map(|s| s.radius).fold(f32::INFINITY, f32::min);
        let farthest = spheres.iter().map(|s| s.center.distance(eye) + s.radius).fold(0.0, f32::max);
        [1e-3 * smallest, 2.0 * farthest]
    }

    fn shape(&self, xml: &mut Xml, sphere: &Sphere, role: Role) -> io::Result<()> {
        plugin(xml, "shape", "sphere", |xml| {
            let [x, y, z] = self.moved(sphere.center).to_array().map(|v| v.to_string());
            let center = [("name", "center"), ("x", &x), ("y", &y), ("z", &z)];
            xml.create_element("point").with_attributes(center).write_empty()?;
            value(xml, "float", "radius", &sphere.radius.to_string())?;
            if matches!(role, Role::Enclosure(_)) {
                // Enclosures are seen and lit from inside.
                value(xml, "boolean", "flip_normals", "true")?;
            }
            let id = material_id(sphere.material as usize);
            xml.create_element("ref").with_attribute(("id", id.as_str())).write_empty()?;
            if sphere.is_emitter() {
                plugin(xml, "emitter", "area", |xml| color(xml, "radiance", sphere.emission))?;
            }
            Ok(())
        })
    }
}

fn bsdf(xml: &mut Xml, index: usize, material: &Material) -> io::Result<()> {
    let kind = match material {
        Material::Diffuse { .. } => "diffuse",
        Material::Specular { .. } => "conductor",
        Material::Dielectric { .. } => "dielectric",
    };
    let id = material_id(index);
    let attributes = [("type", kind), ("id", id.as_str())];
    xml.create_element("bsdf").with_attributes(attributes).write_inner_content(|xml| match *material {
        Material::Diffuse { albedo } => color(xml, "reflectance", albedo),
        Material::Specular { albedo } => {
            value(xml, "string", "material", "none")?;
            color(xml, "specular_reflectance", albedo)
        }
        Material::Dielectric { albedo, ior } => {
            value(xml, "float", "int_ior", &ior.to_string())?;
            value(xml, "float", "ext_ior", "1")?;
            color(xml, "specular_reflectance", albedo)?;
            color(xml, "specular_transmittance", albedo)
        }
    })?;
    Ok(())
}

fn material_id(index: usize) -> String {
    format!("material-{index}")
}

fn plugin(
    xml: &mut Xml,
    tag: &str,
    kind: &str,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    xml.create_element(tag).with_attribute(("type", kind)).write_inner_content(content).map(drop)
}

fn value(xml: &mut Xml, tag: &str, name: &str, value: &str) -> io::Result<()> {
    xml.create_element(tag).with_attributes([("name", name), ("value", value)]).write_empty().map(drop)
}

fn color(xml: &mut Xml, name: &str, color: Rgb) -> io::Result<()> {
    value(xml, "rgb", name, &numbers(&color.to_array()))
}

fn numbers<T: ToString>(values: &[T]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shift_of(spheres: &[(f32, f32)], eye: f32) -> f32 {
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let ball = scene.spheres[0];
        let sphere = |&(z, radius): &(f32, f32)| Sphere { center: Vec3::Z * z, radius, material: 0, ..ball };
        scene.spheres = spheres.iter().map(sphere).collect();
        scene.camera.eye = Vec3::new(500.0, 0.0, eye);
        let still = scene.at(0.0);
        shift(&View {
            name: "a",
            camera: &scene.camera,
            still: &still,
            time: 0.0,
            width: 4,
            height: 3,
            filter: scene::Filter::Box,
            samples: 1,
            version: "1",
        })
    }

    /// What is small, and the eye, come at least a hundredth of the largest radius above the origin, by a whole number.
    #[test]
    fn small_things_are_moved_away_from_the_origin() {
        // A wall of 1000, so a margin of 5: the lowest point is to be at 10.
        assert_eq!(shift_of(&[(0.0, 1000.0), (20.0, 2.0)], 50.0), 0.0);
        assert_eq!(shift_of(&[(0.0, 1000.0), (11.5, 2.0)], 50.0), 1.0);
        assert_eq!(shift_of(&[(0.0, 1000.0), (12.0, 2.0)], 50.0), 0.0);
        assert_eq!(shift_of(&[(0.0, 1000.0), (-30.0, 2.0)], 50.0), 42.0);
        assert_eq!(shift_of(&[(0.0, 1000.0), (50.0, 2.0)], -3.5), 14.0);
        // What is larger than the margin is a wall itself.
        assert_eq!(shift_of(&[(0.0, 1000.0), (-30.0, 6.0)], 50.0), 0.0);
        assert_eq!(shift_of(&[(0.0, 1000.0), (-30.0, 5.0)], 50.0), 45.0);
    }
}
