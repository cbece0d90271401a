//! A recording in one line, and what of it no machine has.

use super::{MotionKind, Recording, Warning};
use crate::report::display_unit;

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
/// Most effort by unit: a press's 10 MN, a slewing ring's 1 MN·m, a mill motor's 1 kA, an inverter's 2 kV.
const MOST_EFFORT: [(&str, f64); 4] = [("N", 1e7), ("Nm", 1e6), ("A", 1e3), ("V", 2e3)];
/// Sample times that a recording of friction has (s).
const SAMPLE_TIMES: std::ops::RangeInclusive<f64> = 1e-7..=1.0;

/// Three digits with the prefix that suits them.
fn short(value: f64, unit: &str) -> String {
    let shown = display_unit(unit, value);
    let value = value * shown.factor;
    let decimals = match value.abs() {
        v if v >= 100.0 || v == 0.0 => 0,
        v if v >= 10.0 => 1,
        _ => 2,
    };
    format!("{value:.decimals$} {}", shown.unit)
}

fn range(values: &[f64]) -> Option<(f64, f64)> {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    finite.fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
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
                    let pairs = x.iter().zip(x.iter().skip(over));
                    let times = t.iter().zip(t.iter().skip(over));
                    pairs
                        .zip(times)
                        .map(|((a, b), (s, e))| ((b - a) / (e - s)).abs())
                        .collect::<Vec<_>>()
                })
                .collect(),
        };
        crate::statistics::quantile(&mut speeds, 0.9999).unwrap_or(0.0)
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
            said.push(format!("travel {}", short(high - low, unit)));
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

    /// Values that no machine has, with what would put them right; `role` and kind are the columns'.
    pub fn implausible(&self) -> Option<Warning> {
        let (most, position, milli) = match self.kind {
            MotionKind::Linear => (LINEAR, "x_m", "mm"),
            MotionKind::Rotary => (ROTARY, "q_rad", "mrad"),
        };
        let unit = self.position_unit();
        let mut asked = Vec::new();
        let travel = range(&self.position).map_or(0.0, |(low, high)| high - low);
        let speed = self.top_speed();
        if !SAMPLE_TIMES.contains(&self.sample_time_s) {
            asked.push(format!(
                "a sample every {} s: if the time is in ms, give --map 't_s=0.001*COLUMN'",
                self.sample_time_s
            ));
        }
        if travel > most.travel {
            asked.push(format!(
                "a travel of {travel:.4} {unit}: if the position is in {milli}, give --map '{position}=0.001*COLUMN'"
            ));
        } else if travel > 0.0 && travel < LEAST_TRAVEL {
            asked.push(format!(
                "a travel of {travel:.3e} {unit}: if the position is in counts, give --map '{position}=LENGTH_OF_A_COUNT*COLUMN'"
            ));
        } else if speed > most.speed {
            asked.push(format!(
                "a speed of {speed:.4} {unit}/s: if the time is in ms, give --map 't_s=0.001*COLUMN'; if the position is in {milli}, --map '{position}=0.001*COLUMN'"
            ));
        }
        let effort = range(&self.effort).map_or(0.0, |(low, high)| high.max(-low));
        let of_unit = MOST_EFFORT.iter().find(|m| m.0 == self.effort_unit());
        if let Some((unit, most)) = of_unit
            && effort > *most
        {
            asked.push(format!(
                "a {} of {effort:.4} {unit}: if it is in m{unit}, give --map '{}_{unit}=0.001*COLUMN'",
                self.role.name(),
                self.role.name()
            ));
        }
        (!asked.is_empty()).then(|| {
            Warning::new(
                "implausible",
                format!("no machine has {}", asked.join("; nor ")),
            )
        })
    }
}
