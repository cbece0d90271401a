//! What Preslide's kernels are measured against: an empty call, a PID and a biquad; [`crate::textbook`] and [`crate::exported`] for the rest.

use core::sync::atomic::Ordering;
use dsp_process::SplitProcess;
use fixed::types::I32F0;
use idsp::iir::{BiquadClamp, DirectForm1};
use preslide::Units;

use crate::motion::{COUNT, SAMPLE_TIME};
use crate::stub::{Controller, EMPTY_TICK, Row};
use crate::tick::{Inputs, Pid, PidState};

/// What a call of any stub costs by itself.
// SAFETY: the symbol is this crate's own.
#[unsafe(export_name = "cycles__empty_call__1")]
#[inline(never)]
extern "C" fn empty_call(_model: &(), _state: &mut (), displacement: f32, _velocity: f32) -> f32 {
    displacement
}

/// The control tick without a kernel: what a tick with one is compared with.
// SAFETY: the symbol is this crate's own.
#[unsafe(export_name = "cycles__tick__empty_call__1")]
#[inline(never)]
extern "C" fn empty_tick(
    _model: &(),
    _state: &mut (),
    (pid, pid_state): &mut Controller,
    inputs: &Inputs<f32>,
) -> f32 {
    pid.step(pid_state, inputs.error);
    inputs.motion.displacement
}

/// A PID alone.
// SAFETY: the symbol is this crate's own.
#[unsafe(export_name = "cycles__pid_f32__1")]
#[inline(never)]
extern "C" fn pid(model: &Pid, state: &mut PidState, _displacement: f32, velocity: f32) -> f32 {
    model.step(state, velocity);
    state.output
}

type Biquad = BiquadClamp<dsp_fixedpoint::Q<i32, i64, 29>, i32>;

// SAFETY: the symbol is this crate's own.
#[unsafe(export_name = "cycles__idsp_biquad_i32__1")]
#[inline(never)]
extern "C" fn biquad(
    model: &Biquad,
    state: &mut DirectForm1<i32>,
    displacement: I32F0,
    _velocity: I32F0,
) -> I32F0 {
    I32F0::from_bits(model.process(state, displacement.to_bits()))
}

fn single(kernel: &'static str, units: Units) -> Row {
    Row {
        kernel,
        blocks: 1,
        units,
    }
}

/// To be run before anything that is compared with it.
pub fn run_empty_tick() {
    let ticks = single("empty_call", Units::SI).run_in_tick(&(), (), empty_tick);
    EMPTY_TICK.store((ticks.mean() as f32).to_bits(), Ordering::Relaxed);
}

pub fn run() {
    crate::textbook::run();
    crate::exported::run();

    let row = single("empty_call", Units::SI);
    let call = row.run(&(), (), empty_call, |_, _, _| ());
    row.print_measured::<()>(&call, None);
    let row = single("pid_f32", Units::SI);
    let call = row.run(&Pid::EXAMPLE, PidState::default(), pid, |_, _, _| ());
    row.print_measured::<PidState>(&call, None);
    // A low-pass at a tenth of the sample rate.
    let counts = Units {
        length: COUNT,
        force: 1.0,
        velocity: COUNT / SAMPLE_TIME,
    };
    let model = Biquad::from([0.0675, 0.135, 0.0675, 1.143, -0.413]);
    let row = single("idsp_biquad_i32", counts);
    let call = row.run(&model, DirectForm1::default(), biquad, |_, _, _| ());
    row.print_measured::<DirectForm1<i32>>(&call, None);
}
