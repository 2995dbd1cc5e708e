//! The command `completions`: generates a script for a shell from the definitions of the options, and has it offer the
//! names of the built-in scenes.

use crate::terminal::error::Error;
use crate::terminal::text::print;
use clap::{Arg, Args as ClapArgs, Command};
use clap_complete::Shell;
use files::builtin::SCENES;

/// Print a script that completes commands, options and the names of scenes in a shell
#[derive(Debug, ClapArgs)]
#[command(
    after_long_help = "Example:\n  sppm completions bash > ~/.local/share/bash-completion/completions/sppm"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Runs the command.
pub(crate) fn run(mut command: Command, args: &CompletionsArgs) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "sppm", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    print(with_scenes(args.shell, script, &takers(&command)).as_bytes())
}

/// The commands whose first argument is a scene.
fn takers(command: &Command) -> Vec<&str> {
    let is_scene = |arg: &Arg| {
        let mut values = arg.get_possible_values().into_iter();
        values.any(|value| value.get_name() == SCENES[0].name)
    };
    let takes = |command: &&Command| command.get_positionals().any(is_scene);
    command.get_subcommands().filter(takes).map(Command::get_name).collect()
}

/// `script` with the names of the scenes for the commands `takers`. The generator for bash offers them by itself.
fn with_scenes(shell: Shell, script: String, takers: &[&str]) -> String {
    match shell {
        Shell::Elvish => after_heads(script, takers, |name| format!("&'sppm;{name}'= {{"), elvish),
        Shell::Fish => script + &fish(takers),
        Shell::PowerShell => after_heads(script, takers, |name| format!("'sppm;{name}' {{"), powershell),
        Shell::Zsh => zsh(&script),
        _ => script,
    }
}

/// Adds a line for each scene after the line that begins the completions of each command.
fn after_heads(
    mut script: String,
    takers: &[&str],
    head: impl Fn(&str) -> String,
    line: fn(&str, &str) -> String,
) -> String {
    let indented = |line: String| {
        [
            "
            "
            .to_owned(),
            line,
        ]
        .concat()
    };
    let lines: String = SCENES.iter().map(|scene| indented(line(scene.name, scene.about))).collect();
    for head in takers.iter().map(|name| head(name)) {
        script = script.replacen(&head, &format!("{head}{lines}"), 1);
    }
    script
}

fn elvish(name: &str, about: &str) -> String {
    format!("cand {name} '{about}'")
}

fn powershell(name: &str, about: &str) -> String {
    format!("[CompletionResult]::new('{name}', '{name}', [CompletionResultType]::ParameterValue, '{about}')")
}

fn fish(takers: &[&str]) -> String {
    let names: Vec<String> =
        SCENES.iter().map(|scene| format!("{}\\t'{}'", scene.name, scene.about)).collect();
    let names = names.join("\n");
    let line =
        |name: &&str| format!("complete -c sppm -n \"__fish_sppm_using_subcommand {name}\" -a \"{names}\"\n");
    takers.iter().map(line).collect()
}

/// By itself zsh would offer nothing but the listed values, and no scene files.
fn zsh(script: &str) -> String {
    /// What the generated script calls at its end.
    const MAIN: &str = "if [ \"$funcstack[1]\" = \"_sppm\" ]; then";
    let start = "((cornell\\:";
    let Some(list) =
        script.find(start).and_then(|at| script[at..].find("))").map(|end| &script[at..at + end + 2]))
    else {
        return script.to_owned();
    };
    let function = format!(
        "(( $+functions[_sppm_scenes] )) ||\n_sppm_scenes() {{\n    _alternative 'scenes:scene:{list}' \
         'files:scene file:_files -g \"*.toml\"'\n}}\n\n"
    );
    script.replace(list, "_sppm_scenes").replacen(MAIN, &(function + MAIN), 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In every shell, for all commands that take a scene.
    #[test]
    fn names_of_scenes_are_offered_by_the_commands_that_take_one() {
        use clap::CommandFactory as _;
        let mut command = crate::commands::Args::command();
        let names: Vec<String> = takers(&command).into_iter().map(String::from).collect();
        for taker in ["render", "verify", "trace", "export", "view", "scenes", "tune"] {
            assert!(names.iter().any(|name| name == taker), "{names:?}");
        }
        assert!(!names.iter().any(|name| name == "compare" || name == "info"), "{names:?}");
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        for shell in [Shell::Bash, Shell::Elvish, Shell::Fish, Shell::PowerShell, Shell::Zsh] {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut command, "sppm", &mut script);
            let script = with_scenes(shell, String::from_utf8(script).unwrap(), &names);
            for scene in SCENES {
                assert!(script.contains(scene.name), "{shell}: {}", scene.name);
            }
            let of_first = match shell {
                Shell::Elvish => format!("cand {} '", SCENES[0].name),
                Shell::PowerShell => format!("[CompletionResult]::new('{}', '", SCENES[0].name),
                Shell::Fish => format!("\" -a \"{}\\t'", SCENES[0].name),
                _ => continue,
            };
            assert_eq!(script.matches(&of_first).count(), names.len(), "{shell}");
        }
    }
}
