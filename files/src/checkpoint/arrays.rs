//! The sections of a checkpoint that hold materials and spheres as numbers, a fraction of their text.

use super::damage::Damage;
use super::sections::{FRAME, GLOW, MATERIALS, MOTION, Name, SPHERES, Section, write_section};
use scene::{Material, Rgb, Scene, Sphere, Vec3};
use std::io::{self, Read, Write};

/// Words of 4 bytes per material: kind, albedo and index of refraction.
const MATERIAL_WORDS: usize = 5;
/// Words per sphere: centre, radius and material.
const SPHERE_WORDS: usize = 5;
/// Words per sphere that emits or moves: its index and a vector.
const EXTRA_WORDS: usize = 4;

/// The materials and spheres of a scene's own: its sky follows from the background, others from files of particles.
pub(super) struct Arrays<'a> {
    materials: &'a [Material],
    spheres: &'a [Sphere],
}

/// One of the four sections: its name, its rows, and how to write them.
type Part<'a> = (Name, u64, Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>);

impl<'a> Arrays<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
        Self { materials: scene.own_materials(), spheres: scene.own_spheres() }
    }

    /// Bytes of all sections.
    pub(super) fn bytes(&self) -> u64 {
        self.parts().iter().map(|(_, bytes, _)| FRAME + bytes).sum()
    }

    pub(super) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        for (name, bytes, fill) in self.parts() {
            write_section(out, name, bytes, |out| fill(out))?;
        }
        Ok(())
    }

    fn parts(&self) -> [Part<'_>; 4] {
        let bytes = |rows: usize, words: usize| (rows * words * 4) as u64;
        let extra = |name, of: fn(&Sphere) -> Vec3| -> Part<'_> {
            let rows = move || self.spheres.iter().enumerate().filter(move |(_, s)| of(s) != Vec3::ZERO);
            let row = move |(i, s): (usize, &Sphere)| {
                let [x, y, z] = of(s).to_array().map(f32::to_bits);
                [i as u32, x, y, z]
            };
            (name, bytes(rows().count(), EXTRA_WORDS), Box::new(move |out| write_rows(out, rows().map(row))))
        };
        [
            (
                MATERIALS,
                bytes(self.materials.len(), MATERIAL_WORDS),
                Box::new(|out| write_rows(out, self.materials.iter().map(words_of_material))),
            ),
            (
                SPHERES,
                bytes(self.spheres.len(), SPHERE_WORDS),
                Box::new(|out| write_rows(out, self.spheres.iter().map(words_of_sphere))),
            ),
            extra(GLOW, |s| s.emission),
            extra(MOTION, |s| s.velocity),
        ]
    }
}

fn words_of_material(material: &Material) -> [u32; MATERIAL_WORDS] {
    let (kind, ior) = match material {
        Material::Diffuse { .. } => (0, 1.0),
        Material::Specular { .. } => (1, 1.0),
        Material::Dielectric { ior, .. } => (2, *ior),
    };
    let [r, g, b] = material.albedo().to_array().map(f32::to_bits);
    [kind, r, g, b, ior.to_bits()]
}

fn words_of_sphere(sphere: &Sphere) -> [u32; SPHERE_WORDS] {
    let [x, y, z] = sphere.center.to_array().map(f32::to_bits);
    [x, y, z, sphere.radius.to_bits(), sphere.material]
}

fn write_rows<const N: usize>(out: &mut dyn Write, rows: impl Iterator<Item = [u32; N]>) -> io::Result<()> {
    /// Rows that are written at a time.
    const ROWS: usize = 1 << 12;
    let mut bytes = Vec::with_capacity(ROWS * N * 4);
    for row in rows {
        bytes.extend(row.map(u32::to_le_bytes).as_flattened());
        if bytes.len() == bytes.capacity() {
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    out.write_all(&bytes)
}

/// Reads the four sections, the first at offset `at` of a file of `length` bytes, and advances `at` beyond them. The
/// numbers are not checked, but for indices.
pub(super) fn read(
    input: &mut impl Read,
    at: &mut u64,
    length: u64,
) -> Result<(Vec<Material>, Vec<Sphere>), Damage> {
    let materials = read_rows(input, MATERIALS, at, length, material)?;
    let mut spheres = read_rows(input, SPHERES, at, length, |words| Some(sphere(words)))?;
    read_extra(input, GLOW, at, length, &mut spheres, |sphere| &mut sphere.emission)?;
    read_extra(input, MOTION, at, length, &mut spheres, |sphere| &mut sphere.velocity)?;
    Ok((materials, spheres))
}

fn read_extra(
    input: &mut impl Read,
    name: Name,
    at: &mut u64,
    length: u64,
    spheres: &mut [Sphere],
    of: fn(&mut Sphere) -> &mut Vec3,
) -> Result<(), Damage> {
    read_rows(input, name, at, length, |[i, vector @ ..]: [u32; EXTRA_WORDS]| {
        *of(spheres.get_mut(i as usize)?) = Vec3::from_array(vector.map(f32::from_bits));
        Some(())
    })?;
    Ok(())
}

/// Reads a section of rows of `N` words, each converted by `convert`; `None` if the row is not valid.
fn read_rows<const N: usize, T>(
    input: &mut impl Read,
    name: Name,
    at: &mut u64,
    length: u64,
    mut convert: impl FnMut([u32; N]) -> Option<T>,
) -> Result<Vec<T>, Damage> {
    let mut section = Section::begin(input, name, length - *at)?;
    *at += FRAME + section.length;
    let size = (N * 4) as u64;
    if section.length % size != 0 {
        let problem = format!("has {} bytes, not a multiple of {size}", section.length);
        return Err(section.refuse(problem));
    }
    let count = section.length / size;
    // One more for the sky.
    let mut rows = Vec::with_capacity(count as usize + 1);
    let mut fault = None;
    for row in 0..count {
        let mut bytes = [[0; 4]; N];
        section.read_exact(bytes.as_flattened_mut())?;
        match convert(bytes.map(u32::from_le_bytes)) {
            Some(converted) => rows.push(converted),
            None => fault = fault.or(Some(row)),
        }
    }
    section.end()?;
    match fault {
        None => Ok(rows),
        Some(row) => {
            let problem = format!("cannot be used: row {row} is not valid");
            Err(Damage::Invalid { section: name.1, problem })
        }
    }
}

fn material([kind, albedo @ .., ior]: [u32; MATERIAL_WORDS]) -> Option<Material> {
    let albedo = Rgb::from_array(albedo.map(f32::from_bits));
    match kind {
        0 => Some(Material::Diffuse { albedo }),
        1 => Some(Material::Specular { albedo }),
        2 => Some(Material::Dielectric { albedo, ior: f32::from_bits(ior) }),
        _ => None,
    }
}

fn sphere([x, y, z, radius, material]: [u32; SPHERE_WORDS]) -> Sphere {
    let [x, y, z, radius] = [x, y, z, radius].map(f32::from_bits);
    Sphere { center: Vec3::new(x, y, z), velocity: Vec3::ZERO, radius, material, emission: Rgb::ZERO }
}
