//! Renders a range of the frames of a trajectory, an image for each.

use super::render::{RenderArgs, configure, job_of, particles};
use super::watch;
use crate::args::frames::{Frames, numbered};
use crate::args::outputs::default_name;
use crate::args::particles::CameraFrame;
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::logs::{self, Level};
use crate::terminal::signals::Requests;
use figure::Frame;
use figure::Stage;
use files::named;
use files::particles::{Clip, Scenery};
use scene::text::{counted, list};
use std::path::Path;

/// Renders the frames of `range` one after another. One that fails is told, and does not keep the others from being rendered;
/// a signal ends all.
pub(super) fn run(args: &RenderArgs, range: Frames) -> Result<(), Error> {
    let bad = |problem: &str| Err(Error::BadInput(problem.into()));
    let Some(path) = particles(&args.source).filter(|_| args.source.like.is_none()) else {
        return bad("--frame: ranges of frames are for files of particles, such as .xyz or .dump");
    };
    if args.part.field().is_some() {
        return bad("--frame: parts of a render are of one frame; name one, or leave out --part and --range");
    }
    if args.outputs.is_streamed() {
        return bad(
            "--output: standard output takes one image, and a range of frames gives several; name a file",
        );
    }
    if args.source.particles.asks_for_a_page() {
        return bad("--view: the page shows one frame, and a range gives several; give the view a direction");
    }
    let busy = Busy::with(format!("reading {}", path.display()));
    let clip = Clip::open(path).map_err(Error::BadInput)?;
    drop(busy);
    let numbers =
        range.numbers(clip.frames()).map_err(|problem| Error::BadInput(format!("--frame: {problem}")))?;
    let reel = Reel::new(args, path, clip, numbers.first().copied().unwrap_or(0))?;
    let requests = Requests::listen()?;
    let mut failed = Vec::new();
    for (place, number) in numbers.iter().copied().enumerate() {
        match reel.render(number, (place, numbers.len()), &requests) {
            Ok(()) => {}
            Err(Error::Interrupted(signal, text)) => {
                let rest = range.beginning_at(number);
                let text = format!("frame {number}: {text}; `--frame {rest}` goes on with it");
                return Err(Error::Interrupted(signal, text));
            }
            // What the options ask for cannot be done for any frame.
            Err(error @ Error::BadInput(_)) if place == 0 => return Err(error),
            Err(error) => {
                logs::say(Level::ERROR, &format!("frame {number}: {error}"));
                failed.push(number);
            }
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    let all = counted(numbers.len() as u64, "frame");
    let others = if failed.len() == numbers.len() { "" } else { "; the others are rendered" };
    Err(Error::Failed(format!("of {all} these failed: {}{others}", list(&failed))))
}

/// Frames that are rendered with the same options.
struct Reel<'a> {
    args: &'a RenderArgs,
    path: &'a Path,
    clip: Clip,
    stage: Stage,
    most: u64,
    /// The stage of all frames, if they share one.
    scenery: Option<Scenery>,
}

impl<'a> Reel<'a> {
    /// Finds the stage of all frames, of which `first` is the first.
    fn new(args: &'a RenderArgs, path: &'a Path, clip: Clip, first: usize) -> Result<Self, Error> {
        let particles = &args.source.particles;
        let stage = particles.stage([args.settings.width, args.settings.height])?;
        let most = args.engine.memory_limit.unwrap_or(u64::MAX);
        let frame = match particles.camera_frame()? {
            CameraFrame::Each => None,
            CameraFrame::Usual => Some(Frame::Number(first)),
            CameraFrame::Of(frame) => Some(frame),
        };
        let scenery = frame.map(|frame| particles.scenery(&clip, frame, &stage, most)).transpose()?;
        Ok(Self { args, path, clip, stage, most, scenery })
    }

    fn render(&self, number: usize, (place, all): (usize, usize), requests: &Requests) -> Result<(), Error> {
        if let Some(signal) = requests.pending() {
            return Err(Error::Interrupted(signal, "it was not begun".into()));
        }
        let particles = &self.args.source.particles;
        let recipe = particles.recipe(Frame::Number(number))?;
        let busy = Busy::with(format!("reading frame {number} of {}", self.path.display()));
        let staged = self.clip.stage(&recipe, &self.stage, self.scenery.as_ref(), self.most);
        // Of another frame it may be true, so the request is not at fault.
        let (staged, _) = staged.map_err(|problem| Error::Failed(particles.say(self.path, &problem)))?;
        drop(busy);
        let opened = named::of_particles(self.path, staged);
        opened.notes.iter().for_each(|note| logs::say(Level::INFO, &format!("note: frame {number}: {note}")));
        let image = numbered(&default_name(&opened.stem), number);
        let job = job_of(opened)?;
        let outputs = self.args.outputs.of_frame(number);
        let checkpoints = self.args.checkpoints.of_frame(number);
        let job = configure(self.args, job, image, (&outputs, &checkpoints))?;
        let title = format!("frame {number}, {} of {all}", place + 1);
        watch::run(job, Some(title), &self.args.messages, (&self.args.viewers, false), requests)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal_hook::consts::SIGINT;
    use std::fs;
    use std::path::PathBuf;
    use tempfile::TempDir;

    /// The options of `sppm render` with these words, and a limit of memory that no render keeps to.
    fn args(words: &[&str]) -> RenderArgs {
        use crate::commands::{Args, Command};
        use clap::Parser as _;
        let usual = ["sppm", "render", "run.xyz", "--memory-limit", "1K"];
        let args = Args::try_parse_from(usual.iter().chain(words)).unwrap();
        let Command::Render(args) = args.command else { panic!("another command") };
        args
    }

    /// A file of two frames: of 2 atoms, and of 100.
    fn trajectory() -> (TempDir, PathBuf) {
        let frame = |atoms: usize| {
            let row = |i: usize| format!("O {} 0 0\n", 3 * i);
            let rows: String = (0..atoms).map(row).collect();
            format!("{atoms}\n\n{rows}")
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.xyz");
        fs::write(&path, frame(2) + &frame(100)).unwrap();
        (folder, path)
    }

    /// Of the frame that the camera is fitted to, and of each that is shown.
    #[test]
    fn a_memory_limit_holds_for_every_frame_that_is_read() {
        let (_folder, path) = trajectory();
        let args = args(&[]);
        let reel = |first| Reel::new(&args, &path, Clip::open(&path).unwrap(), first);
        let fitted = reel(1).err().unwrap().to_string();
        assert!(fitted.contains("100 particles need "), "{fitted}");
        let shown = reel(0).unwrap().render(1, (1, 2), &Requests::deaf()).unwrap_err().to_string();
        assert!(shown.contains("100 particles need "), "{shown}");
    }

    /// One that comes between two frames ends the range before the next.
    #[test]
    fn a_frame_is_not_begun_after_a_signal() {
        let (_folder, path) = trajectory();
        let args = args(&["--camera-frame", "each"]);
        let reel = Reel::new(&args, &path, Clip::open(&path).unwrap(), 0).unwrap();
        let ended = reel.render(0, (0, 2), &Requests::after(SIGINT)).unwrap_err();
        assert_eq!((ended.code(), ended.to_string()), (130, "it was not begun".into()));
    }
}
