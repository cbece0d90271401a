//! Eqs. (10)–(12) as they are printed: forces as states, integrated in time, the onset of slip located exactly.
//!
//! Eq. (11) is read as the library documents it (odd in `v`; stick on a reversal of the displacement).

use super::Stribeck;

struct Element {
    stiffness: f64,
    share: f64,
    force: f64,
    slips: bool,
}

/// The model and its memory.
pub struct MaxwellSlip {
    elements: Vec<Element>,
    stribeck: Stribeck,
    /// `C` (N/s), may be infinite.
    attraction: f64,
    /// `T_s` (s).
    sample_time: f64,
    direction: f64,
}

impl MaxwellSlip {
    /// `(k_i, α_i)` of each block, the sliding law, `C` (N/s) and `T_s` (s).
    pub fn new(
        blocks: &[(f64, f64)],
        stribeck: Stribeck,
        attraction: f64,
        sample_time: f64,
    ) -> Self {
        let element = |&(stiffness, share): &(f64, f64)| Element {
            stiffness,
            share,
            force: 0.0,
            slips: false,
        };
        Self {
            elements: blocks.iter().map(element).collect(),
            stribeck,
            attraction,
            sample_time,
            direction: 1.0,
        }
    }

    /// Moves by `displacement` (m) at a constant rate over one sample time, sliding at `velocity` (m/s), and
    /// returns the force (N).
    pub fn advance(&mut self, displacement: f64, velocity: f64) -> f64 {
        if displacement != 0.0 && displacement.signum() != self.direction {
            self.direction = displacement.signum();
            for element in &mut self.elements {
                element.slips = false;
            }
        }
        if displacement != 0.0 || velocity != 0.0 {
            let strength = self.stribeck.force(velocity);
            for element in &mut self.elements {
                let rate = element.stiffness * displacement.abs() / self.sample_time;
                let limit = element.share * strength;
                let mut left = self.sample_time;
                if !element.slips {
                    // (10): dF/dt = k·v, until |F| = W.
                    let until_slip = (limit - self.direction * element.force) / rate;
                    if self.direction * element.force >= limit {
                        element.slips = true;
                    } else if until_slip <= self.sample_time {
                        element.slips = true;
                        element.force = self.direction * limit;
                        left -= until_slip;
                    } else {
                        element.force += self.direction * rate * self.sample_time;
                    }
                }
                if element.slips {
                    element.force = relax(
                        element.force,
                        self.direction * limit,
                        self.attraction / strength,
                        left,
                    );
                }
            }
        }
        self.elements.iter().map(|element| element.force).sum()
    }
}

/// Integrates (11), `dF/dt = C·(sgn(v)·α − F/s) = (C/s)·(target − F)`, over `time` (s) by Runge–Kutta steps that
/// are short against `s/C`.
fn relax(mut force: f64, target: f64, rate: f64, time: f64) -> f64 {
    if rate.is_infinite() {
        return target;
    }
    let steps = (rate * time / 0.01).ceil().max(1.0);
    let h = time / steps;
    let slope = |f: f64| rate * (target - f);
    for _ in 0..steps as usize {
        let a = slope(force);
        let b = slope(force + 0.5 * h * a);
        let c = slope(force + 0.5 * h * b);
        let d = slope(force + h * c);
        force += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    force
}
