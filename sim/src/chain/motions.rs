//! What is recorded, and the other motion that tracking is judged on.

use crate::tracking::Step;

/// Repeats of the recorded motion: one fold of the cross-validation each, or several.
const REPEATS: usize = 3;
/// Time to reach a speed (s).
const RAMP_S: f64 = 0.02;

/// Nested pre-sliding strokes, peak to peak (m), and their speed (m/s). The largest exceeds twice the longest yield
/// displacement of the paper's axis (39 µm), so that every block slips; the smaller ones show the memory.
const NESTED: [(f64, f64); 4] = [
    (150e-6, 300e-6),
    (60e-6, 150e-6),
    (20e-6, 80e-6),
    (8e-6, 40e-6),
];

/// Where the nested strokes of each repeat are made (m).
const STATIONS_M: [f64; REPEATS] = [0.0, 1e-3, -1e-3];

/// Half of the travel (m): two turns of the screw in all.
const END_M: f64 = 2e-3;

/// Passes over the whole travel, there and back, at these speeds (m/s) in each repeat.
const PASSES: [f64; 2] = [5e-3, 2.5e-3];

/// Strokes about the station, peak to peak (m), and their speed (m/s): sliding that is slow enough for a Stribeck curve.
const SLOW: [(f64, f64); 2] = [(200e-6, 300e-6), (400e-6, 600e-6)];

/// Moves to one position (m) after another at a speed (m/s).
struct Tour {
    position: f64,
    steps: Vec<Step>,
}

impl Tour {
    fn new() -> Self {
        Self {
            position: 0.0,
            steps: Vec::new(),
        }
    }

    fn go(&mut self, to: f64, speed_m_s: f64) {
        if to != self.position {
            self.steps.push(Step::Move {
                distance_m: to - self.position,
                speed_m_s,
                ramp_s: RAMP_S,
            });
            self.position = to;
        }
    }
}

/// What is recorded: in each repeat nested strokes and slow sliding at a station, then passes over the travel.
pub fn recorded() -> Vec<Step> {
    let mut tour = Tour::new();
    for station in STATIONS_M {
        tour.go(station, 2e-3);
        for (stroke, speed) in NESTED.into_iter().chain(SLOW) {
            tour.go(station + 0.5 * stroke, speed);
            tour.go(station - 0.5 * stroke, speed);
        }
        for speed in PASSES {
            tour.go(END_M, speed);
            tour.go(-END_M, speed);
        }
    }
    tour.steps
}

/// What is judged: reversals at other places, at other speeds, in other orders, some within pre-sliding.
pub fn judged() -> Vec<Step> {
    let mut tour = Tour::new();
    for (to, speed) in [
        (1.7e-3, 3e-3),
        (1.3e-3, 1e-3),
        (1.6e-3, 1e-3),
        (-0.3e-3, 3e-3),
        (-0.27e-3, 0.2e-3),
        (-0.28e-3, 0.1e-3),
        (-0.25e-3, 0.2e-3),
        (-1.8e-3, 1.5e-3),
        (-1.2e-3, 1e-3),
        (-1.5e-3, 2e-3),
        (0.4e-3, 2e-3),
        (0.37e-3, 0.3e-3),
        (0.8e-3, 1e-3),
        (0.0, 1.5e-3),
    ] {
        tour.go(to, speed);
    }
    tour.steps
}
