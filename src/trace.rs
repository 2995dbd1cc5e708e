//! The command `trace`.

use crate::args::TraceArgs;
use crate::engines::Chosen;
use crate::error::Error;
use crate::outputs::check_distinct;
use crate::{scenes, threads};
use files::{atomic_file, npy};

/// Traces the rays of one file and writes what they hit into another.
pub(crate) fn trace(args: &TraceArgs) -> Result<(), Error> {
    let opened = scenes::open(&args.scene.name)?;
    let time = opened.instant(args.time)?;
    let engine = Chosen::new(args.engine.into(), args.lanes)?;
    let bad =
        |option: &str, error: &dyn ToString| Error::BadInput(format!("{option}: {}", error.to_string()));
    if args.hits.extension().is_none_or(|e| e != "npy") {
        return Err(bad("--hits", &format!("{} does not end in .npy", args.hits.display())));
    }
    let scene_file = opened.file.as_deref().map(|path| ("the scene", path));
    let inputs: Vec<_> = scene_file.into_iter().chain([("--rays", args.rays.as_path())]).collect();
    check_distinct(&inputs, &[("--hits", &args.hits)])?;
    atomic_file::check(&args.hits).map_err(|error| bad("--hits", &error))?;
    let rays = npy::read(&args.rays).map_err(|error| bad("--rays", &error))?;
    threads::start(args.machine.threads)?;
    let still = opened.scene.at(time);
    let hits = engine.surfaces(&still, &rays);
    npy::write(&args.hits, &hits).map_err(|error| Error::Failed(error.to_string()))
}
