//! The command `compare`: measures how similar two images are.

use crate::args::files::check_distinct;
use crate::args::values::bound;
use crate::terminal::error::Error;
use crate::terminal::text::{complain, print};
use clap::Args;
use compare::{CompareError, Exceeded, Metrics, Thresholds, difference_image};
use files::image_file::{self, Encoding, Format};
use scene::Film;
use std::path::{Path, PathBuf};

/// Tell how alike two images are
///
/// Prints the means of both images, RMSE and relative MSE of linear radiance, and PSNR, SSIM and FLIP of what sRGB
/// shows. Relative MSE divides each square error by the square of B (and a little more), so that dark places count as
/// bright ones do; by blocks of 8x8 pixels it shows wrong light rather than noise. FLIP estimates what someone sees who
/// flips between the two. Exits with 1, saying why, if a bound given by --max-... or --min-... does not hold.
#[derive(Debug, Args)]
#[command(after_long_help = COMPARE_EXAMPLES)]
pub(crate) struct CompareArgs {
    /// The image to judge: .png, .exr or .pfm
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The image that is right
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// Write a false-colour picture of the difference
    #[arg(long, value_name = "FILE.png")]
    difference: Option<PathBuf>,

    #[command(flatten)]
    thresholds: ThresholdArgs,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  sppm compare cornell.exr truth.exr --difference where.png
  sppm compare cornell.png old.png --max-abs 0 --json";

/// What the images must satisfy.
#[derive(Debug, Args)]
#[command(next_help_heading = "Bounds")]
struct ThresholdArgs {
    /// Greatest root-mean-square error, over all channels
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_rmse: Option<f64>,

    /// Greatest relative mean-square error, over all channels
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_relmse: Option<f64>,

    /// Greatest relative mean-square error of the means over blocks of 8x8 pixels
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_block_relmse: Option<f64>,

    /// Greatest mean FLIP error, from 0 (alike) to 1
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_flip: Option<f64>,

    /// Greatest difference of any channel of any pixel; 0 asks for equal images
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_abs: Option<f64>,

    /// Least mean SSIM index, at most 1 (alike)
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    min_ssim: Option<f64>,

    /// Least peak signal-to-noise ratio, in dB
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    min_psnr: Option<f64>,
}

impl From<&ThresholdArgs> for Thresholds {
    fn from(args: &ThresholdArgs) -> Self {
        Self {
            max_rmse: args.max_rmse,
            max_relmse: args.max_relmse,
            max_block_relmse: args.max_block_relmse,
            max_flip: args.max_flip,
            max_abs: args.max_abs,
            min_ssim: args.min_ssim,
            min_psnr: args.min_psnr,
        }
    }
}

/// Prints the metrics of two images; fails if a threshold is exceeded.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Error> {
    if let Some(path) = &args.difference {
        check_difference(args, path)?;
    }
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let metrics = Metrics::of(&a, &b).map_err(|error| incomparable(args, &error))?;
    let text = if args.json { json(&metrics)? } else { metrics.to_string() };
    print(text.as_bytes())?;
    if let Some(path) = &args.difference {
        write_difference(args, path, &a, &b)?;
    }
    let exceeded: Vec<String> =
        Thresholds::from(&args.thresholds).exceeded(&metrics).iter().map(sentence).collect();
    if exceeded.is_empty() { Ok(()) } else { Err(Error::Failed(exceeded.join("; "))) }
}

/// Names the bound that is exceeded, with its option.
fn sentence(exceeded: &Exceeded) -> String {
    let Exceeded { metric, value, field, threshold, is_above } = exceeded;
    let (side, option) = (if *is_above { "above" } else { "below" }, field.replace('_', "-"));
    format!("{metric} is {value}, {side} --{option} {threshold}")
}

fn read(path: &Path) -> Result<Film, Error> {
    image_file::read(path).map_err(|error| Error::BadInput(error.to_string()))
}

fn check_difference(args: &CompareArgs, path: &Path) -> Result<(), Error> {
    let bad = |error: &dyn ToString| Error::BadInput(format!("--difference: {}", error.to_string()));
    check_distinct(&[("image A", &args.a), ("image B", &args.b)], &[("--difference", path)])?;
    match Format::from_path(path) {
        Ok(Format::Png) | Err(_) => image_file::check_writable(path).map_err(|error| bad(&error)),
        Ok(_) => Err(bad(&format!("{} is a picture in false colours; name a .png file", path.display()))),
    }
}

fn write_difference(args: &CompareArgs, path: &Path, a: &Film, b: &Film) -> Result<(), Error> {
    let difference = difference_image(a, b).map_err(|error| incomparable(args, &error))?;
    image_file::write(path, &difference.film, &Encoding::default())
        .map_err(|error| Error::Failed(error.to_string()))?;
    complain(&format!("wrote {}; its brightest colour stands for {:e}", path.display(), difference.scale));
    Ok(())
}

fn incomparable(args: &CompareArgs, error: &CompareError) -> Error {
    Error::BadInput(format!("{} and {} cannot be compared: {error}", args.a.display(), args.b.display()))
}

fn json(metrics: &impl serde::Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(metrics);
    text.map(|text| text + "\n").map_err(|error| Error::Failed(format!("cannot make JSON: {error}")))
}
