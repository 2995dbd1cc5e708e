//! The command `trace`.

use crate::sandbox::Sandbox;
use files::builtin;
use npyz::{NpyFile, Order, WriterBuilder as _};
use scene::ray::NO_SPHERE;
use scene::{Ray, Vec3};

/// A row of the file of hits.
#[derive(Clone, Copy, Debug, PartialEq, npyz::Deserialize)]
struct Hit {
    t: f32,
    sphere: i32,
    normal: [f32; 3],
}

/// The bytes of a `.npy` file.
fn array<T: npyz::AutoSerialize + Copy>(shape: &[u64], values: &[T], order: Order) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new().default_dtype().shape(shape).order(order);
    let mut writer = options.writer(&mut bytes).begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
    bytes
}

fn rays(values: &[[f32; 6]]) -> Vec<u8> {
    array(&[values.len() as u64, 6], &values.concat(), Order::C)
}

fn hits(sandbox: &Sandbox, name: &str) -> Vec<Hit> {
    NpyFile::new(&sandbox.bytes(name)[..]).unwrap().into_vec().unwrap()
}

/// A folder with `rays.npy`.
fn prepared(bytes: &[u8]) -> Sandbox {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.path("rays.npy"), bytes).unwrap();
    sandbox
}

fn trace(sandbox: &Sandbox, args: &[&str]) {
    let command = ["trace", "--rays", "rays.npy", "--hits"];
    let ended = sandbox.run(command.iter().chain(args));
    assert_eq!((ended.code, ended.stdout.as_str(), ended.stderr.as_str()), (Some(0), "", ""), "{args:?}");
}

/// Rays from the eye of a built-in scene in a grid of directions.
fn all_around(name: &str) -> Vec<[f32; 6]> {
    let eye = builtin::scene(name).unwrap().camera.eye;
    let mut found = Vec::new();
    for i in 0..40 {
        for k in 0..25 {
            let (z, phi) = (-0.96 + 0.08 * k as f32, 0.157 * i as f32);
            let r = (1.0 - z * z).sqrt();
            found.push([eye.x, eye.y, eye.z, r * phi.cos(), r * phi.sin(), z]);
        }
    }
    found
}

const FLOOR_OF_GLASS: &str = "
background = [1, 1, 1]
camera = { eye = [0, 0, 10], direction = [0, 0, -1], vertical_fov_degrees = 40, shutter = [0, 2] }
[[sphere]]
center = [0, 0, 0]
velocity = [0, 0, -1]
radius = 2
material = { type = \"dielectric\", albedo = [1, 1, 1], ior = 1.5 }
";

#[test]
fn hits_are_at_the_expected_places() {
    let sandbox = prepared(&rays(&[
        [0.0, 0.0, 10.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, 10.0, 0.0, 0.0, -25.0],
        [0.0, 0.0, 0.0, 0.0, 3.0, 4.0],
        [0.0, 0.0, 10.0, 0.0, 0.0, 1.0],
    ]));
    sandbox.write("ball.toml", FLOOR_OF_GLASS);
    for engine in ["fast", "reference"] {
        trace(&sandbox, &["hits.npy", "ball.toml", "--engine", engine]);
        let found = hits(&sandbox, "hits.npy");
        let front = Hit { t: 8.0, sphere: 0, normal: [0.0, 0.0, 1.0] };
        assert_eq!(found[..2], [front, front], "{engine}");
        // From the inside, along a direction that is not a unit vector: t is still a distance in scene units.
        assert_eq!((found[2].t, found[2].sphere), (2.0, 0), "{engine}");
        assert!(
            (found[2].normal[1] + 0.6).abs() < 1e-6 && (found[2].normal[2] + 0.8).abs() < 1e-6,
            "{engine}"
        );
        // The background is one more sphere, after those of the file.
        assert_eq!(found[3].sphere, 1, "{engine}");

        trace(&sandbox, &["late.npy", "ball.toml", "--engine", engine, "--time", "2"]);
        assert_eq!(hits(&sandbox, "late.npy")[0], Hit { t: 10.0, ..front }, "{engine}");
    }
}

#[test]
fn engines_and_lanes_write_the_same_bytes() {
    for scene in ["cornell", "random", "surgery"] {
        let given = all_around(scene);
        let sandbox = prepared(&rays(&given));
        trace(&sandbox, &["reference.npy", scene, "--engine", "reference"]);
        let expected = sandbox.bytes("reference.npy");
        for lanes in fast::LaneKind::ALL.into_iter().filter(|kind| kind.is_available()) {
            let name = format!("{lanes:?}").to_lowercase();
            trace(&sandbox, &["fast.npy", scene, "--lanes", &name, "--threads", "2"]);
            assert!(sandbox.bytes("fast.npy") == expected, "{scene} on {name}");
        }
        let opened = builtin::scene(scene).unwrap();
        let still = opened.at(0.0);
        for (values, hit) in given.iter().zip(hits(&sandbox, "reference.npy")) {
            let [origin, direction] = [0, 3].map(|at| Vec3::from_slice(&values[at..at + 3]));
            let nearest =
                reference::intersect::intersect(&still, &Ray { origin, direction, leaves: NO_SPHERE });
            let expected =
                nearest.map_or((f32::INFINITY, -1, [0.0; 3]), |h| (h.t, h.sphere as i32, h.normal.into()));
            assert_eq!((hit.t, hit.sphere, hit.normal), expected, "{scene}");
        }
    }
}

#[test]
fn arrays_may_have_any_order_and_length() {
    let given = all_around("cornell");
    for count in [0, 1, 257, 1000] {
        let sandbox = prepared(&rays(&given[..count]));
        trace(&sandbox, &["c.npy", "cornell"]);
        assert_eq!(hits(&sandbox, "c.npy").len(), count);
        let columns: Vec<f32> = (0..6).flat_map(|k| given[..count].iter().map(move |ray| ray[k])).collect();
        let fortran = array(&[count as u64, 6], &columns, Order::Fortran);
        std::fs::write(sandbox.path("rays.npy"), fortran).unwrap();
        trace(&sandbox, &["fortran.npy", "cornell"]);
        assert!(sandbox.bytes("c.npy") == sandbox.bytes("fortran.npy"), "{count} rays");
    }
}

#[test]
fn bad_arrays_are_refused_and_nothing_written() {
    let one = [50.0, 50.0, 200.0, 0.0, 0.0, -1.0];
    let with = |at: usize, value: f32| {
        let mut ray = one;
        ray[at] = value;
        rays(&[one, ray])
    };
    let whole = rays(&[one; 4]);
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (4000000000000000000, 6), }\n";
    let endless =
        [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes()].concat();
    let cases: [(Vec<u8>, &[&str]); 13] = [
        (array(&[1, 6], &one.map(f64::from), Order::C), &["rays.npy", "'<f8'", "float32", "astype"]),
        (array(&[1, 6], &[1_i32; 6], Order::C), &["'<i4'", "float32"]),
        (array(&[2, 3], &one, Order::C), &["shape (2, 3)", "(N, 6)"]),
        (array(&[6], &one, Order::C), &["has 1 dimension;", "(N, 6)"]),
        (array(&[1, 6, 1], &one, Order::C), &["3 dimensions"]),
        (with(0, f32::NAN), &["ray 1 is not finite"]),
        (with(5, f32::INFINITY), &["ray 1 is not finite"]),
        (with(5, 0.0), &["ray 1", "length 0"]),
        (whole[..whole.len() - 1].to_vec(), &["is too short for 4 rays: it has "]),
        (whole[..20].to_vec(), &["rays.npy", ".npy"]),
        (b"no array".to_vec(), &["rays.npy", "numpy.save"]),
        (Vec::new(), &["rays.npy", "numpy.save"]),
        (endless, &["is too short for 4000000000000000000 rays"]),
    ];
    for (bytes, words) in cases {
        let sandbox = prepared(&bytes);
        sandbox.run(["trace", "cornell", "--rays", "rays.npy", "--hits", "hits.npy"]).refused(words);
        assert_eq!(sandbox.names(), ["rays.npy"], "{words:?}");
    }
}

#[test]
fn bad_options_are_refused_and_nothing_written() {
    let sandbox = prepared(&rays(&[[50.0, 50.0, 200.0, 0.0, 0.0, -1.0]]));
    sandbox.write("ball.toml", FLOOR_OF_GLASS);
    let before = sandbox.contents();
    let cases: [(&[&str], &[&str]); 11] = [
        (&["cornell"], &["--rays and --hits are missing", "sppm trace --help"]),
        (&["cornell", "--rays", "rays.npy"], &["--hits is missing"]),
        (&["cornel", "--rays", "rays.npy", "--hits", "h.npy"], &["did you mean cornell?"]),
        (&["cornell", "--rays", "no.npy", "--hits", "h.npy"], &["--rays: no.npy: there is no such file"]),
        (
            &["cornell", "--rays", ".", "--hits", "h.npy"],
            &["--rays: .: this is a directory; name a .npy file"],
        ),
        (&["cornell", "--rays", "rays.npy", "--hits", "rays.npy"], &["--hits: rays.npy is also --rays"]),
        (&["ball.toml", "--rays", "rays.npy", "--hits", "h.txt"], &["--hits: h.txt", ".npy"]),
        (&["cornell", "--rays", "rays.npy", "--hits", "no/h.npy"], &["--hits: no/h.npy", "does not exist"]),
        (
            &["ball.toml", "--rays", "rays.npy", "--hits", "h.npy", "--time", "3"],
            &["--time: 3", "open, 0 to 2"],
        ),
        (&["cornell", "--rays", "rays.npy", "--hits", "h.npy", "--engine", "path"], &["--engine: \"path\""]),
        (
            &["cornell", "--rays", "rays.npy", "--hits", "h.npy", "--engine", "reference", "--lanes", "auto"],
            &["--lanes", "reference"],
        ),
    ];
    for (args, words) in cases {
        sandbox.run(["trace"].iter().chain(args)).refused(words);
        assert!(sandbox.contents() == before, "{args:?} changed the folder: {:?}", sandbox.names());
    }
}

/// A link is the file that it leads to.
#[cfg(unix)]
#[test]
fn hits_go_into_neither_the_scene_nor_the_rays() {
    let sandbox = prepared(&rays(&[[0.0, 0.0, 10.0, 0.0, 0.0, -1.0]]));
    sandbox.write("ball.toml", FLOOR_OF_GLASS);
    let link = sandbox.path("h.npy");
    for (target, what) in [("ball.toml", "the scene"), ("rays.npy", "--rays")] {
        std::os::unix::fs::symlink(target, &link).unwrap();
        let ended = sandbox.run(["trace", "ball.toml", "--rays", "rays.npy", "--hits", "h.npy"]);
        ended.refused(&[&format!("--hits: h.npy is also {what}")]);
        std::fs::remove_file(&link).unwrap();
    }
}
