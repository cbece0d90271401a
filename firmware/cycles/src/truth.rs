//! The stage that every kernel's force is compared with: the full law with the paper's ten blocks in `f64`, over the same motion.

use preslide::{Friction, Gms, Units};

use crate::alone::Alone;
use crate::kernels::{BREAKAWAY, SLIDING, blocks, built};
use crate::motion::{SAMPLE_TIME, Strokes, TICKS};

static MEMORY: Alone<Option<[f64; TICKS]>> = Alone::new(None);

/// Its force \[N\] in every tick; worked out once.
pub fn forces() -> &'static [f64; TICKS] {
    // SAFETY: callers drop what they have read before they ask again.
    unsafe { MEMORY.lend() }.get_or_insert_with(|| {
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
