//! Runs renders from start to end: two at once, stopped, with goals, and with observers.

use crate::cases::tell;
use crate::{endless, image, path_tracer, small};
use render::{End, EngineChoice, EngineName, Error, Field, Image, Job, Notice, Observer, Step};
use scene::{Automatic, Quality, RadiusSchedule, Resumable, Settings, Stats, Stop};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// Stops the render after the given iteration.
struct StopAfter(u32, Stop);

impl Observer for StopAfter {
    fn after(&mut self, step: &Step, _: &dyn Resumable) {
        if step.iteration == self.0 {
            self.1.request();
        }
    }
}

#[test]
fn two_renders_at_once_give_the_engines_images() {
    let (first, second) = (small(1 << 30), small(8));
    let job = Job::new(first.clone());
    let stop = job.stop.clone();
    let stopped = job.start(StopAfter(3, stop)).unwrap();
    let whole = Job::new(second.clone()).start(()).unwrap();
    let (mut seen, deadline) = (0, Instant::now() + Duration::from_mins(2));
    while !(stopped.is_over() && whole.is_over()) {
        for running in [&stopped, &whole] {
            if let Some(snapshot) = running.latest() {
                let settings = Settings { iterations: snapshot.iterations, ..first.settings };
                assert_eq!(snapshot.film, image(&scene::Scene { settings, ..first.clone() }));
                seen += 1;
            }
        }
        assert!(Instant::now() < deadline, "the renders do not end");
    }
    let (stopped, whole) = (stopped.wait().unwrap(), whole.wait().unwrap());
    assert_eq!((stopped.end, stopped.report.iterations), (End::Stopped, 3));
    assert_eq!((whole.end, whole.report.iterations), (End::Iterations, 8));
    assert_eq!(stopped.last.unwrap().film, image(&small(3)));
    assert_eq!(whole.last.unwrap().film, image(&second));
    tell("render", seen, "snapshots compared");
}

#[test]
fn a_render_stops_from_any_thread_and_is_no_error() {
    let running = endless().start(()).unwrap();
    let stop = running.stopper();
    let other = spawn(move || {
        sleep(Duration::from_millis(100));
        stop.request();
    });
    let outcome = running.wait().unwrap();
    other.join().unwrap();
    assert_eq!(outcome.end, End::Stopped);
    assert!(outcome.report.interrupted && outcome.report.ended_by == "stop");
    assert!(outcome.written.is_empty() && outcome.failed.is_empty() && outcome.saved.is_none());
}

/// Who or what stopped it the front end knows; why else it has ended, the render.
#[test]
fn what_ended_a_render_is_told() {
    struct Curtain(Stop);

    impl Observer for Curtain {
        fn after(&mut self, _: &Step, _: &dyn Resumable) {
            self.0.request();
        }

        fn stopped_by(&self) -> &'static str {
            "the curtain"
        }
    }

    let job = endless();
    let stop = job.stop.clone();
    let report = job.start(Curtain(stop)).unwrap().wait().unwrap().report;
    assert_eq!((report.ended_by, report.interrupted, report.iterations), ("the curtain", true, 1));
    let report = Job::new(small(1)).start(Curtain(Stop::new())).unwrap().wait().unwrap().report;
    assert_eq!((report.ended_by, report.interrupted, report.iterations), ("iterations", false, 1));
}

#[test]
fn dropping_a_render_stops_it() {
    let job = endless();
    let stop = job.stop.clone();
    drop(job.start(()).unwrap());
    assert!(stop.is_requested());
}

#[test]
fn the_time_limit_does_not_request_a_stop() {
    let mut job = endless();
    job.goals.time = Some(Duration::from_millis(50));
    let stop = job.stop.clone();
    let outcome = job.start(()).unwrap().wait().unwrap();
    assert_eq!(outcome.end, End::Time);
    assert!(!stop.is_requested());
    assert!(outcome.report.iterations >= 1);
}

/// Its seconds, and its time limit, begin when the bias of an error goal is known. The pilots that tell it take over a
/// thousand iterations here, and the render one.
#[test]
fn pilots_of_the_bias_do_not_count_as_time_of_the_render() {
    let mut job = Job::new(small(1));
    job.scene.settings.radius_pilots = 128;
    job.goals.error = Some(1e-6);
    let began = Instant::now();
    let outcome = job.start(()).unwrap().wait().unwrap();
    let (seconds, whole) = (outcome.report.wall_seconds, began.elapsed().as_secs_f64());
    assert!(seconds > 0.0 && seconds < whole / 4.0, "{seconds} s of {whole} s");
}

/// Nothing is said to be chosen that was not, and the settings stay as they are.
#[test]
fn a_render_that_is_stopped_while_settings_are_chosen_has_its_own() {
    struct Begun(Sender<(Settings, bool)>);

    impl Observer for Begun {
        fn notice(&mut self, notice: &Notice) {
            if let Notice::Begun { settings, chosen, .. } = notice {
                self.0.send((*settings, chosen.any())).unwrap();
            }
        }
    }

    let (sender, begun) = channel();
    let job = Job::new(small(2)).choosing(Automatic::all(Quality::Draft));
    job.stop.request();
    let outcome = job.start(Begun(sender)).unwrap().wait().unwrap();
    assert_eq!((outcome.end, outcome.report.iterations), (End::Stopped, 0));
    assert_eq!(begun.recv(), Ok((small(2).settings, false)));
}

#[test]
fn an_error_goal_ends_a_render() {
    let mut job = endless();
    job.goals.error = Some(1e9);
    let outcome = job.start(()).unwrap().wait().unwrap();
    assert_eq!((outcome.end, outcome.report.iterations), (End::Error, 2));
    assert!(outcome.report.estimated_error.is_some_and(|error| error > 0.0));
}

/// Sends every notification to a channel, as text.
struct Told(Sender<String>);

impl Observer for Told {
    fn after(&mut self, step: &Step, render: &dyn Resumable) {
        assert_eq!(step.iteration, render.iterations());
        let radius = step.mean_radius.map_or("none".into(), |radius| format!("{radius:.1}"));
        self.0.send(format!("{} of {}, radius {radius}", step.iteration, step.iterations)).unwrap();
    }

    fn notice(&mut self, notice: &Notice) {
        if let Notice::Begun { threads, settings, .. } = notice {
            self.0.send(format!("{} iterations on {threads}", settings.iterations)).unwrap();
        }
    }
}

#[test]
fn an_observer_is_notified_of_every_iteration() {
    let (sender, told) = channel();
    let mut job = Job::new(small(2));
    (job.threads, job.scene.settings.initial_radius) = (Some(2), 2.0);
    job.engine = path_tracer();
    let running = job.start(Told(sender)).unwrap();
    let outcome = running.wait().unwrap();
    let told: Vec<String> = told.iter().collect();
    assert_eq!(told, ["2 iterations on 2", "1 of 2, radius none", "2 of 2, radius none"]);
    assert_eq!(outcome.report.threads, 2);
    // A part tells of its own iterations.
    let (sender, told) = channel();
    let mut job = Job::new(small(9));
    job.scene.settings.radius_schedule = RadiusSchedule::Global;
    job.range = Some(5..8);
    job.start(Told(sender)).unwrap().wait().unwrap();
    let told: Vec<String> =
        told.iter().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect();
    assert_eq!(told, ["1 of 3", "2 of 3", "3 of 3"]);
}

#[test]
fn progress_is_available_without_an_observer() {
    let running = Job::new(small(4)).start(()).unwrap();
    while !running.is_over() {
        sleep(Duration::from_millis(1));
    }
    assert_eq!(running.latest().unwrap().iterations, 4);
    let step = running.progress().unwrap();
    assert_eq!((step.iteration, step.iterations, step.photons), (4, 4, 20_000));
    assert!(step.elapsed_seconds >= step.seconds && step.seconds > 0.0);
    // It takes a pass over all pixels, so only who follows gets it.
    assert_eq!(step.mean_radius, None);
}

#[test]
fn an_observer_that_does_not_follow_is_left_alone() {
    struct Aloof;

    impl Observer for Aloof {
        fn follows(&self) -> bool {
            false
        }

        fn after(&mut self, step: &Step, _: &dyn Resumable) {
            panic!("called after iteration {}", step.iteration);
        }

        fn image(&mut self, _: Image) {
            panic!("an image that nobody asked for");
        }
    }

    let outcome = Job::new(small(2)).start(Aloof).unwrap().wait().unwrap();
    assert_eq!(outcome.report.iterations, 2);
}

#[test]
fn images_are_developed_only_if_live() {
    let mut job = Job::new(small(3));
    job.live = false;
    let running = job.start(()).unwrap();
    assert!(running.latest().is_none());
    assert!(running.wait().unwrap().last.is_none());
}

/// Seconds are those of passes, which follow each other, and bytes those of pixels and what belongs to them.
#[test]
fn engines_tell_their_seconds_and_bytes() {
    /// What an engine holds for any image: tables of spheres and of cells.
    const FIXED: f64 = 40e6;
    for engine in EngineName::ALL {
        let told = |width: u32| {
            let mut job = Job::new(small(2));
            (job.scene.settings.width, job.threads) = (width, Some(1));
            job.engine = EngineChoice::new(engine, None).unwrap();
            job.start(()).unwrap().wait().unwrap().report
        };
        let report = told(40);
        let Stats { camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds, .. } =
            report.stats;
        let passes = [camera_seconds, build_grid_seconds, photon_seconds, consolidate_seconds];
        assert!(passes.iter().all(|seconds| *seconds >= 0.0), "{engine:?}: {passes:?}");
        assert!(camera_seconds > 0.0 && photon_seconds > 0.0, "{engine:?}: {passes:?}");
        assert!(passes.iter().sum::<f64>() <= report.wall_seconds, "{engine:?}: {passes:?}");
        // At least the sums of a pixel, and no more than was told before.
        let (few, many) = (report.stats.bytes, told(400).stats.bytes);
        assert!(many - few >= 360 * 30 * 32, "{engine:?}: {few} and {many} bytes");
        assert!((few as f64) < FIXED && few <= report.bytes_at_most, "{engine:?}: {few} bytes");
    }
}

/// Photons are traced in as many rounds as it takes, which is of no account for the image.
#[test]
fn a_memory_limit_is_kept_and_changes_no_image() {
    let job = |memory_limit| {
        let mut job = Job::new(small(1));
        job.scene.settings.photons_per_iteration = 200_000;
        (job.threads, job.memory_limit) = (Some(1), memory_limit);
        job
    };
    let all = job(None).bytes_at_most().unwrap();
    let mut limits = (1..10).map(|tenths| all / 10 * tenths);
    let limit = limits.find(|limit| job(Some(*limit)).bytes_at_most().is_ok()).unwrap();
    let [limited, free] = [Some(limit), None].map(|limit| job(limit).start(()).unwrap().wait().unwrap());
    assert!(limited.report.bytes_at_most <= limit && limit < all / 2, "{limit} of {all} bytes");
    let [few, many] = [&limited, &free].map(|outcome| outcome.report.stats.bytes);
    assert!(3 * few < 2 * many, "{few} and {many} bytes");
    assert_eq!(limited.last.unwrap().film, free.last.unwrap().film);
}

/// Several threads read snapshots during a render. Each must be the complete image of an iteration.
#[test]
fn snapshots_are_complete_images() {
    let running = Arc::new(Mutex::new(Job::new(small(40)).start(()).unwrap()));
    let images: Vec<_> = (1..=40).map(|n| image(&small(n))).collect();
    let images = Arc::new(images);
    let readers: Vec<_> = (0..3)
        .map(|_| {
            let (running, images) = (Arc::clone(&running), Arc::clone(&images));
            spawn(move || {
                let mut last = 0;
                loop {
                    let (snapshot, is_over) = {
                        let running = running.lock().unwrap();
                        (running.latest(), running.is_over())
                    };
                    if let Some(snapshot) = snapshot {
                        assert!(snapshot.iterations >= last, "an older image after a newer one");
                        last = snapshot.iterations;
                        assert!(snapshot.film == images[last as usize - 1]);
                    }
                    if is_over {
                        return last;
                    }
                }
            })
        })
        .collect();
    for reader in readers {
        assert!(reader.join().unwrap() >= 1);
    }
}

/// In one process as between two: the second is refused, and may start once the first is over.
#[test]
fn two_jobs_do_not_write_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("a.pfm");
    let job = |mut job: Job| {
        job.outputs.image = Some(image.clone());
        job.threads = Some(1);
        job
    };
    let running = job(endless()).start(()).unwrap();
    match job(Job::new(small(1))).start(()).map(drop) {
        Err(Error::Input { field: Field::Image, problem }) => {
            assert!(
                problem.to_string().contains("a.pfm: is in use by another render, process "),
                "{problem}"
            );
        }
        other => panic!("not refused: {other:?}"),
    }
    running.stopper().request();
    let again = running.wait().unwrap().job;
    assert!(job(Job::new(small(1))).start(()).unwrap().wait().unwrap().failed.is_empty());
    // The job that comes back holds no lock, and takes it anew.
    let running = again.start(()).unwrap();
    assert!(job(Job::new(small(1))).start(()).is_err());
    drop(running);
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}
