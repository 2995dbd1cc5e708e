//! Merges parts of a render: checkpoints that hold different iterations of the same image.
//!
//! With global radii (`radius_schedule = "global"`) iterations are independent, and their sums are of integers. So the sum of
//! parts is that of the whole render, bit for bit, in whichever grouping and order they are added, and whoever rendered them.
//! An iteration that is in several parts is counted once.
//!
//! ```text
//! read what stands before the sums of each part: are they of one render?
//! choose parts that hold each iteration once                                (cover.rs)
//! add them up, one after another; each is verified as it is read           (sum.rs)
//! ```
//!
//! The memory is that of one image's sums, 80 bytes per pixel, however many parts there are.

mod cover;
mod sum;

pub use sum::Sum;

use crate::backdrop::{Backdrop, scene_behind};
use crate::choice::EngineChoice;
use crate::error::{Error, Field, Problem};
use crate::metadata::{self, Metadata};
use crate::outputs::{Outputs, check_distinct};
use crate::save::Note;
use crate::writer::{Shown, Writer};
use cover::{Conflict, cover};
use files::atomic_file::{self, FileError};
use files::checkpoint::{self, Checkpoint, Contents};
use files::input;
use files::lock::Lock;
use scene::{Engine, Iterations, Scene, Settings, Spheres, Stats, Sums, TRANSPORT};
use std::fmt::Display;
use std::fs::File;
use std::io::BufReader;
use std::mem::replace;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{channel, sync_channel};
use std::thread;

/// Rows that are read before they are added.
const ROWS_AHEAD: usize = 8;
/// Bytes that are read from a part at a time.
const BUFFER: usize = 1 << 20;

/// Parts of one render.
pub struct Merge {
    scene: Scene,
    digest: String,
    note: Note,
    parts: Vec<Part>,
    /// The parts that are added up.
    chosen: Vec<usize>,
    done: Iterations,
}

/// A checkpoint with global radii.
struct Part {
    path: PathBuf,
    /// Its scene is that of the merge, and no longer here.
    checkpoint: Checkpoint,
}

impl Merge {
    /// Reads what stands before the sums of parts, and chooses those that are added up. Of the number of iterations asked for,
    /// which may differ, the largest counts.
    ///
    /// # Errors
    /// Names the first file that cannot be read, is damaged, or is of another render than the first; or two files that have
    /// some iterations in common, if no choice among the parts has each iteration once.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Error> {
        let bad = |problem: String| Error::input(Field::Parts, problem);
        let mut merge: Option<Self> = None;
        for path in paths {
            let mut part = Part::open(path).map_err(bad)?;
            let scene = part.take_scene();
            match &mut merge {
                None => merge = Some(Self::of_first(part, scene)),
                Some(merge) => merge.take(part, &scene).map_err(bad)?,
            }
        }
        let mut merge = merge.ok_or_else(|| bad("there are none; name the files to merge".into()))?;
        merge.choose().map_err(bad)?;
        Ok(merge)
    }

    fn of_first(part: Part, scene: Scene) -> Self {
        let note: Note = serde_json::from_str(&part.checkpoint.note).unwrap_or_default();
        Self {
            scene,
            digest: part.checkpoint.account.scene.clone(),
            // Of the whole render, whose outputs are not those of the part.
            note: Note { renderer: note.renderer, keep: true, ..Note::default() },
            parts: vec![part],
            chosen: Vec::new(),
            done: Iterations::default(),
        }
    }

    /// Adds a part to the list, if it is of the same render. `scene` is its own.
    fn take(&mut self, part: Part, scene: &Scene) -> Result<(), String> {
        self.check_alike(&part, scene)?;
        let ours = &mut self.scene.settings;
        ours.iterations = ours.iterations.max(scene.settings.iterations);
        self.parts.push(part);
        Ok(())
    }

    /// Checks that a part, whose scene is `scene`, is of the same render.
    fn check_alike(&self, part: &Part, scene: &Scene) -> Result<(), String> {
        let (path, first) = (part.path.display(), self.parts[0].path.display());
        if part.checkpoint.account.scene != self.digest {
            return Err(format!(
                "{path} is of another scene than {first}: digest {}, not {}",
                part.checkpoint.account.scene, self.digest
            ));
        }
        match difference(&self.scene.settings, &scene.settings) {
            Some(difference) => Err(format!("{path} is of other settings than {first}: {difference}")),
            None => Ok(()),
        }
    }

    fn choose(&mut self) -> Result<(), String> {
        let sets: Vec<Iterations> = self.parts.iter().map(|part| part.checkpoint.account.done()).collect();
        self.chosen = cover(&sets).map_err(|Conflict { parts: [a, b], common }| {
            let [first, second] = [a, b].map(|k| self.parts[k].path.display());
            format!(
                "{second} ({}) and {first} ({}) both hold the iterations {common}, which cannot be told apart; leave one \
                 of the two out, and render what is then missing",
                sets[b], sets[a]
            )
        })?;
        self.done = sets.iter().fold(Iterations::default(), |all, set| all.with(set));
        Ok(())
    }

    /// The scene, with the settings of the render.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The iterations in the parts.
    pub fn done(&self) -> &Iterations {
        &self.done
    }

    /// The iterations that were asked for and are in no part.
    pub fn missing(&self) -> Iterations {
        Iterations::from(0..self.scene.settings.iterations).without(&self.done)
    }

    /// The files whose iterations are all in others, so that they are not read.
    pub fn repeated(&self) -> impl Iterator<Item = &Path> {
        let parts = self.parts.iter().enumerate();
        parts.filter(|(k, _)| !self.chosen.contains(k)).map(|(_, part)| part.path.as_path())
    }

    /// Adds the parts up and writes the result: a checkpoint if `out` ends in `.sppm`, else an image.
    ///
    /// # Errors
    /// If `out` cannot be written, is a checkpoint of which something would be lost, or a part turns out to be damaged; then
    /// nothing is written.
    pub fn write(&self, out: &Path) -> Result<(), Error> {
        let outputs = self.check(out)?;
        let _lock = Lock::take(out).map_err(|error| Error::named(Field::Image, error))?;
        if outputs.is_none() {
            self.check_replaced(out)?;
        }
        let sum = self.add_up()?;
        let written = match outputs {
            Some(outputs) => self.write_image(outputs, &sum, out),
            None => atomic_file::replace(out, |file| {
                checkpoint::write(file, &sum, &self.contents(&self.note_text()))
            }),
        };
        written.map_err(|error| Error::failed(error.to_string()))
    }

    /// Adds the parts up in memory.
    ///
    /// # Errors
    /// If a part turns out to be damaged.
    pub fn add_up(&self) -> Result<Sum, Error> {
        let (mut sum, mut stats) = (Sum::new(&self.scene), Stats::default());
        for part in self.chosen.iter().map(|&k| &self.parts[k]) {
            part.add_to(&mut sum).map_err(|problem| Error::input(Field::Parts, problem))?;
            stats.add(&part.checkpoint.account.stats);
        }
        sum.set_done(&self.done, &stats);
        Ok(sum)
    }

    /// Checks that `out` can be written; returns the outputs if it is an image.
    fn check(&self, out: &Path) -> Result<Option<Outputs>, Error> {
        let inputs: Vec<_> = self.parts.iter().map(|part| (Field::Parts, part.path.as_path())).collect();
        check_distinct(&inputs, &[(Field::Image, out)])?;
        let named = |error| Error::named(Field::Image, error);
        if is_checkpoint(out) {
            atomic_file::check(out).map_err(named)?;
            let bytes = checkpoint::length(&self.scene, &self.note_text(), Sums::Exact, false);
            atomic_file::check_room(out, bytes).map_err(named)?;
            return Ok(None);
        }
        let outputs = Outputs { image: Some(out.to_owned()), ..Outputs::default() };
        outputs.check(EngineChoice::default(), &[])?;
        outputs.check_alpha(&self.scene)?;
        outputs.check_room(&self.scene)?;
        Ok(Some(outputs))
    }

    /// Checks that nothing is lost when `out` is replaced, if it is there: that all its iterations are in the parts.
    fn check_replaced(&self, out: &Path) -> Result<(), Error> {
        if !out.exists() {
            return Ok(());
        }
        let refused = |problem: String| Error::input(Field::Image, problem);
        let other = |problem| refused(format!("{problem}; remove it, or name another file to write"));
        let mut there = Part::open(out).map_err(other)?;
        let scene = there.take_scene();
        self.check_alike(&there, &scene).map_err(other)?;
        let lost = there.checkpoint.account.done().without(&self.done);
        if lost.is_empty() {
            return Ok(());
        }
        Err(refused(format!(
            "{} holds the iterations {lost}, which are in no part and would be lost; name it as a part too, and another \
             file to write",
            out.display()
        )))
    }

    fn write_image(&self, outputs: Outputs, sum: &Sum, out: &Path) -> Result<(), FileError> {
        let writer = Writer::new(outputs);
        let metadata = self.metadata(sum, writer.outputs());
        let behind = scene_behind(&self.scene);
        let mut backdrop = behind
            .as_ref()
            .map(|behind| Backdrop::new(behind, self.scene.background, EngineChoice::default()));
        if let Some(backdrop) = &mut backdrop {
            backdrop.catch_up(&self.done);
        }
        writer.image(out, &Shown { engine: sum, backdrop: backdrop.as_ref(), metadata })
    }

    fn note_text(&self) -> String {
        serde_json::to_string(&self.note).unwrap_or_default() // cannot fail: it names no files
    }

    fn contents<'a>(&'a self, note: &'a str) -> Contents<'a> {
        let which = Some(&self.done).filter(|done| !done.are_first());
        let (scene, digest) = (&self.scene, &self.digest);
        Contents { scene, digest, version: env!("CARGO_PKG_VERSION"), note, which, past: None }
    }

    fn metadata(&self, sum: &Sum, outputs: &Outputs) -> Metadata {
        let settings = Settings { iterations: sum.iterations().max(1), ..self.scene.settings };
        Metadata {
            version: env!("CARGO_PKG_VERSION").into(),
            transport: TRANSPORT,
            scene: self.scene.name.clone(),
            scene_digest: self.digest.clone(),
            settings,
            which: Some(self.done.clone()).filter(|done| !done.are_first()),
            photons: u64::from(settings.photons_per_iteration) * u64::from(sum.iterations()),
            renderer: self.note.renderer_of(Sums::Exact),
            lanes: None,
            exposure: None,
            tone: outputs.shown_tone(),
            estimated_error: None,
            scene_file: metadata::scene_file(&self.scene, &settings),
        }
    }
}

impl Part {
    fn open(path: &Path) -> Result<Self, String> {
        let (_, _, checkpoint) = read_head(path)?;
        Ok(Self { path: path.to_owned(), checkpoint })
    }

    /// Takes the scene out: of many parts, one scene is enough.
    fn take_scene(&mut self) -> Scene {
        let own = &mut self.checkpoint.scene;
        let Scene { camera, settings, background, transparent_background, .. } = *own;
        let (name, materials, spheres) = (String::new(), Vec::new(), Spheres::default());
        let imports = Vec::new();
        replace(
            own,
            Scene { name, camera, materials, spheres, background, transparent_background, settings, imports },
        )
    }

    /// Adds the sums. The file is opened again, as there may be more parts than files that can be open.
    fn add_to(&self, sum: &mut Sum) -> Result<(), String> {
        let (mut file, length, again) = read_head(&self.path)?;
        if again.account != self.checkpoint.account {
            return Err(format!("{} has changed while it was merged; begin again", self.path.display()));
        }
        let read = thread::scope(|scope| {
            // To read takes about as long as to add.
            let (rows, received) = sync_channel::<(u32, Vec<u32>)>(ROWS_AHEAD);
            let (back, used) = channel::<Vec<u32>>();
            scope.spawn(move || {
                for (y, words) in received {
                    sum.add_row(y, &words);
                    let _ = back.send(words); // when all is read, nobody wants it back
                }
            });
            again.sums(&mut file, length, |y, words| {
                let mut row = used.try_recv().unwrap_or_default();
                row.clear();
                row.extend_from_slice(words);
                let _ = rows.send((y, row)); // fails if the other thread panics, as this one does then
            })
        });
        read.map_err(|damage| format!("{}: {damage}", self.path.display()))
    }
}

/// Opens a part, and reads what stands before its sums. Returns the file with its length.
fn read_head(path: &Path) -> Result<(BufReader<File>, u64, Checkpoint), String> {
    let told = |problem: &dyn Display| format!("{}: {problem}", path.display());
    let (file, length) = input::open(path, "name a part").map_err(|problem| told(&problem))?;
    let mut file = BufReader::with_capacity(BUFFER, file);
    let read = Checkpoint::read_head(&mut file, length, path.parent().unwrap_or(Path::new("")));
    let checkpoint = read.and_then(|checkpoint| checkpoint.check_transport().map(|()| checkpoint));
    let checkpoint = checkpoint.map_err(|damage| told(&damage))?;
    if checkpoint.account.sums != Sums::Exact {
        return Err(told(&format_args!(
            "is of {}, whose sums cannot be merged; only renders with --radius-schedule global have parts",
            checkpoint.account.sums
        )));
    }
    Ok((file, length, checkpoint))
}

/// Whether a file is named as a checkpoint.
pub fn is_checkpoint(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "sppm")
}

/// The first setting in which two renders differ, other than the number of iterations.
fn difference(ours: &Settings, theirs: &Settings) -> Option<String> {
    let rows = |settings: &Settings| {
        let Settings {
            width,
            height,
            photons_per_iteration,
            max_depth,
            initial_radius,
            seed,
            filter,
            light_samples,
            glint_samples,
            iterations: _,
            radius_schedule: _,
            radius_pilots: _,
            radius_clearance: _,
        } = *settings;
        [
            ("width", width.to_string()),
            ("height", height.to_string()),
            ("photons_per_iteration", photons_per_iteration.to_string()),
            ("max_depth", max_depth.to_string()),
            ("initial_radius", initial_radius.to_string()),
            ("seed", seed.to_string()),
            ("filter", filter.to_string()),
            ("light_samples", light_samples.to_string()),
            ("glint_samples", glint_samples.to_string()),
        ]
    };
    if (Settings { iterations: ours.iterations, ..*theirs }) == *ours {
        return None;
    }
    let pairs = rows(ours).into_iter().zip(rows(theirs));
    let found = pairs.into_iter().find(|(ours, theirs)| ours != theirs);
    let told = |((name, ours), (_, theirs))| format!("{name} is {theirs}, not {ours}");
    Some(found.map_or("they differ in one that this program does not name".into(), told))
}

/// The iterations of part number `part`, from 1, if so many are divided evenly into `parts`.
///
/// # Errors
/// If there is no such part, or it has no iterations.
pub fn part_of(iterations: u32, part: u32, parts: u32) -> Result<Range<u32>, Error> {
    let said = || Problem::of(Field::Part).text(format_args!(" {part}/{parts}"));
    if part == 0 || part > parts {
        return Err(Error::input(Field::Part, said().text(": parts are counted from 1 to their number")));
    }
    let start = |part: u32| (u64::from(iterations) * u64::from(part) / u64::from(parts)) as u32;
    let range = start(part - 1)..start(part);
    if range.is_empty() {
        let problem = format!(" has no iterations, as there are {iterations} in all; ask for fewer parts");
        return Err(Error::input(Field::Part, said().text(problem)));
    }
    Ok(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Filter, RadiusSchedule};

    #[test]
    fn the_setting_that_differs_is_named() {
        let ours =
            Settings { width: 4, height: 3, radius_schedule: RadiusSchedule::Global, ..Settings::default() };
        assert_eq!(difference(&ours, &ours), None);
        // Parts may have been asked for with other numbers of iterations.
        assert_eq!(difference(&ours, &Settings { iterations: ours.iterations + 1, ..ours }), None);
        for (theirs, told) in [
            (Settings { width: 5, ..ours }, "width is 5, not 4"),
            (Settings { height: 5, ..ours }, "height is 5, not 3"),
            (
                Settings { photons_per_iteration: 7, max_depth: 1, ..ours },
                "photons_per_iteration is 7, not 200000",
            ),
            (Settings { max_depth: 1, ..ours }, "max_depth is 1, not 5"),
            (Settings { initial_radius: 0.5, ..ours }, "initial_radius is 0.5, not 2"),
            (Settings { seed: 99, ..ours }, "seed is 99, not 1"),
            (Settings { filter: Filter::Gaussian, ..ours }, "filter is gaussian, not box"),
            (Settings { light_samples: 2, ..ours }, "light_samples is 2, not 1"),
            (Settings { glint_samples: 2, ..ours }, "glint_samples is 2, not 1"),
            (Settings { radius_pilots: 2, ..ours }, "they differ in one that this program does not name"),
        ] {
            assert_eq!(difference(&ours, &theirs).as_deref(), Some(told));
        }
    }

    #[test]
    fn parts_have_each_iteration_once_and_are_alike() {
        for (iterations, parts) in [(1, 1), (7, 3), (64, 64), (100, 7), (u32::MAX, 3)] {
            let ranges: Vec<_> = (1..=parts).map(|part| part_of(iterations, part, parts).unwrap()).collect();
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, iterations));
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start), "{ranges:?}");
            let least = iterations / parts;
            assert!(ranges.iter().all(|range| (least..=least + 1).contains(&(range.end - range.start))));
        }
        for (part, parts, told) in [
            (0, 4, "part 0/4: parts are counted from 1 to their number"),
            (5, 4, "part 5/4: parts are counted from 1 to their number"),
            (1, 4, "part 1/4 has no iterations, as there are 3 in all; ask for fewer parts"),
        ] {
            assert_eq!(part_of(3, part, parts).unwrap_err().to_string(), told);
        }
    }

    #[test]
    fn checkpoints_are_told_by_their_names() {
        assert!(is_checkpoint(Path::new("a/b.sppm")) && is_checkpoint(Path::new("a.png.sppm")));
        for other in ["a.png", "sppm", ".sppm", "a.sppm.1", "a.SPPM"] {
            assert!(!is_checkpoint(Path::new(other)), "{other}");
        }
    }
}
