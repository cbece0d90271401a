//! `A·cos(2πft + φ)`, with a phase of each file's own: no clock runs from one to the next.

use super::readout::enter;
use super::wave::{PHASE, amplitude_phase_and_shape, wave};
use super::{Class, Effect, Fitted, Line, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// `external_vibration`.
pub struct ExternalVibration;

impl Effect for ExternalVibration {
    fn id(&self) -> &'static str {
        form::EXTERNAL_VIBRATION.id
    }

    fn name(&self) -> &'static str {
        "vibration from outside"
    }

    fn words(&self) -> &'static str {
        "a vibration from outside, of fixed frequency in time"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::Time
    }

    fn experiment(&self) -> &'static str {
        "a recording at rest with the controller off"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Rests]
    }

    fn recurs(&self) -> bool {
        true
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("frequency_Hz", Scale::Frequency)]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn line(&self) -> Option<Line> {
        Some(Line::Time)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[frequency] = shape else {
            return Vec::new();
        };
        let waves = wave(&scene.s.t, 1.0 / frequency);
        let within = |session: &Range<usize>| {
            waves.each_ref().map(|wave| {
                let mut part = vec![0.0; wave.len()];
                part[session.clone()].copy_from_slice(&wave[session.clone()]);
                Column::of(part)
            })
        };
        scene.s.sessions.iter().flat_map(within).collect()
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape("force_N", self, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        // The model file's vibration is a sine.
        let mut sine = values.to_vec();
        for (_, phase) in sine.iter_mut().filter(|(key, _)| key == PHASE) {
            phase.value += FRAC_PI_2;
        }
        enter(self.id(), &sine, &[], model)
    }
}
