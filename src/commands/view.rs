//! The command `view`: a page in the browser to render a scene and change it, or to look at an image.

use crate::args::engine::EngineArgs;
use crate::args::files::check_distinct;
use crate::args::messages::MessageArgs;
use crate::args::particles::{ParticleArgs, usual_renderer};
use crate::args::scene::{self, SceneName};
use crate::args::settings::{QualityArgs, SettingsArgs};
use crate::args::view::{DisplayArgs, PageArgs};
use crate::terminal::error::Error;
use crate::terminal::logs;
use crate::terminal::signals::Requests;
use ::render::Job;
use ::scene::settings::MAX_ITERATIONS;
use ::scene::text::{counted, mebibytes};
use ::scene::{Automatic, Scene};
use clap::{Args as ClapArgs, ValueHint};
use files::image_file::{self, Format, ImageReader};
use files::{atomic_file, builtin, named, paths};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;
use tracing::debug;
use view::{Legacy, Look, Project, View};

/// Render a scene in the browser and change it there, or look at an image
///
/// Prints the address of a page on this machine and opens it. The picture converges while you look; turn the camera, pick
/// balls, change materials and lamps, and save images, the scene and checkpoints. The page has help. Ctrl-C ends it: the image
/// is written if --output names a file, and a scene that was changed and not saved is written beside it.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = VIEW_EXAMPLES)]
pub(crate) struct ViewArgs {
    /// A built-in scene (see `sppm scenes`), a scene file ending in .toml, a file of molecules or particles, - for standard
    /// input, or an image file
    #[arg(value_name = "SCENE|IMAGE", value_parser = SceneName, hide_possible_values = true)]
    pub target: OsString,

    /// An image to compare with: the page shows it beside, and the difference
    #[arg(long, value_name = "IMAGE", value_hint = ValueHint::FilePath)]
    pub reference: Option<PathBuf>,

    /// The layer to show of an EXR file that has layers [default: the page lists all]
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,

    /// Write the image here when the view ends
    #[arg(short, long, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub page: PageArgs,

    #[command(flatten)]
    pub display: DisplayArgs,

    #[command(flatten)]
    pub particles: ParticleArgs,

    #[command(flatten)]
    pub settings: SettingsArgs,

    #[command(flatten)]
    pub quality: QualityArgs,

    #[command(flatten)]
    pub engine: EngineArgs,

    #[command(flatten)]
    pub messages: MessageArgs,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  sppm view cornell
  sppm view mine.toml --threads 2 --reference truth.exr
  sppm view mine.toml --quality final
  sppm view beauty.exr
  sppm view cornell --no-open --port 8000     over ssh -L 8000:localhost:8000
  sppm view cornell --display localhost:14158";

/// How often it is looked whether a signal came.
const TICK: Duration = Duration::from_millis(50);

/// Runs the command.
pub(crate) fn run(args: &ViewArgs) -> Result<(), Error> {
    logs::init(args.messages.log_format, args.messages.level());
    if is_image(&args.target) { show(args) } else { edit(args) }
}

/// Serves two images to be compared, each with the layer to show of it.
pub(crate) fn compare(
    a: (&Path, Option<&str>),
    b: (&Path, Option<&str>),
    page: &PageArgs,
) -> Result<(), Error> {
    let requests = Requests::listen()?;
    let view = View::compared(a, b, &page.place()).map_err(Error::BadInput)?;
    page.announce(&view, false)?;
    wait(&requests);
    Err(interrupted(&requests, "the view is closed".into()))
}

/// Whether `target` names an image file. What does not exist is left to be looked for as a scene.
fn is_image(target: &OsStr) -> bool {
    let path = Path::new(target);
    let is_scene = target == "-" || target.to_str().is_some_and(|name| builtin::find(name).is_some());
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let has_extension = Format::from_path(path).is_ok();
    let is_particles = named::is_particles(target);
    !is_scene
        && !is_toml
        && !is_particles
        && (has_extension || (path.is_file() && ImageReader::open(path, None).is_ok()))
}

fn show(args: &ViewArgs) -> Result<(), Error> {
    if args.output.is_some() {
        return Err(Error::BadInput(
            "--output: an image is only looked at; name a scene to render one".into(),
        ));
    }
    let requests = Requests::listen()?;
    let (path, reference) = (Path::new(&args.target), args.reference.as_deref());
    let view =
        View::files(path, args.layer.as_deref(), reference, &args.page.place()).map_err(Error::BadInput)?;
    args.page.announce(&view, false)?;
    if let Some(display) = args.display.start(&path.to_string_lossy())? {
        display.show(image_file::read(path).map_err(|error| Error::BadInput(error.to_string()))?);
    }
    wait(&requests);
    Err(interrupted(&requests, "the view is closed".into()))
}

fn edit(args: &ViewArgs) -> Result<(), Error> {
    if args.layer.is_some() {
        return Err(Error::BadInput("--layer: only image files have layers by name".into()));
    }
    let (size, most) = ([args.settings.width, args.settings.height], args.engine.memory_limit);
    let opened = scene::open(&args.target, &args.particles, size, most.unwrap_or(u64::MAX))?;
    check(args, opened.file.as_deref())?;
    let (own, automatic) = args.quality.apply(&opened.scene.settings, opened.automatic);
    let settings = args.settings.apply(&own)?;
    let text = text_of(opened.file.as_deref(), &opened.stem);
    let engine = args.engine.choose(usual_renderer(opened.is_staged, &opened.scene))?;
    let automatic = endless(args.settings.automatic(automatic));
    let mut job = Job::new(Scene { settings, ..opened.scene }).choosing(automatic);
    (job.engine, job.threads, job.memory_limit) = (engine, args.engine.threads, args.engine.memory_limit);
    job.choose_settings()?;
    let (of_render, of_page) = (job.bytes_at_most()?, view::bytes_at_most(&job.scene));
    debug!("up to {} for the render, and {} for the page", mebibytes(of_render), mebibytes(of_page));
    let project = Project {
        scene: job.scene,
        text,
        stem: opened.stem.to_string_lossy().into_owned(),
        engine,
        threads: args.engine.threads,
        memory_limit: args.engine.memory_limit,
        limit: limit(args.settings.given_iterations()),
    };
    let name = project.stem.clone();
    let requests = Requests::listen()?;
    let display = args.display.start(&name)?;
    let view = View::studio(project, args.reference.as_deref(), display, &args.page.place());
    let view = view.map_err(Error::BadInput)?;
    args.page.announce(&view, false)?;
    wait(&requests);
    let what = match view.end() {
        Some(legacy) => write(args, &legacy, &name)?,
        None => "the view broke down; this is a fault of sppm, please report it".into(),
    };
    Err(interrupted(&requests, what))
}

/// The text of the scene file, or of the built-in scene `stem`, which keeps its comments when the page changes it.
fn text_of(file: Option<&Path>, stem: &OsStr) -> Option<String> {
    match file {
        // Such a file is no scene file, and may be of any size.
        Some(file) if named::is_particles(file.as_os_str()) => None,
        Some(file) => fs::read_to_string(file).ok(),
        None => stem.to_str().and_then(builtin::find).map(|builtin| builtin.text.to_owned()),
    }
}

/// What is chosen of a render that goes on for as long as it is looked at, and whose first picture must not have to wait: neither
/// for pilots nor, among many spheres, for what is near each pixel, which every change of the view asks for anew.
fn endless(automatic: Automatic) -> Automatic {
    Automatic { iterations: false, radius_pilots: false, radius_clearance: false, ..automatic }
}

/// The iterations after which it ends; `None` if there is no end, as where so many are given that there can be no more.
fn limit(given: Option<u32>) -> Option<u32> {
    given.filter(|iterations| *iterations != MAX_ITERATIONS)
}

fn check(args: &ViewArgs, scene: Option<&Path>) -> Result<(), Error> {
    let Some(output) = &args.output else { return Ok(()) };
    let inputs = [("the scene", scene), ("--reference", args.reference.as_deref())];
    let inputs: Vec<_> = inputs.into_iter().filter_map(|(name, path)| Some((name, path?))).collect();
    check_distinct(&inputs, &[("--output", output)])?;
    image_file::check_writable(output).map_err(|error| Error::BadInput(format!("--output: {error}")))
}

/// Writes what the studio left: the image, if a file is named for it, and a scene that is changed and not saved.
fn write(args: &ViewArgs, legacy: &Legacy, name: &str) -> Result<String, Error> {
    let Some(kept) = &legacy.kept else {
        return Ok("not one iteration was over, so nothing is written".into());
    };
    let image = args.output.as_ref().map(|output| {
        kept.write_image(output, Look::default())?;
        let done = counted(kept.iterations, "iteration");
        Ok(format!("wrote {} after {done}", output.display()))
    });
    let scene = legacy.is_unsaved.then(|| {
        let path = unused(args.output.as_deref(), name)?;
        let wrote = atomic_file::replace(&path, |out| out.write_all(kept.text.as_bytes()));
        wrote.map_err(|error| error.to_string())?;
        Ok(format!("the changed scene is in {}", path.display()))
    });
    // Where one cannot be written, the other is not lost.
    let all: Vec<Result<String, String>> = [image, scene].into_iter().flatten().collect();
    let is_all_written = all.iter().all(Result::is_ok);
    let told =
        all.into_iter().map(|one| one.unwrap_or_else(|problem| problem)).collect::<Vec<_>>().join("; ");
    match (told.is_empty(), is_all_written) {
        (true, _) => Ok("the view is closed".into()),
        (false, true) => Ok(told),
        (false, false) => Err(Error::Failed(told)),
    }
}

/// A name for the changed scene that no file has, beside the image if there is one.
fn unused(output: Option<&Path>, name: &str) -> Result<PathBuf, String> {
    /// More changed scenes are not written side by side.
    const MOST: u32 = 1000;
    let beside = output.map_or(PathBuf::from(name), |output| output.with_extension(""));
    let named = |n: u32| match n {
        1 => paths::around(&beside, "", "-edited.toml"),
        n => paths::around(&beside, "", &format!("-edited-{n}.toml")),
    };
    let problem = || format!("{}: there are {MOST} of them; remove some", named(1).display());
    (1..=MOST).map(named).find(|path| !path.exists()).ok_or_else(problem)
}

/// Waits until a signal asks for the end.
fn wait(requests: &Requests) {
    while !requests.stop().is_requested() {
        thread::sleep(TICK);
    }
}

fn interrupted(requests: &Requests, what: String) -> Error {
    match requests.pending() {
        Some(signal) => Error::Interrupted(signal, what),
        None => Error::Failed(what),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::scene::Film;

    #[test]
    fn images_are_told_from_scenes_by_their_names_or_content() {
        let folder = tempfile::tempdir().unwrap();
        let image = folder.path().join("a.png");
        image_file::write(&image, &Film::new(1, 1), &image_file::Encoding::default()).unwrap();
        let of = |name: &str, from: Option<&Path>| {
            let path = folder.path().join(name);
            from.map(|from| fs::copy(from, &path).unwrap());
            is_image(path.as_os_str())
        };
        // What is named as an image is one, whether it is there or not; others if they are.
        assert!(of("b.png", Some(&image)) && of("none.exr", None));
        assert!(of("image", Some(&image)) && !of("none", None));
        fs::write(folder.path().join("text"), "text").unwrap();
        assert!(!of("text", None));
        // Scenes, whatever they hold.
        assert!(!of("a.toml", Some(&image)) && !of("B.TOML", None) && !of("a.xyz", Some(&image)));
        assert!(!is_image("-".as_ref()) && !is_image("cornell".as_ref()));
    }

    /// It is written when the view ends, long after both have been read.
    #[test]
    fn the_image_replaces_neither_the_scene_nor_what_it_is_compared_with() {
        use crate::commands::{Args, Command};
        use clap::Parser as _;
        let words = ["sppm", "view", "a.toml", "--reference", "a.exr", "-o"];
        let of = |output: &str| {
            let args = Args::try_parse_from(words.iter().chain(&[output])).unwrap();
            let Command::View(args) = args.command else { panic!("another command") };
            check(&args, Some(Path::new("a.toml"))).map_err(|error| error.to_string())
        };
        let is_also =
            |output: &str, what: &str| Err(format!("--output: {output} is also {what}; name another file"));
        assert_eq!(of("a.exr"), is_also("a.exr", "--reference"));
        assert_eq!(of("a.toml"), is_also("a.toml", "the scene"));
        assert_eq!(of("b.exr"), Ok(()));
    }

    #[test]
    fn scene_files_and_built_in_scenes_have_a_text_to_change() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str| {
            let path = folder.path().join(name);
            fs::write(&path, "# a comment").unwrap();
            text_of(Some(&path), "cornell".as_ref())
        };
        assert_eq!([of("a.toml"), of("a.xyz")], [Some("# a comment".into()), None]);
        let cornell = builtin::find("cornell").unwrap();
        assert_eq!(text_of(None, "cornell".as_ref()).as_deref(), Some(cornell.text));
        assert_eq!(text_of(None, "stdin".as_ref()), None);
    }

    #[test]
    fn a_view_goes_on_unless_it_is_told_when_to_end() {
        assert_eq!([None, Some(MAX_ITERATIONS)].map(limit), [None; 2]);
        let ends = [Some(1), Some(MAX_ITERATIONS - 1)];
        assert_eq!(ends.map(limit), ends);
        let all = Automatic::all(::scene::Quality::Final);
        let (iterations, radius_pilots, radius_clearance) = (false, false, false);
        assert_eq!(endless(all), Automatic { iterations, radius_pilots, radius_clearance, ..all });
    }

    /// Beside the image, or in the current folder, and never over another.
    #[test]
    fn a_changed_scene_gets_a_name_that_no_file_has() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.png");
        let next = || unused(Some(&output), "b").unwrap();
        for name in ["a-edited.toml", "a-edited-2.toml", "a-edited-3.toml"] {
            assert_eq!(next(), folder.path().join(name));
            fs::write(next(), "").unwrap();
        }
        assert_eq!(unused(None, "no such scene").unwrap(), Path::new("no such scene-edited.toml"));
    }
}
