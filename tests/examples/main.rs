//! Runs every example and checks its output.

use std::path::Path;
use std::process::Command;

/// Runs an example with `args` and returns its standard output.
fn run(name: &str, folder: &Path, args: &[&str]) -> String {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--locked", "--example", name, "--manifest-path"]);
    cargo.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).arg("--").args(args);
    let output = cargo.current_dir(folder).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{name}: {stdout}{stderr}");
    stdout.into_owned()
}

#[test]
fn render_and_save() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("render_and_save", folder.path(), &["a.exr"]);
    assert_eq!(said, "wrote a.exr after 16 iterations\n");
    let film = files::image_file::read(&folder.path().join("a.exr")).unwrap();
    assert_eq!((film.width, film.height), (160, 120));
}

#[test]
fn watch_and_stop() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("watch_and_stop", folder.path(), &[]);
    assert!(said.contains("iteration 1: 20000 photons, mean radius 2.000"), "{said}");
    assert!(said.contains("Begun") && said.ends_with("4 iterations from another place\n"), "{said}");
}

#[test]
fn compare_engines() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("compare_engines", folder.path(), &[]);
    assert!(said.starts_with("photon mapping against path tracing:\n") && said.contains("RMSE"), "{said}");
}

#[test]
fn build_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("build_a_scene", folder.path(), &["b.png"]);
    assert!(said.contains("[[sphere]]") && said.ends_with("wrote [\"b.png\"]\n"), "{said}");
    assert!(files::image_file::read(&folder.path().join("b.png")).is_ok());
}

#[test]
fn read_rays() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("read_rays", folder.path(), &[]);
    assert_eq!(said.lines().count(), 3, "{said}");
    assert!(said.lines().all(|line| line.starts_with("sphere ")), "{said}");
}
