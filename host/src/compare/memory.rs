//! Non-local memory, measured: does a model come back to the force it left when an inner loop closes?

use preslide::ParamError;
use preslide_fit::friction::{FrictionModel, Path};

/// Inner loops, each half as wide as the one around it.
const LOOPS: usize = 9;
/// Samples on half the outer loop: 16 on the last reversal's distance from the middle.
const HALF: i64 = 16 << LOOPS;
/// How much slower the slow run is.
const SLOWER: f64 = 100.0;
/// How often the motion is made smaller, by the widest over the narrowest loop each time, where a model slides
/// throughout: down to 1e-8 of the amplitude.
const SMALLER: usize = 3;
/// Share of the force's range that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// The motion on which a model's loops are judged.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Half of the outer loop's width (m or rad).
    pub amplitude: f64,
    /// Speed (m/s or rad/s), the same on all branches.
    pub speed: f64,
}

/// How well a model closes nested loops.
#[derive(Clone, Debug)]
pub struct LoopClosure {
    /// `|F(return) − F(reversal)|` (N or N·m) of each inner loop, the widest first: [`widths`](Self::widths).
    pub errors: Vec<f64>,
    /// Width of each inner loop (m or rad).
    pub widths: Vec<f64>,
    /// The largest of `errors` and of those of the slow run.
    pub largest: f64,
    /// The largest error when moving a hundred times slower: differs for models in which time enters.
    pub largest_slow: f64,
    /// Highest less lowest force (N or N·m) over the motion.
    pub range: f64,
    /// Whether the force depends on where the motion turned at all; it does not for Coulomb friction, whose
    /// loops close because there is nothing to remember.
    pub remembers: bool,
    /// Positions (m or rad) of the motion.
    pub position: Vec<f64>,
    /// The model's force (N or N·m) there.
    pub force: Vec<f64>,
}

impl LoopClosure {
    /// The model remembers, and every inner loop closes to rounding (1e-9 of the force's range).
    pub fn is_nonlocal(&self) -> bool {
        self.remembers && self.largest <= ROUNDING * self.range
    }
}

/// Corners of the motion in samples from the middle: out to both ends, then reversals that halve, then the same
/// reversals backward, so that each loop is closed where it was opened.
fn corners() -> Vec<i64> {
    let inward: Vec<i64> = (0..=LOOPS + 1)
        .map(|k| match k {
            0 => HALF,
            k if k % 2 == 1 => -(HALF >> (k - 1)),
            k => HALF >> (k - 1),
        })
        .collect();
    let outward = inward.iter().rev().skip(1);
    inward.iter().chain(outward).copied().collect()
}

/// Drives `model` from rest through an outer loop and, within it, nested reversals of 1/2, 1/4, … 1/512 of the
/// amplitude, then back through the same reversals.
///
/// The force at the return to each reversal point is compared with the force when it was first reached, on a
/// branch of the same direction. A model with non-local memory (return-point memory) comes back to the same force.
/// Positions are whole multiples of one step, so the return is exact. Where even the narrowest loop is so wide
/// that the model slides on all of its branches the motion is repeated at a 512th of the amplitude, up to three
/// times, for nothing is learnt about memory there.
///
/// # Errors
/// [`ParamError`] where the library refuses a parameter.
pub fn loop_closure(model: &FrictionModel, scale: Scale) -> Result<LoopClosure, ParamError> {
    let mut found = on_motion(model, scale)?;
    let mut amplitude = scale.amplitude;
    for _ in 0..SMALLER {
        if found.remembers {
            return Ok(found);
        }
        amplitude /= (1_u32 << LOOPS) as f64;
        let smaller = on_motion(model, Scale { amplitude, ..scale })?;
        if smaller.remembers {
            found = smaller;
        }
    }
    Ok(found)
}

/// [`loop_closure`] with an outer loop of this very amplitude.
fn on_motion(model: &FrictionModel, scale: Scale) -> Result<LoopClosure, ParamError> {
    let mut places = vec![0_i64];
    let mut turns = Vec::new();
    for corner in corners() {
        let mut at = places.last().copied().unwrap_or(0);
        while at != corner {
            at += (corner - at).signum();
            places.push(at);
        }
        turns.push(places.len() - 1);
    }
    let step = scale.amplitude / HALF as f64;
    let position: Vec<f64> = places.iter().map(|&p| p as f64 * step).collect();
    let direction: Vec<f64> = std::iter::once(0.0)
        .chain(places.windows(2).map(|p| (p[1] - p[0]) as f64))
        .collect();
    let run = |speed: f64| {
        let velocity: Vec<f64> = direction.iter().map(|d| d * speed).collect();
        model.force(Path {
            position: &position,
            velocity: &velocity,
            pieces: std::slice::from_ref(&(0..position.len())),
            sample_time: step / speed,
        })
    };
    // The outer loop's two corners come first and last; the innermost corner is where the motion turns back.
    let inner = 2..=LOOPS;
    let closing = |force: &[f64]| -> Vec<f64> {
        inner
            .clone()
            .map(|k| (force[turns[turns.len() - 1 - k]] - force[turns[k]]).abs())
            .collect()
    };
    let worst = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);

    let force = run(scale.speed)?;
    let errors = closing(&force);
    let largest_slow = worst(&closing(&run(scale.speed / SLOWER)?));
    let lowest = force.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = force.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The branches cross the middle upward after having turned at different places.
    let crossings: Vec<f64> = (1..places.len())
        .filter(|&i| places[i] == 0 && places[i - 1] < 0)
        .map(|i| force[i])
        .collect();
    let spread = crossings.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        - crossings.iter().copied().fold(f64::INFINITY, f64::min);
    Ok(LoopClosure {
        largest: worst(&errors).max(largest_slow),
        largest_slow,
        widths: inner
            .map(|k| 1.5 * scale.amplitude / 2_f64.powi(k as i32 - 1))
            .collect(),
        errors,
        range: highest - lowest,
        remembers: spread > ROUNDING * (highest - lowest),
        position,
        force,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide::{Block, HsiehParams};

    /// The paper's experiment: within 40 µm, driven slowly.
    const PAPER: Scale = Scale {
        amplitude: 40e-6,
        speed: 20e-6,
    };

    fn closure(model: &FrictionModel) -> LoopClosure {
        loop_closure(model, PAPER).unwrap()
    }

    /// Dahl with n = 1 from saturation has a closed form, so the error itself can be checked: from `F_c` back by
    /// `w` and forward by `w` it ends at `F_c·(1 − (2 − u₀)·…)`, worked out below for one loop.
    #[test]
    fn dahls_error_is_what_its_equation_says() {
        let (amplitude, length) = (40e-6, 5e-6);
        let dahl = closure(&FrictionModel::Dahl {
            stiffness: 0.9 / length,
            coulomb: 0.9,
            exponent: 1.0,
        });
        assert!(dahl.remembers && !dahl.is_nonlocal());
        // F/F_c along the corners: moving by d relaxes the distance to sgn(d) by exp(−|d|/length).
        let mut share = 0.0;
        let mut at = 0.0;
        let mut visited = Vec::new();
        for corner in corners() {
            let to = corner as f64 / HALF as f64 * amplitude;
            let end = (to - at).signum();
            share = end + (share - end) * (-(to - at).abs() / length).exp();
            at = to;
            visited.push(share);
        }
        for (i, error) in dahl.errors.iter().enumerate() {
            let k = i + 2;
            let expected = 0.9 * (visited[visited.len() - 1 - k] - visited[k]).abs();
            assert!(
                (error - expected).abs() < 1e-10,
                "loop {k}: {error} {expected}"
            );
        }
    }

    #[test]
    fn coulomb_has_nothing_to_remember() {
        let coulomb = closure(&FrictionModel::Coulomb { coulomb: 1.0 });
        assert_eq!(coulomb.largest, 0.0);
        assert!(!coulomb.remembers && !coulomb.is_nonlocal());
    }

    /// Hsieh's spring closes its loops; the plastic module, which creeps, opens them again.
    #[test]
    fn hsieh_closes_but_for_creep() {
        let mut params = HsiehParams {
            k1: 5000.0,
            k2: 200_000.0,
            beta: 3e5,
            viscous: 0.0,
            creep: 0.0,
            hardening: 1e6,
            hardening_exponent: 2.0,
        };
        assert!(closure(&FrictionModel::Hsieh(params)).is_nonlocal());
        params.creep = 0.5;
        params.hardening = 1e4;
        let creeping = closure(&FrictionModel::Hsieh(params));
        assert!(!creeping.is_nonlocal());
        assert!(creeping.largest_slow != creeping.errors.iter().copied().fold(0.0, f64::max));
    }

    /// A stroke of 0.2 m says nothing about a model that yields within micrometres; the motion finds them.
    #[test]
    fn long_strokes_are_made_smaller() {
        let long = Scale {
            amplitude: 0.2,
            speed: 0.1,
        };
        let gms = FrictionModel::maxwell_slip(&[1e6], &[2e-6]);
        let gms = loop_closure(&gms, long).unwrap();
        assert!(gms.is_nonlocal() && gms.position.iter().all(|x| x.abs() < 1e-3));
        let dahl = FrictionModel::Dahl {
            stiffness: 1e6,
            coulomb: 2.0,
            exponent: 1.0,
        };
        let dahl = loop_closure(&dahl, long).unwrap();
        assert!(dahl.remembers && !dahl.is_nonlocal() && dahl.largest > 0.02 * dahl.range);
    }

    #[test]
    fn parameters_are_judged_by_the_library() {
        let wrong = FrictionModel::Gms {
            breakaway: 1.0,
            blocks: vec![Block {
                stiffness: 1.0,
                weight: 0.5,
            }],
            sliding: None,
        };
        assert!(loop_closure(&wrong, PAPER).is_err());
    }
}
