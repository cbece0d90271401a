//! The motion that would show what this recording cannot, or decide what it leaves open.

use super::effect::{self, Part};
use super::hysteresis;
use super::verdict::Diagnosis;
use preslide_fit::statistics::{bounds, quantile_between_ranks, spread};
use std::fmt::Write as _;

/// Sample time of the profile (s).
const STEP_S: f64 = 1e-3;
/// Repeats, and longest time of one part of a repeat (s): of a motion by itself, with folds to hold out, and of one beside a recording that there
/// is already.
const ALONE: (usize, f64) = (4, 40.0);
const ONCE_MORE: (usize, f64) = (2, 20.0);
/// Quantile of the accelerations of the recording that the motion may take.
const STEEP: f64 = 0.98;
/// Effects that an ordinary recording shows little of, and a motion made for them well.
const OF_THEIR_OWN: [&str; 4] = ["dwell_aging", "backlash", "drive_compliance", "run_in"];
/// Probability from which a suspicion is worth an experiment.
const LEAST: f64 = 0.05;

/// A motion from rest to rest.
struct Profile {
    x: Vec<f64>,
    /// Largest acceleration (m/s² or rad/s²).
    steepest: f64,
    /// Longest that one part may take (s).
    longest: f64,
}

impl Profile {
    fn here(&self) -> f64 {
        self.x.last().copied().unwrap_or(0.0)
    }

    /// Goes to `target` with the least jerk, `speed` at most.
    fn go(&mut self, target: f64, speed: f64) {
        let start = self.here();
        let way = (target - start).abs();
        // Peaks of velocity and acceleration of the polynomial.
        let duration = (1.875 * way / speed).max((5.7735 * way / self.steepest).sqrt());
        let count = (duration / STEP_S).ceil() as usize;
        for i in 1..=count {
            let u = i as f64 / count as f64;
            let way = u * u * u * (10.0 + u * (6.0 * u - 15.0));
            self.x.push(start + (target - start) * way);
        }
    }

    fn rest(&mut self, seconds: f64) {
        let here = self.here();
        self.x
            .extend(std::iter::repeat_n(here, (seconds / STEP_S) as usize));
    }

    fn part(&mut self, part: Part, (low, high): (f64, f64), (slow, fast): (f64, f64)) {
        let (travel, middle) = (high - low, 0.5 * (low + high));
        // A stroke that takes no longer than it should.
        let longest = self.longest;
        let stroke = |speed: f64, most: f64| most.min(speed * 0.2 * longest);
        match part {
            Part::Nested => {
                self.go(middle, fast);
                for size in spread(travel / 5000.0, travel / 50.0, 5).iter().rev() {
                    let from = self.here();
                    for end in [from + size, from, from + size, from] {
                        self.go(end, size / 0.5);
                    }
                }
            }
            Part::Speeds => {
                self.go(middle, fast);
                for speed in spread(0.1 * slow, fast, 7) {
                    self.go(middle + stroke(speed, 0.4 * travel), speed);
                    self.go(middle, speed);
                }
            }
            Part::Rests => {
                for (i, seconds) in [0.1, 1.0, 10.0, 0.3, 3.0].into_iter().enumerate() {
                    self.rest(seconds);
                    let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                    self.go(self.here() + side * stroke(slow, travel / 50.0), slow);
                }
            }
            Part::Passes => {
                let speed = (3.0 * slow).max(travel / (0.4 * longest));
                for end in [low, high, low] {
                    self.go(end, speed.min(fast));
                }
            }
            Part::Again => {
                for strokes in [12, 4] {
                    for _ in 0..strokes {
                        self.go(middle + stroke(fast, 0.4 * travel), fast);
                        self.go(middle, fast);
                    }
                    self.rest(0.25 * self.longest);
                }
            }
            Part::Fast => {
                for end in [low, high, low, high, middle] {
                    self.go(end, fast);
                }
            }
        }
    }
}

/// The parts that show an effect.
fn parts_of(id: &str) -> &'static [Part] {
    match effect::by_id(id) {
        Some(effect) => effect.card().shown_by,
        None if id == hysteresis::ID => &[Part::Nested],
        None => &[],
    }
}

/// Its name for people.
fn name_of(id: &str) -> &str {
    effect::by_id(id).map_or(hysteresis::NAME, |effect| effect.name())
}

/// Whether it is the id of something that an experiment may be for.
pub fn may_be_for(id: &str) -> bool {
    id == hysteresis::ID || effect::by_id(id).is_some()
}

/// A motion that would decide something, in the coordinate of the recording.
pub struct Experiment {
    /// Effects that it is for, by id.
    pub about: Vec<&'static str>,
    /// Positions (m or rad), a millisecond apart, from the middle of the travel.
    pub x: Vec<f64>,
    /// Where each of its repeats ends.
    ends: Vec<usize>,
    rotary: bool,
}

impl Experiment {
    /// The motion for some effects, within the travel, the speeds and the accelerations of the recording.
    fn about(
        mut about: Vec<&'static str>,
        found: &Diagnosis,
        (repeats, longest): (usize, f64),
    ) -> Self {
        about.sort_unstable();
        about.dedup();
        let mut parts: Vec<Part> = Vec::new();
        for part in about.iter().flat_map(|id| parts_of(id)) {
            if !parts.contains(part) {
                parts.push(*part);
            }
        }
        let s = &found.null.rows.s;
        let (low, high) = bounds(&s.x);
        let top = s.top_speed();
        let speeds = (s.speeds().0.min(0.1 * top), top);
        let steep: Vec<f64> = s.a.iter().map(|a| a.abs()).collect();
        let mut profile = Profile {
            x: vec![0.5 * (low + high)],
            steepest: quantile_between_ranks(&steep, STEEP).max(f64::MIN_POSITIVE),
            longest,
        };
        let mut ends = Vec::new();
        for _ in 0..repeats {
            profile.go(0.5 * (low + high), top);
            for &part in &parts {
                profile.part(part, (low, high), speeds);
            }
            ends.push(profile.x.len());
        }
        Self {
            about,
            x: profile.x,
            ends,
            rotary: s.rotary,
        }
    }

    /// For all that a diagnosis leaves open and all that its recording hides.
    pub fn for_all(found: &Diagnosis) -> Self {
        let open = found
            .effects
            .iter()
            .filter(|e| !e.confident || !e.ambiguous.is_empty())
            .flat_map(|e| std::iter::once(e.id()).chain(e.ambiguous.iter().map(|e| e.id())));
        let hidden = found
            .lacks
            .iter()
            .flat_map(|l| l.hides.iter().map(|e| e.id()));
        Self::about(open.chain(hidden).collect(), found, ALONE)
    }

    /// What would decide the most costly open doubt: of a name that is suspected, by what it would take off and how likely it is;
    /// then of what the recording hides; then, where nothing was found, of what only a kind of motion shows well that was not played. Whatever the same motion shows is
    /// asked along.
    pub fn next(found: &Diagnosis, asked: &[String]) -> Option<Self> {
        let stated: Vec<&str> = found.confident().map(|e| e.id()).collect();
        let is_open = |id: &&'static str| {
            let is_known = stated.contains(id) || asked.iter().any(|a| a == id);
            !parts_of(id).is_empty() && !is_known
        };
        let suspected = found.effects.iter().filter(|e| !e.confident && !e.in_fit);
        let mut suspected: Vec<(f64, &'static str)> = suspected
            .filter(|e| e.confidence >= LEAST)
            .map(|e| (e.confidence * (e.nmse_test[0] - e.nmse_test[1]), e.id()))
            .collect();
        suspected.sort_by(|a, b| b.0.total_cmp(&a.0));
        let hidden = found.lacks.iter();
        let hidden = hidden.flat_map(|lack| lack.hides.iter().map(|e| e.id()));
        let played: Vec<Part> = asked.iter().flat_map(|id| parts_of(id)).copied().collect();
        let of_another_kind = |id: &&'static str| {
            let own = parts_of(id);
            let is_new = !own.iter().all(|part| played.contains(part));
            found.missing().next().is_none() && OF_THEIR_OWN.contains(id) && is_new
        };
        let all = effect::ALL.iter().map(|effect| effect.id());
        let doubts = suspected.into_iter().map(|(_, id)| id).chain(hidden);
        let open: Vec<&'static str> = doubts
            .chain(all.filter(of_another_kind))
            .filter(is_open)
            .collect();
        let shows = parts_of(open.first()?);
        let is_shown = |id: &&'static str| parts_of(id).iter().all(|part| shows.contains(part));
        let about = open.iter().copied().filter(is_shown).collect();
        Some(Self::about(about, found, ONCE_MORE))
    }

    /// Duration (s).
    pub fn seconds(&self) -> f64 {
        self.x.len() as f64 * STEP_S
    }

    /// As a motion that `drive play` follows; `column` is its position's.
    pub fn csv(&self, column: &str) -> String {
        let mut text = format!("t_s,{column},repeat\n");
        for (i, x) in self.x.iter().enumerate() {
            let repeat = self.ends.partition_point(|end| *end <= i);
            // Writing to a string does not fail.
            let _ = writeln!(text, "{:.3},{x:.9},{repeat}", i as f64 * STEP_S);
        }
        text
    }

    /// In words, without a full stop.
    pub fn words(&self) -> String {
        format!(
            "{:.0} s of reference {} for {}",
            self.seconds(),
            if self.rotary { "q" } else { "x" },
            self.about
                .iter()
                .map(|id| name_of(id))
                .collect::<Vec<_>>()
                .join(", ")
        )
    }
}
