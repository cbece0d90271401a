//! The load on a spring behind the motor; either has the encoder.

use super::ahead::{self, ENCODER_ON_LOAD, ahead};
use super::behind::{self, NONE};
use super::displaced::displaced;
use super::readout::enter;
use super::{BARE, Card, Class, Effect, Fitted, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;
use std::f64::consts::TAU;

/// Share of the inertia on the motor's side of an elastic drive or a gap, which one recording does not show.
pub(super) const MOTOR_SHARE: f64 = 0.5;
/// Between which values it lies: drives are chosen so that neither side has much more than twice the other's inertia. The intervals hold
/// what follows from both.
const SHARES: [f64; 2] = [0.3, 0.7];
/// The load's share and damping from where on those of one that swings are refined.
const LOAD: f64 = 0.5;
/// See [`LOAD`].
const DAMPED: f64 = 0.1;
/// The least that a motor has.
const LEAST_MOTOR: f64 = 0.05;
/// Half of a 95 % interval of a swing, at least, relative: how far the contact's damping, which is assumed, and friction on the motor's side shift it.
/// Swings of three made machines that it was chosen on came out 1 to 5 % low, of four others up to 6 % (`host-tests/tests/swing.rs`).
const LEAST_ERROR: f64 = 0.08;
/// Key of the resonance; of a load that swings behind a motor that stands, the shape is that swing.
const FREQUENCY: &str = "frequency_Hz";
/// Its place among the shapes.
const RESONANCE: usize = 1;
/// Key of that of a simulation.
const SIMULATED: &str = "simulated_frequency_Hz";
/// Key of the stiffness in a simulation.
const SIMULATED_STIFFNESS: &str = "simulated_stiffness_N_per_m";
/// Key of the stiffness, which is fitted where the motor has the encoder.
const STIFFNESS: &str = "stiffness_N_per_m";

/// Band of the rows (Hz): what a kernel of ±12.5 ms passes by half.
const ROWS_HZ: f64 = 0.62 / 12.5e-3;
/// Times the band of the motion up to which a resonance can be seen.
const SEEN_FROM: f64 = 3.0;

/// `drive_compliance`.
pub struct DriveCompliance;

static CARD: Card = Card {
    id: form::DRIVE_COMPLIANCE.id,
    name: "elastic drive",
    words: "an elastic drive between motor and load",
    class: Class::Drive,
    axis: Axis::Acceleration,
    experiment: "a sweep through the expected resonance",
    shown_by: &[Part::Fast, Part::Nested],
    // Where the load has the encoder, the motor is simulated, and its resonance is a shape. So is a load that swings, as if it had
    // all of the inertia: its share is the coefficient, and its frequency that behind a motor which stands.
    shape: &[
        (ahead::SHARE, Scale::Chosen),
        (FREQUENCY, Scale::Logarithmic),
        // Beside a simulation that has a spring of another size.
        (SIMULATED, Scale::Chosen),
        // The load alone, and its share then the coefficient's, too.
        (behind::SHARE, Scale::Logarithmic),
        (behind::DAMPING_RATIO, Scale::Logarithmic),
    ],
    acts_on_effort: true,
    ..BARE
};

impl Effect for DriveCompliance {
    fn card(&self) -> &Card {
        &CARD
    }

    fn shape_in(&self, _: &Entry, _: &Model) -> Vec<f64> {
        // The model file's drive has as much inertia on both sides.
        vec![MOTOR_SHARE]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let on_load = ahead::contacts(scene).map(|[hz, share]| vec![share, hz]);
        let swings = behind::swings(scene);
        let stiff = std::iter::once(vec![MOTOR_SHARE]);
        let on_motor = swings.iter().map(|hz| vec![NONE, *hz, NONE, LOAD, DAMPED]);
        let mut shapes: Vec<_> = stiff.chain(on_load).chain(on_motor).collect();
        if let Some(simulated) = scene.core.simulated_swing {
            shapes.extend(swings.iter().map(|hz| vec![NONE, *hz, simulated]));
        }
        shapes
    }

    fn valleys(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        let near = [0.7, 1.0, 1.4];
        let swings = [0.4, 0.7, 1.0, 1.4, 2.0];
        behind::valleys(shape, [&[1.0], &swings, &near, &[1.0, 0.3]])
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        if let Some(load) = behind::Load::of(shape) {
            return vec![load.in_place_of_one_bolted_on(scene)];
        }
        let share = match *shape {
            [share] => share,
            [NONE, hz, simulated] => return vec![behind::another_spring([hz, simulated], scene)],
            [share, hz] => return ahead(0.0, [hz, share], scene),
            _ => return Vec::new(),
        };
        // Behind a spring the load is displaced by the transmitted effort.
        let (core, a) = (scene.core, &scene.s.a);
        let transmitted = scene.sampled(|i| core.fitted[i] - share * core.mass * a[i]);
        vec![displaced(&transmitted, (1.0 - share) * core.mass, scene)]
    }

    fn admits(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        match (shape, coefficients) {
            (&[NONE, _, NONE, share, _], &[c]) => behind::is_load(share, c),
            (&[NONE, ..], &[c]) => behind::LOAD.contains(&c),
            (&[share, _], &[c]) => ahead::is_motor(share, c),
            (_, &[c]) => c > 0.0,
            _ => false,
        }
    }

    fn in_simulation(&self, shape: &[f64]) -> Option<bool> {
        match shape {
            [NONE, _, NONE, ..] | [_] | [] => None,
            // The motor that is ahead of the load is driven by the measured effort.
            [_, _] => Some(false),
            _ => Some(true),
        }
    }

    /// An effect in proportion to the fourth derivative is seen from a third of its resonance on: below that the recording has nothing of it,
    /// and what is fitted there is the hysteresis' own error.
    fn is_harmless(&self, scene: &Scene, coefficients: &[f64]) -> bool {
        let reduced = scene.core.mass * MOTOR_SHARE * (1.0 - MOTOR_SHARE);
        let compliance = coefficients.first().map_or(0.0, |c| c.abs());
        let frequency = (compliance * reduced).sqrt().recip() / TAU;
        frequency > SEEN_FROM * scene.s.band_hz.min(ROWS_HZ)
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        let seen = SEEN_FROM * scene.s.band_hz.min(ROWS_HZ);
        match (index, shape) {
            (_, &[NONE, ..]) => behind::of_load(scene, shape, index),
            (RESONANCE, &[_, hz]) => ahead::within(hz.min(seen), scene),
            _ => shape[index],
        }
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        match *fitted.shape {
            [NONE, ..] => return swinging(fitted),
            [share, _] => return ahead::with_own_share(fitted, &CARD, share),
            _ => {}
        }
        let stiffness = |c: f64| 1.0 / c.abs().max(f64::MIN_POSITIVE);
        let mut values = vec![
            over_shares(fitted, STIFFNESS, |_, c, error| {
                let error = error.map(|e| e * stiffness(c).powi(2));
                fitted.estimate(stiffness(c), error)
            }),
            over_shares(fitted, FREQUENCY, |share, c, error| {
                // Two masses on a spring: `ω² = k/(m·μ·(1 − μ))`.
                let reduced = fitted.scene.core.mass * share * (1.0 - share);
                let frequency = (stiffness(c) / reduced).sqrt() / TAU;
                let error = error.map(|e| 0.5 * e * stiffness(c) * frequency);
                fitted.estimate(frequency, error)
            }),
        ];
        values.extend(fitted.shape_of(&CARD));
        values
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        if !values.iter().any(|(key, _)| key == STIFFNESS) {
            return Err(ENCODER_ON_LOAD.to_owned());
        }
        let own = |key: &str| values.iter().find(|(own, _)| own == key);
        // The model file's drive has as much inertia on both sides: of the same stiffness it swings the slower, the less even they are.
        let even = own(ahead::SHARE).map_or(1.0, |(_, told)| {
            2.0 * (told.value * (1.0 - told.value)).max(0.0).sqrt()
        });
        let frequency = own(FREQUENCY).map(|(key, told)| {
            let told = Estimate {
                value: even * told.value,
                ci95: told.ci95.map(|ends| ends.map(|end| even * end)),
            };
            (key.clone(), told)
        });
        enter(self.id(), frequency.as_slice(), &[], model)
    }
}

/// Stiffness and resonance of a load that swings behind a motor that stands, the motor's share, and the stiffness that a simulation has for it.
fn swinging(fitted: &Fitted) -> Vec<(String, Estimate)> {
    let told = ahead::widened(fitted, &CARD, &[LEAST_ERROR; 3]);
    // What is simulated with a share of the inertia passes as much of it as the coefficient says.
    let assumed = fitted.shape.get(3).copied().unwrap_or(1.0);
    let c = assumed * fitted.coefficient(0);
    let error = fitted.error(0).map(|e| assumed * e);
    let share = fitted.estimate(c, error);
    let possible = |load: f64| load.clamp(0.0, 1.0 - LEAST_MOTOR);
    // Two masses on a spring, of which one has the share `load`.
    let mass = fitted.scene.core.mass;
    let stiffness = |hz: f64, load: f64| (TAU * hz).powi(2) * possible(load) * mass;
    let both = |hz: f64, load: f64| hz / (1.0 - possible(load)).sqrt();
    let at = |own: &str, of: &dyn Fn(f64, f64) -> f64| {
        let (_, swing) = told.iter().find(|(key, _)| key == own)?;
        let load = share.value;
        let value = of(swing.value, load);
        let least = [-LEAST_ERROR, LEAST_ERROR].map(|by| (1.0 + by) * swing.value);
        let swings = swing.ci95.unwrap_or(least);
        // Swing and share err by themselves.
        let ends = share.ci95.map(|shares| {
            [0, 1].map(|end| {
                let of_swing = of(swings[end], load) - value;
                let of_share = of(swing.value, shares[end]) - value;
                value + (2.0 * end as f64 - 1.0) * of_swing.hypot(of_share)
            })
        });
        Some(Estimate { value, ci95: ends })
    };
    let simulated = at(SIMULATED, &stiffness).filter(|s| s.value > 0.0);
    // What two springs differ in hardly shows the share by itself.
    let is_told = simulated.is_none();
    let motor = || fitted.estimate(1.0 - possible(c), error);
    let values = [
        (STIFFNESS, at(FREQUENCY, &stiffness)),
        (SIMULATED_STIFFNESS, simulated),
        (FREQUENCY, at(FREQUENCY, &both).filter(|_| is_told)),
        (ahead::SHARE, is_told.then(motor)),
    ];
    let values = values
        .into_iter()
        .filter_map(|(key, told)| Some((key.to_owned(), told?)));
    values.collect()
}

/// A value at the assumed share, and an interval that holds those at all that the share may be.
fn over_shares(
    fitted: &Fitted,
    key: &str,
    of: impl Fn(f64, f64, Option<f64>) -> Estimate,
) -> (String, Estimate) {
    let error = fitted.error(0);
    let share = fitted.shape.first().copied().unwrap_or(MOTOR_SHARE);
    let mut own = of(share, fitted.coefficient(0), error);
    for share in SHARES {
        if let (Some([low, high]), Some(c)) = (&mut own.ci95, (fitted.at_shape)(&[share]))
            && let Some(ends) = of(share, c, error).ci95
        {
            (*low, *high) = (low.min(ends[0]), high.max(ends[1]));
        }
    }
    (key.to_owned(), own)
}
