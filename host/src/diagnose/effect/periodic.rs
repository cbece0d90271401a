//! Waves that a line of a spectrum shows, `A·cos(2πx/p + φ)` and in time: five effects, told apart by what the wave does.

use super::displaced::displaced;
use super::lack::both_directions;
use super::readout::enter;
use super::wave::{PHASE, amplitude_phase_and_shape, wave};
use super::{BARE, Card, Class, Effect, Fitted, Line, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::Cos;
use crate::diagnose::expr::Input::Time;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

/// An effect of one wave.
pub struct Periodic {
    card: Card,
    /// What a cosine and a sine of such a period or frequency do to the effort.
    columns: fn(f64, &Scene) -> Vec<Column>,
}

/// The shape of all but the vibration.
const PERIOD: &[(&str, Scale)] = &[("period_m", Scale::Period)];

/// `A·cos(2πx/p + φ)`.
pub static PERIODIC_FORCE: Periodic = Periodic {
    card: Card {
        id: form::PERIODIC_FORCE.id,
        name: "cogging or torque ripple",
        words: "a force with a fixed period in position",
        class: Class::Place,
        axis: Axis::Position,
        experiment: "slow constant-speed passes at two speeds and with the motor off (pushed): cogging stays",
        coefficient: "force_N",
        shape: PERIOD,
        line: Some(Line::Force),
        recurs: true,
        formula: Some(|stated| Some(stated.get("force_N")? * stated.wave()?)),
        ..BARE
    },
    columns: |period, scene| wave(&scene.s.x, period).map(Column::of).to_vec(),
};

/// `m = 1 + a·cos(2πx/p + φ)`.
pub static PERIODIC_FRICTION: Periodic = Periodic {
    card: Card {
        id: form::PERIODIC_FRICTION.id,
        name: "friction ripple",
        words: "a friction level with a fixed period in position: screw or ball passage",
        class: Class::Place,
        axis: Axis::Position,
        experiment: "slow passes over several periods in both directions: friction flips with the direction",
        coefficient: "level",
        shape: PERIOD,
        line: Some(Line::Level),
        recurs: true,
        // A ripple of all that resists the motion, viscous friction too, differs from it by inertia and weight alone.
        in_place: &[&TORQUE_RIPPLE],
        lacks: both_directions,
        formula: Some(|stated| Some(stated.friction(stated.get("level")? * stated.wave()?))),
        ..BARE
    },
    columns: |period, scene| {
        let waves = wave(&scene.s.x, period);
        waves.map(|wave| scene.friction(|i| wave[i])).to_vec()
    },
};

/// `F = command·(1 + a·cos(2πx/p + φ))`: the motor's constant over its angle.
pub static TORQUE_RIPPLE: Periodic = Periodic {
    card: Card {
        id: form::TORQUE_RIPPLE.id,
        name: "ripple in proportion to the current",
        words: "a motor whose force for a given current varies with its position: torque ripple",
        class: Class::Drive,
        axis: Axis::Position,
        experiment: "slow constant-speed passes with two loads or against a spring: torque ripple grows with the force, cogging stays",
        shown_by: &[Part::Passes, Part::Fast],
        coefficient: "share",
        shape: PERIOD,
        line: Some(Line::Effort),
        acts_on_effort: true,
        ..BARE
    },
    // What the drive is asked for beyond the force, to first order in the share.
    columns: |period, scene| {
        let waves = wave(&scene.s.x, period);
        let more = waves.map(|wave| scene.force(|i| -wave[i] * scene.core.fitted[i]));
        more.to_vec()
    },
};

/// Measured `= x + e·cos(2πx/p + φ)`.
pub static ENCODER_ERROR: Periodic = Periodic {
    card: Card {
        id: form::ENCODER_ERROR.id,
        name: "encoder interpolation error",
        words: "interpolation error of the encoder",
        class: Class::Drive,
        axis: Axis::Position,
        experiment: "creep over several encoder periods within the pre-sliding range, against a reference",
        shown_by: &[Part::Nested],
        coefficient: "error_m",
        shape: PERIOD,
        line: Some(Line::Force),
        ..BARE
    },
    columns: |period, scene| {
        let errors = wave(&scene.s.x, period);
        errors
            .map(|error| displaced(&error, scene.core.mass, scene))
            .to_vec()
    },
};

/// `A·cos(2πft + φ)`, with a phase of each file's own: no clock runs from one to the next.
pub static EXTERNAL_VIBRATION: Periodic = Periodic {
    card: Card {
        id: form::EXTERNAL_VIBRATION.id,
        name: "vibration from outside",
        words: "a vibration from outside, of fixed frequency in time",
        class: Class::Drive,
        axis: Axis::Time,
        experiment: "a recording at rest with the controller off",
        shown_by: &[Part::Rests],
        coefficient: "force_N",
        shape: &[("frequency_Hz", Scale::Frequency)],
        line: Some(Line::Time),
        recurs: true,
        formula: Some(|stated| {
            let turns = TAU * stated.get("frequency_Hz")? * Expr::from(Time);
            let wave = (turns + Expr::Number(stated.get("phase_rad")?)).of(Cos);
            Some(stated.get("force_N")? * wave)
        }),
        ..BARE
    },
    columns: |frequency, scene| {
        let waves = wave(&scene.s.t, 1.0 / frequency);
        let within = |session: &Range<usize>| {
            waves.each_ref().map(|wave| {
                let mut part = vec![0.0; wave.len()];
                part[session.clone()].copy_from_slice(&wave[session.clone()]);
                Column::of(part)
            })
        };
        scene.s.sessions.iter().flat_map(within).collect()
    },
};

impl Effect for Periodic {
    fn card(&self) -> &Card {
        &self.card
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        match *shape {
            [length] => (self.columns)(length, scene),
            _ => Vec::new(),
        }
    }

    /// Friction does not push: its level stays above zero.
    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        let is_level = self.card.line == Some(Line::Level);
        !is_level || coefficients.iter().map(|c| c * c).sum::<f64>() < 1.0
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape(&self.card, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        let mut values = values.to_vec();
        if self.card.line == Some(Line::Time) {
            // The model file's vibration is a sine.
            for (_, phase) in values.iter_mut().filter(|(key, _)| key == PHASE) {
                phase.value += FRAC_PI_2;
            }
        }
        enter(self.card.id, &values, &[], model)
    }
}
