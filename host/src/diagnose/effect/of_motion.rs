//! Effects that are no more than a card and a force of the motion.

use super::lack::several_speeds;
use super::{BARE, Card, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::normal::Bound;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;

/// An effect of one coefficient.
pub struct OfMotion {
    pub(super) card: Card,
    /// The force at a sample for a coefficient of one.
    pub(super) force: fn(&Signals, usize) -> f64,
}

/// What the cards of forces of velocity share.
pub(super) const OF_VELOCITY: Card = Card {
    axis: Axis::Velocity,
    shown_by: &[Part::Speeds],
    lacks: several_speeds,
    ..BARE
};

impl Effect for OfMotion {
    fn card(&self) -> &Card {
        &self.card
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![scene.force(|i| (self.force)(scene.s, i))]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        self.card.bound == Bound::Free || matches!(coefficients, [c] if *c > 0.0)
    }
}
