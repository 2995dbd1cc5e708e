//! The layouts of the scalar stages: an array of objects (stages 0 and 1), and arrays of floats, vectors and
//! intersections (stages 2 and 3).

use super::gathered::Gathered;
use super::layout::{PixelState, Pixels, Seen, Site, from_the_front, is_not_zero};
use crate::flux::{IntegerSums, Photon};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;
use scene::ray::NO_SPHERE;

/// A vector in memory: three floats, or four of which one is unused.
pub(crate) trait Triple: Copy + Default + 'static {
    fn xyz(&self) -> [f32; 3];
    fn of(xyz: [f32; 3]) -> Self;
}

impl Triple for [f32; 3] {
    #[inline(always)]
    fn xyz(&self) -> [f32; 3] {
        *self
    }
    #[inline(always)]
    fn of(xyz: [f32; 3]) -> Self {
        xyz
    }
}

impl Triple for glam::Vec3A {
    #[inline(always)]
    fn xyz(&self) -> [f32; 3] {
        self.to_array()
    }
    #[inline(always)]
    fn of(xyz: [f32; 3]) -> Self {
        Self::from_array(xyz)
    }
}

#[inline(always)]
fn load<V: Vector>(from: &impl Triple) -> V {
    let xyz = from.xyz();
    V::new(V::L::load(&xyz[..1]), V::L::load(&xyz[1..2]), V::L::load(&xyz[2..]))
}

#[inline(always)]
fn store<V: Vector, T: Triple>(v: V, to: &mut T) {
    let [x, y, z] = v.xyz();
    let mut xyz = [0.0; 3];
    V::L::store(x, &mut xyz[..1]);
    V::L::store(y, &mut xyz[1..2]);
    V::L::store(z, &mut xyz[2..]);
    *to = T::of(xyz);
}

/// Where a camera path met a diffuse surface.
#[derive(Clone, Copy, Default)]
pub(crate) struct Intersection<T> {
    point: T,
    normal: T,
    incident: T,
    colour: T,
    sphere: u32,
    in_shell: bool,
}

/// Mutable access to one pixel.
pub(crate) struct PixelMut<'a, T> {
    direct: &'a mut T,
    tau: &'a mut T,
    n: &'a mut f32,
    radius_squared: &'a mut f32,
    sums: &'a mut [f32; 4],
    attenuation: &'a mut T,
    intersection: &'a mut Intersection<T>,
    is_set: Option<&'a mut bool>,
}

/// Pixels that are read and changed one at a time.
pub(crate) trait OneByOne {
    type T: Triple;
    fn new(count: usize, radius_squared: f32) -> Self;
    fn pixel(&mut self, index: usize) -> PixelMut<'_, Self::T>;
    fn gathered(&self, index: usize) -> (&Self::T, &Self::T, f32);
    fn radius_squared(&self, index: usize) -> &f32;
    fn attenuation(&self, index: usize) -> &Self::T;
    fn intersection(&self, index: usize) -> &Intersection<Self::T>;
    /// Whether the pixel has a visible point, if the layout stores that as a flag.
    fn flag(&self, index: usize) -> Option<bool>;
    fn bytes(&self) -> usize;
}

/// A layout of the scalar stages.
pub(crate) struct ScalarPixels<P> {
    pixels: P,
    integer_sums: IntegerSums,
}

impl<P: OneByOne + 'static> Pixels for ScalarPixels<P> {
    /// The index of the candidate; its data is read when needed.
    type Held<V: Vector> = u32;

    fn new(count: usize, initial_radius: f32, integer_sums: IntegerSums) -> Self {
        Self { pixels: P::new(count, initial_radius * initial_radius), integer_sums }
    }

    #[inline(always)]
    fn sums(&self) -> &IntegerSums {
        &self.integer_sums
    }

    #[inline(always)]
    fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>) {
        let pixel = self.pixels.pixel(at);
        store(load::<V>(pixel.direct) + seen.direct, pixel.direct);
        let is_set = V::L::any(is_not_zero(seen.attenuation));
        if let Some(flag) = pixel.is_set {
            *flag = is_set;
        }
        store(self.integer_sums.weight(seen.attenuation, seen.colour), pixel.attenuation);
        if is_set {
            let mut sphere = [NO_SPHERE];
            V::L::store_u(seen.sphere, &mut sphere);
            store(seen.point, &mut pixel.intersection.point);
            store(seen.normal, &mut pixel.intersection.normal);
            store(from_the_front(seen), &mut pixel.intersection.incident);
            store(seen.colour, &mut pixel.intersection.colour);
            pixel.intersection.sphere = sphere[0];
            pixel.intersection.in_shell = V::L::any(seen.in_shell);
        }
    }

    #[inline(always)]
    fn site<V: Vector>(&self, at: usize) -> Site<V> {
        let intersection = self.pixels.intersection(at);
        Site {
            is_set: self.is_set::<V>(&(at as u32)),
            point: load(&intersection.point),
            radius_squared: V::L::load(std::slice::from_ref(self.pixels.radius_squared(at))),
            sphere: V::L::load_u(std::slice::from_ref(&intersection.sphere)),
        }
    }

    #[inline(always)]
    fn fetch<V: Vector>(&self, ids: U<V>) -> u32 {
        let mut id = [0];
        V::L::store_u(ids, &mut id);
        id[0]
    }
    #[inline(always)]
    fn is_set<V: Vector>(&self, held: &u32) -> M<V> {
        match self.pixels.flag(*held as usize) {
            Some(flag) => V::L::mask_from_bits(u32::from(flag)),
            None => is_not_zero(load::<V>(self.pixels.attenuation(*held as usize))),
        }
    }
    #[inline(always)]
    fn reach<V: Vector>(&self, held: &u32) -> (V, F<V>) {
        let index = *held as usize;
        let point = load(&self.pixels.intersection(index).point);
        (point, V::L::load(std::slice::from_ref(self.pixels.radius_squared(index))))
    }
    #[inline(always)]
    fn normal<V: Vector>(&self, held: &u32) -> V {
        load(&self.pixels.intersection(*held as usize).normal)
    }
    #[inline(always)]
    fn is_seen<V: Vector>(&self, held: &u32, normal: V) -> M<V> {
        let incident: V = load(&self.pixels.intersection(*held as usize).incident);
        V::L::lt(incident.dot(normal), V::L::f(0.0))
    }
    #[inline(always)]
    fn is_in_shell<V: Vector>(&self, held: &u32, sphere: u32) -> M<V> {
        let intersection = self.pixels.intersection(*held as usize);
        V::L::mask_from_bits(u32::from(intersection.in_shell && intersection.sphere == sphere))
    }
    #[inline(always)]
    fn colour<V: Vector>(&self, _: &Tables, held: &u32) -> V {
        load(&self.pixels.intersection(*held as usize).colour)
    }

    #[inline(always)]
    fn add<V: Vector>(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon, contribution: V) {
        if self.integer_sums.add(bits, ids, photon) {
            return;
        }
        let [r, g, b] = contribution.xyz();
        let mut lane = [0.0, 0.0, 0.0, 1.0];
        V::L::store(r, &mut lane[..1]);
        V::L::store(g, &mut lane[1..2]);
        V::L::store(b, &mut lane[2..3]);
        let sums = self.pixels.pixel(ids[0] as usize).sums;
        for channel in 0..4 {
            sums[channel] += lane[channel];
        }
    }

    #[inline(always)]
    fn consolidate<V: Vector>(&mut self, at: usize, nominal: f32) {
        let pixel = self.pixels.pixel(at);
        let mut sums = [[0.0; 4]; MOST_LANES];
        sums[0] = self.integer_sums.take(at, nominal).unwrap_or(std::mem::take(pixel.sums));
        let before = Gathered::<V> {
            tau: load(pixel.tau),
            n: V::L::load(std::slice::from_ref(pixel.n)),
            radius_squared: V::L::load(std::slice::from_ref(pixel.radius_squared)),
        };
        let after = before.consolidated(load(pixel.attenuation), &sums);
        store(after.tau, pixel.tau);
        V::L::store(after.n, std::slice::from_mut(pixel.n));
        V::L::store(after.radius_squared, std::slice::from_mut(pixel.radius_squared));
    }

    fn state(&self, index: usize) -> PixelState {
        let (direct, tau, n) = self.pixels.gathered(index);
        PixelState {
            direct: Vec3::from_array(direct.xyz()),
            tau: Vec3::from_array(tau.xyz()),
            n,
            radius_squared: *self.pixels.radius_squared(index),
        }
    }

    fn bytes(&self) -> usize {
        self.pixels.bytes() + self.integer_sums.bytes()
    }
}

/// All data of a pixel in one object.
#[derive(Clone, Copy)]
pub(crate) struct Object {
    radius_squared: f32,
    n: f32,
    tau: [f32; 3],
    direct: [f32; 3],
    sums: [f32; 4],
    attenuation: [f32; 3],
    intersection: Intersection<[f32; 3]>,
}

/// Stages 0 and 1: an array of objects.
pub(crate) struct Objects(Vec<Object>);

impl OneByOne for Objects {
    type T = [f32; 3];
    fn new(count: usize, radius_squared: f32) -> Self {
        let zero = [0.0; 3];
        let object = Object {
            radius_squared,
            n: 0.0,
            tau: zero,
            direct: zero,
            sums: Default::default(),
            attenuation: zero,
            intersection: Intersection::default(),
        };
        Self(vec![object; count])
    }
    #[inline(always)]
    fn pixel(&mut self, index: usize) -> PixelMut<'_, [f32; 3]> {
        let object = &mut self.0[index];
        PixelMut {
            direct: &mut object.direct,
            tau: &mut object.tau,
            n: &mut object.n,
            radius_squared: &mut object.radius_squared,
            sums: &mut object.sums,
            attenuation: &mut object.attenuation,
            intersection: &mut object.intersection,
            is_set: None,
        }
    }
    fn gathered(&self, index: usize) -> (&[f32; 3], &[f32; 3], f32) {
        let object = &self.0[index];
        (&object.direct, &object.tau, object.n)
    }
    #[inline(always)]
    fn radius_squared(&self, index: usize) -> &f32 {
        &self.0[index].radius_squared
    }
    #[inline(always)]
    fn attenuation(&self, index: usize) -> &[f32; 3] {
        &self.0[index].attenuation
    }
    #[inline(always)]
    fn intersection(&self, index: usize) -> &Intersection<[f32; 3]> {
        &self.0[index].intersection
    }
    #[inline(always)]
    fn flag(&self, _: usize) -> Option<bool> {
        None
    }
    fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

/// From stage 2 on: an array for each type of data, and a flag for whether there is a visible point.
pub(crate) struct TypedArrays<T> {
    direct: Vec<T>,
    tau: Vec<T>,
    n: Vec<f32>,
    radius_squared: Vec<f32>,
    sums: Vec<[f32; 4]>,
    attenuation: Vec<T>,
    intersections: Vec<Intersection<T>>,
    flags: Vec<bool>,
}

impl<T: Triple> OneByOne for TypedArrays<T> {
    type T = T;
    fn new(count: usize, radius_squared: f32) -> Self {
        Self {
            direct: vec![T::default(); count],
            tau: vec![T::default(); count],
            n: vec![0.0; count],
            radius_squared: vec![radius_squared; count],
            sums: vec![Default::default(); count],
            attenuation: vec![T::default(); count],
            intersections: vec![Intersection::default(); count],
            flags: vec![false; count],
        }
    }
    #[inline(always)]
    fn pixel(&mut self, index: usize) -> PixelMut<'_, T> {
        PixelMut {
            direct: &mut self.direct[index],
            tau: &mut self.tau[index],
            n: &mut self.n[index],
            radius_squared: &mut self.radius_squared[index],
            sums: &mut self.sums[index],
            attenuation: &mut self.attenuation[index],
            intersection: &mut self.intersections[index],
            is_set: Some(&mut self.flags[index]),
        }
    }
    fn gathered(&self, index: usize) -> (&T, &T, f32) {
        (&self.direct[index], &self.tau[index], self.n[index])
    }
    #[inline(always)]
    fn radius_squared(&self, index: usize) -> &f32 {
        &self.radius_squared[index]
    }
    #[inline(always)]
    fn attenuation(&self, index: usize) -> &T {
        &self.attenuation[index]
    }
    #[inline(always)]
    fn intersection(&self, index: usize) -> &Intersection<T> {
        &self.intersections[index]
    }
    #[inline(always)]
    fn flag(&self, index: usize) -> Option<bool> {
        Some(self.flags[index])
    }
    fn bytes(&self) -> usize {
        let vectors = size_of_val(&self.direct[..]) * 3 + size_of_val(&self.intersections[..]);
        vectors + size_of_val(&self.sums[..]) + size_of_val(&self.n[..]) * 2 + self.flags.len()
    }
}
