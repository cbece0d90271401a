//! Machines made for a test: a motion of sines, and Maxwell-slip blocks that hold it.

/// Position, velocity and acceleration at time `t` (s) of sines, each of an amplitude, an angular frequency (rad/s) and a phase (rad).
pub fn sines(waves: &[[f64; 3]], t: f64) -> [f64; 3] {
    let parts = waves.iter().map(|[a, w, phase]| {
        let (sin, cos) = (w * t + phase).sin_cos();
        [a * sin, a * w * cos, -a * w * w * sin]
    });
    parts.fold([0.0; 3], |sum, part| [0, 1, 2].map(|i| sum[i] + part[i]))
}

/// Blocks in parallel, springs that slip.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// Stiffness, yield and deflection of each.
    blocks: Vec<[f64; 3]>,
    last: Option<f64>,
}

impl Blocks {
    /// Of such stiffnesses and yields, unloaded.
    pub fn new(blocks: &[(f64, f64)]) -> Self {
        Self {
            blocks: blocks.iter().map(|&(k, d)| [k, d, 0.0]).collect(),
            last: None,
        }
    }

    /// Their force at the next position; at the first they are unloaded.
    pub fn force(&mut self, x: f64) -> f64 {
        let by = x - self.last.replace(x).unwrap_or(x);
        let moved = self.blocks.iter_mut().map(|[k, d, z]| {
            *z = (*z + by).clamp(-*d, *d);
            *k * *z
        });
        moved.sum()
    }
}
