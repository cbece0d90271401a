//! What lies between the two tasks.

use crate::{Background, Control, Model};
use core::sync::atomic::{AtomicBool, AtomicU16};
use heapless::spsc::Queue;
use preslide::control::{Coefficients, Controller, Move, Settings};
use preslide::{Friction, ParamError};
use preslide_link::Sample;

/// A change of the controller between two ticks.
// The large variant is copied once when it is swapped in; there is no heap to box it in.
#[allow(clippy::large_enum_variant)]
pub enum Change<F: Friction> {
    /// New parameters.
    Swap(Coefficients<F>),
    /// Leave the safe state.
    Restart,
}

/// The queues; one capacity is used up by the queue itself.
pub struct Queues<F: Friction> {
    moves: Queue<Move, 9>,
    changes: Queue<Change<F>, 3>,
    /// 3 ms of telemetry at 20 kHz.
    samples: Queue<Sample, 65>,
    stopped: AtomicBool,
    heard: AtomicBool,
    every: AtomicU16,
}

impl<F: Friction> Queues<F> {
    /// Empty ones.
    pub const fn new() -> Self {
        Self {
            moves: Queue::new(),
            changes: Queue::new(),
            samples: Queue::new(),
            stopped: AtomicBool::new(true),
            heard: AtomicBool::new(false),
            every: AtomicU16::new(1),
        }
    }

    /// Both tasks, with the controller at the counter's reading `first` and telemetry from every `every`-th tick.
    ///
    /// # Errors
    /// The first setting or parameter that is not usable.
    pub fn tasks<M: Model<Friction = F>>(
        &'static mut self,
        settings: Settings,
        model: M,
        first: u32,
        every: u16,
    ) -> Result<(Control<F>, Background<M>), ParamError> {
        *self.every.get_mut() = every;
        let friction = model.build(settings.sample_time())?;
        let coefficients = Coefficients::try_new(&settings, friction, M::UNITS)?;
        let (moves_in, moves) = self.moves.split();
        let (changes_in, changes) = self.changes.split();
        let (samples, samples_out) = self.samples.split();
        Ok((
            Control {
                controller: Controller::new(coefficients, first),
                moves,
                changes,
                samples,
                stopped: &self.stopped,
                heard: &self.heard,
                every: &self.every,
                since: 0,
                tick: 0,
                sequence: 0,
                dropped: 0,
            },
            Background::new(
                settings,
                model,
                moves_in,
                changes_in,
                samples_out,
                &self.stopped,
                &self.heard,
                &self.every,
            ),
        ))
    }
}

impl<F: Friction> Default for Queues<F> {
    fn default() -> Self {
        Self::new()
    }
}
