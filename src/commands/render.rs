//! The command `render`: renders a scene and writes the files asked for.

use super::watch;
use crate::args::engine::EngineArgs;
use crate::args::goals::{CheckpointArgs, GoalArgs};
use crate::args::messages::MessageArgs;
use crate::args::outputs::{OutputArgs, default_name, default_name_of};
use crate::args::part::PartArgs;
use crate::args::particles::usual_renderer;
use crate::args::scene::{self, SourceArgs};
use crate::args::settings::{QualityArgs, SettingsArgs};
use crate::args::view::WatchArgs;
use crate::terminal::error::Error;
use crate::terminal::signals::Requests;
use ::render::merge::is_checkpoint;
use ::render::{EngineChoice, Field, Goals, Job, Outputs, Save};
use ::scene::Settings;
use clap::Args as ClapArgs;
use files::image_file::Tone;
use files::named::{self, Opened};
use std::path::{Path, PathBuf};

/// Render a scene to an image file
///
/// Ctrl-C (SIGTERM, SIGHUP) writes a checkpoint and the image as it stands after the last whole iteration, says so, and
/// exits with 130 (143, 129); a second one exits at once, and tears no file.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = RENDER_EXAMPLES)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub source: SourceArgs,

    #[command(flatten)]
    pub outputs: OutputArgs,

    #[command(flatten)]
    pub quality: QualityArgs,

    #[command(flatten)]
    pub settings: SettingsArgs,

    #[command(flatten)]
    pub goals: GoalArgs,

    #[command(flatten)]
    pub checkpoints: CheckpointArgs,

    #[command(flatten)]
    pub part: PartArgs,

    #[command(flatten)]
    pub engine: EngineArgs,

    #[command(flatten)]
    pub viewers: WatchArgs,

    #[command(flatten)]
    pub messages: MessageArgs,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  sppm render cornell
  sppm render mirror -o mirror.exr --width 1024 --height 768 --iterations 200
  sppm render surgery --depth 64 --radius 1 --photons 1000000 --stats surgery.json
  sppm render cornell --method path --iterations 1024 -o truth.exr
  sppm render surgery --time 10m --until-error 0.02
  sppm render --like mirror.exr -o again.exr
  sppm render - -o exr:- < mine.toml > mine.exr
  sppm render surgery -n 4096 --radius-schedule global --part 3/64 -o part3.sppm
  sppm render water.pdb --view iso --ground
  sppm render melt.dump --frame 0..100:10 -o melt-{frame}.png
  sppm render melt.dump --frame last --color molecule --style 'z > 30: hide' --width 1600 --height 1200

What settings do:
  More iterations remove noise and bias both. A smaller first radius means less blur and more noise.
  A depth of 5, the paper's, is quick and makes closed rooms 6 to 13 % too dark; 64 is as good as all of it.
  Lengths are in the scene's own unit; radiance is linear, in W sr^-1 m^-2 per channel.";

/// Runs the command for one image.
pub(crate) fn run(args: &RenderArgs) -> Result<(), Error> {
    let size = [args.settings.width, args.settings.height];
    let (job, image) = open(&args.source, size, args.engine.memory_limit)?;
    let job = configure(args, job, image, (&args.outputs, &args.checkpoints))?;
    let has_page = args.source.particles.asks_for_a_page();
    watch::run(job, None, &args.messages, (&args.viewers, has_page), &Requests::listen()?)
}

/// The job as options ask for it; `image` is the default name of its image.
pub(super) fn configure(
    args: &RenderArgs,
    mut job: Job,
    image: PathBuf,
    (outputs, checkpoints): (&OutputArgs, &CheckpointArgs),
) -> Result<Job, Error> {
    job.goals = args.goals.or(Goals::default());
    let (own, automatic) = args.quality.apply(&job.scene.settings, job.automatic);
    let settings = args.settings.apply(&own)?;
    let given = args.settings.given_iterations();
    let iterations = job.goals.iterations(given, settings.iterations);
    job.scene.settings = Settings { iterations, ..settings };
    job.automatic = args.settings.automatic(automatic);
    job.automatic.iterations &= !job.goals.are_open();
    job.automatic.method &= !args.engine.states_method();
    job.engine = args.engine.choose(job.engine.renderer())?;
    job.inputs.extend(args.engine.profile.clone().map(|path| (Field::Profile, path)));
    (job.threads, job.memory_limit) = (args.engine.threads, args.engine.memory_limit);
    if let Some(field) = args.part.field() {
        job.check_parts(field)?;
        // Which iterations a part has depends on how many there are.
        job.choose_settings()?;
        job.range = args.part.range(job.scene.settings.iterations)?;
        let path = part_file(args, &image)?;
        job.save = Some(Save { path, every: args.checkpoints.every.unwrap_or_default(), keep: true });
        job.outputs = Outputs { stats: args.outputs.stats.clone(), ..Outputs::default() };
    } else {
        job.outputs = outputs.or(job.outputs, image)?;
        job.save = checkpoints.save(job.outputs.image.as_deref());
    }
    Ok(job)
}

/// The checkpoint that a part is written to; `image` is the default name of the whole image.
fn part_file(args: &RenderArgs, image: &Path) -> Result<PathBuf, Error> {
    let OutputArgs { output, exposure, tone, white, snapshots, radius_image, count_image, .. } =
        &args.outputs;
    let CheckpointArgs { checkpoint, no_checkpoint, .. } = &args.checkpoints;
    let others = [
        ("--exposure", exposure.is_some()),
        ("--tone", tone.is_some()),
        ("--white", white.is_some()),
        ("--snapshots", *snapshots),
        ("--radius-image", radius_image.is_some()),
        ("--count-image", count_image.is_some()),
        ("--checkpoint", checkpoint.is_some()),
        ("--no-checkpoint", *no_checkpoint),
    ];
    if let Some((option, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
        let problem = "a part is no image, but the checkpoint that --output names; leave out this option";
        return Err(Error::BadInput(format!("{option}: {problem}")));
    }
    let path = output.clone().unwrap_or_else(|| image.with_extension(format!("{}.sppm", args.part.name())));
    if is_checkpoint(&path) {
        return Ok(path);
    }
    let problem = "a part is no image, but a checkpoint for `sppm merge`; name a file that ends in .sppm";
    Err(Error::BadInput(format!("--output: {}: {problem}", path.display())))
}

/// The job for a scene.
pub(super) fn job_of(Opened { scene, automatic, is_staged, bytes, file, .. }: Opened) -> Result<Job, Error> {
    let engine = EngineChoice::new(usual_renderer(is_staged, &scene), None)?;
    let mut job = Job::new(scene).choosing(automatic);
    (job.engine, job.bytes_before) = (engine, bytes);
    job.inputs.extend(file.map(|file| (Field::Scene, file)));
    if is_staged {
        // Backgrounds are to have the colour that is asked for, and lamps are such that nothing is brighter than white.
        job.outputs.tone = Some(Tone::Clamp);
    }
    Ok(job)
}

/// The file of particles that is named in place of a scene, if it is one.
pub(super) fn particles(args: &SourceArgs) -> Option<&Path> {
    args.scene.as_deref().filter(|name| named::is_particles(name)).map(Path::new)
}

/// The job for a scene, or for repeating the render of `--like`; and the default name of its image.
fn open(
    args: &SourceArgs,
    size: [Option<u32>; 2],
    memory_limit: Option<u64>,
) -> Result<(Job, PathBuf), Error> {
    let most = memory_limit.unwrap_or(u64::MAX);
    let particles = particles(args);
    if let Some(like) = &args.like
        && (particles.is_some() || args.scene.is_none())
    {
        // What is recorded says how particles are shown; a file of them is named to be found.
        args.particles.refuse("what --like repeats")?;
        let folder = particles.and_then(Path::parent);
        let job = Job::like_in(like, None, folder)?;
        let image = default_name_of(&job.scene.name);
        return Ok((job, image));
    }
    let open = |name| scene::open(name, &args.particles, size, most);
    let named = args.scene.as_deref().map(open).transpose()?;
    let stem = named.as_ref().map(|named| default_name(&named.stem));
    let job = match (&args.like, named) {
        (Some(like), named) => {
            let bytes_before = named.as_ref().map_or(0, |named| named.bytes);
            let file = named.as_ref().and_then(|named| named.file.clone()).map(|file| (Field::Scene, file));
            let mut job = Job::like(like, named.map(|named| named.scene))?;
            job.inputs.splice(0..0, file);
            job.bytes_before = bytes_before;
            job
        }
        (None, Some(named)) => job_of(named)?,
        (None, None) => return Err(Error::BadInput("<SCENE> is missing".into())), // clap requires one of the two
    };
    let image = stem.unwrap_or_else(|| default_name_of(&job.scene.name));
    Ok((job, image))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::scene::{Automatic, Quality};

    fn job(words: &[&str]) -> Result<Job, String> {
        use crate::commands::{Args, Command};
        use clap::Parser as _;
        let words = ["sppm", "render"].iter().chain(words);
        let Command::Render(args) = Args::try_parse_from(words).unwrap().command else {
            panic!("another command")
        };
        let (job, image) = open(&args.source, [None; 2], None).map_err(|error| error.to_string())?;
        configure(&args, job, image, (&args.outputs, &args.checkpoints)).map_err(|error| error.to_string())
    }

    #[test]
    fn a_job_is_as_options_ask_for_it() {
        let usual = job(&["cornell"]).unwrap();
        assert_eq!(usual.outputs, Outputs { image: Some("cornell.png".into()), ..Outputs::default() });
        assert_eq!(usual.save, Some(Save::beside(Path::new("cornell.png"))));
        assert_eq!((usual.threads, usual.memory_limit, usual.range.clone()), (None, None, None));
        assert!(usual.automatic.iterations && usual.goals == Goals::default() && usual.inputs.is_empty());
        let own = usual.scene.settings;
        let fixed =
            job(&["cornell", "-n", "7", "--threads", "2", "--memory-limit", "1G", "--engine", "reference"])
                .unwrap();
        assert_eq!(fixed.scene.settings, Settings { iterations: 7, ..own });
        assert!(!fixed.automatic.iterations && fixed.automatic.max_depth);
        assert_eq!((fixed.threads, fixed.memory_limit), (Some(2), Some(1 << 30)));
        assert_eq!(fixed.engine.name(), ::render::EngineName::Reference);
    }

    /// A goal leaves the iterations open, unless they are given.
    #[test]
    fn goals_take_the_place_of_iterations() {
        use ::scene::settings::MAX_ITERATIONS;
        for goal in [["--time", "3s"], ["--until-error", "0.1"]] {
            let open = job(&[&["cornell"], &goal[..]].concat()).unwrap();
            assert_eq!((open.scene.settings.iterations, open.automatic.iterations), (MAX_ITERATIONS, false));
            assert!(open.goals.are_open() && open.automatic.photons_per_iteration);
            let both = job(&[&["cornell", "-n", "9"], &goal[..]].concat()).unwrap();
            assert_eq!(both.scene.settings.iterations, 9);
        }
    }

    /// A scene file, and the image of a render of it by [`Quality::Paper`], in this folder.
    fn rendered(folder: &Path) -> [String; 2] {
        let [scene, image] =
            ["mine.toml", "a.exr"].map(|name| folder.join(name).to_str().unwrap().to_owned());
        std::fs::write(&scene, files::builtin::find("cornell").unwrap().text).unwrap();
        let size = ["--width", "8", "--height", "6", "-n", "1", "--photons", "100", "--quality", "paper"];
        let words = [&[&scene[..], "-o", &image, "--no-checkpoint"], &size[..]].concat();
        let outcome = job(&words).unwrap().start(()).unwrap().wait().unwrap();
        assert_eq!(outcome.written, [Path::new(&image)]);
        [scene, image]
    }

    /// What is recorded leaves nothing to be chosen; whoever asks for a quality gets that one all the same.
    #[test]
    fn a_render_is_repeated_at_the_quality_that_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let [_, image] = rendered(folder.path());
        let chosen = |words: &[&str]| job(&[&["--like", &image], words].concat()).unwrap().automatic;
        assert!(!chosen(&[]).any());
        assert_eq!(chosen(&["--quality", "draft"]), Automatic::all(Quality::Draft));
        let by_radius = chosen(&["--radius", "auto"]);
        assert!(by_radius.initial_radius && !by_radius.iterations, "{by_radius:?}");
    }

    /// Of a scene that is rendered, and of one that is named beside what is repeated.
    #[test]
    fn the_memory_that_a_scene_took_to_read_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, image] = rendered(folder.path());
        let bytes = |words: &[&str]| job(words).unwrap().bytes_before;
        let own = bytes(&[&scene]);
        assert!(own > 0);
        assert_eq!([bytes(&[&scene, "--like", &image]), bytes(&["--like", &image])], [own, 0]);
    }

    const PART: [&str; 8] =
        ["cornell", "--quality", "paper", "-n", "8", "--radius-schedule", "global", "--part"];

    #[test]
    fn a_part_is_kept_as_a_checkpoint_of_its_own_name() {
        let part = job(&[&PART[..], &["2/4"]].concat()).unwrap();
        assert_eq!((part.range, part.outputs), (Some(2..4), Outputs::default()));
        let save = part.save.unwrap();
        assert_eq!((save.path.as_path(), save.keep), (Path::new("cornell.2-of-4.sppm"), true));
        let named = job(&[&PART[..], &["2/4", "-o", "a.sppm", "--every", "3", "--stats", "b.json"]].concat())
            .unwrap();
        let expected = Save { path: "a.sppm".into(), every: ::render::Every::Iterations(3), keep: true };
        assert_eq!((named.save, named.outputs.stats), (Some(expected), Some("b.json".into())));
    }

    #[test]
    fn what_does_not_go_with_a_part_is_refused() {
        for option in [
            &["--exposure", "1"][..],
            &["--tone", "aces"],
            &["--white", "2"],
            &["--snapshots"],
            &["--radius-image", "a.exr"],
            &["--count-image", "a.exr"],
            &["--checkpoint", "a.sppm"],
            &["--no-checkpoint"],
        ] {
            let problem = job(&[&PART[..], &["2/4"], option].concat()).unwrap_err();
            let start = format!("{}: a part is no image, but the checkpoint that --output names", option[0]);
            assert!(problem.starts_with(&start), "{problem}");
        }
        let problem = job(&[&PART[..], &["2/4", "-o", "a.png"]].concat()).unwrap_err();
        assert!(problem.starts_with("--output: a.png: a part is no image, but a checkpoint"), "{problem}");
        let problem = job(&["cornell", "--quality", "paper", "-n", "8", "--part", "2/4"]).unwrap_err();
        assert!(problem.starts_with("--part: iterations are independent"), "{problem}");
    }
}
