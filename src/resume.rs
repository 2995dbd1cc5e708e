//! The command `resume`.

use crate::args::ResumeArgs;
use crate::budget::Goals;
use crate::checkpoints::{Note, Plan, resolved};
use crate::engines::{Chosen, EngineName};
use crate::error::Error;
use crate::job::Job;
use crate::logs;
use crate::outputs::{Outputs, default_name};
use files::checkpoint::{Loaded, Store};
use scene::settings::MAX_ITERATIONS;
use scene::{Scene, Settings};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Goes on with a render from its checkpoint.
pub(crate) fn resume(args: &ResumeArgs) -> Result<(), Error> {
    logs::init(&args.messages);
    let bad = |error: &dyn ToString| Error::BadInput(error.to_string());
    let store = Store::new(&args.file);
    let missing = || Error::BadInput(format!("{}: there is no such file", args.file.display()));
    if !store.exists() {
        return Err(missing());
    }
    let lock = store.lock().map_err(|error| bad(&error))?;
    let loaded = store.load().map_err(|error| bad(&error))?.ok_or_else(missing)?;
    let note = Note::of(&loaded);
    let goals = Goals { time: args.goals.time, error: args.goals.until_error.or(note.until_error) };
    let settings = settings(args, &loaded)?;
    let engine = engine(args, &loaded, &note)?;
    let plan = Plan { every: args.every.unwrap_or(note.every), keep: note.keep, store, lock: Some(lock) };
    let outputs = outputs(args, note, &loaded, engine.name())?;
    if loaded.fallback.is_some() {
        plan.store.fall_back().map_err(|error| Error::Failed(error.to_string()))?;
    }
    let scene = Scene { settings, ..loaded.checkpoint.scene.clone() };
    let (threads, memory_limit) = (args.engine.threads, args.engine.memory_limit);
    Job { scene, engine, threads, memory_limit, outputs, goals, plan: Some(plan), from: Some(loaded) }
        .run(&args.messages)
}

/// The settings of the render, with as many iterations as are asked for now.
fn settings(args: &ResumeArgs, loaded: &Loaded) -> Result<Settings, Error> {
    let settings = loaded.checkpoint.scene.settings;
    let done = loaded.checkpoint.account.iterations;
    let iterations = match args.iterations {
        Some(asked) if asked < done => {
            let path = loaded.path.display();
            return Err(Error::BadInput(format!(
                "--iterations {asked}: {path} holds {done} already; ask for at least as many"
            )));
        }
        Some(asked) => asked,
        // More time for what was done is time for more.
        None if done >= settings.iterations
            && (args.goals.time.is_some() || args.goals.until_error.is_some()) =>
        {
            MAX_ITERATIONS
        }
        None => settings.iterations,
    };
    Ok(Settings { iterations, ..settings })
}

/// The engine that was asked for, or the one that rendered last.
fn engine(args: &ResumeArgs, loaded: &Loaded, note: &Note) -> Result<Chosen, Error> {
    let sums = loaded.checkpoint.account.sums;
    let usual = note.engine.filter(|engine| engine.sums() == sums).unwrap_or(EngineName::of(sums));
    let name = args.engine.engine.unwrap_or(usual);
    if name.sums() != sums {
        let (name, path) = (name.name(), loaded.path.display());
        return Err(Error::BadInput(format!(
            "--engine {name}: {path} is of {sums}, and goes on by {} alone",
            EngineName::all_of(sums)
        )));
    }
    Chosen::from_args(name, &args.engine)
}

/// The files of the render, as it was asked for and as it is now.
fn outputs(args: &ResumeArgs, note: Note, loaded: &Loaded, engine: EngineName) -> Result<Outputs, Error> {
    let there = |path: Option<PathBuf>| path.map(|path| resolved(&path, &args.file));
    let usual = Note {
        image: there(note.image),
        radius_image: there(note.radius_image),
        count_image: there(note.count_image),
        stats: there(note.stats),
        ..note
    };
    let stem = loaded.checkpoint.scene.name.replace(['/', '\\'], "-");
    let image = args.file.with_file_name(default_name(OsStr::new(&stem)));
    Outputs::new(&args.outputs, usual, image, engine, &[("the checkpoint", &args.file)])
}
