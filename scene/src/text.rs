//! Formats lists, counts, times and sizes for messages.

use std::fmt::{Display, Write as _};

/// `text` with its control characters escaped, so that it stays one line whatever a file name holds.
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            let _ = write!(line, "{}", c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}

/// Joins `items` to a list: `a, b and c`.
pub fn list<T: Display>(items: &[T]) -> String {
    let words: Vec<String> = items.iter().map(ToString::to_string).collect();
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => words.concat(),
    }
}

/// `1 iteration`, `2 iterations`.
pub fn counted(number: impl Into<u64>, noun: &str) -> String {
    match number.into() {
        1 => format!("1 {noun}"),
        n => format!("{n} {noun}s"),
    }
}

/// A quantity to three digits with an SI prefix: `1.23M`.
pub fn scaled(value: f64) -> String {
    const PREFIXES: [(f64, &str); 4] = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, "")];
    // What would be rounded to a thousand has the next prefix.
    let is_of = |&(unit, _): &(f64, &str)| value / unit >= 0.9995;
    let (unit, prefix) = PREFIXES.into_iter().find(is_of).unwrap_or((1.0, ""));
    format!("{:.*}{prefix}", decimals(value / unit), value / unit)
}

/// The number of decimals that gives `value` three digits once it is rounded to them.
fn decimals(value: f64) -> usize {
    match value {
        v if v >= 99.95 => 0,
        v if v >= 9.995 => 1,
        _ => 2,
    }
}

/// Formats a time: `0.42 s`, `12.3 s`, `3 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.*} s", decimals(seconds)),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

/// Formats a number of bytes: `1.5 MiB`; less than a mebibyte as `1.5 KiB`, or `15 bytes`.
pub fn mebibytes(bytes: u64) -> String {
    match bytes {
        0..1024 => counted(bytes, "byte"),
        1024..0x10_0000 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_spelled_out() {
        assert_eq!(one_line("a\nb\u{7f}\tc é"), "a\\nb\\u{7f}\\tc é");
    }

    #[test]
    fn lists_read_well() {
        assert_eq!(list::<&str>(&[]), "");
        assert_eq!(list(&["a"]), "a");
        assert_eq!(list(&["a", "b"]), "a and b");
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
    }

    #[test]
    fn quantities_have_three_digits() {
        assert_eq!(scaled(0.0), "0.00");
        assert_eq!(scaled(999.0), "999");
        assert_eq!(scaled(1234.0), "1.23k");
        assert_eq!(scaled(45_678_901.0), "45.7M");
        let whole = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 2e9, 5e12].map(scaled);
        assert_eq!(whole, ["1.00", "10.0", "100", "1.00k", "10.0k", "100k", "1.00M", "2.00G", "5000G"]);
        // Rounded up to one more digit before the point, or to the next prefix.
        let rounded = [9.994, 9.996, 99.94, 99.96, 999.4, 999.6, 999_400.0, 999_600.0].map(scaled);
        assert_eq!(rounded, ["9.99", "10.0", "99.9", "100", "999", "1.00k", "999k", "1.00M"]);
    }

    #[test]
    fn one_is_no_plural() {
        let all = [0_u32, 1, 2, 21].map(|number| counted(number, "frame"));
        assert_eq!(all, ["0 frames", "1 frame", "2 frames", "21 frames"]);
    }

    #[test]
    fn few_bytes_are_not_told_as_none() {
        let all = [0, 1, 1023, 1536, 1 << 20, 3 << 30].map(mebibytes);
        assert_eq!(all, ["0 bytes", "1 byte", "1023 bytes", "1.5 KiB", "1.0 MiB", "3072.0 MiB"]);
    }

    #[test]
    fn durations_carry_into_the_next_unit() {
        assert_eq!(duration(0.424), "0.42 s");
        assert_eq!(duration(12.34), "12.3 s");
        assert_eq!(duration(59.7), "1 min 0 s");
        assert_eq!(duration(200.0), "3 min 20 s");
        assert_eq!(duration(7500.0), "2 h 5 min");
        let ends = [9.996, 59.4, 60.0, 3599.4, 3599.6, 7199.0, 90_061.0].map(duration);
        let told = ["10.0 s", "59.4 s", "1 min 0 s", "59 min 59 s", "1 h 0 min", "1 h 59 min", "25 h 1 min"];
        assert_eq!(ends, told);
    }
}
