//! `d·abs(v)`: viscous friction is `viscous + d` forwards and `viscous − d` backwards.

use super::Range::Any;
use super::{BARE, Form};
use preslide::effects::Situation;

/// `viscous_asymmetry`.
pub(crate) static VISCOUS_ASYMMETRY: Form = Form {
    id: "viscous_asymmetry",
    keys: &[("half_difference_N_s_per_m", Any)],
    library: |effect, _| {
        let half = effect.get("half_difference_N_s_per_m");
        Ok(Some(Box::new(move |at: &Situation<f64>| {
            (0.0, half * at.velocity.abs())
        })))
    },
    controller: Err(
        "the controller's library has no viscous friction of each direction yet; without it the mean of both is left, viscous of [friction]",
    ),
    ..BARE
};
