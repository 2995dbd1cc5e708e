//! Rods as chains of small balls, since spheres are the only shape: bonds, and the edges of a cell.

use crate::color::Screen;
use glam::DVec3;
use importers::{Cell, Particles};

/// The colour of the edges of a cell.
pub(crate) const CELL_COLOR: Screen = Screen([64, 64, 64]);
/// Radius of the edges of a cell, as a share of its diagonal.
const EDGE: f64 = 0.0025;
/// Radius of a bond, as a share of the smaller one of its atoms'.
const BOND: f64 = 0.4;
/// Distance of two balls of a chain, in radii: close enough to look like a rod.
const STEP: f64 = 0.5;
/// Most balls of a half bond, however far its atoms are apart.
const MOST: f64 = 1000.0;

/// A bond: the way from its first atom to its second, through the side of a periodic cell if that is shorter.
pub(crate) struct Ends {
    way: DVec3,
    radius: f64,
}

impl Ends {
    /// The bond between a `pair` of particles, shown with these radii.
    pub(crate) fn new(particles: &Particles, pair: [usize; 2], radii: [f32; 2]) -> Self {
        let [from, to] = pair.map(|i| DVec3::from_array(particles.positions[i]));
        let way = shortest(to - from, particles.cell.as_ref());
        Self { way, radius: BOND * f64::from(radii[0].min(radii[1])) }
    }

    /// Passes centre and radius of the balls of one half to `add`: from the atom at `from`, along the way for a `sign` of 1
    /// and against it for -1. What is within the atom of this `radius` is left out.
    pub(crate) fn half(&self, from: [f64; 3], sign: f64, radius: f32, add: impl FnMut([f64; 3], f32)) {
        let hidden = (f64::from(radius) - self.radius).max(0.0);
        let half = 0.5 * self.way.length();
        if hidden < half {
            let along = sign * self.way / self.way.length();
            chain(DVec3::from_array(from) + along * hidden, along * (half - hidden), self.radius, add);
        }
    }
}

/// `way`, or the shortest one through the sides of a periodic cell whose vectors are about at right angles.
fn shortest(way: DVec3, cell: Option<&Cell>) -> DVec3 {
    let Some(cell) = cell else { return way };
    let at_origin = Cell { origin: [0.0; 3], ..*cell };
    let shares = at_origin.fractions(way.to_array());
    let turns = [0, 1, 2].map(|i| if cell.periodic[i] { shares[i].round() } else { 0.0 });
    way - DVec3::from_array(at_origin.point(turns))
}

/// Passes the balls along the edges of `cell` to `add`.
pub(crate) fn edges(cell: &Cell, mut add: impl FnMut([f64; 3], f32)) {
    let diagonal = cell.vectors.map(DVec3::from_array).iter().sum::<DVec3>().length();
    let radius = EDGE * diagonal;
    cell.beads(STEP * radius).into_iter().for_each(|bead| add(bead, radius as f32));
}

/// Passes the balls of `radius` along `way` from `from` to `add`, those at both ends among them.
fn chain(from: DVec3, way: DVec3, radius: f64, mut add: impl FnMut([f64; 3], f32)) {
    let count = (way.length() / (STEP * radius)).ceil().clamp(1.0, MOST);
    for i in 0..=count as u32 {
        add((from + way * (f64::from(i) / count)).to_array(), radius as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use importers::Format;

    fn two(cell: Option<Cell>) -> Particles {
        let mut particles = Particles::new(Format::Xyz);
        particles.positions = vec![[0.5, 0.0, 0.0], [9.5, 0.0, 0.0]];
        particles.cell = cell;
        particles
    }

    fn half(particles: &Particles, sign: f64) -> Vec<[f64; 3]> {
        let mut centers = Vec::new();
        let from = particles.positions[usize::from(sign < 0.0)];
        Ends::new(particles, [0, 1], [0.25, 0.5]).half(from, sign, 0.25, |p, radius| {
            assert_eq!(radius, 0.1);
            centers.push(p);
        });
        centers
    }

    #[test]
    fn halves_meet_in_the_middle() {
        let particles = two(None);
        let [one, other] = [1.0, -1.0].map(|sign| half(&particles, sign));
        assert_eq!((one.last(), other.last()), (Some(&[5.0, 0.0, 0.0]), Some(&[5.0, 0.0, 0.0])));
        // From within the atom's surface.
        assert!((one[0][0] - 0.65).abs() < 1e-9, "{:?}", one[0]);
        let gap = one.windows(2).map(|pair| pair[1][0] - pair[0][0]).fold(0.0, f64::max);
        assert!(gap <= 0.05 + 1e-9, "{gap}");
    }

    /// Where the balls of atoms meet, there is nothing between them; and between atoms in one place there is no way at all.
    #[test]
    fn a_bond_within_its_atoms_is_not_drawn() {
        let drawn = |particles: &Particles, radius: f32| {
            let mut count = 0;
            let ends = Ends::new(particles, [0, 1], [radius; 2]);
            ends.half(particles.positions[0], 1.0, radius, |_, _| count += 1);
            count
        };
        // Half of the way is 4.5; a rod of 0.4 radii comes out of its ball after 0.6.
        assert!(drawn(&two(None), 7.0) > 0);
        assert_eq!(drawn(&two(None), 8.0), 0);
        let mut together = two(None);
        together.positions[1] = together.positions[0];
        assert_eq!(drawn(&together, 1.0), 0);
    }

    #[test]
    fn bonds_pass_the_sides_of_a_periodic_cell() {
        let vectors = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
        let cell = Cell { origin: [0.0; 3], vectors, periodic: [true, true, false] };
        let particles = two(Some(cell));
        assert_eq!(half(&particles, 1.0).last(), Some(&[0.0, 0.0, 0.0]));
        assert_eq!(half(&particles, -1.0).last(), Some(&[10.0, 0.0, 0.0]));
        let open = Cell { periodic: [false; 3], ..cell };
        assert_eq!(half(&two(Some(open)), 1.0).last(), Some(&[5.0, 0.0, 0.0]));
    }
}
