//! A recording in one line.

use super::Recording;
use crate::report::display_unit;
use crate::statistics::{bounds, quantile};

/// Three digits with the prefix that suits them.
pub(super) fn short(value: f64, unit: &str) -> String {
    let shown = display_unit(unit, value);
    let value = value * shown.factor;
    let decimals = match value.abs() {
        v if v >= 100.0 || v == 0.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$} {}", shown.unit)
}

fn range(values: &[f64]) -> Option<(f64, f64)> {
    Some(bounds(values)).filter(|(low, high)| low <= high)
}

/// What the values go in steps of: what an encoder's count is, or the file's last digit; `None` where most steps are no multiples of any.
pub(super) fn count(values: &[f64]) -> Option<f64> {
    /// Steps that tell, and how near to whole numbers of counts nearly all of them are.
    const FEWEST: usize = 20;
    const NEAR: f64 = 0.1;
    const ALMOST_ALL: f64 = 0.99;
    /// Longer steps show how far the count is off, not whether there is one.
    const LONGEST: f64 = 20.0;
    let steps = values.windows(2).map(|p| (p[1] - p[0]).abs());
    let steps: Vec<f64> = steps.filter(|s| *s > 0.0).collect();
    let most = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    // What adding up leaves is no step.
    let real = steps.iter().copied().filter(|s| *s > 1e-12 * most);
    let least = real.fold(f64::INFINITY, f64::min);
    let short: Vec<f64> = steps.into_iter().filter(|s| *s < LONGEST * least).collect();
    let near = short.iter().filter(|s| {
        let counts = *s / least;
        (counts - counts.round()).abs() < NEAR
    });
    if short.len() < FEWEST || (near.count() as f64) < ALMOST_ALL * short.len() as f64 {
        return None;
    }
    let whole = |s: &f64| (s / least).round();
    let both: f64 = short.iter().map(|s| s * whole(s)).sum();
    let count = both / short.iter().map(|s| whole(s).powi(2)).sum::<f64>();
    // To the digits that the steps support.
    format!("{count:.6e}").parse().ok()
}

/// A number of counts for people: 812, 49.2 k, 4.9 M.
fn many(counts: f64) -> String {
    match counts {
        n if n >= 1e6 => format!("{:.1} M", n / 1e6),
        n if n >= 1e4 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

impl Recording {
    /// Seconds recorded, gaps left out.
    fn seconds(&self) -> f64 {
        let of = |p: &std::ops::Range<usize>| self.t_s[p.end - 1] - self.t_s[p.start];
        let pieces = self.pieces.iter().filter(|p| !p.is_empty());
        pieces.map(of).sum::<f64>() + self.sample_time_s
    }

    /// The speed (m/s or rad/s) that a hundredth of a percent of the samples exceed, over five samples where none is recorded: encoder counts are no
    /// speed.
    pub(super) fn top_speed(&self) -> f64 {
        const OVER: usize = 5;
        let mut speeds: Vec<f64> = match &self.velocity {
            Some(velocity) => velocity.iter().map(|v| v.abs()).collect(),
            None => self
                .pieces
                .iter()
                .filter_map(|p| Some((self.position.get(p.clone())?, &self.t_s[p.clone()])))
                .flat_map(|(x, t)| {
                    let over = OVER.min(x.len().saturating_sub(1)).max(1);
                    (over..x.len())
                        .map(move |i| ((x[i] - x[i - over]) / (t[i] - t[i - over])).abs())
                })
                .collect(),
        };
        quantile(&mut speeds, 0.9999).unwrap_or(0.0)
    }

    /// Length, rate, travel, top speed and effort in one line: what a user knows of the machine, and sees at once where a unit is wrong.
    pub fn in_one_line(&self) -> String {
        let mut said = vec![format!(
            "{} at {}",
            short(self.seconds(), "s"),
            short(1.0 / self.sample_time_s, "Hz")
        )];
        let unit = self.position_unit();
        if let Some((low, high)) = range(&self.position) {
            let counts = self.count.map(|count| (high - low) / count);
            said.push(format!(
                "travel {}{}",
                short(high - low, unit),
                counts.map_or_else(String::new, |n| format!(" ({} counts)", many(n)))
            ));
            said.push(format!(
                "up to {}",
                short(self.top_speed(), &format!("{unit}/s"))
            ));
        }
        if let Some((low, high)) = range(&self.effort) {
            let (name, unit) = (self.role.name(), self.effort_unit());
            // Of a raw effort, once.
            let name = name.strip_prefix(unit).map_or(name, str::trim);
            said.push(
                match low < 0.0 && high > 0.0 && -low > 0.5 * high && high > -0.5 * low {
                    true => format!("{name} ±{}", short(high.max(-low), unit)),
                    false => format!("{name} {} to {}", short(low, unit), short(high, unit)),
                },
            );
        }
        format!("{}   {}", self.name, said.join(" · "))
    }
}
