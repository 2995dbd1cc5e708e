//! What is read of each format, frame by frame, and what is said of faults: here what formats have in common, and in modules what each
//! has of its own.

mod arrays;
mod cif;
mod dump;
mod gro;
mod gsd;
mod pdb;
#[path = "../specimens/mod.rs"]
mod specimens;
mod tables;
mod xyz;

use importers::{Format, Frame, Particles, Properties, Request, Trajectory, Unit, frames, read, read_from};
use specimens::{COUNT, gsd_of, gzip, place, specimens};
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

/// What no other format begins with is believed before a name, and a name before what the first lines look like.
#[test]
fn signatures_go_before_names_and_names_before_looks() {
    let signed = [Format::Gsd, Format::Npy, Format::Npz, Format::Ply, Format::Dump];
    for specimen in specimens().into_iter().filter(|specimen| signed.contains(&specimen.format)) {
        let (_folder, path) = file("a.xyz", &specimen.bytes);
        assert_eq!(read(&path, &Request::default()).unwrap().format, specimen.format, "{}", specimen.name);
    }
    // A title and an atom that are numbers.
    let (_folder, path) = file("a.gro", "7\n1\n    1SOL      1    1   0.100   0.200   0.300\n 1 1 1\n");
    let particles = read(&path, &Request::default()).unwrap();
    assert_eq!((particles.format, particles.positions), (Format::Gro, vec![[0.1, 0.2, 0.3]]));
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

/// Each frame has its own header, and GRO also a line after its atoms.
#[test]
fn frames_of_gro_files_and_dumps_follow_each_other() {
    let gro =
        |x: usize| format!("frame {x}\n1\n    1SOL     OW    1   {x}.000   2.000   3.000\n 1 2 {}\n", x + 1);
    let dump =
        |x: usize| format!("ITEM: TIMESTEP\n{x}\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n{x} 2 3\n");
    let of = |frame: &dyn Fn(usize) -> String| (0..3).map(frame).collect::<String>();
    for (name, text, title) in [("a.gro", of(&gro), "frame"), ("a.dump", of(&dump), "timestep")] {
        let (_folder, path) = file(name, text);
        let trajectory = Trajectory::open(&path).unwrap();
        assert_eq!(trajectory.frames(), 3, "{name}");
        for number in [2, 0, 1] {
            let request = all(Frame::Number(number));
            let particles = trajectory.read(&request).unwrap();
            assert_eq!((particles.frame, particles.positions[0][0]), (number, number as f64), "{name}");
            assert_eq!(particles.title, format!("{title} {number}"));
            let height = particles.cell.map(|cell| cell.vectors[2][2]);
            assert_eq!(height, (name == "a.gro").then_some(number as f64 + 1.0));
            assert_eq!(particles, read(&path, &request).unwrap(), "{name}");
        }
        assert_eq!(read(&path, &all(Frame::Last)).unwrap().frame, 2, "{name}");
    }
}

/// LAMMPS writes it at the beginning of a file alone.
#[test]
fn the_unit_of_the_first_frame_of_a_dump_is_that_of_all() {
    let frame =
        |x: usize| format!("ITEM: TIMESTEP\n{x}\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n{x} 2 3\n");
    let text = format!("\nITEM: UNITS\nsi\n{}{}{}", frame(0), frame(1), frame(2));
    let (_folder, path) = file("a.dump", text);
    let trajectory = Trajectory::open(&path).unwrap();
    for asked in [Frame::Number(0), Frame::Number(2), Frame::Last] {
        let request = all(asked);
        assert_eq!(read(&path, &request).unwrap().unit, Unit::Metre, "{asked:?}");
        assert_eq!(trajectory.read(&request).unwrap().unit, Unit::Metre, "{asked:?}");
    }
    let (_folder, path) = file("a.dump", format!("{}{}", frame(0), frame(1)));
    assert_eq!(read(&path, &all(Frame::Last)).unwrap().unit, Unit::Unknown);
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
