//! An outer sample of the predictive controller, its lift and its solver apart: 13 lifted states, 5 moves, as in `track -- koopman`.

use preslide::control::koopman::{
    Ahead, ErrorLift, ErrorLiftState, KoopmanModel, KoopmanMpc, KoopmanSettings, KoopmanState,
};

use crate::checksum::Checksum;
use crate::kernels::{BREAKAWAY, blocks, built};
use crate::motion::{COUNT, Tick};

pub const STATES: usize = 13;
pub const MOVES: usize = 5;
const BLOCKS: usize = 4;
const DELAYS: usize = 4;

/// Ticks of an outer sample.
const TICKS: usize = 20;

pub type Lift = ErrorLift<STATES, BLOCKS, DELAYS>;
pub type LiftState = ErrorLiftState<STATES, BLOCKS>;
pub type Mpc = KoopmanMpc<STATES, MOVES>;
pub type MpcState = KoopmanState<MOVES>;

/// What a sample is told.
pub struct Sample {
    pub error: f32,
    pub travelled: f32,
    pub reference: f32,
    pub force: f32,
    pub ahead: Ahead<MOVES>,
}

/// The following error's row as learnt on the simulated stage over proportional and derivative feedback.
const ERROR: [f64; STATES] = [
    1.369, -0.1183, -0.1945, -0.09126, -4.479e-8, -3.046e-7, -8.983e-8, 1.016e-7, 0.1084, 9.07e-3,
    4.29e-3, 1.82e-3, 1.0,
];

/// That row, shifts, and deflections that follow the error.
fn model() -> KoopmanModel<STATES> {
    let mut map = [[0.0; STATES]; STATES];
    map[0] = ERROR;
    for i in 1..DELAYS {
        map[i][i - 1] = 1.0;
        map[DELAYS + i][DELAYS + i - 1] = 1.0;
    }
    for (i, row) in map.iter_mut().enumerate().skip(2 * DELAYS).take(BLOCKS) {
        (row[0], row[1], row[i]) = (-0.5, 0.5, 0.98);
    }
    map[STATES - 1][STATES - 1] = 1.0;
    let mut force = [0.0; STATES];
    force[DELAYS] = 1.0;
    let mut reference = [0.0; STATES];
    reference[0] = 0.0173;
    KoopmanModel {
        map,
        force,
        reference,
    }
}

pub fn lift() -> Lift {
    let yields = blocks::<BLOCKS>().map(|block| block.yield_displacement(BREAKAWAY));
    built(Lift::try_new(&yields, false, &model(), 0.02))
}

pub fn mpc(iterations: u32) -> Mpc {
    let settings = KoopmanSettings {
        lengths: [1, 1, 2, 4, 8],
        effort: 1e-16,
        change: 1e-13,
        force: 1.5,
        slew: 0.5,
        travel: 10.0,
        iterations,
    };
    built(Mpc::try_new(&model(), &settings))
}

/// Samples along the motion: the axis is where it is, and the reference a few counts ahead of it; the ends of travel are within reach of
/// every fourth.
fn samples(motion: impl Iterator<Item = Tick>) -> impl Iterator<Item = Sample> {
    motion.step_by(TICKS).enumerate().map(|(index, tick)| {
        let travelled = tick.counts as f32 * COUNT as f32;
        let lead = (index % 7) as f32 - 3.0;
        let near = if index % 4 == 0 { 1e-7 } else { f32::INFINITY };
        Sample {
            error: lead * 4.0 * COUNT as f32,
            travelled,
            reference: travelled,
            force: 0.1 * lead,
            ahead: Ahead {
                displacement: [travelled; MOVES],
                below: [near; MOVES],
                above: [near; MOVES],
            },
        }
    })
}

/// Takes and solves every sample; the number of them, and the checksums of lifted states and orders.
pub fn run(
    motion: impl Iterator<Item = Tick>,
    mut take: impl FnMut(&Sample) -> [f32; STATES],
    mut solve: impl FnMut(&Sample, &[f32; STATES]) -> f32,
) -> (usize, [u64; 2]) {
    let (mut lifts, mut orders, mut calls) = (Checksum::new(), Checksum::new(), 0);
    for sample in samples(motion) {
        let lifted = take(&sample);
        lifted.iter().for_each(|entry| lifts.add((*entry).into()));
        orders.add(solve(&sample, &lifted).into());
        calls += 1;
    }
    (calls, [lifts.value(), orders.value()])
}
