//! Comparing images takes memory for their width, not for their height.
//!
//! This is a separate binary with a single test because it measures the memory of the whole process.

use compare::{DifferenceMap, Metrics};
use peak_alloc::PeakAlloc;
use scene::{Rgb, RowReader};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const WIDTH: u32 = 4096;
/// Pixels of 12 bytes of the taller image, both times: what holding the images would take.
const WHOLE: usize = 2 * 12 * 4096 * 1024;
/// Threads may or may not work on rows at the same time.
const SLACK: f64 = 1.2;

/// An image that is computed row by row.
struct Rows {
    height: u32,
    next: u32,
    seed: u32,
}

impl RowReader for Rows {
    fn size(&self) -> [u32; 2] {
        [WIDTH, self.height]
    }

    fn read(&mut self, pixels: &mut [Rgb]) -> Result<(), String> {
        for row in pixels.chunks_exact_mut(WIDTH as usize) {
            for (x, pixel) in row.iter_mut().enumerate() {
                let noise = (x as u32 ^ self.next).wrapping_mul(0x9e37_79b9 + self.seed) >> 24;
                *pixel = Rgb::splat(noise as f32 / 255.0);
            }
            self.next += 1;
        }
        Ok(())
    }

    fn rewind(&mut self) -> Result<(), String> {
        self.next = 0;
        Ok(())
    }
}

/// Peak memory of `work` on two images of `height` rows.
fn peak(height: u32, work: impl FnOnce(&mut Rows, &mut Rows)) -> usize {
    let [mut a, mut b] = [1, 2].map(|seed| Rows { height, next: 0, seed });
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    work(&mut a, &mut b);
    MEMORY.peak_usage() - before
}

#[test]
fn memory_does_not_grow_with_the_rows() {
    let measure = |a: &mut Rows, b: &mut Rows| {
        let metrics = Metrics::of_rows(a, b, false, &mut |_, _| {}).unwrap();
        assert!(metrics.flip > 0.0 && metrics.ssim.all < 1.0);
    };
    let [small, large] = [512, 1024].map(|height| peak(height, measure));
    assert!(large as f64 <= SLACK * small as f64, "{large} bytes, where half the rows take {small}");
    let map = peak(1024, |a, b| {
        DifferenceMap::of_rows(a, b, &mut |_, _| {}).unwrap();
    });
    assert!(map < WHOLE / 2, "{map} bytes; the images have {WHOLE}");
}
