//! Stage 4: structure of arrays, with a separate array for every word of a visible point.

use super::gathered::Gathered;
use super::layout::{PixelState, Pixels, Seen, Site, from_the_front, is_not_zero};
use crate::flux::{IntegerSums, Photon};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// One word per pixel. The length is a power of two, as gathers require.
pub(super) struct Column(Vec<u32>);

/// Three words per pixel.
pub(super) struct Column3([Column; 3]);

impl Column {
    pub(super) fn new(count: usize, value: f32) -> Self {
        Self(vec![value.to_bits(); count.next_power_of_two().max(MOST_LANES)])
    }
    #[inline(always)]
    pub(super) fn load<L: Lanes>(&self, at: usize) -> L::F {
        L::from_bits(L::load_u(&self.0[at..]))
    }
    #[inline(always)]
    pub(super) fn store<L: Lanes>(&mut self, at: usize, v: L::F) {
        L::store_u(L::bits(v), &mut self.0[at..]);
    }
    #[inline(always)]
    pub(super) fn gather<L: Lanes>(&self, ids: L::U) -> L::F {
        L::from_bits(L::gather_u(&self.0, ids))
    }
    pub(super) fn get(&self, index: usize) -> f32 {
        f32::from_bits(self.0[index])
    }
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

impl Column3 {
    pub(super) fn new(count: usize) -> Self {
        Self(std::array::from_fn(|_| Column::new(count, 0.0)))
    }
    #[inline(always)]
    pub(super) fn load<V: Vector>(&self, at: usize) -> V {
        let [x, y, z] = &self.0;
        V::new(x.load::<V::L>(at), y.load::<V::L>(at), z.load::<V::L>(at))
    }
    #[inline(always)]
    pub(super) fn store<V: Vector>(&mut self, at: usize, v: V) {
        let ([x, y, z], [vx, vy, vz]) = (&mut self.0, v.xyz());
        x.store::<V::L>(at, vx);
        y.store::<V::L>(at, vy);
        z.store::<V::L>(at, vz);
    }
    #[inline(always)]
    fn gather<V: Vector>(&self, ids: U<V>) -> V {
        let [x, y, z] = &self.0;
        V::new(x.gather::<V::L>(ids), y.gather::<V::L>(ids), z.gather::<V::L>(ids))
    }
    pub(super) fn get(&self, index: usize) -> Vec3 {
        let [x, y, z] = &self.0;
        Vec3::new(x.get(index), y.get(index), z.get(index))
    }
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(Column::bytes).sum()
    }
}

/// The state that pixels keep over iterations, and the throughput of their paths, in columns.
pub(super) struct Film {
    pub(super) direct: Column3,
    pub(super) tau: Column3,
    pub(super) n: Column,
    pub(super) radius_squared: Column,
    pub(super) attenuation: Column3,
    pub(super) integer_sums: IntegerSums,
}

impl Film {
    pub(super) fn new(count: usize, initial_radius: f32, integer_sums: IntegerSums) -> Self {
        Self {
            direct: Column3::new(count),
            tau: Column3::new(count),
            n: Column::new(count, 0.0),
            radius_squared: Column::new(count, initial_radius * initial_radius),
            attenuation: Column3::new(count),
            integer_sums,
        }
    }
    /// Adds direct light, and stores the factor by which flux will be weighted.
    #[inline(always)]
    pub(super) fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>) {
        self.direct.store(at, self.direct.load::<V>(at) + seen.direct);
        let weight = self.integer_sums.weight(seen.attenuation, seen.colour);
        self.attenuation.store(at, weight);
    }
    #[inline(always)]
    pub(super) fn consolidate<V: Vector>(
        &mut self,
        at: usize,
        sums: &mut [[f32; 4]; MOST_LANES],
        nominal: f32,
    ) {
        for lane in 0..V::L::N {
            if let Some(gathered) = self.integer_sums.take(at + lane, nominal) {
                sums[lane] = gathered;
            }
        }
        let before = Gathered::<V> {
            tau: self.tau.load(at),
            n: self.n.load::<V::L>(at),
            radius_squared: self.radius_squared.load::<V::L>(at),
        };
        let after = before.consolidated(self.attenuation.load(at), sums);
        self.tau.store(at, after.tau);
        self.n.store::<V::L>(at, after.n);
        self.radius_squared.store::<V::L>(at, after.radius_squared);
    }
    pub(super) fn state(&self, index: usize) -> PixelState {
        PixelState {
            direct: self.direct.get(index),
            tau: self.tau.get(index),
            n: self.n.get(index),
            radius_squared: self.radius_squared.get(index),
        }
    }
    pub(super) fn bytes(&self) -> usize {
        3 * self.direct.bytes() + 2 * self.n.bytes() + self.integer_sums.bytes()
    }
}

/// The layout. Each candidate takes a gather of 16 words from 16 arrays.
pub(crate) struct Columns {
    film: Film,
    point: Column3,
    normal: Column3,
    incident: Column3,
    colour: Column3,
    /// The sphere; its top bit is set if the point lies inside of a shell.
    sphere: Column,
    /// Three channels, and the number of photons.
    sums: [Vec<f32>; 4],
}

/// The top bit of the sphere's word, which says that the point lies inside of a shell.
pub(super) const IN_SHELL: u32 = 1 << 31;

/// The word of the sphere, with the flag.
#[inline(always)]
pub(super) fn sphere_word<V: Vector>(seen: &Seen<V>) -> U<V> {
    V::L::select_u(seen.in_shell, seen.sphere | V::L::u(IN_SHELL), seen.sphere)
}

/// The 16 words of candidates, one candidate per lane, and their indices.
#[derive(Clone, Copy)]
pub(crate) struct Held16<V: Vector> {
    pub(super) ids: U<V>,
    pub(super) attenuation: V,
    pub(super) radius_squared: F<V>,
    pub(super) point: V,
    pub(super) normal: V,
    pub(super) incident: V,
    pub(super) colour: V,
}

impl<V: Vector> Held16<V> {
    #[inline(always)]
    pub(super) fn is_set(&self) -> M<V> {
        is_not_zero(self.attenuation)
    }
    #[inline(always)]
    pub(super) fn is_seen(&self) -> M<V> {
        V::L::lt(self.incident.dot(self.normal), V::L::f(0.0))
    }
}

impl Pixels for Columns {
    type Held<V: Vector> = Held16<V>;

    fn new(count: usize, initial_radius: f32, sums: IntegerSums) -> Self {
        let padded = count.next_multiple_of(MOST_LANES);
        Self {
            film: Film::new(count, initial_radius, sums),
            point: Column3::new(count),
            normal: Column3::new(count),
            incident: Column3::new(count),
            colour: Column3::new(count),
            sphere: Column::new(count, 0.0),
            sums: std::array::from_fn(|_| vec![0.0; padded]),
        }
    }

    #[inline(always)]
    fn sums(&self) -> &IntegerSums {
        &self.film.integer_sums
    }

    #[inline(always)]
    fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>) {
        self.film.see::<V>(at, seen);
        self.point.store(at, seen.point);
        self.normal.store(at, seen.normal);
        self.incident.store(at, from_the_front(seen));
        self.colour.store(at, seen.colour);
        self.sphere.store::<V::L>(at, V::L::from_bits(sphere_word(seen)));
    }

    #[inline(always)]
    fn site<V: Vector>(&self, at: usize) -> Site<V> {
        let sphere = V::L::bits(self.sphere.load::<V::L>(at));
        Site {
            is_set: is_not_zero(self.film.attenuation.load::<V>(at)),
            point: self.point.load(at),
            radius_squared: self.film.radius_squared.load::<V::L>(at),
            sphere: sphere & V::L::u(!IN_SHELL),
        }
    }

    #[inline(always)]
    fn fetch<V: Vector>(&self, ids: U<V>) -> Held16<V> {
        Held16 {
            ids,
            attenuation: self.film.attenuation.gather(ids),
            radius_squared: self.film.radius_squared.gather::<V::L>(ids),
            point: self.point.gather(ids),
            normal: self.normal.gather(ids),
            incident: self.incident.gather(ids),
            colour: self.colour.gather(ids),
        }
    }
    #[inline(always)]
    fn is_set<V: Vector>(&self, held: &Held16<V>) -> M<V> {
        held.is_set()
    }
    #[inline(always)]
    fn reach<V: Vector>(&self, held: &Held16<V>) -> (V, F<V>) {
        (held.point, held.radius_squared)
    }
    #[inline(always)]
    fn normal<V: Vector>(&self, held: &Held16<V>) -> V {
        held.normal
    }
    #[inline(always)]
    fn is_seen<V: Vector>(&self, held: &Held16<V>, _: V) -> M<V> {
        held.is_seen()
    }
    #[inline(always)]
    fn is_in_shell<V: Vector>(&self, held: &Held16<V>, sphere: u32) -> M<V> {
        V::L::eq(V::L::bits(self.sphere.gather::<V::L>(held.ids)), V::L::u(sphere | IN_SHELL))
    }
    #[inline(always)]
    fn colour<V: Vector>(&self, _: &Tables, held: &Held16<V>) -> V {
        held.colour
    }

    #[inline(always)]
    fn add<V: Vector>(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon, contribution: V) {
        if self.film.integer_sums.add(bits, ids, photon) {
            return;
        }
        let ([r, g, b], mut channels) = (contribution.xyz(), [[0.0; MOST_LANES]; 4]);
        V::L::store(r, &mut channels[0]);
        V::L::store(g, &mut channels[1]);
        V::L::store(b, &mut channels[2]);
        V::L::store(V::L::f(1.0), &mut channels[3]);
        for lane in 0..V::L::N {
            if (bits >> lane) & 1 == 1 {
                for (sums, channel) in self.sums.iter_mut().zip(&channels) {
                    sums[ids[lane] as usize] += channel[lane];
                }
            }
        }
    }

    #[inline(always)]
    fn consolidate<V: Vector>(&mut self, at: usize, nominal: f32) {
        let mut sums = [[0.0; 4]; MOST_LANES];
        for (number, channel) in self.sums.iter_mut().enumerate() {
            for lane in 0..V::L::N {
                sums[lane][number] = std::mem::take(&mut channel[at + lane]);
            }
        }
        self.film.consolidate::<V>(at, &mut sums, nominal);
    }

    fn state(&self, index: usize) -> PixelState {
        self.film.state(index)
    }

    fn bytes(&self) -> usize {
        let sums: usize = self.sums.iter().map(|channel| size_of_val(&channel[..])).sum();
        self.film.bytes() + 4 * self.point.bytes() + self.sphere.bytes() + sums
    }
}
