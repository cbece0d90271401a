//! `A·sin(q − q0)` about a rotary axis.

use super::wave::amplitude_and_phase;
use super::{BARE, Card, Class, Effect, Fitted, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::expr::Function::Sin;
use crate::diagnose::signals::Signals;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::signal::ONE_SLOPE_RAD;
use preslide_fit::statistics::Estimate;

/// Key of the amplitude, `torque_Nm` on the rotary axes that it is for.
const AMPLITUDE: &str = "force_N";
/// Key of the angle at which its force is zero and rising.
const ANGLE: &str = "angle_rad";

/// `gravity`.
pub struct Gravity;

static CARD: Card = Card {
    id: form::GRAVITY.id,
    name: "gravity",
    words: "the weight of an arm or an unbalanced rotor: one wave a turn",
    class: Class::Plain,
    axis: Axis::Position,
    experiment: "slow passes over half a turn or more, and again with the axis of rotation upright, where gravity is gone",
    shown_by: &[Part::Passes],
    lacks: |s| is_one_slope(s).then_some("travel of a radian or more"),
    formula: Some(|stated| Some(stated.get("force_N")? * stated.past("angle_rad")?.of(Sin))),
    ..BARE
};

impl Effect for Gravity {
    fn card(&self) -> &Card {
        &CARD
    }

    fn equivalents(&self, s: &Signals) -> Vec<&'static str> {
        if is_one_slope(s) {
            vec![form::POSITION_SPRING.id]
        } else {
            Vec::new()
        }
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        scene.s.rotary.then(Vec::new).into_iter().collect()
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        let q = &scene.s.x;
        vec![scene.force(|i| q[i].sin()), scene.force(|i| q[i].cos())]
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        // `a·sin q + b·cos q = A·sin(q − q0)` with `q0 = atan2(−b, a)`.
        amplitude_and_phase(AMPLITUDE, ANGLE, fitted)
    }
}

/// Whether an axis turns by less than a radian, over which gravity and a spring are one slope.
pub(super) fn is_one_slope(s: &Signals) -> bool {
    s.rotary && s.travel() < ONE_SLOPE_RAD
}
