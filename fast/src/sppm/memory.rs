//! How much memory a render takes, before it does.

use super::Sppm;
use crate::camera_pass::{PixelRows, slots};
use crate::join::GROUP;
use crate::join::cells::table_size;
use crate::join::deposits::{BYTES_OF_BINS, Direction, Record, with_margin};
use crate::join::gather::Sums;
use crate::lanes::Row;
use crate::parameters::Parameters;
use scene::Settings;

/// What a thread holds beside its deposits: batches of paths, and an occupancy map.
const BYTES_PER_THREAD: u64 = 3 << 19;
/// What a sphere takes in the scene and in the tables and trees made of it.
const BYTES_PER_SPHERE: u64 = 768;

impl Sppm<'_> {
    /// Bytes that a render of a scene of so many `spheres` takes at most, with so many `deposits_at_once`
    /// ([`Sppm::deposits_at_once`]): if every photon is deposited at every bounce where something can be seen.
    pub fn bytes_at_most(
        settings: &Settings,
        spheres: usize,
        threads: usize,
        deposits_at_once: u32,
        parameters: &Parameters,
    ) -> u64 {
        let per_slot = size_of::<Row>() + size_of::<PixelRows>() + size_of::<Sums>() / GROUP;
        let pixels = slots(settings) as u64 * per_slot as u64;
        // A round may go beyond what is held at once by another such, and by what was in work.
        let bounces = u64::from(settings.max_depth - 1);
        let all = u64::from(settings.photons_per_iteration) * bounces;
        let round = 2 * u64::from(deposits_at_once) + u64::from(parameters.photons_per_job) * bounces;
        let each = (size_of::<Record>() + size_of::<Direction>()) as u64;
        // Once in the bins' chunks, and once sorted.
        let deposits = 2 * with_margin(all.min(round)) * each;
        let buckets = table_size(parameters.buckets(settings.photons_per_iteration)) as u64;
        pixels
            + deposits
            + 4 * buckets
            + buckets / 8
            + threads as u64 * (BYTES_PER_THREAD + BYTES_OF_BINS as u64)
            + spheres as u64 * BYTES_PER_SPHERE
    }
}
