//! The stage that every kernel's force is compared with: the full law with the paper's ten blocks in `f64`, over the same motion.

use core::cell::UnsafeCell;
use preslide::{Friction, Gms, Units};

use crate::kernels::{BREAKAWAY, SLIDING, blocks, built};
use crate::motion::{SAMPLE_TIME, Strokes, TICKS};

struct Memory(UnsafeCell<Option<[f64; TICKS]>>);

// SAFETY: nothing here runs beside anything else.
unsafe impl Sync for Memory {}

static MEMORY: Memory = Memory(UnsafeCell::new(None));

/// Its force \[N\] in every tick; worked out once.
pub fn forces() -> &'static [f64; TICKS] {
    // SAFETY: no reference is kept that could change it, and there is one thread.
    unsafe { &mut *MEMORY.0.get() }.get_or_insert_with(|| {
        let gms = Gms::<10, f64>::try_new(&blocks(), BREAKAWAY, SLIDING, SAMPLE_TIME, Units::SI);
        let gms = built(gms);
        let mut state = gms.at_rest();
        let mut forces = [0.0; TICKS];
        for (force, tick) in forces.iter_mut().zip(Strokes::new()) {
            *force = gms.step(&mut state, tick.motion(Units::SI));
        }
        forces
    })
}
