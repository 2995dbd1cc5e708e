//! What is read of each format, frame by frame, and what is said of faults.

mod specimens;

use importers::{
    Cell, Format, Frame, Particles, Properties, Request, Trajectory, Unit, frames, read, read_from,
};
use specimens::{COUNT, by_columns, gsd_of, gzip, npy, place, specimens, zip};
use std::fmt::Write as _;
use std::io::Cursor;
use std::path::PathBuf;

/// Of `f32` numbers of size 100.
const SINGLE: f64 = 1e-5;

fn all(frame: Frame) -> Request {
    Request { frame, properties: Properties::All, ..Request::default() }
}

fn parse(format: Format, bytes: impl AsRef<[u8]>) -> Particles {
    read_from("a", Cursor::new(bytes.as_ref()), format, &all(Frame::Number(0))).unwrap()
}

/// The message for a fault, after the name.
fn fault(format: Format, bytes: impl AsRef<[u8]>) -> String {
    let error = read_from("a", Cursor::new(bytes.as_ref()), format, &all(Frame::Number(0))).unwrap_err();
    error.to_string().strip_prefix('a').unwrap().to_owned()
}

fn labels(labels: Option<&importers::Labels>) -> Vec<&str> {
    let labels = labels.unwrap();
    (0..labels.index.len()).map(|row| labels.name(row)).collect()
}

/// A file in a folder of its own, which is gone when the folder is dropped.
fn file(name: &str, bytes: impl AsRef<[u8]>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

#[test]
fn every_format_gives_the_same_positions() {
    for specimen in specimens() {
        // The others leave atoms out, repeat them, or scale them.
        if matches!(specimen.name, "pdb" | "mmcif" | "crystal" | "scaled dump") {
            continue;
        }
        let particles = parse(specimen.format, &specimen.bytes);
        assert_eq!(particles.len(), COUNT, "{}", specimen.name);
        let scale = if specimen.format == Format::Gro { 10.0 } else { 1.0 };
        let tolerance = match specimen.format {
            // Three decimals of a nanometre.
            Format::Gro => 0.5e-2 + SINGLE,
            Format::Xyz if specimen.name != "extended xyz" => 0.5e-4 + SINGLE,
            _ => SINGLE,
        };
        for (at, position) in particles.positions.iter().enumerate() {
            let far = (0..3).map(|axis| (scale * position[axis] - place(at)[axis]).abs()).fold(0.0, f64::max);
            assert!(far <= tolerance, "{}: particle {at} is at {position:?}", specimen.name);
        }
    }
}

#[test]
fn formats_are_told_by_content_or_name() {
    for specimen in specimens() {
        // Without a name, all but the two kinds of CIF and the compressed one, whose content is unmistakable too.
        let (_folder, path) = file("particles", &specimen.bytes);
        let particles = read(&path, &Request::default());
        if specimen.name == "extended xyz" || specimen.format != Format::Mmcif {
            assert_eq!(particles.unwrap().format, specimen.format, "{}", specimen.name);
        } else {
            assert_eq!(particles.unwrap().format, Format::Mmcif);
        }
    }
    let of = |name: &str| Format::of_name(name.as_ref());
    assert_eq!(
        [of("a.XYZ"), of("a.pdb.gz"), of("b/dump.melt.100"), of("a.toml")],
        [Some(Format::Xyz), Some(Format::Pdb), Some(Format::Dump), None]
    );
    let (_folder, path) = file("a.dat", b"\x28\xb5\x2f\xfdrest");
    assert!(read(&path, &Request::default()).unwrap_err().problem.contains("compressed by zstd"));
    let (_folder, path) = file("a.dat", "hello\n");
    assert!(read(&path, &Request::default()).unwrap_err().problem.contains("no known format"));
    let folder = tempfile::tempdir().unwrap();
    assert!(read(folder.path(), &Request::default()).unwrap_err().problem.contains("this is a directory"));
    let missing = read("missing.xyz".as_ref(), &Request::default()).unwrap_err();
    assert_eq!(missing.to_string(), "missing.xyz: there is no such file");
}

/// An ending that stands for a format goes before what comes earlier in a name.
#[test]
fn numbered_dumps_are_told_by_a_part_of_their_name() {
    let of = |name: &str| Format::of_name(name.as_ref());
    for name in [
        "dump.melt.1000",
        "melt.dump.0",
        "a.b.dump.c.7",
        "dump.melt",
        "Melt.Dump.7",
        "melt.dump.7.gz",
        "runs/melt.dump.7",
        "melt.dump",
        "melt.dump.gz",
    ] {
        assert_eq!(of(name), Some(Format::Dump), "{name}");
    }
    for name in
        ["dumpling.7", "dump_melt.7", "dump-1.7", "mydump.7", "melt.dumps.7", "dump.d/melt.7", "melt.7"]
    {
        assert_eq!(of(name), None, "{name}");
    }
    assert_eq!([of("dump.melt.xyz"), of("melt.dump.csv")], [Some(Format::Xyz), Some(Format::Csv)]);
}

#[test]
fn frames_are_found_by_number_and_from_the_end() {
    for (text, name) in [
        (specimens::extended_xyz(4).into_bytes(), "a.xyz"),
        (gzip(specimens::extended_xyz(4).as_bytes()), "a.xyz.gz"),
    ] {
        let (_folder, path) = file(name, text);
        assert_eq!(frames(&path).unwrap(), 4);
        let trajectory = Trajectory::open(&path).unwrap();
        assert_eq!((trajectory.frames(), trajectory.format()), (4, Format::Xyz));
        for number in [3, 0, 2] {
            let request = all(Frame::Number(number));
            let particles = trajectory.read(&request).unwrap();
            assert_eq!((particles.frame, particles.positions[0][0]), (number, number as f64));
            assert_eq!(particles, read(&path, &request).unwrap());
        }
        assert_eq!(trajectory.read(&all(Frame::Last)).unwrap(), read(&path, &all(Frame::Last)).unwrap());
        for error in [trajectory.read(&all(Frame::Number(4))), read(&path, &all(Frame::Number(4)))] {
            assert!(error.unwrap_err().problem.contains("has no frame 4; it has 4 frames, 0 to 3"));
        }
    }
    for (name, count) in [("a.pdb", 2), ("a.cif", 2), ("a.gsd", 2), ("a.csv", 1)] {
        let specimen = specimens()
            .into_iter()
            .find(|specimen| Some(specimen.format) == Format::of_name(name.as_ref()))
            .unwrap();
        let (_folder, path) = file(name, &specimen.bytes);
        let trajectory = Trajectory::open(&path).unwrap();
        assert_eq!(trajectory.frames(), count, "{name}");
        assert_eq!(trajectory.read(&all(Frame::Last)).unwrap().frame, count - 1);
        assert!(
            read(&path, &all(Frame::Number(count))).unwrap_err().problem.contains("has no frame"),
            "{name}"
        );
    }
}

#[test]
fn memory_is_refused_before_it_is_used() {
    for specimen in specimens() {
        let request = Request { memory: 1000, ..Request::default() };
        let error = read_from("a", Cursor::new(&specimen.bytes), specimen.format, &request).unwrap_err();
        assert!(error.problem.contains("memory"), "{}: {error}", specimen.name);
    }
}

#[test]
fn properties_are_read_if_they_are_asked_for() {
    let bytes = specimens::extended_xyz(1);
    let with = |properties: Properties| {
        let request = Request { properties, ..Request::default() };
        let particles = read_from("a", Cursor::new(&bytes), Format::Xyz, &request).unwrap();
        assert_eq!(particles.available, ["q", "fixed"]);
        particles.properties.iter().map(|property| property.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(with(Properties::None), [""; 0]);
    assert_eq!(with(Properties::Named(vec!["q".into(), "other".into()])), ["q"]);
    assert_eq!(with(Properties::All), ["q", "fixed"]);
    let particles = parse(Format::Xyz, &bytes);
    assert_eq!(particles.property("fixed").unwrap()[0], 1.0);
    assert_eq!(particles.property("q").unwrap()[5], -1.5e-3);
    assert_eq!((particles.radii.unwrap()[8], particles.colors.unwrap()[7]), (0.9, [0.1, 0.2, 0.3]));
    assert_eq!(particles.ids.unwrap()[0], COUNT as u64);
}

#[test]
fn labels_that_are_no_symbols_are_types() {
    let particles = parse(Format::Xyz, "5\n\nC 0 0 0\nFe2 0 0 0\nbead 0 0 0\n8 0 0 0\nH+ 0 0 0\n");
    assert_eq!(particles.elements.as_deref(), Some(&[6, 26, 0, 0, 1][..]));
    assert_eq!(labels(particles.types.as_ref()), ["C", "Fe2", "bead", "8", "H+"]);
    let particles = parse(Format::Xyz, "2\n\nna 0 0 0\nCL 0 0 0\n");
    assert_eq!((particles.elements, particles.types), (Some(vec![11, 17]), None));
    let text = "1\nProperties=type:I:1:element:S:1:pos:R:3\n7 Au 1 2 3\n";
    let particles = parse(Format::Xyz, text);
    assert_eq!((particles.elements, labels(particles.types.as_ref())), (Some(vec![79]), vec!["7"]));
    let particles = parse(Format::Xyz, "1\nProperties=Z:I:1:pos:R:3\n79 1 2 3\n");
    assert_eq!(particles.elements, Some(vec![79]));
}

#[test]
fn comments_of_plain_xyz_may_hold_anything() {
    let particles = parse(Format::Xyz, "1\nit's \"odd = 3 [\nO 1 2 3 4.5 x\n");
    assert_eq!((particles.title.as_str(), particles.cell), ("it's \"odd = 3 [", None));
    assert_eq!(particles.property("column_5"), Some(&[4.5][..]));
    let particles =
        parse(Format::Xyz, "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Origin=\"-1 0 2\" pbc=\"F F T\"\nO 1 2 3\n");
    let cell = particles.cell.unwrap();
    assert_eq!((cell.origin, cell.periodic), ([-1.0, 0.0, 2.0], [false, false, true]));
}

#[test]
fn lattices_are_vectors_or_lengths_of_edges() {
    let cell = |comment: &str| parse(Format::Xyz, format!("1\n{comment}\nO 1 2 3\n")).cell;
    let right = Cell {
        origin: [0.0; 3],
        vectors: [[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 6.5]],
        periodic: [true, true, false],
    };
    for lattice in [
        "Lattice=\"4 0 0 0 5 0 0 0 6.5\"",
        "Lattice=\"4 5 6.5\"",
        "lattice={4 5 6.5}",
        "Lattice=[4, 5, 6.5]",
        "Lattice=[[4, 0, 0], [0, 5, 0], [0, 0, 6.5]]",
        "Lattice = \"4 5 6.5\"",
        "Properties = species:S:1:pos:R:3 Lattice=\"4 5 6.5\"",
    ] {
        assert_eq!(cell(&format!("{lattice} pbc=\"T T F\"")), Some(right), "{lattice}");
    }
    // Free text.
    for comment in ["the lattice = cubic", "sublattice=\"4 5 6\"", "no lattice", "lattice constant=\"4\""] {
        assert_eq!(cell(comment), None, "{comment}");
    }
}

#[test]
fn faults_of_xyz_are_told_with_line_and_column() {
    let fault = |text: &str| fault(Format::Xyz, text);
    assert_eq!(
        fault("2\n\nO 1 2 3\nO 1 x 3\n"),
        ":4:5: \"x\" is no number; a coordinate is one, such as 1.5"
    );
    assert_eq!(fault("2\n\nO 1 2 3\nO 1 2\n"), ":4:6: the line has 3 of 4 fields: a symbol and x, y, z");
    assert_eq!(fault("2\n\nO 1 2 3\n"), ":4: the file ends after 1 of 2 particles");
    assert_eq!(fault("9999\n\nO 1 2 3\n"), ":3: the file is too short for the 9999 particles it announces");
    assert_eq!(fault("1\n\nO 1 nan 3\n"), ":3:5: the coordinate is NaN; coordinates are finite numbers");
    assert_eq!(fault("1\n\nO 1 1e99 3\n"), ":3:5: the coordinate 1e99 is too far away: at most 1e30");
    assert!(fault("O 1 2 3\n").starts_with(":1: \"O 1 2 3\" is no number of atoms"));
    assert_eq!(fault(""), ": has no frame: the file is empty");
    let extended = |properties: &str| fault(&format!("1\nProperties={properties}\nO 1 2 3\n"));
    assert!(extended("species:S:1:pos:R").starts_with(":2: \"pos:R\" in Properties is no column"));
    assert!(extended("species:S:1").starts_with(":2: Properties has no positions"));
    assert_eq!(
        extended("species:S:1:pos:R:3:q:R:1"),
        ":3:8: the line has 4 of 5 fields: species, pos (3), q"
    );
    assert_eq!(extended("pos:R:3"), ":3:1: \"O\" is no number; a coordinate is one, such as 1.5");
    assert!(fault("1\nLattice=\"1 2\nO 1 2 3\n").contains("the value of \"Lattice\" has no end"));
    for numbers in ["", "1 2", "1 2 3 4", "4 5 6 90 90 90", "4 5 x"] {
        let line = fault(&format!("1\nLattice=\"{numbers}\"\nO 1 2 3\n"));
        let right = "is no cell; it is nine numbers, three for each vector, or three lengths of edges";
        assert_eq!(line, format!(":2: Lattice=\"{numbers}\" {right}"));
    }
    assert!(fault("1\nLattice=4 5 6\nO 1 2 3\n").starts_with(":2: Lattice=\"4\" is no cell"));
}

#[test]
fn a_fault_far_down_is_told_with_its_line() {
    let mut text = String::from("200000\n\n");
    (0..199_999).for_each(|_| text.push_str("O 1.25 2.25 3.25\n"));
    text.push_str("O 1 2 -\n");
    assert!(fault(Format::Xyz, &text).starts_with(":200002:7: \"-\" is no number"));
    let particles = parse(Format::Xyz, text.replace("O 1 2 -", "bead 1 2 3"));
    assert_eq!((particles.len(), particles.positions[199_999]), (200_000, [1.0, 2.0, 3.0]));
    assert_eq!(particles.elements.unwrap()[199_998..], [8, 0]);
}

#[test]
fn dumps_are_sorted_and_their_boxes_understood() {
    let dump = |bounds: &str, atoms: &str| {
        format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {atoms}\n"
        )
    };
    let particles = parse(
        Format::Dump,
        dump(
            "pp pp fs\n0 10\n0 20\n-5 5",
            "element id zs xs type ys diameter\nO 9 0.5 0.1 1 0.25 2\nSi 4 0 0 b 0 1",
        ),
    );
    assert_eq!(particles.positions, [[0.0, 0.0, -5.0], [1.0, 5.0, 0.0]]);
    assert_eq!((particles.elements, labels(particles.types.as_ref())), (Some(vec![14, 8]), vec!["b", "1"]));
    assert_eq!((particles.ids, particles.radii), (Some(vec![4, 9]), Some(vec![0.5, 1.0])));
    assert_eq!(particles.cell.unwrap().periodic, [true, true, false]);
    assert_eq!(particles.unit, Unit::Unknown);
    // A box repeats along an axis if both of its sides do; old versions say nothing, and mean all.
    let periodic = |sides: &str| {
        let text = dump(&format!("{sides}\n0 10\n0 20\n-5 5"), "x y z\n1 2 3\n4 5 6");
        parse(Format::Dump, text).cell.unwrap().periodic
    };
    assert_eq!(periodic("pp ps fp"), [true, false, false]);
    assert_eq!(periodic("ff pp mm"), [false, true, false]);
    assert_eq!(periodic(""), [true; 3]);
    // The bounds are those of the bounding box: the cell itself is 10 wide.
    let particles =
        parse(Format::Dump, dump("xy xz yz pp pp pp\n-2 13 3\n0 24 -2\n0 5 4", "x y z\n1 2 3\n4 5 6"));
    let cell = particles.cell.unwrap();
    assert_eq!(
        (cell.origin, cell.vectors),
        ([0.0, 0.0, 0.0], [[10.0, 0.0, 0.0], [3.0, 20.0, 0.0], [-2.0, 4.0, 5.0]])
    );
    // A general triclinic box, by its vectors and its origin.
    let general = dump("abc origin pp pp pp\n1 2 0 -1\n-3 1 0 -2\n0 1 4 -3", "xs ys zs\n1 0 0\n0 0.5 0.5");
    let particles = parse(Format::Dump, general);
    assert_eq!(particles.positions, [[0.0, 0.0, -3.0], [-2.5, -1.0, -1.0]]);
    // Wrapped coordinates go before unwrapped ones.
    assert_eq!(
        parse(Format::Dump, dump("pp pp pp\n0 1\n0 1\n0 1", "xu yu zu x y z\n9 9 9 1 2 3\n9 9 9 4 5 6"))
            .positions[0],
        [1.0, 2.0, 3.0]
    );
}

/// One slanted cell as every format writes it that has vectors or tilts, with tilts of all signs.
#[test]
fn a_slanted_cell_is_the_same_in_every_format() {
    let lengths = [10.0, 8.0, 6.0];
    for signs in 0..8_u8 {
        let sign = |bit: u8| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let [x, y, z] = lengths;
        let (xy, xz, yz) = (3.0 * sign(0), 2.0 * sign(1), 1.5 * sign(2));
        let vectors = [[x, 0.0, 0.0], [xy, y, 0.0], [xz, yz, z]];
        let origin = [1.0, -2.0, 0.5];
        let check = |format: Format, bytes: &[u8], origin: [f64; 3]| {
            let cell = parse(format, bytes).cell.unwrap();
            let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < SINGLE);
            let is_same = (0..3).all(|at| near(cell.vectors[at], vectors[at])) && near(cell.origin, origin);
            assert!(is_same, "{format:?}: {cell:?} for {vectors:?} from {origin:?}");
        };
        let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let rows = vectors.as_flattened();
        let text = format!("1\nLattice=\"{}\" Origin=\"{}\"\nO 1 2 3\n", words(rows), words(&origin));
        check(Format::Xyz, text.as_bytes(), origin);
        let line = "    1SOL     OW    1   1.000   2.000   3.000";
        let text = format!("a\n1\n{line}\n{}\n", words(&[x, y, z, 0.0, 0.0, xy, 0.0, xz, yz]));
        check(Format::Gro, text.as_bytes(), [0.0; 3]);
        let dump = |bounds: &str| {
            format!("ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS x y z\n1 2 3\n")
        };
        // The bounding box is that of the eight corners.
        let corner = |at: usize, axis: usize| {
            origin[axis] + (0..3).map(|v| f64::from((at >> v & 1) as u8) * vectors[v][axis]).sum::<f64>()
        };
        let ends = |axis: usize| {
            let all = (0..8).map(|at| corner(at, axis));
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)])
        };
        let row = |axis: usize, tilt: f64| words(&[ends(axis)[0], ends(axis)[1], tilt]);
        let text = dump(&format!("xy xz yz pp pp pp\n{}\n{}\n{}", row(0, xy), row(1, xz), row(2, yz)));
        check(Format::Dump, text.as_bytes(), origin);
        let row = |at: usize| words(&[vectors[at][0], vectors[at][1], vectors[at][2], origin[at]]);
        let text = dump(&format!("abc origin pp pp pp\n{}\n{}\n{}", row(0), row(1), row(2)));
        check(Format::Dump, text.as_bytes(), origin);
        let tilted = [x, y, z, xy / y, xz / z, yz / z];
        let bytes: Vec<u8> = tilted.iter().flat_map(|number| (*number as f32).to_le_bytes()).collect();
        let count = 1_u32.to_le_bytes().to_vec();
        let file = gsd_of(&[(0, "configuration/box", 9, 1, bytes), (0, "particles/N", 3, 1, count)]);
        let middle = [0, 1, 2].map(|axis| 0.5 * (0..3).map(|v| vectors[v][axis]).sum::<f64>());
        check(Format::Gsd, &file, middle.map(|m| -m));
    }
}

#[test]
fn faults_of_dumps_are_told() {
    let fault = |text: &str| fault(Format::Dump, text);
    assert!(fault("ITEM: TIMESTEP\n0\n1 2 3\n").starts_with(":3: \"1 2 3\" is no section"));
    assert!(fault("ITEM: ATOMS id x y z\n").contains("NUMBER OF ATOMS is missing"));
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id vx\n1 2 \n")
            .starts_with(":3: the columns have no coordinates")
    );
    assert!(fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n1 2 3\n").contains("need BOX BOUNDS"));
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0\n")
            .starts_with(":5: \"0\" has no 2 numbers")
    );
    assert!(
        fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z\n-1 2 3 4\n")
            .starts_with(":4:1: \"-1\" is no id")
    );
    assert!(fault("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n1 2 3 4\n").contains("beyond the 3 fields"));
}

#[test]
fn numbers_of_gro_files_go_on_beyond_five_digits() {
    let mut text = String::from("many\n100003\n");
    for at in 0..100_003 {
        let number = (at + 99_999) % 100_000;
        let _ = writeln!(text, "{number:>5}ION     NA{number:>5}   1.000   2.000   3.000");
    }
    text.push_str("4 5 6\n");
    let particles = parse(Format::Gro, &text);
    assert_eq!(particles.ids.as_ref().unwrap()[..3], [99_999, 100_000, 100_001]);
    assert_eq!(particles.ids.unwrap()[100_002], 200_001);
    assert_eq!(particles.residue_numbers.unwrap()[100_002], 200_001);
    assert_eq!((particles.unit, particles.cell.unwrap().vectors[2]), (Unit::Nanometre, [0.0, 0.0, 6.0]));
    // What is not in order, such as a selection, has not come to the end of its digits.
    let row = |number: u32| format!("{number:>5}ION     NA{number:>5}   1.000   2.000   3.000\n");
    let text = ["few\n4\n", &row(70), &row(3), &row(40_000), &row(12), "4 5 6\n"].concat();
    let particles = parse(Format::Gro, text);
    assert_eq!(particles.ids, Some(vec![70, 3, 40_000, 12]));
    assert_eq!(particles.residue_numbers, Some(vec![70, 3, 40_000, 12]));
    // More decimals make columns wider.
    let wide = "wide\n1\n    1SOL     OW    1    0.123456    1.234567   12.345678\n 1 2 3\n";
    assert_eq!(parse(Format::Gro, wide).positions, [[0.123_456, 1.234_567, 12.345_678]]);
    assert!(
        fault(Format::Gro, "a\n1\n    1SOL     OW    1   0.126   1.x   0.679\n1 1 1\n")
            .starts_with(":3:29: \"1.x\" is no number")
    );
    assert!(
        fault(Format::Gro, "a\n1\n    1SOL     OW\n1 1 1\n").starts_with(":3:16: the line has 15 columns")
    );
    assert!(fault(Format::Gro, "a\nb\n").starts_with(":2: \"b\" is no number of atoms"));
}

/// An atom of a PDB file: serial number, name, mark, residue, chain, number of the residue, and what comes after.
fn atom(serial: &str, name: &str, mark: char, residue: &str, number: &str, rest: &str) -> String {
    format!("ATOM  {serial:>5} {name:<4}{mark}{residue:>3} A{number:>4}    {rest}\n")
}

#[test]
fn pdb_numbers_go_on_in_hybrid_36() {
    let place = "   1.000   2.000   3.000  1.00  5.00";
    let mut text = [("99999", "9999"), ("A0000", "A000"), ("a0000", "a000"), ("*****", "****")]
        .map(|(serial, number)| atom(serial, " CA ", ' ', "ALA", number, place))
        .concat();
    text.push_str("CONECT99999A0000\nCONECTa0000A000099999\nCONECT    7    8\n");
    let particles = parse(Format::Pdb, &text);
    assert_eq!(particles.ids, Some(vec![99_999, 100_000, 43_770_016, 43_770_017]));
    assert_eq!(particles.residue_numbers, Some(vec![9999, 10_000, 1_223_056, 0]));
    assert_eq!(particles.bonds, [[0, 1], [0, 2], [1, 2]]);
    assert_eq!(particles.property("b_factor"), Some(&[5.0; 4][..]));
    assert_eq!((particles.elements, labels(particles.chains.as_ref())), (Some(vec![6; 4]), vec!["A"; 4]));
}

#[test]
fn pdb_alternatives_are_chosen_by_mean_occupancy() {
    let of = |name: &str, mark: char, x: f64, occupancy: f64| {
        atom("1", name, mark, "SER", "5", &format!("{x:>8.3}   0.000   0.000  {occupancy:.2} 10.00"))
    };
    let text = [
        of(" CA ", ' ', 1.0, 1.0),
        of(" CB ", 'A', 2.0, 0.8),
        of(" CB ", 'B', 3.0, 0.6),
        of(" OG ", 'A', 4.0, 0.2),
        of(" OG ", 'B', 5.0, 0.6),
        of(" HG ", 'A', 6.0, 0.2),
    ];
    let particles = parse(Format::Pdb, text.concat());
    assert_eq!(particles.positions.iter().map(|place| place[0]).collect::<Vec<_>>(), [1.0, 3.0, 5.0, 6.0]);
}

/// Residues 52 and 52A are two, in which other locations may be the best.
#[test]
fn alternatives_are_chosen_in_each_residue_by_itself() {
    let rows = [
        ("52", "?", 'A', 1.0, 0.7),
        ("52", "?", 'B', 2.0, 0.3),
        ("52", "A", 'A', 3.0, 0.2),
        ("52", "A", 'B', 4.0, 0.8),
        ("53", "?", 'A', 5.0, 0.6),
        ("53", "?", 'B', 6.0, 0.4),
    ];
    let pdb = rows.map(|(number, insertion, mark, x, occupancy)| {
        let line = atom(
            "1",
            " CA ",
            mark,
            "SER",
            number,
            &format!("{x:>8.3}   0.000   0.000  {occupancy:.2} 10.00"),
        );
        if insertion == "A" { line.replace("52 ", "52A") } else { line }
    });
    let names = ["id", "type_symbol", "label_atom_id", "label_alt_id", "auth_comp_id", "auth_asym_id"];
    let places = ["auth_seq_id", "pdbx_PDB_ins_code", "Cartn_x", "Cartn_y", "Cartn_z", "occupancy"];
    let names = names.iter().chain(&places).map(|name| format!("_atom_site.{name}\n"));
    let cif = rows.map(|(number, insertion, mark, x, occupancy)| {
        format!("1 C CA {mark} SER A {number} {insertion} {x} 0 0 {occupancy}\n")
    });
    let cif = format!("data_a\nloop_\n{}{}", names.collect::<String>(), cif.concat());
    for (format, text) in [(Format::Pdb, pdb.concat()), (Format::Mmcif, cif)] {
        let particles = parse(format, text);
        let x: Vec<f64> = particles.positions.iter().map(|place| place[0]).collect();
        assert_eq!(x, [1.0, 4.0, 5.0], "{format:?}");
    }
}

#[test]
fn pdb_models_cells_and_faults_are_understood() {
    let specimen = specimens().into_iter().find(|specimen| specimen.name == "pdb").unwrap();
    let particles = parse(Format::Pdb, &specimen.bytes);
    // Of A and B, which are alike in all, A stays, and the atom without a mark.
    assert_eq!((particles.len(), particles.title.as_str()), (2 * COUNT / 3, "SALTY WATER"));
    assert_eq!(particles.bonds, [[0, 1], [2, 3]]);
    let cell = particles.cell.unwrap();
    assert_eq!((cell.vectors[0], cell.vectors[1]), ([20.0, 0.0, 0.0], [0.0, 30.0, 0.0]));
    // What `END` separates are frames too, and what is empty is none.
    let line = atom("1", " C  ", ' ', "LIG", "1", "   1.000   2.000   3.000");
    let text = format!(
        "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1\n{line}END\n{line}{line}END\nMODEL\nENDMDL\n"
    );
    let (_folder, path) = file("a.pdb", &text);
    assert_eq!(frames(&path).unwrap(), 2);
    let last = read(&path, &all(Frame::Last)).unwrap();
    assert_eq!((last.len(), last.cell), (2, None));
    // `SCALE` may turn the cell: here its first vector is along y.
    let scale =
        [(1, "0.000000  0.100000"), (2, "-.050000  0.000000"), (3, "0.000000  0.000000")].map(|(row, xy)| {
            format!(
                "SCALE{row}     {xy:>19} {:>9}        0.25000\n",
                if row == 3 { "0.040000" } else { "0.000000" }
            )
        });
    let text =
        format!("CRYST1   10.000   20.000   25.000  90.00  90.00  90.00 P 1\n{}{line}", scale.concat());
    let turned = parse(Format::Pdb, text).cell.unwrap();
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < SINGLE);
    assert!(
        near(turned.vectors[0], [0.0, 10.0, 0.0]) && near(turned.vectors[1], [-20.0, 0.0, 0.0]),
        "{turned:?}"
    );
    assert!(near(turned.origin, [5.0, -2.5, -6.25]), "{turned:?}");
    // Trajectories have a cell before each frame.
    let cell = |a: u8| format!("CRYST1   {a:>2}.000   20.000   30.000  90.00  90.00  90.00 P 1\n");
    let text = format!("{}MODEL\n{line}ENDMDL\n{}MODEL\n{line}ENDMDL\n", cell(10), cell(11));
    for (frame, length) in [(0, 10.0), (1, 11.0)] {
        let request = all(Frame::Number(frame));
        let particles = read_from("a", Cursor::new(&text), Format::Pdb, &request).unwrap();
        assert_eq!(particles.cell.unwrap().vectors[0], [length, 0.0, 0.0]);
    }
    let fault = |text: &str| fault(Format::Pdb, text);
    assert!(fault(&line.replace("2.000", "2,000")).starts_with(":1:39: \"2,000\" is no number"));
    assert!(fault("ATOM      1  CA\n").starts_with(":1:16: the line has 15 columns"));
    assert!(fault("HEADER\nCRYST1    x\n").starts_with(":2:7: \"x\" is no length"));
    assert!(fault("HEADER\n").contains("has no atoms"));
}

#[test]
fn mmcif_names_bonds_and_models_are_read() {
    let specimen = specimens().into_iter().find(|specimen| specimen.name == "mmcif").unwrap();
    let particles = parse(Format::Mmcif, &specimen.bytes);
    assert_eq!((particles.len(), particles.title.as_str()), (COUNT, "salty water"));
    assert_eq!(labels(particles.names.as_ref())[..3], ["O", "H1", "H2'"]);
    assert_eq!(particles.bonds, [[0, 1]], "that of hydrogen is none");
    let fault = |text: &str| fault(Format::Mmcif, text);
    let with = |rows: &str| {
        format!(
            "data_a\nloop_\n_atom_site.id\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n{rows}"
        )
    };
    let good = parse(Format::Mmcif, with("1 C 1 2 3\n2 FE\n4 5\n6\n"));
    assert_eq!((good.positions[1], good.elements), ([4.0, 5.0, 6.0], Some(vec![6, 26])));
    assert!(
        fault(&with("1 C 1 2 3\n2 C 1 2 ?\n")).starts_with(":9:9: \"\" is no number"),
        "{}",
        fault(&with("1 C 1 2 3\n2 C 1 2 ?\n"))
    );
    assert!(fault(&with("1 C 1 2 3\n2 C 1 2\n")).contains("a row of the loop has 4 of 5 values"));
    assert!(fault("data_a\n'open\n").starts_with(":2:2: a quotation mark"));
    assert!(fault("data_a\n_b\n").contains("\"_b\" has no value"));
    assert!(fault("data_a\n").contains("has no atoms"));
    let alone = "data_a\n_atom_site.id 1\n_atom_site.type_symbol He\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z 3\n";
    assert_eq!(parse(Format::Mmcif, alone).positions, [[1.0, 2.0, 3.0]]);
    let group = "data_a\n_cell_length_a 2\n_cell_length_b 2\n_cell_length_c 2\n_symmetry_space_group_name_H-M 'F m -3 m'\nloop_\n\
                 _atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\nNa1 0.5 0.25(2) -1\n";
    assert!(fault(group).contains("lists no _space_group_symop_operation_xyz"));
    assert_eq!(parse(Format::Mmcif, group.replace("F m -3 m", "P 1")).positions, [[1.0, 0.5, -2.0]]);
}

/// Columns of `_atom_site` that bonds need as well.
const ATOM_SITES: [&str; 8] =
    ["id", "type_symbol", "auth_asym_id", "auth_seq_id", "label_atom_id", "Cartn_x", "Cartn_y", "Cartn_z"];

/// Models have numbers of their own, which need not begin at 1; and a bond to another image of the crystal is none within it.
#[test]
fn mmcif_models_are_frames_and_bonds_stay_within_the_crystal() {
    let names = ATOM_SITES.iter().chain(&["pdbx_PDB_model_num"]).map(|name| format!("_atom_site.{name}\n"));
    let ends = |end: u8| {
        ["auth_asym_id", "auth_seq_id", "label_atom_id", "symmetry"]
            .map(|name| format!("_struct_conn.ptnr{end}_{name}\n"))
            .concat()
    };
    let text = format!(
        "data_a\nloop_\n{}1 C A 1 CA 1 0 0 4\n2 C A 2 CA 2 0 0 4\n3 C A 3 CA 3 0 0 4\n4 O A 1 OW 4 0 0 7\n5 O A 1 OW 5 0 0 2\n\
         6 O A 2 OW 6 0 0 2\nloop_\n_struct_conn.conn_type_id\n{}{}covale A 1 CA 1_555 A 2 CA 1_555\n\
         metalc A 2 CA 1_555 A 3 CA 2_655\ndisulf A 1 CA 3_555 A 3 CA 3_555\n",
        names.collect::<String>(),
        ends(1),
        ends(2)
    );
    let (_folder, path) = file("a.cif", &text);
    assert_eq!(frames(&path).unwrap(), 3);
    let of = |frame| read(&path, &all(frame)).unwrap();
    let x = |frame| of(frame).positions.iter().map(|p| p[0]).collect::<Vec<_>>();
    let models = [0, 1, 2].map(|number| x(Frame::Number(number)));
    assert_eq!(models, [vec![1.0, 2.0, 3.0], vec![4.0], vec![5.0, 6.0]]);
    assert_eq!(x(Frame::Last), [5.0, 6.0]);
    assert_eq!(of(Frame::Number(0)).bonds, [[0, 1], [0, 2]]);
}

/// Of several blocks the first with atoms is read as if it stood alone: no other says anything of its cell, its symmetry, its
/// bonds or its atoms.
#[test]
fn blocks_of_cif_say_nothing_of_each_other() {
    let site = |names: &[&str], prefix: &str, rows: &str| {
        let names = names.iter().map(|name| format!("{prefix}{name}\n")).collect::<Vec<_>>().concat();
        format!("loop_\n{names}{rows}")
    };
    let cell = |length: u8| ["a", "b", "c"].map(|side| format!("_cell_length_{side} {length}\n")).concat();
    let molecule = site(&ATOM_SITES, "_atom_site.", "1 C A 1 CA 1 2 3\n2 C A 2 CA 4 5 6\n");
    let crystal =
        cell(4) + &site(&["label", "fract_x", "fract_y", "fract_z"], "_atom_site_", "Na1 0.25 0.5 0.125\n");
    let alone = "_atom_site.id 1\n_atom_site.type_symbol He\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n_atom_site.Cartn_z 3\n";
    let without_atoms = [
        cell(7),
        "_cell_angle_beta 100\n".into(),
        "_struct.title another\n".into(),
        "_symmetry_space_group_name_H-M 'F m -3 m'\n".into(),
        "loop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\n-x,-y,-z\n".into(),
        site(
            &["conn_type_id", "ptnr1_auth_asym_id", "ptnr1_auth_seq_id", "ptnr1_label_atom_id"],
            "_struct_conn.",
            "",
        ) + "_struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n_struct_conn.ptnr2_label_atom_id\n\
             covale A 1 CA A 2 CA\n",
        // What is known of atoms that have no place.
        "_atom_site.type_symbol Fe\n_atom_site.label_atom_id FE\n".into(),
        site(&["label", "occupancy"], "_atom_site_", "Na1 0.5\n"),
        String::new(),
    ];
    let parse = |text: &str| {
        read_from("a", Cursor::new(text.as_bytes()), Format::Mmcif, &Request::default()).unwrap()
    };
    for (atoms, count) in [(molecule.as_str(), 2), (&crystal, 1), (alone, 1)] {
        let block = format!("data_a\n{atoms}");
        let right = parse(&block);
        assert_eq!((right.len(), right.bonds.len(), right.title.as_str()), (count, 0, ""));
        assert_eq!(right.cell.is_some(), atoms == crystal);
        for other in without_atoms.iter().map(String::as_str).chain([without_atoms.concat().as_str()]) {
            let before = parse(&format!("data_other\n{other}{block}"));
            assert_eq!(before, right, "after {other}");
        }
        for other in without_atoms.iter().map(String::as_str).chain([molecule.as_str(), &crystal, alone]) {
            let after = parse(&format!("{block}data_other\n{other}"));
            assert_eq!(after, right, "before {other}");
        }
    }
}

/// Of each assembly the group of the highest mean occupancy stays, among equals the first; atoms without a group stay.
#[test]
fn of_disordered_groups_one_is_read() {
    let text = "data_a\n_cell_length_a 10\n_cell_length_b 10\n_cell_length_c 10\nloop_\n_atom_site_label\n_atom_site_fract_x\n\
                _atom_site_fract_y\n_atom_site_fract_z\n_atom_site_occupancy\n_atom_site_disorder_assembly\n\
                _atom_site_disorder_group\nC1 .1 0 0 1 . .\nC2A .2 0 0 0.4(1) A 1\nC2B .3 0 0 0.6 A 2\nC3A .4 0 0 0.4 A 1\n\
                C3B .5 0 0 0.6 A 2\nO4B .6 0 0 0.5 B 2\nO4A .7 0 0 0.5 B 1\nN5 .8 0 0 0.5 . -1\n";
    let x = |text: &str| parse(Format::Mmcif, text).positions.iter().map(|p| p[0]).collect::<Vec<_>>();
    assert_eq!(x(text), [1.0, 3.0, 5.0, 6.0, 8.0]);
    assert_eq!(x(&text.replace("0.4", "0.7")), [1.0, 2.0, 4.0, 6.0, 8.0]);
    // An occupancy that is not stated is whole.
    assert_eq!(x(&text.replace("0.4(1)", "?").replace("0.4", ".")), [1.0, 2.0, 4.0, 6.0, 8.0]);
}

/// What a file calls itself, by the rules of each format.
#[test]
fn titles_are_those_of_the_files() {
    let title = |format, text: &str| parse(format, text).title;
    assert_eq!(title(Format::Xyz, "1\n two  atoms \nO 0 0 0\n").trim(), "two  atoms");
    assert_eq!(
        title(Format::Gro, "Some water\n1\n    1SOL     OW    1   0.100   0.200   0.300\n 1 1 1\n"),
        "Some water"
    );
    let dump = "ITEM: TIMESTEP\n700\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n1 2 3\n";
    assert_eq!(title(Format::Dump, dump), "timestep 700");
    let atom = "ATOM      1  N   ALA A   1       1.000   2.000   3.000  1.00 10.00           N\n";
    // It goes on over several lines.
    let pdb = format!("TITLE     SOME ATOMS\nREMARK\nTITLE    2 OF WATER\n{atom}");
    assert_eq!(title(Format::Pdb, &pdb), "SOME ATOMS OF WATER");
    // Of several comments the first is taken.
    let ply = "ply\nformat ascii 1.0\ncomment two points\ncomment by hand\nobj_info 7\nelement vertex 1\nproperty float x\n\
               property float y\nproperty float z\nend_header\n1 2 3\n";
    assert_eq!(title(Format::Ply, ply), "two points");
}

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

#[test]
fn ply_lists_and_elements_before_the_points_are_skipped() {
    let header = "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int v\nelement vertex 2\nproperty list int float more\n\
                  property float x\nproperty float y\nproperty float z\nproperty float q\nend_header\n";
    let particles = parse(Format::Ply, format!("{header}3 0 1 2\n0\n2 8 9 1 2 3 4\n0 5 6 7 8\n"));
    assert_eq!(
        (particles.positions, particles.properties[0].values.clone()),
        (vec![[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]], vec![4.0, 8.0])
    );
    let mut bytes = header.replace("ascii", "binary_big_endian").into_bytes();
    bytes.extend([1, 0, 0, 0, 7, 0]);
    for (list, numbers) in [(&[8.0_f32, 9.0][..], [1.0_f32, 2.0, 3.0, 4.0]), (&[], [5.0, 6.0, 7.0, 8.0])] {
        bytes.extend((list.len() as i32).to_be_bytes());
        list.iter().chain(&numbers).for_each(|number| bytes.extend(number.to_be_bytes()));
    }
    let particles = parse(Format::Ply, &bytes);
    assert_eq!(particles.positions, [[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]]);
    let fault = |text: &str| fault(Format::Ply, text);
    assert!(fault(&header.replace("vertex", "point")).contains("no element called vertex"));
    assert!(fault(&header.replace("float z", "float w")).contains("has no columns x, y and z"));
    assert!(
        fault(&header.replace("property float x", "property quad x"))
            .starts_with(":7: \"property quad x\" is no line")
    );
    assert!(fault("ply\nformat ascii 1.0\nelement vertex 1\n").contains("where end_header should be"));
    assert!(fault(&header.replace("vertex 2", "vertex 99999999")).contains("is too short for the 99999999"));
}

#[test]
fn colours_are_scaled_by_their_type() {
    let ply = parse(Format::Ply, specimens::ply("ascii")).colors.unwrap();
    assert_eq!((ply[0], ply[51]), ([1.0, 0.0, 0.0], [1.0, 0.2, 0.0]));
    let csv = parse(Format::Csv, "x,y,z,r,g,b\n0,0,0,51,255,0\n").colors.unwrap();
    assert_eq!(csv, [[0.2, 1.0, 0.0]]);
    let csv = parse(Format::Csv, "x,y,z,r,g,b\n0,0,0,0.25,1,0\n").colors.unwrap();
    assert_eq!(csv, [[0.25, 1.0, 0.0]]);
}

#[test]
fn tables_of_all_separators_are_read() {
    for separator in [',', ';', '\t'] {
        let particles = parse(Format::Csv, specimens::csv(separator));
        assert_eq!((particles.len(), particles.available.as_slice()), (COUNT, &["charge".to_owned()][..]));
        assert_eq!(particles.elements.unwrap()[..2], [8, 1]);
    }
    let particles = parse(Format::Csv, "X [nm];Y [nm];Z [nm];Radius\n\n1,5;2;-3;\"0,5\"\n");
    assert_eq!((particles.positions, particles.radii), (vec![[1.5, 2.0, -3.0]], Some(vec![0.5])));
    let particles = parse(Format::Csv, "# x y z id q\n1 2 3 7 nan\n");
    assert_eq!((particles.ids, particles.properties[0].values[0].is_nan()), (Some(vec![7]), true));
    let fault = |text: &str| fault(Format::Csv, text);
    assert_eq!(fault("x,y\n1,2\n"), ":1: has no columns x, y and z; its columns are x, y");
    assert!(
        fault("1,2,3\n4,5,6\n").starts_with(":1: the first line has numbers; it should name the columns")
    );
    assert_eq!(
        fault("x,y,z\n1,2,3\n1,,3\n"),
        ":3:1: column y: \"\" is no number; a coordinate is one, such as 1.5"
    );
    assert_eq!(fault("x,y,z\n1,2\n"), ":2:1: the line has 2 of 3 fields; the next is z");
    assert!(fault("x,y,z\n1,2,3,4\n").contains("\"4\" is beyond the 3 columns"));
    assert!(fault("x,y,z,r\n1,2,3,-1\n").contains("column r: the radius is -1"));
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

#[test]
fn gsd_frames_share_what_they_lack_with_the_first() {
    let specimen = specimens().into_iter().find(|specimen| specimen.format == Format::Gsd).unwrap();
    let second = read_from("a", Cursor::new(&specimen.bytes), Format::Gsd, &all(Frame::Last)).unwrap();
    assert_eq!((second.frame, second.len(), second.positions[0]), (1, COUNT, [1.0; 3]));
    assert_eq!(labels(second.types.as_ref())[..2], ["first", "other"]);
    assert_eq!((second.bonds.as_slice(), second.elements), (&[[0, 1], [2, 3]][..], None));
    assert_eq!(second.radii.unwrap()[0], 0.5, "the default diameter is 1");
    assert_eq!(second.properties[0].name, "charge");
    let cell = second.cell.unwrap();
    let middle = cell.point([0.5; 3]);
    assert!(middle.iter().all(|number| number.abs() < SINGLE), "centred at {middle:?}");
    let number = |count: u32| count.to_le_bytes().to_vec();
    // A box of two dimensions, whose height may be 0, repeats in its plane.
    for height in [0.0_f32, 3.0] {
        let bounds = [4.0, 5.0, height, 0.5, 0.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
        let cell = |dimensions: u8| {
            let chunks = [
                (0, "configuration/dimensions", 1, 1, vec![dimensions]),
                (0, "configuration/box", 9, 1, Vec::clone(&bounds)),
                (0, "particles/N", 3, 1, number(1)),
            ];
            parse(Format::Gsd, gsd_of(&chunks)).cell
        };
        assert_eq!(cell(2).unwrap().periodic, [true, true, false]);
        assert_eq!(cell(3).map(|cell| cell.periodic), (height > 0.0).then_some([true; 3]));
    }
    // Symbols are elements if all types are such.
    let typed = |names: &[u8]| {
        parse(
            Format::Gsd,
            gsd_of(&[(0, "particles/N", 3, 1, number(1)), (0, "particles/types", 5, 3, names.to_vec())]),
        )
    };
    assert_eq!(typed(b"Si\0O\0\0").elements, Some(vec![14]));
    assert_eq!(typed(b"Si\0A\0\0").elements, None);
}

/// Not with the frame before: of three frames that all say something else, whatever the last lacks is that of the first.
#[test]
fn gsd_frames_share_nothing_with_the_frame_before() {
    /// A chunk without its frame.
    type Part = (&'static str, u8, u32, Vec<u8>);
    let singles =
        |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let words = |numbers: &[u32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    // All that a frame may have; that in the middle has a particle and a bond more.
    let chunks = |frame: u8| -> Vec<Part> {
        let (of_frame, count) = (f32::from(frame), if frame == 1 { 3 } else { 2 });
        let each = |scale: f32, columns: u32| {
            let numbers = (1..=count * columns).map(|k| scale * (10.0 * of_frame + k as f32));
            singles(&numbers.collect::<Vec<_>>())
        };
        let types = ["Si\0\0O\0\0\0", "bis\0one\0", "cis\0one\0"][usize::from(frame)];
        let kinds: Vec<u32> = (0..count).map(|at| (at + u32::from(frame)) % 2).collect();
        // What joins a particle with itself is no bond.
        let bonds: &[u32] = [&[0, 1][..], &[0, 2, 1, 2], &[1, 1]][usize::from(frame)];
        let bounds = [4.0 + of_frame, 5.0 + of_frame, 6.0 + of_frame, 0.5, 0.0, 0.25];
        vec![
            ("configuration/dimensions", 1, 1, vec![if frame == 0 { 3 } else { 2 }]),
            ("configuration/box", 9, 1, singles(&bounds)),
            ("particles/N", 3, 1, words(&[count])),
            ("particles/types", 5, 4, types.into()),
            ("particles/typeid", 3, 1, words(&kinds)),
            ("particles/position", 9, 3, each(1.0, 3)),
            ("particles/diameter", 9, 1, each(0.25, 1)),
            ("particles/charge", 9, 1, each(-1.0, 1)),
            ("particles/velocity", 9, 3, each(2.0, 3)),
            ("log/particles/energy", 9, 1, each(3.0, 1)),
            ("bonds/N", 3, 1, words(&[bonds.len() as u32 / 2])),
            ("bonds/group", 3, 2, words(bonds)),
        ]
    };
    // The last of these frames.
    let read_last = |frames: &[&[Part]]| {
        let with_number = |(number, chunks): (usize, &&[Part])| {
            let chunk =
                |(name, kind, columns, bytes): &Part| (number as u64, *name, *kind, *columns, bytes.clone());
            chunks.iter().map(chunk).collect::<Vec<_>>()
        };
        let bytes = gsd_of(&frames.iter().enumerate().flat_map(with_number).collect::<Vec<_>>());
        let particles = read_from("a", Cursor::new(bytes), Format::Gsd, &all(Frame::Last)).unwrap();
        assert_eq!(particles.frame + 1, frames.len());
        Particles { frame: 0, ..particles }
    };
    let [first, middle, last] = [0, 1, 2].map(chunks);
    let step = [("configuration/step", 4, 1, 9_u64.to_le_bytes().to_vec())];
    assert_eq!(read_last(&[&first, &middle, &step]), read_last(&[&first]), "a frame that lacks all");
    assert_eq!(read_last(&[&first, &middle, &last]), read_last(&[&last]), "a frame that has all");
    for (at, lacked) in first.iter().enumerate() {
        let (mut own, mut right) = (last.clone(), last.clone());
        own.remove(at);
        right[at] = lacked.clone();
        let found = read_last(&[&first, &middle, &own]);
        assert_eq!(found, read_last(&[&right]), "a frame that lacks {}", lacked.0);
    }
    // What there is of each particle is not shared with a frame that has another number of them.
    let number = vec![middle[2].clone()];
    let is_of_all = |name: &str| !name.contains("particles/") || name == "particles/types";
    let of_all = first.iter().filter(|chunk| is_of_all(chunk.0)).chain(&number).cloned().collect::<Vec<_>>();
    let right = read_last(&[&of_all]);
    assert_eq!((&right.positions[..], right.properties.len()), (&[[0.0; 3]; 3][..], 0));
    assert_eq!(read_last(&[&first, &number]), right);
}

#[test]
fn faults_of_gsd_are_told_with_their_bytes() {
    let fault = |chunks: &[specimens::Chunk]| fault(Format::Gsd, gsd_of(chunks));
    let count = |count: u32| (0, "particles/N", 3, 1, count.to_le_bytes().to_vec());
    let nan = f32::NAN.to_le_bytes().repeat(3);
    assert!(
        fault(&[count(1), (0, "particles/position", 9, 3, nan)])
            .starts_with(": byte 260: particle 0 is at [NaN")
    );
    assert!(
        fault(&[count(2), (0, "particles/position", 9, 3, vec![0; 12])])
            .contains("is an array of 1 x 3, and should be 2 x 3")
    );
    assert!(
        fault(&[count(1), (0, "particles/typeid", 3, 1, 7_u32.to_le_bytes().to_vec())])
            .contains("particle 0 has type 7 of 1")
    );
    assert!(fault(&[count(u32::MAX)]).contains("has 4294967295 particles"));
    let bond = [0_u32, 9].into_iter().flat_map(u32::to_le_bytes).collect();
    let one = 1_u32.to_le_bytes().to_vec();
    assert!(
        fault(&[count(1), (0, "bonds/N", 3, 1, one), (0, "bonds/group", 3, 2, bond)])
            .contains("bond 0 joins 0 and 9")
    );
    assert!(fault(&[]).contains("has no frame: the file is empty"));
    assert!(super_short().starts_with(": byte 0: the header of 256 bytes is beyond the end"));
}

fn super_short() -> String {
    fault(Format::Gsd, 0x65DF_65DF_65DF_65DF_u64.to_le_bytes())
}
