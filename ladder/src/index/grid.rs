//! The hash grid: a visible point is entered in every cell that its search sphere touches, and a photon looks only into
//! the cell that it lies in. Cells are hashed to the bins of a table of fixed length.

use super::bins::Bins;
use super::lookup::{Index, WIDENED};
use super::tuning::Tuning;
use crate::one::One;
use crate::pixels::Pixels;
use crate::vector::{F, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// The largest cell number in either direction. Coordinates beyond it belong to the outermost cell.
const OUTERMOST: f32 = 1_073_741_824.0;

/// The grid, with bins of type `B`.
pub(crate) struct HashGrid<B> {
    inverse_cell_size: f32,
    cell_size: f32,
    /// The number of bins, which is a power of two, less one.
    mask: u32,
    bins: B,
}

/// The cell of a coordinate. It is monotone, so a box covers the cells between those of its corners. Points are both
/// entered and looked up by this function.
#[inline(always)]
fn cell<L: Lanes>(x: L::F, inverse_cell_size: f32) -> L::U {
    let scaled = x * L::f(inverse_cell_size);
    L::truncate(L::floor(L::max(L::min(scaled, L::f(OUTERMOST)), L::f(-OUTERMOST))))
}

/// The three cell numbers of each lane.
#[inline(always)]
fn cells<V: Vector>(point: V, inverse_cell_size: f32) -> [[u32; MOST_LANES]; 3] {
    let mut numbers = [[0; MOST_LANES]; 3];
    let [x, y, z]: [U<V>; 3] = {
        let [x, y, z] = point.xyz();
        [
            cell::<V::L>(x, inverse_cell_size),
            cell::<V::L>(y, inverse_cell_size),
            cell::<V::L>(z, inverse_cell_size),
        ]
    };
    V::L::store_u(x, &mut numbers[0]);
    V::L::store_u(y, &mut numbers[1]);
    V::L::store_u(z, &mut numbers[2]);
    numbers
}

impl<B: Bins> HashGrid<B> {
    #[inline(always)]
    fn bin_of(&self, x: u32, y: u32, z: u32) -> usize {
        let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
        (hash & self.mask) as usize
    }

    /// Enters point `id` in every cell from `low` to `high`.
    #[inline(always)]
    fn enter(&mut self, id: u32, sphere: u32, low: [u32; 3], high: [u32; 3]) {
        let [low, high] = [low.map(|c| c as i32), high.map(|c| c as i32)];
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let bin = self.bin_of(x as u32, y as u32, z as u32);
                    self.bins.insert(bin, id, sphere);
                }
            }
        }
    }
}

impl<B: Bins> Index for HashGrid<B> {
    type Cursor<'a>
        = B::Cursor<'a>
    where
        B: 'a;

    fn new(pixels: usize, tuning: &Tuning) -> Self {
        let bins = pixels.next_power_of_two();
        Self {
            inverse_cell_size: 0.0,
            cell_size: tuning.cell_size,
            mask: bins as u32 - 1,
            bins: B::new(bins, pixels, tuning),
        }
    }

    #[inline(always)]
    fn build<V: Vector, P: Pixels>(&mut self, pixels: &P, count: usize) {
        let largest = largest_radius::<V, P>(pixels, count);
        self.inverse_cell_size = 1.0 / (largest * self.cell_size).max(f32::MIN_POSITIVE);
        self.bins.clear();
        for at in (0..count).step_by(V::L::N) {
            let site = pixels.site::<V>(at);
            let mut rest = V::L::mask_bits(site.is_set & V::L::first(count - at));
            if rest == 0 {
                continue;
            }
            let reach: F<V> = V::L::sqrt(site.radius_squared) * V::L::f(WIDENED);
            let reach = V::new(reach, reach, reach);
            let low = cells(site.point - reach, self.inverse_cell_size);
            let high = cells(site.point + reach, self.inverse_cell_size);
            let mut spheres = [0; MOST_LANES];
            V::L::store_u(site.sphere, &mut spheres);
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let low = [low[0][lane], low[1][lane], low[2][lane]];
                let high = [high[0][lane], high[1][lane], high[2][lane]];
                self.enter((at + lane) as u32, spheres[lane], low, high);
            }
        }
    }

    #[inline(always)]
    fn open(&self, point: Vec3) -> B::Cursor<'_> {
        let [x, y, z] = [point.x, point.y, point.z].map(|c| cell::<One>(c, self.inverse_cell_size).0);
        self.bins.open(self.bin_of(x, y, z))
    }

    #[inline(always)]
    fn next<L: Lanes>(cursor: &mut B::Cursor<'_>) -> Option<(L::U, L::M)> {
        B::next::<L>(cursor)
    }

    #[inline(always)]
    fn shared_sphere(cursor: &B::Cursor<'_>) -> Option<u32> {
        B::shared_sphere(cursor)
    }

    fn bytes(&self) -> usize {
        self.bins.bytes()
    }
}

/// The largest search radius of all visible points.
#[inline(always)]
pub(super) fn largest_radius<V: Vector, P: Pixels>(pixels: &P, count: usize) -> f32 {
    let zero = V::L::f(0.0);
    let mut most: F<V> = zero;
    for at in (0..count).step_by(V::L::N) {
        let site = pixels.site::<V>(at);
        let is_set = site.is_set & V::L::first(count - at);
        most = V::L::max(V::L::select(is_set, site.radius_squared, zero), most);
    }
    let mut lanes = [0.0; MOST_LANES];
    V::L::store(most, &mut lanes);
    lanes.iter().fold(0.0, |a: f32, b| a.max(*b)).sqrt()
}
