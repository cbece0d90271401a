//! The lifted state of an axis in its control loop.

use super::KoopmanModel;
use crate::param::{ParamError, at_most, nearest, not_negative, positive};

/// ```text
/// ψ = [e_k … e_{k−D+1}, u_k … u_{k−D+1}, z_1 … z_N, d]
/// ```
/// The following error and the outer forces with their delays, in which the loop's velocity and the drive's mode are; the deflections of
/// the identified Maxwell-slip blocks, `z ← clamp(z + Δx, ±D)`, in which the friction is; and the error per sample `d` that the map did
/// not foresee, `d ← d + g·(e − ê)`, which is held over the horizon and without which a force that nobody learnt would leave an offset
/// (Maeder, Borrelli, Morari, *Linear offset-free model predictive control*, Automatica 45, 2009). `D` is `DELAYS`, `N` `BLOCKS`,
/// `STATES = 2·D + N + 1`.
///
/// `u_k` is the order that counts from this sample on, given in the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorLift<const STATES: usize, const BLOCKS: usize, const DELAYS: usize> {
    yields: [f32; BLOCKS],
    /// The loop compensates the blocks along the reference: what remains is how far theirs are ahead.
    compensated: bool,
    /// The first row of the map, and what the reference adds to it.
    foreseen: [f32; STATES],
    reference: f32,
    gain: f32,
}

/// What an [`ErrorLift`] remembers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorLiftState<const STATES: usize, const BLOCKS: usize> {
    lifted: [f32; STATES],
    /// Along the measured motion and along the reference.
    measured: [f32; BLOCKS],
    wanted: [f32; BLOCKS],
}

impl<const STATES: usize, const BLOCKS: usize, const DELAYS: usize>
    ErrorLift<STATES, BLOCKS, DELAYS>
{
    /// Of blocks with the `yields` `D_i` (m or rad) and the gain `g` of what the map did not foresee (-), 0…1.
    ///
    /// # Errors
    /// [`ParamError`] where a value is not finite or out of range.
    pub fn try_new(
        yields: &[f64; BLOCKS],
        compensated: bool,
        model: &KoopmanModel<STATES>,
        gain: f64,
    ) -> Result<Self, ParamError> {
        const { assert!(DELAYS > 0 && STATES == 2 * DELAYS + BLOCKS + 1) };
        let mut lift = Self {
            yields: [0.0; BLOCKS],
            compensated,
            foreseen: [0.0; STATES],
            reference: nearest("map of the reference", model.reference[0])?,
            gain: nearest("gain", at_most("gain", not_negative("gain", gain)?, 1.0)?)?,
        };
        for (to, from) in lift.yields.iter_mut().zip(yields) {
            *to = nearest("yield displacement", positive("yield displacement", *from)?)?;
        }
        for (to, from) in lift.foreseen.iter_mut().zip(&model.map[0]) {
            *to = nearest("map of the error", *from)?;
        }
        Ok(lift)
    }

    /// At rest, on the reference.
    pub const fn at_rest(&self) -> ErrorLiftState<STATES, BLOCKS> {
        ErrorLiftState {
            lifted: [0.0; STATES],
            measured: [0.0; BLOCKS],
            wanted: [0.0; BLOCKS],
        }
    }

    /// Takes a sample: the following `error` (m or rad), what axis and reference travelled since the last one, and the force that counts
    /// from here on (N or N·m).
    pub fn take<'a>(
        &self,
        state: &'a mut ErrorLiftState<STATES, BLOCKS>,
        error: f32,
        travelled: f32,
        reference: f32,
        force: f32,
    ) -> &'a [f32; STATES] {
        let lifted = &mut state.lifted;
        let mut foreseen = self.reference * reference;
        for (weight, entry) in self.foreseen.iter().zip(lifted.iter()) {
            foreseen += weight * entry;
        }
        lifted.copy_within(0..DELAYS - 1, 1);
        lifted[0] = error;
        lifted.copy_within(DELAYS..2 * DELAYS - 1, DELAYS + 1);
        lifted[DELAYS] = force;
        for (i, most) in self.yields.iter().enumerate() {
            let clamped = |z: f32| z.clamped(*most);
            state.measured[i] = clamped(state.measured[i] + travelled);
            state.wanted[i] = clamped(state.wanted[i] + reference);
            lifted[2 * DELAYS + i] = if self.compensated {
                state.wanted[i] - state.measured[i]
            } else {
                state.measured[i]
            };
        }
        let missed = lifted[STATES - 1] + self.gain * (error - foreseen);
        lifted[STATES - 1] = if missed.is_finite() { missed } else { 0.0 };
        lifted
    }
}

trait Clamped {
    fn clamped(self, most: Self) -> Self;
}

impl Clamped for f32 {
    /// NaN counts as no deflection.
    fn clamped(self, most: f32) -> f32 {
        if self > most {
            most
        } else if self >= -most {
            self
        } else if self < -most {
            -most
        } else {
            0.0
        }
    }
}
