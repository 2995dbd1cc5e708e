//! The units in which the fluxes of aimed photons are counted: see docs/aiming.md, "Integers".

/// Bits by which the unit of flux is lowered for light photons, at most: those of a sun in the place and of the size of ours, in metres,
/// that are aimed at a ball of radius 0.3 weigh 2^-80. Photons weigh at most 2^3 as they depart, and are doubled by at most
/// [`AIMED_BOUNCES`](super::AIMED_BOUNCES) surfaces. So no flux exceeds 2^(3 + 3 + 21 + 69), and as fewer than 2^31 photons are
/// deposited no sum exceeds 2^127.
pub const MOST_SCALE_BITS: u32 = 69;

/// No ball is a target that less of the lamps' flux crosses. The lightest photon has 10 bits then: an error of 2^-11 of its brightest
/// channel, at random.
pub(super) const LEAST_FLUX: f64 = 1.0 / (1_u128 << (MOST_SCALE_BITS + EXPONENT_STEP + 3)) as f64;

/// Exponents of heavy photons' fluxes are multiples of this; weights of up to `2^EXPONENT_STEP` times the least need none
/// ([`Aim::scale_bits`](super::Aim::scale_bits)).
pub const EXPONENT_STEP: u32 = 8;
