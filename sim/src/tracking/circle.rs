//! A circle by two axes: what is left where one of them turns.

use super::{Instant, TrackingError};
use preslide::control::{Move, Planner, Settings};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Radius (m) and speed along the circle (m/s).
const RADIUS_M: f64 = 0.5e-3;
const SPEED_M_S: f64 = 1e-3;
/// Turns; the last is judged.
const TURNS: f64 = 2.0;
/// Time to reach the speed (s).
const RAMP_S: f64 = 0.2;
/// Ticks from one point of the stream to the next: 1 ms.
const POINT_TICKS: u32 = 20;
/// What belongs to a reversal (rad): 0.1 s either way.
const NEAR_RAD: f64 = 0.1 * SPEED_M_S / RADIUS_M;

/// Angle (rad) after `t_s`: the speed rises over [`RAMP_S`], and falls at the end.
fn angle(t_s: f64, duration_s: f64) -> f64 {
    let rate = SPEED_M_S / RADIUS_M;
    let ramp = |t: f64| rate * t.clamp(0.0, RAMP_S).powi(2) / (2.0 * RAMP_S);
    let cruise = rate * (t_s.min(duration_s - RAMP_S) - RAMP_S).max(0.0);
    let braked = ramp(RAMP_S) - ramp(duration_s - t_s.min(duration_s));
    ramp(t_s)
        + cruise
        + if t_s > duration_s - RAMP_S {
            braked
        } else {
            0.0
        }
}

/// The stream of one axis: the sine, or the cosine less one.
///
/// # Errors
/// [`TrackingError`] where the axis's limits do not allow it.
pub fn moves(settings: &Settings, cosine: bool) -> Result<Vec<Move>, TrackingError> {
    let mut planner = Planner::try_new(settings)?;
    planner.stands(0, false);
    let duration_s = TURNS * TAU * RADIUS_M / SPEED_M_S + RAMP_S;
    let point_s = settings.sample_time() * f64::from(POINT_TICKS);
    let count = (duration_s / point_s).ceil() as u32;
    (1..=count + 2)
        .map(|i| {
            let angle = angle(f64::from(i) * point_s, duration_s);
            let x = if cosine {
                angle.cos() - 1.0
            } else {
                angle.sin()
            };
            Ok(planner.point(RADIUS_M * x, POINT_TICKS)?)
        })
        .collect()
}

/// What an axis did: reference and position as the encoder sees it (m), every tick.
#[derive(Clone, Debug, Default)]
pub struct Path {
    points: Vec<[f64; 2]>,
    faulted: bool,
}

impl Path {
    /// Takes a tick; `count` is one encoder count (m).
    pub fn add(&mut self, now: &Instant, count: f64) {
        let reference = now.command.reference as f64 / 65536.0 * count;
        self.points.push([reference, now.encoder_m]);
        self.faulted |= now.command.fault.is_some();
    }
}

/// A judged circle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Circle {
    /// Largest following error (m) of an axis within 0.1 s of its own reversal.
    pub spike_m: f64,
    /// Largest deviation (m) from the reference's radius within 0.1 s of a reversal of either axis.
    pub quadrant_m: f64,
}

impl Circle {
    /// Of the cosine's and the sine's axis; `None` where one ended in a fault.
    pub fn judge(x: &Path, y: &Path) -> Option<Self> {
        if x.faulted || y.faulted || x.points.is_empty() {
            return None;
        }
        let mut circle = Self::default();
        // The last turn, as long as the speed is whole: it ends where the ramp begins.
        let judged = x.points.iter().zip(&y.points).skip(x.points.len() / 2);
        for ([x_ref, x], [y_ref, y]) in judged {
            let angle = y_ref.atan2(x_ref + RADIUS_M);
            let near = |of: f64| (angle - of).rem_euclid(2.0 * FRAC_PI_2);
            let turns = |of| near(of).min(2.0 * FRAC_PI_2 - near(of)) < NEAR_RAD;
            let (x_turns, y_turns) = (turns(0.0), turns(FRAC_PI_2));
            if x_turns {
                circle.spike_m = circle.spike_m.max((x_ref - x).abs());
            }
            if y_turns {
                circle.spike_m = circle.spike_m.max((y_ref - y).abs());
            }
            if x_turns || y_turns {
                let radius = (x + RADIUS_M).hypot(*y) - (x_ref + RADIUS_M).hypot(*y_ref);
                circle.quadrant_m = circle.quadrant_m.max(radius.abs());
            }
        }
        Some(circle)
    }
}
