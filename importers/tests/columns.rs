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
fn radii_are_radii_or_halves_of_diameters() {
    let (radius, diameter) = (("radius", ["0.5", "2"]), ("diameter", ["3", "8"]));
    let radii = ("radii", radius.1);
    let rows = |columns: &[(&str, [&str; 2])], separator: &str| {
        let row = |k: usize| columns.iter().map(|(_, values)| values[k]).collect::<Vec<_>>().join(separator);
        format!("{}\n{}\n", row(0), row(1))
    };
    for (more, expected, others) in [
        (vec![radius], [0.5, 2.0], None),
        (vec![diameter], [1.5, 4.0], None),
        (vec![radius, diameter], [0.5, 2.0], Some([3.0, 8.0])),
        (vec![diameter, radius], [0.5, 2.0], Some([3.0, 8.0])),
        (vec![radii, diameter], [0.5, 2.0], Some([3.0, 8.0])),
        (vec![diameter, radii], [0.5, 2.0], Some([3.0, 8.0])),
    ] {
        let columns = [&PLACES[..], &more].concat();
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let extended =
            format!("2\nProperties=pos:R:3:{}:R:1\n{}", names[3..].join(":R:1:"), rows(&columns, " "));
        let table = format!("{}\n{}", names.join(","), rows(&columns, ","));
        let declared =
            names.iter().map(|name| format!("property float {name}\n")).collect::<Vec<_>>().concat();
        let points =
            format!("ply\nformat ascii 1.0\nelement vertex 2\n{declared}end_header\n{}", rows(&columns, " "));
        let dumped = dump(None, &columns);
        for (format, text) in
            [(Format::Dump, dumped), (Format::Xyz, extended), (Format::Csv, table), (Format::Ply, points)]
        {
            // To LAMMPS `radii` is a name like any other.
            if format == Format::Dump && more.contains(&radii) {
                continue;
            }
            let particles = parse(format, &text);
            assert_eq!(particles.len(), 2);
            assert_eq!(particles.radii.as_deref(), Some(&expected[..]), "{format:?} {more:?}");
            let others = others.as_ref().map(|values| &values[..]);
            assert_eq!(particles.property("diameter"), others, "{format:?} {more:?}");
        }
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

/// Of the columns beyond the position, plain XYZ needs in every row those that are asked for, and what stands before them.
#[test]
fn rows_of_plain_xyz_may_end_before_columns_that_nobody_asks_for() {
    let fields = ["O", "4", "5", "6", "0.5", "0.25", "0.75", "0.125"];
    for count in 3..=fields.len() {
        let text = format!("2\n\nO 1 2 3 1.5 1.25 1.75\n{}\n", fields[..count].join(" "));
        for last in 4..=7 {
            let name = format!("column_{last}");
            let properties = if last == 4 { Properties::None } else { Properties::Named(vec![name.clone()]) };
            let request = Request { properties, ..Request::default() };
            let particles = read_from("a", Cursor::new(text.as_bytes()), Format::Xyz, &request);
            if count < last {
                let error = particles.unwrap_err().problem;
                assert_eq!(error, format!("the line has {count} of {last} fields: a symbol and x, y, z"));
                continue;
            }
            let particles = particles.unwrap();
            assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
            assert_eq!(particles.available, ["column_5", "column_6", "column_7"]);
            let values = [[1.5, 0.5], [1.25, 0.25], [1.75, 0.75]];
            let expected = last.checked_sub(5).map(|at| &values[at][..]);
            assert_eq!(particles.property(&name), expected, "{count} fields, {name}");
        }
    }
}

/// In tables, numbers of every column may have a decimal comma; a comma in a text is one.
#[test]
fn decimal_commas_are_points_in_all_columns() {
    let header = "x y z radius red green blue type id charge note spin";
    let rows =
        ["1.5 -2.25 3 0.5 0.25 1 0.125 A,1 7 -0.25 2,4-a 1.5e-3", "-.5 4 5.75 2 1 0.5 0 2 8 3 5 -2.5E2"];
    for separator in [',', ';', '\t', ' '] {
        let table = |point: &str| {
            let line = |row: &str| {
                let field = |field: &str| {
                    let field = field.replace('.', point);
                    if field.contains(separator) { format!("\"{field}\"") } else { field }
                };
                row.split(' ').map(field).collect::<Vec<_>>().join(&separator.to_string())
            };
            format!("{}\n{}\n{}\n", line(header), line(rows[0]), line(rows[1]))
        };
        let particles = parse(Format::Csv, &table("."));
        assert_eq!(particles.positions, [[1.5, -2.25, 3.0], [-0.5, 4.0, 5.75]]);
        assert_eq!((&particles.radii, &particles.ids), (&Some(vec![0.5, 2.0]), &Some(vec![7, 8])));
        assert_eq!(particles.colors.as_deref(), Some(&[[0.25, 1.0, 0.125], [1.0, 0.5, 0.0]][..]));
        assert_eq!(particles.types.as_ref().map(|types| types.names.join(" ")).as_deref(), Some("A,1 2"));
        assert_eq!(particles.available, ["charge", "spin"]);
        assert_eq!(particles.property("charge"), Some(&[-0.25, 3.0][..]));
        assert_eq!(particles.property("spin"), Some(&[1.5e-3, -250.0][..]));
        assert_eq!(parse(Format::Csv, &table(",")), particles, "{separator:?}");
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
