//! How a kernel is called: through a function of its own, by address, so that no compiler specialises the call.

use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use preslide::{Scalar, Units};

use crate::motion::{COUNT, Motion, SAMPLE_TIME};

/// A kernel's update: model, state, displacement, velocity in; force out.
pub type Step<M, State, S> = unsafe extern "C" fn(&M, &mut State, S, S) -> S;

/// Enough for the worst paths to appear; more changes no figure by 1 %.
const TICKS: usize = 10_000;

/// What the line about a kernel says beside its size.
pub struct Row {
    pub kernel: &'static str,
    pub blocks: usize,
    pub units: Units,
}

impl Row {
    /// Calls `step` for every tick of the motion and prints the kernel's line.
    ///
    /// The rms of the force stands there to show that kernels of one law compute the same thing.
    pub fn run<M, State, S: Scalar>(&self, model: &M, mut state: State, step: Step<M, State, S>) {
        let step = black_box(step);
        let scalar = |value: f64| S::try_from_f64(value).unwrap_or(S::ZERO);
        let mut squares = 0.0;
        for tick in Motion::new().take(TICKS) {
            let displacement = scalar(f64::from(tick.counts) * COUNT / self.units.length);
            let velocity =
                scalar(f64::from(tick.velocity) * COUNT / SAMPLE_TIME / self.units.velocity);
            // SAFETY: every stub is a safe Rust function, or a C peer whose structures `peers.rs` mirrors.
            let force = unsafe { step(model, &mut state, displacement, velocity) };
            let newtons = force.to_f64() * self.units.force;
            squares += newtons * newtons;
        }
        hprintln!(
            "kernel {} {} calls {} model {} state {} force_rms {:.6}",
            self.kernel,
            self.blocks,
            TICKS,
            size_of::<M>(),
            size_of::<State>(),
            libm::sqrt(squares / TICKS as f64)
        );
    }
}

/// Defines the stub of a library model and drives it: `stub!("name", n, Model, model, units)`.
#[macro_export]
macro_rules! stub {
    ($kernel:literal, $n:literal, $model:ty, $units:expr, $make:expr) => {{
        type Scalar = <$model as preslide::Friction>::Scalar;
        type State = <$model as preslide::Friction>::State;
        // SAFETY: the symbol is this crate's own.
        #[unsafe(export_name = concat!("cycles__", $kernel, "__", $n))]
        #[inline(never)]
        extern "C" fn stub(model: &$model, state: &mut State, displacement: Scalar, velocity: Scalar) -> Scalar {
            // SAFETY: no instruction, only a name: without it the compiler folds stubs of equal code into one.
            unsafe { core::arch::asm!(concat!("// ", $kernel, $n), options(nomem, nostack, preserves_flags)) };
            preslide::Friction::step(model, state, preslide::Motion { displacement, velocity })
        }
        let model: $model = $make;
        let row = $crate::stub::Row { kernel: $kernel, blocks: $n, units: $units };
        let state = preslide::Friction::at_rest(&model);
        row.run(&model, state, stub);
    }};
}
