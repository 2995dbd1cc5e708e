//! Writes a scene as a scene file in canonical form: equal scenes give equal texts.
//!
//! [`super::parse`] reads the text back as the same scene, bit for bit. The names of spheres and materials are lost, as
//! a [`Scene`] does not keep them.

use crate::particles::hexadecimal;
use scene::{Camera, Filter, Import, Material, RadiusSchedule, Rgb, Scene, Settings, Sphere, Vec3};
use sha2::{Digest, Sha256};
use std::fmt::{self, Display, Write};
use std::path::Path;

/// The text of a scene file with `scene` and `settings`. Spheres from files of particles are named by these files, as they
/// were opened.
pub fn to_text(scene: &Scene, settings: &Settings) -> String {
    to_text_with(scene, settings, |file| file)
}

/// As [`to_text`], with the names of files of particles alone, without their folders: for what is given to others.
pub fn to_portable_text(scene: &Scene, settings: &Settings) -> String {
    to_text_with(scene, settings, |file| file.file_name().map_or(file, Path::new))
}

fn to_text_with(scene: &Scene, settings: &Settings, file: fn(&Path) -> &Path) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_head(&mut text, scene)
        .and_then(|()| write_materials(&mut text, scene.own_materials()))
        .and_then(|()| scene.own_spheres().iter().try_for_each(|sphere| write_sphere(&mut text, sphere)))
        .and_then(|()| write_imports(&mut text, &scene.imports, file))
        .and_then(|()| write_settings(&mut text, settings));
    text
}

/// The text of a scene file with `scene` and `settings`, but without its own materials and spheres. See
/// [`super::with_spheres`]. Files of particles are named by their absolute paths.
pub(crate) fn head_to_text(scene: &Scene, settings: &Settings) -> String {
    let absolute = |import: &Import| {
        let file = std::path::absolute(&import.file).unwrap_or_else(|_| import.file.clone());
        Import { file, ..import.clone() }
    };
    let imports: Vec<Import> = scene.imports.iter().map(absolute).collect();
    let mut text = String::new();
    let _ = write_head(&mut text, scene)
        .and_then(|()| write_imports(&mut text, &imports, |file| file))
        .and_then(|()| write_settings(&mut text, settings)); // as above
    text
}

/// Beyond so many spheres, [`digest`] takes their numbers in place of their text, which takes twenty times as long to write.
const MOST_AS_TEXT: usize = 1 << 16;

/// Identifies a scene: the SHA-256, in hexadecimal, of its scene file without settings, with all spheres written out; if
/// they are more than 65536, as the bytes of their numbers.
pub fn digest(scene: &Scene) -> String {
    hashed(scene, scene.spheres.len() <= MOST_AS_TEXT)
}

/// Whether `digest` is that of `scene`, by this version or by those that took the text of any number of spheres.
pub fn is_digest_of(digest: &str, scene: &Scene) -> bool {
    digest == self::digest(scene) || scene.spheres.len() > MOST_AS_TEXT && digest == hashed(scene, true)
}

/// The digest of a scene, of which spheres are taken as text or as numbers.
fn hashed(scene: &Scene, as_text: bool) -> String {
    let mut hash = Hashed(Sha256::new());
    let (materials, spheres) = shown(scene);
    // Hashing cannot fail either.
    let _ = write_head(&mut hash, scene).and_then(|()| write_materials(&mut hash, materials));
    if as_text {
        let _ = spheres.iter().try_for_each(|sphere| write_sphere(&mut hash, sphere));
    } else {
        hash_numbers(&mut hash.0, spheres);
    }
    hexadecimal(&hash.0.finalize())
}

/// Takes the numbers of spheres, in the order of their fields and from the lowest byte, into a hash.
fn hash_numbers(hash: &mut Sha256, spheres: &[Sphere]) {
    /// Spheres that are hashed at once.
    const AT_ONCE: usize = 64;
    let mut bytes = Vec::with_capacity(AT_ONCE * size_of::<Sphere>());
    for some in spheres.chunks(AT_ONCE) {
        bytes.clear();
        for Sphere { center, velocity, radius, material, emission } in some {
            let vectors = |v: &Vec3| v.to_array().map(f32::to_bits);
            let words =
                [vectors(center), vectors(velocity), vectors(emission), [radius.to_bits(), *material, 0]];
            bytes.extend(words.as_flattened().iter().flat_map(|word| word.to_le_bytes()));
        }
        hash.update(&bytes);
    }
}

/// Hashes the text that is written to it, so that a large scene's text is never in memory.
struct Hashed(Sha256);

impl Write for Hashed {
    fn write_str(&mut self, s: &str) -> fmt::Result {
        self.0.update(s);
        Ok(())
    }
}

/// All materials and spheres but for the sky, which comes last: the reader makes it from the background.
fn shown(scene: &Scene) -> (&[Material], &[Sphere]) {
    let spheres = scene.without_sky();
    let skies = scene.spheres.len() - spheres.len();
    (&scene.materials[..scene.materials.len() - skies], spheres)
}

fn write_materials(out: &mut impl Write, materials: &[Material]) -> fmt::Result {
    materials.iter().enumerate().try_for_each(|(i, material)| write_material(out, i, material))
}

/// Files of particles, each named by what `file` makes of its path.
fn write_imports(out: &mut impl Write, imports: &[Import], file: fn(&Path) -> &Path) -> fmt::Result {
    imports.iter().try_for_each(|import| {
        let file = toml::Value::from(file(&import.file).to_string_lossy().as_ref());
        writeln!(out, "\n[[particles]]\nfile = {file}\ndigest = \"{}\"", import.digest)?;
        out.write_str(&import.table)
    })
}

fn write_head(out: &mut impl Write, scene: &Scene) -> fmt::Result {
    writeln!(out, "name = {}", toml::Value::from(scene.name.as_str()))?;
    if scene.background != Rgb::ZERO {
        writeln!(out, "background = {}", Triple(scene.background))?;
    }
    if scene.transparent_background {
        writeln!(out, "transparent_background = true")?;
    }
    write_camera(out, &scene.camera)
}

fn write_camera(out: &mut impl Write, camera: &Camera) -> fmt::Result {
    let Camera { eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter } =
        camera;
    writeln!(
        out,
        "\n[camera]\neye = {}\ndirection = {}\nup = {}",
        Triple(*eye),
        Triple(*direction),
        Triple(*up)
    )?;
    writeln!(out, "vertical_fov_degrees = {}", Float(*vertical_fov_degrees))?;
    writeln!(out, "aperture_radius = {}", Float(*aperture_radius))?;
    writeln!(out, "focus_distance = {}", Float(*focus_distance))?;
    writeln!(out, "shutter = [{}, {}]", Float(shutter[0]), Float(shutter[1]))
}

/// The name of a material, padded with zeros so that sorting by name keeps the order.
struct Name(usize);

impl Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "m{:010}", self.0)
    }
}

fn write_material(out: &mut impl Write, i: usize, material: &Material) -> fmt::Result {
    let kind = match material {
        Material::Diffuse { .. } => "diffuse",
        Material::Specular { .. } => "specular",
        Material::Dielectric { .. } => "dielectric",
    };
    writeln!(out, "\n[materials.{}]\ntype = \"{kind}\"\nalbedo = {}", Name(i), Triple(material.albedo()))?;
    match material {
        Material::Dielectric { ior, .. } => writeln!(out, "ior = {}", Float(*ior)),
        _ => Ok(()),
    }
}

fn write_sphere(out: &mut impl Write, sphere: &Sphere) -> fmt::Result {
    let Sphere { center, velocity, radius, material, emission } = sphere;
    writeln!(out, "\n[[sphere]]\ncenter = {}\nradius = {}", Triple(*center), Float(*radius))?;
    writeln!(out, "material = \"{}\"", Name(*material as usize))?;
    for (key, vector) in [("emission", emission), ("velocity", velocity)] {
        if *vector != Vec3::ZERO {
            writeln!(out, "{key} = {}", Triple(*vector))?;
        }
    }
    Ok(())
}

fn write_settings(out: &mut impl Write, settings: &Settings) -> fmt::Result {
    let Settings {
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        radius_schedule,
        radius_pilots,
        radius_clearance,
        light_samples,
        glint_samples,
    } = settings;
    writeln!(out, "\n[settings]\nwidth = {width}\nheight = {height}\niterations = {iterations}")?;
    writeln!(out, "photons_per_iteration = {photons_per_iteration}\nmax_depth = {max_depth}")?;
    writeln!(out, "initial_radius = {}\nseed = {seed}", Float(*initial_radius))?;
    match filter {
        Filter::Box => Ok(()),
        filter => writeln!(out, "filter = \"{filter}\""),
    }?;
    match radius_schedule {
        RadiusSchedule::PerPixel => Ok(()),
        schedule @ RadiusSchedule::Global => writeln!(out, "radius_schedule = \"{schedule}\""),
    }?;
    match radius_pilots {
        0 => Ok(()),
        pilots => writeln!(out, "radius_pilots = {pilots}"),
    }?;
    match radius_clearance {
        0.0 => Ok(()),
        factor => writeln!(out, "radius_clearance = {}", Float(*factor)),
    }?;
    match light_samples {
        1 => Ok(()),
        samples => writeln!(out, "light_samples = {samples}"),
    }?;
    match glint_samples {
        1 => Ok(()),
        samples => writeln!(out, "glint_samples = {samples}"),
    }
}

/// Displays a number such that it reads back as the same `f32`.
struct Float(f32);

impl Display for Float {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let short = format!("{:?}", self.0);
        // Readers parse an `f64` and round it to `f32`. In the rare case that this gives another number, write all
        // digits.
        if short.parse::<f64>().is_ok_and(|value| value as f32 == self.0) {
            f.write_str(&short)
        } else {
            write!(f, "{:?}", f64::from(self.0))
        }
    }
}

struct Triple(Vec3);

impl Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Vec3 { x, y, z } = self.0;
        write!(f, "[{}, {}, {}]", Float(x), Float(y), Float(z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::SCENES;
    use crate::scene_file::parse;
    use proptest::prelude::*;

    fn again(scene: &Scene, settings: &Settings) -> Scene {
        parse("again.toml", &to_text(scene, settings)).unwrap()
    }

    #[test]
    fn every_built_in_scene_is_read_back() {
        for builtin in SCENES {
            let scene = builtin.scene();
            let settings = Settings { seed: u64::MAX, initial_radius: 0.1, ..scene.settings };
            assert_eq!(again(&scene, &settings), Scene { settings, ..scene });
        }
    }

    #[test]
    fn a_sky_is_read_back() {
        let text = "name = \"a \\\"b\\\" \\\\ c\"\nbackground = [0.1, 0.2, 0.3]\n[camera]\neye = [0, 0, 0]\n\
            target = [1, 2, 3.3]\nvertical_fov_degrees = 33.3\naperture_radius = 0.1\nshutter = [0.25, 0.75]\n\
            [[sphere]]\ncenter = [9, 9.1, 9.7]\nvelocity = [0, 1e-3, 0]\nradius = 0.7\n\
            material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.33 }\n";
        let scene = parse("sky.toml", text).unwrap();
        assert_eq!(scene.spheres.len(), 2);
        assert_eq!(again(&scene, &scene.settings), scene);
    }

    /// A checkpoint may be resumed in another folder than the one in which it was written.
    #[test]
    fn heads_name_files_of_particles_by_absolute_paths() {
        let import = |file: &str| Import {
            file: file.into(),
            digest: "0f".into(),
            table: "radius = 1".into(),
            spheres: 0..0,
            materials: 0..0,
        };
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let absolute = std::env::temp_dir().join("there.xyz");
        scene.imports = vec![import("here/a.xyz"), import(absolute.to_str().unwrap())];
        let text: toml::Table = head_to_text(&scene, &scene.settings).parse().unwrap();
        let files = text["particles"]
            .as_array()
            .unwrap()
            .iter()
            .map(|table| Path::new(table["file"].as_str().unwrap()));
        let here = std::env::current_dir().unwrap().join("here/a.xyz");
        assert!(files.eq([here.as_path(), absolute.as_path()]), "{text}");
    }

    /// An image that is given to others says nothing of the folders of whoever made it.
    #[test]
    fn portable_texts_name_files_of_particles_without_folders() {
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let import = |file: &str| Import {
            file: file.into(),
            digest: "0f".into(),
            table: String::new(),
            spheres: 9..9,
            materials: scene.materials.len()..scene.materials.len(),
        };
        scene.imports = vec![import("/home/me/a.xyz"), import("../b.gro"), import("c.pdb")];
        let files = |text: String| -> Vec<String> {
            text.lines().filter_map(|line| line.strip_prefix("file = ")).map(str::to_owned).collect()
        };
        let settings = &scene.settings;
        let portable = files(to_portable_text(&scene, settings));
        assert_eq!(portable, ["\"a.xyz\"", "\"b.gro\"", "\"c.pdb\""]);
        let whole = files(to_text(&scene, settings));
        assert_eq!(whole, ["\"/home/me/a.xyz\"", "\"../b.gro\"", "\"c.pdb\""]);
    }

    /// No value is a default, and no two are alike.
    #[test]
    fn everything_is_read_back() {
        let text = "name = \"all\"\n[camera]\neye = [1, 2, 3]\ndirection = [0.1, -0.2, -3]\nup = [0.3, 2, 0.4]\n\
            vertical_fov_degrees = 37\naperture_radius = 0.5\nfocus_distance = 7\nshutter = [0.25, 0.75]\n\
            [settings]\nwidth = 11\nheight = 12\niterations = 13\nphotons_per_iteration = 14\nmax_depth = 15\n\
            initial_radius = 0.16\nseed = 17000000000000000001\nfilter = \"gaussian\"\nradius_schedule = \"global\"\n\
            light_samples = 10\nglint_samples = 18\n[materials.a]\ntype = \"diffuse\"\nalbedo = [0.1, 0.2, 0.3]\n\
            [materials.b]\ntype = \"specular\"\nalbedo = [0.4, 0.5, 0.6]\n\
            [[sphere]]\ncenter = [9, 8, 7]\nradius = 0.7\nmaterial = \"b\"\nvelocity = [0.01, 0.02, 0.03]\n\
            emission = [21, 22, 23]\n[[sphere]]\ncenter = [-9, 8, 7]\nradius = 0.8\nmaterial = \"a\"\n";
        let scene = parse("all.toml", text).unwrap();
        assert_eq!(again(&scene, &scene.settings), scene);
        assert_eq!((scene.camera.up, scene.settings.filter), (Vec3::new(0.3, 2.0, 0.4), Filter::Gaussian));
        assert_eq!((scene.settings.light_samples, scene.settings.glint_samples), (10, 18));
        // Only with radii of their own do pixels begin with other ones.
        let radius_schedule = RadiusSchedule::PerPixel;
        let own = Settings { radius_schedule, radius_pilots: 3, radius_clearance: 0.45, ..scene.settings };
        assert_eq!(again(&scene, &own).settings, own);
    }

    #[test]
    fn the_digest_of_many_spheres_is_of_their_numbers_and_an_older_one_still_counts() {
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let last = scene.spheres[scene.spheres.len() - 1];
        scene.spheres.resize(MOST_AS_TEXT + 2, last);
        let (ours, older) = (digest(&scene), hashed(&scene, true));
        assert_ne!(ours, older);
        assert!(is_digest_of(&ours, &scene) && is_digest_of(&older, &scene));
        // Every number counts, and so does its sign.
        let changes: [fn(&mut Sphere); 5] = [
            |s| s.center.y = s.center.y.next_up(),
            |s| s.velocity.z = 1.0,
            |s| s.emission.x += 1.0,
            |s| s.radius = s.radius.next_down(),
            |s| s.material ^= 1,
        ];
        for (k, change) in changes.into_iter().enumerate() {
            let mut other = scene.clone();
            change(&mut other.spheres[MOST_AS_TEXT - k]);
            assert!(!is_digest_of(&ours, &other) && !is_digest_of(&older, &other), "change {k}");
        }
        // The last of a scene of few is as text.
        scene.spheres.truncate(MOST_AS_TEXT);
        assert_eq!(digest(&scene), hashed(&scene, true));
    }

    #[test]
    fn the_digest_is_of_the_scene_and_not_of_its_settings() {
        let scene = crate::builtin::scene("cornell").unwrap();
        let mut other = scene.clone();
        other.settings.seed += 1;
        assert_eq!(digest(&scene), digest(&other));
        other.spheres[0].radius = other.spheres[0].radius.next_up();
        assert_ne!(digest(&scene), digest(&other));
        let whole = to_text(&scene, &scene.settings);
        let (text, _) = whole.split_once("\n[settings]").unwrap();
        assert_eq!(digest(&scene), format!("{:x}", Sha256::digest(text)));
    }

    /// Its shortest text, 7.038531e-26, is a tie once it was rounded to `f64`.
    #[test]
    fn a_number_that_would_be_rounded_twice_is_read_back() {
        let value = f32::from_bits(0x15ae_43fd);
        let read = Float(value).to_string().parse::<f64>().unwrap() as f32;
        assert_eq!(read.to_bits(), value.to_bits());
    }

    /// Files of particles may be gone, or elsewhere.
    #[test]
    fn the_digest_is_of_all_spheres_wherever_they_come_from() {
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let own = digest(&scene);
        let (spheres, materials) = (scene.spheres.len(), scene.materials.len());
        scene.imports = vec![Import {
            file: "a.xyz".into(),
            digest: "0f".into(),
            table: String::new(),
            spheres: spheres - 1..spheres,
            materials: materials - 1..materials,
        }];
        assert_eq!(digest(&scene), own);
        scene.spheres[spheres - 1].radius += 1.0;
        assert_ne!(digest(&scene), own);
    }

    proptest! {
        #[test]
        fn every_number_is_read_back(bits in any::<u32>()) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            let read = Float(value).to_string().parse::<f64>().unwrap() as f32;
            prop_assert_eq!(read.to_bits(), bits);
            let table = format!("v = {}", Float(value)).parse::<toml::Table>();
            prop_assert!(table.is_ok());
        }
    }
}
