//! Time stamps that are written as a date or a time of day, in seconds from the day of the first.

use chrono::{Datelike, NaiveDate};

use super::Warning;
use super::names::Source;

/// Seconds of a day.
const DAY: f64 = 86_400.0;

/// Reads stamps one after the other.
#[derive(Debug, Default)]
pub(super) struct Clock {
    first_day: Option<i32>,
    last: Option<f64>,
    midnights: f64,
}

/// Of a day of twice twelve hours, and the hour that it begins with.
#[derive(Clone, Copy)]
enum Half {
    Morning = 0,
    Afternoon = 12,
}

impl Clock {
    /// Seconds of `2025-11-09T09:27:03.748Z`, `20251109T092703.748Z`, `2025-11-09 09:27:03+01:00`, `09:27:03.748` or `9:27:03.748 AM`; a time of day that falls by more than
    /// half a day has passed midnight.
    pub(super) fn seconds(&mut self, text: &str) -> Option<f64> {
        let (text, half) = half_of_day(text);
        let of_day = |time: &str| of_day(time, half);
        if let Some((date, time)) = text.split_once(['T', 't', ' ']) {
            let day = day(date)?;
            let (time, ahead) = zone(time)?;
            let days = day - *self.first_day.get_or_insert(day);
            return Some(f64::from(days) * DAY + of_day(time)? - ahead);
        }
        let seconds = of_day(text)?;
        if self.last.is_some_and(|last| last - seconds > 0.5 * DAY) {
            self.midnights += DAY;
        }
        self.last = Some(seconds);
        Some(self.midnights + seconds)
    }
}

/// In what stamps since 1970 count, by how large the first of them is.
#[derive(Debug, Default)]
pub(super) struct Since1970(Option<Option<f64>>);

impl Since1970 {
    /// The value of a source's column: in seconds, where it is a time without a unit that counts since 1970 in something else.
    pub(super) fn of(&mut self, source: &Source, value: f64) -> f64 {
        /// The years 2001 to 2286.
        const SECONDS: std::ops::Range<f64> = 1e9..1e10;
        if !source.is_bare_time() {
            return value;
        }
        let mut units = [1e-3, 1e-6, 1e-9].into_iter();
        let unit = self
            .0
            .get_or_insert_with(|| units.find(|unit| SECONDS.contains(&(unit * value))));
        value * unit.unwrap_or(1.0)
    }

    /// Says in what such stamps are taken.
    pub(super) fn said(&self) -> Option<Warning> {
        let unit = self.0.flatten()?;
        Some(warning!(
            "since-1970",
            "the time counts since 1970 in units of {unit:e} s: taken as that"
        ))
    }
}

/// A time without its `AM` or `PM`, and which.
fn half_of_day(text: &str) -> (&str, Option<Half>) {
    let text = text.trim_end();
    let marks = ["am", "pm", "a.m.", "p.m."];
    let mark = marks.iter().find_map(|mark| {
        let (before, end) = text.split_at_checked(text.len().checked_sub(mark.len())?)?;
        let half = match mark.starts_with('a') {
            true => Half::Morning,
            false => Half::Afternoon,
        };
        end.eq_ignore_ascii_case(mark)
            .then(|| (before.trim_end(), Some(half)))
    });
    mark.unwrap_or((text, None))
}

/// Days from a fixed one to a Gregorian `year-month-day`, `year/month/day`, `day.month.year`, or `month/day/year` where that is a date, and else
/// `day/month/year`.
fn day(date: &str) -> Option<i32> {
    if date.len() == 8 && date.bytes().all(|b| b.is_ascii_digit()) {
        let part = |at: std::ops::Range<usize>| date[at].parse().ok();
        let date = NaiveDate::from_ymd_opt(date[0..4].parse().ok()?, part(4..6)?, part(6..8)?);
        return date.map(|date| date.num_days_from_ce());
    }
    let mut parts = date
        .splitn(3, ['-', '/', '.'])
        .map(|p| p.parse::<i32>().ok());
    let (first, month, last) = (parts.next()??, parts.next()??, parts.next()??);
    let (year, month, day) = match (date.contains('.'), last > 31) {
        (true, _) => (last, month, first),
        (false, true) if first <= 12 => (last, first, month),
        (false, true) => (last, month, first),
        (false, false) => (first, month, last),
    };
    NaiveDate::from_ymd_opt(year, month.try_into().ok()?, day.try_into().ok()?)
        .map(|date| date.num_days_from_ce())
}

/// A time without its zone, and the seconds by which the zone is ahead of UTC.
fn zone(time: &str) -> Option<(&str, f64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0.0));
    }
    match time.rfind(['+', '-']) {
        None => Some((time, 0.0)),
        Some(at) => {
            let digits = time[at + 1..].replace(':', "");
            let minutes: f64 = digits
                .get(2..)
                .filter(|m| !m.is_empty())
                .map_or(Some(0.0), |m| m.parse().ok())?;
            let ahead = 3600.0 * digits.get(..2)?.parse::<f64>().ok()? + 60.0 * minutes;
            let sign = if time[at..].starts_with('-') {
                -1.0
            } else {
                1.0
            };
            Some((&time[..at], sign * ahead))
        }
    }
}

/// Seconds of `09:27:03.748` or `9:27:03,748`, of the whole day or of a half of it.
fn of_day(time: &str, half: Option<Half>) -> Option<f64> {
    // `092703.748`
    let digits = time.bytes().take_while(u8::is_ascii_digit).count();
    let compact = (digits == 6 && !time.contains(':'))
        .then(|| [&time[..2], &time[2..4], &time[4..]].join(":"));
    let mut parts = compact.as_deref().unwrap_or(time).split(':');
    let (hour, minute, second) = (parts.next()?, parts.next()?, parts.next()?);
    let whole = |text: &str, below: u32| text.trim().parse::<u32>().ok().filter(|n| *n < below);
    let seconds: f64 = second.replace(',', ".").parse().ok()?;
    let is_time = parts.next().is_none() && (0.0..61.0).contains(&seconds);
    let minute = whole(minute, 60)?;
    let hour = match half {
        None => whole(hour, 24)?,
        // It begins with the hour 12.
        Some(half) => whole(hour, 13).filter(|h| *h > 0)? % 12 + half as u32,
    };
    is_time.then(|| f64::from(3600 * hour + 60 * minute) + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_read_across_midnight_leap_days_and_zones() {
        for stamps in [
            ["2025-11-09T23:59:59.5Z", "2025-11-10T00:00:00.25Z"],
            ["2024-02-28 23:59:59.5", "2024-02-29 00:00:00,25"],
            ["2024-12-31T23:59:59.5Z", "2025-01-01T01:00:00.25+01:00"],
            ["2025-01-01T00:59:59.5+0100", "2024-12-31T19:00:00.25-05:00"],
            ["23:59:59.5", "0:00:00.25"],
            ["2024/02/28 23:59:59.5", "2024/02/29 00:00:00.25"],
            ["28.02.2024 23:59:59,5", "29.02.2024 00:00:00,25"],
            ["20240228T235959.5", "20240229T000000.25"],
            ["20240228T225959,5Z", "20240229T000000.25+0100"],
            ["11:59:59.5 PM", "12:00:00.25 AM"],
            ["11:59:59.5am", "12:00:00.25 p.m."],
            ["12:59:59.5 PM", "1:00:00.25 PM"],
            ["2/28/2024 11:59:59.5 PM", "2/29/2024 12:00:00.25 AM"],
            ["28/02/2024 23:59:59.5", "29/02/2024 00:00:00.25"],
        ] {
            let mut clock = Clock::default();
            let [a, b] = stamps.map(|s| clock.seconds(s).unwrap_or_else(|| panic!("{s}")));
            assert_eq!(b - a, 0.75, "{stamps:?}");
        }
        for text in [
            "",
            "12",
            "12:61:00",
            "25:00:00",
            "13:00:00 PM",
            "0:00:00 AM",
            "abc",
            "2025-13-01T00:00:00",
            "2025-02-29T00:00:00",
            "1:2:3:4",
            "20250229T000000",
            "20250228T240000",
            "20250228",
        ] {
            assert_eq!(Clock::default().seconds(text), None, "{text}");
        }
    }
}
