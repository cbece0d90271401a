//! A simulation that moved by itself, reproduced by a model: two motions say that they differ, not by which force, so that what the
//! simulation would have needed for the recorded motion comes from a model of the simulation.

use super::effect::ALWAYS_FREE;
use super::fit::Known;
use super::modelled::effort_of;
use super::term::{Subject, Term};
use super::weak::Column;
use super::{Refusal, judge};
use crate::effects::Effect;
use crate::model::Model;
use crate::progress::Progress;
use crate::recording::Recording;

/// Share of the mismatch that the reproduction may miss of the simulation: half, or less of it might be the machine's than the reproduction's.
/// (A quarter refused EMPS's simulation without its offset, which is truly missing.)
const MISSED: f64 = 0.5;

/// The model of a simulation.
#[derive(Clone, Debug)]
pub struct Reproduced {
    /// Inertia, friction and effects that the simulation's own motion and effort show.
    pub model: Model,
    /// What it leaves of the simulation's own effort (%).
    pub nmse: f64,
}

impl Reproduced {
    /// Diagnoses the simulation as if it were a machine: `own` is its motion under its effort.
    ///
    /// # Errors
    /// [`Refusal`], where its motion does not tell.
    pub fn of(own: &Recording, progress: &Progress) -> Result<Self, Refusal> {
        let found = judge(own, None, &Known::default(), None, progress)?;
        let model = found.extended_model(own, None).model;
        let rows = &found.ground.rows;
        let modelled = rows
            .weak
            .rows(&effort_of(&model, own).map_err(Refusal::Data)?);
        let mut left: Vec<f64> = rows
            .force
            .iter()
            .zip(modelled)
            .map(|(f, m)| f - m)
            .collect();
        // A solver of fixed steps delays its motion by a part of a step, which is no force.
        let delay = Term::new(Subject::Effect(ALWAYS_FREE), &[]);
        for column in found.ground.columns(&delay).iter() {
            let square: f64 = column.iter().map(|c| c * c).sum();
            let product: f64 = column.iter().zip(&left).map(|(c, l)| c * l).sum();
            let part = product / square.max(1e-300);
            left.iter_mut()
                .zip(column)
                .for_each(|(l, c)| *l -= part * c);
        }
        let nmse = rows.nmse(&left);
        Ok(Self { model, nmse })
    }

    /// The effort that the simulation needs for the recorded motion.
    ///
    /// # Errors
    /// [`Refusal`], where the simulation has an effect of what was not recorded.
    pub fn effort(&self, recording: &Recording) -> Result<Column, Refusal> {
        effort_of(&self.model, recording).map_err(Refusal::Data)
    }

    /// What stands for the simulation, and how well: a sentence without its full stop.
    pub fn words(&self, recording: &Recording) -> String {
        let model = &self.model;
        let plain = [
            ("inertia", model.inertia),
            ("viscous friction", model.viscous),
            ("a constant force", model.constant_force),
        ];
        let plain = plain.into_iter().filter(|p| p.1 != 0.0).map(|p| p.0);
        let named = model.effects.iter().map(Effect::id);
        let parts: Vec<&str> = std::iter::once("hysteresis")
            .chain(plain)
            .chain(named)
            .collect();
        format!(
            "from its own motion, the simulation is reproduced by {}, which miss {:.3} % of the variance of its {}",
            parts.join(", "),
            self.nmse,
            recording.role.name()
        )
    }

    /// Whether it misses too much of the simulation for a mismatch of this NMSE (%) to be the machine's.
    pub fn misses_too_much(&self, mismatch: f64) -> bool {
        self.nmse > MISSED * mismatch
    }
}
