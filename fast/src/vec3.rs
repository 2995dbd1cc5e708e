//! Three-vectors in lanes. Operations mirror glam's on one lane, in its order.

use crate::lanes::Lanes;
use scene::Vec3;

/// As many vectors as there are lanes.
#[derive(Clone, Copy)]
pub(crate) struct V3<L: Lanes> {
    pub(crate) x: L::F,
    pub(crate) y: L::F,
    pub(crate) z: L::F,
}

impl<L: Lanes> V3<L> {
    #[inline(always)]
    pub(crate) fn new(x: L::F, y: L::F, z: L::F) -> Self {
        Self { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self { x: L::f(v.x), y: L::f(v.y), z: L::f(v.z) }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> L::F {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn scale(self, s: L::F) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    #[inline(always)]
    pub(crate) fn select(m: L::M, a: Self, b: Self) -> Self {
        Self { x: L::select(m, a.x, b.x), y: L::select(m, a.y, b.y), z: L::select(m, a.z, b.z) }
    }

    /// The largest component, as `scene::max_component` finds it.
    #[inline(always)]
    pub(crate) fn max_component(self) -> L::F {
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
