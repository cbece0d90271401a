//! The quasi-static Maxwell-slip model by its reversal points: no block has a state of its own.
//!
//! With the virgin curve `φ(u) = Σ min(k_i·u, W_i)`, a branch from the reversal `(x_r, F_r)` is
//! `F = F_r ± 2·φ(|x − x_r|/2)` (Masing). A branch that reaches the reversal before the last continues the
//! branch that was interrupted there; the branch from the first reversal joins the virgin curve at that
//! point's mirror image.

/// Position (counts, exact) and force (N) at a reversal.
struct Reversal {
    position: i64,
    force: f64,
}

/// The model and its memory.
pub struct Masing {
    /// `(k_i, W_i)` in N/m, N.
    blocks: Vec<(f64, f64)>,
    /// Length of a count (m).
    count: f64,
    reversals: Vec<Reversal>,
    position: i64,
    force: f64,
    rising: Option<bool>,
}

impl Masing {
    /// `(k_i, α_i)` of each block, the breakaway force (N), and the length of a count (m).
    pub fn new(blocks: &[(f64, f64)], breakaway: f64, count: f64) -> Self {
        Self {
            blocks: blocks.iter().map(|&(k, a)| (k, a * breakaway)).collect(),
            count,
            reversals: Vec::new(),
            position: 0,
            force: 0.0,
            rising: None,
        }
    }

    fn virgin(&self, counts: f64) -> f64 {
        let u = counts * self.count;
        self.blocks.iter().map(|&(k, w)| (k * u).min(w)).sum()
    }

    /// Moves by a number of counts and returns the force (N).
    pub fn advance(&mut self, counts: i32) -> f64 {
        if counts == 0 {
            return self.force;
        }
        let rising = counts > 0;
        if self.rising.is_some_and(|before| before != rising) {
            self.reversals.push(Reversal {
                position: self.position,
                force: self.force,
            });
        }
        self.rising = Some(rising);
        self.position += i64::from(counts);
        loop {
            match self.reversals.as_slice() {
                [.., before, _] if (self.position >= before.position) == rising => {
                    self.reversals.truncate(self.reversals.len() - 2);
                }
                [first] if self.position.abs() >= first.position.abs() => self.reversals.clear(),
                _ => break,
            }
        }
        let sign = if rising { 1.0 } else { -1.0 };
        self.force = match self.reversals.last() {
            Some(last) => {
                let travel = (self.position - last.position).abs() as f64;
                last.force + sign * 2.0 * self.virgin(0.5 * travel)
            }
            None => sign * self.virgin(self.position.abs() as f64),
        };
        self.force
    }
}
