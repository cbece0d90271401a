//! The queues, and the two tasks at their ends.

use crate::queues::{Order, Planned, Shared, Status};
use crate::telemetry::Samples;
use crate::{Background, Control, Model, Parameters, ROOM};
use core::sync::atomic::{AtomicBool, AtomicU16};
use heapless::spsc::Queue;
use preslide::control::{Axis, Coefficients, Controller, Planner};
use preslide::{Friction, ParamError};
use preslide_link::ResetCause;

/// The queues; one capacity is used up by the queue itself.
pub struct Queues<F: Friction> {
    moves: Queue<Planned, { ROOM as usize + 1 }>,
    orders: Queue<Order<F>, 3>,
    statuses: Queue<Status, 5>,
    shared: Shared,
}

/// What a controller starts with.
pub struct Start<M> {
    /// What was compiled in.
    pub axis: Axis,
    /// The friction model.
    pub model: M,
    /// What was saved, if it could be read.
    pub saved: Option<Parameters>,
    /// The counter's reading.
    pub count: u32,
    /// Telemetry from every so many ticks.
    pub every: u16,
    /// What the board was reset by.
    pub reset: ResetCause,
}

impl<F: Friction> Queues<F> {
    /// Empty ones.
    pub const fn new() -> Self {
        Self {
            moves: Queue::new(),
            orders: Queue::new(),
            statuses: Queue::new(),
            shared: Shared {
                calls: AtomicBool::new(false),
                heard: AtomicBool::new(false),
                every: AtomicU16::new(1),
                samples: Samples::new(),
            },
        }
    }

    /// Both tasks. What was saved rules over what was compiled in, where it is usable.
    ///
    /// # Errors
    /// The first setting or parameter, of those compiled in, that is not usable.
    pub fn tasks<M: Model<Friction = F>>(
        &'static mut self,
        start: Start<M>,
    ) -> Result<(Control<F>, Background<M>), ParamError> {
        *self.shared.every.get_mut() = start.every;
        let built = |axis: &Axis, model: &M| {
            let friction = model.build(axis.sample_time())?;
            Coefficients::try_new(axis, friction, M::UNITS)
        };
        let saved = start
            .saved
            .map(|saved| saved.over(&start.axis, &start.model))
            .and_then(|(axis, model)| Some((built(&axis, &model).ok()?, axis, model)));
        let is_saved = saved.is_some();
        let (coefficients, axis, model) = match saved {
            Some(saved) => saved,
            None => (built(&start.axis, &start.model)?, start.axis, start.model),
        };
        let planner = Planner::try_new(&axis)?;
        let (moves_in, moves) = self.moves.split();
        let (orders_in, orders) = self.orders.split();
        let (statuses, statuses_out) = self.statuses.split();
        let controller = Controller::new(coefficients, start.count);
        let control = Control::new(controller, moves, orders, statuses, &self.shared);
        let background = Background {
            log: crate::log::Log::default(),
            deframer: preslide_link::Deframer::new(),
            answered: preslide_link::Answered::new(),
            axis,
            model,
            staged: None,
            planner,
            reset: start.reset,
            saved: is_saved,
            epoch: 0,
            streaming: false,
            moves_sent: 0,
            orders_sent: 0,
            pending: None,
            status: control.status(),
            moves: moves_in,
            orders: orders_in,
            statuses: statuses_out,
            shared: &self.shared,
        };
        Ok((control, background))
    }
}

impl<F: Friction> Default for Queues<F> {
    fn default() -> Self {
        Self::new()
    }
}
