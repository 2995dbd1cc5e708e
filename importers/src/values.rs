//! Numbers in binary files: how they are stored, and what they are.

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    /// Signed, of 1, 2, 4 or 8 bytes.
    Signed(usize),
    Unsigned(usize),
    /// Of 4 or 8 bytes.
    Float(usize),
}

impl Scalar {
    /// Its bytes.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }

    /// The value of [`Self::size`] bytes. Integers beyond 2^53 are rounded.
    ///
    /// # Panics
    /// If there are fewer bytes.
    #[inline]
    pub(crate) fn value(self, bytes: &[u8], is_big_endian: bool) -> f64 {
        match (self, is_big_endian) {
            // What most files hold.
            (Self::Float(4), false) => f64::from(f32::from_le_bytes(bytes[..4].try_into().expect("4 bytes"))),
            (Self::Float(8), false) => f64::from_le_bytes(bytes[..8].try_into().expect("8 bytes")),
            _ => self.any_value(&bytes[..self.size()], is_big_endian),
        }
    }

    fn any_value(self, bytes: &[u8], is_big_endian: bool) -> f64 {
        let mut word = [0; 8];
        for (place, byte) in bytes.iter().enumerate() {
            let significance = if is_big_endian { bytes.len() - 1 - place } else { place };
            word[significance] = *byte;
        }
        let word = u64::from_le_bytes(word);
        let unused = 64 - 8 * bytes.len() as u32;
        match self {
            Self::Float(4) => f64::from(f32::from_bits(word as u32)),
            Self::Float(_) => f64::from_bits(word),
            Self::Unsigned(_) => word as f64,
            Self::Signed(_) => ((word << unused) as i64 >> unused) as f64,
        }
    }

    /// The value of a colour's full intensity. Of 4 bytes and more it is that of one byte, as libraries widen whole numbers.
    pub(crate) fn full(self) -> f64 {
        match self {
            Self::Float(_) => 1.0,
            Self::Signed(4..) | Self::Unsigned(4..) => 255.0,
            Self::Signed(size) => ((1_u64 << (8 * size - 1)) - 1) as f64,
            Self::Unsigned(size) => ((1_u64 << (8 * size)) - 1) as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_all_kinds_are_read() {
        let both = |scalar: Scalar, bytes: &[u8]| {
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(scalar.value(&reversed, true), scalar.value(bytes, false));
            scalar.value(bytes, false)
        };
        assert_eq!(both(Scalar::Signed(1), &[0xff]), -1.0);
        assert_eq!(both(Scalar::Unsigned(2), &[0x01, 0x02]), 513.0);
        assert_eq!(both(Scalar::Signed(4), &(-7_i32).to_le_bytes()), -7.0);
        assert_eq!(both(Scalar::Unsigned(8), &u64::MAX.to_le_bytes()), 2_f64.powi(64));
        assert_eq!(both(Scalar::Float(4), &1.5_f32.to_le_bytes()), 1.5);
        assert_eq!(both(Scalar::Float(8), &(-0.1_f64).to_le_bytes()), -0.1);
        assert_eq!(
            [Scalar::Unsigned(1).full(), Scalar::Unsigned(2).full(), Scalar::Float(4).full()],
            [255.0, 65535.0, 1.0]
        );
    }
}
