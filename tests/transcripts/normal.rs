//! Puts words in place of what depends on the clock, the machine and the version.

use std::path::Path;

/// `text` without what is another on every run or machine. The session's folder is `[here]`.
pub(crate) fn normal(text: &str, folder: &Path) -> String {
    let mut text = text.to_owned();
    for (path, word) in [(folder, "[here]"), (Path::new(env!("CARGO_MANIFEST_DIR")), "[repository]")] {
        text = text.replace(path.to_str().unwrap(), word);
    }
    let version = env!("CARGO_PKG_VERSION");
    for before in ["sppm ", "sppm-", "\"version\":\"", "\"version\": \"", "sppm \""] {
        text = text.replace(&format!("{before}{version}"), &format!("{before}[version]"));
    }
    // What `sppm verify` compares: the other kinds of lanes that the processor has.
    let is_other = |line: &str| {
        ["avx2", "avx512"].iter().any(|lanes| line.starts_with(&format!("  fast on {lanes} lanes and ")))
    };
    text = text.split_inclusive('\n').filter(|line| !is_other(line)).collect();
    for lanes in ["avx512", "avx2", "emulated"] {
        for (before, after) in [("", " lanes"), ("\"lanes\":\"", "\""), ("\"lanes\": \"", "\"")] {
            text = text.replace(&format!("{before}{lanes}{after}"), &format!("{before}[lanes]{after}"));
        }
    }
    text = after(&text, "`--time ", |c| c != '`', "[time]");
    text = after(&text, "-rescued-", |c| c.is_ascii_digit(), "[id]");
    text = after(&text, "in use by another render, process ", |c| c.is_ascii_digit(), "[id]");
    // Accounts of checkpoints hold times, so their lengths differ.
    text = after(&text, " of its ", |c| c.is_ascii_digit(), "[n]");
    // Rounds of photons follow the lanes.
    for mark in ["\"candidates\": ", "\"candidates\":"] {
        text = after(&text, mark, |c| c.is_ascii_digit(), "[n]");
    }
    text = after(&text, "\"timestamp\":\"", |c| c != '"', "[time]");
    text = numbers_of_json(&text);
    quantities(&text)
}

/// What follows `mark` as long as `is_of` holds becomes `word`.
fn after(text: &str, mark: &str, is_of: impl Fn(char) -> bool, word: &str) -> String {
    let mut pieces = text.split(mark);
    let mut done = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let end = piece.find(|c| !is_of(c)).unwrap_or(piece.len());
        done += mark;
        done += if end > 0 { word } else { "" };
        done += &piece[end..];
    }
    done
}

/// Numbers in JSON that are times or bytes: their keys end in `seconds`, `bytes` or `bytes_at_most`.
fn numbers_of_json(text: &str) -> String {
    let mut done = text.to_owned();
    for end in ["seconds", "bytes", "bytes_at_most"] {
        for colon in ["\":", "\": "] {
            let mark = format!("{end}{colon}");
            done = after(&done, &mark, |c| c.is_ascii_digit() || ".e-".contains(c), "[measured]");
        }
    }
    done
}

/// Times such as `0.42 s` or `3 min 20 s`, and sizes such as `1.5 MiB`.
fn quantities(text: &str) -> String {
    const UNITS: [(&str, &str); 6] = [
        ("s", "[time]"),
        ("min", "[time]"),
        ("h", "[time]"),
        ("ms", "[time]"),
        ("MiB", "[size]"),
        ("KiB", "[size]"),
    ];
    let mut done = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let end =
            rest[at..].find(|c: char| !(c.is_ascii_digit() || c == '.')).map_or(rest.len(), |end| at + end);
        let is_begun = rest[..at].ends_with(|c: char| c.is_alphanumeric() || "_-.".contains(c));
        let unit = rest[end..].strip_prefix(' ').map(|after| {
            let length = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
            &after[..length]
        });
        let word = UNITS.iter().find(|(name, _)| !is_begun && unit == Some(name));
        done += &rest[..at];
        if let Some((name, word)) = word {
            done += word;
            rest = &rest[end + 1 + name.len()..];
        } else {
            done += &rest[at..end];
            rest = &rest[end..];
        }
    }
    done += rest;
    done.replace("[time] [time]", "[time]")
}

#[test]
fn what_depends_on_the_run_is_left_out() {
    let of = |text: &str| normal(text, Path::new("/some/folder"));
    assert_eq!(
        of("/some/folder/a.png in 0.42 s, 3 min 20 s; 52.5 MiB"),
        "[here]/a.png in [time], [time]; [size]"
    );
    assert_eq!(
        of("`--time 10m` and a-rescued-123.png of 3 shots"),
        "`--time [time]` and a-rescued-[id].png of 3 shots"
    );
    assert_eq!(
        of("\"wall_seconds\": 0.5e-3, \"bytes\":12,"),
        "\"wall_seconds\": [measured], \"bytes\":[measured],"
    );
    assert_eq!(
        of("engine fast on avx2 lanes, \"lanes\":\"avx512\""),
        "engine fast on [lanes] lanes, \"lanes\":\"[lanes]\""
    );
    assert_eq!(of(concat!("sppm ", env!("CARGO_PKG_VERSION"))), "sppm [version]");
}
