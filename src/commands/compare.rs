//! The command `compare`: measures how similar two images are.

use super::view;
use crate::args::files::check_distinct;
use crate::args::values::bound;
use crate::args::view::PageArgs;
use crate::terminal::bar::Bar;
use crate::terminal::error::Error;
use crate::terminal::text::{complain, print};
use clap::Args;
use compare::{CompareError, DifferenceMap, Exceeded, Metrics, Thresholds};
use files::image_file::{self, Encoding, Format, ImageReader, Tone};
use render::Metadata;
use scene::text::one_line;
use scene::{Picture, RowReader};
use std::path::{Path, PathBuf};

/// Tell how alike two images are
///
/// Prints the means of both images, RMSE and relative MSE of linear radiance, and PSNR, SSIM and FLIP of what sRGB
/// shows. Relative MSE divides each square error by the square of B (and a little more), so that dark places count as
/// bright ones do; by blocks of 8x8 pixels it shows wrong light rather than noise. FLIP estimates what someone sees who
/// flips between the two. If both files hold linear radiance, HDR-FLIP does so at all exposures. Large images are read in
/// strips. Exits with 1, saying why, if a bound given by --max-... or --min-... does not hold.
#[derive(Debug, Args)]
#[command(after_long_help = COMPARE_EXAMPLES)]
pub(crate) struct CompareArgs {
    /// The image to judge: PNG, JPEG, EXR, PFM, HDR, TIFF, WebP or QOI
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The image that is right
    #[arg(value_name = "B")]
    b: PathBuf,

    /// The layer to read of EXR files that have layers
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// Write a false-colour picture of the difference
    #[arg(long, value_name = "FILE.png")]
    difference: Option<PathBuf>,

    /// Then look at both images in the browser, with a slider between them, and at their difference; Ctrl-C ends it
    #[arg(long)]
    view: bool,

    #[command(flatten)]
    page: PageArgs,

    #[command(flatten)]
    thresholds: ThresholdArgs,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  sppm compare cornell.exr truth.exr --difference where.png
  sppm compare cornell.exr beauty.exr --layer ViewLayer.Combined
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

    /// Greatest mean HDR-FLIP error, of images that hold linear radiance
    #[arg(long, value_name = "X", value_parser = bound, allow_hyphen_values = true)]
    max_hdr_flip: Option<f64>,

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
            max_hdr_flip: args.max_hdr_flip,
            max_abs: args.max_abs,
            min_ssim: args.min_ssim,
            min_psnr: args.min_psnr,
        }
    }
}

/// Prints the metrics of two images; fails if a threshold is exceeded.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Error> {
    args.page.check(args.view)?;
    if let Some(path) = &args.difference {
        check_difference(args, path)?;
    }
    let [mut a, mut b] = open(args)?;
    if let Some(warning) = toned_apart(args, [&a, &b]) {
        complain(&warning);
    }
    let hdr_flip = a.is_linear() && b.is_linear();
    check_hdr_flip(args, [&a, &b])?;
    let metrics =
        with_bar(b.size(), "comparing", |progress| Metrics::of_rows(&mut a, &mut b, hdr_flip, progress));
    let metrics = metrics.map_err(|error| incomparable(args, &error))?;
    let text = if args.json { json(&metrics)? } else { metrics.to_string() };
    // The page's address is the first line on standard output.
    if args.view {
        text.lines().for_each(|line| complain(&line));
    } else {
        print(text.as_bytes())?;
    }
    if let Some(path) = &args.difference {
        write_difference(args, path, &mut a, &mut b)?;
    }
    let judged = judge(args, &metrics);
    if !args.view {
        return judged;
    }
    if let Err(error) = judged {
        complain(&format!("warning: {error}"));
    }
    let [of_a, of_b] = layers(args)?;
    view::compare((&args.a, of_a), (&args.b, of_b), &args.page)
}

/// Whether the bounds that were asked for are kept to.
fn judge(args: &CompareArgs, metrics: &Metrics) -> Result<(), Error> {
    if args.thresholds.max_hdr_flip.is_some() && metrics.hdr_flip.is_none() {
        let b = args.b.display();
        return Err(Error::Failed(format!(
            "--max-hdr-flip: {b} is black, for which HDR-FLIP is not defined"
        )));
    }
    let exceeded: Vec<String> =
        Thresholds::from(&args.thresholds).exceeded(metrics).iter().map(sentence).collect();
    if exceeded.is_empty() { Ok(()) } else { Err(Error::Failed(exceeded.join("; "))) }
}

/// The warning that the images show radiance by two curves. Of a linear image that is known, of others only if their
/// files say it.
fn toned_apart(args: &CompareArgs, images: [&ImageReader; 2]) -> Option<String> {
    let tone = |path: &Path, image: &ImageReader| {
        let metadata = || Metadata::from_note(&image_file::read_note(path).ok()??);
        if image.is_linear() { Some(Tone::Clamp) } else { metadata()?.tone }
    };
    let (a, b) = (tone(&args.a, images[0])?, tone(&args.b, images[1])?);
    let (toned, tone) = if a == Tone::Clamp { (&args.b, b) } else { (&args.a, a) };
    (a != b).then(|| {
        format!(
            "warning: {} shows radiance by the tone curve {tone}, and the other image does not: what is told is mostly the \
             curve; compare .exr images, or render by --tone clamp",
            one_line(&toned.to_string_lossy())
        )
    })
}

/// Names the bound that is exceeded, with its option.
fn sentence(exceeded: &Exceeded) -> String {
    let Exceeded { metric, value, field, threshold, is_above } = exceeded;
    let (side, option) = (if *is_above { "above" } else { "below" }, field.replace('_', "-"));
    format!("{metric} is {value}, {side} --{option} {threshold}")
}

/// The layer to read of each image. A file without layers is read whole, unless neither has some.
fn layers(args: &CompareArgs) -> Result<[Option<&str>; 2], Error> {
    let bad = |error: image_file::ImageError| Error::BadInput(error.to_string());
    let paths = [&args.a, &args.b];
    let has_layers = match args.layer {
        Some(_) => paths.map(|path| image_file::layer_names(path).map(|names| !names.is_empty())),
        None => [Ok(false), Ok(false)],
    };
    let [of_a, of_b] = has_layers;
    let (of_a, of_b) = (of_a.map_err(bad)?, of_b.map_err(bad)?);
    let layer = |has: bool| args.layer.as_deref().filter(|_| has || !(of_a || of_b));
    Ok([layer(of_a), layer(of_b)])
}

/// Opens both images.
fn open(args: &CompareArgs) -> Result<[ImageReader; 2], Error> {
    let [of_a, of_b] = layers(args)?;
    let open = |path: &Path, layer| {
        ImageReader::open(path, layer).map_err(|error| Error::BadInput(error.to_string()))
    };
    Ok([open(&args.a, of_a)?, open(&args.b, of_b)?])
}

/// Rejects a bound on HDR-FLIP for images that hold what a screen shows.
fn check_hdr_flip(args: &CompareArgs, images: [&ImageReader; 2]) -> Result<(), Error> {
    let mut shown = [&args.a, &args.b].into_iter().zip(images).filter(|(_, image)| !image.is_linear());
    match (args.thresholds.max_hdr_flip, shown.next()) {
        (Some(_), Some((path, image))) => Err(Error::BadInput(format!(
            "--max-hdr-flip: {} holds {}; HDR-FLIP needs linear radiance, as in .exr, .pfm, .hdr and .tif files",
            path.display(),
            image.samples()
        ))),
        _ => Ok(()),
    }
}

/// Images of more pixels than this take seconds, and have a bar.
const QUICK: u64 = 1 << 22;

fn is_quick([width, height]: [u32; 2]) -> bool {
    u64::from(width) * u64::from(height) <= QUICK
}

/// The bar of so many rows that are read in all, if images of this size take long.
fn bar_of(size: [u32; 2], rows: u64) -> Option<Bar> {
    (!is_quick(size)).then(|| Bar::of(rows as u32, "rows"))
}

/// Runs `work`, with a bar of the rows that it reads in all if that takes long.
fn with_bar<T>(size: [u32; 2], what: &str, work: impl FnOnce(compare::Progress) -> T) -> T {
    let mut bar = None;
    let done = work(&mut |rows, all| {
        if let Some(bar) = bar.get_or_insert_with(|| bar_of(size, all)) {
            bar.step(rows as u32, what);
        }
    });
    if let Some(bar) = bar.flatten() {
        bar.clear();
    }
    done
}

fn check_difference(args: &CompareArgs, path: &Path) -> Result<(), Error> {
    let bad = |error: &dyn ToString| Error::BadInput(format!("--difference: {}", error.to_string()));
    check_distinct(&[("image A", &args.a), ("image B", &args.b)], &[("--difference", path)])?;
    match Format::from_path(path) {
        Ok(Format::Png) => image_file::check_writable(path).map_err(|error| bad(&error)),
        _ => Err(bad(&format!("{} is a picture in false colours; name a .png file", path.display()))),
    }
}

fn write_difference(
    args: &CompareArgs,
    path: &Path,
    a: &mut ImageReader,
    b: &mut ImageReader,
) -> Result<(), Error> {
    let map = with_bar(b.size(), "mapping the difference", |progress| DifferenceMap::of_rows(a, b, progress));
    let map = map.map_err(|error| incomparable(args, &error))?;
    let pixel = |x, y| map.color(x, y);
    let picture = Picture { width: map.width, height: map.height, pixel: &pixel };
    image_file::write_picture(path, &picture, &Encoding::default())
        .map_err(|error| Error::Failed(error.to_string()))?;
    complain(&format!("wrote {}; its brightest colour stands for {:e}", path.display(), map.scale));
    Ok(())
}

fn incomparable(args: &CompareArgs, error: &CompareError) -> Error {
    match error {
        CompareError::Unreadable(line) => Error::BadInput(line.clone()),
        _ => Error::BadInput(format!(
            "{} and {} cannot be compared: {error}",
            args.a.display(),
            args.b.display()
        )),
    }
}

fn json(metrics: &impl serde::Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(metrics);
    text.map(|text| text + "\n").map_err(|error| Error::Failed(format!("cannot make JSON: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_images_have_a_bar() {
        assert!(is_quick([2048, 2048]) && is_quick([1, 1 << 22]) && !is_quick([2048, 2049]));
        assert!(!is_quick([u32::MAX, u32::MAX]));
        assert!(bar_of([2048, 2048], 9).is_none());
        assert!(bar_of([2048, 2049], 9).is_some_and(|bar| bar.line().contains(" 0/9 rows  ")));
        let mut steps = 0;
        let done = with_bar([3, 2], "comparing", |progress| {
            progress(1, 2);
            steps += 1;
            7
        });
        assert_eq!((done, steps), (7, 1));
    }

    #[test]
    fn what_is_exceeded_is_told_by_its_option() {
        let exceeded = |is_above, field| {
            sentence(&Exceeded { metric: "it", value: 0.5, field, threshold: 0.25, is_above })
        };
        assert_eq!(exceeded(true, "max_block_relmse"), "it is 0.5, above --max-block-relmse 0.25");
        assert_eq!(exceeded(false, "min_ssim"), "it is 0.5, below --min-ssim 0.25");
    }

    #[test]
    fn each_bound_is_its_own() {
        use crate::commands::{Args as All, Command};
        use clap::Parser as _;
        let of = |words: &[&str]| {
            let args = All::try_parse_from(["sppm", "compare", "a", "b"].iter().chain(words)).unwrap();
            let Command::Compare(args) = args.command else { panic!("another command") };
            Thresholds::from(&args.thresholds)
        };
        let (none, bound) = (Thresholds::default(), Some(0.5));
        assert_eq!(of(&[]), none);
        for (option, expected) in [
            ("--max-rmse", Thresholds { max_rmse: bound, ..none }),
            ("--max-relmse", Thresholds { max_relmse: bound, ..none }),
            ("--max-block-relmse", Thresholds { max_block_relmse: bound, ..none }),
            ("--max-flip", Thresholds { max_flip: bound, ..none }),
            ("--max-hdr-flip", Thresholds { max_hdr_flip: bound, ..none }),
            ("--max-abs", Thresholds { max_abs: bound, ..none }),
            ("--min-ssim", Thresholds { min_ssim: bound, ..none }),
            ("--min-psnr", Thresholds { min_psnr: bound, ..none }),
        ] {
            assert_eq!(of(&[option, "0.5"]), expected, "{option}");
        }
    }
}
