//! The motion in a model's units.

use preslide::{Motion, Scalar, Units};

use crate::motion::Tick;

/// What a kernel and its controller are given in a tick.
pub struct Given<S> {
    /// Displacement and velocity.
    pub motion: [S; 2],
    pub place: S,
    /// Velocity \[counts per tick\].
    pub velocity: f32,
}

// Once in the image and not once a kernel, as the motion itself.
#[inline(never)]
fn in_units<S: Scalar>(tick: &Tick, units: Units) -> Given<S> {
    let Motion {
        displacement,
        velocity,
    } = tick.motion(units);
    Given {
        motion: [displacement, velocity],
        place: tick.place(units),
        velocity: tick.velocity,
    }
}

/// Every tick.
#[cfg(target_arch = "arm")]
pub fn given<S: Scalar>(units: Units) -> impl Iterator<Item = Given<S>> {
    use crate::motion::{Strokes, TICKS};
    Strokes::new()
        .take(TICKS)
        .map(move |tick| in_units(&tick, units))
}

#[cfg(target_arch = "riscv32")]
pub use remembered::given;

/// Worked out once for all kernels of the same units: divisions of software `double` would take a simulated core longer than the kernels.
#[cfg(target_arch = "riscv32")]
mod remembered {
    use super::{Given, in_units};
    use crate::alone::Alone;
    use crate::motion::{Strokes, TICKS};
    use core::any::TypeId;
    use core::mem::MaybeUninit;
    use preslide::{Scalar, Units};

    /// Of which scalar and units, and as many bytes as the ticks take in the longest scalar.
    struct Memory {
        of: Option<(TypeId, Units)>,
        ticks: MaybeUninit<[Given<f64>; TICKS]>,
    }

    static MEMORY: Alone<Memory> = Alone::new(Memory {
        of: None,
        ticks: MaybeUninit::uninit(),
    });

    /// Every tick.
    pub fn given<S: Scalar>(units: Units) -> impl Iterator<Item = Given<S>> {
        const { assert!(size_of::<S>() <= 8 && align_of::<S>() <= 8) };
        // SAFETY: no reference outlives this function.
        let memory = unsafe { MEMORY.lend() };
        let ticks = memory.ticks.as_mut_ptr().cast::<Given<S>>();
        if memory.of != Some((TypeId::of::<S>(), units)) {
            for (index, tick) in Strokes::new().take(TICKS).enumerate() {
                // SAFETY: within the memory, which is as long for the longest scalar.
                unsafe { ticks.add(index).write(in_units(&tick, units)) };
            }
            memory.of = Some((TypeId::of::<S>(), units));
        }
        // SAFETY: written above, for this scalar, in this call or one before.
        (0..TICKS).map(move |index| unsafe { ticks.add(index).read() })
    }
}
