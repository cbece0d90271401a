//! An axis that sticks while the effort on it rises, and then slips: a ramp of force until it breaks away, or a loop that hunts about a place.
//!
//! Of every slip that follows a rest the effort at its start is the breakaway level, and the work along its path, over the path, the kinetic
//! one: the axis rests before and after, so that inertia takes nothing of it.

use crate::recording::Recording;
use crate::report::figures::{quantity, within};
use crate::statistics::{Estimate, quantile};
use serde::Serialize;
use std::ops::Range;

/// Half of the window (s) over which a motion is looked at: shorter than a slip, longer than what a loop does to one count of the encoder.
const WINDOW_S: f64 = 0.01;
/// Share of the fastest motion below which an axis rests, and of the travel that a slip covers at least, both without the share [`RARE`] of the
/// samples at their ends: how the axis got to where it hunts is soon over, and may be thirty times as far as a slip.
const SLOW: f64 = 0.02;
const SHORT: f64 = 0.03;
const RARE: f64 = 0.02;
/// Quantile of the steps that is a count of the encoder, and counts that are no motion.
const COUNT: f64 = 0.02;
const COUNTS: f64 = 1.5;
/// Fewest slips for a level, and their share of all slips: with fewer it is a start like any other.
const FEWEST: usize = 5;
const MOST_OF_ALL: f64 = 0.5;
/// Share of hunting's slips that go against the one before, and that nobody paused before.
const TURNS: f64 = 0.8;
/// Sections of a rest. The effort stands still in one where it changes by this share of the mean over all; of a pause there are more than so
/// many. Who ramps a force by hand takes it off first; a loop that hunts never does.
const SECTIONS: usize = 20;
const STANDS: f64 = 0.2;
const PAUSE: usize = 3;

/// Levels in one direction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Levels {
    /// Mean effort (N or N·m) at which the axis breaks away, with the interval of the mean.
    #[serde(rename = "breakaway_N")]
    pub breakaway: Estimate,
    /// Standard deviation of the single ones.
    #[serde(rename = "spread_N")]
    pub spread: f64,
    /// Mean effort along the slips.
    #[serde(rename = "kinetic_N")]
    pub kinetic: Estimate,
    /// Slips.
    pub count: usize,
}

/// What the slips of a recording show.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StickSlip {
    /// In +x; `None` below two slips.
    pub forward: Option<Levels>,
    /// In −x, of negative sign.
    pub backward: Option<Levels>,
    /// Median time (s) from slip to slip.
    pub period_s: f64,
    /// Median path (m or rad) of a slip.
    #[serde(rename = "path_m")]
    pub path: f64,
    /// It goes to and fro by itself: every rest is a ramp from its beginning, every slip goes against the one before.
    pub hunts: bool,
}

/// One slip from rest.
struct Slip {
    at_s: f64,
    direction: f64,
    breakaway: f64,
    kinetic: f64,
    path: f64,
    at_once: bool,
}

impl StickSlip {
    /// Finds the slips; `None` where the axis is moved rather than breaks away.
    pub fn of(recording: &Recording) -> Option<Self> {
        let half = ((WINDOW_S / recording.sample_time_s()).round() as usize).max(2);
        let scene = Scene::of(recording, half)?;
        let runs: Vec<(usize, Range<usize>)> = recording
            .pieces
            .iter()
            .flat_map(|p| scene.runs(p))
            .collect();
        let told: Vec<Option<Slip>> = runs
            .iter()
            .map(|(rest, run)| scene.slip(*rest, run))
            .collect();
        let slips: Vec<&Slip> = told.iter().flatten().collect();
        let count = slips.len() as f64;
        if slips.len() < FEWEST || count < MOST_OF_ALL * runs.len() as f64 {
            return None;
        }
        let pairs = || slips.windows(2);
        let turns = pairs().filter(|p| p[0].direction != p[1].direction).count() as f64;
        let at_once = slips.iter().filter(|s| s.at_once).count() as f64;
        let mut periods: Vec<f64> = pairs().map(|p| p[1].at_s - p[0].at_s).collect();
        let mut paths: Vec<f64> = slips.iter().map(|s| s.path).collect();
        let levels = |direction: f64| Levels::of(slips.iter().filter(|s| s.direction == direction));
        Some(Self {
            forward: levels(1.0),
            backward: levels(-1.0),
            period_s: quantile(&mut periods, 0.5)?,
            path: quantile(&mut paths, 0.5)?,
            hunts: turns >= TURNS * (count - 1.0) && at_once >= TURNS * count,
        })
    }

    /// Names and values, as a fit's parameters.
    pub fn parameters(&self) -> Vec<(&'static str, Estimate)> {
        let names = [
            ["breakaway_forward", "kinetic_forward"],
            ["breakaway_backward", "kinetic_backward"],
        ];
        let sides = names.into_iter().zip([self.forward, self.backward]);
        let told = sides.filter_map(|([breakaway, kinetic], side)| {
            side.map(|s| [(breakaway, s.breakaway), (kinetic, s.kinetic)])
        });
        told.flatten().collect()
    }

    /// Why a recording of this shows nothing else.
    pub fn refusal(&self, recording: &Recording) -> String {
        format!(
            "{}: {}; record a commanded motion for anything else",
            recording.name,
            self.words(recording)
        )
    }

    /// For a person: levels, their spread, and what they mean.
    pub fn words(&self, recording: &Recording) -> String {
        let unit = recording.effort_unit();
        let side = |levels: &Option<Levels>| {
            levels.map(|l| {
                format!(
                    "{} ({} slips, kinetic {})",
                    within(l.breakaway.value, l.spread, unit),
                    l.count,
                    quantity(l.kinetic.value, unit)
                )
            })
        };
        let sides: Vec<String> = [&self.forward, &self.backward]
            .into_iter()
            .filter_map(side)
            .collect();
        let levels = format!(
            "it breaks away at {}, spread of the single ones",
            sides.join(" and ")
        );
        if self.hunts {
            format!(
                "the axis hunts: it sticks while the effort rises and slips {} one way or the other every {:.2} s, with nothing from outside; {levels}. To stop it, freeze or leak the integral within a slip of the target, or feed the friction forward",
                quantity(self.path, recording.kind.unit()),
                self.period_s
            )
        } else {
            format!("the effort rises on the resting axis until it slips: {levels}")
        }
    }
}

impl Levels {
    fn of<'a>(slips: impl Iterator<Item = &'a &'a Slip>) -> Option<Self> {
        let (breakaway, kinetic): (Vec<f64>, Vec<f64>) =
            slips.map(|s| (s.breakaway, s.kinetic)).unzip();
        let count = breakaway.len();
        if count < 2 {
            return None;
        }
        let told = |values: &[f64]| {
            let n = count as f64;
            let mean = values.iter().sum::<f64>() / n;
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let spread = (squares / (n - 1.0)).sqrt();
            (Estimate::new(mean, Some(spread / n.sqrt()), count), spread)
        };
        let (breakaway, spread) = told(&breakaway);
        Some(Self {
            breakaway,
            spread,
            kinetic: told(&kinetic).0,
            count,
        })
    }
}

/// A recording, and what counts as rest in it.
struct Scene<'a> {
    recording: &'a Recording,
    /// Samples of half a window.
    half: usize,
    /// Displacement over a window up to which the axis rests.
    still: f64,
    count: f64,
    travel: f64,
    /// Means over a window.
    position: Vec<f64>,
    effort: Vec<f64>,
}

impl<'a> Scene<'a> {
    fn of(recording: &'a Recording, half: usize) -> Option<Self> {
        let x = &recording.position;
        let mut steps: Vec<f64> = x.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
        steps.retain(|s| *s > 0.0);
        let count = quantile(&mut steps, COUNT)?;
        let windows = recording
            .pieces
            .iter()
            .flat_map(|p| x[p.clone()].windows(2 * half + 1));
        let mut speeds: Vec<f64> = windows.map(|w| (w[2 * half] - w[0]).abs()).collect();
        let fastest = quantile(&mut speeds, 1.0 - RARE)?;
        let mut places = x.clone();
        let [low, high] = [0.5 * RARE, 1.0 - 0.5 * RARE].map(|q| quantile(&mut places, q));
        let means = |values: &[f64]| {
            let pieces = recording.pieces.iter();
            pieces
                .flat_map(|p| means(&values[p.clone()], half))
                .collect()
        };
        Some(Self {
            recording,
            half,
            still: (COUNTS * count).max(SLOW * fastest),
            count,
            travel: high? - low?,
            position: means(x),
            effort: means(&recording.effort),
        })
    }

    /// Stretches of motion that go somewhere, each with the sample at which the motion before it ended.
    fn runs(&self, piece: &Range<usize>) -> Vec<(usize, Range<usize>)> {
        let x = &self.recording.position;
        let half = self.half;
        let moves = |i: usize| {
            i >= piece.start + half
                && i + half < piece.end
                && (x[i + half] - x[i - half]).abs() > self.still
        };
        let (mut runs, mut rest, mut i) = (Vec::new(), piece.start, piece.start);
        while i < piece.end {
            let start = i;
            while i < piece.end && moves(i) {
                i += 1;
            }
            if i > start && (x[i - 1] - x[start]).abs() >= SHORT * self.travel {
                runs.push((rest, start..i));
                rest = i;
            }
            i = i.max(start + 1);
        }
        runs
    }

    /// A run as a slip, if the axis rested before it and the effort took longer to rise than the axis to slip.
    fn slip(&self, rest: usize, run: &Range<usize>) -> Option<Slip> {
        let (x, half) = (&self.recording.position, self.half);
        let direction = (x[run.end - 1] - x[run.start]).signum();
        let onset = run
            .clone()
            .find(|i| (x[*i] - x[run.start]).abs() > COUNTS * self.count)?;
        if run.start < rest + 4 * half {
            return None;
        }
        let ramp = &self.effort[rest..onset];
        let before =
            ramp[..ramp.len().div_ceil(20)].iter().sum::<f64>() / ramp.len().div_ceil(20) as f64;
        let rise = |f: f64| direction * (f - before);
        let last = rise(*ramp.last()?);
        let lasting = ramp
            .iter()
            .rev()
            .take_while(|f| rise(**f) >= 0.5 * last)
            .count();
        if last <= 0.0 || lasting < run.end - onset {
            return None;
        }
        let highest = ramp[ramp.len() - lasting..]
            .iter()
            .map(|f| direction * f)
            .fold(f64::NEG_INFINITY, f64::max);
        let sections: Vec<f64> = ramp
            .chunks(ramp.len().div_ceil(SECTIONS))
            .map(|s| s.iter().sum::<f64>() / s.len() as f64)
            .collect();
        let stands = |p: &&[f64]| (p[1] - p[0]).abs() < STANDS * last / SECTIONS as f64;
        let standing = sections.windows(2).filter(stands).count();
        let along = onset.saturating_sub(half).max(rest)..(run.end + half).min(x.len() - 1);
        let path = self.position[along.end - 1] - self.position[along.start];
        let work: f64 = along
            .clone()
            .skip(1)
            .map(|i| {
                0.5 * (self.recording.effort[i] + self.recording.effort[i - 1])
                    * (self.position[i] - self.position[i - 1])
            })
            .sum();
        Some(Slip {
            at_s: self.recording.t_s[onset],
            direction,
            breakaway: direction * highest,
            kinetic: work / path,
            path: path.abs(),
            at_once: standing <= PAUSE,
        })
    }
}

/// Means over windows of `2·half + 1` values, shorter at the ends.
fn means(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for v in values {
        sums.push(sums[sums.len() - 1] + v);
    }
    let mean = |i: usize| {
        let (from, to) = (i.saturating_sub(half), (i + half + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::StickSlip;
    use crate::recording::{LoadOptions, Recording, load_csv};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::fmt::Write as _;

    const BREAKAWAY: f64 = 0.8;
    const KINETIC: f64 = 0.5;

    /// 24 slips of 20 mm within 60 ms to and fro, each after a ramp of 1.2 s, or a pause of 1 s at zero and then the ramp; encoder of 0.1 mm.
    fn made(pause: bool, seed: u64) -> Recording {
        made_after(0, pause, seed)
    }

    /// The same after a move of 1 m in so many samples.
    fn made_after(samples: u32, pause: bool, seed: u64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut text, mut sample) = ("t_s,x_m,force_N\n".to_owned(), 0);
        let mut row = |x: f64, f: f64, noise: f64| {
            writeln!(
                text,
                "{:.3},{:.4},{:.5}",
                f64::from(sample) * 1e-3,
                x,
                f + noise
            )
            .expect("memory");
            sample += 1;
        };
        let mut noise = ChaCha8Rng::seed_from_u64(seed + 1000);
        let mut noise = || noise.random_range(-0.01..0.01);
        for i in 0..samples {
            row(1.0 - f64::from(i) / f64::from(samples), -KINETIC, noise());
        }
        for slip in 0..24 {
            let (direction, from) = if slip % 2 == 0 {
                (1.0, 0.0)
            } else {
                (-1.0, 0.02)
            };
            let level = direction * BREAKAWAY * (1.0 + 0.04 * rng.random_range(-1.7..1.7));
            let start = if pause { 0.0 } else { -0.4 * direction };
            for _ in 0..if pause { 1000 } else { 0 } {
                row(from, 0.0, 0.0);
            }
            for i in 0..1200 {
                row(
                    from,
                    start + (level - start) * f64::from(i) / 1200.0,
                    noise(),
                );
            }
            // The driving force falls as the axis turns faster, and rises as it slows down: its mean along the path is friction's.
            for i in 0..60 {
                let part = std::f64::consts::PI * f64::from(i) / 60.0;
                let x = from + direction * 0.01 * (1.0 - part.cos());
                row(x, direction * (KINETIC + 0.2 * part.cos()), noise());
            }
        }
        load_csv(text.as_bytes(), "made.csv", &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn ramps_show_breakaway_its_spread_and_kinetic_friction() {
        for seed in [3, 4, 5] {
            let found = StickSlip::of(&made(true, seed)).expect("slips");
            assert!(!found.hunts, "seed {seed}");
            for (side, sign) in [(found.forward, 1.0), (found.backward, -1.0)] {
                let side = side.expect("slips");
                println!("seed {seed}: {side:?}");
                assert_eq!(side.count, 12);
                assert!((sign * side.breakaway.value / BREAKAWAY - 1.0).abs() < 0.04);
                assert!(
                    (0.01..0.07).contains(&(side.spread / BREAKAWAY)),
                    "{}",
                    side.spread
                );
                assert!(
                    (sign * side.kinetic.value / KINETIC - 1.0).abs() < 0.06,
                    "{}",
                    side.kinetic.value
                );
            }
        }
    }

    #[test]
    fn a_loop_that_never_pauses_hunts() {
        let recording = made(false, 6);
        let found = StickSlip::of(&recording).expect("slips");
        assert!(found.hunts);
        assert!((found.period_s - 1.26).abs() < 0.02, "{}", found.period_s);
        assert!(found.words(&recording).contains("hunts"));
    }

    #[test]
    fn an_axis_hunts_however_far_it_moved_before() {
        let found = StickSlip::of(&made_after(300, false, 6)).expect("slips");
        let far = found.forward.expect("slips").breakaway.value;
        println!("breakaway {far} N of {BREAKAWAY}");
        assert!(found.hunts && (far / BREAKAWAY - 1.0).abs() < 0.04);
    }

    #[test]
    fn a_commanded_motion_is_not_stick_slip() {
        let mut text = "t_s,x_m,force_N\n".to_owned();
        for i in 0..20_000 {
            let t = f64::from(i) * 1e-3;
            // A trapezoid of 0.5 s and a rest of 0.5 s, to and fro.
            let phase = (t % 2.0 / 0.5) as u32;
            let part = (t % 0.5) / 0.5;
            let (x, f) = match phase {
                0 => (0.02 * part, 0.5),
                1 => (0.02, 0.3),
                2 => (0.02 * (1.0 - part), -0.5),
                _ => (0.0, -0.3),
            };
            writeln!(text, "{t:.3},{x:.5},{f:.3}").expect("memory");
        }
        let recording = load_csv(text.as_bytes(), "moved.csv", &LoadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        assert!(StickSlip::of(&recording).is_none());
    }
}
