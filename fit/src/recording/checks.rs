//! Named warnings about the motion and the effort, and the sign of the effort.

use super::segments::Strokes;
use super::{EffortRole, Warning, balance};
use crate::report::figures::quantity;
use crate::statistics::bounds;
use std::ops::Range;

/// A handful of strokes at a dozen samples each: below this, fits with ten parameters are guesses.
pub(super) const FEW_SAMPLES: usize = 200;
/// Code of the warning of fewer.
pub(super) const TOO_SHORT: &str = "too-short";
/// Reversals below which memory of the motion cannot show.
const FEW_REVERSALS: usize = 2;
/// A range of this many equal extreme samples in a row is a limit, not a peak …
const CLIPPED_RUN: usize = 5;
/// … where such ranges make up this share of the recording.
const CLIPPED_SHARE: f64 = 0.001;
/// Net work over closed motion, relative to the work exchanged, beyond which its sign is certain.
/// Real recordings reach 0.5 to 0.97 in magnitude.
const CERTAIN_WORK: f64 = 0.1;
/// Share of all the work exchanged that must be of runs which tell, before the sign is decided by them.
const TOLD_WORK: f64 = 0.3;
/// Positions that close a motion agree within this share of the travel.
const CLOSED: f64 = 0.05;

/// Warns of motion that cannot show friction's memory.
pub(super) fn motion(strokes: &[Strokes], samples: usize, unit: &str, warnings: &mut Vec<Warning>) {
    if samples < FEW_SAMPLES {
        warnings.push(warning!(
            TOO_SHORT,
            "{samples} samples; under {FEW_SAMPLES} few fits are certain"
        ));
    }
    let travel = strokes.iter().map(|s| s.travel).fold(0.0, f64::max);
    let quantum = strokes.iter().map(|s| s.quantum).fold(0.0, f64::max);
    let reversals: usize = strokes.iter().map(|s| s.reversals.len()).sum();
    if travel <= 2.0 * quantum {
        warnings.push(warning!(
            "no-motion",
            "the position covers {} in all, no more than two steps of its encoder",
            quantity(travel, unit)
        ));
    } else if reversals == 0
        && !(strokes.iter().any(|s| s.net < 0.0) && strokes.iter().any(|s| s.net > 0.0))
    {
        warnings.push(warning!(
            "one-way-motion",
            "no reversal in {} of travel: friction cannot be told from a constant load, and \
                 pre-sliding memory does not show",
            quantity(travel, unit)
        ));
    } else if reversals < FEW_REVERSALS {
        warnings.push(warning!(
            "few-reversals",
            "{reversals} reversals; pre-sliding memory shows from two on"
        ));
    }
}

/// Warns where the effort stays at its extreme value, as a saturated sensor or amplifier does.
pub(super) fn clipping(effort: &[f64], unit: &str, warnings: &mut Vec<Warning>) {
    let (low, high) = bounds(effort);
    if low >= high {
        warnings.push(warning!(
            "constant-effort",
            "the effort is {low} {unit} throughout"
        ));
        return;
    }
    for limit in [low, high] {
        let (mut clipped, mut run) = (0, 0);
        for value in effort.iter().copied().chain([f64::NAN]) {
            if value == limit {
                run += 1;
            } else {
                if run >= CLIPPED_RUN {
                    clipped += run;
                }
                run = 0;
            }
        }
        let share = clipped as f64 / effort.len() as f64;
        if clipped > 0 && share >= CLIPPED_SHARE {
            warnings.push(warning!(
                "clipping",
                "{clipped} samples ({:.1} %) stay at the extreme {limit} {unit}: the sensor may be saturated",
                100.0 * share
            ));
        }
    }
}

/// Work against closed motion: `(net, exchanged)` (J for force and torque), the effort's mean
/// taken off because a nearly closed path multiplies any offset by what is left open.
fn closed_work(x: &[f64], effort: &[f64], strokes: &Strokes) -> Option<(f64, f64)> {
    let first = *strokes.reversals.first()?;
    // Kinetic energy is zero at reversals: inertia does no work between them.
    let last = *strokes.reversals.iter().rev().find(|&&last| {
        last > first
            && x.get(first)
                .zip(x.get(last))
                .is_some_and(|(a, b)| (a - b).abs() <= CLOSED * strokes.travel)
    })?;
    Some(work_over(x, effort, first..last + 1))
}

/// Net work over a range of samples and the work exchanged, the effort's mean taken off.
fn work_over(x: &[f64], effort: &[f64], range: Range<usize>) -> (f64, f64) {
    let (Some(x), Some(effort)) = (x.get(range.clone()), effort.get(range)) else {
        return (0.0, 0.0);
    };
    let mean = effort.iter().sum::<f64>() / effort.len().max(1) as f64;
    let steps = x.windows(2).zip(effort.windows(2));
    steps
        .map(|(x, f)| (0.5 * (f[0] + f[1]) - mean) * (x[1] - x[0]))
        .fold((0.0, 0.0), |(net, all), work| {
            (net + work, all + work.abs())
        })
}

/// Code of the warning that the effort was turned.
pub(super) const FLIPPED: &str = "effort-sign-flipped";

/// Net work that friction takes, and the work exchanged: over each run whose motion closes, and of the others by the balance of energy. Zero
/// where both together tell of too little of all the work, which a short stroke must not speak for.
fn work(x: &[f64], effort: &[f64], strokes: &[Strokes]) -> (f64, f64) {
    let exchanged = |s: &Strokes| work_over(x, effort, s.run.clone()).1;
    let told = strokes
        .iter()
        .filter_map(|s| {
            let closed = closed_work(x, effort, s);
            let most = closed.filter(|c| c.1 >= TOLD_WORK * exchanged(s));
            most.or_else(|| balance::friction(x, effort, s))
        })
        .fold((0.0, 0.0), |(n, e), (net, exchanged)| {
            (n + net, e + exchanged)
        });
    let all: f64 = strokes.iter().map(exchanged).sum();
    if told.1 >= TOLD_WORK * all {
        told
    } else {
        (0.0, 0.0)
    }
}

/// Whether motion and effort say by themselves which sign the effort has.
pub(super) fn tells_sign(x: &[f64], effort: &[f64], strokes: &[Strokes]) -> bool {
    let (net, exchanged) = work(x, effort, strokes);
    net.abs() > CERTAIN_WORK * exchanged
}

/// Turns the effort into the model's convention: positive where it drives motion in +x, so that
/// the net work over closed motion, which is what friction dissipates, is positive. Without
/// `--sign` a recording of the opposite convention is flipped, with a warning.
pub(super) fn sign(
    x: &[f64],
    effort: &mut [f64],
    strokes: &[Strokes],
    role: EffortRole,
    asked: Option<f64>,
    warnings: &mut Vec<Warning>,
) {
    if let Some(sign) = asked {
        effort.iter_mut().for_each(|f| *f *= sign);
    }
    let (net, exchanged) = work(x, effort, strokes);
    let opposed = net < -CERTAIN_WORK * exchanged;
    if !opposed {
        return;
    }
    let found = format!(
        "friction would give back {1:.0} % of the {0}'s work, which it never does",
        role.name(),
        -100.0 * net / exchanged
    );
    if asked.is_some() {
        warnings.push(warning!(
            "negative-work",
            "{found}; --sign was given, so it stays"
        ));
    } else {
        effort.iter_mut().for_each(|f| *f = -*f);
        warnings.push(warning!(
            FLIPPED,
            "{found}: its sign opposes the model's, so it was multiplied by -1; --sign -1 says so and silences this, --sign 1 forbids it"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::super::segments;
    use super::*;

    fn codes(warnings: &[Warning]) -> Vec<&str> {
        warnings.iter().map(|w| w.code).collect()
    }

    /// The effort of a force as [`sign`] leaves it, and what it says of that.
    fn signed(
        x: &[f64],
        effort: &[f64],
        strokes: &[Strokes],
        asked: Option<f64>,
    ) -> (Vec<f64>, String) {
        let (mut effort, mut warnings) = (effort.to_vec(), Vec::new());
        let role = EffortRole::Force;
        sign(x, &mut effort, strokes, role, asked, &mut warnings);
        (effort, codes(&warnings).join(","))
    }

    /// Three sine cycles with Coulomb friction, inertia and an offset.
    fn cycles() -> (Vec<f64>, Vec<f64>) {
        let phase = |i: usize| i as f64 * 0.01;
        let x = (0..1885).map(|i| phase(i).sin()).collect();
        let f = (0..1885)
            .map(|i| phase(i).cos().signum() - 5.0 * phase(i).sin() + 2.0)
            .collect();
        (x, f)
    }

    #[test]
    fn an_opposed_sign_is_flipped_unless_a_sign_is_given() {
        let (x, f) = cycles();
        let strokes = [segments::strokes(&x, 0..x.len())];
        let run = |factor: f64, asked: Option<f64>| {
            let effort: Vec<f64> = f.iter().map(|f| factor * f).collect();
            let (effort, said) = signed(&x, &effort, &strokes, asked);
            (effort == f, said)
        };
        assert_eq!(run(1.0, None), (true, String::new()));
        assert_eq!(run(-1.0, None), (true, "effort-sign-flipped".into()));
        assert_eq!(run(-1.0, Some(-1.0)), (true, String::new()));
        assert_eq!(run(-1.0, Some(1.0)), (false, "negative-work".into()));
        assert_eq!(run(1.0, Some(-1.0)), (false, "negative-work".into()));
    }

    /// A long run that does not close, and beside it a short one that closes on a spring's lag, against the rest.
    #[test]
    fn a_short_stroke_does_not_speak_for_all_of_the_work() {
        let (long, short) = (6000, 600);
        let at = |i: usize| i as f64 * 0.001;
        // Six strokes of which none ends where another did.
        let far = |t: f64| 5.0 * t + (1.0 + t) * (3.0 * t).sin();
        let near = |t: f64| 0.02 * (21.0 * t).sin();
        let x: Vec<f64> = (0..long)
            .map(|i| far(at(i)))
            .chain((0..short).map(|i| near(at(i))))
            .collect();
        let force = |i: usize| {
            let before = if i == 0 || i == long { x[i] } else { x[i - 1] };
            let friction = (x[i] - before).signum();
            if i < long { friction } else { -friction }
        };
        let f: Vec<f64> = (0..long + short).map(force).collect();
        let strokes = [0..long, long..long + short].map(|run| segments::strokes(&x, run));
        assert_eq!(signed(&x, &f, &strokes, None), (f.clone(), String::new()));
        // Alone, it decides.
        assert_eq!(signed(&x, &f, &strokes[1..], None).1, "effort-sign-flipped");
    }

    #[test]
    fn a_spring_has_no_sign_to_find() {
        let (x, _) = cycles();
        let strokes = [segments::strokes(&x, 0..x.len())];
        let effort: Vec<f64> = x.iter().map(|x| -3.0 * x).collect();
        assert_eq!(signed(&x, &effort, &strokes, None).1, "");
    }

    #[test]
    fn motion_and_clipping_are_named_with_figures() {
        let check = |x: &[f64]| {
            let mut warnings = Vec::new();
            motion(
                &[segments::strokes(x, 0..x.len())],
                x.len(),
                "m",
                &mut warnings,
            );
            codes(&warnings).join(",")
        };
        let ramp: Vec<f64> = (0..500).map(f64::from).collect();
        assert_eq!(check(&ramp), "one-way-motion");
        assert_eq!(check(&ramp[..100]), "too-short,one-way-motion");
        assert_eq!(check(&[1.0; 500]), "no-motion");
        let back: Vec<f64> = (0..500)
            .map(|i| f64::from(250 - (i - 250i32).abs()))
            .collect();
        assert_eq!(check(&back), "few-reversals");
        assert_eq!(check(&cycles().0), "");

        let (_, f) = cycles();
        let limited: Vec<f64> = f.iter().map(|f| f.min(5.0)).collect();
        let mut warnings = Vec::new();
        clipping(&f, "N", &mut warnings);
        assert!(warnings.is_empty(), "{warnings:?}");
        clipping(&limited, "N", &mut warnings);
        assert_eq!(codes(&warnings), ["clipping"]);
        assert!(
            warnings[0].message.contains("extreme 5 N"),
            "{}",
            warnings[0].message
        );
    }
}
