//! Help, version, completions and manual pages.

use crate::sandbox::{Ended, Sandbox};
use std::fs;

const COMMANDS: [&str; 15] = [
    "render",
    "resume",
    "merge",
    "farm",
    "view",
    "info",
    "scenes",
    "compare",
    "verify",
    "trace",
    "export",
    "ladder",
    "tune",
    "completions",
    "man",
];

/// Standard output of a run that succeeds, prints nothing to standard error and writes no files.
fn output(args: &[&str]) -> String {
    let sandbox = Sandbox::new();
    let Ended { code, stdout, stderr } = sandbox.run(args);
    assert_eq!((code, stderr.as_str()), (Some(0), ""), "{args:?}");
    assert_eq!(sandbox.names(), [""; 0], "{args:?}");
    stdout
}

#[test]
fn help_names_every_command_and_shows_examples() {
    for args in [["--help"], ["-h"], ["help"]] {
        let help = output(&args);
        for command in COMMANDS {
            assert!(help.contains(&format!("  {command}  ")), "no {command} in {help}");
        }
    }
    assert!(output(&["--help"]).contains("sppm render cornell"));
}

#[test]
fn every_command_has_help() {
    for command in COMMANDS {
        let help = output(&[command, "--help"]);
        assert!(help.contains(&format!("Usage: sppm {command}")), "{help}");
        assert!(help.contains("Example"), "{help}");
        assert_eq!(help, output(&["help", command]));
    }
}

#[test]
fn version_is_the_packages() {
    for option in ["--version", "-V"] {
        assert_eq!(output(&[option]), format!("sppm {}\n", env!("CARGO_PKG_VERSION")));
    }
}

#[test]
fn completions_contain_all_commands() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = output(&["completions", shell]);
        for word in COMMANDS.iter().chain(&["radius-image"]) {
            assert!(script.contains(word), "no {word} for {shell}");
        }
    }
}

#[test]
fn completions_offer_the_built_in_scenes() {
    let names: Vec<&str> = files::builtin::SCENES.iter().map(|scene| scene.name).collect();
    // What begins the part of a command, and what begins the next part.
    let heads: [(&str, &str, &str); 4] = [
        ("bash", "sppm__subcmd__COMMAND)", ";;"),
        ("elvish", "&'sppm;COMMAND'= {", "}"),
        ("fish", "complete -c sppm -n \"__fish_sppm_using_subcommand COMMAND\" -a \"cornell", "\"\n"),
        ("powershell", "'sppm;COMMAND' {", "}"),
    ];
    for (shell, head, end) in heads {
        let script = output(&["completions", shell]);
        for command in ["render", "verify", "trace", "export", "tune", "scenes"] {
            let head = head.replace("COMMAND", command);
            let at = script.find(&head).unwrap_or_else(|| panic!("no {head} in {script}"));
            let part = &script[at..at + head.len() + script[at + head.len()..].find(end).unwrap()];
            for name in &names {
                assert!(part.contains(name), "no {name} for {command} in {shell}: {part}");
            }
        }
    }
    let zsh = output(&["completions", "zsh"]);
    assert!(zsh.contains("_sppm_scenes() {\n    _alternative 'scenes:scene:((cornell\\:\""), "{zsh}");
    assert!(zsh.contains(":_sppm_scenes' \\\n"), "{zsh}");
}

/// The shell itself completes the first letter of a scene, and the name of a file.
#[cfg(unix)]
#[test]
fn bash_completes_scenes_and_files() {
    let sandbox = Sandbox::new();
    sandbox.write("script", &output(&["completions", "bash"]));
    let complete = |words: &str, count: u32| {
        let script = format!(
            "source ./script; COMP_WORDS=({words}); COMP_CWORD={count}; _sppm sppm \"${{COMP_WORDS[$COMP_CWORD]}}\" x; \
             echo \"${{COMPREPLY[@]}}\""
        );
        let Ok(done) =
            std::process::Command::new("bash").args(["-c", &script]).current_dir(sandbox.path("")).output()
        else {
            return None; // there is no bash
        };
        assert!(done.status.success() && done.stderr.is_empty(), "{done:?}");
        Some(String::from_utf8(done.stdout).unwrap())
    };
    for (words, count, reply) in
        [("sppm render cor", 2, "cornell\n"), ("sppm scenes mo", 2, "motion\n"), ("sppm rend", 1, "render\n")]
    {
        let completed = complete(words, count);
        assert!(completed.as_deref().is_none_or(|completed| completed == reply), "{words}: {completed:?}");
    }
}

#[test]
fn the_manual_page_goes_to_standard_output() {
    let page = output(&["man"]);
    assert!(page.contains(".TH sppm 1"), "{page}");
}

#[test]
fn manual_pages_of_all_commands_go_into_a_folder() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.path("man1")).unwrap();
    assert_eq!(sandbox.run(["man", "man1"]).code, Some(0));
    for command in COMMANDS {
        let page = String::from_utf8(sandbox.bytes(&format!("man1/sppm-{command}.1"))).unwrap();
        assert!(page.contains(&format!(".TH sppm-{command} 1")), "{page}");
    }
    assert!(sandbox.path("man1/sppm.1").exists());
    // And no others: `sppm help` has nothing to tell of itself. The folder is one more name.
    assert_eq!(sandbox.names().len(), COMMANDS.len() + 2, "{:?}", sandbox.names());
}
