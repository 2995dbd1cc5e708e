//! The command `render`.

use crate::args::{RenderArgs, SettingsArgs, SourceArgs};
use crate::budget::Goals;
use crate::checkpoints::{Note, Plan};
use crate::engines::{Chosen, EngineName};
use crate::error::Error;
use crate::job::Job;
use crate::like::{self, Like};
use crate::outputs::{Outputs, default_name};
use crate::scenes::{self, Opened};
use crate::{logs, outputs};
use files::checkpoint::Loaded;
use files::scene_file;
use scene::{Scene, Settings};
use std::path::Path;

/// Renders a scene and writes the files that were asked for.
pub(crate) fn render(args: &RenderArgs) -> Result<(), Error> {
    logs::init(&args.messages);
    let (opened, like) = open(&args.source)?;
    let goals = Goals::from(&args.goals);
    let settings = settings(&args.settings, &opened, &goals)?;
    let scene = Scene { settings, ..opened.scene };
    let engine = args.engine.engine.or(like.as_ref().map(|like| like.engine)).unwrap_or(EngineName::Fast);
    let engine = Chosen::from_args(engine, &args.engine)?;
    let mut inputs = Vec::new();
    inputs.extend(opened.file.as_deref().map(|path| ("the scene", path)));
    inputs.extend(args.source.like.as_deref().map(|path| ("--like", path)));
    inputs.extend(args.engine.profile.as_deref().map(|path| ("--profile", path)));
    let exposure = like.and_then(|like| like.exposure);
    let usual = Note { exposure, ..Note::default() };
    let image = default_name(&opened.stem);
    let outputs = Outputs::new(&args.outputs, usual, image, engine.name(), &inputs)?;
    check_checkpoint(args, &outputs, &inputs)?;
    let plan = Plan::new(&args.checkpoints, outputs.image())?;
    let from = found(plan.as_ref(), &scene, engine.name())?;
    let threads = args.engine.threads;
    let memory_limit = args.engine.memory_limit;
    Job { scene, engine, threads, memory_limit, outputs, goals, plan, from }.run(&args.messages)
}

/// The scene, and the render that is to be repeated.
fn open(args: &SourceArgs) -> Result<(Opened, Option<Like>), Error> {
    let like = args.like.as_deref().map(like::read).transpose()?;
    let named = args.scene.as_ref().map(scenes::open).transpose()?;
    let Some(mut like) = like else {
        return match named {
            Some(opened) => Ok((opened, None)),
            None => Err(Error::BadInput("<SCENE> is missing".into())), // never so: the parser has seen to it
        };
    };
    let opened = like.open(named, args.like.as_deref().unwrap_or(Path::new("")))?;
    Ok((opened, Some(like)))
}

fn settings(args: &SettingsArgs, opened: &Opened, goals: &Goals) -> Result<Settings, Error> {
    let settings = args.apply(opened)?;
    Ok(Settings { iterations: goals.iterations(args.iterations, settings.iterations), ..settings })
}

/// A checkpoint is neither read nor written as something else.
fn check_checkpoint(args: &RenderArgs, outputs: &Outputs, inputs: &[outputs::Named]) -> Result<(), Error> {
    match args.checkpoints.checkpoint.as_deref() {
        Some(path) => {
            let taken: Vec<_> = inputs.iter().copied().chain(outputs.named()).collect();
            outputs::check_distinct(&taken, &[("--checkpoint", path)])
        }
        None => Ok(()),
    }
}

/// The checkpoint that is there, if it is one of this very render; another is not overwritten.
fn found(plan: Option<&Plan>, scene: &Scene, engine: EngineName) -> Result<Option<Loaded>, Error> {
    let Some(plan) = plan else { return Ok(None) };
    let or_else = "remove it, or name another by --checkpoint";
    let loaded = plan.store.load().map_err(|error| Error::BadInput(format!("{error}; {or_else}")))?;
    let Some(loaded) = loaded else { return Ok(None) };
    let there = &loaded.checkpoint;
    let other = |what: String| {
        let (path, done) = (plan.store.path().display(), there.account.iterations);
        let text =
            format!("{path} holds {done} iterations of {what}; continue it by `sppm resume`, {or_else}");
        Err(Error::BadInput(text))
    };
    let iterations = scene.settings.iterations;
    if scene_file::digest(scene) != there.account.scene {
        return other(format!("another scene, {}", there.scene.name));
    }
    if there.account.sums != engine.sums() {
        return other(there.account.sums.to_string());
    }
    if (Settings { iterations, ..there.scene.settings }) != scene.settings {
        return other("other settings".into());
    }
    if there.account.iterations > iterations {
        return other(format!("this render, more than {iterations}"));
    }
    if loaded.fallback.is_some() {
        plan.store.fall_back().map_err(|error| Error::Failed(error.to_string()))?;
    }
    Ok(Some(loaded))
}
