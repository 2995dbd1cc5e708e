//! Images that an observer asks for: with radii, counts and metadata.

use crate::{endless, image, path_tracer, small};
use render::{Image, Job, Observer, Step};
use scene::{Engine, Resumable, Settings, Stop};
use std::sync::mpsc::{Sender, channel};

/// Asks for the image after the given iteration, and for the last.
pub(crate) struct Asks {
    after: u32,
    done: u32,
    images: Sender<Image>,
    stop: Option<Stop>,
}

impl Asks {
    pub(crate) fn new(after: u32, images: Sender<Image>) -> Self {
        Self { after, done: 0, images, stop: None }
    }
}

impl Observer for Asks {
    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        self.done = step.iteration;
    }

    fn wants_image(&mut self, is_last: bool) -> bool {
        is_last || self.done == self.after
    }

    fn image(&mut self, image: Image) {
        self.images.send(image).unwrap();
        if let Some(stop) = &self.stop {
            stop.request();
        }
    }
}

#[test]
fn an_observer_gets_the_images_that_it_asks_for() {
    let (sender, images) = channel();
    let scene = small(5);
    let mut job = Job::new(scene.clone());
    job.live = false;
    let outcome = job.start(Asks::new(3, sender)).unwrap().wait().unwrap();
    let images: Vec<Image> = images.iter().collect();
    let of =
        |iterations| scene::Scene { settings: Settings { iterations, ..scene.settings }, ..scene.clone() };
    assert_eq!(images.iter().map(|image| image.metadata.settings.iterations).collect::<Vec<_>>(), [3, 5]);
    for (seen, iterations) in images.iter().zip([3, 5]) {
        assert_eq!(seen.film, image(&of(iterations)));
        let mut engine = fast::Sppm::new(&scene, &scene.settings);
        (0..iterations).for_each(|_| engine.iterate());
        assert_eq!((&seen.radius, &seen.count), (&engine.radius(), &engine.count()));
        assert_eq!(seen.metadata.photons, 5000 * u64::from(iterations));
    }
    assert_eq!(outcome.last, None, "the job is not live");
}

#[test]
fn the_last_image_of_a_stopped_render_is_that_of_its_last_whole_iteration() {
    let (sender, images) = channel();
    let mut job = endless();
    job.live = false;
    let stop = Some(job.stop.clone());
    let outcome = job.start(Asks { stop, ..Asks::new(2, sender) }).unwrap().wait().unwrap();
    let images: Vec<Image> = images.iter().collect();
    assert_eq!(outcome.report.iterations, 2);
    assert_eq!(images.len(), 2);
    assert_eq!(images[0], images[1]);
}

#[test]
fn a_render_without_an_image_gives_none_and_a_path_tracer_no_planes() {
    let (sender, images) = channel();
    let job = endless();
    job.stop.request();
    job.start(Asks::new(1, sender.clone())).unwrap().wait().unwrap();
    let mut job = Job::new(small(1));
    job.engine = path_tracer();
    job.start(Asks::new(9, sender)).unwrap().wait().unwrap();
    let images: Vec<Image> = images.iter().collect();
    assert_eq!(images.len(), 1);
    assert_eq!((&images[0].radius, &images[0].count, images[0].metadata.photons), (&None, &None, 0));
}
