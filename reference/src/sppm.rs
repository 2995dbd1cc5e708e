//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009): the passes of an iteration, in order.

use crate::camera_pass::{CameraNumbers, VisiblePoint, camera_ray, trace};
use crate::consolidate::{Gathered, Pixel};
use crate::grid::Grid;
use crate::photon_pass::{Deposit, photon_pass};
use scene::still::Role;
use scene::{Engine, Film, Plane, Scene, Settings, Stats, Still};
use std::time::Instant;

/// The grid's cell size over the largest radius, unless one asks for another. The image does not depend on it.
const CELL_SIZE: f32 = 2.0;

/// The reference renderer.
pub struct Sppm<'a> {
    scene: &'a Scene,
    settings: Settings,
    cell_size: f32,
    iterations: u32,
    pixels: Vec<Pixel>,
    stats: Stats,
}

impl<'a> Sppm<'a> {
    /// A render that has not begun.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        Self::with_cell_size(scene, settings, CELL_SIZE)
    }

    /// The same render over a grid whose cells measure `cell_size` times the largest radius; a number above 0.
    pub fn with_cell_size(scene: &'a Scene, settings: &Settings, cell_size: f32) -> Self {
        let pixels = vec![Pixel::new(settings.initial_radius); settings.pixels()];
        Self { scene, settings: *settings, cell_size, iterations: 0, pixels, stats: Stats::default() }
    }

    /// One camera path per pixel: adds up direct light, and gives the visible points, each with its pixel's index.
    fn camera_pass(&mut self, still: &Still) -> (Vec<VisiblePoint>, Vec<usize>) {
        let frame = self.scene.camera.frame(self.settings.width, self.settings.height);
        let (mut points, mut owners) = (Vec::new(), Vec::new());
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            let (x, y) = (index as u32 % self.settings.width, index as u32 / self.settings.width);
            let mut numbers = CameraNumbers::new(&self.settings, self.iterations, x, y);
            let ray = camera_ray(&frame, x, y, &numbers);
            let sample = trace(still, ray, self.settings.max_depth, &mut numbers, &mut self.stats);
            pixel.direct += sample.direct;
            if let Some(visible) = sample.visible {
                points.push(visible);
                owners.push(index);
            }
        }
        (points, owners)
    }

    /// Traces the photons and joins each with the visible points that it reaches.
    fn photon_pass(
        &mut self,
        still: &Still,
        grid: &Grid,
        points: &[VisiblePoint],
        owners: &[usize],
    ) -> Vec<Gathered> {
        let mut gathered = vec![Gathered::default(); points.len()];
        let pixels = &self.pixels;
        photon_pass(still, &self.settings, self.iterations, &mut self.stats, |deposit, stats| {
            for index in grid.candidates(deposit.point) {
                stats.candidates += 1;
                if contributes(still, deposit, &points[index], pixels[owners[index]].radius_squared) {
                    stats.contributions += 1;
                    let sum = &mut gathered[index];
                    sum.m += 1;
                    for (total, flux) in sum.flux.iter_mut().zip(deposit.flux.0) {
                        *total += u64::from(flux);
                    }
                }
            }
        });
        gathered
    }

    fn plane(&self, value: impl Fn(&Pixel) -> f32) -> Plane {
        let Settings { width, height, .. } = self.settings;
        Plane { width, height, values: self.pixels.iter().map(value).collect() }
    }
}

/// True if a photon counts at a visible point: it arrives within the radius, and on the side that is seen.
///
/// Inside of one and the same shell it always does, whatever the angle to the visible point's normal. To reject what
/// grazes there would lose `R^2 / (8 r^2)` of an even light, and by just so much a furnace would be too dark.
pub fn contributes(still: &Still, deposit: &Deposit, visible: &VisiblePoint, radius_squared: f32) -> bool {
    let d = deposit.point - visible.point;
    let is_near = d.dot(d) < radius_squared;
    let shares_shell = deposit.sphere == visible.sphere
        && matches!(still.roles[visible.sphere as usize], Role::Enclosure(_));
    is_near && (shares_shell || deposit.wi.dot(visible.normal) > 0.0)
}

impl Engine for Sppm<'_> {
    fn iterate(&mut self) {
        let still = self.scene.at(self.scene.camera.shutter_time(self.settings.seed, self.iterations));
        let start = Instant::now();
        let (points, owners) = self.camera_pass(&still);
        let camera = Instant::now();
        let grid = Grid::build(&points, |i| self.pixels[owners[i]].radius_squared.sqrt(), self.cell_size);
        let built = Instant::now();
        let gathered = self.photon_pass(&still, &grid, &points, &owners);
        let traced = Instant::now();
        for ((visible, owner), gathered) in points.iter().zip(&owners).zip(&gathered) {
            self.pixels[*owner].consolidate(visible.beta, gathered, still.lights.power);
        }
        self.iterations += 1;
        let held = size_of_val(&self.pixels[..]) + size_of_val(&points[..]) + size_of_val(&owners[..]);
        self.stats.bytes = (held + size_of_val(&gathered[..]) + grid.bytes()) as u64;
        self.stats.camera_seconds += (camera - start).as_secs_f64();
        self.stats.build_grid_seconds += (built - camera).as_secs_f64();
        self.stats.photon_seconds += (traced - built).as_secs_f64();
        self.stats.consolidate_seconds += traced.elapsed().as_secs_f64();
    }

    fn iterations(&self) -> u32 {
        self.iterations
    }

    fn develop(&self) -> Film {
        let Settings { width, height, .. } = self.settings;
        if self.iterations == 0 {
            return Film::new(width, height);
        }
        let pixels = self.pixels.iter().map(|p| p.develop(&self.settings, self.iterations)).collect();
        Film { width, height, pixels }
    }

    fn direct(&self) -> Option<Film> {
        let Settings { width, height, .. } = self.settings;
        Some(Film { width, height, pixels: self.pixels.iter().map(|p| p.direct).collect() })
    }

    fn radius(&self) -> Option<Plane> {
        Some(self.plane(|p| p.radius_squared.sqrt()))
    }

    fn count(&self) -> Option<Plane> {
        Some(self.plane(|p| p.n))
    }

    fn stats(&self) -> &Stats {
        &self.stats
    }
}
