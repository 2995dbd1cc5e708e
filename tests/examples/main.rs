//! Runs every example and checks its output.

use std::path::Path;
use std::process::Command;
use std::sync::Once;

/// Runs an example with `args` in `folder` and returns what it prints.
fn run(name: &str, folder: &Path, args: &[&str]) -> String {
    build();
    let program = Path::new(env!("CARGO_BIN_EXE_sppm")).with_file_name("examples").join(name);
    let output = Command::new(program).args(args).current_dir(folder).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{name}: {stdout}{stderr}");
    stdout.into_owned()
}

/// Builds the examples, unless `cargo test --workspace` just has: with the whole workspace, so that the features of
/// dependencies are the same.
fn build() {
    static BUILT: Once = Once::new();
    BUILT.call_once(|| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "--locked", "--workspace", "--examples"]);
        assert!(cargo.current_dir(env!("CARGO_MANIFEST_DIR")).status().unwrap().success());
    });
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
    assert!(said.contains("iteration 1: 20000 photons, mean radius 1.6"), "{said}");
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
