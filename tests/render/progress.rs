//! How far an iteration is, and images that go to a stream.

use crate::{endless, path_tracer, small};
use render::{EngineChoice, EngineName, Job, MethodName, Outputs, Renderer, Stream};
use scene::{Engine, Settings, Stop};
use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// All of the work is counted, once, whatever the size, and however the photons are divided into rounds.
#[test]
fn a_whole_iteration_is_all_of_its_work() {
    for (width, height, photons) in [(40, 30, 5000), (1, 1, 1), (65, 9, 1025)] {
        let scene = small(1);
        let settings = Settings { width, height, photons_per_iteration: photons, ..scene.settings };
        let fast = fast::Sppm::new(&scene, &settings);
        let rounds = fast::Sppm::new(&scene, &settings).deposits_at_once(500);
        let engines: [Box<dyn Engine>; 5] = [
            Box::new(fast),
            Box::new(rounds),
            Box::new(reference::Sppm::new(&scene, &settings)),
            Box::new(reference::PathTracer::new(&scene, &settings)),
            Box::new(fast::PathTracer::new(&scene, &settings)),
        ];
        for mut engine in engines {
            for _ in 0..2 {
                let stop = Stop::new();
                assert_eq!(stop.meter().share(), 0.0);
                assert!(engine.iterate_unless(&stop));
                let left = 1.0 - stop.meter().share();
                // `share` is cut off at 1, so nothing may be missing; that nothing is counted twice is tested below.
                assert_eq!(left, 0.0, "{width} x {height}, {photons} photons");
            }
        }
    }
}

#[test]
fn a_running_render_tells_how_far_its_iteration_is() {
    let all =
        MethodName::ALL.iter().flat_map(|&method| EngineName::ALL.map(|engine| Renderer { method, engine }));
    for renderer in all {
        let mut job = endless();
        job.engine = EngineChoice::new(renderer, None).unwrap();
        let settings = &mut job.scene.settings;
        (settings.width, settings.height, settings.photons_per_iteration) = (2000, 1500, 100_000_000);
        let running = job.start(()).unwrap();
        let (mut last, mut steps, began) = (0.0, 0, Instant::now());
        while steps < 5 {
            let share = running.share_of_iteration();
            if running.progress().is_none() {
                assert!((last..1.0).contains(&share), "{share} after {last}");
            }
            steps += u32::from(share > last);
            last = share;
            assert!(began.elapsed() < Duration::from_mins(2), "{renderer:?} does not tell");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// A stream that keeps what it gets.
#[derive(Clone, Default)]
struct Kept(Arc<Mutex<Vec<u8>>>);

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_stream_gets_the_bytes_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["png", "exr", "pfm"] {
        let (kept, file) = (Kept::default(), folder.path().join(format!("a.{extension}")));
        let mut job = Job::new(small(2));
        job.engine = path_tracer();
        job.outputs = Outputs {
            image: Some(file.clone()),
            stream: Some(Stream::new("a socket", extension, kept.clone())),
            ..Outputs::default()
        };
        let outcome = job.start(()).unwrap().wait().unwrap();
        assert_eq!(outcome.written, [file.clone(), "a socket".into()]);
        assert!(*kept.0.lock().unwrap() == std::fs::read(file).unwrap(), "{extension}");
    }
}

/// A stream that is broken.
struct Broken;

impl Write for Broken {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        Err(io::ErrorKind::ConnectionReset.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn an_image_that_a_stream_does_not_take_is_told_and_kept() {
    let mut job = Job::new(small(1));
    job.outputs.stream = Some(Stream::new("a socket", "pfm", Broken));
    let outcome = job.start(()).unwrap().wait().unwrap();
    assert!(outcome.written.is_empty());
    let [unwritten] = &outcome.failed[..] else { panic!("{:?}", outcome.failed) };
    let said = unwritten.error.to_string();
    assert!(said.starts_with("a socket: cannot be written: "), "{said}");
    let refuge = unwritten.refuge.as_ref().unwrap();
    assert_eq!(files::image_file::read(refuge).unwrap().pixels.len(), 40 * 30);
    std::fs::remove_file(refuge).unwrap();
}
