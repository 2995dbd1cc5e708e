//! Memory of making spheres of many particles, counted.

use figure::stage::{Stage, origin, set};
use figure::{Recipe, balls};
use importers::{Format, Particles};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Particles: enough that what does not grow with them is nothing.
const COUNT: usize = 300_000;
/// Bytes per particle at the peak, with the particles themselves (25): 44 for the sphere and 20 for the ball that it is made
/// of, or what a style takes.
const MOST: usize = 80;
/// The same where spheres are of glass, whose overlaps are searched by copies of 24 bytes and a list that grows by doubling.
const MOST_OF_GLASS: usize = 90;

#[test]
fn a_particle_takes_few_bytes_until_it_is_a_sphere() {
    for (style, most) in [
        ("", MOST),
        ("radius=touch", MOST),
        ("material=glass, radius=0.4", MOST_OF_GLASS),
        ("color=x, map=plasma", MOST),
    ] {
        let mut particles = Particles::new(Format::Xyz);
        let place = |i: usize| [i % 67, i / 67 % 67, i / 67 / 67].map(|c| c as f64);
        particles.positions = (0..COUNT).map(place).collect();
        particles.elements = Some((0..COUNT).map(|i| [1, 6, 8][i % 3]).collect());
        let mut recipe = Recipe { origin: origin(&particles), ..Recipe::default() };
        if !style.is_empty() {
            recipe.style.push(figure::Rule::parse(style).unwrap());
        }
        MEMORY.reset_peak_usage();
        let made = balls(particles, &recipe).unwrap();
        set(&made.spheres, &made.materials, false, &Stage::default()).unwrap();
        let bytes = MEMORY.peak_usage();
        assert_eq!(made.spheres.len(), COUNT);
        assert!(bytes < most * COUNT, "{style}: {} bytes per particle", bytes / COUNT);
    }
}
