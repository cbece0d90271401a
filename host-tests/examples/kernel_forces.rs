//! The checksums of the kernels' forces on this machine, for `cargo xtask cycles` to compare with the target's: over the first ticks
//! of the motion, as many as the argument says, or over all of them.
//!
//! Kernels, parameters and motion are the harness's own files: nothing is written twice that could differ.

#[path = "../../firmware/cycles/src/checksum.rs"]
mod checksum;
#[path = "../../firmware/cycles/src/closed_loop.rs"]
mod closed_loop;
#[path = "../../firmware/cycles/src/effects.rs"]
mod effects;
#[path = "../../firmware/cycles/src/kernels.rs"]
mod kernels;
#[path = "../../firmware/cycles/src/koopman.rs"]
mod koopman;
#[path = "../../firmware/cycles/src/motion.rs"]
mod motion;

use checksum::Checksum;
use fixed::types::I16F16;
use motion::{Strokes, TICKS};
use preslide::{Friction, Scalar, Units};
use preslide_app::{Number, Starting};

/// The harness's macro of this name measures; this one only runs the kernel.
#[macro_export]
macro_rules! stub {
    ($kernel:expr, $n:literal, $model:ty, $units:expr, $make:expr) => {
        $crate::stub!($kernel, $n, $model, $units, $make, |_state| {})
    };
    ($kernel:expr, $n:literal, $model:ty, $units:expr, $make:expr, |$state:ident| $tell:expr) => {{
        let model: $model = $make;
        let mut state = preslide::Friction::at_rest(&model);
        {
            let $state = &mut state;
            $tell;
        }
        $crate::print_checksum($kernel, $n, &model, state, $units);
    }};
}

/// How much of the motion.
fn ticks() -> usize {
    match std::env::args().nth(1) {
        Some(ticks) => ticks.parse().expect("a number of ticks"),
        None => TICKS,
    }
}

fn print_checksum<F: Friction>(
    kernel: &str,
    blocks: usize,
    model: &F,
    mut state: F::State,
    units: Units,
) {
    let mut checksum = Checksum::new();
    for tick in Strokes::new().take(ticks()) {
        model.set_position(&mut state, tick.place(units));
        checksum.add(model.step(&mut state, tick.motion(units)).to_f64());
    }
    println!("{kernel} {blocks} {:016x}", checksum.value());
}

/// The codes of the whole control task.
fn print_control_task<S: Number>(kernel: &str) {
    let queues = Box::leak(Box::default());
    let model = Starting::<S>::PAPER;
    let checksum = closed_loop::run(model, queues, ticks(), |inputs, task| task.tick(inputs));
    println!("{kernel} 4 {checksum:016x}");
}

/// Lifted states and orders of the predictive controller; cores without a float unit, which see a part of the motion, leave it out.
fn print_koopman(kernel: &str, iterations: u32) {
    let (lift, mpc) = (koopman::lift(), koopman::mpc(iterations));
    let mut state: koopman::LiftState = lift.at_rest();
    let mut plan = koopman::MpcState::new();
    let (_, [lifts, orders]) = koopman::run(
        Strokes::new().take(ticks()),
        |s| *lift.take(&mut state, s.error, s.travelled, s.reference, s.force),
        |sample, lifted| mpc.solve(&mut plan, lifted, &sample.ahead),
    );
    println!("koopman_lift 4 {lifts:016x}");
    println!("{kernel} 5 {orders:016x}");
}

fn main() {
    kernels::run();
    effects::run();
    print_control_task::<f32>("control_task_f32");
    print_control_task::<I16F16>("control_task_i16f16");
    if ticks() == TICKS {
        print_koopman("koopman_mpc_10", 10);
        print_koopman("koopman_mpc_20", 20);
    }
    kernels::long_runs(|kernel, checksum| {
        println!("{kernel} steps {} {checksum:016x}", kernels::LONG);
    });
}
