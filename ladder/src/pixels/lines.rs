//! Stages 5 and 6: all data that the photon pass reads of a visible point is in one line of 16 or of 8 words, and the
//! data that it writes is together as well. The lines of all lanes become vectors by transposes of 8x8 words.

use super::columns::{Column, Film, Held16, IN_SHELL, sphere_word};
use super::layout::{PixelState, Pixels, Seen, Site, from_the_front, is_not_zero};
use crate::flux::{IntegerSums, Photon};
use crate::tables::{Tables, fetch_pairs};
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES, Row};

/// Rows that are aligned to cache lines of 64 bytes.
struct CacheLines {
    rows: Vec<Row>,
    /// Rows before the first whole cache line.
    skipped: usize,
}

impl CacheLines {
    fn new(rows: usize) -> Self {
        let rows = vec![Row::default(); rows + 1];
        let skipped = rows.as_ptr().align_offset(64);
        Self { rows, skipped }
    }
    #[inline(always)]
    fn get(&self) -> &[Row] {
        &self.rows[self.skipped..]
    }
    #[inline(always)]
    fn get_mut(&mut self) -> &mut [Row] {
        &mut self.rows[self.skipped..]
    }
    fn bytes(&self) -> usize {
        size_of_val(&self.rows[..])
    }
}

/// The content of a line.
pub(crate) trait Line: 'static {
    /// The data read of candidates.
    type Held<V: Vector>: Copy;
    fn new(count: usize) -> Self;
    fn write<V: Vector>(&mut self, at: usize, seen: &Seen<V>, radius_squared: F<V>);
    /// Points and spheres of the pixels from `at` on.
    fn site<V: Vector>(&self, at: usize) -> (V, U<V>);
    fn fetch<V: Vector>(&self, ids: U<V>) -> Self::Held<V>;
    fn is_set<V: Vector>(held: &Self::Held<V>) -> M<V>;
    fn reach<V: Vector>(held: &Self::Held<V>) -> (V, F<V>);
    fn normal<V: Vector>(held: &Self::Held<V>) -> V;
    fn is_seen<V: Vector>(held: &Self::Held<V>) -> M<V>;
    fn is_in_shell<V: Vector>(&self, held: &Self::Held<V>, sphere: u32) -> M<V>;
    fn colour<V: Vector>(tables: &Tables, held: &Self::Held<V>) -> V;
    fn bytes(&self) -> usize;
}

/// Stage 5: the 16 words that stage 4 gathers, in one cache line. The sphere is rarely needed, so it is stored
/// elsewhere.
pub(crate) struct Line16 {
    lines: CacheLines,
    sphere: Column,
}

/// Consecutive numbers from `first` on, one per lane.
#[inline(always)]
fn consecutive(first: usize) -> [u32; MOST_LANES] {
    let mut numbers = [0; MOST_LANES];
    for (lane, number) in numbers.iter_mut().enumerate() {
        *number = (first + lane) as u32;
    }
    numbers
}

impl Line for Line16 {
    type Held<V: Vector> = Held16<V>;
    fn new(count: usize) -> Self {
        let lines = CacheLines::new(2 * count.next_multiple_of(MOST_LANES));
        Self { lines, sphere: Column::new(count, 0.0) }
    }
    #[inline(always)]
    fn write<V: Vector>(&mut self, at: usize, seen: &Seen<V>, radius_squared: F<V>) {
        let ([ax, ay, az], [px, py, pz], [nx, ny, nz]) =
            (seen.attenuation.xyz(), seen.point.xyz(), seen.normal.xyz());
        let ([ix, iy, iz], [r, g, b]) = (from_the_front(seen).xyz(), seen.colour.xyz());
        let (mut first, mut second) = ([Row::default(); MOST_LANES], [Row::default(); MOST_LANES]);
        V::L::transpose([ax, ay, az, radius_squared, px, py, pz, nx], &mut first);
        V::L::transpose([ny, nz, ix, iy, iz, r, g, b], &mut second);
        let lines = &mut self.lines.get_mut()[2 * at..2 * (at + V::L::N)];
        for lane in 0..V::L::N {
            lines[2 * lane] = first[lane];
            lines[2 * lane + 1] = second[lane];
        }
        self.sphere.store::<V::L>(at, V::L::from_bits(sphere_word(seen)));
    }
    #[inline(always)]
    fn site<V: Vector>(&self, at: usize) -> (V, U<V>) {
        let [[_, _, _, _, px, py, pz, _], _] = fetch_pairs::<V::L>(self.lines.get(), &consecutive(at));
        (V::new(px, py, pz), V::L::bits(self.sphere.load::<V::L>(at)))
    }
    #[inline(always)]
    fn fetch<V: Vector>(&self, ids: U<V>) -> Held16<V> {
        let mut numbers = [0; MOST_LANES];
        V::L::store_u(ids, &mut numbers);
        let [[ax, ay, az, radius_squared, px, py, pz, nx], [ny, nz, ix, iy, iz, r, g, b]] =
            fetch_pairs::<V::L>(self.lines.get(), &numbers);
        Held16 {
            ids,
            attenuation: V::new(ax, ay, az),
            radius_squared,
            point: V::new(px, py, pz),
            normal: V::new(nx, ny, nz),
            incident: V::new(ix, iy, iz),
            colour: V::new(r, g, b),
        }
    }
    #[inline(always)]
    fn is_set<V: Vector>(held: &Held16<V>) -> M<V> {
        held.is_set()
    }
    #[inline(always)]
    fn reach<V: Vector>(held: &Held16<V>) -> (V, F<V>) {
        (held.point, held.radius_squared)
    }
    #[inline(always)]
    fn normal<V: Vector>(held: &Held16<V>) -> V {
        held.normal
    }
    #[inline(always)]
    fn is_seen<V: Vector>(held: &Held16<V>) -> M<V> {
        held.is_seen()
    }
    #[inline(always)]
    fn is_in_shell<V: Vector>(&self, held: &Held16<V>, sphere: u32) -> M<V> {
        V::L::eq(V::L::bits(self.sphere.gather::<V::L>(held.ids)), V::L::u(sphere | IN_SHELL))
    }
    #[inline(always)]
    fn colour<V: Vector>(_: &Tables, held: &Held16<V>) -> V {
        held.colour
    }
    fn bytes(&self) -> usize {
        self.lines.bytes() + self.sphere.bytes()
    }
}

/// Stage 6: eight words. Only visible points seen from the side of their normal are entered in the index, so neither
/// throughput nor incident direction is needed. The colour is looked up by the sphere. Sphere numbers never use the top
/// bit, so it serves as a flag.
pub(crate) struct Line8(CacheLines);

/// The eight words of candidates.
#[derive(Clone, Copy)]
pub(crate) struct Held8<V: Vector> {
    point: V,
    radius_squared: F<V>,
    normal: V,
    sphere: U<V>,
}

impl<V: Vector> Held8<V> {
    #[inline(always)]
    fn of([px, py, pz, radius_squared, nx, ny, nz, sphere]: [F<V>; 8]) -> Self {
        let sphere = V::L::bits(sphere);
        Self { point: V::new(px, py, pz), radius_squared, normal: V::new(nx, ny, nz), sphere }
    }
}

impl Line for Line8 {
    type Held<V: Vector> = Held8<V>;
    fn new(count: usize) -> Self {
        Self(CacheLines::new(count.next_multiple_of(MOST_LANES)))
    }
    #[inline(always)]
    fn write<V: Vector>(&mut self, at: usize, seen: &Seen<V>, radius_squared: F<V>) {
        let ([px, py, pz], [nx, ny, nz]) = (seen.point.xyz(), seen.normal.xyz());
        let sphere = V::L::from_bits(sphere_word(seen));
        V::L::transpose([px, py, pz, radius_squared, nx, ny, nz, sphere], &mut self.0.get_mut()[at..]);
    }
    #[inline(always)]
    fn site<V: Vector>(&self, at: usize) -> (V, U<V>) {
        let held = Held8::<V>::of(V::L::load_rows(&self.0.get()[at..]));
        (held.point, held.sphere)
    }
    #[inline(always)]
    fn fetch<V: Vector>(&self, ids: U<V>) -> Held8<V> {
        let mut numbers = [0; MOST_LANES];
        V::L::store_u(ids, &mut numbers);
        Held8::of(V::L::gather_rows(self.0.get(), &numbers))
    }
    #[inline(always)]
    fn is_set<V: Vector>(_: &Held8<V>) -> M<V> {
        V::L::first(V::L::N)
    }
    #[inline(always)]
    fn reach<V: Vector>(held: &Held8<V>) -> (V, F<V>) {
        (held.point, held.radius_squared)
    }
    #[inline(always)]
    fn normal<V: Vector>(held: &Held8<V>) -> V {
        held.normal
    }
    #[inline(always)]
    fn is_seen<V: Vector>(_: &Held8<V>) -> M<V> {
        V::L::first(V::L::N)
    }
    #[inline(always)]
    fn is_in_shell<V: Vector>(&self, held: &Held8<V>, sphere: u32) -> M<V> {
        V::L::eq(held.sphere, V::L::u(sphere | IN_SHELL))
    }
    #[inline(always)]
    fn colour<V: Vector>(tables: &Tables, held: &Held8<V>) -> V {
        let [r, g, b] = tables.albedos::<V::L>(held.sphere & V::L::u(!IN_SHELL));
        V::new(r, g, b)
    }
    fn bytes(&self) -> usize {
        self.0.bytes()
    }
}

/// The layout: columns for data that is read in order, lines for data that is read at random.
pub(crate) struct Lines<T> {
    film: Film,
    candidates: T,
    sums: Vec<[f32; 4]>,
}

impl<T: Line> Pixels for Lines<T> {
    type Held<V: Vector> = T::Held<V>;

    fn new(count: usize, initial_radius: f32, integer_sums: IntegerSums) -> Self {
        let sums = vec![[0.0; 4]; count.next_multiple_of(MOST_LANES)];
        Self { film: Film::new(count, initial_radius, integer_sums), candidates: T::new(count), sums }
    }

    #[inline(always)]
    fn sums(&self) -> &IntegerSums {
        &self.film.integer_sums
    }

    #[inline(always)]
    fn see<V: Vector>(&mut self, at: usize, seen: &Seen<V>) {
        self.film.see::<V>(at, seen);
        self.candidates.write(at, seen, self.film.radius_squared.load::<V::L>(at));
    }

    #[inline(always)]
    fn site<V: Vector>(&self, at: usize) -> Site<V> {
        let (point, sphere) = self.candidates.site::<V>(at);
        Site {
            is_set: is_not_zero(self.film.attenuation.load::<V>(at)),
            point,
            radius_squared: self.film.radius_squared.load::<V::L>(at),
            sphere: sphere & V::L::u(!IN_SHELL),
        }
    }

    #[inline(always)]
    fn fetch<V: Vector>(&self, ids: U<V>) -> T::Held<V> {
        self.candidates.fetch(ids)
    }
    #[inline(always)]
    fn is_set<V: Vector>(&self, held: &T::Held<V>) -> M<V> {
        T::is_set(held)
    }
    #[inline(always)]
    fn reach<V: Vector>(&self, held: &T::Held<V>) -> (V, F<V>) {
        T::reach(held)
    }
    #[inline(always)]
    fn normal<V: Vector>(&self, held: &T::Held<V>) -> V {
        T::normal(held)
    }
    #[inline(always)]
    fn is_seen<V: Vector>(&self, held: &T::Held<V>, _: V) -> M<V> {
        T::is_seen(held)
    }
    #[inline(always)]
    fn is_in_shell<V: Vector>(&self, held: &T::Held<V>, sphere: u32) -> M<V> {
        self.candidates.is_in_shell(held, sphere)
    }
    #[inline(always)]
    fn colour<V: Vector>(&self, tables: &Tables, held: &T::Held<V>) -> V {
        T::colour(tables, held)
    }

    #[inline(always)]
    fn add<V: Vector>(&mut self, bits: u32, ids: &[u32; MOST_LANES], photon: &Photon, contribution: V) {
        if self.film.integer_sums.add(bits, ids, photon) {
            return;
        }
        let ([r, g, b], one, zero) = (contribution.xyz(), V::L::f(1.0), V::L::f(0.0));
        let mut rows = [Row::default(); MOST_LANES];
        V::L::transpose([r, g, b, one, zero, zero, zero, zero], &mut rows);
        for lane in 0..V::L::N {
            if (bits >> lane) & 1 == 1 {
                let sums = &mut self.sums[ids[lane] as usize];
                for channel in 0..4 {
                    sums[channel] += rows[lane].0[channel];
                }
            }
        }
    }

    #[inline(always)]
    fn consolidate<V: Vector>(&mut self, at: usize, nominal: f32) {
        let mut sums = [[0.0; 4]; MOST_LANES];
        for lane in 0..V::L::N {
            sums[lane] = std::mem::take(&mut self.sums[at + lane]);
        }
        self.film.consolidate::<V>(at, &mut sums, nominal);
    }

    fn state(&self, index: usize) -> PixelState {
        self.film.state(index)
    }

    fn bytes(&self) -> usize {
        self.film.bytes() + self.candidates.bytes() + size_of_val(&self.sums[..])
    }
}
