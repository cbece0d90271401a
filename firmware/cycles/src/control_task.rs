//! What the whole control task costs, called as an interrupt calls it: its work, without the exception around it.

use fixed::types::I16F16;
use preslide::Units;
use preslide::kernels::Whole;
use preslide_app::{Inputs, Model, Queues, Starting};

use crate::alone::Alone;
use crate::closed_loop::{self, Task};
use crate::motion::TICKS;
use crate::spent::Spent;
use crate::stub::Row;

macro_rules! control_task {
    ($kernel:literal, $number:ty) => {{
        type Source = Starting<$number>;
        static QUEUES: Alone<Queues<<Source as Model>::Friction>> = Alone::new(Queues::new());
        // SAFETY: the symbol is this crate's own.
        #[unsafe(export_name = concat!("cycles__", $kernel, "__4"))]
        #[inline(never)]
        extern "C" fn stub(
            inputs: &Inputs,
            task: &mut Task<Source>,
            _displacement: Whole,
            _velocity: Whole,
        ) -> Whole {
            Whole::from_bits(task.tick(inputs))
        }
        let row = Row {
            kernel: $kernel,
            blocks: 4,
            units: Units::SI,
        };
        let mut spent = Spent::default();
        // SAFETY: this line runs once.
        let queues = unsafe { QUEUES.lend() };
        let step = core::hint::black_box(stub as crate::stub::Step<_, _, _>);
        let checksum = closed_loop::run(
            Source::PAPER,
            queues,
            TICKS,
            // SAFETY: a safe function of these types.
            |inputs, task| unsafe { spent.update(step, inputs, task, [Whole::ZERO; 2]) }.to_bits(),
        );
        row.tell([0, size_of::<Task<Source>>()], 0.0, checksum);
        row.print_measured::<Task<Source>>(&spent, None);
    }};
}

pub fn run() {
    control_task!("control_task_f32", f32);
    control_task!("control_task_i16f16", I16F16);
}
