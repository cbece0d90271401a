//! What an outer sample costs on a core with a float unit; the others have no time for it.

use core::hint::black_box;

use crate::koopman::{self, Lift, LiftState, Mpc, MpcState, STATES, Sample};
use crate::motion::{Strokes, TICKS};

// SAFETY: the symbol is this crate's own.
#[unsafe(export_name = "cycles__koopman_lift__4")]
#[inline(never)]
extern "C" fn lift(
    lift: &Lift,
    state: &mut LiftState,
    sample: &Sample,
    lifted: &mut [f32; STATES],
) {
    let Sample {
        error,
        travelled,
        reference,
        force,
        ..
    } = *sample;
    *lifted = *lift.take(state, error, travelled, reference, force);
}

type Take = extern "C" fn(&Lift, &mut LiftState, &Sample, &mut [f32; STATES]);
type Solve = extern "C" fn(&Mpc, &mut MpcState, &[f32; STATES], &Sample) -> f32;

macro_rules! solver {
    ($kernel:literal) => {{
        // SAFETY: the symbol is this crate's own.
        #[unsafe(export_name = concat!("cycles__", $kernel, "__5"))]
        #[inline(never)]
        extern "C" fn solve(
            mpc: &Mpc,
            state: &mut MpcState,
            lifted: &[f32; STATES],
            sample: &Sample,
        ) -> f32 {
            // SAFETY: no instruction, only a name: without it the compiler folds stubs of equal code into one.
            unsafe { core::arch::asm!(concat!("// ", $kernel), options(nomem, nostack, preserves_flags)) };
            mpc.solve(state, lifted, &sample.ahead)
        }
        solve
    }};
}

pub fn run() {
    measure("koopman_mpc_10", 10, solver!("koopman_mpc_10"), true);
    measure("koopman_mpc_20", 20, solver!("koopman_mpc_20"), false);
}

/// The first of them has the lift's calls recorded, too.
fn measure(kernel: &str, iterations: u32, solve: Solve, with_lift: bool) {
    let (model, mpc) = (koopman::lift(), koopman::mpc(iterations));
    let (mut state, mut plan) = (model.at_rest(), MpcState::new());
    let (recorded, solve) = (black_box(lift as Take), black_box(solve));
    let (calls, [lifts, orders]) = koopman::run(
        Strokes::new().take(TICKS),
        |sample| {
            let mut lifted = [0.0; STATES];
            if with_lift {
                recorded(&model, &mut state, sample, &mut lifted);
            } else {
                lifted = *model.take(
                    &mut state,
                    sample.error,
                    sample.travelled,
                    sample.reference,
                    sample.force,
                );
            }
            lifted
        },
        |sample, lifted| solve(&mpc, &mut plan, lifted, sample),
    );
    if with_lift {
        let (model, state) = (size_of::<Lift>(), size_of::<LiftState>());
        crate::say!(
            "kernel koopman_lift 4 calls {calls} model {model} state {state} error 0.0000 checksum {lifts:016x}"
        );
    }
    let (model, state) = (size_of::<Mpc>(), size_of::<MpcState>());
    crate::say!(
        "kernel {kernel} 5 calls {calls} model {model} state {state} error 0.0000 checksum {orders:016x}"
    );
}
