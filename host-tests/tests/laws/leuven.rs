//! The Leuven models with a hysteresis by Masing's rules in `z`: no block has a state of its own.

use preslide_host_tests::reference::ode::integrate;

/// A reversal of `z` (m), and `F_h` (N) there.
#[derive(Clone, Copy)]
struct Reversal {
    place: f64,
    force: f64,
}

/// The model without Stribeck effect, and its memory.
pub struct Leuven {
    /// `(k_i, W_i)` (N/m, N).
    blocks: Vec<(f64, f64)>,
    /// `s` (N).
    strength: f64,
    exponent: f64,
    damping: f64,
    /// The equation of 2000, relative to `F_b`.
    original: bool,
    reversals: Vec<Reversal>,
    place: f64,
    force: f64,
    rising: Option<bool>,
}

impl Leuven {
    /// `(k_i, α_i)` of each block, `F_s` (N), `n`, `σ1` (N·s/m).
    pub fn new(
        blocks: &[(f64, f64)],
        breakaway: f64,
        exponent: f64,
        damping: f64,
        original: bool,
    ) -> Self {
        Self {
            blocks: blocks.iter().map(|&(k, a)| (k, a * breakaway)).collect(),
            strength: breakaway,
            exponent,
            damping,
            original,
            reversals: Vec::new(),
            place: 0.0,
            force: 0.0,
            rising: None,
        }
    }

    /// Reversals that are left and the force at `place` on the way up or down from the last reversal.
    fn at(&self, place: f64, rising: bool) -> (usize, f64) {
        let sign = if rising { 1.0 } else { -1.0 };
        let virgin = |u: f64| -> f64 { self.blocks.iter().map(|&(k, w)| (k * u).min(w)).sum() };
        let mut left = self.reversals.len();
        loop {
            match &self.reversals[..left] {
                [.., before, _] if sign * (place - before.place) >= 0.0 => left -= 2,
                [first] if sign * place >= first.place.abs() => left = 0,
                [] => return (0, sign * virgin(place.abs())),
                [.., last] => {
                    let travel = (place - last.place).abs();
                    return (left, last.force + sign * 2.0 * virgin(0.5 * travel));
                }
            }
        }
    }

    /// `dz/dx`.
    fn pace(&self, place: f64, rising: bool) -> f64 {
        let sign = if rising { 1.0 } else { -1.0 };
        let (left, force) = self.at(place, rising);
        let base = match self.reversals[..left].last() {
            Some(last) if self.original => last.force,
            _ => 0.0,
        };
        let share = (force - base) / (sign * self.strength - base);
        1.0 - share.signum() * share.abs().powf(self.exponent)
    }

    /// Moves by `displacement` (m) and returns the force (N) at the velocity `velocity` (m/s).
    pub fn advance(&mut self, displacement: f64, velocity: f64) -> f64 {
        if displacement != 0.0 {
            let rising = displacement > 0.0;
            if self.rising.is_some_and(|before| before != rising) {
                self.reversals.push(Reversal {
                    place: self.place,
                    force: self.force,
                });
            }
            self.rising = Some(rising);
            let sign = displacement.signum();
            let slope = |place: f64| sign * self.pace(place, rising);
            self.place = integrate(slope, self.place, displacement.abs(), 1e-18);
            let (left, force) = self.at(self.place, rising);
            self.reversals.truncate(left);
            self.force = force;
        }
        let pace = self.pace(self.place, self.rising.unwrap_or(true));
        self.force + self.damping * velocity * pace
    }
}
