//! Writes all times and counts as a table of comma-separated values.

use crate::error::Error;
use crate::options::Random;
use crate::report::csv;
use crate::report::measured::Measured;
use crate::report::sweep::Sweep;
use serde::Serialize;
use std::path::Path;

/// A line of the table: a row of the ladder in one case. Seconds are those of the median run.
#[derive(Serialize)]
struct Record<'a> {
    scene: &'a str,
    row: &'a str,
    random: Random,
    sweep: Option<Sweep>,
    value: Option<u64>,
    width: u32,
    height: u32,
    iterations: u32,
    photons_per_iteration: u32,
    max_depth: u32,
    spheres: usize,
    runs: usize,
    seconds: f64,
    least_seconds: f64,
    camera_seconds: f64,
    index_seconds: f64,
    photon_seconds: f64,
    consolidate_seconds: f64,
    speedup: f64,
    visible_points: u64,
    photon_segments: u64,
    deposits: u64,
    candidates: u64,
    contributions: u64,
    bytes: u64,
}

/// Writes a line per case and row.
pub(crate) fn write(path: &Path, measured: &Measured, random: Random) -> Result<(), Error> {
    let places =
        (0..measured.cases.len()).flat_map(|case| (0..measured.rows.len()).map(move |row| (case, row)));
    let records: Vec<Record> = places.map(|(case, row)| record(measured, case, row, random)).collect();
    csv::write(path, &records)
}

fn record<'a>(measured: &'a Measured, case: usize, row: usize, random: Random) -> Record<'a> {
    let (runs, number) = (&measured.runs[case][row], case);
    let (case, run) = (&measured.cases[case], runs.median());
    Record {
        scene: &case.name,
        row: measured.rows[row].name,
        random,
        sweep: measured.sweep,
        value: measured.sweep.map(|_| case.value),
        width: case.settings.width,
        height: case.settings.height,
        iterations: case.settings.iterations,
        photons_per_iteration: case.settings.photons_per_iteration,
        max_depth: case.settings.max_depth,
        spheres: case.scene.spheres.len(),
        runs: runs.count(),
        seconds: run.seconds,
        least_seconds: runs.least(),
        camera_seconds: run.stats.camera_seconds,
        index_seconds: run.stats.build_grid_seconds,
        photon_seconds: run.stats.photon_seconds,
        consolidate_seconds: run.stats.consolidate_seconds,
        speedup: measured.speedup(number, row),
        visible_points: run.stats.visible_points,
        photon_segments: run.stats.photon_segments,
        deposits: run.stats.deposits,
        candidates: run.stats.candidates,
        contributions: run.stats.contributions,
        bytes: run.stats.bytes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::Example;

    #[test]
    fn every_column_holds_what_it_is_called() {
        let (scenes, sweep) = (Example::of_scenes(), Example::of_sweep());
        let spheres = scenes.measured().cases[0].scene.spheres.len();
        let of_scene = csv::text(&[record(&scenes.measured(), 1, 2, Random::Paper)]);
        let expected = format!(
            "scene,row,random,sweep,value,width,height,iterations,photons_per_iteration,max_depth,spheres,runs,seconds,\
             least_seconds,camera_seconds,index_seconds,photon_seconds,consolidate_seconds,speedup,visible_points,\
             photon_segments,deposits,candidates,contributions,bytes\n\
             b,fast,paper,,,8,6,3,50,5,{spheres},3,2.0,1.5,1.0,0.25,0.5,0.0625,6.0,11,12,13,14,15,16\n"
        );
        assert_eq!(of_scene, expected);
        let of_sweep = csv::text(&[record(&sweep.measured(), 1, 1, Random::Keyed)]);
        let line = format!(
            "a,6,keyed,photons,40,8,6,3,40,5,{spheres},3,2.0,1.5,1.0,0.25,0.5,0.0625,4.0,11,12,13,14,15,16"
        );
        assert_eq!(of_sweep.lines().nth(1), Some(&line[..]));
    }
}
