//! The firmware's control task on a simulated axis: moves that a host asks for over the link, back and forth, in closed loop.
//!
//! The axis is that of the paper, in nothing but additions, multiplications and divisions of `f64`, so that every processor simulates
//! the same one.

use core::convert::Infallible;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use heapless::spsc::Queue;
use preslide::control::Axis;
use preslide::{Friction, Motion, QuasiStaticGms, QuasiStaticState, Units};
use preslide_app::{Bridge, Control, Inputs, Model, Queues, RECEIVED, SENT, Start};
use preslide_link::{LARGEST_FRAME, Numbered, Request, ResetCause, encode};
use preslide_store::Slots;

use crate::checksum::Checksum;
use crate::kernels::{BREAKAWAY, blocks, built};
use crate::motion::{COUNT, SAMPLE_TIME};

/// Tick of the order that enables the axis, of the first move, and from one move to the next, which ends in between.
const ENABLED: usize = 40;
const FIRST_MOVE: usize = 60;
const NEXT_MOVE: usize = 450;

/// A move \[m\], \[m/s\], \[s\].
const DISTANCE: f32 = 60e-6;
const SPEED: f32 = 5e-3;
const RAMP: f32 = 5e-3;

/// The interrupt's work: the control task and its bridge.
pub struct Task<M: Model> {
    control: Control<M::Friction>,
    duty: Duty,
}

impl<M: Model> Task<M> {
    #[inline(always)]
    pub fn tick(&mut self, inputs: &Inputs) -> i32 {
        self.control.tick(*inputs, &mut self.duty);
        self.duty.0
    }
}

/// A bridge that takes one store: the last code.
#[derive(Default)]
struct Duty(i32);

impl Bridge for Duty {
    #[inline(always)]
    fn drive(&mut self, code: i32) {
        self.0 = code;
    }

    #[inline(always)]
    fn open(&mut self) {
        self.0 = 0;
    }

    #[inline(always)]
    fn is_broken(&mut self) -> bool {
        false
    }
}

/// Mass, winding and Maxwell-slip friction in the tick's steps.
struct Plant {
    position: f64,
    velocity: f64,
    current: f64,
    friction: QuasiStaticGms<4, f64>,
    memory: QuasiStaticState<4, f64>,
}

impl Plant {
    fn new() -> Self {
        let friction = built(QuasiStaticGms::try_new(&blocks(), BREAKAWAY, Units::SI));
        Self {
            position: 0.0,
            velocity: 0.0,
            current: 0.0,
            memory: friction.at_rest(),
            friction,
        }
    }

    fn inputs(&self) -> Inputs {
        // Away from zero, where the conversion's rounding turns.
        let count = (self.position / COUNT + 1e6) as i32 - 1_000_000;
        Inputs {
            count: count.cast_unsigned(),
            index: None,
            supply: (SUPPLY * 1e3) as u16,
            current: (self.current * 1e4) as i16,
            late: false,
        }
    }

    fn tick(&mut self, code: i32) {
        let voltage = SUPPLY * f64::from(code) / f64::from(AXIS.hardware.steps);
        self.current = (voltage - NEWTONS_PER_AMPERE * self.velocity) / AXIS.motor.resistance;
        let motion = Motion::quasi_static(self.velocity * SAMPLE_TIME);
        let friction = self.friction.step(&mut self.memory, motion);
        let force = NEWTONS_PER_AMPERE * self.current - friction;
        self.velocity += force / AXIS.feed_forward.mass * SAMPLE_TIME;
        self.position += self.velocity * SAMPLE_TIME;
    }
}

const AXIS: Axis = Axis::PAPER_AXIS;

/// \[V\].
const SUPPLY: f64 = 6.0;

const NEWTONS_PER_AMPERE: f64 =
    AXIS.motor.torque_constant * core::f64::consts::TAU / AXIS.motor.screw_lead;

/// Runs `ticks` of the task, each through `tick`; returns the checksum of its codes.
pub fn run<M: Model>(
    model: M,
    queues: &'static mut Queues<M::Friction>,
    ticks: usize,
    mut tick: impl FnMut(&Inputs, &mut Task<M>) -> i32,
) -> u64 {
    let start = Start {
        axis: AXIS,
        model,
        saved: None,
        count: 0,
        every: 1,
        reset: ResetCause::Power,
    };
    let (control, mut background) = built(queues.tasks(start));
    let mut task = Task {
        control,
        duty: Duty::default(),
    };
    let (mut line, mut back) = (Queue::<u8, RECEIVED>::new(), Queue::<u8, SENT>::new());
    let ((mut ask, mut asked), (mut answer, mut answered)) = (line.split(), back.split());
    let mut plant = Plant::new();
    let mut checksum = Checksum::new();
    let (mut number, mut farthest) = (0, 0.0_f64);
    for now in 0..ticks {
        if let Some(request) = request(now) {
            let mut frame = [0; LARGEST_FRAME];
            let length = encode(
                &Numbered {
                    id: number,
                    request,
                },
                &mut frame,
            )
            .unwrap_or(0);
            for byte in &frame[..length] {
                let _ = ask.enqueue(*byte);
            }
            number += 1;
        }
        let code = tick(&plant.inputs(), &mut task);
        plant.tick(code);
        checksum.add_whole(code);
        farthest = farthest.max(plant.position);
        background.poll(&mut asked, &mut answer, &mut None::<Slots<NoFlash>>);
        while answered.dequeue().is_some() {}
    }
    assert!(
        farthest > 0.9 * f64::from(DISTANCE),
        "the axis did not move"
    );
    checksum.value()
}

fn request(now: usize) -> Option<Request> {
    if now == ENABLED {
        return Some(Request::Enable);
    }
    let since = now.checked_sub(FIRST_MOVE)?;
    let forth = (since / NEXT_MOVE).is_multiple_of(2);
    since.is_multiple_of(NEXT_MOVE).then_some(Request::Move {
        distance_m: if forth { DISTANCE } else { -DISTANCE },
        speed_m_s: SPEED,
        ramp_s: RAMP,
    })
}

/// Nothing is saved.
struct NoFlash;

impl ErrorType for NoFlash {
    type Error = Infallible;
}

impl ReadNorFlash for NoFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _offset: u32, _into: &mut [u8]) -> Result<(), Infallible> {
        Ok(())
    }

    fn capacity(&self) -> usize {
        0
    }
}

impl NorFlash for NoFlash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 8;

    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), Infallible> {
        Ok(())
    }

    fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), Infallible> {
        Ok(())
    }
}
