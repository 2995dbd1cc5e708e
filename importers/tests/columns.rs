//! What each format makes of its columns, whatever they are called, however wide they are and in whichever order they stand.

use importers::{Format, Frame, Particles, Properties, Request, Unit, read_from};
use std::io::Cursor;

fn parse(format: Format, text: &str) -> Particles {
    let request = Request { frame: Frame::Number(0), properties: Properties::All, ..Request::default() };
    read_from("a", Cursor::new(text.as_bytes()), format, &request).unwrap()
}

/// A LAMMPS dump of two particles with these units and columns; of each column the values of both.
fn dump(units: Option<&str>, columns: &[(&str, [&str; 2])]) -> String {
    let units = units.map_or(String::new(), |units| format!("ITEM: UNITS\n{units}\n"));
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row = |k: usize| columns.iter().map(|(_, values)| values[k]).collect::<Vec<_>>().join(" ");
    format!(
        "{units}ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n0 40\n\
         ITEM: ATOMS {}\n{}\n{}\n",
        names.join(" "),
        row(0),
        row(1)
    )
}

const PLACES: [(&str, [&str; 2]); 3] = [("x", ["1", "2"]), ("y", ["3", "4"]), ("z", ["5", "6"])];

#[test]
fn lengths_of_dumps_are_in_the_units_that_they_name() {
    for (units, expected) in [
        (None, Unit::Unknown),
        (Some("lj"), Unit::Unknown),
        (Some("cgs"), Unit::Unknown),
        (Some("micro"), Unit::Unknown),
        (Some("electron"), Unit::Unknown),
        (Some("metal"), Unit::Angstrom),
        (Some("real"), Unit::Angstrom),
        (Some("nano"), Unit::Nanometre),
        (Some("si"), Unit::Metre),
    ] {
        assert_eq!(parse(Format::Dump, &dump(units, &PLACES)).unit, expected, "{units:?}");
    }
    let angstrom = [Unit::Angstrom, Unit::Nanometre, Unit::Metre, Unit::Unknown].map(Unit::in_angstrom);
    assert_eq!(angstrom, [Some(1.0), Some(10.0), Some(1e10), None]);
}

#[test]
fn coordinates_of_dumps_are_plain_scaled_or_unwrapped() {
    for (names, scale) in [
        (["x", "y", "z"], [1.0; 3]),
        (["xu", "yu", "zu"], [1.0; 3]),
        (["xs", "ys", "zs"], [10.0, 20.0, 40.0]),
        (["xsu", "ysu", "zsu"], [10.0, 20.0, 40.0]),
    ] {
        let values = [["0.25", "-0.5"], ["0.5", "1.5"], ["0.75", "0.125"]];
        let columns: Vec<(&str, [&str; 2])> = names.into_iter().zip(values).rev().collect();
        let particles = parse(Format::Dump, &dump(None, &columns));
        let expected = [[0.25, 0.5, 0.75], [-0.5, 1.5, 0.125]]
            .map(|place: [f64; 3]| std::array::from_fn(|axis| place[axis] * scale[axis]));
        assert_eq!(particles.positions, expected, "{names:?}");
    }
}

/// Half of a diameter is a radius, and where both are told the radius counts, in whichever order they stand.
#[test]
fn radii_of_dumps_are_radii_or_halves_of_diameters() {
    let (radius, diameter) = (("radius", ["0.5", "2"]), ("diameter", ["3", "8"]));
    for (more, expected, others) in [
        (vec![radius], [0.5, 2.0], None),
        (vec![diameter], [1.5, 4.0], None),
        (vec![radius, diameter], [0.5, 2.0], Some([3.0, 8.0])),
        (vec![diameter, radius], [0.5, 2.0], Some([3.0, 8.0])),
    ] {
        let particles = parse(Format::Dump, &dump(None, &[&PLACES[..], &more].concat()));
        assert_eq!(particles.radii.as_deref(), Some(&expected[..]), "{more:?}");
        assert_eq!(particles.property("diameter"), others.as_ref().map(|values| &values[..]), "{more:?}");
    }
}

#[test]
fn each_column_of_a_dump_has_its_meaning_or_is_a_property() {
    let columns = [
        &PLACES[..],
        &[("id", ["9", "4"]), ("type", ["2", "1"]), ("element", ["O", "H"]), ("mol", ["7", "8"])],
        &[("vx", ["0.5", "-1"]), ("q", ["1", "2"])],
    ]
    .concat();
    let particles = parse(Format::Dump, &dump(None, &columns));
    // By their ids.
    assert_eq!(particles.ids, Some(vec![4, 9]));
    assert_eq!(particles.positions, [[2.0, 4.0, 6.0], [1.0, 3.0, 5.0]]);
    assert_eq!(particles.elements, Some(vec![1, 8]));
    assert_eq!(particles.molecules, Some(vec![8, 7]));
    let types = particles.types.as_ref().unwrap();
    assert_eq!([types.name(0), types.name(1)], ["1", "2"]);
    assert_eq!(particles.property("vx"), Some(&[-1.0, 0.5][..]));
    assert_eq!(particles.property("q"), Some(&[2.0, 1.0][..]));
}

/// Columns of GRO are as wide as the first line shows by its decimal points, those of velocities too.
#[test]
fn gro_columns_are_as_wide_as_their_points_are_apart() {
    for decimals in 1..=9 {
        let (width, decimals_of_velocity) = (decimals + 5, decimals + 1);
        let number = |value: f64, decimals: usize| format!("{value:width$.decimals$}");
        let row = |id: u32, place: [f64; 3], velocity: [f64; 3]| {
            let place: String = place.into_iter().map(|v| number(v, decimals)).collect();
            let velocity: String = velocity.into_iter().map(|v| number(v, decimals_of_velocity)).collect();
            format!("{id:>5}SOL  {:>5}{id:>5}{place}{velocity}\n", "OW")
        };
        let [a, b] = [([0.5, -1.5, 12.5], [0.25, -0.5, 0.75]), ([7.5, 8.5, 9.5], [-0.25, 0.5, -0.75])];
        let text = format!("title\n2\n{}{}1 2 3\n", row(1, a.0, a.1), row(2, b.0, b.1));
        let particles = parse(Format::Gro, &text);
        let near = |a: f64, b: f64| (a - b).abs() <= 0.51 * 10.0_f64.powi(-(decimals as i32));
        for (found, expected) in particles.positions.iter().zip([a.0, b.0]) {
            assert!((0..3).all(|axis| near(found[axis], expected[axis])), "{decimals}: {found:?}");
        }
        for (axis, name) in ["velocity_x", "velocity_y", "velocity_z"].into_iter().enumerate() {
            let found = particles.property(name).unwrap_or_else(|| panic!("no {name} of {decimals}"));
            let expected = [a.1[axis], b.1[axis]];
            let is_near = found.iter().zip(expected).all(|(v, e)| near(f64::from(*v), e));
            assert!(is_near, "{name} of {decimals}: {found:?}, not {expected:?}");
        }
    }
}

/// `r` is a radius, unless it is red beside `g` and `b`; a diameter says nothing beside a radius.
#[test]
fn a_diameter_is_a_radius_where_none_is_stated() {
    for (head, radius) in [
        ("x,y,z,diameter,r,g,b", 2.0),
        ("x,y,z,diameter,red,green,blue", 2.0),
        ("x,y,z,diameter,r,a,b", 0.5),
        ("x,y,z,diameter,radius,g,b", 0.5),
    ] {
        let particles =
            parse(Format::Csv, &format!("{head}\n1,2,3,4,0.5,0.25,0.75\n5,6,7,4,0.5,0.25,0.75\n"));
        assert_eq!(particles.radii, Some(vec![radius; 2]), "{head}");
        assert_eq!(particles.colors.is_some(), radius == 2.0, "{head}");
    }
}
