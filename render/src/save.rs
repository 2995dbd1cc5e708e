//! Where and how often checkpoints are written, and the note that they contain.

use crate::names::{MethodName, Renderer};
use crate::outputs::Outputs;
use files::checkpoint::Loaded;
use files::image_file::Tone;
use files::paths::around;
use scene::Sums;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Where and how often to write checkpoints.
#[derive(Clone, Debug, PartialEq)]
pub struct Save {
    /// The checkpoint file. If there is one of another render, it is not overwritten: the job is refused.
    pub path: PathBuf,
    /// How often it is written.
    pub every: Every,
    /// Whether it is kept after the render is complete. If so, the path is also checked before the start.
    pub keep: bool,
}

impl Save {
    /// Writes `OUT.sppm` next to the image `OUT` once a minute, and removes it after the render is complete. If that name
    /// would be too long for a file, it is shortened ([`files::paths::around`]).
    pub fn beside(image: &Path) -> Self {
        Self { path: around(image, "", ".sppm"), every: Every::default(), keep: false }
    }
}

/// The interval between two checkpoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Every {
    /// After the first iteration that ends at least this long after the last checkpoint.
    Time(Duration),
    /// After this many iterations.
    Iterations(u32),
}

impl Default for Every {
    fn default() -> Self {
        Self::Time(Duration::from_mins(1))
    }
}

/// The note in a checkpoint: the outputs and options of the render. Files in the checkpoint's own folder are noted by
/// name, so that they can be moved together with it; others by absolute path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// The method, and the engine that rendered last.
    #[serde(flatten)]
    pub renderer: Option<Renderer>,
    /// The image.
    pub image: Option<PathBuf>,
    /// Exposure of the image, in stops.
    pub exposure: Option<f32>,
    /// Tone curve of the image, if it is not the usual one.
    #[serde(default)]
    pub tone: Option<Tone>,
    /// Whether snapshots of iterations 1, 2, 4, 8, ... are written.
    pub snapshots: bool,
    /// The image of radii.
    pub radius_image: Option<PathBuf>,
    /// The image of counts.
    pub count_image: Option<PathBuf>,
    /// The report in JSON.
    pub stats: Option<PathBuf>,
    /// The estimated error at which the render is to end.
    pub until_error: Option<f64>,
    /// How often the checkpoint is written.
    pub every: Every,
    /// Whether the checkpoint is kept after the render is complete.
    pub keep: bool,
    /// The iterations of a part of a render, from the first to before the second; `None` if all are wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[u32; 2]>,
}

impl Note {
    /// The note in a checkpoint; the default if it cannot be parsed.
    pub fn of(loaded: &Loaded) -> Self {
        serde_json::from_str(&loaded.checkpoint.note).unwrap_or_default()
    }

    /// The iterations that were asked for, of a part.
    pub(crate) fn part(&self) -> Option<Range<u32>> {
        self.range.map(|[start, end]| start..end)
    }

    /// What renders a checkpoint with this note and `sums`: by the noted engine, if one is noted.
    pub fn renderer_of(&self, sums: Sums) -> Renderer {
        let method = MethodName::of(sums);
        self.renderer.filter(|renderer| renderer.method == method).unwrap_or(method.into())
    }
}

/// `path` as noted in a checkpoint at `store`; `None` if it is not Unicode.
fn noted(path: &Path, store: &Path) -> Option<PathBuf> {
    let whole = std::path::absolute(path).ok()?;
    let folder = std::path::absolute(store).ok()?.parent()?.to_owned();
    let noted = whole.strip_prefix(folder).ok().filter(|rest| rest.components().count() == 1);
    let noted = noted.map_or_else(|| whole.clone(), Path::to_path_buf);
    noted.to_str().is_some().then_some(noted)
}

/// The inverse of [`noted`].
fn resolved(noted: &Path, store: &Path) -> PathBuf {
    match store.parent() {
        Some(folder) if noted.is_relative() => folder.join(noted),
        _ => noted.to_owned(),
    }
}

impl Outputs {
    /// Adds the output files to the `note` of a checkpoint at `store`.
    pub(crate) fn note(&self, store: &Path, note: &mut Note) {
        let noted = |path: &Option<PathBuf>| path.as_deref().and_then(|path| noted(path, store));
        note.image = noted(&self.image);
        note.radius_image = noted(&self.radius_image);
        note.count_image = noted(&self.count_image);
        note.stats = noted(&self.stats);
        (note.exposure, note.tone, note.snapshots) = (self.exposure, self.tone, self.snapshots);
    }

    /// The output files in the `note` of a checkpoint at `store`.
    pub(crate) fn noted(note: &Note, store: &Path) -> Self {
        let there = |path: &Option<PathBuf>| path.as_deref().map(|path| resolved(path, store));
        Self {
            image: there(&note.image),
            stream: None,
            exposure: note.exposure,
            tone: note.tone,
            snapshots: note.snapshots,
            radius_image: there(&note.radius_image),
            count_image: there(&note.count_image),
            stats: there(&note.stats),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::EngineName;

    #[test]
    fn notes_of_earlier_versions_are_read() {
        let note = Note { exposure: Some(2.0), renderer: Some(MethodName::Path.into()), ..Note::default() };
        let text = serde_json::to_string(&note).unwrap();
        let renderer = |old: &str, sums| {
            let old = text.replace(r#""method":"path","engine":"fast""#, old);
            let read: Note = serde_json::from_str(&old).unwrap();
            assert_eq!(read.exposure, note.exposure, "{old}");
            read.renderer_of(sums)
        };
        let (fast, reference) = (EngineName::Fast.into(), EngineName::Reference.into());
        assert_eq!(renderer(r#""engine":"path""#, Sums::Paths), MethodName::Path.into());
        assert_eq!(renderer(r#""engine":"reference""#, Sums::Photons), reference);
        assert_eq!(renderer(r#""engine":null"#, Sums::Photons), fast);
        assert_eq!(renderer(r#""engine":null"#, Sums::Paths), MethodName::Path.into());
        // Sums decide, whatever the note says.
        assert_eq!(renderer(r#""method":"path","engine":"fast""#, Sums::Photons), fast);
    }

    #[test]
    fn files_move_with_their_checkpoint() {
        let there = Path::new("/a/b/x.sppm");
        for (path, as_noted, elsewhere) in [
            ("/a/b/x.png", "x.png", "/c/x.png"),
            ("/a/b/c/x.png", "/a/b/c/x.png", "/a/b/c/x.png"),
            ("/a/x.png", "/a/x.png", "/a/x.png"),
        ] {
            let note = noted(Path::new(path), there).unwrap();
            assert_eq!(note, Path::new(as_noted));
            assert_eq!(resolved(&note, there), Path::new(path));
            assert_eq!(resolved(&note, Path::new("/c/x.sppm")), Path::new(elsewhere));
        }
        assert_eq!(resolved(Path::new("x.png"), Path::new("x.sppm")), Path::new("x.png"));
    }

    /// A note is text. A file whose name is none is left out, and all else is kept.
    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_are_not_noted() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = std::ffi::OsStr::from_bytes(b"x\xff.png");
        let outputs = Outputs {
            image: Some(Path::new("/a/b").join(name)),
            stats: Some("/a/b/stats.json".into()),
            ..Outputs::default()
        };
        let mut note = Note::default();
        outputs.note(Path::new("/a/b/x.sppm"), &mut note);
        assert_eq!((note.image.as_deref(), note.stats.as_deref()), (None, Some(Path::new("stats.json"))));
        assert!(serde_json::to_string(&note).is_ok());
    }

    /// All that a render writes, and how, is what a resumed render writes unless it is told otherwise.
    #[test]
    fn outputs_come_back_from_their_note() {
        let there = Path::new("/a/b/x.sppm");
        let file = |name: &str| Some(PathBuf::from(name));
        let all = Outputs {
            image: file("/a/b/x.png"),
            stream: None,
            exposure: Some(-1.5),
            tone: Some(Tone::Reinhard { white: 3.0 }),
            snapshots: true,
            radius_image: file("/a/b/radius.pfm"),
            count_image: file("/c/count.pfm"),
            stats: file("/a/b/stats.json"),
        };
        let none = Outputs::default();
        let only_stats = Outputs { stats: all.stats.clone(), ..Outputs::default() };
        let only_count = Outputs { count_image: all.count_image.clone(), ..Outputs::default() };
        for outputs in [all, none, only_stats, only_count] {
            let mut note = Note::default();
            outputs.note(there, &mut note);
            let read: Note = serde_json::from_str(&serde_json::to_string(&note).unwrap()).unwrap();
            assert_eq!(read, note);
            assert_eq!(Outputs::noted(&read, there), outputs);
        }
    }
}
