//! The checksums of the kernels' forces on this machine, for `cargo xtask cycles` to compare with the target's.
//!
//! Kernels, parameters and motion are the harness's own files: nothing is written twice that could differ.

#[path = "../../firmware/cycles/src/checksum.rs"]
mod checksum;
#[path = "../../firmware/cycles/src/kernels.rs"]
mod kernels;
#[path = "../../firmware/cycles/src/motion.rs"]
mod motion;

use checksum::Checksum;
use motion::{Strokes, TICKS};
use preslide::{Friction, Scalar, Units};

/// The harness's macro of this name measures; this one only runs the kernel.
#[macro_export]
macro_rules! stub {
    ($kernel:literal, $n:literal, $model:ty, $units:expr, $make:expr) => {{
        let model: $model = $make;
        $crate::print_checksum($kernel, $n, &model, $units);
    }};
}

fn print_checksum<F: Friction>(kernel: &str, blocks: usize, model: &F, units: Units) {
    let mut state = model.at_rest();
    let mut checksum = Checksum::new();
    for tick in Strokes::new().take(TICKS) {
        checksum.add(model.step(&mut state, tick.motion(units)).to_f64());
    }
    println!("{kernel} {blocks} {:016x}", checksum.value());
}

fn main() {
    kernels::run();
    kernels::long_runs(|kernel, checksum| {
        println!("{kernel} steps {} {checksum:016x}", kernels::LONG);
    });
}
