//! Koopman model predictive control as an outer task over the production controller, and what it is worth beside its rivals.

mod contender;
mod firmware;
mod learnt;
mod outer;
mod predictive;
#[cfg(test)]
mod tests;
mod verdict;

pub use contender::{Contender, Known};
pub use firmware::{FirmwareSettings, FirmwareTask, firmware, source};
pub use learnt::{Learnt, learn};
pub use verdict::{Verdict, print, study};

/// Ticks of an outer sample: 1 ms at 20 kHz.
const TICKS: u32 = 20;

/// Blocks and delays of the lift: as many blocks as the other controllers have, and of each delayed value four, of which the drive's mode,
/// the loop's velocity window and the sample in which an order waits take their part.
const BLOCKS: usize = 4;
const DELAYS: usize = 4;
const STATES: usize = 2 * DELAYS + BLOCKS + 1;
const MOVES: usize = 5;

/// Samples of each move: 16 ms, in which the loop's 25 Hz turn by more than a radian.
const LENGTHS: [u32; MOVES] = [1, 1, 2, 4, 8];

/// Bounds on the outer force (N): a breakaway force and its dispersion, and half as much again.
const FORCE_N: f64 = 1.5;
/// And on its change in a sample (N).
const SLEW_N: f64 = 0.5;

/// Iterations of the fast gradient in a sample.
const ITERATIONS: u32 = 20;

/// What an excursion beyond the travel weighs against an error (-).
const TRAVEL: f64 = 10.0;

type Model = preslide::control::koopman::KoopmanModel<STATES>;
type Mpc = preslide::control::koopman::KoopmanMpc<STATES, MOVES>;
type Lift = preslide::control::koopman::ErrorLift<STATES, BLOCKS, DELAYS>;
