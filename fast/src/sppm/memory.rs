//! How much memory a render will take.

use crate::eye;
use crate::global::BYTES_OF_GLOBAL;
use crate::join::{BYTES_OF_BINS, Direction, MOST_BYTES_OF_SUMS, Record, table_size, with_margin};
use crate::parameters::Parameters;
use crate::pixels::{GROUP, GroupColumns, Pixel, PixelRow, slots};
use crate::prepared::bytes_of_spheres;
use scene::aim::survey;
use scene::clearance;
use scene::first_radii::{bytes_at_most as radii_bytes_at_most, pilot_settings};
use scene::{RadiusSchedule, Settings};

/// What a thread holds beside its deposits: batches of paths, and an occupancy map.
const BYTES_PER_THREAD: u64 = 3 << 19;
/// Deposits that a small render, of those that choose radii or settings, holds at a time.
pub const DEPOSITS_OF_PILOTS: u32 = 1 << 18;

/// See `Sppm::bytes_at_most`.
pub(super) fn bytes_at_most(
    settings: &Settings,
    spheres: usize,
    threads: usize,
    deposits_at_once: u32,
    parameters: &Parameters,
) -> u64 {
    let global = if settings.radius_schedule == RadiusSchedule::Global { BYTES_OF_GLOBAL } else { 0 };
    let per_group = size_of::<GroupColumns>() + MOST_BYTES_OF_SUMS;
    let per_slot = size_of::<Pixel>() + size_of::<PixelRow>() + per_group / GROUP + global;
    let pixels = slots(settings) as u64 * per_slot as u64;
    // A round may exceed its deposits by those of a work item.
    let bounces = u64::from(settings.max_depth - 1);
    let all = u64::from(settings.photons_per_iteration) * bounces;
    let round = u64::from(deposits_at_once) + u64::from(parameters.photons_per_job) * bounces;
    let each = (size_of::<Record>() + size_of::<Direction>()) as u64;
    // Once in the bins' chunks, and once sorted, if all are in the bins that are sorted at a time; and a number by which a
    // deposit is sorted.
    let deposits = with_margin(all.min(round)) * (2 * each + size_of::<u32>() as u64);
    let buckets = table_size(parameters.buckets(settings.photons_per_iteration)) as u64;
    // The survey comes before the first deposit.
    let survey = survey::bytes_at_most(settings.photons_per_iteration, settings.max_depth);
    pixels
        + deposits.max(survey)
        + 4 * buckets
        + buckets / 8
        + threads as u64 * (BYTES_PER_THREAD + BYTES_OF_BINS as u64)
        + bytes_of_spheres(spheres)
        + clearance::bytes_at_most(settings, spheres)
        + eye::bytes_at_most(settings)
        + pilots(settings, threads, parameters)
}

/// What choosing the first radii takes.
fn pilots(settings: &Settings, threads: usize, parameters: &Parameters) -> u64 {
    if settings.radius_pilots == 0 {
        return 0;
    }
    // The balls' tables are those of the render.
    let pilot = pilot_settings(settings);
    bytes_at_most(&pilot, 0, threads, DEPOSITS_OF_PILOTS, parameters) + radii_bytes_at_most(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::Paths;
    use crate::prepared::BYTES_PER_SPHERE;

    /// Every term is by itself: what one more of something takes does not depend on the rest.
    #[test]
    fn each_thing_takes_its_own_bytes() {
        let parameters = Parameters::default();
        let few = Settings { width: 64, height: 64, photons_per_iteration: 1 << 16, ..Settings::default() };
        let bytes = |settings: &Settings, spheres, threads, deposits| {
            bytes_at_most(settings, spheres, threads, deposits, &parameters)
        };
        let base = bytes(&few, 10, 2, 1 << 22);
        // Of a thread's, two batches of paths and the largest map alone.
        let map = Parameters::ALL.iter().find(|p| p.name == "occupancy_bits").unwrap().most as u64 / 8;
        assert!(BYTES_PER_THREAD > 2 * size_of::<Paths>() as u64 + map);
        // As ARCHITECTURE.md has it: 88 bytes, and 52 in several rounds.
        let wide = Settings { width: 128, ..few };
        assert_eq!(bytes(&wide, 10, 2, 1 << 22) - base, 64 * 64 * (88 + 52));
        // And 80 with global radii.
        let global = Settings { radius_schedule: RadiusSchedule::Global, ..few };
        assert_eq!(bytes(&global, 10, 2, 1 << 22) - base, 64 * 64 * 80);
        assert_eq!(bytes(&few, 11, 2, 1 << 22) - base, BYTES_PER_SPHERE);
        let limited = Settings { radius_clearance: 1.0, ..few };
        assert_eq!(bytes(&limited, 10, 2, 1 << 22) - base, clearance::bytes_at_most(&limited, 10));
        // A bit per pixel, and again.
        let several = Settings { glint_samples: 2, ..few };
        assert_eq!(bytes(&several, 10, 2, 1 << 22) - base, 64 * 64 / 4);
        assert_eq!(bytes(&few, 10, 3, 1 << 22) - base, BYTES_PER_THREAD + BYTES_OF_BINS as u64);
        // One bounce more: a deposit per photon and a sixteenth, of 48 bytes, twice, and of a number.
        let deep = Settings { max_depth: few.max_depth + 1, ..few };
        assert_eq!(bytes(&deep, 10, 2, 1 << 22) - base, (1 << 16) * 17 / 16 * 100);
        // No more deposits than a round and what is in work, however many photons there are: then buckets alone.
        let many = Settings { photons_per_iteration: 1 << 20, ..few };
        let more = Settings { photons_per_iteration: 1 << 21, ..few };
        let buckets = |photons| table_size(parameters.buckets(photons)) as u64;
        let added = buckets(1 << 21) - buckets(1 << 20);
        assert!(added > 0);
        assert_eq!(bytes(&more, 10, 2, 1 << 18) - bytes(&many, 10, 2, 1 << 18), 4 * added + added / 8);
        // Of deposits those of a round: what is held at once, and a job's.
        let bounces = u64::from(few.max_depth - 1);
        let in_work = u64::from(parameters.photons_per_job) * bounces;
        let round = with_margin((1 << 18) + in_work) * 100;
        let shallow = Settings { max_depth: 1, ..many };
        let none = bytes(&shallow, 10, 2, 1 << 18);
        let survey =
            |settings: &Settings| survey::bytes_at_most(settings.photons_per_iteration, settings.max_depth);
        assert_eq!(bytes(&many, 10, 2, 1 << 18) - none, round - survey(&shallow));
        // Of few deposits, the survey takes more than these.
        let [few, deep] = [2, 9].map(|max_depth| Settings { max_depth, photons_per_iteration: 1, ..few });
        assert_eq!(bytes(&deep, 10, 2, 1 << 22) - bytes(&few, 10, 2, 1 << 22), survey(&deep) - survey(&few));
    }
}
