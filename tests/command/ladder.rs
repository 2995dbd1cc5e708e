//! The command `ladder`. The images of its rows are tested in `tests/ladder`.

use crate::sandbox::{Ended, Sandbox, TINY};

fn ladder(sandbox: &Sandbox, args: &[&str]) -> Ended {
    let ended = sandbox.run(["ladder"].iter().chain(args).chain(&TINY));
    assert_eq!(ended.code, Some(0), "{args:?}: {ended:?}");
    ended
}

/// The lines of a CSV file, the header first, split into fields.
fn records(sandbox: &Sandbox, name: &str) -> Vec<Vec<String>> {
    let text = String::from_utf8(sandbox.bytes(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn every_row_is_timed_and_told() {
    let sandbox = Sandbox::new();
    let ended = ladder(&sandbox, &["--scene", "cornell", "--csv", "times.csv", "--repeat", "2"]);
    let records = records(&sandbox, "times.csv");
    let column = |name: &str| records[0].iter().position(|field| field == name).unwrap();
    let (row, speedup, runs, scene) = (column("row"), column("speedup"), column("runs"), column("scene"));
    assert_eq!(records.len() - 1, ladder::ROWS.len());
    for (record, expected) in records[1..].iter().zip(ladder::ROWS) {
        assert_eq!(record[row], expected.name);
        assert_eq!((&record[scene][..], &record[runs][..]), ("cornell", "2"));
        assert!(record[speedup].parse::<f64>().unwrap() > 0.0);
        assert!(ended.stdout.contains(&format!("\n  {} ", expected.name)), "{ended:?}");
    }
    assert_eq!(records[1][speedup], "1.0");
    assert_eq!(sandbox.names(), ["times.csv"]);
}

/// With the reference's random numbers, all rows count the same photons.
#[test]
fn keyed_rows_do_the_same_work() {
    let sandbox = Sandbox::new();
    ladder(&sandbox, &["--scene", "mirror", "--rng", "keyed", "--csv", "a.csv", "--repeat", "1"]);
    let records = records(&sandbox, "a.csv");
    let column = records[0].iter().position(|field| field == "contributions").unwrap();
    assert!(records[2..].iter().all(|record| record[column] == records[1][column]), "{records:?}");
}

#[test]
fn sweeps_have_a_line_per_value_and_plots() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("plots")).unwrap();
    let sweeps = [("iterations", 3), ("photons", 3), ("size", 3), ("depth", 3), ("spheres", 4)];
    for (sweep, values) in sweeps {
        let args = ["--quick", "--scene", "random", "--sweep", sweep, "--rows", "3,6"];
        let csv = format!("{sweep}.csv");
        let ended = ladder(&sandbox, &[&args[..], &["--plots", "plots", "--csv", &csv]].concat());
        let records = records(&sandbox, &csv);
        assert_eq!(records.len() - 1, 2 * values, "{sweep}");
        // Of each value, the speedup of a row is over the first row at that value.
        let column = |name: &str| records[0].iter().position(|field| field == name).unwrap();
        let number = |record: &[String], name: &str| record[column(name)].parse::<f64>().unwrap();
        for rows in records[1..].chunks(2) {
            assert_eq!(rows[0][column("value")], rows[1][column("value")]);
            for row in rows {
                let speedup = number(&rows[0], "seconds") / number(row, "seconds");
                assert!((number(row, "speedup") / speedup - 1.0).abs() < 1e-9, "{sweep}: {row:?}");
            }
        }
        assert!(ended.stdout.contains("grows as"), "{ended:?}");
    }
    ladder(&sandbox, &["--scene", "cornell", "--rows", "0,fast", "--plots", "plots", "--repeat", "1"]);
    for name in ["speedup", "speedup-depth-random", "complexity-pixels-random", "speedup-spheres-random"] {
        let svg = String::from_utf8(sandbox.bytes(&format!("plots/{name}.svg"))).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{name}");
    }
    let svg = String::from_utf8(sandbox.bytes("plots/speedup.svg")).unwrap();
    for words in ["\ntimes as fast as row 0\n", "\nspeedup\n", "\n0\n", "\nfast\n", "\ncornell\n"] {
        assert!(svg.contains(words), "no {words:?} in {svg}");
    }
    // Numbers along the axis are rounded, such as 0.3.
    let lengths = svg.lines().filter(|line| line.parse::<f64>().is_ok()).map(str::len);
    assert!(lengths.max() < Some(8), "{svg}");
    // Speedups are over the first row, and how time grows is that of the last stage.
    for (name, title) in [
        ("speedup-depth-random", "random: times as fast as stage 3"),
        ("complexity-pixels-random", "random, row 6: time of each pass over its most"),
        ("flat-pixels-random", "random, row 6: time of each pass over predicted work"),
    ] {
        let svg = String::from_utf8(sandbox.bytes(&format!("plots/{name}.svg"))).unwrap();
        assert!(svg.contains(title), "{name}: {svg}");
    }
}

/// Figures 5, 8 and 10 to 12 of the paper.
#[test]
fn counted_rows_stand_under_their_roofs() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("plots")).unwrap();
    let rows =
        ["--scene", "cornell", "--rows", "0,6,fast", "--repeat", "1", "--roofline", "--plots", "plots"];
    let ended = ladder(&sandbox, &rows);
    for words in ["GHz; ", "peak by FMA of 8 floats", "peak reading DRAM", "not counted"] {
        assert!(ended.stdout.contains(words), "no {words:?} in {ended:?}");
    }
    let points = records(&sandbox, "plots/roofline.csv");
    // Two rows, each with a total and four passes; operations of the fast engine are not counted.
    assert_eq!(points.len() - 1, 2 * 5);
    let column = |name: &str| points[0].iter().position(|field| field == name).unwrap();
    let number = |record: &[String], name: &str| record[column(name)].parse::<f64>().unwrap();
    for record in &points[1..] {
        let (flops, bytes) =
            (number(record, "flops"), number(record, "bytes_loaded") + number(record, "bytes_stored"));
        assert!(
            (flops / bytes - number(record, "flops_per_byte")).abs() < 1e-9 * flops / bytes,
            "{record:?}"
        );
    }
    for row in points[1..].chunks(5) {
        let of_passes: f64 = row[1..].iter().map(|record| number(record, "flops")).sum();
        assert_eq!(number(&row[0], "flops"), of_passes);
    }
    let peaks = records(&sandbox, "plots/peaks.csv");
    let names: Vec<&str> = peaks[1..].iter().map(|record| &record[0][..]).collect();
    assert_eq!(names, ["clock", "fma of one float", "fma of 8 floats", "L1", "L2", "L3", "DRAM"]);
    // Each level is read in more bytes than the one before.
    let bytes: Vec<usize> = peaks[4..].iter().map(|record| record[1].parse().unwrap()).collect();
    assert!(bytes.is_sorted_by(|near, far| near < far), "{peaks:?}");
    let sweep = ["--sweep", "iterations", "--quick", "--similarity"];
    let ended = ladder(&sandbox, &[&rows[..], &sweep[..]].concat());
    assert!(ended.stdout.contains("structural similarity"), "{ended:?}");
    // Of fewer iterations those operations are counted that these take, though all are counted in one render.
    let points = records(&sandbox, "plots/roofline.csv");
    let column = |name: &str| points[0].iter().position(|field| field == name).unwrap();
    let of_rows: Vec<_> = points[1..].iter().filter(|record| record[column("pass")] == "all").collect();
    assert_eq!(of_rows.len(), 3 * 2);
    for row in ["0", "6"] {
        let of_row = of_rows.iter().filter(|record| record[column("row")] == row);
        let flops = of_row.map(|record| {
            [column("value"), column("flops")].map(|column| record[column].parse::<f64>().unwrap())
        });
        let [one, two, four] = flops.collect::<Vec<_>>()[..] else { panic!("{points:?}") };
        assert_eq!([one[0], two[0], four[0]], [1.0, 2.0, 4.0]);
        for [less, more] in [[one, two], [two, four]] {
            assert!((1.5..2.5).contains(&(more[1] / less[1])), "{points:?}");
        }
    }
    // The first row is compared with itself, so its similarity is 1.
    let compared = records(&sandbox, "plots/similarity.csv");
    assert_eq!(compared.len() - 1, 3 * 3);
    assert!(
        compared[1..].iter().filter(|record| record[2] == "0").all(|record| record[3] == "1.0"),
        "{compared:?}"
    );
    for name in ["roofline-cornell", "roofline-cornell-0", "flops-iterations-cornell", "ssim-cornell"] {
        let svg = String::from_utf8(sandbox.bytes(&format!("plots/{name}.svg"))).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{name}");
    }
}

#[test]
fn quality_depends_only_on_the_image() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("plots")).unwrap();
    let quality = |options: &[&str]| {
        let common = ["ladder", "--quick", "--scene", "mirror", "--rows", "6,fast", "--quality"];
        let size = ["--width=80", "--height=60", "--photons=25000"];
        let common = [&common[..], &["--plots", "plots"], &size].concat();
        let ended = sandbox.run(common.iter().chain(options));
        assert!(ended.stdout.contains("over the least"), "{ended:?}");
        let records = records(&sandbox, "plots/quality.csv");
        let number = |row: usize, name: &str| {
            let column = records[0].iter().position(|field| field == name).unwrap();
            records[row][column].parse::<f64>().unwrap()
        };
        for (row, name) in [(1, "6"), (2, "fast")] {
            assert_eq!(records[row][..2], ["mirror", name]);
            let cost = number(row, "relative_square_error") * number(row, "seconds");
            assert!((number(row, "cost") / cost - 1.0).abs() < 1e-9, "{records:?}");
        }
        [1, 2].map(|row| number(row, "relative_square_error"))
    };
    // In a scene with one light, with the same random numbers, both give the same image, up to the order of sums.
    let [six, fast] = quality(&["--rng", "keyed"]);
    assert!(fast > 0.0 && (six / fast - 1.0).abs() < 1e-3, "{six} and {fast}");
    let [_, better] = quality(&["--iterations", "6"]);
    assert!(better < 0.6 * fast, "{better} after three times the iterations, {fast} before");
}

#[test]
fn generators_are_timed_and_told() {
    let sandbox = Sandbox::new();
    let ended = sandbox.run(["ladder", "--numbers", "--csv", "numbers.csv"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let records = records(&sandbox, "numbers.csv");
    // rand, xorshift32 on its own and with five unroll factors, keyed streams in two ways.
    assert_eq!(records.len() - 1, 9);
    for record in &records[1..] {
        let name = record[0].trim_start_matches('"');
        assert!(ended.stdout.contains(name), "no {name:?} in {ended:?}");
    }
}

#[test]
fn images_are_those_of_renders_with_fewer_iterations() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("images")).unwrap();
    let settings = ["--width=24", "--height=16", "--photons=2000"];
    let args = ["ladder", "--scene", "cornell", "--rows", "6,fast", "--images", "images", "--iterations=5"];
    let ended = sandbox.run([&args[..], &settings].concat());
    assert_eq!(ended.code, Some(0), "{ended:?}");
    for iterations in ["2", "4", "5"] {
        let args =
            ["render", "cornell", "--quality=paper", "-q", "-o", "render.pfm", "--iterations", iterations];
        assert_eq!(sandbox.run([&args[..], &settings].concat()).code, Some(0));
        let of_row = |row| sandbox.bytes(&format!("images/cornell-{row}-{iterations}.pfm"));
        assert!(of_row("fast") == sandbox.bytes("render.pfm"), "{iterations}");
        assert_eq!(of_row("6").len(), of_row("fast").len());
        assert!(of_row("6") != of_row("fast"), "{iterations}");
    }
    assert_eq!(std::fs::read_dir(sandbox.path("images")).unwrap().count(), 6);
}

#[test]
fn what_cannot_be_run_is_refused() {
    let sandbox = Sandbox::new();
    let cases: [(&[&str], &[&str]); 10] = [
        (&["--similarity", "--sweep", "depth"], &["--similarity", "--sweep iterations"]),
        (&["--numbers", "--quick"], &["--numbers", "--quick"]),
        (&["--rows", "7"], &["--rows", "\"7\"", "is no row", "kdtree-own and fast"]),
        (&["--sweep", "colour"], &["--sweep", "\"colour\"", "iterations, photons, size, depth and spheres"]),
        (&["--scene", "cornell", "--sweep", "spheres"], &["--sweep spheres", "too few balls", "random"]),
        (&["--scene", "kornell"], &["\"kornell\"", "did you mean cornell?"]),
        (&["--plots", "missing"], &["--plots", "missing is not a folder"]),
        (&["--images", "missing"], &["--images", "missing is not a folder"]),
        (&["--images", ".", "--sweep", "depth"], &["--images", "--sweep"]),
        (&["--csv", "missing/a.csv"], &["--csv", "missing"]),
    ];
    for (args, words) in cases {
        let ended = sandbox.run(["ladder"].iter().chain(args));
        assert_eq!(ended.code, Some(2), "{args:?}: {ended:?}");
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        for word in words {
            assert!(ended.stderr.contains(word), "no {word:?} in {ended:?}");
        }
    }
    assert_eq!(sandbox.names(), [""; 0]);
}

/// Its rows are those of the paper, which sends one shadow ray from each point.
#[test]
fn several_light_samples_are_refused() {
    let ended = Sandbox::new().run(["ladder", "--quick", "--scene", "mirror", "--light-samples", "2"]);
    ended.refused(&["--light-samples", "it must be 1"]);
}
