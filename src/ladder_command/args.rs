//! The options of `ladder`.

use crate::args::settings::SettingsArgs;
use crate::args::values::whole;
use clap::{Args, ValueEnum};
use ladder::{ROWS, Random, Row};
use scene::text::list;
use serde::Serialize;
use std::ffi::OsString;
use std::path::PathBuf;

/// Run the ladder of the paper's stages and time them
///
/// Every row renders the same physics; what differs is how. Runs of all rows are interleaved, on one thread, and the
/// median counts. Rows: the paper's stages 0 to 6, stage 3 with other unroll factors, the paper's failed attempts
/// (horizontal, sorted, blocked), the k-d trees that it proposes, and the fast engine of this program.
#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct LadderArgs {
    /// A scene, as for `render`; may be given more than once [default: the paper's five; with --quick, cornell]
    #[arg(long, value_name = "SCENE")]
    pub scene: Vec<OsString>,

    /// The rows to run, separated by commas [default: all; in a sweep, the stages and the fast engine]
    #[arg(long, value_name = "ROWS", value_delimiter = ',', value_parser = row)]
    pub rows: Vec<&'static Row>,

    /// Vary one parameter, as in the paper's figures 4, 6, 7 and 9
    #[arg(long, value_enum, value_name = "WHAT")]
    pub sweep: Option<Sweep>,

    /// Where random numbers come from
    #[arg(long, value_enum, default_value = "paper")]
    pub rng: Rng,

    /// Runs of every row, of which the median counts [default: 3; with --quick, 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 1000), allow_hyphen_values = true)]
    pub repeat: Option<u32>,

    /// Small images and few photons: less than a minute in all
    #[arg(long)]
    pub quick: bool,

    #[command(flatten)]
    pub also: AlsoArgs,

    /// Write every time and count as a table of comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,

    /// Write plots (.svg) into a folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,

    #[command(flatten)]
    pub settings: SettingsArgs,
}

/// What is done besides timing the rows, or instead.
#[allow(clippy::struct_excessive_bools)] // switches of a command line
#[derive(Debug, Args)]
pub(crate) struct AlsoArgs {
    /// Also count operations and bytes, which takes some ten times as long, and hold them against the machine's peaks
    ///
    /// Peaks and rows are measured here and now. Reports floating-point operations (FLOPs) per cycle and operational
    /// intensity; with --plots also writes rooflines, as in the paper's figures 10 to 12, roofline.csv and peaks.csv,
    /// and in a sweep FLOPs per cycle, as in figure 5. The fast engine is timed, but its operations are not counted.
    #[arg(long)]
    pub roofline: bool,

    /// In a sweep of iterations, also compare the rows' images with the first row's, as in the paper's figure 8
    #[arg(long, requires = "sweep")]
    pub similarity: bool,

    /// Also render with as many seeds as there are runs, and tell the rows' errors and what equal quality costs
    ///
    /// Compares the means of 8x8 pixels with those of a hundred times the iterations, at least 600, by the fast engine:
    /// the error is their mean square difference, relative to their mean square, and the cost the error times the
    /// seconds. With --plots also writes quality.csv.
    #[arg(long, conflicts_with = "sweep")]
    pub quality: bool,

    /// Write the rows' images into a folder instead of timing them: of 2, 4, 8, ... iterations, up to all
    ///
    /// They are called SCENE-ROW-ITERATIONS.pfm. A row renders once, on its way to the last.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["sweep", "repeat", "roofline", "similarity", "quality", "csv", "plots"])]
    pub images: Option<PathBuf>,

    /// Time generators of random numbers instead of rows
    #[arg(long, conflicts_with_all = ["scene", "rows", "sweep", "rng", "repeat", "quick", "roofline", "similarity", "quality", "images", "plots"])]
    pub numbers: bool,
}

const EXAMPLES: &str = "\
Examples:
  sppm ladder --quick
  sppm ladder --scene cornell --rows 0,6,fast --csv times.csv --plots plots
  sppm ladder --scene random --sweep spheres --plots plots
  sppm ladder --scene cornell --rows 0,4,6 --roofline --plots plots
  sppm ladder --rows 6,fast --quality --repeat 8

At the paper's settings the baseline takes half a minute per scene and run on machines of today.";

/// What a sweep varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Sweep {
    /// Iterations, from 2 to 64
    Iterations,
    /// Photons of an iteration, from 12500 to 800000
    Photons,
    /// Pixels, from 32x24 to 1024x768
    Size,
    /// The most segments of a path, from 1 to 10
    Depth,
    /// Spheres: the scene without most of its balls, up to all
    Spheres,
}

impl Sweep {
    /// What is varied, as people say it.
    pub(crate) fn noun(self) -> &'static str {
        match self {
            Self::Iterations => "iterations",
            Self::Photons => "photons",
            Self::Size => "pixels",
            Self::Depth => "depth",
            Self::Spheres => "spheres",
        }
    }
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Rng {
    /// Each row's own generator: rand of the C library, from stage 3 on xorshift
    Paper,
    /// The reference's streams: every row traces the same paths
    Keyed,
}

impl From<Rng> for Random {
    fn from(rng: Rng) -> Self {
        match rng {
            Rng::Paper => Self::Paper,
            Rng::Keyed => Self::Keyed,
        }
    }
}

fn row(name: &str) -> Result<&'static Row, String> {
    let names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
    ladder::find(name).ok_or_else(|| format!("is no row; there are {}", list(&names)))
}
