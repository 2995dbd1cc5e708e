//! Functions of one lane: random streams, sampling, scattering.

use crate::eye::ray_through;
use crate::light_choice::LightChoice;
use crate::photon_pass;
use crate::{sampling, scatter};
use lanes::{Kernel, LaneKind, Lanes, MOST_LANES, V3, dispatch};
use scene::camera::Frame;
use scene::rng::StreamKey;

/// A map of `A` floats to `B` floats.
pub(super) trait Map<const A: usize, const B: usize> {
    /// Mark it `#[inline(always)]`.
    fn apply<L: Lanes>(&self, inputs: [L::F; A]) -> [L::F; B];
}

/// A map over columns of equal lengths, the last packet padded with zeros.
pub(super) struct OverColumns<'a, T, const A: usize, const B: usize> {
    pub(super) map: T,
    pub(super) inputs: [&'a [f32]; A],
    pub(super) outputs: [&'a mut [f32]; B],
}

impl<T: Map<A, B>, const A: usize, const B: usize> OverColumns<'_, T, A, B> {
    /// Runs the map on lanes of the given kind.
    ///
    /// # Panics
    /// If the columns differ in length.
    pub(super) fn on(self, lanes: LaneKind) {
        let count = self.outputs[0].len();
        assert!(self.inputs.iter().all(|column| column.len() == count), "columns differ in length");
        assert!(self.outputs.iter().all(|column| column.len() == count), "columns differ in length");
        dispatch(lanes, self);
    }
}

impl<T: Map<A, B>, const A: usize, const B: usize> Kernel for OverColumns<'_, T, A, B> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let count = self.outputs[0].len();
        let whole = count / L::N * L::N;
        let mut inputs = [L::f(0.0); A];
        for at in (0..whole).step_by(L::N) {
            for column in 0..A {
                inputs[column] = L::load(&self.inputs[column][at..]);
            }
            let outputs = self.map.apply::<L>(inputs);
            for column in 0..B {
                L::store(outputs[column], &mut self.outputs[column][at..]);
            }
        }
        if whole < count {
            let mut padded = [0.0; MOST_LANES];
            for column in 0..A {
                padded[..count - whole].copy_from_slice(&self.inputs[column][whole..]);
                inputs[column] = L::load(&padded);
            }
            let outputs = self.map.apply::<L>(inputs);
            for column in 0..B {
                L::store(outputs[column], &mut padded);
                self.outputs[column][whole..].copy_from_slice(&padded[..count - whole]);
            }
        }
    }
}

/// Makes each map a function over columns: its parameters, the names of its inputs, its number of outputs.
macro_rules! maps {
    ($($(#[$doc:meta])* $name:ident($($parameter:ident: $type:ty),*) [$($input:ident),*] -> $outputs:literal $body:block)*) => {$(
        $(#[$doc])*
        ///
        /// # Panics
        /// If the columns differ in length.
        pub fn $name(
            lanes: lanes::LaneKind,
            $($parameter: $type,)*
            inputs: [&[f32]; [$(stringify!($input)),*].len()],
            outputs: [&mut [f32]; $outputs],
        ) {
            struct This {
                $($parameter: $type),*
            }
            impl $crate::kernels::maps::Map<{ [$(stringify!($input)),*].len() }, $outputs> for This {
                #[inline(always)]
                fn apply<L: Lanes>(&self, [$($input),*]: [L::F; [$(stringify!($input)),*].len()]) -> [L::F; $outputs] {
                    let Self { $($parameter),* } = self;
                    $body
                }
            }
            let map = This { $($parameter),* };
            $crate::kernels::maps::OverColumns { map, inputs, outputs }.on(lanes);
        }
    )*};
}
pub(super) use maps;

#[inline(always)]
fn columns<L: Lanes>(v: V3<L>) -> [L::F; 3] {
    [v.x, v.y, v.z]
}

maps! {
    /// The start states of streams `index` (words).
    stream_state(key: StreamKey) [index] -> 1 {
        [L::from_bits(sampling::stream_state::<L>(*key, L::bits(index)))]
    }

    /// The next states of streams (words), and their next uniform numbers.
    next_uniform() [state] -> 2 {
        let mut state = L::bits(state);
        let uniform = sampling::next_uniform::<L>(&mut state);
        [L::from_bits(state), uniform]
    }

    /// Words to floats in [0, 1).
    unit_float() [word] -> 1 {
        [sampling::unit_float::<L>(L::bits(word))]
    }

    /// Sine and cosine of `2 pi u`.
    sincos_turn() [u] -> 2 {
        let (sin, cos) = sampling::sincos_turn::<L>(u);
        [sin, cos]
    }

    /// Points of the unit disk.
    uniform_disk() [u, v] -> 2 {
        let (x, y) = sampling::uniform_disk::<L>(u, v);
        [x, y]
    }

    /// Points of the unit sphere.
    uniform_sphere() [u, v] -> 3 {
        columns(sampling::uniform_sphere::<L>(u, v))
    }

    /// Directions about normals `n`.
    cosine_hemisphere() [nx, ny, nz, u, v] -> 3 {
        columns(sampling::cosine_hemisphere::<L>(V3::new(nx, ny, nz), u, v))
    }

    /// Directions in cones about `a` of the given height, and `1 - cos` of their angles to `a`.
    uniform_cone() [ax, ay, az, height, u, v] -> 4 {
        let (d, h) = sampling::uniform_cone::<L>(V3::new(ax, ay, az), height, u, v);
        [d.x, d.y, d.z, h]
    }

    /// Two unit vectors that make a frame with `n`.
    orthonormal_frame() [nx, ny, nz] -> 6 {
        let (s, t) = sampling::frame::<L>(V3::new(nx, ny, nz));
        [s.x, s.y, s.z, t.x, t.y, t.z]
    }

    /// Vectors scaled to unit length.
    unit() [x, y, z] -> 3 {
        columns(sampling::unit::<L>(V3::new(x, y, z)))
    }

    /// The largest components.
    max_component() [x, y, z] -> 1 {
        [V3::<L>::new(x, y, z).max_component()]
    }

    /// Directions `d` mirrored about `n`.
    reflect() [dx, dy, dz, nx, ny, nz] -> 3 {
        columns(scatter::reflect::<L>(V3::new(dx, dy, dz), V3::new(nx, ny, nz)))
    }

    /// Reflectances.
    fresnel() [eta, cos_i, cos_t] -> 1 {
        [scatter::fresnel::<L>(eta, cos_i, cos_t)]
    }

    /// Directions `d` after a boundary of glass with normal `n`, met from inside where `inside` is above zero; and
    /// the factor of radiance.
    dielectric() [dx, dy, dz, nx, ny, nz, inside, ior, u] -> 4 {
        let (d, n) = (V3::new(dx, dy, dz), V3::new(nx, ny, nz));
        let (d, scale) = scatter::dielectric::<L>(d, n, L::lt(L::f(0.0), inside), ior, u);
        [d.x, d.y, d.z, scale]
    }

    /// The same, reflected or refracted by the roots of the shares of the power.
    dielectric_by_roots() [dx, dy, dz, nx, ny, nz, inside, ior, u] -> 4 {
        let (d, n) = (V3::new(dx, dy, dz), V3::new(nx, ny, nz));
        let (d, scale) = scatter::dielectric_by_roots::<L>(d, n, L::lt(L::f(0.0), inside), ior, u);
        [d.x, d.y, d.z, scale]
    }

    /// Powers, in multiples of the nominal power, as fluxes (words) in units of `FLUX_ONE` to it.
    quantise() [power] -> 1 {
        [photon_pass::quantise::<L>(power)]
    }

    /// Powers of aimed photons as fluxes (words), with the exponent in the upper eight bits of the first; and 1 where there is one, else 0.
    quantise_aimed(scale: f32) [r, g, b] -> 4 {
        let ([r, g, b], heavy) = photon_pass::quantise_aimed::<L>(*scale, V3::new(r, g, b));
        [r, g, b, L::select(L::eq(heavy, L::u(0)), L::f(0.0), L::f(1.0))]
    }

    /// 1 where a photon of power `p` survives the roulette at albedo `a`, else 0; and its power then.
    survive() [px, py, pz, ax, ay, az, roulette] -> 4 {
        let (survives, p) = photon_pass::survive::<L>(V3::new(px, py, pz), V3::new(ax, ay, az), roulette);
        [L::select(survives, L::f(1.0), L::f(0.0)), p.x, p.y, p.z]
    }

    /// Origins and directions of the rays through places of the image, and (where there is one) of the lens.
    camera_ray(frame: Frame) [x, y, u, v] -> 6 {
        let (o, d) = ray_through::<L>(frame, x, y, [u, v]);
        [o.x, o.y, o.z, d.x, d.y, d.z]
    }

    /// The numbers (words) of the lights that `u` chooses by their cumulative probabilities.
    choose_light(cumulative: Vec<f32>) [u] -> 1 {
        [L::from_bits(LightChoice::new(cumulative).choose::<L>(u))]
    }
}
