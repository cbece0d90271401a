//! Measured `= x + e·cos(2πx/p + φ)`.

use super::displaced::displaced;
use super::readout::enter;
use super::wave::{amplitude_phase_and_shape, wave};
use super::{Class, Effect, Fitted, Line, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// `encoder_error`.
pub struct EncoderError;

impl Effect for EncoderError {
    fn id(&self) -> &'static str {
        form::ENCODER_ERROR.id
    }

    fn name(&self) -> &'static str {
        "encoder interpolation error"
    }

    fn words(&self) -> &'static str {
        "interpolation error of the encoder"
    }

    fn class(&self) -> Class {
        Class::Drive
    }

    fn axis(&self) -> Axis {
        Axis::Position
    }

    fn experiment(&self) -> &'static str {
        "creep over several encoder periods within the pre-sliding range, against a reference"
    }

    fn shown_by(&self) -> &'static [Part] {
        &[Part::Nested]
    }

    fn shape(&self) -> &'static [(&'static str, Scale)] {
        &[("period_m", Scale::Period)]
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn line(&self) -> Option<Line> {
        Some(Line::Force)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[period] = shape else {
            return Vec::new();
        };
        wave(&scene.s.x, period)
            .map(|error| displaced(&error, scene.core.mass, scene))
            .to_vec()
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        amplitude_phase_and_shape("error_m", self, fitted)
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &[], model)
    }
}
