//! Blocks that stick give way at a rate that grows with the stress (Eyring's sinh): `rate·sinh(F/(share·F_limit))`.

use super::displaced::displaced;
use super::grid::one;
use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// From a rate that rises e-fold with a twentieth of the breakaway force to one that is all but proportional to the force.
const SHARES: [f64; 2] = [0.05, 0.5];
/// Largest stress, half as much again as the friction level at the smallest share: beyond the level blocks slip.
const MOST: f64 = 30.0;

/// `creep`.
pub struct Creep;

static CARD: Card = Card {
    id: form::CREEP.id,
    name: "creep",
    words: "slow motion under a constant force",
    class: Class::Drift,
    axis: Axis::SinceReversal,
    experiment: "holds of 10 s at several forces below breakaway, the controller off",
    shown_by: &[Part::Rests, Part::Speeds],
    coefficient: "rate_m_s",
    shape: &[("share_of_breakaway", Scale::Logarithmic)],
    is_transient: true,
    ..BARE
};

impl Effect for Creep {
    fn card(&self) -> &Card {
        &CARD
    }

    fn grid(&self, _: &Scene) -> Vec<Vec<f64>> {
        one(SHARES[0], SHARES[1], 4)
    }

    fn within(&self, _: &Scene, shape: &[f64], index: usize) -> f64 {
        shape[index].clamp(SHARES[0], SHARES[1])
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[share] = shape else {
            return Vec::new();
        };
        let (s, core) = (scene.s, scene.core);
        let mut crept = vec![0.0; s.x.len()];
        for i in 1..s.x.len() {
            let stress = (core.friction[i - 1] / (share * core.level)).clamp(-MOST, MOST);
            crept[i] = crept[i - 1] + s.dt * stress.sinh();
        }
        vec![displaced(&crept, 0.0, scene)]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }
}
