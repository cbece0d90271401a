//! The motion that would show what this recording cannot, or tell apart what it leaves open.

use super::effect::grid::spread;
use super::effect::{self, Part};
use super::hysteresis;
use super::signals::bounds;
use super::verdict::Diagnosis;
use crate::recording::Recording;
use std::fmt::Write as _;

/// Repeats of the motion: folds to hold out.
const REPEATS: usize = 4;
/// Sample time of the profile (s).
const STEP_S: f64 = 1e-3;
/// Longest that one part of a repeat may take (s).
const LONGEST_S: f64 = 40.0;

/// A motion from rest to rest.
struct Profile {
    x: Vec<f64>,
}

impl Profile {
    fn here(&self) -> f64 {
        self.x.last().copied().unwrap_or(0.0)
    }

    /// Goes to `target` with the least jerk, `speed` at most.
    fn go(&mut self, target: f64, speed: f64) {
        let start = self.here();
        let duration = 1.875 * (target - start).abs() / speed;
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
        let stroke = |speed: f64, most: f64| most.min(speed * 0.2 * LONGEST_S);
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
                let speed = (3.0 * slow).max(travel / (0.4 * LONGEST_S));
                for end in [low, high, low] {
                    self.go(end, speed.min(fast));
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
        Some(effect) => effect.shown_by(),
        None if id == hysteresis::ID => &[Part::Nested],
        None => &[],
    }
}

/// The motion as CSV, within the travel and the speeds of the recording, and what it is for.
pub fn profile(recording: &Recording, found: &Diagnosis) -> (String, String) {
    let open = found
        .effects
        .iter()
        .filter(|e| !e.confident || !e.ambiguous.is_empty())
        .flat_map(|e| std::iter::once(e.id()).chain(e.ambiguous.iter().map(|e| e.id())));
    let hidden = found.lacks.iter().flat_map(|l| l.hides.iter().copied());
    let ids: Vec<&str> = open.chain(hidden).collect();
    let mut parts: Vec<Part> = Vec::new();
    for part in ids.iter().flat_map(|id| parts_of(id)) {
        if !parts.contains(part) {
            parts.push(*part);
        }
    }
    let s = &found.ground.rows.s;
    let (low, high) = bounds(&s.x);
    let top = s.top_speed();
    let speeds = (s.speeds().0.min(0.1 * top), top);
    let mut profile = Profile {
        x: vec![0.5 * (low + high)],
    };
    let unit = if recording.position_unit() == "m" {
        ("x_ref_m", "x")
    } else {
        ("q_ref_rad", "q")
    };
    let mut text = format!("t_s,{},repeat\n", unit.0);
    let mut written = 0;
    for repeat in 0..REPEATS {
        profile.go(0.5 * (low + high), top);
        for &part in &parts {
            profile.part(part, (low, high), speeds);
        }
        for (i, x) in profile.x.iter().enumerate().skip(written) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{:.3},{x:.9},{repeat}", i as f64 * STEP_S);
        }
        written = profile.x.len();
    }
    let mut ids = ids;
    ids.sort_unstable();
    ids.dedup();
    let words = format!(
        "{:.0} s of reference {} for {}",
        profile.x.len() as f64 * STEP_S,
        unit.1,
        ids.join(", ")
    );
    (text, words)
}
