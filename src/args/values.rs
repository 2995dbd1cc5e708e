//! Parsers for the values of options. Each returns an error message that follows the rejected value in a sentence.

use render::Every;
use scene::settings::MAX_ITERATIONS;
use std::str::FromStr;
use std::time::Duration;

/// Parses whole numbers from `least` to `most`.
pub(crate) fn whole<T: TryFrom<u64>>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        u64::from_str(text)
            .ok()
            .filter(|value| (least..=most).contains(value))
            .and_then(|value| T::try_from(value).ok())
            .ok_or_else(|| format!("is not a whole number from {least} to {most}"))
    }
}

/// A setting on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given<T> {
    /// `auto`: it is chosen from the scene.
    Auto,
    /// This number.
    Number(T),
}

impl<T: Copy> Given<T> {
    /// The number given for the setting; else `own`.
    pub(crate) fn number_or(given: Option<Self>, own: T) -> T {
        match given {
            Some(Self::Number(number)) => number,
            Some(Self::Auto) | None => own,
        }
    }

    /// Whether the setting is to be chosen; if nothing is given, `own`.
    pub(crate) fn is_chosen(given: Option<&Self>, own: bool) -> bool {
        given.map_or(own, |given| matches!(given, Self::Auto))
    }
}

/// Parses `auto`, or a number by `parse`.
pub(crate) fn or_auto<T>(
    parse: impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<Given<T>, String> + Clone + Send + Sync + 'static {
    move |text| if text == "auto" { Ok(Given::Auto) } else { parse(text).map(Given::Number) }
}

/// Parses counts from 1 to `most` of things that take `bytes` each. If a count is too large, the message says how much
/// memory it would need.
pub(crate) fn amount(
    most: u32,
    bytes: u64,
) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    let parse = whole::<u32>(1, most.into());
    move |text| {
        parse(text).map_err(|problem| match u64::from_str(text) {
            Ok(value) if value > 0 => {
                let gibibytes = value as f64 * bytes as f64 / f64::from(1 << 30);
                format!("{problem}; so many would need {gibibytes:.1} GiB")
            }
            _ => problem,
        })
    }
}

/// Parses numbers from `least` to `most`.
pub(crate) fn number(
    least: f32,
    most: f32,
) -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    move |text| {
        f32::from_str(text)
            .ok()
            .filter(|value| (least..=most).contains(value))
            .ok_or_else(|| format!("is not a number from {} to {}", short(least), short(most)))
    }
}

/// Parses 0, or numbers from `least` to `most`.
pub(crate) fn number_or_zero(
    [least, most]: [f32; 2],
) -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    let parse = number(least, most);
    move |text| match f32::from_str(text) {
        // Without the sign of -0.
        Ok(0.0) => Ok(0.0),
        _ => parse(text).map_err(|problem| format!("{problem}, or 0")),
    }
}

/// Formats `value`, with an exponent if that is shorter.
fn short(value: f32) -> String {
    let (plain, exponential) = (value.to_string(), format!("{value:e}"));
    if exponential.len() < plain.len() { exponential } else { plain }
}

/// Parses a time, in seconds if it has no unit.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    let seconds = || f64::from_str(text).ok().and_then(from_seconds);
    duration(text)
        .or_else(seconds)
        .ok_or_else(|| "is not a time above 0 and below a century, such as 90s, 10m or 2h".into())
}

/// Parses a time or a number of iterations.
pub(crate) fn every(text: &str) -> Result<Every, String> {
    let iterations = || whole::<u32>(1, MAX_ITERATIONS.into())(text).ok().map(Every::Iterations);
    let either = duration(text).map(Every::Time).or_else(iterations);
    either.ok_or_else(|| "is neither a time such as 30s or 5m nor a number of iterations".into())
}

fn duration(text: &str) -> Option<Duration> {
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic())?;
    let (value, unit) = text.split_at(unit_at);
    let seconds = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        "d" => 86400.0,
        _ => return None,
    };
    from_seconds(f64::from_str(value).ok()? * seconds)
}

/// A time above 0 and of less than a century.
fn from_seconds(seconds: f64) -> Option<Duration> {
    const MOST: f64 = 3.2e9;
    let is_short = (0.0..=MOST).contains(&seconds);
    is_short.then(|| Duration::from_secs_f64(seconds)).filter(|time| !time.is_zero())
}

/// Parses a memory size. Units are powers of 1024.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (value, unit) = text.split_at(unit_at);
    let unit = match unit.to_ascii_lowercase().trim_end_matches('b').trim_end_matches('i') {
        "" => Some(0),
        "k" => Some(10),
        "m" => Some(20),
        "g" => Some(30),
        "t" => Some(40),
        _ => None,
    };
    let size = unit.and_then(|shift| Some(f64::from_str(value).ok()? * f64::from(2).powi(shift)));
    size.filter(|size| *size >= 1.0 && *size < 2f64.powi(60))
        .map(|size| size as u64)
        .ok_or_else(|| "is not a size such as 500M or 4G".into())
}

/// Parses finite numbers above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = f64::from_str(text).ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "is not a number above 0".into())
}

/// Parses the bound of a metric: any finite number from 0.
pub(crate) fn bound(text: &str) -> Result<f64, String> {
    f64::from_str(text)
        .ok()
        .filter(|value| value.is_finite() && *value >= 0.0)
        .ok_or_else(|| "is not a number of at least 0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_keep_to_their_range() {
        let parse = whole::<u32>(1, 10);
        assert_eq!(parse("1"), Ok(1));
        assert_eq!(parse("10"), Ok(10));
        for text in ["0", "11", "-1", "1.0", "1e0", "", " 1", "NaN", "inf", "0x1", "99999999999999999999"] {
            assert_eq!(parse(text), Err("is not a whole number from 1 to 10".into()), "{text:?}");
        }
    }

    #[test]
    fn whole_numbers_reach_the_last_seed() {
        assert_eq!(whole::<u64>(0, u64::MAX)("18446744073709551615"), Ok(u64::MAX));
    }

    #[test]
    fn what_is_too_much_is_told_with_its_memory() {
        let parse = amount(1 << 20, 128);
        assert_eq!(parse("1048576"), Ok(1 << 20));
        let problem = "is not a whole number from 1 to 1048576";
        assert_eq!(parse("1099511627776"), Err(format!("{problem}; so many would need 131072.0 GiB")));
        for text in ["0", "-1", "1e6", ""] {
            assert_eq!(parse(text), Err(problem.into()), "{text:?}");
        }
    }

    #[test]
    fn numbers_keep_to_their_range() {
        let parse = number(1e-15, 1e15);
        assert_eq!(parse("0.5"), Ok(0.5));
        assert_eq!(parse("2e3"), Ok(2000.0));
        for text in ["0", "-1", "1e-16", "1e16", "NaN", "inf", "-inf", "", "2cm"] {
            assert_eq!(parse(text), Err("is not a number from 1e-15 to 1e15".into()), "{text:?}");
        }
        assert_eq!(number(-100.0, 100.0)("-1.5"), Ok(-1.5));
        assert_eq!(number(-100.0, 100.0)("x"), Err("is not a number from -100 to 100".into()));
    }

    #[test]
    fn times_have_units() {
        for (text, seconds) in [
            ("90s", 90.0),
            ("10m", 600.0),
            ("10min", 600.0),
            ("1.5h", 5400.0),
            ("250ms", 0.25),
            ("2d", 172_800.0),
        ] {
            assert_eq!(time(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
            assert_eq!(every(text), Ok(Every::Time(Duration::from_secs_f64(seconds))), "{text}");
        }
        for (text, seconds) in [("90", 90.0), ("0.5", 0.5), ("1e2", 100.0)] {
            assert_eq!(time(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for text in ["", "0", "-1", "NaN", "inf", "90 ", "90ss"] {
            assert!(time(text).is_err(), "{text}");
        }
        for text in ["", "s", "0s", "-1s", "1e-30s", "1e30s", "NaNs", "infs", "1 s", "1w", "1s1"] {
            assert!(time(text).is_err(), "{text}");
        }
        assert_eq!(every("12"), Ok(Every::Iterations(12)));
        for text in ["", "0", "-3", "1.5", "x"] {
            assert!(every(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_binary() {
        for (text, size) in [("1", 1), ("4096", 4096), ("1K", 1 << 10), ("1.5MiB", 3 << 19), ("4G", 1 << 32)]
        {
            assert_eq!(bytes(text), Ok(size), "{text}");
        }
        // In any case, with what follows the letter or without it.
        for (text, size) in
            [("500m", 500 << 20), ("8kib", 8 << 10), ("2Tb", 2 << 40), ("3gB", 3 << 30), ("7b", 7)]
        {
            assert_eq!(bytes(text), Ok(size), "{text}");
        }
        for text in ["", "0", "-1", "M", "1X", "NaN", "1e30G", "0.1", "1 M"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    /// Zero is no number of the range and yet right; with a minus sign it is the same number, and recorded as such.
    #[test]
    fn zero_stands_beside_a_range_and_has_no_sign() {
        let parse = number_or_zero([1e-3, 1e3]);
        for text in ["0", "-0", "0.0", "-0e5"] {
            assert_eq!(parse(text).map(f32::to_bits), Ok(0), "{text}");
        }
        assert_eq!((parse("0.001"), parse("1000")), (Ok(1e-3), Ok(1e3)));
        for text in ["5e-4", "-1", "1001", "NaN", "x", ""] {
            assert_eq!(parse(text), Err("is not a number from 1e-3 to 1e3, or 0".into()), "{text:?}");
        }
    }

    #[test]
    fn bounds_are_finite_and_not_negative() {
        assert_eq!(bound("0"), Ok(0.0));
        assert_eq!(bound("1e-3"), Ok(1e-3));
        for text in ["-0.1", "NaN", "inf", "x", ""] {
            assert!(bound(text).is_err(), "{text:?}");
        }
    }

    #[test]
    fn what_is_positive_is_finite_and_above_0() {
        assert_eq!((positive("0.05"), positive("1e-300")), (Ok(0.05), Ok(1e-300)));
        for text in ["0", "-0.1", "NaN", "inf", "-inf", "x", ""] {
            assert_eq!(positive(text), Err("is not a number above 0".into()), "{text:?}");
        }
    }

    #[test]
    fn what_is_given_stands_before_what_the_scene_has() {
        let parse = or_auto(whole::<u32>(1, 9));
        assert_eq!((parse("auto"), parse("9")), (Ok(Given::Auto), Ok(Given::Number(9))));
        assert_eq!(parse("10"), Err("is not a whole number from 1 to 9".into()));
        let number = |given| Given::number_or(given, 7);
        assert_eq!([number(None), number(Some(Given::Auto)), number(Some(Given::Number(2)))], [7, 7, 2]);
        let is_chosen = |given: Option<Given<u32>>, own| Given::is_chosen(given.as_ref(), own);
        assert!(is_chosen(None, true) && is_chosen(Some(Given::Auto), false));
        assert!(!is_chosen(None, false) && !is_chosen(Some(Given::Number(2)), true));
    }

    #[test]
    fn times_and_sizes_end_where_they_are_told_to() {
        assert!(time("3.2e9").is_ok() && time("3.3e9").is_err() && time("1e-9").is_ok());
        assert_eq!((bytes("1.9"), bytes("0.99").is_err()), (Ok(1), true));
        assert_eq!(bytes("1048575T"), Ok(1_048_575 << 40));
        assert!(bytes("1048576T").is_err());
        assert_eq!(every("1073741824").is_ok(), MAX_ITERATIONS >= 1_073_741_824);
    }
}
