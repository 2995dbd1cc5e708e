//! Vectors of three components, one per lane.

use crate::operations::Lanes;
use glam::Vec3;

/// A vector of three components in each lane. Operations are glam's, in the same order, so with the same bits.
#[derive(Clone, Copy)]
pub struct V3<L: Lanes> {
    /// The first components.
    pub x: L::F,
    /// The second.
    pub y: L::F,
    /// The third.
    pub z: L::F,
}

impl<L: Lanes> V3<L> {
    /// From components.
    #[inline(always)]
    pub fn new(x: L::F, y: L::F, z: L::F) -> Self {
        Self { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: L::f(v.x), y: L::f(v.y), z: L::f(v.z) }
    }

    /// Dot product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> L::F {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Times a number.
    #[must_use]
    #[inline(always)]
    pub fn scale(self, s: L::F) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    /// `if m { a } else { b }`.
    #[inline(always)]
    pub fn select(m: L::M, a: Self, b: Self) -> Self {
        Self { x: L::select(m, a.x, b.x), y: L::select(m, a.y, b.y), z: L::select(m, a.z, b.z) }
    }

    /// The largest component, by the comparisons of `scene::max_component`.
    #[inline(always)]
    pub fn max_component(self) -> L::F {
        let xy = L::select(L::lt(self.y, self.x), self.x, self.y);
        L::select(L::lt(self.z, xy), xy, self.z)
    }
}

macro_rules! componentwise {
    ($($op:ident $method:ident;)*) => {$(
        impl<L: Lanes> std::ops::$op for V3<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { x: self.x.$method(other.x), y: self.y.$method(other.y), z: self.z.$method(other.z) }
            }
        }
    )*};
}

componentwise! {
    Add add;
    Sub sub;
    Mul mul;
}

impl<L: Lanes> std::ops::Neg for V3<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
