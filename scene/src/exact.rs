//! Exact sums of what pixels gain, for iterations that are added up in any order and grouping.
//!
//! A gain, an `f32`, is rounded once to a multiple of a unit and clamped; sums of integers are exact. The unit follows from
//! the scene: with 2^e the least power of two above the brightest emission of any channel, it is 2^(e - 80).
//!
//! **No overflow.** A gain is clamped to less than 2^161 units, and a render has at most 2^30 iterations
//! ([`MAX_ITERATIONS`](crate::settings::MAX_ITERATIONS)), so sums stay below 2^191: they fit 192 bits with a sign.
//!
//! **Nothing is lost that an `f32` would keep.** A gain of 2^-56 of the brightest emission or more is a whole number of units,
//! as an `f32` has 24 bits; it is added without any rounding. A smaller one is rounded by at most 2^-80 of the brightest
//! emission, which the `f32` sum of any pixel of 2^-55 of that or more would lose as well. Above, a clamped gain would be
//! 2^81 times the brightest emission or more. What a pixel gains is at most (emission met on the way, direct light, and of `l`
//! photons all deposited within its radius, each of 8 times the nominal power `P / l`) of the order of
//! `8 d P / (pi^2 r^2)`, with `d` the depth and `P` the power of all lamps, `4 pi^2 R^2` times their emission. In 2^30
//! iterations `r^2` falls to 2^-10. So no gain is clamped while the lamps are below 2^30 initial radii wide.

use crate::world::Scene;
use std::ops::AddAssign;

/// Bits of a unit below the brightest emission.
const BITS_BELOW: i32 = 80;
/// A gain is below two to this power, in units.
const BITS_OF_GAIN: u32 = 161;

/// A sum in units, of 192 bits: two's complement, the lowest word first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exact(pub [u64; 3]);

/// The unit of the sums of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// A unit is two to this power, in radiance.
    exponent: i32,
}

impl Scale {
    /// That of a scene, by its brightest emission.
    pub fn of(scene: &Scene) -> Self {
        let brightest = scene.spheres.iter().map(|sphere| sphere.emission.max_element()).fold(0.0, f32::max);
        Self { exponent: exponent_above(brightest) - BITS_BELOW }
    }

    /// A gain in units: rounded to the nearest, halves away from zero, and clamped. What is not a number counts as nothing.
    pub fn quantise(self, gain: f32) -> Exact {
        let (size, is_negative) = (f64::from(gain.abs()), gain < 0.0);
        if size.is_nan() || size == 0.0 {
            return Exact::default();
        }
        // An `f64` holds every `f32` as a normal number: 53 bits, of which the lower 29 are zero.
        let (bits, zeros) = (size.to_bits(), 52);
        let exponent = (bits >> zeros) as i32 - 1023;
        let digits = (bits & ((1 << zeros) - 1)) | (1 << zeros);
        let places = exponent - zeros - self.exponent;
        let units = if size.is_infinite() || exponent - self.exponent >= BITS_OF_GAIN as i32 {
            Exact::MOST_OF_GAIN
        } else if places >= 0 {
            Exact::shifted(digits, places as u32)
        } else {
            // 64 places and more take away all 53 bits, and so does the rounding of half a unit.
            let places = places.unsigned_abs().min(63);
            Exact([(digits + (1 << (places - 1))) >> places, 0, 0])
        };
        if is_negative { units.negated() } else { units }
    }

    /// The mean of `count` gains whose sum this is, as radiance.
    pub fn mean(self, sum: Exact, count: u32) -> f32 {
        (sum.to_f64() * power_of_two(self.exponent) / f64::from(count)) as f32
    }
}

/// The exponent of the least power of two above `x`; 0 for 0.
fn exponent_above(x: f32) -> i32 {
    if x > 0.0 { (f64::from(x).to_bits() >> 52) as i32 - 1022 } else { 0 }
}

/// Two to this power, which is that of a normal `f64`.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

impl Exact {
    /// The largest gain.
    const MOST_OF_GAIN: Self = Self([u64::MAX, u64::MAX, (1 << (BITS_OF_GAIN - 128)) - 1]);

    /// `digits` times two to the power of `places`, which together are below 192 bits.
    fn shifted(digits: u64, places: u32) -> Self {
        let (word, bits) = ((places / 64) as usize, places % 64);
        let wide = u128::from(digits) << bits;
        let mut sum = [0; 3];
        sum[word] = wide as u64;
        if let Some(next) = sum.get_mut(word + 1) {
            *next = (wide >> 64) as u64;
        }
        Self(sum)
    }

    fn negated(self) -> Self {
        let mut sum = Self(self.0.map(|word| !word));
        sum += Self([1, 0, 0]);
        sum
    }

    fn is_negative(self) -> bool {
        self.0[2] >> 63 == 1
    }

    /// Rounded to an `f64`: the size's upper and lower parts each, then their sum.
    fn to_f64(self) -> f64 {
        let [low, middle, high] = if self.is_negative() { self.negated().0 } else { self.0 };
        let upper = u128::from(high) << 64 | u128::from(middle);
        let size = upper as f64 * power_of_two(64) + low as f64;
        if self.is_negative() { -size } else { size }
    }

    /// Whether it can be the sum of the gains of so many iterations.
    #[inline]
    pub fn is_sum_of(self, iterations: u32) -> bool {
        let size = if self.is_negative() { self.negated() } else { self };
        let most = u128::from(iterations) << (BITS_OF_GAIN - 128);
        u128::from(size.0[2]) < most || size == Self::default()
    }
}

impl AddAssign for Exact {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        let mut carry = false;
        for (word, more) in self.0.iter_mut().zip(other.0) {
            let (sum, first) = word.overflowing_add(more);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            (*word, carry) = (sum, first || second);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Scale = Scale { exponent: -80 };

    fn sum(scale: Scale, gains: &[f32]) -> Exact {
        let mut sum = Exact::default();
        for gain in gains {
            sum += scale.quantise(*gain);
        }
        sum
    }

    /// As 128 bits, which small gains fit.
    fn small(exact: Exact) -> i128 {
        let [low, middle, high] = exact.0;
        assert_eq!(high, if middle >> 63 == 1 { u64::MAX } else { 0 }, "more than 128 bits");
        (u128::from(middle) << 64 | u128::from(low)) as i128
    }

    #[test]
    fn gains_are_rounded_to_the_nearest_unit() {
        let scale = Scale { exponent: 0 };
        for (gain, units) in [
            (0.0, 0),
            (-0.0, 0),
            (1.0, 1),
            (-1.0, -1),
            (0.5, 1),
            (-0.5, -1),
            (0.499_999_97, 0),
            (1.5, 2),
            (2.5, 3),
            (-2.5, -3),
            (8_388_609.0, 8_388_609),
            (1e-40, 0),
            (f32::from_bits(1), 0),
            (f32::NAN, 0),
            (16_777_216.0 * 1e6, 16_777_216_000_000),
        ] {
            assert_eq!(small(scale.quantise(gain)), units, "{gain}");
        }
        assert_eq!(small(ONE.quantise(1.0)), 1 << 80);
        assert_eq!(small(ONE.quantise(-0.75)), -(3 << 78));
        assert_eq!(Scale { exponent: -200 }.quantise(1.0), Exact::MOST_OF_GAIN);
    }

    /// Over all exponents of `f32`: what has 24 bits above the unit comes back as it was, and the rest within half a unit.
    #[test]
    fn a_gain_comes_back() {
        for exponent in -148..80 {
            for digits in [1.0, 1.25, 1.999_999_9] {
                for sign in [1.0, -1.0] {
                    let gain = (sign * digits * 2.0_f64.powi(exponent)) as f32;
                    let back = ONE.mean(ONE.quantise(gain), 1);
                    let error = (f64::from(back) - f64::from(gain)).abs();
                    let most = if exponent >= -56 { 0.0 } else { 2.0_f64.powi(-81) };
                    assert!(error <= most, "{gain} comes back as {back}");
                }
            }
        }
    }

    #[test]
    fn sums_are_exact_whatever_their_order() {
        let gains = [1e20, 1.0, -1e20, 3e-12, -0.25, 1e20, f32::MIN_POSITIVE, -7e5, -1e20];
        let whole = sum(ONE, &gains);
        let mut reversed = gains;
        reversed.reverse();
        assert_eq!(sum(ONE, &reversed), whole);
        let [mut first, last] = [&gains[..4], &gains[4..]].map(|some| sum(ONE, some));
        first += last;
        assert_eq!(first, whole);
        assert_eq!(ONE.mean(whole, 1), (1.0 - 0.25 - 7e5 + 3e-12_f64) as f32);
    }

    /// As the file's head proves: 2^30 of the largest gains.
    #[test]
    fn nothing_overflows() {
        for gain in [f32::INFINITY, f32::MAX, f32::NEG_INFINITY] {
            let mut all = ONE.quantise(gain);
            for doubled in 0..30 {
                assert_eq!(all.is_negative(), gain < 0.0, "{gain} times 2^{doubled}");
                assert!(all.is_sum_of(1 << doubled) && !all.is_sum_of((1 << doubled) / 2));
                let again = all;
                all += again;
            }
            assert!(all.is_sum_of(crate::settings::MAX_ITERATIONS));
            assert_eq!(all.is_negative(), gain < 0.0);
            let mean = f64::from(ONE.mean(all, 1 << 30)).abs();
            assert!((mean / 2.0_f64.powi(81) - 1.0).abs() < 1e-6, "{mean}");
        }
    }

    #[test]
    fn the_unit_follows_the_brightest_emission() {
        for (brightest, exponent) in [(0.0, 0), (1.0, 1), (0.99, 0), (1e15, 50), (2.0, 2), (1e-42, -139)] {
            assert_eq!(exponent_above(brightest), exponent, "{brightest}");
        }
    }

    /// Of any channel of any sphere; of a scene without light it is as if that were below 1.
    #[test]
    fn the_unit_is_that_of_the_brightest_channel_of_all_spheres() {
        let mut scene = crate::test_scenes::balls(&[(glam::Vec3::X, 0.5, 3.0), (glam::Vec3::Y, 0.5, 1.0)]);
        assert_eq!(Scale::of(&scene), Scale { exponent: 2 - 80 });
        scene.spheres[1].emission.z = 100.0;
        assert_eq!(Scale::of(&scene), Scale { exponent: 7 - 80 });
        scene.spheres[1].emission = glam::Vec3::new(0.0, 0.25, 0.0);
        assert_eq!(Scale::of(&scene), Scale { exponent: 2 - 80 });
        assert_eq!(Scale::of(&crate::test_scenes::balls(&[])), Scale { exponent: -80 });
    }
}
