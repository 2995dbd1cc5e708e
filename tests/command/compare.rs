//! The command `compare`. The metrics themselves have unit tests.

use crate::sandbox::{Ended, Sandbox};
use files::image_file::{self, Encoding};
use scene::{Film, Rgb};

/// A folder with a grey image `a.exr`, the same with one brighter pixel, `b.exr`, one with a NaN, and one of another
/// size.
fn prepared() -> Sandbox {
    let sandbox = Sandbox::new();
    let mut film = Film::new(16, 12);
    film.pixels.fill(Rgb::splat(0.25));
    let write = |name: &str, film: &Film| {
        image_file::write(&sandbox.path(name), film, &Encoding::default()).unwrap();
    };
    write("a.exr", &film);
    film.pixels[5 * 16 + 3].y = 0.75;
    write("b.exr", &film);
    film.pixels[0].x = f32::NAN;
    write("nan.exr", &film);
    write("small.exr", &Film::new(8, 12));
    sandbox
}

fn succeeded(ended: &Ended) -> &str {
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""), "{ended:?}");
    &ended.stdout
}

#[test]
fn an_image_is_identical_to_itself() {
    let sandbox = prepared();
    let strictest = ["--max-rmse=0", "--max-relmse=0", "--max-flip=0", "--max-abs=0", "--min-ssim=1"];
    let ended = sandbox.run(["compare", "a.exr", "a.exr"].iter().chain(&strictest));
    assert!(succeeded(&ended).contains("identical"), "{ended:?}");
}

#[test]
fn images_by_different_tone_curves_are_told_apart() {
    let sandbox = Sandbox::new();
    sandbox.render(&["cornell", "-o", "a.png"]);
    sandbox.render(&["cornell", "-o", "clamped.png", "--tone=clamp"]);
    sandbox.render(&["cornell", "-o", "a.exr"]);
    for [a, b] in [["a.png", "a.exr"], ["a.exr", "a.png"], ["clamped.png", "a.png"]] {
        let ended = sandbox.run(["compare", a, b]);
        let line = "warning: a.png shows radiance by the tone curve agx, and the other image does not";
        assert!(ended.code == Some(0) && ended.stderr.starts_with(line), "{ended:?}");
    }
    // Of two curves, that of the judged image is named.
    sandbox.render(&["cornell", "-o", "aces.png", "--tone=aces"]);
    for [a, b, tone] in [["aces.png", "a.png", "aces"], ["a.png", "aces.png", "agx"]] {
        let ended = sandbox.run(["compare", a, b]);
        let line =
            format!("warning: {a} shows radiance by the tone curve {tone}, and the other image does not");
        assert!(ended.code == Some(0) && ended.stderr.starts_with(&line), "{ended:?}");
    }
    // Of a JPEG it is not known.
    sandbox.render(&["cornell", "-o", "a.jpg"]);
    for [a, b] in [["a.png", "a.png"], ["clamped.png", "a.exr"], ["a.png", "a.jpg"], ["a.jpg", "a.exr"]] {
        succeeded(&sandbox.run(["compare", a, b]));
    }
}

#[test]
fn metrics_are_printed_as_text_and_as_json() {
    let sandbox = prepared();
    let ended = sandbox.run(["compare", "a.exr", "b.exr"]);
    for word in ["RMSE", "relative MSE", "PSNR", "SSIM", "FLIP", "HDR-FLIP", "red", "(3, 5)"] {
        assert!(succeeded(&ended).contains(word), "no {word:?} in {ended:?}");
    }
    let ended = sandbox.run(["compare", "a.exr", "b.exr", "--json"]);
    let metrics: serde_json::Value = serde_json::from_str(succeeded(&ended)).unwrap();
    assert_eq!(metrics["largest_difference"]["value"], 0.5);
    assert_eq!(metrics["rmse"]["red"], 0.0);
    assert!(metrics["hdr_flip"].as_f64().unwrap() > 0.0);
    let rmse = metrics["rmse"]["green"].as_f64().unwrap();
    approx::assert_relative_eq!(rmse, 0.5 / 192.0_f64.sqrt(), max_relative = 1e-12);
}

#[test]
fn each_bound_can_be_broken_and_is_named() {
    let sandbox = prepared();
    for (option, bound) in [
        ("--max-rmse", "0.001"),
        ("--max-relmse", "0.0005"),
        ("--max-block-relmse", "0"),
        ("--max-flip", "0"),
        ("--max-hdr-flip", "0"),
        ("--max-abs", "0.49"),
        ("--min-ssim", "1"),
        ("--min-psnr", "90"),
    ] {
        let ended = sandbox.run(["compare", "a.exr", "b.exr", option, bound]);
        assert_eq!(ended.code, Some(1), "{option}: {ended:?}");
        assert_eq!(ended.stderr.lines().count(), 1, "{ended:?}");
        assert!(ended.stderr.contains(&format!("{option} {bound}")), "{ended:?}");
        assert!(ended.stdout.contains("RMSE"), "{ended:?}");
    }
    let lax = ["--max-rmse", "1", "--max-abs", "0.51", "--min-psnr", "0"];
    succeeded(&sandbox.run(["compare", "a.exr", "b.exr"].iter().chain(&lax)));
}

#[test]
fn the_difference_is_brightest_where_it_is_largest() {
    let sandbox = prepared();
    let ended = sandbox.run(["compare", "a.exr", "b.exr", "--difference", "d.png", "--json"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stderr.starts_with("wrote d.png") && ended.stderr.contains("5e-1"), "{ended:?}");
    assert!(serde_json::from_str::<serde_json::Value>(&ended.stdout).is_ok());
    let film = sandbox.image("d.png");
    let brightness = |i: usize| film.pixels[i].element_sum();
    assert!((0..192).all(|i| i == 5 * 16 + 3 || brightness(i) < brightness(5 * 16 + 3)));
    // Where a bound does not hold, it is needed most.
    let ended = sandbox.run(["compare", "a.exr", "b.exr", "--difference", "e.png", "--max-abs", "0"]);
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(sandbox.bytes("e.png") == sandbox.bytes("d.png"));
}

#[test]
fn invalid_input_is_rejected_and_nothing_written() {
    let sandbox = prepared();
    sandbox.write("note.png", "no image");
    sandbox.write("note.txt", "no image");
    image_file::write(&sandbox.path("b.png"), &Film::new(16, 12), &Encoding::default()).unwrap();
    let before = sandbox.contents();
    let cases: [(&[&str], &[&str]); 19] = [
        (&["compare"], &["<A> and <B> are missing", "sppm compare --help"]),
        (&["compare", "a.exr"], &["<B> is missing"]),
        (&["compare", "a.exr", "b.exr", "c.exr"], &["\"c.exr\"", "too many"]),
        (&["compare", "a.exr", "missing.exr"], &["missing.exr: "]),
        (&["compare", "note.png", "a.exr"], &["note.png: "]),
        (&["compare", "note.txt", "a.exr"], &["note.txt", "neither PNG, JPEG"]),
        (&["compare", "a.exr", "small.exr"], &["a.exr and small.exr", "16 x 12", "8 x 12", "same size"]),
        (&["compare", "a.exr", "nan.exr"], &["a.exr and nan.exr", "NaN", "(0, 0)"]),
        (&["compare", "a.exr", "."], &["."]),
        (&["compare", "a.exr", "b.exr", "--max-rmse", "-1"], &["--max-rmse: \"-1\""]),
        (&["compare", "a.exr", "b.exr", "--max-flip", "NaN"], &["--max-flip: \"NaN\""]),
        (&["compare", "a.exr", "b.exr", "--min-ssim", "high"], &["--min-ssim: \"high\""]),
        (
            &["compare", "a.exr", "b.exr", "--max-rmsd", "1"],
            &["no option --max-rmsd", "did you mean --max-rmse?"],
        ),
        (&["compare", "a.exr", "b.exr", "--difference", "d.exr"], &["--difference: d.exr", ".png"]),
        (&["compare", "a.exr", "b.exr", "--difference", "missing/d.png"], &["--difference: missing/d.png"]),
        (&["compare", "note.png", "a.exr", "--difference", "./note.png"], &["--difference", "also image A"]),
        (&["compare", "a.exr", "b.exr", "--difference", "d.jpg"], &["--difference: d.jpg", ".png"]),
        (&["compare", "a.exr", "b.exr", "--layer", "diffuse"], &["a.exr", "no layer `diffuse`"]),
        (
            &["compare", "a.exr", "b.png", "--max-hdr-flip", "1"],
            &["--max-hdr-flip: b.png holds 8 bits of sRGB"],
        ),
    ];
    for (args, words) in cases {
        sandbox.run(args).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
}

#[test]
fn every_format_is_compared_with_every_other() {
    let sandbox = prepared();
    let film = Film::from_fn(40, 30, |x, y| Rgb::new(x as f32 / 40.0, y as f32 / 30.0, 0.5));
    let names = ["s.png", "s.jpg", "s.exr", "s.pfm", "s.hdr", "s.tif"];
    for name in names {
        image_file::write(&sandbox.path(name), &film, &Encoding::default()).unwrap();
    }
    for a in names {
        for b in names {
            let ended = sandbox.run(["compare", a, b, "--json", "--min-ssim=0.98"]);
            let metrics: serde_json::Value = serde_json::from_str(succeeded(&ended)).unwrap();
            let is_linear = |name: &str| !matches!(name, "s.png" | "s.jpg");
            assert_eq!(metrics["hdr_flip"].is_null(), !(is_linear(a) && is_linear(b)), "{a} and {b}");
        }
    }
    succeeded(&sandbox.run(["compare", "s.exr", "s.tif", "--max-abs=0", "--max-hdr-flip=0"]));
}

#[test]
fn a_black_reference_has_no_hdr_flip() {
    let sandbox = prepared();
    image_file::write(&sandbox.path("black.exr"), &Film::new(16, 12), &Encoding::default()).unwrap();
    assert!(!succeeded(&sandbox.run(["compare", "a.exr", "black.exr"])).contains("HDR-FLIP"));
    let ended = sandbox.run(["compare", "a.exr", "black.exr", "--max-hdr-flip=1"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("black.exr is black"), "{ended:?}");
}

#[test]
fn a_layer_is_chosen_by_its_name() {
    let sandbox = prepared();
    let plane = scene::Plane { width: 16, height: 12, values: vec![0.25; 192] };
    image_file::write_plane(&sandbox.path("layers.exr"), &plane, "grey", &Encoding::default()).unwrap();
    // The other image has no layers, and is read whole.
    for args in [["compare", "layers.exr", "a.exr"], ["compare", "a.exr", "layers.exr"]] {
        let ended = sandbox.run(args.iter().chain(&["--layer", "grey", "--max-abs=0"]));
        succeeded(&ended);
        sandbox.run(args.iter().chain(&["--layer", "gray"])).refused(&["layers.exr", "`gray`; it has grey"]);
    }
}
