//! Sums of flux at visible points: in floats and in order of arrival, as in the paper, or in integers, whose sums do
//! not depend on the order.

use crate::vector::Vector;
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;
use scene::film::{FLUX_ONE, FluxUnit};
use std::f32::consts::FRAC_1_PI;

/// A photon's power, in the forms that are added.
#[derive(Clone, Copy)]
pub(crate) struct Photon {
    /// The power in W.
    power: Vec3,
    /// The power quantised as in the reference; unused if floats are summed.
    quantised: [u64; 3],
}

/// Integer sums as in the reference, if requested: three channels and the number of photons per pixel. They are kept
/// outside of the layouts, which hold floats.
pub(crate) struct IntegerSums(Option<Vec<[u64; 4]>>);

impl IntegerSums {
    /// Sums for this number of pixels, or none if they are not wanted.
    pub(crate) fn new(pixels: usize, are_wanted: bool) -> Self {
        Self(are_wanted.then(|| vec![[0; 4]; pixels.next_multiple_of(MOST_LANES)]))
    }

    /// A photon whose power is given in units of the nominal power.
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

    /// Adds a photon to the pixels `ids[lane]` of the lanes whose bits are set. Does nothing and returns false if
    /// floats are to be summed.
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

    /// Takes the sums of a pixel as floats: three channels of flux, and the number of photons. `None` if floats are
    /// summed elsewhere.
    #[inline(always)]
    pub(crate) fn take(&mut self, pixel: usize, nominal: f32) -> Option<[f32; 4]> {
        let [r, g, b, m] = std::mem::take(&mut self.0.as_mut()?[pixel]);
        // As in the reference: exact as an f64, then rounded once, and multiplied by the power of two first.
        let FluxUnit { part, nominal } = FluxUnit::new(nominal, 1.0);
        let flux = |sum: u64| (sum as f64) as f32 * part * nominal;
        Some([flux(r), flux(g), flux(b), m as f32])
    }

    /// The factor from flux to the increase of `tau`: the path's throughput, and for integers also the BSDF. Floats
    /// were already multiplied by the BSDF.
    #[inline(always)]
    pub(crate) fn weight<V: Vector>(&self, attenuation: V, colour: V) -> V {
        if self.0.is_some() { (attenuation * colour).scale(V::L::f(FRAC_1_PI)) } else { attenuation }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |sums| size_of_val(&sums[..]))
    }
}

/// The contribution of a photon to visible points of the given colours, as in the paper: `bsdf * power`.
#[inline(always)]
pub(crate) fn contribution<V: Vector>(photon: &Photon, colour: V) -> V {
    colour.scale(V::L::f(FRAC_1_PI)) * V::splat(photon.power)
}
