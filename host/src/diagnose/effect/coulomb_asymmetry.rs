//! `m = 1 + a·sgn F`, which is `sgn v` in sliding.

use super::lack::both_directions;
use super::{BARE, Card, Class, Effect, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Expr;
use crate::diagnose::expr::Function::Tanh;
use crate::diagnose::expr::Input::Direction;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// Share of the friction level over which its sign changes.
const SMALL: f64 = 0.1;

/// `coulomb_asymmetry`.
pub struct CoulombAsymmetry;

static CARD: Card = Card {
    id: form::COULOMB_ASYMMETRY.id,
    name: "friction that differs by direction",
    words: "friction that differs by direction",
    class: Class::Plain,
    axis: Axis::Velocity,
    experiment: "turn the stage end for end, or change the load: an asymmetry scales with the friction level",
    coefficient: "asymmetry",
    lacks: both_directions,
    formula: Some(|stated| {
        let side = (1.0 / SMALL * Expr::from(Direction)).of(Tanh);
        Some(stated.friction(stated.get("asymmetry")? * side))
    }),
    ..BARE
};

impl Effect for CoulombAsymmetry {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, _: &Signals) -> Vec<&'static str> {
        vec![form::CONSTANT_FORCE.id]
    }

    /// Two names of one force to every fit: together each would have a part of it.
    fn excludes(&self, _: &[f64]) -> Vec<&'static str> {
        vec![form::CONSTANT_FORCE.id]
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let (friction, level) = (&scene.core.friction, scene.core.level);
        vec![scene.friction(|i| (friction[i] / (SMALL * level)).tanh())]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        // Friction does not push, in neither direction.
        matches!(coefficients, [c] if c.abs() < 1.0)
    }
}
