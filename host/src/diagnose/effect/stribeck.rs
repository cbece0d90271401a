//! `m = 1 + a·exp(−(|v|/v_s)^δ)`.

use super::grid::falling;
use super::lack::several_speeds;
use super::readout::enter;
use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::{Abs, Exp};
use crate::diagnose::expr::Input::{Slipping, Velocity};
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::statistics::Estimate;

/// Place of the exponent in the shape.
pub(super) const EXPONENT: usize = 1;
/// Largest level of the curve, static friction three times the sliding one: beyond it the falling curve and a viscous force cancel
/// each other over the speeds recorded.
pub(super) const STEEPEST: f64 = 2.0;

/// `stribeck`.
pub struct Stribeck;

static CARD: Card = Card {
    id: form::STRIBECK.id,
    name: "Stribeck effect",
    words: "friction that falls with speed at low speed",
    class: Class::Law,
    axis: Axis::Speed,
    experiment: "rests of 0.1, 1 and 10 s before slow moves at several speeds",
    shown_by: &[Part::Speeds],
    coefficient: "level",
    shape: &[
        ("velocity_m_s", Scale::Logarithmic),
        ("exponent", Scale::Logarithmic),
        ("slipping_only", Scale::Chosen),
    ],
    lacks: several_speeds,
    formula: Some(|stated| {
        let slow = 1.0 / stated.get("velocity_m_s")? * Expr::from(Velocity).of(Abs);
        let slow = slow.power(stated.get("exponent")?);
        let fallen = stated.get("level")? * (-1.0 * slow).of(Exp);
        Some(match stated.get("slipping_only") {
            Some(only) if only > 0.5 => stated.level * Expr::from(Slipping) * fallen,
            _ => stated.friction(fallen),
        })
    }),
    ..BARE
};

impl Effect for Stribeck {
    fn card(&self) -> &Card {
        &CARD
    }

    fn excludes(&self, _: &[f64]) -> Vec<&'static str> {
        vec![form::FRICTIONAL_LAG.id]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        falling(scene.s, 8)
            .into_iter()
            .flat_map(|v| [(1.0, 0.0), (2.0, 0.0), (1.0, 1.0)].map(|(e, only)| vec![v, e, only]))
            .collect()
    }

    fn within(&self, _: &Scene, shape: &[f64], index: usize) -> f64 {
        let value = shape[index];
        if index == EXPONENT {
            exponent(value)
        } else {
            value
        }
    }

    fn storable(&self, shape: &[f64]) -> Vec<f64> {
        storable(shape)
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[velocity, exponent, slipping_only] = shape else {
            return Vec::new();
        };
        let curve = |i: usize| falls(scene.s.v[i], velocity, exponent);
        vec![if slipping_only > 0.5 {
            scene.force(|i| scene.core.slipping[i] * curve(i))
        } else {
            scene.friction(curve)
        }]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if (0.0..STEEPEST).contains(c))
    }

    fn in_model(&self, model: &Model) -> Vec<Vec<f64>> {
        let listed = model.effects.iter().filter(|e| e.id() == self.id());
        let mut shapes: Vec<Vec<f64>> = listed.map(|e| self.shape_in(e, model)).collect();
        if let FrictionModel::Gms {
            sliding: Some(sliding),
            ..
        }
        | FrictionModel::LuGre { sliding, .. } = &model.friction
            && sliding.coulomb > 0.0
        {
            shapes.push(vec![
                sliding.stribeck_velocity,
                sliding.stribeck_exponent,
                0.0,
            ]);
        }
        shapes
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        enter(self.id(), values, &["slipping_only"], model)
    }
}

/// `exp(−(|v|/v_s)^δ)`.
pub(super) fn falls(v: f64, velocity: f64, exponent: f64) -> f64 {
    (-(v.abs() / velocity).powf(exponent)).exp()
}

/// An exponent that a recording can separate from others.
pub(super) fn exponent(value: f64) -> f64 {
    value.clamp(0.5, 3.0)
}

/// The exponents that the library tabulates are 1 and above.
pub(super) fn storable(shape: &[f64]) -> Vec<f64> {
    let mut shape = shape.to_vec();
    if let Some(exponent) = shape.get_mut(EXPONENT) {
        *exponent = exponent.max(1.0);
    }
    shape
}
