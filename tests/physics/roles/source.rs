//! The random numbers that the engines' sources read, each of which must have a role that is tested.
//!
//! The sources are parsed. Whoever adds a number adds its role to `camera.rs`, `photons.rs` or `paths.rs` here, with a
//! scene that shows it, and then to [`READ`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Expr, ExprArray, ExprMethodCall, ItemConst, ItemEnum, ItemMod};

/// What a file reads: named dimensions of the stratified points, and calls that draw from a stream.
#[derive(Debug, Default, PartialEq)]
struct Reads {
    /// Per constant of the module `dimension`, its dimensions.
    dimensions: BTreeMap<String, Vec<usize>>,
    /// Calls of `next_f32` and `next_u32`.
    draws: usize,
}

/// Constants with their dimensions.
type Named = &'static [(&'static str, &'static [usize])];

/// Per file of the reference that reads random numbers, its dimensions and the draws from streams. Draws are: in the
/// camera pass the shifts of a tile, and lobes beyond the stratified ones; in the photon pass the shifts of an iteration,
/// and the three numbers of a later bounce; in the path tracer the call that serves all others, a later lobe, the three
/// numbers of direct light on later surfaces (1 call), later directions (2), and roulette (1 call in the source); in further
/// rays the place in the pixel and on the lens (2 calls serve both), and the choice at glass.
///
/// The survey's numbers enter no image: place in the image and on the lens, and per surface two for the direction, roulette
/// and the three of direct light. Its dimensions are places of walks in the image.
const READ: [(&str, Named, usize); 5] = [
    (
        "camera_pass.rs",
        &[
            ("LENS", &[5, 6]),
            ("LIGHT", &[4]),
            ("LIGHT_POINT", &[2, 3]),
            ("LOBES", &[7, 8, 9, 10]),
            ("PIXEL", &[0, 1]),
        ],
        2,
    ),
    (
        "photon_numbers.rs",
        &[("DIRECTION", &[0, 1]), ("FIRST_BOUNCE", &[4, 5, 7]), ("LIGHT", &[6]), ("POSITION", &[2, 3])],
        2,
    ),
    ("glints.rs", &[], 3),
    ("path_tracer.rs", &[("BOUNCE", &[7, 9]), ("LOBES", &[8, 10])], 6),
    ("survey.rs", &[], 4),
];

/// The files of the fast engine that name dimensions, and the reference's file of the same path.
const ALIKE: [(&str, &str); 3] = [
    ("fast/src/eye/numbers.rs", "reference/src/camera_pass.rs"),
    ("fast/src/path_tracer/numbers.rs", "reference/src/path_tracer.rs"),
    ("fast/src/photon_pass/emission.rs", "reference/src/photon_numbers.rs"),
];

impl Visit<'_> for Reads {
    fn visit_item_mod(&mut self, module: &ItemMod) {
        // Tests read numbers of their own.
        if module.ident != "tests" {
            let is_dimension = module.ident == "dimension";
            let items = module.content.iter().flat_map(|(_, items)| items);
            for item in items {
                match item {
                    syn::Item::Const(item) if is_dimension => self.name(item),
                    other => self.visit_item(other),
                }
            }
        }
    }

    fn visit_expr_method_call(&mut self, call: &ExprMethodCall) {
        self.draws += usize::from(call.method == "next_f32" || call.method == "next_u32");
        visit::visit_expr_method_call(self, call);
    }
}

impl Reads {
    fn of(path: &Path) -> Self {
        let mut reads = Self::default();
        reads.visit_file(&syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap());
        reads
    }

    fn name(&mut self, item: &ItemConst) {
        let numbers = match &*item.expr {
            Expr::Array(ExprArray { elems, .. }) => elems.iter().map(number).collect(),
            other => vec![number(other)],
        };
        self.dimensions.insert(item.ident.to_string(), numbers);
    }
}

fn number(expression: &Expr) -> usize {
    match expression {
        Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(int), .. }) => int.base10_parse().unwrap(),
        _ => panic!("a dimension is a number"),
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

#[test]
fn every_random_number_that_is_read_has_a_role() {
    let folder = root().join("reference/src");
    for path in sources(&folder) {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap().to_owned();
        let listed =
            READ.iter().find(|(file, ..)| *file == name).map_or_else(Reads::default, |(_, named, draws)| {
                let dimensions = named.iter().map(|(name, numbers)| ((*name).to_owned(), numbers.to_vec()));
                Reads { dimensions: dimensions.collect(), draws: *draws }
            });
        assert_eq!(
            Reads::of(&path),
            listed,
            "reference/src/{name} reads random numbers that have no role in tests/physics/roles"
        );
    }
}

/// Numbers of one path that have the same dimension are one number.
#[test]
fn no_dimension_has_two_roles() {
    for (file, named, _) in READ {
        let mut dimensions: Vec<_> = named.iter().flat_map(|(_, numbers)| numbers.iter()).collect();
        let count = dimensions.len();
        dimensions.sort_unstable();
        dimensions.dedup();
        assert_eq!(dimensions.len(), count, "{file}: two roles share a dimension");
    }
}

/// Up to the first diffuse surface the path tracer has the dimensions of the camera pass, but for its choices at glass.
#[test]
fn paths_and_the_camera_pass_share_no_dimension_for_two_roles() {
    let of = |name| READ.iter().find(|(file, ..)| *file == name).unwrap().1;
    let paths: Vec<_> = of("path_tracer.rs").iter().flat_map(|(_, numbers)| *numbers).collect();
    for (role, numbers) in of("camera_pass.rs").iter().filter(|(role, _)| *role != "LOBES") {
        assert!(!numbers.iter().any(|number| paths.contains(&number)), "{role}");
    }
}

#[test]
fn the_fast_engine_names_the_same_dimensions() {
    for (fast, reference) in ALIKE {
        let [fast, reference] = [fast, reference].map(|file| Reads::of(&root().join(file)).dimensions);
        assert!(!reference.is_empty());
        assert_eq!(fast, reference);
    }
}

/// Who draws from which family: `numbers` of camera paths, tiles, photons, emission; the shutter; the path tracer.
#[test]
fn every_family_of_streams_has_a_reader_that_is_tested() {
    struct Families(Vec<String>);
    impl Visit<'_> for Families {
        fn visit_item_enum(&mut self, item: &ItemEnum) {
            if item.ident == "Family" {
                self.0.extend(item.variants.iter().map(|variant| variant.ident.to_string()));
            }
        }
    }
    let mut families = Families(Vec::new());
    let text = std::fs::read_to_string(root().join("scene/src/rng.rs")).unwrap();
    families.visit_file(&syn::parse_file(&text).unwrap());
    // The last two make no image brighter or darker: where photons are aimed, and how codes are rounded.
    let known = ["Camera", "Tile", "Photon", "Emission", "Shutter", "Path", "Survey", "Glint", "Dither"];
    assert_eq!(families.0, known);
}
