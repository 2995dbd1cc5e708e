//! Vectors of three components, implemented in the ways of the paper's stages: by function calls, inlined, or in one
//! 128-bit register; on one lane or on eight. All implementations run the same operations in the same order.

use crate::counted::Counted;
use crate::one::One;
use glam::Vec3A;
use lanes::{Emulated, Kernel, Lanes, on_avx2};
use scene::Vec3;
use std::ops::{Add, Mul, Neg, Sub};

/// The floats of a vector's lanes.
pub(crate) type F<V> = <<V as Vector>::L as Lanes>::F;
/// The words of a vector's lanes.
pub(crate) type U<V> = <<V as Vector>::L as Lanes>::U;
/// The truth values of a vector's lanes.
pub(crate) type M<V> = <<V as Vector>::L as Lanes>::M;

/// One vector per lane, and whether kernels that use them are called or inlined.
pub(crate) trait Vector:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The lanes.
    type L: Lanes;
    /// True if larger functions are called instead of inlined (see [`callable`]).
    const CALLS: bool;

    /// A vector with the given components.
    fn new(x: F<Self>, y: F<Self>, z: F<Self>) -> Self;
    /// The components.
    fn xyz(self) -> [F<Self>; 3];
    /// The vector multiplied by a number.
    fn scale(self, s: F<Self>) -> Self;
    /// Dot product.
    fn dot(self, other: Self) -> F<Self>;

    /// The same vector in every lane.
    #[inline(always)]
    fn splat(v: Vec3) -> Self {
        Self::new(Self::L::f(v.x), Self::L::f(v.y), Self::L::f(v.z))
    }

    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(Vec3::ZERO)
    }

    /// `if m { a } else { b }`.
    #[inline(always)]
    fn select(m: M<Self>, a: Self, b: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (a.xyz(), b.xyz());
        Self::new(Self::L::select(m, ax, bx), Self::L::select(m, ay, by), Self::L::select(m, az, bz))
    }

    /// The largest component, as `scene::max_component` finds it.
    #[inline(always)]
    fn max_component(self) -> F<Self> {
        let [x, y, z] = self.xyz();
        let xy = Self::L::select(Self::L::lt(y, x), x, y);
        Self::L::select(Self::L::lt(z, xy), xy, z)
    }
}

/// Defines a vector of three components whose operations are inlined `always` or `never`.
macro_rules! vector {
    ($(#[$about:meta])* $name:ident, $module:ident, $inline:ident, calls: $calls:literal) => {
        $(#[$about])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name<L: Lanes> {
            x: L::F,
            y: L::F,
            z: L::F,
        }

        /// The functions of this vector type.
        mod $module {
            use super::{Lanes, $name};

            #[inline($inline)]
            pub(super) fn add<L: Lanes>(a: &$name<L>, b: &$name<L>) -> $name<L> {
                $name { x: a.x + b.x, y: a.y + b.y, z: a.z + b.z }
            }
            #[inline($inline)]
            pub(super) fn sub<L: Lanes>(a: &$name<L>, b: &$name<L>) -> $name<L> {
                $name { x: a.x - b.x, y: a.y - b.y, z: a.z - b.z }
            }
            #[inline($inline)]
            pub(super) fn mul<L: Lanes>(a: &$name<L>, b: &$name<L>) -> $name<L> {
                $name { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
            }
            #[inline($inline)]
            pub(super) fn neg<L: Lanes>(a: &$name<L>) -> $name<L> {
                $name { x: -a.x, y: -a.y, z: -a.z }
            }
            #[inline($inline)]
            pub(super) fn scale<L: Lanes>(a: &$name<L>, s: L::F) -> $name<L> {
                $name { x: a.x * s, y: a.y * s, z: a.z * s }
            }
            #[inline($inline)]
            pub(super) fn dot<L: Lanes>(a: &$name<L>, b: &$name<L>) -> L::F {
                a.x * b.x + a.y * b.y + a.z * b.z
            }
        }

        impl<L: Lanes> Vector for $name<L> {
            type L = L;
            const CALLS: bool = $calls;
            #[inline(always)]
            fn new(x: L::F, y: L::F, z: L::F) -> Self {
                Self { x, y, z }
            }
            #[inline(always)]
            fn xyz(self) -> [L::F; 3] {
                [self.x, self.y, self.z]
            }
            #[inline(always)]
            fn scale(self, s: L::F) -> Self {
                $module::scale(&self, s)
            }
            #[inline(always)]
            fn dot(self, other: Self) -> L::F {
                $module::dot(&self, &other)
            }
        }

        vector!(@operators $name, $module, Add add, Sub sub, Mul mul);

        impl<L: Lanes> Neg for $name<L> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                $module::neg(&self)
            }
        }
    };
    (@operators $name:ident, $module:ident, $($op:ident $method:ident),*) => {$(
        impl<L: Lanes> $op for $name<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                $module::$method(&self, &other)
            }
        }
    )*};
}

vector! {
    /// Stage 0: every operation on vectors is a function call, as are the larger functions.
    Called, called, never, calls: true
}
vector! {
    /// Stage 1: operations on vectors are inlined, the larger functions are called.
    MathInlined, math_inlined, always, calls: true
}
vector! {
    /// From stage 2 on: everything is inlined.
    Inlined, inlined, always, calls: false
}

/// Failed attempt 1: one vector in one 128-bit register, whose fourth lane is unused.
#[derive(Clone, Copy)]
pub(crate) struct Horizontal(Vec3A);

impl Vector for Horizontal {
    type L = One;
    const CALLS: bool = false;
    #[inline(always)]
    fn new(x: f32, y: f32, z: f32) -> Self {
        Self(Vec3A::new(x, y, z))
    }
    #[inline(always)]
    fn xyz(self) -> [f32; 3] {
        self.0.to_array()
    }
    #[inline(always)]
    fn scale(self, s: f32) -> Self {
        Self(self.0 * s)
    }
    /// Computed component by component: reductions stay scalar, as in the paper.
    #[inline(always)]
    fn dot(self, other: Self) -> f32 {
        let ([ax, ay, az], [bx, by, bz]) = (self.xyz(), other.xyz());
        ax * bx + ay * by + az * bz
    }
}

macro_rules! horizontal {
    ($($op:ident $method:ident),*) => {$(
        impl $op for Horizontal {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}

horizontal!(Add add, Sub sub, Mul mul);

impl Neg for Horizontal {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// The vectors that a row's kernels compute with, and the lanes that they run on.
///
/// Only kernels that are timed are inlined as a whole. Counted and emulated ones call their larger functions, which
/// rows then share.
pub(crate) trait Width: 'static {
    /// Runs a pass over the row's own vectors.
    fn run(pass: impl Pass);
    /// Runs a pass over vectors that count every operation.
    fn run_counted(pass: impl Pass);
}

/// A pass that runs on any vectors.
pub(crate) trait Pass {
    /// Runs the pass. Implementations must be marked `#[inline(always)]`.
    fn run<V: Vector>(self);
}

/// Scalar rows, with the vectors `V`.
pub(crate) struct Scalar<V>(std::marker::PhantomData<V>);

impl<W: Vector + 'static> Width for Scalar<W> {
    fn run(pass: impl Pass) {
        pass.run::<W>();
    }
    fn run_counted(pass: impl Pass) {
        pass.run::<MathInlined<Counted<One>>>();
    }
}

/// Vertical rows: one path or candidate per lane of AVX2.
pub(crate) struct Vertical;

/// Adapts a pass to the dispatch on lanes.
struct OnLanes<P>(P);

impl<P: Pass> Kernel for OnLanes<P> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.run::<Inlined<L>>();
    }
}

impl Width for Vertical {
    fn run(pass: impl Pass) {
        // Without AVX2 the row runs slowly, on the vectors that count, which are compiled anyway.
        if let Err(OnLanes(pass)) = on_avx2(OnLanes(pass)) {
            Self::run_counted(pass);
        }
    }
    fn run_counted(pass: impl Pass) {
        pass.run::<MathInlined<Counted<Emulated>>>();
    }
}

/// Defines functions that are inlined, or called if the vectors require it ([`Vector::CALLS`]).
macro_rules! callable {
    ($($(#[$about:meta])* $vis:vis fn $name:ident<V: Vector>($($arg:ident: $type:ty),* $(,)?) -> $out:ty $body:block)*) => {$(
        $(#[$about])*
        #[inline(always)]
        $vis fn $name<V: Vector>($($arg: $type),*) -> $out {
            #[inline(always)]
            fn here<V: Vector>($($arg: $type),*) -> $out $body
            #[inline(never)]
            fn away<V: Vector>($($arg: $type),*) -> $out {
                here::<V>($($arg),*)
            }
            if V::CALLS { away::<V>($($arg),*) } else { here::<V>($($arg),*) }
        }
    )*};
}
pub(crate) use callable;
