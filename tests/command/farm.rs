//! The command `farm`. Here a shell script replaces Python; `python/tests` has tests of the farm itself.

use crate::sandbox::{Ended, Sandbox};
use std::env;
use std::fs::{Permissions, set_permissions};
use std::os::unix::fs::PermissionsExt as _;

/// Runs `sppm farm` with `words`, where `python3` is a script that ends with `probe` when it is asked what it has. Otherwise it
/// prints how many words it got, and which.
fn farm(sandbox: &Sandbox, probe: &str, words: &[&str]) -> Ended {
    let script = "#!/bin/sh\n[ \"$1\" = -c ] && { echo \"$2\" > asked; exit $PROBE; }\necho $# \"$@\"\n";
    sandbox.write("python3", script);
    set_permissions(sandbox.path("python3"), Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", sandbox.path("").display(), env::var("PATH").unwrap_or_default());
    let mut command = sandbox.command(["farm"].iter().chain(words));
    let output =
        command.env_remove("SPPM_PYTHON").envs([("PATH", &path[..]), ("PROBE", probe)]).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// All words are the farm's, those among them that this command knows too.
#[test]
fn without_a_name_python_is_the_usual_one_and_gets_all_words() {
    let sandbox = Sandbox::new();
    let ended = farm(&sandbox, "0", &["a box.toml", "--help", "-o", "a.exr"]);
    let expected = (Some(0), "6 -m sppm.farm a box.toml --help -o a.exr\n");
    assert_eq!((ended.code, &ended.stdout[..]), expected, "{ended:?}");
    let asked = String::from_utf8(sandbox.bytes("asked")).unwrap();
    assert!(asked.contains("sppm.farm") && asked.contains("distributed"), "{asked}");
}

#[test]
fn what_python_lacks_is_told_with_what_helps() {
    let ended = farm(&Sandbox::new(), "1", &["cornell"]);
    ended.refused(&["farm: python3 lacks", "pip install \"./python[farm]\"", "by SPPM_PYTHON"]);
}
