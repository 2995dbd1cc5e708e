//! The line that shows progress: as much of it as fits on the terminal, and never more.

use std::time::Duration;

/// The bar is left out where fewer columns than these are free for it.
const SHORTEST_BAR: usize = 10;
const LONGEST_BAR: usize = 40;
/// A terminal of fewer columns has no room for a bar beside what matters more.
const NARROW: usize = 40;
/// A time that is farther away than this is a guess that helps nobody.
const FARTHEST: Duration = Duration::from_hours(24 * 365);

/// What is in progress.
#[derive(Clone, Debug, Default)]
pub(crate) struct Work {
    /// What is counted, in the plural; empty if nothing is.
    pub(crate) noun: &'static str,
    /// Steps done.
    pub(crate) done: u32,
    /// Steps of this session's beginning, from which a render may have been resumed.
    pub(crate) began_at: u32,
    /// Steps to do; `None` if something else will end the work.
    pub(crate) all: Option<u32>,
    /// The share of the current step that is done.
    pub(crate) within: f64,
    /// Time since the beginning.
    pub(crate) elapsed: Duration,
    /// How much of it went by before the first step.
    pub(crate) prepared: Duration,
    /// The time after which the work ends.
    pub(crate) limit: Option<Duration>,
    /// More to tell, the most important first.
    pub(crate) facts: Vec<String>,
}

impl Work {
    /// The same while it is being prepared, of which this share is done.
    pub(crate) fn preparing(self, share: f64) -> Self {
        let what = format!("preparing, {:.0} %", 100.0 * share);
        Self { noun: "", facts: vec![what], all: None, prepared: self.elapsed, ..self }
    }

    /// The line for a terminal of `columns` columns. It leaves the last column free, where some terminals would go on to
    /// the next line.
    pub(crate) fn line(&self, columns: usize) -> String {
        let room = columns.saturating_sub(1);
        let texts = self.texts();
        let share = self.share();
        // A bar is worth more than the last facts, but on a narrow terminal less than the time that is left.
        let bar_room = if share.is_some() && columns >= NARROW { SHORTEST_BAR + 1 } else { 0 };
        let fitting = |taken: usize| texts.iter().find(|text| columns_of(text) + taken <= room);
        let Some(text) = fitting(bar_room).or_else(|| fitting(0)) else {
            return texts.last().map_or(String::new(), |text| cut(text, room));
        };
        let free = room - columns_of(text);
        match share {
            Some(share) if free > SHORTEST_BAR => {
                format!("{} {text}", bar(share, (free - 1).min(LONGEST_BAR)))
            }
            _ => text.clone(),
        }
    }

    /// The line without a bar, from the whole of it to the least.
    fn texts(&self) -> Vec<String> {
        if self.noun.is_empty() {
            let (what, elapsed) = (self.facts.join("  "), clock(self.elapsed));
            return vec![format!("{what}  {elapsed}"), what];
        }
        let count = self.all.map_or(self.done.to_string(), |all| format!("{}/{all}", self.done));
        let counted = format!("{count} {}", self.noun);
        let elapsed = format!("{} elapsed", clock(self.elapsed));
        let left = self.left().map(|left| format!("{} left", clock(left)));
        let times: Vec<String> = [elapsed].into_iter().chain(left.clone()).collect();
        let last = left.unwrap_or_else(|| clock(self.elapsed));
        let mut texts = Vec::new();
        for facts in (0..=self.facts.len()).rev() {
            let facts = self.facts[..facts].iter().cloned();
            let parts: Vec<String> =
                [counted.clone()].into_iter().chain(facts).chain([times.join(", ")]).collect();
            texts.push(parts.join("  "));
        }
        texts.extend([format!("{counted}  {last}"), format!("{count}  {last}"), count]);
        texts
    }

    /// The share of the way that lies behind: to the last step or to the limit, whichever is nearer.
    fn share(&self) -> Option<f64> {
        let of_steps = self.all.map(|all| (f64::from(self.done) + self.within) / f64::from(all.max(1)));
        let of_time =
            self.limit.map(|limit| self.elapsed.as_secs_f64() / limit.as_secs_f64().max(f64::MIN_POSITIVE));
        let share = match (of_steps, of_time) {
            (Some(a), Some(b)) => a.max(b),
            (a, b) => a.or(b)?,
        };
        Some(share.clamp(0.0, 1.0))
    }

    /// The time until the end, by the steps so far or by the limit, whichever is sooner.
    fn left(&self) -> Option<Duration> {
        let behind = f64::from(self.done - self.began_at.min(self.done)) + self.within;
        let by_steps = self.all.and_then(|all| {
            let ahead = f64::from(all.saturating_sub(self.done)) - self.within;
            let stepping = self.elapsed.saturating_sub(self.prepared);
            // Before anything is done this is infinite or no number, which is no duration.
            let left = stepping.as_secs_f64() * ahead.max(0.0) / behind;
            Duration::try_from_secs_f64(left).ok().filter(|left| *left <= FARTHEST)
        });
        let by_limit = self.limit.map(|limit| limit.saturating_sub(self.elapsed));
        by_steps.into_iter().chain(by_limit).min()
    }
}

/// The most columns that `text` takes: letters of some scripts take two.
fn columns_of(text: &str) -> usize {
    text.chars().map(|c| if c.is_ascii() { 1 } else { 2 }).sum()
}

/// As much of `text` as fits into `columns` columns.
fn cut(text: &str, columns: usize) -> String {
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
    let end = ends.take_while(|&end| columns_of(&text[..end]) <= columns).last();
    text[..end.unwrap_or(0)].into()
}

/// A bar of `columns` columns.
fn bar(share: f64, columns: usize) -> String {
    let inner = columns - 2;
    let full = (share * inner as f64).floor() as usize;
    format!("[{}{}]", "#".repeat(full), ".".repeat(inner - full))
}

/// A time in few columns: `7s`, `3m 20s`, `2h 5m`, `3d 4h`.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0..60 => format!("{seconds}s"),
        60..3600 => format!("{}m {}s", seconds / 60, seconds % 60),
        3600..86400 => format!("{}h {}m", seconds / 3600, seconds % 3600 / 60),
        _ => format!("{}d {}h", seconds / 86400, seconds % 86400 / 3600),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn work() -> Work {
        Work {
            noun: "iterations",
            done: 3,
            all: Some(6),
            elapsed: seconds(6),
            facts: vec!["1.50M photons/s".into(), "mean radius 1.5000".into()],
            ..Work::default()
        }
    }

    #[test]
    fn all_is_told_where_there_is_room() {
        let line = work().line(100);
        let text = " 3/6 iterations  1.50M photons/s  mean radius 1.5000  6s elapsed, 6s left";
        assert!(line.ends_with(text), "{line}");
        assert!(line.starts_with("[##########") && line.chars().count() == 99, "{line}");
    }

    /// The way to the goal that is reached first, of steps or time.
    #[test]
    fn the_bar_is_that_of_the_nearer_goal() {
        let share = |done, seconds_of_limit: Option<u64>| {
            let limit = seconds_of_limit.map(seconds);
            Work { done, limit, ..work() }.share().unwrap()
        };
        assert_eq!([share(3, None), share(3, Some(8)), share(3, Some(24))], [0.5, 0.75, 0.5]);
        assert_eq!(share(6, Some(3)), 1.0);
    }

    #[test]
    fn a_line_fits_on_every_terminal_and_tells_the_most_important() {
        let long = Work { done: 1_000_000_000, all: Some(1 << 30), limit: Some(seconds(9999)), ..work() };
        for work in [work(), long, Work { all: None, ..work() }] {
            for columns in 0..200 {
                let line = work.line(columns);
                assert!(line.chars().count() < columns.max(1), "{columns}: {line}");
                assert!(columns < 12 || line.contains(&work.done.to_string()), "{columns}: {line}");
            }
        }
        assert_eq!(work().line(60), "[##########...........] 3/6 iterations  6s elapsed, 6s left");
        assert_eq!(work().line(40), "[######.......] 3/6 iterations  6s left");
        assert_eq!(work().line(39), "3/6 iterations  6s elapsed, 6s left");
        assert_eq!(work().line(20), "3/6  6s left");
        assert_eq!(work().line(4), "3/6");
    }

    #[test]
    fn a_time_limit_is_told_by_the_clock_and_not_by_iterations() {
        let work = Work { all: None, limit: Some(seconds(10)), facts: Vec::new(), done: 46, ..work() };
        let line = work.line(80);
        assert!(line.ends_with("46 iterations  6s elapsed, 4s left"), "{line}");
        assert!(
            line.starts_with(&format!("[{}", "#".repeat(22))) && !line.contains(&"#".repeat(24)),
            "{line}"
        );
        // The goal that is nearer counts.
        let both = |all| Work { all: Some(all), ..work.clone() };
        assert!(both(1000).line(80).ends_with("46/1000 iterations  6s elapsed, 4s left"));
        assert!(both(48).line(80).ends_with("46/48 iterations  6s elapsed, 0s left"));
        let late = Work { elapsed: seconds(11), ..work };
        assert!(late.line(80).ends_with("11s elapsed, 0s left"));
    }

    #[test]
    fn the_current_iteration_counts() {
        let begun = Work { done: 0, all: Some(2), within: 0.5, ..work() };
        assert!(begun.line(60).ends_with("6s elapsed, 18s left"), "{}", begun.line(60));
        assert!(begun.line(60).starts_with("[###"), "{}", begun.line(60));
        let nothing = Work { within: 0.0, ..begun };
        assert!(nothing.line(60).ends_with("6s elapsed"), "{}", nothing.line(60));
        let instant = Work { elapsed: Duration::ZERO, ..nothing };
        assert!(instant.line(60).ends_with("0s elapsed"), "{}", instant.line(60));
    }

    /// What came before the first iteration will not come again.
    #[test]
    fn preparation_says_nothing_of_the_time_that_is_left() {
        let prepared = Work { prepared: seconds(4), done: 1, all: Some(4), facts: Vec::new(), ..work() };
        assert!(prepared.line(60).ends_with("6s elapsed, 6s left"), "{}", prepared.line(60));
        let preparing = work().preparing(0.375);
        assert_eq!(preparing.line(60), "preparing, 38 %  6s");
        let limited = Work { limit: Some(seconds(10)), ..work() }.preparing(0.375).line(60);
        assert!(limited.starts_with("[####") && limited.ends_with("] preparing, 38 %  6s"), "{limited}");
    }

    /// First radii are chosen in the first iteration, when the render's own clock is running.
    #[test]
    fn a_time_limit_counts_what_is_prepared() {
        let limited = Work { prepared: seconds(4), all: None, limit: Some(seconds(10)), ..work() };
        assert_eq!((limited.left(), limited.share()), (Some(seconds(4)), Some(0.6)));
    }

    /// The iterations of an earlier session took none of this one's time.
    #[test]
    fn a_resumed_render_is_not_taken_for_a_fast_one() {
        let resumed = Work { done: 500, began_at: 499, all: Some(502), facts: Vec::new(), ..work() };
        assert!(resumed.line(60).ends_with("6s elapsed, 12s left"), "{}", resumed.line(60));
    }

    #[test]
    fn what_has_no_steps_is_named() {
        let waiting =
            Work { noun: "", facts: vec!["reading \u{4e16}\u{754c}.toml".into()], all: None, ..work() };
        assert_eq!(waiting.line(80), "reading \u{4e16}\u{754c}.toml  6s");
        assert_eq!(waiting.line(12), "reading \u{4e16}");
        assert_eq!(waiting.line(1), "");
    }

    #[test]
    fn times_are_short() {
        for (time, text) in [(0, "0s"), (59, "59s"), (200, "3m 20s"), (7500, "2h 5m"), (100_000, "1d 3h")] {
            assert_eq!(clock(seconds(time)), text);
        }
    }

    #[test]
    fn a_unit_begins_where_the_one_before_ends() {
        for (time, text) in
            [(60, "1m 0s"), (3599, "59m 59s"), (3600, "1h 0m"), (86_399, "23h 59m"), (86_400, "1d 0h")]
        {
            assert_eq!(clock(seconds(time)), text);
        }
    }

    #[test]
    fn a_bar_is_full_at_the_end_and_has_as_many_columns_as_it_is_given() {
        assert_eq!(
            [bar(0.0, 6), bar(0.5, 6), bar(0.99, 6), bar(1.0, 6)],
            ["[....]", "[##..]", "[###.]", "[####]"]
        );
        let done = Work { done: 9, all: Some(3), ..work() };
        assert_eq!((done.share(), done.left()), (Some(1.0), Some(Duration::ZERO)));
        // The meter may still be at the last step when that is counted.
        let last = Work { done: 6, within: 0.5, ..work() };
        assert_eq!((last.share(), last.left()), (Some(1.0), Some(Duration::ZERO)));
    }

    /// A guess of more than a year is none; a limit is not guessed.
    #[test]
    fn what_is_too_far_away_is_not_told() {
        let far = |days: u64| Work { done: 1, all: Some(2), elapsed: seconds(86_400 * days), ..work() };
        assert_eq!(far(365).left(), Some(FARTHEST));
        assert_eq!(far(366).left(), None);
        assert_eq!(
            Work { limit: Some(seconds(86_400 * 400)), ..far(366) }.left(),
            Some(seconds(86_400 * 34))
        );
    }

    #[test]
    fn columns_are_those_of_the_widest_script() {
        assert_eq!(["", "ab", "\u{4e16}b"].map(columns_of), [0, 2, 3]);
        assert_eq!(
            [0, 1, 2, 3, 4].map(|columns| cut("\u{4e16}bc", columns)),
            ["", "", "\u{4e16}", "\u{4e16}b", "\u{4e16}bc"]
        );
    }

    /// A bar has enough columns to tell something, and is there wherever there is room for it beside what matters more.
    #[test]
    fn bars_are_neither_too_short_nor_too_long() {
        let limited = Work { all: None, limit: Some(seconds(100)), ..work() };
        for work in
            [work(), limited, Work { noun: "", ..work() }, Work { done: 12_345, all: Some(99_999), ..work() }]
        {
            for columns in 0..200 {
                let line = work.line(columns);
                let bar = line.strip_prefix('[').and_then(|rest| rest.find(']')).map(|end| end + 2);
                assert!(
                    bar.is_none_or(|bar| (SHORTEST_BAR..=LONGEST_BAR).contains(&bar)),
                    "{columns}: {line}"
                );
                let is_free = columns < NARROW || work.noun.is_empty();
                assert!(bar.is_some() || is_free, "{columns}: {line}");
            }
        }
    }
}
