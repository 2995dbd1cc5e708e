//! The table of all rows and their parts.

use crate::counted::Operations;
use crate::index::{ByBlock, BySphere, ByteBins, HashGrid, Kiddo, LinkedBins, Partitioned, Tree, TypedBins};
use crate::numbers::Generator;
use crate::one::One;
use crate::options::Options;
use crate::pipeline::{Parts, Pipeline};
use crate::pixels::{Columns, Line8, Line16, Lines, Objects, ScalarPixels, TypedArrays};
use crate::rung::Rung;
use crate::vector::{Called, Horizontal, Inlined, MathInlined, Scalar, Vertical};
use scene::{Engine, Film, Probe, Progress, Scene, Settings, Stop};
use serde::Serialize;

/// A description of a row's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Description {
    /// The generator of random numbers.
    pub random: &'static str,
    /// The memory layout of pixels and visible points.
    pub layout: &'static str,
    /// The spatial index.
    pub index: &'static str,
    /// How vector functions are called.
    pub math: &'static str,
    /// The number of rays traced at a time.
    pub width: u32,
    /// The number of candidates joined with a photon at a time.
    pub join: u32,
}

type Start = for<'a> fn(&'a Scene, &Settings, &Options, Generator) -> Box<dyn Rung + 'a>;

/// A row of the ladder.
#[derive(Clone, Copy)]
pub struct Row {
    /// The name on the command line.
    pub name: &'static str,
    /// A description in one line.
    pub about: &'static str,
    /// Its parts.
    pub parts: Description,
    /// True if it is one of the paper's seven stages.
    pub is_stage: bool,
    generator: Generator,
    start: Start,
}

impl Row {
    /// A render that has not begun.
    pub fn start<'a>(&self, scene: &'a Scene, settings: &Settings, options: &Options) -> Box<dyn Rung + 'a> {
        (self.start)(scene, settings, options, self.generator)
    }

    /// True if the row gives the reference's image whatever random numbers and sums are requested.
    pub fn is_always_exact(&self) -> bool {
        self.name == FAST
    }
}

impl std::fmt::Debug for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Row").field("name", &self.name).field("parts", &self.parts).finish_non_exhaustive()
    }
}

/// The row called `name`.
pub fn find(name: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.name == name)
}

/// Starts a render with the parts `P`.
fn start<'a, P: Parts>(
    scene: &'a Scene,
    settings: &Settings,
    options: &Options,
    generator: Generator,
) -> Box<dyn Rung + 'a> {
    Box::new(Pipeline::<P>::new(scene, settings, options, generator))
}

/// Defines the parts of a row by width, layout, index, and whether the scene is read from columns.
macro_rules! parts {
    ($($name:ident: $width:ty, $pixels:ty, $index:ty, columns: $columns:literal;)*) => {$(
        struct $name;
        impl Parts for $name {
            type Width = $width;
            type Pixels = $pixels;
            type Index = $index;
            const FROM_COLUMNS: bool = $columns;
        }
    )*};
}

parts! {
    Stage0: Scalar<Called<One>>, ScalarPixels<Objects>, HashGrid<LinkedBins>, columns: false;
    Stage1: Scalar<MathInlined<One>>, ScalarPixels<Objects>, HashGrid<ByteBins>, columns: false;
    Stage2: Scalar<Inlined<One>>, ScalarPixels<TypedArrays<[f32; 3]>>, HashGrid<TypedBins>, columns: false;
    OneRegister: Scalar<Horizontal>, ScalarPixels<TypedArrays<glam::Vec3A>>, HashGrid<TypedBins>, columns: false;
    Stage4: Vertical, Columns, HashGrid<TypedBins>, columns: true;
    Stage5: Vertical, Lines<Line16>, HashGrid<TypedBins>, columns: false;
    Stage6: Vertical, Lines<Line8>, HashGrid<TypedBins>, columns: false;
    SortedTables: Vertical, Lines<Line8>, HashGrid<Partitioned<BySphere>>, columns: false;
    BlockedTables: Vertical, Lines<Line8>, HashGrid<Partitioned<ByBlock>>, columns: false;
    KiddoTree: Vertical, Lines<Line8>, Kiddo, columns: false;
    OwnTree: Vertical, Lines<Line8>, Tree, columns: false;
}

const FAST: &str = "fast";
const XORSHIFT_8: Generator = Generator::Xorshift { unroll: 8 };
const XORSHIFT: &str = "xorshift32, 8 lanes, 8 vectors at a time";

const BASELINE: Description = Description {
    random: "rand of the C library",
    layout: "array of objects",
    index: "hash grid, linked lists allocated anew",
    math: "called",
    width: 1,
    join: 1,
};
const STAGE1: Description =
    Description { index: "hash grid, generic arrays kept", math: "vector math inlined", ..BASELINE };
const STAGE2: Description = Description {
    layout: "typed arrays, flags for zero throughput",
    index: "hash grid, typed arrays kept",
    math: "inlined",
    ..STAGE1
};
const STAGE3: Description = Description { random: XORSHIFT, ..STAGE2 };
const STAGE4: Description =
    Description { layout: "structure of arrays, 16 gathers", width: 8, join: 8, ..STAGE3 };
const STAGE5: Description = Description { layout: "cache lines of 16 words, two transposes", ..STAGE4 };
const STAGE6: Description = Description { layout: "lines of 8 words, one transpose", ..STAGE4 };

const fn row(
    name: &'static str,
    about: &'static str,
    parts: Description,
    generator: Generator,
    start: Start,
) -> Row {
    Row { name, about, parts, is_stage: false, generator, start }
}

const fn stage(
    name: &'static str,
    about: &'static str,
    parts: Description,
    generator: Generator,
    start: Start,
) -> Row {
    Row { is_stage: true, ..row(name, about, parts, generator, start) }
}

const fn unrolled(name: &'static str, random: &'static str, unroll: usize) -> Row {
    let about = "stage 3 with another unroll factor of its generator";
    row(name, about, Description { random, ..STAGE3 }, Generator::Xorshift { unroll }, start::<Stage2>)
}

/// Every row, in the order of the paper.
pub static ROWS: &[Row] = &[
    stage("0", "baseline", BASELINE, Generator::Rand, start::<Stage0>),
    stage("1", "vector math inlined, bins kept", STAGE1, Generator::Rand, start::<Stage1>),
    stage("2", "everything inlined, typed arrays", STAGE2, Generator::Rand, start::<Stage2>),
    stage("3", "xorshift in vectors", STAGE3, XORSHIFT_8, start::<Stage2>),
    unrolled("3-unroll-1", "xorshift32, 8 lanes, one vector at a time", 1),
    unrolled("3-unroll-2", "xorshift32, 8 lanes, 2 vectors at a time", 2),
    unrolled("3-unroll-4", "xorshift32, 8 lanes, 4 vectors at a time", 4),
    unrolled("3-unroll-16", "xorshift32, 8 lanes, 16 vectors at a time", 16),
    row(
        "horizontal",
        "failed attempt 1: one vector in one register",
        Description { math: "inlined, a vector in a 128-bit register", ..STAGE3 },
        XORSHIFT_8,
        start::<OneRegister>,
    ),
    stage("4", "vertical vectors everywhere", STAGE4, XORSHIFT_8, start::<Stage4>),
    stage("5", "what is gathered lies in one cache line", STAGE5, XORSHIFT_8, start::<Stage5>),
    stage("6", "half as many words", STAGE6, XORSHIFT_8, start::<Stage6>),
    row(
        "sorted",
        "failed attempt 2: a table per sphere",
        Description { index: "a hash grid per sphere", ..STAGE6 },
        XORSHIFT_8,
        start::<SortedTables>,
    ),
    row(
        "blocked",
        "failed attempt 2: a table per block of pixels that fits the cache",
        Description { index: "a hash grid per block", ..STAGE6 },
        XORSHIFT_8,
        start::<BlockedTables>,
    ),
    row(
        "kdtree",
        "future work: a k-d tree, that of the crate kiddo",
        Description { index: "k-d tree of kiddo", ..STAGE6 },
        XORSHIFT_8,
        start::<KiddoTree>,
    ),
    row(
        "kdtree-own",
        "future work: a k-d tree of ours, whose leaves are tested in lanes",
        Description { index: "k-d tree, leaves of up to 32 points", ..STAGE6 },
        XORSHIFT_8,
        start::<OwnTree>,
    ),
    row(
        FAST,
        "the fast engine of this project, on one thread",
        Description {
            random: "keyed streams, Sobol points",
            layout: "tiles of rows",
            index: "photons sorted into cells",
            math: "inlined",
            width: 256,
            join: 8,
        },
        XORSHIFT_8,
        start_fast,
    ),
];

/// The fast engine as a row. It always uses the random numbers and sums of the reference.
struct Fast<'a>(fast::Sppm<'a>);

fn start_fast<'a>(scene: &'a Scene, settings: &Settings, _: &Options, _: Generator) -> Box<dyn Rung + 'a> {
    Box::new(Fast(fast::Sppm::new(scene, settings)))
}

impl Engine for Fast<'_> {
    fn progress(&self) -> &Progress {
        self.0.progress()
    }
    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        self.0.iterate_unless(stop)
    }
    fn probe(&self, x: u32, y: u32) -> Probe {
        self.0.probe(x, y)
    }
    fn develop(&self) -> Film {
        self.0.develop()
    }
}

impl Rung for Fast<'_> {
    fn operations(&self) -> Option<[Operations; 4]> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_their_whole_names() {
        for row in ROWS {
            assert_eq!(find(row.name).map(|found| found.about), Some(row.about));
        }
        for name in ["", "7", "k", "kdtree-", "3-unroll", "FAST"] {
            assert!(find(name).is_none(), "{name:?}");
        }
    }

    /// The paper has seven, and what it varies besides has rows of its own.
    #[test]
    fn stages_are_numbered_in_order() {
        let stages: Vec<&str> = ROWS.iter().filter(|row| row.is_stage).map(|row| row.name).collect();
        assert_eq!(stages, ["0", "1", "2", "3", "4", "5", "6"]);
        let exact: Vec<&str> = ROWS.iter().filter(|row| row.is_always_exact()).map(|row| row.name).collect();
        assert_eq!(exact, ["fast"]);
    }

    #[test]
    fn a_generator_has_the_unroll_factor_that_its_row_names() {
        for row in ROWS.iter().filter(|row| row.name.contains("unroll")) {
            let Generator::Xorshift { unroll } = row.generator else { panic!("{row:?}") };
            assert_eq!(row.name, format!("3-unroll-{unroll}"));
            let told = if unroll == 1 { "one vector".into() } else { format!("{unroll} vectors") };
            assert!(row.parts.random.contains(&told), "{row:?}");
        }
    }
}
