//! Hysteresis laws of the trials: friction in pre-sliding as a function of the path.
//!
//! None of them is the model that the diagnosis fits: a continuum of yields, two virgin curves under
//! Masing's rule with a list of reversals, elements with internal damping, and one law that is held
//! out. No threshold may be set on trials of [`Law::HeldOut`].

use super::draw::Draw;

/// Which law a trial's friction follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Iwan's continuum (1966): 48 elastic-plastic elements whose yield displacements are log-normal.
    IwanLogNormal,
    /// Masing's rule over a virgin curve `((s+ε)^p − ε^p)` that ends in sliding at a finite displacement.
    MasingPower,
    /// Masing's rule over the Ramberg–Osgood-like virgin curve `r/(1+rⁿ)^(1/n)`, which saturates slowly.
    MasingRational,
    /// Elastic-plastic elements with a damper beside each spring: weakly dependent on rate.
    RateElastoplastic,
    /// Masing's rule over a sum of two exponentials of very different length. Never used to set a threshold.
    HeldOut,
}

/// All laws; a trial takes the one at `seed % 5`.
pub const LAWS: [Law; 5] = [
    Law::IwanLogNormal,
    Law::MasingPower,
    Law::MasingRational,
    Law::RateElastoplastic,
    Law::HeldOut,
];

impl Law {
    /// Name in labels and tables.
    pub fn name(self) -> &'static str {
        match self {
            Law::IwanLogNormal => "iwan_log_normal",
            Law::MasingPower => "masing_power",
            Law::MasingRational => "masing_rational",
            Law::RateElastoplastic => "rate_elastoplastic",
            Law::HeldOut => "held_out_law",
        }
    }
}

/// Elastic-plastic element in parallel with others.
#[derive(Clone, Copy, Debug)]
struct Element {
    stiffness: f64,
    limit: f64,
    force: f64,
}

/// Virgin curve: share of the breakaway force after a displacement `s` ≥ 0 (m).
#[derive(Clone, Copy, Debug)]
enum Virgin {
    Power {
        length: f64,
        offset: f64,
        exponent: f64,
    },
    Rational {
        length: f64,
        exponent: f64,
    },
    Exponentials {
        short: f64,
        long: f64,
        share: f64,
    },
}

impl Virgin {
    fn at(self, s: f64) -> f64 {
        match self {
            Virgin::Power {
                length,
                offset,
                exponent,
            } => {
                let base = offset.powf(exponent);
                let full = (length + offset).powf(exponent) - base;
                (((s + offset).powf(exponent) - base) / full).min(1.0)
            }
            Virgin::Rational { length, exponent } => {
                let r = s / length;
                r / (1.0 + r.powf(exponent)).powf(1.0 / exponent)
            }
            Virgin::Exponentials { short, long, share } => {
                1.0 - share * (-s / short).exp() - (1.0 - share) * (-s / long).exp()
            }
        }
    }
}

/// A reversal: position (m) and share of the breakaway force.
#[derive(Clone, Copy, Debug)]
struct Reversal {
    x: f64,
    share: f64,
}

#[derive(Clone, Debug)]
enum Memory {
    Elements {
        elements: Vec<Element>,
        /// Damping over stiffness of each element (s).
        damping_s: f64,
    },
    Masing {
        virgin: Virgin,
        reversals: Vec<Reversal>,
        x: f64,
        share: f64,
        direction: f64,
    },
}

/// A law with its parameters and what it remembers of the path.
#[derive(Clone, Debug)]
pub struct Hysteresis {
    breakaway: f64,
    memory: Memory,
}

impl Hysteresis {
    /// A law with breakaway force `breakaway` (N) and drawn lengths, unloaded, at position 0.
    pub fn draw(law: Law, breakaway: f64, draw: &mut Draw) -> Self {
        let masing = |virgin| Memory::Masing {
            virgin,
            reversals: Vec::new(),
            x: 0.0,
            share: 0.0,
            direction: 0.0,
        };
        let memory = match law {
            Law::IwanLogNormal => {
                let (median, spread) = (draw.log_uniform(4e-6, 12e-6), draw.uniform(0.8, 1.2));
                let quantiles = normal_quantiles::<48>();
                let limit = breakaway / quantiles.len() as f64;
                let element = |q: &f64| Element {
                    stiffness: limit / (median * (spread * q).exp()),
                    limit,
                    force: 0.0,
                };
                Memory::Elements {
                    elements: quantiles.iter().map(element).collect(),
                    damping_s: 0.0,
                }
            }
            Law::RateElastoplastic => {
                let (first, ratio) = (draw.log_uniform(1.5e-6, 3e-6), draw.uniform(1.5, 1.8));
                let weights: Vec<f64> = (0..9).map(|_| draw.uniform(0.5, 1.5)).collect();
                let total: f64 = weights.iter().sum();
                let elements = weights
                    .iter()
                    .enumerate()
                    .map(|(i, w)| Element {
                        stiffness: breakaway * w / total / (first * ratio.powi(i as i32)),
                        limit: breakaway * w / total,
                        force: 0.0,
                    })
                    .collect();
                Memory::Elements {
                    elements,
                    damping_s: draw.uniform(1e-4, 3e-4),
                }
            }
            Law::MasingPower => masing(Virgin::Power {
                length: draw.log_uniform(40e-6, 150e-6),
                offset: draw.log_uniform(0.5e-6, 2e-6),
                exponent: draw.uniform(0.35, 0.6),
            }),
            Law::MasingRational => masing(Virgin::Rational {
                length: draw.log_uniform(3e-6, 10e-6),
                exponent: draw.uniform(0.75, 1.3),
            }),
            Law::HeldOut => masing(Virgin::Exponentials {
                short: draw.log_uniform(2e-6, 6e-6),
                long: draw.log_uniform(25e-6, 90e-6),
                share: draw.uniform(0.4, 0.7),
            }),
        };
        Hysteresis { breakaway, memory }
    }

    /// Parallel blocks of given `(stiffness (N/m), limit (N))`, for the force of a model file.
    pub fn of_blocks(blocks: &[(f64, f64)]) -> Self {
        let elements = blocks
            .iter()
            .map(|&(stiffness, limit)| Element {
                stiffness,
                limit,
                force: 0.0,
            })
            .collect();
        Hysteresis {
            breakaway: blocks.iter().map(|b| b.1).sum(),
            memory: Memory::Elements {
                elements,
                damping_s: 0.0,
            },
        }
    }

    /// Force (N) after a displacement `s` ≥ 0 (m) from rest, slowly.
    pub fn virgin(&self, s: f64) -> f64 {
        match &self.memory {
            Memory::Elements { elements, .. } => elements
                .iter()
                .map(|e| (e.stiffness * s).min(e.limit))
                .sum(),
            Memory::Masing { virgin, .. } => self.breakaway * virgin.at(s),
        }
    }

    /// Moves by `dx` (m) at velocity `v` (m/s) and returns the force (N). `up` and `down` multiply the
    /// friction level against motion in +x and −x: the limits of elements, the force of Masing's laws.
    pub fn step(&mut self, dx: f64, v: f64, up: f64, down: f64) -> f64 {
        match &mut self.memory {
            Memory::Elements {
                elements,
                damping_s,
            } => {
                let mut force = 0.0;
                for e in elements {
                    let (low, high) = (-down * e.limit, up * e.limit);
                    e.force = (e.force + e.stiffness * dx).min(high).max(low);
                    force += (e.force + e.stiffness * *damping_s * v).min(high).max(low);
                }
                force
            }
            Memory::Masing {
                virgin,
                reversals,
                x,
                share,
                direction,
            } => {
                if dx != 0.0 {
                    let heading = dx.signum();
                    if *direction != 0.0 && heading != *direction {
                        reversals.push(Reversal {
                            x: *x,
                            share: *share,
                        });
                    }
                    *direction = heading;
                    *x += dx;
                    *share = masing(*virgin, reversals, *x, heading);
                }
                self.breakaway * *share * if *share > 0.0 { up } else { down }
            }
        }
    }
}

/// Masing's rule: each branch is the virgin curve doubled in both axes; a branch that reaches the reversal
/// where the one around it began continues that one, and both reversals are forgotten.
fn masing(virgin: Virgin, reversals: &mut Vec<Reversal>, x: f64, heading: f64) -> f64 {
    while let [.., before, _] = reversals.as_slice()
        && (x - before.x) * heading >= 0.0
    {
        reversals.truncate(reversals.len() - 2);
    }
    // The outermost branch closes at the mirror image of the first reversal.
    if let [only] = reversals.as_slice()
        && (x + only.x) * heading >= 0.0
    {
        reversals.clear();
    }
    match reversals.last() {
        Some(last) => last.share + 2.0 * heading * virgin.at(0.5 * (x - last.x).abs()),
        None => x.signum() * virgin.at(x.abs()),
    }
}

/// Standard normal quantiles at the middles of `N` equal shares.
fn normal_quantiles<const N: usize>() -> [f64; N] {
    // Trapezoidal sum of the density from −8, fine enough for quantiles to four digits.
    const STEP: f64 = 1e-3;
    let density = |q: f64| (-0.5 * q * q).exp() / std::f64::consts::TAU.sqrt();
    let mut quantiles = [0.0; N];
    let (mut q, mut below) = (-8.0, 0.0);
    for (i, quantile) in quantiles.iter_mut().enumerate() {
        let share = (i as f64 + 0.5) / N as f64;
        while below < share {
            below += 0.5 * STEP * (density(q) + density(q + STEP));
            q += STEP;
        }
        *quantile = q;
    }
    quantiles
}
