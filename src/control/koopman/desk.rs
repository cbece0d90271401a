//! What lies between the control task and the outer one.

use super::Guided;
use crate::control::reference::saturate;
use crate::control::{Controller, Move, Pace, Reference};
use crate::{Count, Friction};

/// Samples that wait for an outer task that is late.
const KEPT: usize = 4;

/// Late runs in a row after which the outer task gives way for a sample.
const GIVES_WAY: u8 = 2;

/// A sample, as the control task tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Told {
    /// No order has come since the axis was enabled: the outer task begins anew.
    pub first: bool,
    /// The following error (2⁻¹⁶ counts).
    pub error: i32,
    /// What axis and reference travelled since the last sample (m or rad).
    pub travelled: [f32; 2],
    /// The force that counts from here on (N or N·m).
    pub force: f32,
}

/// Samples on their way to the outer task, the reference as it is, and the order on its way back.
///
/// The control task waits for nobody ([`Desk::attend`]); the outer task, which it interrupts, holds the desk for as long as it takes to
/// copy ([`super::Outer::take`]), and while it solves holds nothing. An order that comes when its sample is over is thrown away. After two
/// late ones in a row the outer task is not started for a sample, so that what runs below it goes on.
#[derive(Clone, Debug)]
pub struct Desk {
    /// Samples told and taken since the start.
    told: u32,
    taken: u32,
    samples: [Told; KEPT],
    /// As the last sample told found it, with what is planned behind it.
    reference: Reference,
    next: Option<Move>,
    pace: Pace,
    /// The sample that it answers, and the force.
    order: Option<(u32, f32)>,
    /// The sample that the outer task was started for last, the last one that it answered, and how often in a row it was late.
    started: u32,
    answered: u32,
    late: u8,
}

impl Desk {
    /// An empty one beside a controller.
    pub fn new<F: Friction, C: Count>(controller: &Controller<F, C>) -> Self {
        Self {
            told: 0,
            taken: 0,
            samples: [Told::default(); KEPT],
            reference: controller.followed().clone(),
            next: None,
            pace: *controller.pace(),
            order: None,
            started: 0,
            answered: 0,
            late: 0,
        }
    }

    /// For the control task, after every tick: hands on the order that has come in time; where a sample has begun, tells it, with the move
    /// that is to follow the running one. Whether the outer task is to be started.
    #[inline]
    pub fn attend<F: Friction<Scalar = f32>, C: Count>(
        &mut self,
        controller: &mut Controller<Guided<F>, C>,
        next: impl FnOnce() -> Option<Move>,
    ) -> bool {
        let state = controller.friction_state();
        if state.is_due() {
            self.tell(controller, next());
            return self.starts();
        }
        if let Some((of, force)) = self.order.take()
            && of == self.told
        {
            state.order(force);
        }
        false
    }

    fn tell<F: Friction<Scalar = f32>, C: Count>(
        &mut self,
        controller: &mut Controller<Guided<F>, C>,
        next: Option<Move>,
    ) {
        self.order = None;
        if self.told.wrapping_sub(self.taken) < KEPT as u32 {
            let error = controller.reference() - (controller.position() << 16);
            let state = controller.friction_state();
            self.samples[self.told as usize % KEPT] = Told {
                first: !state.is_guided(),
                error: saturate(error),
                travelled: state.travelled(),
                force: state.force(),
            };
            self.told = self.told.wrapping_add(1);
        }
        self.reference.become_as(controller.followed());
        self.pace.clone_from(controller.pace());
        self.next = next;
    }

    fn starts(&mut self) -> bool {
        let in_time = self.answered.wrapping_sub(self.started).cast_signed() >= 0;
        self.late = if in_time { 0 } else { self.late + 1 };
        let starts = self.late < GIVES_WAY;
        if starts {
            self.started = self.told;
        } else {
            self.late = 0;
        }
        starts
    }

    /// For the outer task: the oldest sample that waits.
    pub(super) fn take(&mut self) -> Option<Told> {
        if self.taken == self.told {
            return None;
        }
        let sample = self.samples[self.taken as usize % KEPT];
        self.taken = self.taken.wrapping_add(1);
        Some(sample)
    }

    /// The reference, what follows it, and its pace.
    pub(super) fn reference(&self) -> (&Reference, Option<Move>, &Pace) {
        (&self.reference, self.next, &self.pace)
    }

    /// The last sample that was told: an order names it.
    pub fn sample(&self) -> u32 {
        self.told
    }

    /// For the outer task: its answer to that sample (N or N·m).
    pub fn order(&mut self, sample: u32, force: f32) {
        self.order = Some((sample, force));
        self.answered = sample;
    }
}
