//! A simulation that moved by itself, reproduced by core and effects: two motions say that they differ, not by which force, so that what the
//! simulation would have needed for the recorded motion comes from what its own motion shows of it.

use super::effect::{ALWAYS_FREE, Baseline, Scene};
use super::null_model::{Hypothesis, NullModel};
use super::rows::Rows;
use super::term::{Subject, Term};
use super::weak::Column;
use super::{Refusal, judge};
use preslide_fit::progress::Progress;
use preslide_fit::recording::Recording;

/// Share of the mismatch that the reproduction may miss of the simulation: half, or less of it might be the machine's than the reproduction's.
/// (A quarter refused EMPS's simulation without its offset, which is truly missing.)
const MISSED: f64 = 0.5;

/// What stands for a simulation.
pub struct Reproduced {
    /// The simulation as if it were a machine: its rows and friction, and the inertia and effects that its own motion and effort show.
    null: NullModel,
    state: Hypothesis,
    named: Vec<&'static str>,
    /// What they leave of the simulation's own effort (%) on stretches held out.
    pub nmse: f64,
}

impl Reproduced {
    /// Diagnoses the simulation as if it were a machine: `own` is its motion under its effort.
    ///
    /// # Errors
    /// [`Refusal`], where its motion does not show it.
    pub fn of(own: &Recording, progress: &Progress) -> Result<Self, Refusal> {
        let found = judge(own, None, None, None, progress)?;
        let named = found.confident().map(|e| e.id()).collect();
        let (null, [_, state]) = (found.null, found.states);
        let rows = &null.rows;
        let mut left = state.held_out_residual(rows);
        // A solver of fixed steps delays its motion by a part of a step, which is no force.
        let delay = Term::new(Subject::Effect(ALWAYS_FREE), &[]);
        for column in null.columns(&delay).iter() {
            let square: f64 = column.iter().map(|c| c * c).sum();
            let product: f64 = column.iter().zip(&left).map(|(c, l)| c * l).sum();
            let part = product / square.max(1e-300);
            let taken = left.iter_mut().zip(column);
            taken.for_each(|(l, c)| *l -= part * c);
        }
        let nmse = rows.nmse(&left);
        Ok(Self {
            nmse,
            null,
            state,
            named,
        })
    }

    /// The effort that the simulation needs for the recorded motion.
    ///
    /// # Errors
    /// [`Refusal`], where the recording has no motion to show it.
    pub fn effort(&self, recording: &Recording) -> Result<Column, Refusal> {
        let (null, state) = (&self.null, &self.state);
        let rows = Rows::new(recording, &[]).map_err(Refusal::Data)?;
        let core = null.core.moved(&rows);
        let coefficients = &state.normal.coefficients;
        let baseline = core.baseline(&rows, coefficients, &[], &Baseline::default());
        // An effect is of the simulation's friction level, however much of it this motion uses.
        let baseline = Baseline {
            level: null.baseline.level,
            ..baseline
        };
        let scene = Scene {
            s: &rows.s,
            core: &baseline,
            effort: &rows.effort,
        };
        let mut whole = Column {
            value: baseline.friction.clone(),
            sloped: vec![0.0; rows.s.x.len()],
            curved: rows.s.x.iter().map(|x| baseline.mass * x).collect(),
        };
        for (index, term) in state.terms.iter().enumerate() {
            let columns = term.columns(&scene);
            for (column, c) in columns.iter().zip(state.coefficients(index)) {
                add(&mut whole.value, &column.value, *c);
                add(&mut whole.sloped, &column.sloped, *c);
                add(&mut whole.curved, &column.curved, *c);
            }
        }
        Ok(whole)
    }

    /// What stands for the simulation, and how well: a sentence without its full stop.
    pub fn words(&self, recording: &Recording) -> String {
        let core = match self.null.core.follows_velocity() {
            true => "hysteresis, friction that reverses smoothly with velocity",
            false => "hysteresis",
        };
        let named = self.named.iter().copied();
        let parts: Vec<&str> = ["inertia", core].into_iter().chain(named).collect();
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

fn add(sum: &mut [f64], column: &[f64], times: f64) {
    let both = sum.iter_mut().zip(column);
    both.for_each(|(s, c)| *s += times * c);
}
