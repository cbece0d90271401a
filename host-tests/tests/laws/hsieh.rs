//! Eqs. (4)–(6) marched explicitly in steps far shorter than the sample time.

/// The parameters and the memory, in SI; every reversal of the spring is kept until its loop closes.
pub struct Hsieh {
    /// `k_1s` (N/m).
    pub k1: f64,
    /// `k_2s` (N/m).
    pub k2: f64,
    /// `β` (1/m).
    pub beta: f64,
    /// `ρ` (1/s).
    pub creep: f64,
    /// `ψ`.
    pub hardening: f64,
    /// `a`.
    pub exponent: f64,
    /// Position, plastic displacement and work hardening (m).
    motion: [f64; 3],
    spring: Vec<(f64, f64)>,
    last: (f64, f64),
    rising: Option<bool>,
}

impl Hsieh {
    /// The virgin state for `[k_1s, k_2s, β, ρ, ψ, a]`.
    pub fn new([k1, k2, beta, creep, hardening, exponent]: [f64; 6]) -> Self {
        Self {
            k1,
            k2,
            beta,
            creep,
            hardening,
            exponent,
            motion: [0.0; 3],
            spring: Vec::new(),
            last: (0.0, 0.0),
            rising: None,
        }
    }

    /// Moves by `displacement` (m) at a constant rate over `time` (s) in `steps` steps. Returns the spring's
    /// force (N) and the plastic rate (m/s) at the end.
    pub fn advance(&mut self, displacement: f64, time: f64, steps: usize) -> (f64, f64) {
        let h = time / steps as f64;
        let mut plastic_rate = 0.0;
        for _ in 0..steps {
            let [position, plastic, hardened] = &mut self.motion;
            let force = self.last.1;
            let hardening = (force.abs().powf(self.exponent) / self.hardening - *hardened).max(0.0);
            let rate = self.creep * hardening;
            plastic_rate = rate * force.signum();
            *hardened += rate * h;
            *plastic += plastic_rate * h;
            *position += displacement / steps as f64;
            let spring = *position - *plastic;
            self.stretch(spring);
        }
        (self.last.1, plastic_rate)
    }

    /// Eq. (4) at the spring displacement `x`.
    fn stretch(&mut self, x: f64) {
        if x == self.last.0 {
            return;
        }
        let rising = x > self.last.0;
        if self.rising.is_some_and(|before| before != rising) {
            self.spring.push(self.last);
        }
        self.rising = Some(rising);
        while let [.., before, _] = self.spring.as_slice() {
            if (x < before.0) == rising {
                break;
            }
            self.spring.truncate(self.spring.len() - 2);
        }
        let (from, force) = self.spring.last().copied().unwrap_or((0.0, 0.0));
        let d = x - from;
        let bent = self.k2 / self.beta * -(-self.beta * d.abs()).exp_m1();
        self.last = (x, force + self.k1 * d + bent.copysign(d));
    }
}
