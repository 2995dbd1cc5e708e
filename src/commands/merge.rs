//! The command `merge`: adds up parts of a render.

use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::logs::{self, Format, Level};
use crate::terminal::text::{print, quoted};
use clap::{Args as ClapArgs, ValueHint};
use render::merge::Merge;
use scene::Iterations;
use scene::text::counted;
use std::fmt::Write;
use std::path::PathBuf;
use tracing::{info, warn};

/// Add up parts of a render, from any machines
///
/// PARTS are checkpoints of one render with global radii, as `sppm render --part` and --range write them, or earlier merges.
/// Their sum is the whole render, bit for bit, in whatever grouping and order. Iterations that are in several parts are
/// counted once. Parts of another scene, other settings or another version of the light transport are refused.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = MERGE_EXAMPLES)]
pub(crate) struct MergeArgs {
    /// The parts
    #[arg(value_name = "PARTS", required = true, value_hint = ValueHint::FilePath)]
    pub parts: Vec<PathBuf>,

    /// What to write: a checkpoint (.sppm), for further merges and `sppm resume`, or an image
    ///
    /// A checkpoint that is there already is replaced only if the parts hold all its iterations.
    #[arg(short, long, value_name = "OUT", required_unless_present = "missing", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,

    /// Print which iterations are in no part, each range as a command that renders it; exit with 1 if there are any
    #[arg(long)]
    pub missing: bool,

    /// Say nothing unless something is wrong
    #[arg(short, long)]
    pub quiet: bool,

    /// How messages on standard error are written: for people, or as a JSON object per line
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "text")]
    pub log_format: Format,
}

const MERGE_EXAMPLES: &str = "\
Examples:
  sppm merge part*.sppm -o surgery.exr
  sppm merge part*.sppm -o surgery.sppm
  sppm merge part*.sppm --missing
  sppm resume surgery.sppm -o surgery.png          renders what is missing, and the image";

/// Runs the command.
pub(crate) fn run(args: &MergeArgs) -> Result<(), Error> {
    logs::init(args.log_format, if args.quiet { Level::WARN } else { Level::INFO });
    let busy = Busy::with(format!("reading {}", counted(args.parts.len() as u64, "part")));
    let merge = Merge::open(&args.parts)?;
    drop(busy);
    for path in merge.repeated() {
        warn!("{}: its iterations are in other parts too, and are counted once", path.display());
    }
    let missing = merge.missing();
    if let Some(out) = &args.output {
        let busy = Busy::with(format!("adding {}", counted(args.parts.len() as u64, "part")));
        merge.write(out)?;
        drop(busy);
        let (done, all) = (merge.done().count(), merge.scene().settings.iterations);
        info!(iterations = done, "wrote {}: {done} of {}", out.display(), counted(all, "iteration"));
        if !missing.is_empty() && !args.missing {
            warn!("the iterations {missing} are missing; --missing says how to render them");
        }
    }
    if !args.missing {
        return Ok(());
    }
    print(commands(args, &merge, &missing).as_bytes())?;
    if missing.is_empty() {
        Ok(())
    } else {
        Err(Error::Failed(format!("the iterations {missing} are missing")))
    }
}

/// A command for each range of iterations that is missing.
fn commands(args: &MergeArgs, merge: &Merge, missing: &Iterations) -> String {
    let (like, all) = (quoted(&args.parts[0].to_string_lossy()), merge.scene().settings.iterations);
    let mut text = String::new();
    for range in missing.ranges() {
        let (start, end) = (range.start, range.end);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "sppm render --like {like} -n {all} --range {start}..{end} -o missing-{start}-{end}.sppm"
        );
    }
    text
}
