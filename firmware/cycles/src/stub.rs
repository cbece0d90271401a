//! How a kernel is called: through a function of its own, by address, so that no compiler specialises the call.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};
use preslide::{Friction, Motion, Scalar, Units};

use crate::checksum::Checksum;
use crate::given::given;
use crate::kernels::BREAKAWAY;
use crate::machine::{MEASURES, TELLS};
use crate::motion::TICKS;
use crate::spent::Spent;
use crate::tick::{Inputs, Pid, PidState};
use crate::truth;

/// A kernel's update: model, state, displacement, velocity in; force out.
pub type Step<M, State, S> = unsafe extern "C" fn(&M, &mut State, S, S) -> S;

/// Tells a model where the axis is, before its update and not part of it.
pub type Place<M, State, S> = fn(&M, &mut State, S);

/// A control tick around it.
pub type ControlTick<M, State, S> = extern "C" fn(&M, &mut State, &mut Controller, &Inputs<S>) -> S;

/// The controller that shares the tick.
pub type Controller = (Pid, PidState);

/// Mean cycles of a control tick without a kernel, as the bits of an `f32`: what ticks with one are compared with on a board.
pub static EMPTY_TICK: AtomicU32 = AtomicU32::new(0);

/// What the line about a kernel says beside its size.
pub struct Row {
    pub kernel: &'static str,
    pub blocks: usize,
    pub units: Units,
}

impl Row {
    /// Calls `step` for every tick of the motion and, for the recorder, prints the kernel's line.
    ///
    /// The error is the rms difference from [`crate::truth`] in % of the breakaway force; the checksum shows that this
    /// processor computes the same bits as another.
    pub fn run<M, State, S: Scalar>(
        &self,
        model: &M,
        state: State,
        step: Step<M, State, S>,
        place: Place<M, State, S>,
    ) -> Spent {
        self.run_watched(model, state, step, place, |_, _| ())
    }

    /// The same, where somebody looks at every force.
    pub fn run_watched<M, State, S: Scalar>(
        &self,
        model: &M,
        mut state: State,
        step: Step<M, State, S>,
        place: Place<M, State, S>,
        mut watch: impl FnMut(Motion<S>, S),
    ) -> Spent {
        let step = black_box(step);
        let mut squares = 0.0;
        let mut checksum = Checksum::new();
        let mut spent = Spent::default();
        for (index, tick) in given(self.units).enumerate() {
            place(model, &mut state, tick.place);
            // SAFETY: every stub is a safe Rust function, or a C peer whose structures `textbook.rs` or `exported.rs` mirrors.
            let force = unsafe { spent.update(step, model, &mut state, tick.motion) };
            checksum.add(force.to_f64());
            let [displacement, velocity] = tick.motion;
            let motion = Motion {
                displacement,
                velocity,
            };
            watch(motion, force);
            if !MEASURES {
                let missed = force.to_f64() * self.units.force - truth::forces()[index];
                squares += missed * missed;
            }
        }
        let error = 100.0 / BREAKAWAY * libm::sqrt(squares / TICKS as f64);
        self.tell(
            [size_of::<M>(), size_of::<State>()],
            error,
            checksum.value(),
        );
        spent
    }

    /// The kernel's line for whoever compares: bytes of model and state, error and checksum.
    pub fn tell(&self, [model, state]: [usize; 2], error: f64, checksum: u64) {
        let (kernel, blocks) = (self.kernel, self.blocks);
        if TELLS && MEASURES {
            crate::say!(
                "kernel {kernel} {blocks} calls {TICKS} model {model} checksum {checksum:016x}"
            );
        } else if TELLS {
            crate::say!(
                "kernel {kernel} {blocks} calls {TICKS} model {model} state {state} error {error:.4} checksum {checksum:016x}"
            );
        }
    }

    /// The same motion once more, with the kernel inlined into a control tick.
    pub fn run_in_tick<M, State, S: Scalar>(
        &self,
        model: &M,
        mut state: State,
        control: ControlTick<M, State, S>,
    ) -> Spent {
        let mut spent = Spent::default();
        let control = black_box(control);
        let mut controller = (Pid::EXAMPLE, PidState::default());
        for tick in given(self.units) {
            let [displacement, velocity] = tick.motion;
            let inputs = Inputs {
                motion: Motion {
                    displacement,
                    velocity,
                },
                position: tick.place,
                error: tick.velocity,
            };
            black_box(spent.tick(control, model, &mut state, &mut controller, &inputs));
        }
        black_box(controller.1.output);
        spent
    }

    /// On a core that counts: the kernel's line in the columns of cortex-m4.csv, from its calls and its ticks. None knows the size of
    /// the code, and a board counts no instructions.
    pub fn print_measured<State>(&self, call: &Spent, ticks: Option<&Spent>) {
        if !MEASURES {
            return;
        }
        let (kernel, blocks, state) = (self.kernel, self.blocks, size_of::<State>());
        crate::machine::print(format_args!("{kernel},{blocks},"));
        match call.longest {
            Some(longest) => {
                crate::machine::print(format_args!("{:.1},{longest},", call.mean_instructions()))
            }
            None => crate::machine::print(format_args!(",,")),
        }
        crate::machine::print(format_args!("{:.1},{},,,", call.mean(), call.worst));
        if let Some(ticks) = ticks {
            let without = f64::from(f32::from_bits(EMPTY_TICK.load(Ordering::Relaxed)));
            crate::machine::print(format_args!("{:.1}", ticks.mean() - without));
        }
        crate::say!(",,,{state},,{TICKS},");
    }
}

/// The control tick: the controller, then friction, inlined. Only models with effects of position are told where the axis is.
#[inline(always)]
pub fn tick<F: Friction>(
    model: &F,
    state: &mut F::State,
    (pid, pid_state): &mut Controller,
    inputs: &Inputs<F::Scalar>,
) -> F::Scalar {
    pid.step(pid_state, inputs.error);
    model.set_position(state, inputs.position);
    model.step(state, inputs.motion)
}

/// Defines the stubs of a library model and drives them: `stub!("name", n, Model, units, model)`, with a last argument
/// `|state| …` where the state at rest is to be told something first.
#[macro_export]
macro_rules! stub {
    ($kernel:expr, $n:literal, $model:ty, $units:expr, $make:expr) => {
        $crate::stub!($kernel, $n, $model, $units, $make, |_state| {})
    };
    ($kernel:expr, $n:literal, $model:ty, $units:expr, $make:expr, |$state:ident| $tell:expr) => {{
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
        // SAFETY: as above.
        #[unsafe(export_name = concat!("cycles__tick__", $kernel, "__", $n))]
        #[inline(never)]
        extern "C" fn in_tick(
            model: &$model,
            state: &mut State,
            controller: &mut $crate::stub::Controller,
            inputs: &$crate::tick::Inputs<Scalar>,
        ) -> Scalar {
            // SAFETY: as above.
            unsafe { core::arch::asm!(concat!("// tick ", $kernel, $n), options(nomem, nostack, preserves_flags)) };
            $crate::stub::tick(model, state, controller, inputs)
        }
        let model: $model = $make;
        let row = $crate::stub::Row { kernel: $kernel, blocks: $n, units: $units };
        let mut state = preslide::Friction::at_rest(&model);
        {
            let $state = &mut state;
            $tell;
        }
        let call = row.run(&model, state.clone(), stub, preslide::Friction::set_position);
        let ticks = row.run_in_tick(&model, state, in_tick);
        row.print_measured::<State>(&call, Some(&ticks));
    }};
}
