//! The command `trace`: intersects rays from a file with a scene, and writes what they hit.

use crate::args::engine::MachineArgs;
use crate::args::files::check_distinct;
use crate::args::scene::{SceneArg, instant};
use crate::args::values::number;
use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use clap::{Args as ClapArgs, ValueEnum};
use files::{atomic_file, npy};
use render::{EngineChoice, EngineName, LanesName};
use std::path::PathBuf;

/// An engine whose intersections can be asked for by themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tracer {
    /// The fast engine's, on vectors
    Fast,
    /// The reference's, one ray at a time
    Reference,
}

/// Tell what rays hit, from and into npy files
///
/// IN.npy holds an array of float32 of shape (N, 6): per ray its origin and its direction. A direction may have any
/// length but zero. Rays start in free space: one that starts behind an opaque surface (in a ball, or outside of
/// the room) meets that surface at distance 0 or passes it.
///
/// OUT.npy gets N records: t (float32), the distance in scene units (not in lengths of the direction), infinite for a
/// miss; sphere (int32), the place of the sphere in the scene file, from 0, or -1 for a miss (a background counts as
/// one more sphere, the last); and normal (3 of float32), of unit length on the side that the ray comes from, or zero.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = TRACE_EXAMPLES)]
pub(crate) struct TraceArgs {
    #[command(flatten)]
    scene: SceneArg,

    /// The rays to trace
    #[arg(long, value_name = "IN.npy")]
    rays: PathBuf,

    /// The file to write
    #[arg(long, value_name = "OUT.npy")]
    hits: PathBuf,

    /// When, in shutter time [default: when the shutter opens]
    #[arg(long, value_name = "T", value_parser = number(-1e15, 1e15), allow_hyphen_values = true)]
    time: Option<f32>,

    /// Whose intersections; both give the same bits
    #[arg(long, value_enum, default_value = "fast", help_heading = "Machine")]
    engine: Tracer,

    /// The vectors that the fast engine runs on [default: auto]
    #[arg(long, value_enum, value_name = "LANES", help_heading = "Machine")]
    lanes: Option<LanesName>,

    #[command(flatten)]
    machine: MachineArgs,
}

const TRACE_EXAMPLES: &str = "\
Example:
  python -c 'import numpy; numpy.save(\"rays.npy\", numpy.float32([[50, 50, 200, 0, 0, -1]]))'
  sppm trace cornell --rays rays.npy --hits hits.npy
  python -c 'import numpy; print(numpy.load(\"hits.npy\")[\"t\"])'";

/// Runs the command.
pub(crate) fn run(args: &TraceArgs) -> Result<(), Error> {
    let opened = args.scene.open([None; 2])?;
    let time = instant(&opened, args.time)?;
    let name = match args.engine {
        Tracer::Fast => EngineName::Fast,
        Tracer::Reference => EngineName::Reference,
    };
    let engine = EngineChoice::new(name, args.lanes)?;
    let bad =
        |option: &str, error: &dyn ToString| Error::BadInput(format!("{option}: {}", error.to_string()));
    if args.hits.extension().is_none_or(|e| e != "npy") {
        return Err(bad("--hits", &format!("{} does not end in .npy", args.hits.display())));
    }
    let scene_file = opened.file.as_deref().map(|path| ("the scene", path));
    let inputs: Vec<_> = scene_file.into_iter().chain([("--rays", args.rays.as_path())]).collect();
    check_distinct(&inputs, &[("--hits", &args.hits)])?;
    atomic_file::check(&args.hits).map_err(|error| bad("--hits", &error))?;
    let _busy = Busy::with("tracing the rays");
    let rays = npy::read(&args.rays).map_err(|error| bad("--rays", &error))?;
    let pool = render::pool(args.machine.threads)?;
    let still = opened.scene.at(time);
    let hits = pool.install(|| render::trace(engine, &still, &rays));
    npy::write(&args.hits, &hits).map_err(|error| Error::Failed(error.to_string()))
}
