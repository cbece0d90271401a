//! What is kept of a run.

use super::{Circle, Instant};
use preslide::control::Fault;
use preslide_fit::report::Table;

/// Following error over a motion, as the encoder sees it before quantisation.
#[derive(Clone, Debug, Default)]
pub struct Tracking {
    squares: f64,
    samples: u64,
    peak: f64,
    fault: Option<Fault>,
}

impl Tracking {
    /// Takes a tick; `count` is one encoder count (m).
    pub fn add(&mut self, now: &Instant, count: f64) {
        self.take(now, count, now.encoder_m);
    }

    /// Takes a tick; the error is that of the true position.
    pub fn add_true(&mut self, now: &Instant, count: f64) {
        self.take(now, count, now.true_m);
    }

    fn take(&mut self, now: &Instant, count: f64, position_m: f64) {
        let error = now.command.reference as f64 / 65536.0 * count - position_m;
        self.squares += error * error;
        self.samples += 1;
        self.peak = self.peak.max(error.abs());
        self.fault = self.fault.or(now.command.fault);
    }

    /// RMS error (m); `None` where the run ended in a fault.
    pub fn rms_m(&self) -> Option<f64> {
        (self.fault.is_none() && self.samples > 0)
            .then(|| (self.squares / self.samples as f64).sqrt())
    }

    /// Largest error (m).
    pub fn peak_m(&self) -> f64 {
        self.peak
    }
}

/// A step counts as settled if it ends with at least this time (s) within one count.
const QUIET_S: f64 = 0.05;

/// The 100 nm steps.
#[derive(Clone, Debug, Default)]
pub struct Steps {
    /// The present step's index in the motion.
    step: usize,
    /// Seconds since it began, and until it was last more than one count off.
    now_s: f64,
    outside_s: f64,
    /// Steps made.
    pub made: usize,
    /// Steps that came within one count of the target and stayed there.
    pub settled: usize,
    /// The longest that this took, from the start of the step (s).
    pub slowest_s: f64,
}

impl Steps {
    /// Steps are a move and a dwell in turn; `now.step` is even while moving.
    pub(super) fn add(&mut self, now: &Instant, sample_time: f64) {
        let moving = now.step.is_multiple_of(2);
        if moving && now.step != self.step {
            self.finish();
        }
        self.step = now.step;
        self.now_s += sample_time;
        // The targets are whole counts.
        let target = (now.command.reference + 0x8000) >> 16;
        let off = (now.command.position - target).abs() > 1;
        if moving || off || now.command.fault.is_some() {
            self.outside_s = self.now_s;
        }
    }

    /// Counts the step that has just ended.
    pub(super) fn finish(&mut self) {
        if self.now_s > 0.0 {
            self.made += 1;
            if self.now_s - self.outside_s >= QUIET_S {
                self.settled += 1;
                self.slowest_s = self.slowest_s.max(self.outside_s);
            }
        }
        (self.now_s, self.outside_s) = (0.0, 0.0);
    }
}

/// Rest after a move: does it hunt?
#[derive(Clone, Debug, Default)]
pub struct Rest {
    time_s: f64,
    range: Option<(i64, i64)>,
    fault: Option<Fault>,
}

impl Rest {
    /// The first ten seconds may still creep.
    const CREEP_S: f64 = 10.0;

    pub(super) fn add(&mut self, now: &Instant, sample_time: f64) {
        self.time_s += sample_time;
        self.fault = self.fault.or(now.command.fault);
        if self.time_s > Self::CREEP_S {
            let at = now.command.position;
            let (low, high) = self.range.unwrap_or((at, at));
            self.range = Some((low.min(at), high.max(at)));
        }
    }

    /// Counts between the lowest and the highest position after the first ten seconds; `None` where the run
    /// ended in a fault. More than one is a limit cycle, or creep.
    pub fn counts(&self) -> Option<i64> {
        match (self.fault, self.range) {
            (None, Some((low, high))) => Some(high - low),
            _ => None,
        }
    }
}

/// One compensator.
#[derive(Clone, Debug)]
pub struct Row {
    /// The friction model.
    pub compensator: String,
    /// What it computes in.
    pub arithmetic: &'static str,
    /// The nested triangles.
    pub nested: Tracking,
    /// The slide with reversals.
    pub slide: Tracking,
    /// The 100 nm steps.
    pub steps: Steps,
    /// The 60 s at rest.
    pub rest: Rest,
    /// A circle by two such axes; `None` where one ended in a fault.
    pub circle: Option<Circle>,
}

impl Row {
    pub(super) fn new(compensator: &str, arithmetic: &'static str) -> Self {
        Self {
            compensator: compensator.to_owned(),
            arithmetic,
            nested: Tracking::default(),
            slide: Tracking::default(),
            steps: Steps::default(),
            rest: Rest::default(),
            circle: None,
        }
    }
}

/// The rows as a table for people.
pub fn print(rows: &[Row]) -> String {
    let nm = |t: &Tracking| match t.rms_m() {
        Some(rms) => format!("{:.0} / {:.0}", rms * 1e9, t.peak_m() * 1e9),
        None => format!("{:?}", t.fault),
    };
    Table::of(
        "RMS / peak error (nm) over nested triangles and slides of 1 mm/s; steps settled, the slowest (ms); counts in 60 s of rest; a circle by two axes, spike / quadrant (nm)",
        rows,
    )
    .column("compensator", |row| row.compensator.clone())
    .column("", |row| row.arithmetic.to_owned())
    .column("nested", |row| nm(&row.nested))
    .column("slide", |row| nm(&row.slide))
    .column("steps", |row| format!("{}/{}", row.steps.settled, row.steps.made))
    .column("slowest", |row| format!("{:.0}", row.steps.slowest_s * 1e3))
    .column("rest", |row| row.rest.counts().map_or("fault".into(), |c| c.to_string()))
    .column("circle", |row| {
        let circle = row.circle.map(|c| [c.spike_m, c.quadrant_m].map(|m| m * 1e9));
        circle.map_or("fault".into(), |[spike, quadrant]| format!("{spike:.0} / {quadrant:.0}"))
    })
    .table()
    .to_text()
}
