//! `lead_error` and `periodic_lead_error`: what a second measurement of position says of the first.
//!
//! The difference of the two is fitted by a smooth curve over the travel, Legendre polynomials to the eighth, and by sines of a period that
//! is looked for, beside what it does with direction (backlash), effort (compliance), velocity and acceleration (delay) and time
//! (warming). It acts in the position and not in the effort, so it is no term of a hypothesis. Passes are held out in turn, and for a
//! sine stretches of the travel, too.

mod held_out;
mod lead;
mod legendre;
mod periodic;
mod samples;
#[cfg(test)]
mod tests;
mod words;

use super::signals::Signals;
use held_out::{HeldOut, Sums};
use preslide_fit::recording::{Extra, Recording};
use preslide_fit::statistics::Estimate;
use samples::{BESIDE, COLUMNS, DIRECTION, EFFORT, HIDING, Samples};

pub use held_out::Taken;
pub use lead::Lead;
pub use periodic::Periodic;

/// Correlation from which a further column measures this position: what slips or lags more is another coordinate.
const POSITION: f64 = 0.99;
/// Where both are in the same unit and their ratio is within this share of one, its deviation from one is the lead's; otherwise
/// there is a transmission between them whose exact ratio nobody said.
const SAME: f64 = 0.02;
/// Groups of passes that are held out in turn, and the fewest passes.
const GROUPS: usize = 12;
const FEWEST: usize = 6;
/// Standard errors, over groups of passes, from which something is stated: with six groups the chance is below one in a hundred.
const CERTAIN: f64 = 4.0;
/// Share of the difference that a curve must take of what is held out.
const MATERIAL: f64 = 0.05;

/// What a second position says.
pub struct SecondPosition {
    /// Its column.
    pub column: String,
    /// The second position over the first, where a transmission or an unknown unit lies between them and there is no slope.
    pub ratio: Option<f64>,
    /// Passes between reversals that were compared.
    pub passes: usize,
    /// Second less first, smooth over the travel; `None` where there is none.
    pub lead: Option<Lead>,
    /// Second less first, periodic over the travel, the largest first; empty where there is nothing of the kind.
    pub periodic: Vec<Periodic>,
    /// How far the second stays behind at a reversal (m or rad), where certain and apart from a delay.
    pub lost_motion: Option<Estimate>,
    /// How far it stays behind the effort (m or rad per unit of effort), where certain.
    pub compliance: Option<Estimate>,
    /// RMS of what is left on passes held out (m or rad).
    pub left: f64,
}

/// What each further column says that measures this position, too.
pub fn of(recording: &Recording) -> Vec<SecondPosition> {
    let measures = |e: &Extra| {
        let factor = e.position_factor(recording.kind);
        Some((
            e.name.clone(),
            brought(&e.values, &recording.position, factor)?,
        ))
    };
    let found: Vec<_> = recording.extra.iter().filter_map(measures).collect();
    if found.is_empty() {
        return Vec::new();
    }
    // A turn that is not seen makes backlash look like something of the velocity: the rows' own turns are for friction, which needs longer ones.
    let s = Signals::of(recording).with_every_turn();
    let all = found.into_iter();
    all.filter_map(|(name, (values, ratio))| compared(name, &values, ratio, &recording.effort, &s))
        .collect()
}

/// A column in the unit of the position, and its ratio to it where that had to be fitted; `None` where it measures something else, or
/// is the same measurement once more.
fn brought(
    values: &[f64],
    position: &[f64],
    factor: Option<f64>,
) -> Option<(Vec<f64>, Option<f64>)> {
    let n = position.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (mx, my) = (mean(position), mean(values));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in position.iter().zip(values) {
        let (x, y) = (x - mx, y - my);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    if xy * xy < POSITION * POSITION * xx * yy || xx <= 0.0 {
        return None;
    }
    let fitted = xy / xx;
    let known = factor.map(|f| f * fitted.signum());
    let known = known.filter(|k| (fitted * k - 1.0).abs() < SAME);
    let scale = known.unwrap_or(1.0 / fitted);
    let values: Vec<f64> = values.iter().map(|y| scale * (y - my) + mx).collect();
    // The same counts, written twice, differ by no more than their steps; a motion in steps has none that small.
    let count = count(position).min(count(&values));
    let furthest = position.iter().zip(&values);
    let furthest = furthest.map(|(x, y)| (y - x).abs()).fold(0.0, f64::max);
    (furthest > count).then_some((values, known.is_none().then_some(fitted)))
}

fn compared(
    column: String,
    second: &[f64],
    ratio: Option<f64>,
    effort: &[f64],
    s: &Signals,
) -> Option<SecondPosition> {
    let mut samples = Samples::of(second, effort, s);
    if samples.passes < FEWEST {
        return None;
    }
    let groups = samples.passes.min(GROUPS);
    let finest = smallest_step(&s.x).max(smallest_step(second));
    let periodic = periodic::take_out(&mut samples, groups, finest);
    let sums = Sums::of_passes(&samples, groups);
    // A fitted ratio leaves no slope.
    let plain: Vec<usize> = (0..BESIDE + usize::from(ratio.is_some())).collect();
    let every: Vec<usize> = (0..COLUMNS).collect();
    let (without, with) = (HeldOut::of(&sums, &plain)?, HeldOut::of(&sums, &every)?);
    let taken = with.better_than(&without);
    let lead = taken.is_stated().then(|| Lead {
        share: taken.share,
        z: taken.z,
        ..Lead::of(&with, &samples, ratio.is_none())
    });
    let (told, columns) = if lead.is_some() {
        (&with, every)
    } else {
        (&without, plain)
    };
    // Effort and direction can be separated if velocity and acceleration add nothing to them.
    let seen: Vec<usize> = columns
        .into_iter()
        .filter(|c| !HIDING.contains(c))
        .collect();
    let seen = HeldOut::of(&sums, &seen)?;
    let alone = told.better_than(&seen).share < MATERIAL;
    let certain = |column, unit| alone.then(|| seen.certain(column, unit)).flatten();
    Some(SecondPosition {
        column,
        ratio,
        passes: samples.passes,
        lost_motion: certain(DIRECTION, -2.0 * samples.travel),
        compliance: certain(EFFORT, -samples.travel / samples.most_effort),
        left: samples.travel * told.left(),
        lead,
        periodic,
    })
}

/// The least that two samples differ by: one count, where a position is counted, wherever it was moved to. Less than a part in 10⁷ of the
/// travel is how it was written.
fn count(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let travel = sorted
        .last()
        .zip(sorted.first())
        .map_or(0.0, |(l, f)| l - f);
    smallest_step(&sorted).max(1e-7 * travel)
}

/// The smallest step between samples that is none of zero: one count, where a position is counted.
fn smallest_step(position: &[f64]) -> f64 {
    let steps = position.windows(2).map(|p| (p[1] - p[0]).abs());
    steps.filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min)
}
