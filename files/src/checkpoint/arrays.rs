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

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(count: usize) -> Scene {
        let mut scene = crate::builtin::scene("cornell").unwrap();
        scene.materials = vec![
            Material::Diffuse { albedo: Rgb::new(0.1, 0.2, 0.3) },
            Material::Specular { albedo: Rgb::splat(0.5) },
            Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 },
        ];
        let sphere = |i: usize| Sphere {
            center: Vec3::new(i as f32, 1.0, 2.0),
            velocity: if i % 3 == 1 { Vec3::Y * i as f32 } else { Vec3::ZERO },
            radius: 0.5 + i as f32,
            material: i as u32 % 3,
            emission: if i % 5 == 2 { Rgb::X * i as f32 } else { Rgb::ZERO },
        };
        scene.spheres = (0..count).map(sphere).collect();
        scene.imports.clear();
        scene
    }

    /// As many as are written at a time, and one more and less; lamps and what moves among them.
    #[test]
    fn what_is_written_is_read() {
        for count in [1, 3, 4095, 4096, 4097, 9000] {
            let scene = scene(count);
            let arrays = Arrays { materials: &scene.materials, spheres: &scene.spheres };
            let mut bytes = Vec::new();
            arrays.write(&mut bytes).unwrap();
            assert_eq!(bytes.len() as u64, arrays.bytes());
            let mut at = 0;
            let (materials, spheres) = read(&mut &bytes[..], &mut at, bytes.len() as u64).unwrap();
            assert_eq!((materials, at), (scene.materials.clone(), bytes.len() as u64));
            assert!(spheres[..] == scene.spheres[..], "{count}");
        }
    }

    /// Of one colour, and backwards along an axis.
    #[test]
    fn lamps_and_motion_are_kept_in_every_direction() {
        let sphere = scene(1).spheres[0];
        let of = |v: Vec3| Sphere { velocity: v, emission: v.abs(), ..sphere };
        let spheres = [Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::X, Vec3::Y, Vec3::Z].map(of);
        let arrays = Arrays { materials: &[], spheres: &spheres };
        let mut bytes = Vec::new();
        arrays.write(&mut bytes).unwrap();
        let (_, read) = read(&mut &bytes[..], &mut 0, bytes.len() as u64).unwrap();
        assert!(read[..] == spheres[..], "{read:?}");
    }

    #[test]
    fn rows_that_are_not_valid_are_told() {
        assert_eq!(material([3, 0, 0, 0, 0]), None);
        let told = |name, words: &[u32]| {
            let content: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let mut bytes = Vec::new();
            write_section(&mut bytes, name, content.len() as u64, |out| out.write_all(&content)).unwrap();
            let mut at = 0;
            let read = read_rows(&mut &bytes[..], name, &mut at, bytes.len() as u64, material);
            assert_eq!(at, bytes.len() as u64);
            read.map(|rows| rows.len()).map_err(|damage| damage.to_string())
        };
        let row = |kind| [kind, 0, 0, 0, 0];
        assert_eq!(told(MATERIALS, &[row(0), row(1)].concat()), Ok(2));
        let problem = told(MATERIALS, &[row(0), row(9), row(8)].concat()).unwrap_err();
        assert!(problem.contains("row 1 is not valid"), "{problem}");
        let problem = told(MATERIALS, &[0; 6]).unwrap_err();
        assert!(problem.contains("has 24 bytes, not a multiple of 20"), "{problem}");
    }
}
