//! That transcripts use every option of every command.

use crate::all;
use crate::session::{read, words};
use std::collections::BTreeMap;
use std::process::Command;

/// Options that transcripts cannot use: they need a viewer or a browser.
const LEFT_OUT: [&str; 0] = [];

fn help(arguments: &[&str]) -> String {
    let out = Command::new(env!("CARGO_BIN_EXE_sppm")).args(arguments).output().unwrap();
    String::from_utf8(out.stdout).unwrap()
}

/// An option: its long and its short name, and its value if it is not given.
#[derive(Debug)]
struct Known {
    long: String,
    short: Option<String>,
    default: Option<String>,
}

/// The options that a command's help lists.
fn options(help: &str) -> Vec<Known> {
    let mut known: Vec<Known> = Vec::new();
    for line in help.lines() {
        let indent = line.len() - line.trim_start().len();
        let head = line.trim_start();
        // Texts are indented more.
        if (1..=6).contains(&indent) && head.starts_with('-') {
            let mut short = None;
            for word in head.split([' ', ',']) {
                if let Some(name) = word.strip_prefix("--") {
                    let long = name.split(['=', '[']).next().unwrap().to_owned();
                    known.push(Known { long: format!("--{long}"), short, default: None });
                    break;
                }
                if word.starts_with('-') {
                    short = Some(word.to_owned());
                }
            }
        } else if let (Some((_, rest)), Some(last)) = (line.split_once("[default: "), known.last_mut()) {
            last.default = rest.split(']').next().map(str::to_owned);
        }
    }
    known
}

/// Every option stands in some command line of its command, with a value that is not its default.
#[test]
fn every_option_is_in_a_transcript() {
    let mut lines: BTreeMap<String, Vec<Vec<String>>> = BTreeMap::new();
    for (_, text) in all() {
        for session in read(&text) {
            for line in session.commands() {
                let words: Vec<String> =
                    words(line).into_iter().skip_while(|word| word.contains('=')).collect();
                if words[0] == "sppm" && words.len() > 1 {
                    lines.entry(words[1].clone()).or_default().push(words);
                }
            }
        }
    }
    let general = help(&["--help"]);
    let list = general.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let commands: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.len() > 10, "{commands:?}");
    let mut missing = Vec::new();
    for command in commands.into_iter().filter(|command| *command != "help") {
        let used = lines.get(command).cloned().unwrap_or_default();
        if used.is_empty() {
            missing.push(command.to_owned());
        }
        for Known { long, short, default } in options(&help(&[command, "--help"])) {
            let is_other = |value: Option<&str>| default.is_none() || value != default.as_deref();
            let uses = |words: &Vec<String>| {
                words.iter().enumerate().any(|(at, word)| {
                    let (name, value) = word
                        .split_once('=')
                        .map_or((word.as_str(), None), |(name, value)| (name, Some(value)));
                    (name == long || Some(name) == short.as_deref())
                        && is_other(value.or_else(|| words.get(at + 1).map(String::as_str)))
                })
            };
            let is_left_out = LEFT_OUT.contains(&long.as_str());
            if !is_left_out && !used.iter().any(uses) {
                missing.push(format!("{command} {long}"));
            }
        }
    }
    assert!(missing.is_empty(), "no transcript has {}", missing.join(", "));
}
