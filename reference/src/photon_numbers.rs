//! The random numbers of photons.

use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, sobol};

/// Which dimensions of a photon's Sobol point are used for what.
pub(crate) mod dimension {
    pub(crate) const DIRECTION: [usize; 2] = [0, 1];
    pub(crate) const POSITION: [usize; 2] = [2, 3];
    pub(crate) const FIRST_BOUNCE: [usize; 3] = [4, 5, 7];
    pub(crate) const LIGHT: usize = 6;
}

/// The random numbers of the photons of one iteration.
///
/// Emission and the first bounce use the photon's Sobol point, with new digital shifts in each iteration. Later
/// bounces draw from the photon's own stream.
pub struct PhotonNumbers {
    shifts: [u32; DIMENSIONS],
    key: StreamKey,
}

impl PhotonNumbers {
    /// The numbers of iteration `iteration`.
    pub fn new(seed: u64, iteration: u32) -> Self {
        let mut shifts = StreamKey::new(seed, Family::Emission, iteration).stream(0);
        Self {
            shifts: std::array::from_fn(|_| shifts.next_u32()),
            key: StreamKey::new(seed, Family::Photon, iteration),
        }
    }

    pub(crate) fn stratified<const N: usize>(&self, photon: u32, dimensions: [usize; N]) -> [f32; N] {
        dimensions.map(|d| unit_float(sobol(photon, d) ^ self.shifts[d]))
    }

    /// The photon's own stream.
    pub(crate) fn stream(&self, photon: u32) -> Stream {
        self.key.stream(photon)
    }

    /// The three numbers of a bounce: two for the direction (at glass, the first chooses between reflection and
    /// refraction), one for roulette.
    pub(crate) fn bounce(&self, photon: u32, bounce: u32, stream: &mut Stream) -> [f32; 3] {
        if bounce == 0 {
            self.stratified(photon, dimension::FIRST_BOUNCE)
        } else {
            std::array::from_fn(|_| stream.next_f32())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of as many photons as a power of two, each stratum has one; other iterations and seeds shift them otherwise.
    #[test]
    fn numbers_are_stratified_over_photons() {
        let numbers = PhotonNumbers::new(1, 0);
        for dimension in [0, 3, dimension::LIGHT] {
            let mut cells: Vec<u32> =
                (0..64).map(|photon| (numbers.stratified(photon, [dimension])[0] * 64.0) as u32).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..64).collect::<Vec<u32>>(), "dimension {dimension}");
        }
        let of = |seed, iteration| PhotonNumbers::new(seed, iteration).stratified(5, [0, 1]);
        assert!(of(1, 0) != of(1, 1) && of(1, 0) != of(2, 0));
    }

    #[test]
    fn the_first_bounce_is_stratified_and_later_ones_are_not() {
        let numbers = PhotonNumbers::new(1, 0);
        let mut stream = numbers.stream(9);
        assert_eq!(numbers.bounce(9, 0, &mut stream), numbers.stratified(9, dimension::FIRST_BOUNCE));
        let mut again = numbers.stream(9);
        for bounce in [1, 2] {
            let expected: [f32; 3] = std::array::from_fn(|_| again.next_f32());
            assert_eq!(numbers.bounce(9, bounce, &mut stream), expected, "{bounce}");
        }
    }
}
