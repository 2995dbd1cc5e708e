//! Spheres of particles by recipes.

use figure::color::{Map, Screen, WHITE, palette};
use figure::{Balls, Recipe, Refusal, Rule, Selection, balls};
use importers::{Cell, Format, Labels, Particles, Property, Unit};
use proptest::prelude::*;
use scene::{Material, Rgb, Vec3};

/// Three atoms of water and one of unknown element, with a charge; the types are those of a simulation.
fn few() -> Particles {
    let mut particles = Particles::new(Format::Pdb);
    particles.positions = vec![[0.0; 3], [0.96, 0.0, 0.0], [-0.24, 0.93, 0.0], [5.0, 0.0, 0.0]];
    particles.elements = Some(vec![8, 1, 1, 0]);
    particles.types = Some(Labels { names: vec!["2".into(), "10".into()], index: vec![1, 0, 0, 1] });
    particles.properties = vec![Property { name: "charge".into(), values: vec![-0.8, 0.4, 0.4, f32::NAN] }];
    particles.available = vec!["charge".into()];
    particles
}

fn recipe(style: &[&str]) -> Recipe {
    Recipe { style: style.iter().map(|rule| Rule::parse(rule).unwrap()).collect(), ..Recipe::default() }
}

fn made(style: &[&str]) -> Balls {
    balls(few(), &recipe(style)).unwrap()
}

/// Radius and colour of the ball at this x.
fn at(balls: &Balls, x: f32) -> (f32, Rgb) {
    let sphere = balls.spheres.iter().find(|sphere| sphere.center.x == x).unwrap();
    (sphere.radius, balls.materials[sphere.material as usize].albedo())
}

fn matte(color: Screen) -> Rgb {
    color.linear() * WHITE
}

#[test]
fn atoms_are_shown_by_their_element_if_nothing_else_is_asked_for() {
    let balls = made(&[]);
    assert_eq!(balls.spheres.len(), 4);
    // Bondi's radii; red and white as in Jmol.
    assert_eq!(at(&balls, 0.0), (1.52, matte(Screen([255, 13, 13]))));
    assert_eq!(at(&balls, 0.96).1, matte(Screen([255; 3])));
    // Two atoms of hydrogen share a material.
    assert_eq!(balls.materials.len(), 3);
}

#[test]
fn later_rules_win() {
    let balls = made(&[
        "radius=covalent, color=#808080",
        "element == \"H\": radius=0.5, color=red",
        "x > 0.9 and x < 2: scale=2, material=glass",
        "element not in (\"O\", \"H\"): hide",
    ]);
    assert_eq!(balls.spheres.len(), 3);
    let red = Screen::parse("red").unwrap();
    assert_eq!(at(&balls, 0.0), (0.66, matte(Screen([128; 3]))));
    assert_eq!(at(&balls, -0.24), (0.5, matte(red)));
    assert_eq!(at(&balls, 0.96), (1.0, red.linear()));
    assert!(balls.materials.contains(&Material::Dielectric { albedo: red.linear(), ior: 1.5 }));
    // What was hidden can be shown again.
    let balls = made(&["hide", "element == 'O': hide=false, radius=radius"]);
    assert_eq!(balls.spheres.len(), 1);
    // Rules that say nothing of it leave it hidden.
    let balls = made(&["element == 'O': hide", "color=red", "element == 'O': radius=2"]);
    assert_eq!(balls.spheres.len(), 3);
}

#[test]
fn lamps_glow_in_their_colour() {
    let balls = made(&["color=#ffffff, material=light 3"]);
    assert!(balls.spheres.iter().all(|sphere| sphere.emission == Rgb::splat(3.0)));
    assert_eq!(balls.materials, [Material::Diffuse { albedo: Rgb::ZERO }]);
}

#[test]
fn columns_have_colours() {
    let balls = made(&["color=type"]);
    // By value, 2 comes before 10.
    assert_eq!([0.96, 0.0].map(|x| at(&balls, x).1), [palette(0), palette(1)].map(matte));
    let balls = made(&["color=charge, map=inferno"]);
    let expected = [Map::Inferno.at(0.0), Map::Inferno.at(1.0), Map::MISSING].map(matte);
    assert_eq!([0.0, 0.96, 5.0].map(|x| at(&balls, x).1), expected);
    let balls = made(&["color=charge, range=-1..1, map=grey"]);
    assert_eq!(at(&balls, 0.0).1, matte(Map::Grey.at(0.0999)));
}

/// Of the values in their order, that whose place is nearest.
#[test]
fn percentiles_are_values_of_the_nearest_place() {
    let colors = |range: &str| {
        let mut particles = Particles::new(Format::Npy);
        particles.positions = (0..5).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let values = vec![3.0, 100.0, 0.0, 2.0, 1.0];
        particles.properties = vec![Property { name: "q".into(), values }];
        let rule = format!("radius=0.1, color=q, map=grey, range={range}");
        let balls = balls(particles, &recipe(&[rule.as_str()])).unwrap();
        [0.0, 3.0].map(|x| at(&balls, x).1)
    };
    let of = |places: [f64; 2]| places.map(|place| matte(Map::Grey.at(place)));
    assert_eq!(colors("0%..100%"), of([0.03, 0.02]));
    // Places 0.4 and 3.6 of 0 to 4.
    assert_eq!(colors("10%..90%"), of([0.03, 0.02]));
    // Places 0.6 and 3.4.
    assert_eq!(colors("15%..85%"), of([1.0, 0.5]));
}

#[test]
fn conditions_hold_whichever_side_the_column_is_on() {
    let xs = |condition: &str| {
        let style = ["radius=0.1, hide", &format!("{condition}: hide=false")];
        let balls = balls(few(), &recipe(&style));
        balls.map_or(Vec::new(), |balls| balls.spheres.iter().map(|sphere| sphere.center.x).collect())
    };
    for (sign, turned) in [("<", ">"), ("<=", ">="), (">", "<"), (">=", "<="), ("==", "=="), ("!=", "!=")] {
        for bound in ["0", "0.96", "5", "-9", "9"] {
            let (column_first, column_last) = (format!("x {sign} {bound}"), format!("{bound} {turned} x"));
            assert_eq!(xs(&column_first), xs(&column_last), "{column_first}");
        }
    }
    assert_eq!((xs("0.96 <= x"), xs("0.96 < x")), (vec![0.96, 5.0], vec![5.0]));
}

#[test]
fn what_does_not_suit_the_file_is_refused() {
    let refused = |style: &[&str]| balls(few(), &recipe(style)).unwrap_err();
    for (style, rule, key, expected) in [
        (
            &["color=chrge"][..],
            0,
            "color",
            "there is no column `chrge` (did you mean charge?); the file has x, y, z",
        ),
        (&["hide", "radius=type"], 1, "radius", "`type` is a text"),
        (&["z > 1: color=red", "chain == 'A': hide"], 1, "where", "column 1: there is no column `chain`"),
        (&["map=viridis"], 0, "map", "this is for a color by a column of numbers"),
        (&["color=type, map=viridis"], 0, "color", "a map and its range are for a column of numbers"),
        (&["color=file"], 0, "color", "the file has no colours"),
    ] {
        let Refusal { rule: there, key: at, problem } = refused(style);
        assert_eq!((there, at), (Some(rule), key), "{problem}");
        assert!(problem.starts_with(expected), "{problem}");
    }
    let refused = |recipe: Recipe| balls(few(), &recipe).unwrap_err().to_string();
    let cut = vec![Selection::parse("x > 100").unwrap()];
    assert_eq!(refused(Recipe { cut, ..Recipe::default() }), "cut: no particle is left to be shown");
    assert_eq!(refused(Recipe { wrap: true, ..Recipe::default() }), "wrap: the file has no periodic cell");
    assert_eq!(refused(Recipe { cell: true, ..Recipe::default() }), "cell: the file has no cell");
    assert!(refused(recipe(&["radius=1e20"])).starts_with("file: a radius is 1e20"));
    let refused = |particles: Particles| balls(particles, &recipe(&[])).unwrap_err().to_string();
    assert_eq!(refused(Particles::new(Format::Xyz)), "file: there is no particle in it");
    let mut far = few();
    far.positions[3] = [0.0, -1e16, 0.0];
    assert_eq!(refused(far), "file: a particle is farther than 1e15 from the origin; take another unit");
}

#[test]
fn particles_without_a_radius_are_told() {
    let made = made(&["radius=charge"]);
    assert_eq!((made.spheres.len(), made.notes.len()), (2, 1));
    assert!(made.notes[0].starts_with("2 particles without a radius"), "{:?}", made.notes);
    // Of those that would be shown: the others were left out by whoever asked for that.
    let notes = |style: &[&str], cut: &str| {
        balls(few(), &Recipe { cut: vec![Selection::parse(cut).unwrap()], ..recipe(style) }).unwrap().notes
    };
    let one = ["1 particle without a radius above 0 is not shown"];
    assert_eq!(notes(&["radius=charge"], "x < 3"), one);
    assert_eq!(notes(&["radius=charge", "x == 0: hide"], "x < 9"), one);
    assert_eq!(notes(&["radius=charge", "x == 0: hide"], "x < 3"), [""; 0]);
}

#[test]
fn glass_that_overlaps_is_told() {
    let notes = |style: &[&str]| made(style).notes.len();
    assert_eq!(notes(&["material=glass, radius=0.6"]), 1);
    assert_eq!(notes(&["material=glass, radius=0.45"]), 0);
    assert_eq!(notes(&["material=mirror, radius=0.6"]), 0);
}

#[test]
fn cuts_keep_what_they_select() {
    let cut = ["x < 3", "element == 'H'"].map(|text| Selection::parse(text).unwrap()).to_vec();
    let made = balls(few(), &Recipe { cut, ..Recipe::default() }).unwrap();
    assert_eq!(made.spheres.len(), 2);
    // What is cut away comes back by no rule, and does not count for the range of a map.
    let cut = vec![Selection::parse("x < 3").unwrap()];
    let made = balls(few(), &Recipe { cut, ..recipe(&["color=x", "x > 0: hide=false"]) }).unwrap();
    assert_eq!((made.spheres.len(), at(&made, 0.96).1), (3, matte(Map::Viridis.at(1.0))));
}

#[test]
fn what_is_far_from_the_origin_keeps_its_digits() {
    let mut particles = few();
    for position in &mut particles.positions {
        *position = position.map(|x| x + 1e9);
    }
    let origin = [1e9; 3];
    let far = balls(particles, &Recipe { origin, ..Recipe::default() }).unwrap();
    let near = made(&[]);
    for (a, b) in far.spheres.iter().zip(&near.spheres) {
        // The positions themselves are rounded to multiples of 2^-23.
        assert!(a.center.distance(b.center) < 1e-6, "{} {}", a.center, b.center);
    }
}

#[test]
fn radii_follow_the_unit_of_the_file() {
    for (scale, unit) in [(1.0, None), (0.1, None), (1e-10, None), (1e-10, Some("metre"))] {
        let mut particles = few();
        particles.format = Format::Xyz;
        for position in &mut particles.positions {
            *position = position.map(|x| x * scale);
        }
        let mut recipe = Recipe::default();
        if let Some(unit) = unit {
            recipe.set("unit", unit).unwrap();
        }
        let balls = balls(particles, &recipe).unwrap();
        let radius = balls.spheres.iter().find(|s| s.center == Vec3::ZERO).unwrap().radius;
        let share = f64::from(radius) / scale / 1.52;
        assert!((share - 1.0).abs() < 1e-6, "{scale}: {radius}");
        // Also that of an element that is not known.
        let radius = balls.spheres.iter().map(|s| s.center.x).zip(balls.spheres.iter().map(|s| s.radius));
        let (_, unknown) =
            radius.fold((f32::NEG_INFINITY, 0.0), |last, new| if new.0 > last.0 { new } else { last });
        assert!((f64::from(unknown) / scale / 1.5 - 1.0).abs() < 1e-6, "{scale}: {unknown}");
    }
}

/// Neighbours in liquid argon and in salt are further apart than bonds are long; in files in nanometres, as many of XYZ are.
#[test]
fn units_are_told_by_neighbours_that_are_no_bonds() {
    for (element, distance, covalent) in
        [(18, 3.76, 1.06), (11, 2.82, 1.66), (29, 2.56, 1.32), (6, 1.42, 0.76)]
    {
        for unit in [1.0, 0.1, 1e-10] {
            let mut particles = Particles::new(Format::Xyz);
            particles.positions = (0..9).map(|i| [f64::from(i) * distance * unit, 0.0, 0.0]).collect();
            particles.elements = Some(vec![element; 9]);
            let balls = balls(particles, &recipe(&["radius=covalent"])).unwrap();
            let share = f64::from(balls.spheres[0].radius) / unit / covalent;
            assert!((share - 1.0).abs() < 1e-6, "element {element}, unit {unit}: {share}");
        }
    }
}

/// However far the distances of neighbours are from those of bonds, and unless another unit is asked for.
#[test]
fn a_unit_that_is_stated_is_believed() {
    for (format, unit, distance, asked, expected) in [
        (Format::Gro, Unit::Nanometre, 10.0, None, 0.106),
        (Format::Gro, Unit::Nanometre, 10.0, Some("angstrom"), 1.06),
        (Format::Pdb, Unit::Angstrom, 0.2, None, 1.06),
        (Format::Pdb, Unit::Angstrom, 0.2, Some("nanometre"), 0.106),
        (Format::Dump, Unit::Metre, 1.0, None, 1.06e-10),
        (Format::Dump, Unit::Unknown, 0.2, None, 0.106),
    ] {
        let mut particles = Particles::new(format);
        particles.unit = unit;
        particles.positions = (0..9).map(|i| [f64::from(i) * distance, 0.0, 0.0]).collect();
        particles.elements = Some(vec![18; 9]);
        let mut recipe = recipe(&["radius=covalent"]);
        if let Some(asked) = asked {
            recipe.set("unit", asked).unwrap();
        }
        let balls = balls(particles, &recipe).unwrap();
        let share = f64::from(balls.spheres[0].radius) / expected;
        assert!((share - 1.0).abs() < 1e-6, "{format:?} in {unit:?}, {asked:?}: {share}");
    }
}

/// What a file says of the looks of its particles goes before what is known of elements, and that before types.
#[test]
fn colours_are_of_the_file_then_of_elements_then_of_types() {
    let colors = |has: [bool; 3]| {
        let mut particles = few();
        particles.colors = has[0].then(|| vec![[1.0, 0.5, 0.0]; 4]);
        particles.elements = particles.elements.filter(|_| has[1]);
        particles.types = particles.types.filter(|_| has[2]);
        let balls = balls(particles, &recipe(&["radius=0.1"])).unwrap();
        [0.0, 0.96, 5.0].map(|x| at(&balls, x).1)
    };
    let of = |codes: [[u8; 3]; 3]| codes.map(|codes| matte(Screen(codes)));
    assert_eq!(colors([true; 3]), of([[255, 128, 0]; 3]));
    assert_eq!(colors([false, true, true]), of([[255, 13, 13], [255; 3], [160; 3]]));
    assert_eq!(colors([false, false, true]), [palette(1), palette(0), palette(1)].map(matte));
    let [one, two, three] = colors([false; 3]);
    assert!(one == two && two == three);
}

/// The particles of [`few`] with all columns that files have, each with an order of its own.
fn with_all_columns() -> Particles {
    let mut particles = few();
    particles.positions[3][2] = 2.0;
    let labels = |names: &[&str], index: [u16; 4]| {
        Some(Labels { names: names.iter().map(ToString::to_string).collect(), index: index.to_vec() })
    };
    particles.names = labels(&["OW", "HW1", "HW2", "NA"], [0, 1, 2, 3]);
    particles.residues = labels(&["SOL", "ION"], [0, 0, 0, 1]);
    particles.chains = labels(&["A", "B"], [0, 1, 1, 0]);
    particles.residue_numbers = Some(vec![7, 7, 8, -3]);
    particles.molecules = Some(vec![5, 3, 5, 9]);
    particles.ids = Some(vec![40, 30, 20, 10]);
    particles
}

#[test]
fn every_column_is_known_by_its_name() {
    for (condition, expected) in [
        ("y > 0.5", &[-0.24][..]),
        ("z > 1", &[5.0]),
        ("element == 'O'", &[0.0]),
        ("type == 10", &[0.0, 5.0]),
        ("name == 'HW1'", &[0.96]),
        ("residue == 'ION'", &[5.0]),
        ("chain == 'B'", &[-0.24, 0.96]),
        ("resid == 8", &[-0.24]),
        ("resid < 0", &[5.0]),
        ("molecule == 5", &[-0.24, 0.0]),
        ("id >= 30", &[0.0, 0.96]),
        ("charge > 0", &[-0.24, 0.96]),
    ] {
        let style = ["radius=0.1, hide", &format!("{condition}: hide=false")];
        let balls = balls(with_all_columns(), &recipe(&style)).unwrap();
        let found: Vec<f32> = balls.spheres.iter().map(|sphere| sphere.center.x).collect();
        assert_eq!(found, expected, "{condition}");
    }
    // Molecules have a palette, by their numbers.
    let balls_of = |rule: &str| balls(with_all_columns(), &recipe(&[rule]));
    let colored = balls_of("radius=0.1, color=molecule").unwrap();
    let colors = [0.96, 0.0, -0.24, 5.0].map(|x| at(&colored, x).1);
    assert_eq!(colors, [palette(0), palette(1), palette(1), palette(2)].map(matte));
    let refused = balls_of("color=molecule, range=0..1").unwrap_err().problem;
    assert_eq!(refused, "a map and its range are for a column of numbers, and `molecule` is none");
}

/// A second ball in the same place shows nothing, and one of glass would be wrong.
#[test]
fn particles_in_the_same_place_are_one_ball_if_they_look_alike() {
    let twice = |name: &str| {
        let mut particles = few();
        particles.positions.extend_from_within(..);
        particles.elements.as_mut().unwrap().extend_from_within(..);
        particles.types.as_mut().unwrap().index.extend_from_within(..);
        particles.properties[0].values.extend((0..4_u8).map(f32::from));
        balls(particles, &recipe(&[name])).unwrap().spheres.len()
    };
    assert_eq!(twice("material=glass, radius=0.3"), 4);
    // By the values of the second ones, of which the first has no radius.
    assert_eq!(twice("radius=charge"), 2 + 3);
}

#[test]
fn rules_scale_what_rules_before_have_made() {
    let with_radii = |style: &[&str]| {
        let mut particles = few();
        particles.radii = Some(vec![0.5, 0.25, 0.25, 1.0]);
        balls(particles, &recipe(style)).unwrap()
    };
    let of = |style: &[&str]| [0.0, 0.96].map(|x| at(&with_radii(style), x).0);
    assert_eq!(of(&[]), [0.5, 0.25]);
    assert_eq!(of(&["scale=2"]), [1.0, 0.5]);
    assert_eq!(of(&["scale=2", "element == 'O': scale=3"]), [3.0, 0.5]);
    assert_eq!(of(&["radius=0.125", "scale=4", "x > 0: scale=2"]), [0.5, 1.0]);
    // Also what selects by radii sees them so.
    let red = matte(Screen::parse("red").unwrap());
    let scaled = with_radii(&["scale=2", "radius < 0.6: color=red"]);
    assert_eq!([0.0, 0.96].map(|x| at(&scaled, x).1 == red), [false, true]);
}

#[test]
fn neighbours_touch_where_nothing_is_known() {
    let mut particles = Particles::new(Format::Npy);
    particles.positions = (0..10).map(|i| [f64::from(i) * 3.0, 0.0, 0.0]).collect();
    let balls = balls(particles, &Recipe::default()).unwrap();
    assert!(balls.spheres.iter().all(|sphere| sphere.radius == 1.5));
}

#[test]
fn particles_come_into_their_cell_and_its_edges_are_drawn() {
    let mut particles = few();
    let vectors = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    particles.cell = Some(Cell { origin: [0.0; 3], vectors, periodic: [true; 3] });
    let balls = balls(particles, &Recipe { wrap: true, cell: true, ..Recipe::default() }).unwrap();
    let is_inside = |sphere: &scene::Sphere| (-1e-6..=4.0 + 1e-6).contains(&sphere.center.x);
    assert!(balls.spheres.iter().all(is_inside));
    assert!(balls.spheres.len() > 100);
}

#[test]
fn bonds_join_atoms() {
    let mut particles = few();
    particles.bonds = vec![[0, 1], [0, 2]];
    let mut recipe = Recipe::default();
    recipe.set("bonds", "file").unwrap();
    let balls = balls(particles, &recipe).unwrap();
    assert!(balls.spheres.len() > 10);
    // Half of each bond has the colour of its atom, so there are no further materials.
    assert_eq!(balls.materials.len(), 3);
    assert_eq!(at(&balls, 0.0).0, 0.25 * 1.52);
}

/// Radii of elements are shown at a quarter between bonds; those that a file states are meant as they are.
#[test]
fn radii_of_the_file_are_kept_between_bonds() {
    let mut particles = few();
    particles.bonds = vec![[0, 1], [0, 2]];
    particles.radii = Some(vec![0.5, 0.25, 0.25, 0.125]);
    let mut recipe = Recipe::default();
    recipe.set("bonds", "file").unwrap();
    let balls = balls(particles, &recipe).unwrap();
    let largest = |x: f32| {
        let there = balls.spheres.iter().filter(|sphere| sphere.center == Vec3::X * x);
        there.map(|sphere| sphere.radius).fold(0.0, f32::max)
    };
    assert_eq!([0.0, 0.96, 5.0].map(largest), [0.5, 0.25, 0.125]);
}

/// A bond with one end alone would be a stick in the air.
#[test]
fn bonds_of_hidden_particles_are_not_drawn() {
    let balls_of = |style: &[&str]| {
        let mut particles = few();
        particles.bonds = vec![[0, 1], [1, 2], [2, 3]];
        let mut recipe = recipe(style);
        recipe.set("bonds", "file").unwrap();
        balls(particles, &recipe).unwrap().spheres.len()
    };
    let all = balls_of(&[]);
    assert!(all > 10);
    // Of each bond one end is left.
    assert_eq!(balls_of(&["element == 'H' and x < 0: hide", "element == 'H': hide"]), 2);
    // Both ends of the first.
    let some = balls_of(&["element == 'H' and x < 0: hide"]);
    assert!(some > 3 && some < all, "{some} of {all}");
}

/// A cell may begin anywhere, and with it its atoms.
#[test]
fn bonds_through_sides_are_where_the_cell_is() {
    let balls_at = |origin: [f64; 3]| {
        let mut particles = few();
        particles.positions = [[0.5, 1.0, 1.0], [3.75, 1.0, 1.0], [2.0, 3.5, 1.0], [2.0, 0.5, 1.0]]
            .map(|p| [0, 1, 2].map(|axis| p[axis] + origin[axis]))
            .to_vec();
        particles.bonds = vec![[0, 1], [2, 3]];
        let vectors = [[4.0, 0.0, 0.0], [1.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        particles.cell = Some(Cell { origin, vectors, periodic: [true; 3] });
        let mut recipe = Recipe { origin, ..recipe(&["radius=0.25"]) };
        recipe.set("bonds", "file").unwrap();
        balls(particles, &recipe).unwrap().spheres
    };
    let usual = balls_at([0.0; 3]);
    assert!(usual.len() > 10);
    // No half of a bond is longer than half of the shortest way, 0.75.
    assert!(usual.iter().all(|ball| ball.center.x < 4.5 && ball.center.x > 0.0), "{usual:?}");
    for origin in [[-64.0, 32.0, 8.0], [3.0, 3.0, 3.0], [-2.5, 1.75, 0.5]] {
        let moved = balls_at(origin);
        assert_eq!(moved.len(), usual.len(), "{origin:?}");
        for (a, b) in moved.iter().zip(&usual) {
            // Rounding of coordinates up to 64.
            assert!(
                a.center.distance(b.center) < 1e-5 && a.radius == b.radius,
                "{origin:?}: {a:?} for {b:?}"
            );
        }
    }
}

proptest! {
    #[test]
    fn the_order_of_the_file_is_of_no_account(
        rows in prop::collection::vec((prop::array::uniform3(-3_i8..3), 0..4_u8, 0..5_u16, -2.0..2.0_f32), 1..40),
        turn in 0..40_usize,
    ) {
        let particles = |rows: &[([i8; 3], u8, u16, f32)]| {
            let mut particles = Particles::new(Format::Xyz);
            particles.positions = rows.iter().map(|row| row.0.map(f64::from)).collect();
            particles.elements = Some(rows.iter().map(|row| row.1).collect());
            // Readers number names as they come.
            let mut labels = Labels::default();
            for row in rows {
                let name = row.2.to_string();
                let known = labels.names.iter().position(|there| *there == name);
                labels.index.push(known.unwrap_or_else(|| { labels.names.push(name); labels.names.len() - 1 }) as u16);
            }
            particles.types = Some(labels);
            particles.properties = vec![Property { name: "q".into(), values: rows.iter().map(|row| row.3).collect() }];
            particles
        };
        let mut turned = rows.clone();
        turned.rotate_left(turn % rows.len());
        turned.reverse();
        for style in [&[][..], &["color=type"], &["color=q, range=10%..90%, radius=touch", "type == 3: material=light"]] {
            let mut recipe = recipe(style);
            recipe.set("bonds", "distance").unwrap();
            prop_assert_eq!(balls(particles(&rows), &recipe), balls(particles(&turned), &recipe));
        }
    }
}
