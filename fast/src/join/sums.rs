//! What the pixels of a group gather from the photons of an iteration.

use super::deposit::Flux;
use crate::pixels::GROUP;
use lanes::{Lanes, MOST_LANES};

/// The sums of a group's pixels: `reference::consolidate::Gathered`, for each.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroupSums {
    /// Photons that count: `M`.
    pub(crate) m: [u32; GROUP],
    /// The lower 64 bits of the sums of fluxes per channel, in units of `FLUX_ONE` to the nominal power.
    flux: [[u64; GROUP]; 3],
    /// The bits above those; `None` until a heavy photon counts, as without such sums stay below 2^52. With them they stay
    /// below 2^127 ([`scene::aim::MOST_SCALE_BITS`]).
    upper: Option<Box<[[u64; GROUP]; 3]>>,
}

/// Bytes of [`GroupSums`] with heavy photons.
pub(crate) const MOST_BYTES_OF_SUMS: usize = size_of::<GroupSums>() + size_of::<[[u64; GROUP]; 3]>();

/// `x as f64`, by operations that all vectors have: no processor but those with AVX-512 converts 64-bit integers. Each half of
/// the digits is put below the leading one of a power of two, which is taken away again; so only the last sum is rounded.
#[inline(always)]
fn to_float(x: u64) -> f64 {
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    const TWO_84: f64 = TWO_52 * 4_294_967_296.0;
    let upper = f64::from_bits(TWO_84.to_bits() | x >> 32);
    let lower = f64::from_bits(TWO_52.to_bits() | x & 0xffff_ffff);
    (upper - (TWO_84 + TWO_52)) + lower
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JoinCounts {
    /// Pairs of a photon and a visible point that were tested.
    pub(crate) candidates: u64,
    /// Pairs that count.
    pub(crate) contributions: u64,
}

impl GroupSums {
    /// Adds the flux of a heavy photon to the pixels whose bit is set in `pixels`. Photons are heavy seldom.
    #[cold]
    #[inline(never)]
    pub(crate) fn add_heavy(&mut self, pixels: u32, flux: Flux) {
        self.upper.get_or_insert_with(|| Box::new([[0; GROUP]; 3]));
        for pixel in (0..GROUP).filter(|pixel| pixels >> pixel & 1 == 1) {
            for (channel, units) in flux.units.into_iter().enumerate() {
                self.add_flux(channel, pixel, u128::from(units) << flux.shift);
            }
        }
    }

    /// Adds to the flux of one pixel.
    #[inline(always)]
    pub(crate) fn add_flux(&mut self, channel: usize, pixel: usize, flux: u128) {
        let lower = &mut self.flux[channel][pixel];
        match &mut self.upper {
            None => *lower += flux as u64,
            Some(upper) => {
                let sum = u128::from(*lower) + flux;
                *lower = sum as u64;
                upper[channel][pixel] += (sum >> u64::BITS) as u64;
            }
        }
    }

    /// The flux of one pixel.
    pub(crate) fn total(&self, channel: usize, pixel: usize) -> u128 {
        let upper = self.upper.as_ref().map_or(0, |upper| upper[channel][pixel]);
        u128::from(upper) << u64::BITS | u128::from(self.flux[channel][pixel])
    }

    /// The fluxes of the pixels from `first` on, rounded to `f64` and then to `f32`.
    #[inline(always)]
    pub(crate) fn rounded(&self, channel: usize, first: usize, fluxes: &mut [f32]) {
        if self.upper.is_some() {
            for (pixel, flux) in (first..).zip(fluxes) {
                *flux = self.total(channel, pixel) as f64 as f32;
            }
            return;
        }
        for (flux, sum) in fluxes.iter_mut().zip(&self.flux[channel][first..]) {
            *flux = to_float(*sum) as f32;
        }
    }

    /// Adds to the pixels from `first` on; returns how many photons that are.
    #[inline(always)]
    pub(crate) fn add<L: Lanes>(&mut self, first: usize, m: L::U, flux: [L::U; 3]) -> u64 {
        let (mut values, mut count) = ([0; MOST_LANES], 0);
        L::store_u(m, &mut values);
        for k in 0..L::N {
            self.m[first + k] += values[k];
            count += u64::from(values[k]);
        }
        for channel in 0..3 {
            L::store_u(flux[channel], &mut values);
            if self.upper.is_some() {
                for k in 0..L::N {
                    self.add_flux(channel, first + k, values[k].into());
                }
            } else {
                for (sum, value) in self.flux[channel][first..][..L::N].iter_mut().zip(values) {
                    *sum += u64::from(value);
                }
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::to_float;

    /// At all powers of two and beside them, where rounding ties, and at what comes of multiplying.
    #[test]
    fn integers_are_rounded_as_a_cast_rounds_them() {
        let beside = |power: u64| [power - 1, power, power + 1, power + power / 2, power | power >> 53];
        let powers = (0..64).map(|bit| 1_u64 << bit).flat_map(beside);
        let others = (1..2000_u64).map(|k| k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (k % 64));
        for x in powers.chain(others).chain([0, u64::MAX]) {
            assert_eq!(to_float(x), x as f64, "{x}");
        }
    }
}
