//! Arrays of `NumPy`, alone and in archives.

use super::{fault, labels, parse};
use crate::specimens::{by_columns, gzip, npy, specimens, zip};
use importers::{Cell, Format, Frame, Request, frames, read_from};
use std::io::Cursor;

/// Frame by frame, plain and compressed; a structured array is of one frame whatever its shape.
#[test]
fn arrays_of_frames_are_trajectories() {
    let numbers: Vec<u8> = (0_u8..24).flat_map(|value| f64::from(value).to_le_bytes()).collect();
    let array = npy("'<f8'", "(4, 2, 3)", false, &numbers);
    let of = |bytes: &[u8], frame: Frame| {
        let request = Request { frame, ..Request::default() };
        read_from("a.npy", Cursor::new(bytes), Format::Npy, &request)
    };
    for (frame, number) in [(Frame::Number(0), 0), (Frame::Number(2), 2), (Frame::Last, 3)] {
        let particles = of(&array, frame).unwrap();
        let first = 6.0 * f64::from(number);
        let expected = [[first, first + 1.0, first + 2.0], [first + 3.0, first + 4.0, first + 5.0]];
        assert_eq!((particles.positions, particles.frame), (expected.to_vec(), number as usize));
    }
    assert!(of(&array, Frame::Number(4)).unwrap_err().to_string().contains("it has 4 frames, 0 to 3"));
    let short = of(&array[..array.len() - 1], Frame::Number(3)).unwrap_err().to_string();
    assert!(short.contains("too short for the 2 rows"), "{short}");
    assert!(of(&array[..array.len() - 1], Frame::Number(2)).is_ok());
    let with_radii = npy("'<f8'", "(3, 2, 4)", false, &numbers);
    assert_eq!(of(&with_radii, Frame::Number(1)).unwrap().radii, Some(vec![11.0, 15.0]));
    let mixed = npy("'<f8'", "(4, 2, 3)", true, &numbers);
    assert!(of(&mixed, Frame::Number(1)).unwrap_err().to_string().contains("ascontiguousarray"));
    assert_eq!(of(&gzip(&array), Frame::Number(3)).unwrap().positions[0], [18.0, 19.0, 20.0]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    std::fs::write(&path, &array).unwrap();
    assert_eq!(frames(&path).unwrap(), 4);
}

/// Whichever way the numbers of arrays follow each other, the archive says the same, of particles and of their cell.
#[test]
fn arrays_of_archives_may_be_in_either_order() {
    let vectors = [[4.0, 0.5, 0.0], [1.0, 5.0, -0.5], [-2.0, 1.5, 6.0]];
    for is_fortran in [false, true] {
        let array = |rows: &[f64], width: usize| {
            let bytes: Vec<u8> = rows.iter().flat_map(|number| number.to_le_bytes()).collect();
            let bytes = if is_fortran { by_columns(&bytes, width) } else { bytes };
            npy("'<f8'", &format!("({}, {width})", rows.len() / width), is_fortran, &bytes)
        };
        let files = [
            ("positions.npy", array(&[1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, 0.25], 4)),
            ("colors.npy", array(&[0.0, 0.25, 0.5, 0.75, 1.0, 0.125], 3)),
            ("force.npy", array(&[10.0, 20.0, 30.0, 40.0, 50.0, 60.0], 3)),
            ("spin.npy", array(&[7.0, 8.0, 9.0, 10.0], 2)),
            ("cell.npy", array(vectors.as_flattened(), 3)),
        ];
        for is_compressed in [false, true] {
            let particles = parse(Format::Npz, zip(&files, is_compressed));
            assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
            assert_eq!(particles.radii.as_deref(), Some(&[0.5, 0.25][..]));
            assert_eq!(particles.colors.as_deref(), Some(&[[0.0, 0.25, 0.5], [0.75, 1.0, 0.125]][..]));
            for (name, values) in [
                ("force_x", [10.0, 40.0]),
                ("force_y", [20.0, 50.0]),
                ("force_z", [30.0, 60.0]),
                ("spin_0", [7.0, 9.0]),
                ("spin_1", [8.0, 10.0]),
            ] {
                assert_eq!(particles.property(name), Some(&values[..]), "{name}");
            }
            let cell = Cell { origin: [0.0; 3], vectors, periodic: [true; 3] };
            assert_eq!(particles.cell, Some(cell), "Fortran: {is_fortran}");
        }
    }
}

/// As in an array alone; and where radii are told twice, what the archive has first counts.
#[test]
fn positions_in_archives_may_have_radii_beside_them() {
    let numbers =
        |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let plain = npy("'<f8'", "(2, 3)", false, &numbers(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    let with_radii = npy("'<f8'", "(2, 4)", false, &numbers(&[1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0, 0.25]));
    let radii = npy("'<f8'", "(2,)", false, &numbers(&[7.0, 8.0]));
    let charges = npy("'<f8'", "(2,)", false, &numbers(&[-1.0, 1.0]));
    let of = |files: &[(&str, &Vec<u8>)]| {
        let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(name, data)| (*name, (*data).clone())).collect();
        let particles = parse(Format::Npz, zip(&files, false));
        assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{}", files[0].0);
        particles
    };
    for name in
        ["pos", "position", "positions", "xyz", "points", "centers", "centres", "coordinates", "Coords"]
    {
        let name = format!("{name}.npy");
        assert_eq!(of(&[(&name, &plain), ("charge.npy", &charges)]).radii, None, "{name}");
        let particles = of(&[("charge.npy", &charges), (&name, &with_radii)]);
        assert_eq!(particles.radii.as_deref(), Some(&[0.5, 0.25][..]), "{name}");
        assert_eq!(particles.available, ["charge"], "{name}");
    }
    for (name, expected) in [("radii.npy", [7.0, 8.0]), ("diameters.npy", [3.5, 4.0])] {
        let second = of(&[(name, &radii), ("xyz.npy", &with_radii)]);
        assert_eq!(second.radii.as_deref(), Some(&expected[..]), "{name}");
        let both = of(&[("xyz.npy", &with_radii), (name, &radii)]);
        assert_eq!(both.radii.as_deref(), Some(&[0.5, 0.25][..]), "{name}");
    }
    let third = of(&[("diameters.npy", &charges), ("radii.npy", &radii), ("xyz.npy", &plain)]);
    assert_eq!(third.radii.as_deref(), Some(&[7.0, 8.0][..]), "a diameter says nothing beside a radius");
}

/// Later versions have longer headers, or names in other alphabets; and some machines write the greatest byte first.
#[test]
fn arrays_of_all_versions_and_byte_orders_are_read() {
    let [little, big]: [Vec<u8>; 2] = [f64::to_le_bytes, f64::to_be_bytes]
        .map(|bytes| [1.0, -2.5, 3.0, 0.1, 5.0, 600.0].into_iter().flat_map(bytes).collect());
    let first = npy("'<f8'", "(2, 3)", false, &little);
    let right = parse(Format::Npy, &first);
    assert_eq!(right.positions, [[1.0, -2.5, 3.0], [0.1, 5.0, 600.0]]);
    assert_eq!(parse(Format::Npy, npy("'>f8'", "(2, 3)", false, &big)), right);
    for version in [2, 3] {
        // The length of the header has four bytes instead of two.
        let later = [&first[..6], &[version, 0], &first[8..10], &[0, 0], &first[10..]].concat();
        assert_eq!(parse(Format::Npy, later), right, "version {version}");
    }
    let whole: Vec<u8> = [1_i16, -2, 300].into_iter().flat_map(i16::to_be_bytes).collect();
    assert_eq!(parse(Format::Npy, npy("'>i2'", "(1, 3)", false, &whole)).positions, [[1.0, -2.0, 300.0]]);
}

/// Whole numbers are shares of the greatest of their type, however dark a picture is; and of four components the last is no
/// colour.
#[test]
fn colours_of_arrays_are_scaled_by_their_type_and_have_no_alpha() {
    let colors = |descr: &str, shape: &str, numbers: &[u8]| {
        let files = [
            ("positions.npy", npy("'<f8'", "(2, 3)", false, &[0; 48])),
            ("colors.npy", npy(descr, shape, false, numbers)),
        ];
        parse(Format::Npz, zip(&files, false)).colors.unwrap()
    };
    let dark = [[1.0 / 255.0, 0.0, 0.0], [0.0, 1.0 / 255.0, 0.0]];
    assert_eq!(colors("'|u1'", "(2, 3)", &[1, 0, 0, 0, 1, 0]), dark);
    assert_eq!(colors("'|u1'", "(2, 4)", &[51, 0, 255, 7, 1, 0, 0, 9]), [[0.2, 0.0, 1.0], dark[0]]);
    let words: Vec<u8> =
        [65_535_u16, 0, 13_107, 0, 65_535, 0].into_iter().flat_map(u16::to_le_bytes).collect();
    assert_eq!(colors("'<u2'", "(2, 3)", &words), [[1.0, 0.0, 0.2], [0.0, 1.0, 0.0]]);
    // What NumPy makes of whole numbers that are given no type.
    let wide: Vec<u8> = [255_i64, 0, 51, 0, 255, 0].into_iter().flat_map(i64::to_le_bytes).collect();
    assert_eq!(colors("'<i8'", "(2, 3)", &wide), [[1.0, 0.0, 0.2], [0.0, 1.0, 0.0]]);
    let floats: Vec<u8> =
        [0.25_f32, 0.5, 0.75, 0.125, 1.0, 0.0, 0.5, 0.375].into_iter().flat_map(f32::to_le_bytes).collect();
    assert_eq!(colors("'<f4'", "(2, 4)", &floats), [[0.25, 0.5, 0.75], [1.0, 0.0, 0.5]]);
    let row = [&[0; 12][..], &[51, 0, 255, 7]].concat();
    let structured = npy("[('pos', '<f4', (3,)), ('rgba', '|u1', (4,))]", "(1,)", false, &row);
    assert_eq!(parse(Format::Npy, structured).colors.unwrap(), [[0.2, 0.0, 1.0]]);
}

/// A cell by its edges, and where it begins and along which of them it repeats; and columns of whole numbers and texts.
#[test]
fn archives_tell_the_cell_and_what_particles_are() {
    let numbers =
        |numbers: &[f64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let words = |numbers: &[i32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let text = "A\0BC".chars().flat_map(|c| u32::from(c).to_le_bytes()).collect::<Vec<u8>>();
    for (cell, origin) in [("cell", "origin"), ("box", "cell_origin"), ("lattice", "Origin")] {
        let [cell, origin] = [cell, origin].map(|name| format!("{name}.npy"));
        let files = [
            ("pbc.npy", npy("'|b1'", "(3,)", false, &[1, 0, 1])),
            (origin.as_str(), npy("'<f8'", "(3,)", false, &numbers(&[1.0, -2.0, 0.5]))),
            (cell.as_str(), npy("'<f8'", "(3,)", false, &numbers(&[4.0, 5.0, 6.0]))),
            ("positions.npy", npy("'<f8'", "(2, 3)", false, &numbers(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))),
            ("types.npy", npy("'<i4'", "(2,)", false, &words(&[3, -1]))),
            ("elements.npy", npy("'<i4'", "(2,)", false, &words(&[8, 1]))),
            ("molecules.npy", npy("'<i4'", "(2,)", false, &words(&[7, 9]))),
            ("chains.npy", npy("'<U2'", "(2,)", false, &text)),
            ("Charge.npy", npy("'<i4'", "(2,)", false, &words(&[-2, 1]))),
        ];
        let particles = parse(Format::Npz, zip(&files, true));
        let vectors = [[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.0]];
        let right = Cell { origin: [1.0, -2.0, 0.5], vectors, periodic: [true, false, true] };
        assert_eq!(particles.cell, Some(right), "{cell} {origin}");
        assert_eq!(labels(particles.types.as_ref()), ["3", "-1"]);
        assert_eq!(labels(particles.chains.as_ref()), ["A", "BC"]);
        assert_eq!((&particles.elements, &particles.molecules), (&Some(vec![8, 1]), &Some(vec![7, 9])));
        // Columns keep their names as they are written.
        assert_eq!(particles.available, ["Charge"]);
        assert_eq!(particles.property("Charge"), Some(&[-2.0, 1.0][..]));
    }
}

#[test]
fn faults_of_arrays_say_what_to_save() {
    let fault = |descr: &str, shape: &str, data: &[u8]| fault(Format::Npy, npy(descr, shape, false, data));
    assert!(
        fault("'<f8'", "(3, 10)", &[0; 240])
            .contains("has shape (3, 10), and should have (N, 3) or (N, 4): save array.T")
    );
    assert!(fault("'<f8'", "(2, 10, 5)", &[0; 800]).contains("frames of these"));
    assert!(fault("'<f8'", "(2, 10, 3)", &[0; 239]).contains("too short for the 10 rows"));
    assert!(fault("'<f8'", "(0, 10, 3)", &[]).contains("has no frame"));
    assert!(fault("'<f8'", "(1, 4611686018427387904, 3)", &[0; 24]).contains("more numbers than any file"));
    assert!(fault("'<f8'", "(10,)", &[0; 80]).contains("particles are (N, 3)"));
    assert!(fault("'<c16'", "(10, 3)", &[0; 480]).contains("use array.astype(\"f4\")"));
    assert!(fault("'|O'", "(10, 3)", &[0; 480]).contains("which is not read"));
    assert!(fault("'<f8'", "(10, 3)", &[0; 239]).contains("too short for the 10 rows"));
    assert!(fault("'<f8'", "(1152921504606846976, 3)", &[0; 240]).contains("too short"));
    assert!(fault("'<f8'", "(1, 3)", &[0xff; 24]).contains("row 0: the coordinate is NaN"));
    assert!(fault(&"(".repeat(5000), "(10, 3)", &[]).contains("the header describes no array"));
    assert!(fault("[('x', '<f4'), ('y', '<f4')]", "(1,)", &[0; 8]).contains("has no columns x, y and z"));
}

#[test]
fn faults_of_archives_name_the_array() {
    let radii = npy("'<f8'", "(2,)", false, &[0; 16]);
    let positions = npy("'<f8'", "(3, 3)", false, &[0; 72]);
    let fault = |files: &[(&str, Vec<u8>)]| fault(Format::Npz, zip(files, true));
    assert!(
        fault(&[("positions.npy", positions.clone()), ("radii.npy", radii.clone())])
            .contains("has 3 positions, but another column has 2")
    );
    assert!(
        fault(&[("radii.npy", radii.clone()), ("a.npy", radii)]).contains("has no array called positions")
    );
    let wrong = npy("'<f8'", "(3, 3)", false, &[0xff; 72]);
    assert!(fault(&[("positions.npy", wrong), ("b.npy", positions)]).contains("array \"positions\": byte"));
    let mut damaged = specimens().into_iter().find(|specimen| specimen.name == "npz").unwrap().bytes;
    damaged[5000] ^= 1;
    let error = read_from("a", Cursor::new(damaged), Format::Npz, &Request::default()).unwrap_err();
    assert!(error.problem.contains("array \"positions\": cannot be read"), "{error}");
}
