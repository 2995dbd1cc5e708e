//! What photons add to visible points: floats in the order in which they come, as in the paper, or integers, whose
//! sums do not depend on any order.

use crate::vector::Vector;
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;
use scene::film::FLUX_ONE;
use std::f32::consts::FRAC_1_PI;

/// A photon's power, ready to be added.
#[derive(Clone, Copy)]
pub(crate) struct Photon {
    /// In W.
    power: Vec3,
    /// The power as the reference quantises it; of no meaning where floats are summed.
    quantised: [u64; 3],
}

/// Sums of the reference's kind, if they are asked for: per pixel three channels and the number of photons. They stand
/// apart from the layouts, which hold floats.
pub(crate) struct IntegerSums(Option<Vec<[u64; 4]>>);

impl IntegerSums {
    /// For so many pixels, or none at all.
    pub(crate) fn new(pixels: usize, are_wanted: bool) -> Self {
        Self(are_wanted.then(|| vec![[0; 4]; pixels.next_multiple_of(MOST_LANES)]))
    }

    /// A photon whose power is given in multiples of the nominal one.
    #[inline(always)]
    pub(crate) fn photon(&self, power: Vec3, nominal: f32) -> Photon {
        let mut quantised = [0; 3];
        if self.0.is_some() {
            let scale = FLUX_ONE as f32;
            quantised =
                [power.x, power.y, power.z].map(|p| u64::from(((p * scale + 0.5) as u32).min(FLUX_ONE)));
        }
        Photon { power: power * nominal, quantised }
    }

    /// Adds a photon to the pixels `ids[lane]` of the lanes whose bits are set; false if floats are to be summed.
    #[inline(always)]
    pub(crate) fn add(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon) -> bool {
        let Some(sums) = &mut self.0 else { return false };
        let mut rest = bits;
        while rest != 0 {
            let sum = &mut sums[ids[rest.trailing_zeros() as usize] as usize];
            rest &= rest - 1;
            for channel in 0..3 {
                sum[channel] += photon.quantised[channel];
            }
            sum[3] += 1;
        }
        true
    }

    /// What a pixel has gathered, as floats, if it is here: three channels of flux, and the number of photons. The sums
    /// are cleared.
    #[inline(always)]
    pub(crate) fn take(&mut self, pixel: usize, nominal: f32) -> Option<[f32; 4]> {
        let [r, g, b, m] = std::mem::take(&mut self.0.as_mut()?[pixel]);
        let unit = nominal / FLUX_ONE as f32;
        // As the reference: exact as an f64, rounded once.
        let flux = |sum: u64| (sum as f64) as f32 * unit;
        Some([flux(r), flux(g), flux(b), m as f32])
    }

    /// What turns the flux into what `tau` grows by: the path's throughput, and where integers are summed, the BSDF,
    /// which floats have been multiplied by already.
    #[inline(always)]
    pub(crate) fn weight<V: Vector>(&self, attenuation: V, colour: V) -> V {
        if self.0.is_some() { (attenuation * colour).scale(V::L::f(FRAC_1_PI)) } else { attenuation }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |sums| size_of_val(&sums[..]))
    }
}

/// What a photon brings to visible points of the given colours, by the paper: `bsdf * power`.
#[inline(always)]
pub(crate) fn contribution<V: Vector>(photon: &Photon, colour: V) -> V {
    colour.scale(V::L::f(FRAC_1_PI)) * V::splat(photon.power)
}
