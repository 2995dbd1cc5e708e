//! Pictures as they are sent to the browser: a header and a word of RGB9E5 per pixel.
//!
//! All numbers are little-endian.
//!
//! | bytes | header |
//! |---|---|
//! | 4 | magic number, "SPV1" |
//! | 4 | version of the scene, camera and settings that it shows; never falls |
//! | 4 | iterations |
//! | 4, 4 | width and height of what follows, in pixels |
//! | 4, 4 | width and height of the image that it stands for; more while the camera moves |
//! | 4 | number of the layer |
//! | 4 | `f32`: what the values are to be multiplied by, a power of two |
//! | 4 | flags: 1, of reduced size; 2, one value per pixel, such as a radius, not a colour |
//! | 4 | number of the picture |
//! | 4 | 0 |

use crate::rgb9e5;
use axum::body::Bytes;
use rayon::prelude::*;
use scene::{Film, Plane};
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes of the header.
pub const HEADER: usize = 48;
const MAGIC: [u8; 4] = *b"SPV1";
const REDUCED: u32 = 1;
const PLANE: u32 = 2;
/// The greatest value of a picture is stored below 2 to this power, so that dark places keep their digits.
const TOP: i32 = 15;
/// Pixels of a work item.
const AT_ONCE: usize = 1 << 13;

/// A picture in all layers that somebody looks at.
#[derive(Debug)]
pub(crate) struct Picture {
    /// Each with its number.
    layers: Vec<(u32, Bytes)>,
    /// Whether a page has drawn it.
    is_drawn: AtomicBool,
}

/// What the header says, but for what the pixels tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Caption {
    /// The version of what is shown.
    pub(crate) version: u32,
    /// Iterations.
    pub(crate) iterations: u32,
    /// Width and height of the whole image, in pixels.
    pub(crate) whole: [u32; 2],
    /// The number of the picture, different from that of the one before.
    pub(crate) number: u32,
}

impl Picture {
    /// A picture of layers, each with its number.
    pub(crate) fn new(layers: Vec<(u32, Bytes)>) -> Self {
        Self { layers, is_drawn: AtomicBool::new(false) }
    }

    /// Notes that a page has drawn it; returns whether that was the first.
    pub(crate) fn note_drawn(&self) -> bool {
        !self.is_drawn.swap(true, Ordering::Relaxed)
    }

    /// The bytes of layer `number`, if it is there.
    pub(crate) fn layer(&self, number: u32) -> Option<Bytes> {
        self.layers.iter().find(|(there, _)| *there == number).map(|(_, bytes)| bytes.clone())
    }

    /// Whether it has layer `number`.
    pub(crate) fn has(&self, number: u32) -> bool {
        self.layers.iter().any(|(there, _)| *there == number)
    }
}

/// The bytes of a layer in colour. Works on the current thread pool.
pub(crate) fn of_film(film: &Film, layer: u32, caption: Caption) -> Bytes {
    let value = |at: usize| film.pixels[at].to_array();
    encode([film.width, film.height], value, layer, caption, 0)
}

/// The bytes of a layer of one value per pixel. Works on the current thread pool.
pub(crate) fn of_plane(plane: &Plane, layer: u32, caption: Caption) -> Bytes {
    let value = |at: usize| [plane.values[at]; 3];
    encode([plane.width, plane.height], value, layer, caption, PLANE)
}

fn encode(
    size: [u32; 2],
    value: impl Fn(usize) -> [f32; 3] + Sync,
    layer: u32,
    caption: Caption,
    flags: u32,
) -> Bytes {
    let Caption { version, iterations, whole, number } = caption;
    let pixels = size[0] as usize * size[1] as usize;
    let greater = |a: f32, b: f32| if b.is_finite() { a.max(b) } else { a };
    let greatest = |at| value(at).into_iter().fold(0.0, greater);
    let most = (0..pixels).into_par_iter().with_min_len(AT_ONCE).map(greatest).reduce(|| 0.0, f32::max);
    let up = if most > 0.0 { TOP - 1 - ((most.to_bits() >> 23) as i32 - 127) } else { 0 };
    // The factor is a normal number, and so is its inverse.
    let up = up.clamp(-120, 120);
    let (scale, unscale) = (rgb9e5::power(up), rgb9e5::power(-up));
    let flags = flags | if size == whole { 0 } else { REDUCED };
    let mut bytes = Vec::with_capacity(HEADER + 4 * pixels);
    bytes.extend(MAGIC);
    let words = [version, iterations, size[0], size[1], whole[0], whole[1], layer];
    bytes.extend(words.into_iter().flat_map(u32::to_le_bytes));
    bytes.extend(unscale.to_le_bytes());
    bytes.extend([flags, number, 0].into_iter().flat_map(u32::to_le_bytes));
    bytes.resize(HEADER + 4 * pixels, 0);
    let fill = |(chunk, words): (usize, &mut [u8])| {
        for (i, word) in words.as_chunks_mut().0.iter_mut().enumerate() {
            *word = rgb9e5::encode(value(chunk * AT_ONCE + i).map(|v| v * scale)).to_le_bytes();
        }
    };
    bytes[HEADER..].par_chunks_mut(4 * AT_ONCE).enumerate().for_each(fill);
    bytes.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Rgb;

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[4 * at..][..4].try_into().unwrap())
    }

    #[test]
    fn the_header_is_as_documented() {
        let film = Film { width: 2, height: 1, pixels: vec![Rgb::new(3.0, 2.0, 1.0), Rgb::ZERO] };
        let caption = Caption { version: 7, iterations: 5, whole: [8, 4], number: 9 };
        let bytes = of_film(&film, 1, caption);
        assert_eq!(bytes.len(), HEADER + 8);
        assert_eq!(&bytes[..4], b"SPV1");
        let header: Vec<u32> = (1..8).map(|at| word(&bytes, at)).collect();
        assert_eq!(header, [7, 5, 2, 1, 8, 4, 1]);
        assert_eq!((word(&bytes, 9), word(&bytes, 10), word(&bytes, 11)), (REDUCED, 9, 0));
        let scale = f32::from_bits(word(&bytes, 8));
        assert_eq!(rgb9e5::decode(word(&bytes, 12)).map(|v| v * scale), [3.0, 2.0, 1.0]);
    }

    /// Of more work items than one, the last of which is not full.
    #[test]
    fn every_pixel_is_in_its_place() {
        let (width, height) = (200, 2 * AT_ONCE as u32 / 200 + 3);
        // Neighbours differ by more than a code does, and so do pixels a work item apart.
        let of = |at: u32| 1.0 + (at % 7) as f32 / 7.0;
        let pixels = (0..width * height).map(|at| Rgb::new(of(at), 1.0, 0.5)).collect();
        let film = Film { width, height, pixels };
        let bytes = of_film(&film, 0, Caption::default());
        let scale = f32::from_bits(word(&bytes, 8));
        for at in 0..width * height {
            let [red, ..] = rgb9e5::decode(word(&bytes, HEADER / 4 + at as usize));
            // Half a step of a mantissa of at least 256.
            assert!((red * scale / of(at) - 1.0).abs() <= 1.0 / 512.0, "pixel {at}: {}", red * scale);
        }
    }

    /// Also numbers far beyond what RGB9E5 holds.
    #[test]
    fn values_of_any_size_keep_their_digits() {
        for value in [1e-30_f32, 1e-7, 1.0, 3e4, 1e6, 1e30] {
            let plane = Plane { width: 1, height: 1, values: vec![value] };
            let bytes = of_plane(&plane, 2, Caption { whole: [1, 1], ..Caption::default() });
            let read = rgb9e5::decode(word(&bytes, 12))[0] * f32::from_bits(word(&bytes, 8));
            // Half a step of a mantissa of at least 256.
            assert!((read / value - 1.0).abs() <= 1.0 / 512.0, "{value}: {read}");
            assert_eq!(word(&bytes, 9), PLANE);
        }
    }

    /// They would take all digits from the others.
    #[test]
    fn values_that_are_not_finite_do_not_set_the_scale() {
        let value = 1e-7;
        for odd in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            // In each channel, before the others and after them.
            for at in [0, 1, 2, 6, 7, 8] {
                let values: [f32; 9] = std::array::from_fn(|i| if i == at { odd } else { value });
                let pixels = values.as_chunks().0.iter().map(|pixel: &[f32; 3]| Rgb::from(*pixel)).collect();
                let film = Film { width: 3, height: 1, pixels };
                let bytes = of_film(&film, 0, Caption::default());
                let scale = f32::from_bits(word(&bytes, 8));
                for pixel in (0..3).filter(|pixel| *pixel != at / 3) {
                    for read in rgb9e5::decode(word(&bytes, 12 + pixel)) {
                        // Half a step of a mantissa of at least 256.
                        assert!((read * scale / value - 1.0).abs() <= 1.0 / 512.0, "{odd} at {at}: {read}");
                    }
                }
                // What is infinite is shown brighter than all others, and the rest as black.
                let read = rgb9e5::decode(word(&bytes, 12 + at / 3))[at % 3] * scale;
                assert!(if odd > 0.0 { read > value } else { read == 0.0 }, "{odd} at {at}: {read}");
            }
        }
    }
}
