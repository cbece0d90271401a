//! A motor with play and spring ahead of a load that has the encoder, as a scale on the slide: what the effort moves and the encoder
//! does not see.

use super::{Card, Fitted, Scene};
use crate::diagnose::weak::Column;
use preslide_fit::statistics::Estimate;
use std::f64::consts::TAU;
use std::ops::Range;

/// Key of the motor's share of the inertia.
pub(super) const SHARE: &str = "motor_share";
/// Damping ratio of a contact of steel parts, which a recording hardly shows.
pub(super) const DAMPING: f64 = 0.05;
/// Most radians of the contact's own swing in one step of the simulation.
const STEP: f64 = 0.3;
/// Frequencies (Hz) at which motor and load may swing on their contact, from where on they are refined.
const CONTACTS_HZ: [f64; 2] = [100.0, 180.0];
/// Below it (Hz) the rows pass what the effort's own noise moves, and the column would explain the noise.
const SLOWEST_HZ: f64 = 75.0;
/// Most periods of the contact's swing in a sample: two samples a period are needed, and some more.
const SEEN: f64 = 0.4;
/// Shares of the inertia on the motor's side: a coefficient beside them is free within [`MOTOR`], so that these say little more than how fast
/// a gap is crossed.
const SHARES: [f64; 2] = [0.2, 0.5];
/// Between which shares it lies: a motor has some of the inertia, and not all.
const MOTOR: Range<f64> = 0.05..0.95;
/// Half of a 95 % interval of a gap or a frequency, at least, relative: how far the motor's own friction and inertia and the contact's
/// damping, which are assumed, shift them. Gaps of made recordings came out as 0.84 to 1.57 times their width.
pub(super) const LEAST_ERROR: f64 = 0.4;
/// Why a model file cannot hold what was found beside an encoder on the load.
pub(super) const ENCODER_ON_LOAD: &str =
    "the encoder is on the load here, and a model file's elastic drive or gap has it on the motor";

/// Those of some frequencies (Hz) of which a sample is no more than so many `periods`; none without inertia.
pub(super) fn resolved<const N: usize>(
    some: [f64; N],
    periods: f64,
    scene: &Scene,
) -> impl Iterator<Item = f64> {
    let (inertial, dt) = (scene.core.mass > 0.0, scene.s.dt);
    let seen = move |hz: &f64| inertial && hz * dt < periods;
    some.into_iter().filter(seen)
}

/// Contact frequencies (Hz) and motor shares to try; none without inertia or where the samples are too coarse.
pub(super) fn contacts(scene: &Scene) -> impl Iterator<Item = [f64; 2]> {
    resolved(CONTACTS_HZ, SEEN, scene).flat_map(|hz| SHARES.map(|share| [hz, share]))
}

/// A contact frequency (Hz) brought within what a recording can resolve.
pub(super) fn within(hz: f64, scene: &Scene) -> f64 {
    hz.clamp(SLOWEST_HZ, (SEEN / scene.s.dt).max(SLOWEST_HZ))
}

/// Whether `times` an assumed share of the inertia is one that a motor may have.
pub(super) fn is_motor(share: f64, times: f64) -> bool {
    MOTOR.contains(&(share * times))
}

/// Shapes of a fit with intervals that hold what is assumed: half of each at least, relative.
pub(super) fn widened(fitted: &Fitted, card: &Card, least: &[f64]) -> Vec<(String, Estimate)> {
    let mut values = fitted.shape_of(card);
    for ((_, told), least) in values.iter_mut().zip(least) {
        let least = least * told.value;
        told.ci95 = told
            .ci95
            .map(|[low, high]| [low.min(told.value - least), high.max(told.value + least)]);
    }
    values
}

/// Shapes of a fit, and in place of the share that was assumed the motor's own: that, times how much of the assumed motor is there.
pub(super) fn with_own_share(
    fitted: &Fitted,
    card: &Card,
    assumed: f64,
) -> Vec<(String, Estimate)> {
    let mut values = widened(fitted, card, &[LEAST_ERROR; 3]);
    values.retain(|(key, _)| key != SHARE);
    let coefficient = fitted.coefficient(0);
    // Beside a curve without a name it may be anything.
    if is_motor(assumed, coefficient) {
        let error = fitted.error(0).map(|e| assumed * e);
        let own = fitted.estimate(assumed * coefficient, error);
        values.push((SHARE.to_owned(), own));
    }
    values
}

/// The motor's inertia (kg or kg·m²), the stiffness (N/m) and damping (N·s/m) of the contact, half the gap (m or rad).
struct Drive {
    motor: f64,
    stiffness: f64,
    damping: f64,
    half: f64,
}

/// What the motor adds to the effort: its inertia times the second derivative of how far it is ahead of the load, as a motor behind a contact
/// with the load that swings at `contact_hz` follows the measured effort.
pub(super) fn ahead(gap: f64, [contact_hz, share]: [f64; 2], scene: &Scene) -> Vec<Column> {
    let motor = share * scene.core.mass;
    if motor <= 0.0 {
        return Vec::new();
    }
    let w = TAU * contact_hz;
    let reduced = motor * (1.0 - share);
    let drive = Drive {
        motor,
        stiffness: w * w * reduced,
        damping: 2.0 * DAMPING * w * reduced,
        half: 0.5 * gap,
    };
    let steps = (w * scene.s.dt / STEP).ceil().max(1.0) as usize;
    let ahead = drive.ahead(scene, steps);
    vec![Column {
        curved: ahead.iter().map(|d| motor * d).collect(),
        ..Column::default()
    }]
}

impl Drive {
    /// How far the motor is ahead of the measured load at the samples, the effort of each held until the next, as controllers do.
    fn ahead(&self, scene: &Scene, steps: usize) -> Vec<f64> {
        let s = scene.s;
        let h = s.dt / steps as f64;
        let mut ahead = vec![0.0; s.x.len()];
        for piece in &s.pieces {
            let first = scene.effort[piece.start];
            let mut d = self.half.copysign(first) + first / self.stiffness;
            let mut v = 0.0;
            for i in piece.clone() {
                ahead[i] = d;
                let next = (i + 1).min(piece.end - 1);
                let load = (s.x[next] - s.x[i]) / s.dt;
                if i == piece.start {
                    v = load;
                }
                for _ in 0..steps {
                    let beyond = d - d.clamp(-self.half, self.half);
                    let rubs = if beyond == 0.0 {
                        0.0
                    } else {
                        self.damping * (v - load)
                    };
                    let passed = self.stiffness * beyond + rubs;
                    v += h * (scene.effort[i] - passed) / self.motor;
                    d += h * (v - load);
                }
            }
        }
        ahead
    }
}
