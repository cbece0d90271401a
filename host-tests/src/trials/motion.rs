//! The motion asked of the stage: nested triangles, slides, rests, long strokes, sums of sines.

use std::f64::consts::{PI, TAU};

use super::draw::Draw;

/// Where the stage should be at one tick of the controller.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    /// Position (m).
    pub x: f64,
    /// Velocity (m/s).
    pub v: f64,
    /// Acceleration (m/s²).
    pub a: f64,
    /// Number of the segment within its repeat.
    pub segment: u32,
    /// Number of the repeat.
    pub repeat: u32,
}

/// Longest recording (s): the design's 180 s, and room for rounding.
const LONGEST_S: f64 = 178.0;

/// The reference at every tick of length `tick_s` (s).
pub struct Motion {
    /// Half of the travel (m); the axis moves within ± this.
    pub half_travel: f64,
    /// Repeats of the motion.
    pub repeats: u32,
    /// One entry a tick.
    pub ticks: Vec<Reference>,
}

struct Path {
    ticks: Vec<Reference>,
    tick_s: f64,
    acceleration: f64,
    here: Reference,
}

impl Path {
    fn push(&mut self, x: f64, v: f64, a: f64) {
        self.here = Reference {
            x,
            v,
            a,
            ..self.here
        };
        self.ticks.push(self.here);
    }

    /// Goes to `target` (m) at most at `speed` (m/s), from rest to rest, with trapezoidal velocity.
    fn go(&mut self, target: f64, speed: f64) {
        let (start, distance) = (self.here.x, (target - self.here.x).abs());
        if distance == 0.0 {
            return;
        }
        let direction = (target - start).signum();
        let peak = speed.min((distance * self.acceleration).sqrt());
        let ramp = peak / self.acceleration;
        let duration = distance / peak + ramp;
        let ticks = (duration / self.tick_s).ceil() as usize;
        for i in 1..=ticks {
            let t = (i as f64 * self.tick_s).min(duration);
            let left = duration - t;
            let (s, v, a) = if t < ramp {
                (
                    0.5 * self.acceleration * t * t,
                    self.acceleration * t,
                    self.acceleration,
                )
            } else if left > ramp {
                (peak * (t - 0.5 * ramp), peak, 0.0)
            } else {
                let v = self.acceleration * left;
                (distance - 0.5 * v * left, v, -self.acceleration)
            };
            self.push(start + direction * s, direction * v, direction * a);
        }
        self.rest(0.0);
    }

    fn rest(&mut self, seconds: f64) {
        for _ in 0..(seconds / self.tick_s).ceil() as usize {
            self.push(self.here.x, 0.0, 0.0);
        }
        (self.here.v, self.here.a) = (0.0, 0.0);
    }

    /// Sines `(amplitude (m), frequency (Hz), phase (rad))` about here, faded in and out over 0.5 s.
    fn sines(&mut self, seconds: f64, lines: &[(f64, f64, f64)]) {
        const FADE_S: f64 = 0.5;
        let centre = self.here.x;
        let ticks = (seconds / self.tick_s).ceil() as usize;
        for i in 1..=ticks {
            let t = i as f64 * self.tick_s;
            let edge = t.min(seconds - t).max(0.0);
            let (w, dw, ddw) = if edge < FADE_S {
                let (sin, cos) = (PI * edge / FADE_S).sin_cos();
                let side = if t < 0.5 * seconds { 1.0 } else { -1.0 };
                let rate = PI / FADE_S;
                (
                    0.5 - 0.5 * cos,
                    side * 0.5 * rate * sin,
                    0.5 * rate * rate * cos,
                )
            } else {
                (1.0, 0.0, 0.0)
            };
            let (mut y, mut dy, mut ddy) = (0.0, 0.0, 0.0);
            for &(amplitude, frequency, phase) in lines {
                let rate = TAU * frequency;
                let (sin, cos) = (rate * t + phase).sin_cos();
                y += amplitude * sin;
                dy += amplitude * rate * cos;
                ddy -= amplitude * rate * rate * sin;
            }
            self.push(
                centre + w * y,
                dw * y + w * dy,
                ddw * y + 2.0 * dw * dy + w * ddy,
            );
        }
        self.push(centre, 0.0, 0.0);
    }
}

/// What is drawn of a motion before it is made. Slow and small parts are made at several stations, so that they do not all see the
/// same stretch of the guide.
struct Plan {
    half_travel: f64,
    /// Where triangles, slides, rests and sines are made (m).
    stations: [f64; 4],
    /// Factor on times (-).
    unhurried: f64,
    /// Of the triangles (m), longest first.
    sizes: Vec<f64>,
    /// Triangles per second (Hz).
    triangle_rates: [f64; 2],
    /// Of the slides (m/s).
    speeds: Vec<f64>,
    /// (s).
    rests: [f64; 4],
    stroke_speeds: [f64; 2],
    /// Of the sines: amplitude (m), frequency (Hz), phase (rad).
    lines: Vec<(f64, f64, f64)>,
}

/// Speed (m/s) between the parts.
const TRANSIT: f64 = 30e-3;

impl Plan {
    /// The order of the draws is part of every seed's motion. `half_travel` and `unhurried` are drawn before.
    fn draw(draw: &mut Draw, half_travel: f64, unhurried: f64) -> Self {
        Self {
            half_travel,
            unhurried,
            stations: std::array::from_fn(|_| draw.uniform(-0.85, 0.85) * half_travel),
            sizes: [500e-6, 160e-6, 50e-6, 16e-6, 5e-6]
                .iter()
                .map(|s| s * draw.uniform(0.7, 1.4))
                .collect(),
            triangle_rates: [draw.uniform(0.5, 1.0), draw.uniform(2.0, 4.0)],
            speeds: [0.06e-3, 0.25e-3, 1e-3, 4e-3, 15e-3, 40e-3]
                .iter()
                .map(|v| v * draw.uniform(0.7, 1.4))
                .collect(),
            rests: [0.1, 1.0, 0.3, 2.5].map(|t: f64| t * draw.uniform(0.7, 1.4) * unhurried),
            stroke_speeds: [draw.uniform(7e-3, 14e-3), draw.uniform(30e-3, 60e-3)],
            lines: [0.37, 0.9, 2.1, 4.7, 8.3, 13.0]
                .iter()
                .map(|f| {
                    let rate = TAU * f * draw.uniform(0.85, 1.15);
                    let amplitude = (5e-3 / rate)
                        .min(0.22 / (rate * rate))
                        .min(0.1 * half_travel);
                    (amplitude, rate / TAU, draw.uniform(0.0, TAU))
                })
                .collect(),
        }
    }

    /// Every part once, from wherever the path is to the middle.
    fn repeat(&self, path: &mut Path) {
        path.here.segment = 0;
        path.go(self.stations[0], TRANSIT);
        path.rest(0.1);
        self.triangles(path);
        path.here.segment = 1;
        path.go(self.stations[1], TRANSIT);
        self.slides(path);
        path.here.segment = 2;
        path.go(self.stations[2], TRANSIT);
        self.rests(path);
        path.here.segment = 3;
        for speed in self.stroke_speeds {
            path.go(self.half_travel, speed);
            path.go(-self.half_travel, speed);
        }
        path.here.segment = 4;
        path.go(self.stations[3], TRANSIT);
        path.sines(2.5 * self.unhurried, &self.lines);
        path.go(0.0, TRANSIT);
        path.rest(0.2);
    }

    /// Each triangle inside the one before it: the loops nest.
    fn triangles(&self, path: &mut Path) {
        for rate in self.triangle_rates {
            for size in &self.sizes {
                let around = path.here.x;
                for end in [around + size, around, around + size, around] {
                    path.go(end, 2.0 * size * rate / self.unhurried);
                }
            }
        }
    }

    /// Forth and back at every speed, within the travel.
    fn slides(&self, path: &mut Path) {
        let station = self.stations[1];
        for &speed in &self.speeds {
            let length = (speed * 0.8 * self.unhurried).min(self.half_travel - station.abs());
            path.go(station + length, speed);
            path.go(station, speed);
        }
    }

    /// Rests, each followed by a short way to the other side.
    fn rests(&self, path: &mut Path) {
        for (i, &seconds) in self.rests.iter().enumerate() {
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            path.rest(seconds);
            path.go(path.here.x + side * 60e-6, 0.15e-3);
        }
    }
}

impl Motion {
    /// A motion of 3 to 6 repeats, 40 to 180 s in all.
    pub fn draw(draw: &mut Draw, tick_s: f64) -> Self {
        let half_travel = draw.uniform(8e-3, 20e-3);
        let asked = draw.whole(4, 7) as u32;
        let unhurried = draw.uniform(0.5, 1.6);
        let plan = Plan::draw(draw, half_travel, unhurried);
        let mut path = Path {
            ticks: Vec::new(),
            tick_s,
            acceleration: draw.uniform(0.3, 0.6),
            here: Reference::default(),
        };
        // All repeats take as long as the first, but for the way to its start.
        let longest = (LONGEST_S / tick_s) as usize;
        let mut repeats = 0;
        while repeats < asked
            && (repeats < 3
                || path.ticks.len() / repeats as usize * (repeats as usize + 1) < longest)
        {
            path.here.repeat = repeats;
            repeats += 1;
            plan.repeat(&mut path);
        }
        Motion {
            half_travel,
            repeats,
            ticks: path.ticks,
        }
    }
}
