//! A recording in one line, and what of it no machine has.

use super::columns::Plan;
use super::known::Slot;
use super::units::SECOND;
use super::words;
use super::{MotionKind, Recording, Warning};
use crate::report::display_unit;
use crate::report::figures::quantity;
use crate::statistics::{bounds, quantile};

/// Largest values that a positioning axis, a joint or a spindle has: beyond them the unit is more likely wrong than the machine is such.
struct Most {
    /// Travel (m or rad), speed (m/s or rad/s).
    travel: f64,
    speed: f64,
}

/// A gantry of 100 m; 20 m/s is above linear motors' 10.
const LINEAR: Most = Most {
    travel: 100.0,
    speed: 20.0,
};
/// A spindle of 60,000 turns a minute, for an hour.
const ROTARY: Most = Most {
    travel: 2.3e7,
    speed: 6.3e3,
};
/// Least travel: below it no encoder of 2026 counts (m or rad).
const LEAST_TRAVEL: f64 = 1e-10;
/// Most effort by unit: a press's 10 MN, a slewing ring's 1 MN·m, an inverter's 2 kV; of currents those of 100 A, which few positioning axes
/// have, where a drive that logs mA shows hundreds.
const MOST_EFFORT: [(&str, f64); 4] = [("N", 1e7), ("Nm", 1e6), ("A", 100.0), ("V", 2e3)];
/// Sample times that a recording of friction has (s): the slowest servos log ten a second.
const LEAST_SAMPLE_TIME: f64 = 1e-7;
const LONGEST_SAMPLE_TIME: f64 = 0.5;
/// The longest one of a scan.
const LONGEST_OF_SCAN: f64 = 100.0;
/// Steps in its travel that a scan has at most, which stops at each place to be measured; what is recorded in motion has hundreds in a stroke.
const MOST_PLACES: f64 = 100.0;

/// Three digits with the prefix that suits them.
fn short(value: f64, unit: &str) -> String {
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

/// The column that a role is read from, and the mapping of so many times what it is.
fn rescaled(plan: &Plan, slot: Slot, scale: f64) -> Option<(String, String)> {
    let of = |slot| plan.sources.iter().find(|s| s.known.slot == slot);
    let source = of(slot).or(of(Slot::Step).filter(|_| slot == Slot::Time))?;
    let name = |&i: &usize| plan.names.get(i).map_or("", String::as_str);
    let term = |factor: f64, columns: &[usize]| {
        let columns: Vec<&str> = columns.iter().map(name).collect();
        format!("{}*{}", scale * factor, columns.join("*"))
    };
    let terms: Vec<String> = source
        .terms
        .iter()
        .map(|t| term(t.factor, &t.columns))
        .collect();
    let first = source.columns().next()?;
    let map = format!("{}={}", source.known.name, terms.join("+"));
    Some((name(&first).to_owned(), map))
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
    fn top_speed(&self) -> f64 {
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
            said.push(
                match low < 0.0 && high > 0.0 && -low > 0.5 * high && high > -0.5 * low {
                    true => format!("{name} ±{}", short(high.max(-low), unit)),
                    false => format!("{name} {} to {}", short(low, unit), short(high, unit)),
                },
            );
        }
        format!("{}   {}", self.name, said.join(" · "))
    }

    /// Whether the time is in seconds by its name, and from one sample to the next it goes a good part of the travel.
    fn is_scan(&self, plan: &Plan, travel: f64) -> bool {
        let is_named = plan.sources.iter().any(|s| {
            let name = s.columns().next().and_then(|i| plan.names.get(i));
            s.is_bare_time() && name.is_some_and(|n| words::quantity(n).unit == Some(SECOND))
        });
        let steps = self.position.windows(2).map(|p| (p[1] - p[0]).abs());
        let usual = quantile(&mut steps.collect::<Vec<_>>(), 0.5);
        is_named && usual.is_some_and(|step| MOST_PLACES * step > travel)
    }

    /// Values that no machine has, with what would put them right.
    pub(super) fn implausible(&self, plan: &Plan) -> Option<Warning> {
        let (most, milli) = match self.kind {
            MotionKind::Linear => (LINEAR, "mm"),
            MotionKind::Rotary => (ROTARY, "mrad"),
        };
        let unit = self.position_unit();
        let (mut asked, mut maps) = (Vec::new(), Vec::new());
        let mut ask = |found: String, slot: Slot, unit: &str, scale: f64| {
            let Some((column, map)) = rescaled(plan, slot, scale) else {
                return;
            };
            asked.push(format!(
                "{found}: if `{column}` is in {unit}, give --map '{map}'"
            ));
            maps.push(map);
        };
        let travel = range(&self.position).map_or(0.0, |(low, high)| high - low);
        let speed = self.top_speed();
        let position = match self.position_integrated {
            true => Slot::Velocity,
            false => Slot::Position,
        };
        let step = self.sample_time_s;
        let longest = match self.is_scan(plan, travel) {
            true => LONGEST_OF_SCAN,
            false => LONGEST_SAMPLE_TIME,
        };
        if !(LEAST_SAMPLE_TIME..=longest).contains(&step) {
            let units = [("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)];
            let of_step = units.iter().find(|u| u.1 * step <= LONGEST_SAMPLE_TIME);
            let (unit, scale) = of_step.unwrap_or(&units[0]);
            ask(format!("a sample every {step} s"), Slot::Time, unit, *scale);
        }
        if travel > most.travel {
            let found = format!("a travel of {travel:.4} {unit}");
            ask(found, position, milli, 1e-3);
        } else if speed > most.speed {
            let found = format!("a speed of {speed:.4} {unit}/s");
            ask(found, position, milli, 1e-3);
        }
        let effort = range(&self.effort).map_or(0.0, |(low, high)| high.max(-low));
        let of_unit = MOST_EFFORT.iter().find(|m| m.0 == self.effort_unit());
        if let Some((unit, most)) = of_unit
            && effort > *most
        {
            let found = format!("a {} of {effort:.4} {unit}", self.role.name());
            ask(found, Slot::Effort, &format!("m{unit}"), 1e-3);
        }
        if travel > 0.0 && travel < LEAST_TRAVEL {
            asked.push(format!(
                "a travel of {}: if the position is in counts, give --map 'NAME=LENGTH_OF_A_COUNT*COLUMN'",
                quantity(travel, unit)
            ));
        }
        (!asked.is_empty()).then(|| Warning {
            maps,
            ..warning!(
                "implausible",
                "hardly any machine has {}",
                asked.join("; nor ")
            )
        })
    }
}
