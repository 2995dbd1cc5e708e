//! Summarises a render as text for reviewers: checksums of all bits, and figures that show what has changed and where.

use crate::rows::Row;
use scene::{Engine, Film, Plane, Rgb, Stats};
use std::fmt::Write;

/// Columns and rows of tiles, whose mean radiance is listed.
const TILES: [usize; 2] = [4, 3];

/// The summary of a finished render.
pub(crate) fn summary(row: &Row, engine: &impl Engine) -> String {
    let (s, film) = (&row.settings, engine.develop());
    let mut text = format!(
        "{}: {} x {} pixels, {} iterations of {} photons, depth {}, radius {}, seed {}\n",
        row.scene.name,
        s.width,
        s.height,
        s.iterations,
        s.photons_per_iteration,
        s.max_depth,
        s.initial_radius,
        s.seed
    );
    let values: Vec<f32> = film.pixels.iter().flat_map(Rgb::to_array).collect();
    writeln!(text, "\nimage, crc32 {:08x}", digest(&values)).unwrap();
    tiles(&mut text, &film);
    let planes = [("radius", engine.radius()), ("count", engine.count())];
    for (name, plane) in planes.into_iter().filter_map(|(name, plane)| Some((name, plane?))) {
        write_plane(&mut text, name, &plane);
    }
    work(&mut text, engine.stats());
    text
}

fn digest(values: &[f32]) -> u32 {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_bits().to_le_bytes()).collect();
    crc32fast::hash(&bytes)
}

/// Lists the mean radiance of each tile in red, green and blue. A tile has at least one pixel.
fn tiles(text: &mut String, film: &Film) {
    let size = [film.width as usize, film.height as usize];
    let [columns, rows] = [0, 1].map(|i| TILES[i].min(size[i]));
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let span = |i: usize, n: usize, side: usize| i * side / n..(i + 1) * side / n;
        let (xs, ys) = (span(column, columns, size[0]), span(row, rows, size[1]));
        let count = (xs.len() * ys.len()) as f64;
        let places = ys.flat_map(|y| xs.clone().map(move |x| y * size[0] + x));
        let sum = places.map(|i| film.pixels[i].as_dvec3()).sum::<glam::DVec3>();
        let [r, g, b] = (sum / count).to_array();
        writeln!(text, "  tile {column} {row}  {r:>9.3e} {g:>9.3e} {b:>9.3e}").unwrap();
    }
}

fn write_plane(text: &mut String, name: &str, plane: &Plane) {
    let values = &plane.values;
    let least = values.iter().copied().fold(f32::INFINITY, f32::min);
    let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    writeln!(text, "\n{name}, crc32 {:08x}", digest(values)).unwrap();
    writeln!(text, "  from {least:.4} to {most:.4}, mean {mean:.4}").unwrap();
    // Pixels without photons have a count of 0 and the initial radius.
    let first = if name == "count" { 0.0 } else { most };
    let still = values.iter().filter(|&&v| v == first).count();
    writeln!(text, "  {still} of {} pixels at {first:.4}", values.len()).unwrap();
}

fn work(text: &mut String, stats: &Stats) {
    writeln!(text, "\nwork").unwrap();
    for (name, count) in [
        ("camera segments", stats.camera_segments),
        ("shadow rays", stats.shadow_rays),
        ("visible points", stats.visible_points),
        ("photons", stats.photons),
        ("photon segments", stats.photon_segments),
        ("deposits", stats.deposits),
        ("contributions", stats.contributions),
    ] {
        writeln!(text, "  {count} {name}").unwrap();
    }
}
