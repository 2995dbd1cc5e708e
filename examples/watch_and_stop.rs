//! Watches a render, and stops it once the search radius has shrunk far enough:
//! `cargo run --release --example watch_and_stop`

use render::{End, Job, Notice, Observer, Step};
use scene::{Resumable, Stop};

/// The image is good enough when the search radius has shrunk to this share of the first.
const SHARE: f64 = 0.8;

/// Prints every iteration and stops the render in time.
struct Watcher {
    stop: Stop,
    first: Option<f64>,
}

impl Observer for Watcher {
    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        let radius = step.mean_radius.unwrap_or_default();
        println!("iteration {}: {} photons, mean radius {radius:.3}", step.iteration, step.photons);
        if radius <= SHARE * *self.first.get_or_insert(radius) {
            self.stop.request();
        }
    }

    fn notice(&mut self, notice: &Notice) {
        println!("{notice:?}");
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = files::builtin::scene("cornell").ok_or("no such scene")?;
    (scene.settings.width, scene.settings.height) = (80, 60);
    scene.settings.photons_per_iteration = 20_000;
    scene.settings.iterations = 1000;

    let job = Job::new(scene);
    let watcher = Watcher { stop: job.stop.clone(), first: None };
    let running = job.start(watcher)?;

    // Any thread may ask for the newest image meanwhile.
    while !running.is_over() {
        if let Some(snapshot) = running.latest() {
            let middle = snapshot.film.pixels[snapshot.film.pixels.len() / 2];
            println!("after {} iterations the middle is {middle}", snapshot.iterations);
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let outcome = running.wait()?;
    assert_eq!(outcome.end, End::Stopped);

    // From another place, and again: threads, buffers and what follows from the spheres are still there.
    let mut job = outcome.job;
    job.scene.camera.eye.x += 5.0;
    job.scene.settings.iterations = 4;
    let again = job.start(())?.wait()?;
    println!("{} iterations from another place", again.report.iterations);
    Ok(())
}
