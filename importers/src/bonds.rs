//! Bonds by distance.

use crate::cell::dot;
use crate::elements::element;
use crate::particles::{Cell, Particles};
use rayon::prelude::*;
use std::ops::Range;

/// A bond joins atoms that are no farther apart than the sum of their covalent radii times this, as is the custom of
/// programs that guess bonds: radii are means over many structures, and the longest bonds are about a seventh longer.
pub const TOLERANCE: f64 = 1.15;
/// Atoms that are closer than this, in angstrom, are one atom in two places rather than bonded.
const CLOSEST: f64 = 0.4;
/// The most atoms in a cube with edges of the longest bond. More have never been packed: the unit is not angstrom.
const MOST_IN_CUBE: usize = 1000;
/// Bits of a cube's number along an axis.
const BITS: u32 = 20;

/// The bonds between atoms that are closer than the sum of their covalent radii times [`TOLERANCE`], in the unit of the
/// file (angstrom if unknown), also through the sides of a periodic cell. Pairs of indices, the lower first, sorted.
///
/// Atoms of unknown elements have no bonds. There are none at all where more than a thousand atoms are within the length
/// of a bond, as happens if the unit is not what it seems. Takes time in proportion to n log n.
pub fn by_distance(particles: &Particles) -> Vec<[u32; 2]> {
    let Some(elements) = &particles.elements else { return Vec::new() };
    let angstrom = 1.0 / particles.unit.in_angstrom().unwrap_or(1.0);
    let radius =
        |number: u8| element(number).and_then(|element| element.covalent).map_or(0.0, f64::from) * angstrom;
    let radii: [f64; 256] = std::array::from_fn(|number| radius(number as u8));
    let largest = elements.iter().map(|&number| radii[usize::from(number)]).fold(0.0, f64::max);
    let longest = 2.0 * TOLERANCE * largest;
    if longest == 0.0 {
        return Vec::new();
    }
    let grid = Grid::new(&images(particles, longest), longest);
    if grid.fullest() > MOST_IN_CUBE {
        return Vec::new();
    }
    let is_bond = |a: &Image, b: &Image| {
        let [of_a, of_b] = [a, b].map(|image| radii[usize::from(elements[image.atom as usize])]);
        let most = TOLERANCE * (of_a + of_b);
        let between = std::array::from_fn(|axis| a.position[axis] - b.position[axis]);
        let squared = dot(between, between);
        of_a > 0.0 && of_b > 0.0 && squared <= most * most && squared > (CLOSEST * angstrom).powi(2)
    };
    let cubes = grid.ranges().into_par_iter();
    let mut bonds: Vec<[u32; 2]> = cubes.flat_map_iter(|cube| bonds_of(cube, &grid, is_bond)).collect();
    bonds.par_sort_unstable();
    // Through the sides of a cell each end finds the other.
    bonds.dedup();
    bonds
}

/// The bonds of the atoms in a cube.
fn bonds_of(cube: Range<usize>, grid: &Grid, is_bond: impl Fn(&Image, &Image) -> bool) -> Vec<[u32; 2]> {
    let (near, mut bonds) = (grid.near(cube.start), Vec::new());
    for image in grid.images[cube].iter().filter(|image| image.is_original) {
        for other in near.iter().flat_map(|range| &grid.images[range.clone()]) {
            let is_new = if other.is_original { other.atom > image.atom } else { other.atom != image.atom };
            if is_new && is_bond(image, other) {
                bonds.push([image.atom.min(other.atom), image.atom.max(other.atom)]);
            }
        }
    }
    bonds
}

/// An atom, or its image in a neighbouring cell.
#[derive(Clone, Copy)]
struct Image {
    position: [f64; 3],
    atom: u32,
    is_original: bool,
}

/// All atoms, wrapped into a periodic cell, and their images that are within `reach` of it.
fn images(particles: &Particles, reach: f64) -> Vec<Image> {
    let mut images = Vec::with_capacity(particles.len());
    for (atom, &position) in (0_u32..).zip(&particles.positions) {
        let position = particles.cell.map_or(position, |cell| cell.wrap(position));
        images.push(Image { position, atom, is_original: true });
    }
    if let Some(cell) = particles.cell {
        let heights = heights(&cell);
        let originals = images.len();
        for at in 0..originals {
            let fractions = cell.fractions(images[at].position);
            let shifts = std::array::from_fn(|axis| {
                shifts(fractions[axis], cell.periodic[axis], reach / heights[axis])
            });
            add_images(&cell, images[at], shifts, &mut images);
        }
    }
    images
}

/// The distances of a cell's opposite sides.
fn heights(cell: &Cell) -> [f64; 3] {
    let origin = cell.fractions(cell.origin);
    std::array::from_fn(|row| {
        // The gradient of a coordinate is as long as the sides are near.
        let gradient = std::array::from_fn(|axis| {
            let mut point = cell.origin;
            point[axis] += cell.volume().cbrt();
            (cell.fractions(point)[row] - origin[row]) / cell.volume().cbrt()
        });
        1.0 / dot(gradient, gradient).sqrt()
    })
}

/// By how many cells a coordinate can be moved so that it is within `reach` of the cell: down and up.
fn shifts(fraction: f64, is_periodic: bool, reach: f64) -> [bool; 2] {
    [is_periodic && fraction - 1.0 > -reach, is_periodic && fraction < reach]
}

/// Adds the images of an atom in the neighbouring cells that `shifts` names, down and up along each vector.
fn add_images(cell: &Cell, image: Image, shifts: [[bool; 2]; 3], images: &mut Vec<Image>) {
    let moves = |axis: usize| {
        let [down, up]: [bool; 2] = shifts[axis];
        [Some(0.0), down.then_some(-1.0), up.then_some(1.0)].into_iter().flatten()
    };
    for x in moves(0) {
        for y in moves(1) {
            for z in moves(2) {
                if [x, y, z] != [0.0; 3] {
                    let [a, b, c] = cell.vectors;
                    let along = |axis: usize| image.position[axis] + x * a[axis] + y * b[axis] + z * c[axis];
                    images.push(Image { position: std::array::from_fn(along), is_original: false, ..image });
                }
            }
        }
    }
}

/// Points in cubes, sorted so that cubes in a row along x follow each other.
struct Grid {
    images: Vec<Image>,
    /// The cube of each image.
    cubes: Vec<u64>,
    lowest: [f64; 3],
    edge: f64,
}

impl Grid {
    /// Cubes with edges of at least `least`.
    fn new(images: &[Image], least: f64) -> Self {
        let end = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
            images.iter().map(|image| image.position[axis]).fold(start, pick)
        };
        let lowest = std::array::from_fn(|axis| end(axis, f64::min, f64::INFINITY));
        let highest: [f64; 3] = std::array::from_fn(|axis| end(axis, f64::max, f64::NEG_INFINITY));
        let extent =
            highest.iter().zip(&lowest).map(|(high, low): (&f64, &f64)| high - low).fold(0.0, f64::max);
        // One cube is left free on either side.
        let edge = least.max(extent / f64::from((1_u32 << BITS) - 4));
        let mut grid = Self { images: Vec::new(), cubes: Vec::new(), lowest, edge };
        let mut sorted: Vec<(u64, Image)> =
            images.iter().map(|image| (number(grid.cube(image.position)), *image)).collect();
        sorted.par_sort_unstable_by_key(|(cube, image)| (*cube, image.atom));
        (grid.cubes, grid.images) = sorted.into_iter().unzip();
        grid
    }

    fn cube(&self, position: [f64; 3]) -> [u64; 3] {
        std::array::from_fn(|axis| ((position[axis] - self.lowest[axis]) / self.edge) as u64 + 1)
    }

    /// The images of each cube that has any.
    fn ranges(&self) -> Vec<Range<usize>> {
        let mut start = 0;
        let cubes = self.cubes.chunk_by(|a, b| a == b);
        cubes
            .map(|cube| {
                start += cube.len();
                start - cube.len()..start
            })
            .collect()
    }

    /// The images in the cube of this one and around it: nine rows of three cubes.
    fn near(&self, image: usize) -> [Range<usize>; 9] {
        let [x, y, z] = self.cube(self.images[image].position);
        std::array::from_fn(|row| {
            let [y, z] = [y - 1 + row as u64 % 3, z - 1 + row as u64 / 3];
            let begin = self.cubes.partition_point(|cube| *cube < number([x - 1, y, z]));
            let last = number([x + 1, y, z]);
            let length = self.cubes[begin..].iter().take_while(|cube| **cube <= last).count();
            begin..begin + length
        })
    }

    /// The most images in a cube.
    fn fullest(&self) -> usize {
        self.cubes.chunk_by(|a, b| a == b).map(<[u64]>::len).max().unwrap_or(0)
    }
}

fn number([x, y, z]: [u64; 3]) -> u64 {
    (z << (2 * BITS)) | (y << BITS) | x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::cell;
    use crate::format::Format;

    fn particles(atoms: &[(u8, [f64; 3])]) -> Particles {
        let mut particles = Particles::new(Format::Xyz);
        particles.elements = Some(atoms.iter().map(|(number, _)| *number).collect());
        particles.positions = atoms.iter().map(|(_, position)| *position).collect();
        particles
    }

    /// Pairs found by trying all, over all images of the nearest cells and the next ones.
    fn by_brute_force(particles: &Particles) -> Vec<[u32; 2]> {
        let radius = |at: usize| {
            f64::from(element(particles.elements.as_ref().unwrap()[at]).unwrap().covalent.unwrap())
        };
        let shifts: Vec<[f64; 3]> =
            (0..125).map(|i| [i % 5, i / 5 % 5, i / 25].map(|s| f64::from(s) - 2.0)).collect();
        let cell = particles.cell;
        let periodic = cell.map_or([false; 3], |cell| cell.periodic);
        let near = |a: usize, b: usize| {
            shifts.iter().any(|shift| {
                if (0..3).any(|v| !periodic[v] && shift[v] != 0.0) {
                    return false;
                }
                let moved = |axis: usize| {
                    let vectors = cell.map_or([[0.0; 3]; 3], |cell| cell.vectors);
                    particles.positions[b][axis] + (0..3).map(|v| shift[v] * vectors[v][axis]).sum::<f64>()
                };
                let between = std::array::from_fn(|axis| moved(axis) - particles.positions[a][axis]);
                let distance = dot(between, between).sqrt();
                distance <= TOLERANCE * (radius(a) + radius(b)) && distance > CLOSEST
            })
        };
        let n = particles.len();
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        pairs.filter(|&(a, b)| near(a, b)).map(|(a, b)| [a as u32, b as u32]).collect()
    }

    /// Points that fill a cube of edge `size` without order.
    fn scattered(count: usize, size: f64) -> Vec<(u8, [f64; 3])> {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count)
            .map(|_| ([1, 6, 8, 26][(next() * 4.0) as usize], [next(), next(), next()].map(|u| size * u)))
            .collect()
    }

    #[test]
    fn water_has_two_bonds() {
        let mut water = particles(&[(8, [0.0; 3]), (1, [0.96, 0.0, 0.0]), (1, [-0.24, 0.93, 0.0])]);
        assert_eq!(by_distance(&water), [[0, 1], [0, 2]]);
        water.unit = crate::unit::Unit::Nanometre;
        for position in &mut water.positions {
            *position = position.map(|number| 0.1 * number);
        }
        assert_eq!(by_distance(&water), [[0, 1], [0, 2]]);
        water.elements = Some(vec![8, 1, 0]);
        assert_eq!(by_distance(&water), [[0, 1]]);
    }

    #[test]
    fn bonds_are_those_of_all_pairs() {
        let all = particles(&scattered(300, 12.0));
        let bonds = by_distance(&all);
        assert!(bonds.len() > 300);
        assert_eq!(bonds, by_brute_force(&all));
    }

    #[test]
    fn bonds_go_through_the_sides_of_a_slanted_cell() {
        let mut all = particles(&scattered(300, 12.0));
        let vectors = [[12.0, 0.0, 0.0], [3.0, 12.0, 0.0], [-2.0, 4.0, 12.0]];
        all.cell = cell([-3.0, 1.0, 0.5], vectors, [true; 3]);
        all.wrap();
        let bonds = by_distance(&all);
        assert_eq!(bonds, by_brute_force(&all));
        all.cell.as_mut().unwrap().periodic = [false; 3];
        assert!(by_distance(&all).len() < bonds.len());
    }

    /// Sides that are much nearer to each other than the edges between them are long, vectors that do not repeat, and files
    /// whose molecules are whole, so that atoms are anywhere.
    #[test]
    fn bonds_are_those_of_all_images_in_every_cell_wherever_its_atoms_are() {
        let slanted = [[12.0, 0.0, 0.0], [9.0, 8.0, 0.0], [-8.0, 6.0, 7.0]];
        let lying = [[5.0, 0.0, 4.0], [0.0, 9.0, 8.5], [-1.0, -9.0, 9.0]];
        let places = [[true; 3], [true, false, true], [false, false, true], [false, true, false]];
        for (vectors, periodic) in [slanted, lying].iter().flat_map(|v| places.map(|p| (*v, p))) {
            let mut all = particles(&scattered(200, 9.0));
            all.cell = cell([1.0, -2.0, 0.5], vectors, periodic);
            all.wrap();
            let bonds = by_distance(&all);
            assert_eq!(bonds, by_brute_force(&all), "{vectors:?} {periodic:?}");
            for (at, position) in all.positions.iter_mut().enumerate() {
                for vector in (0..3).filter(|&vector| periodic[vector]) {
                    let turns = ((at + vector) % 7) as f64 - 3.0;
                    *position = std::array::from_fn(|axis| position[axis] + turns * vectors[vector][axis]);
                }
            }
            assert_eq!(by_distance(&all), bonds, "{vectors:?} {periodic:?}, atoms anywhere");
        }
    }

    #[test]
    fn what_is_too_dense_for_atoms_has_no_bonds() {
        let all = particles(&scattered(3000, 1.0));
        assert_eq!(by_distance(&all), [[0; 2]; 0]);
    }
}
