//! The rest of the family: models with parameters that enter nonlinearly, where these may lie, and what is left linear.

pub mod bench;
pub mod fit;
pub mod starts;
#[cfg(test)]
pub(crate) mod tests;

use crate::friction::FrictionModel;
use clap::ValueEnum;
use preslide::{Block, HsiehParams, LeuvenForm, Sliding};

/// A friction model that is fitted by a nonlinear optimiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Family {
    /// Dahl, with its exponent: pre-sliding without a memory of nested loops.
    Dahl,
    /// Dahl with n = 1, the usual choice in controllers.
    DahlLinear,
    /// LuGre: bristles with a Stribeck curve.
    #[value(name = "lugre")]
    LuGre,
    /// Bouc-Wen: hysteresis as in structures.
    BoucWen,
    /// The elasto-plastic model: LuGre without drift below breakaway.
    ElastoPlastic,
    /// Leuven, in the form without the jump, with a stretched exponential as transition curve.
    Leuven,
    /// The two-state model: a branch from the last reversal, and a level that lags.
    TwoState,
    /// Hsieh and Pan: a nonlinear spring with memory in series with a plastic module.
    Hsieh,
}

/// What a recording can show, which bounds the search.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Displacement of a typical sample (m or rad).
    pub shortest: f64,
    /// Half of the longest stroke (m or rad).
    pub longest: f64,
    /// Highest speed (m/s or rad/s).
    pub speed: f64,
    /// Time between samples (s).
    pub sample_time: f64,
    /// Time from the first sample to the last (s).
    pub duration: f64,
}

/// A positive parameter that the optimiser moves, as its logarithm, between two bounds.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// What it is, for messages.
    pub name: &'static str,
    /// Least value.
    pub from: f64,
    /// Greatest value.
    pub to: f64,
}

/// The exponent of LuGre's Stribeck curve; one recording seldom separates it from the Stribeck velocity.
const STRIBECK_EXPONENT: f64 = 2.0;

impl Family {
    /// All of them.
    pub const ALL: [Family; 8] = [
        Family::Dahl,
        Family::DahlLinear,
        Family::BoucWen,
        Family::LuGre,
        Family::ElastoPlastic,
        Family::Leuven,
        Family::TwoState,
        Family::Hsieh,
    ];

    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Family::Dahl => "Dahl",
            Family::DahlLinear => "Dahl, n = 1",
            Family::LuGre => "LuGre",
            Family::BoucWen => "Bouc-Wen",
            Family::ElastoPlastic => "elasto-plastic",
            Family::Leuven => "Leuven",
            Family::TwoState => "two-state",
            Family::Hsieh => "Hsieh",
        }
    }

    /// The nonlinear parameters. Every one is a length, a velocity, a rate or a ratio: the level of the force is
    /// linear and is solved for, see [`Family::model`].
    pub fn parameters(self, span: &Span) -> Vec<Bounded> {
        let bounded = |name, from, to| Bounded { name, from, to };
        // A pre-sliding length below a sample's displacement cannot be seen, one beyond a few strokes is a spring.
        let (shortest, longest) = (span.shortest / 3.0, span.longest * 3.0);
        match self {
            Family::Dahl => vec![
                bounded("F_c/sigma_0", shortest, longest),
                bounded("n", 0.1, 5.0),
            ],
            Family::DahlLinear => vec![bounded("F_c/sigma_0", shortest, longest)],
            Family::LuGre => vec![
                bounded("F_s/sigma_0", shortest, longest),
                // Breakaway at more than three times the sliding force is no dry or lubricated contact.
                bounded("F_c/F_s", 1.0 / 3.0, 1.0),
                bounded("v_s", 1e-3 * span.speed, 3.0 * span.speed),
            ],
            Family::BoucWen => vec![
                bounded("F_c/sigma_0", shortest, longest),
                bounded("n", 1.0, 10.0),
                bounded("sigma", 0.5, 2.0),
            ],
            Family::ElastoPlastic => vec![
                bounded("F_s/sigma_0", shortest, longest),
                bounded("z_ba*sigma_0/F_c", 0.01, 0.9),
                bounded("F_c/F_s", 1.0 / 3.0, 1.0),
                bounded("v_s", 1e-3 * span.speed, 3.0 * span.speed),
            ],
            Family::Leuven => vec![
                bounded("transition length", shortest, longest),
                // 1 is an exponential; below it the curve is the steeper at its start.
                bounded("transition exponent", 0.3, 1.0),
                bounded("n", 1.0, 20.0),
            ],
            Family::TwoState => vec![
                bounded("pre-sliding distance", 3.0 * shortest, 3.0 * longest),
                bounded("F_c/F_s", 1.0 / 3.0, 1.0),
                bounded("v_s", 1e-3 * span.speed, 3.0 * span.speed),
            ],
            Family::Hsieh => vec![
                bounded("1/beta", shortest, longest),
                bounded("k_2s/(beta*k_1s)", 0.1 * span.longest, 1e3 * span.longest),
                bounded("rho", 0.01 / span.duration, 3.0 / span.sample_time),
                bounded("1/psi", 1e-3 * span.shortest, 10.0 * span.longest),
                bounded("a", 0.5, 10.0),
            ],
        }
    }

    /// Whether the model has a viscous term of its own: LuGre's `σp·dz/dt` and its relatives', Hsieh's `C_v·dx_s/dt`.
    pub fn is_damped(self) -> bool {
        matches!(
            self,
            Family::LuGre | Family::ElastoPlastic | Family::Leuven | Family::Hsieh
        )
    }

    /// Number of friction parameters that are fitted, without offset and rigid body.
    pub fn parameter_count(self) -> usize {
        match self {
            Family::Dahl => 3,
            Family::DahlLinear => 2,
            Family::BoucWen | Family::TwoState => 4,
            Family::LuGre | Family::Leuven => 5,
            Family::ElastoPlastic => 6,
            Family::Hsieh => 7,
        }
    }

    /// The model with the parameters `nonlinear`, whose force is
    /// `amplitude·(force of model(nonlinear, 1, 0)) + damping·(force of model(nonlinear, 1, 1) − force of model(nonlinear, 1, 0))`.
    ///
    /// `amplitude` (N or N·m) is `F_c` (Dahl, Bouc-Wen), `k_2s/β` (Hsieh), else `F_s`; `damping` (N·s/m or N·m·s/rad) is
    /// `σp` (LuGre), `σ1` (elasto-plastic, Leuven), `C_v` (Hsieh). Hsieh's hardening scales with the amplitude as `ψ = ψ'·amplitudeᵃ`. `None`
    /// where `nonlinear` has the wrong length.
    pub fn model(self, nonlinear: &[f64], amplitude: f64, damping: f64) -> Option<FrictionModel> {
        Some(match (self, nonlinear) {
            (Family::Dahl, &[length, exponent]) => FrictionModel::Dahl {
                stiffness: amplitude / length,
                coulomb: amplitude,
                exponent,
            },
            (Family::DahlLinear, &[length]) => FrictionModel::Dahl {
                stiffness: amplitude / length,
                coulomb: amplitude,
                exponent: 1.0,
            },
            (Family::LuGre, &[length, weakening, stribeck_velocity]) => FrictionModel::LuGre {
                stiffness: amplitude / length,
                damping,
                breakaway: amplitude,
                sliding: stribeck(amplitude, weakening, stribeck_velocity),
            },
            (Family::BoucWen, &[length, exponent, shape]) => FrictionModel::BoucWen {
                stiffness: amplitude / length,
                coulomb: amplitude,
                exponent: exponent.max(1.0),
                shape: shape.clamp(0.5, 2.0),
            },
            (Family::ElastoPlastic, &[length, elastic, weakening, stribeck_velocity]) => {
                let weakening = weakening.min(1.0);
                FrictionModel::ElastoPlastic {
                    stiffness: amplitude / length,
                    damping,
                    // Not to exceed the library's bound by rounding.
                    elastic: elastic.min(0.9 - 1e-9) * weakening * length,
                    breakaway: amplitude,
                    sliding: stribeck(amplitude, weakening, stribeck_velocity),
                }
            }
            (Family::Leuven, &[length, stretch, exponent]) => FrictionModel::Leuven {
                form: LeuvenForm::Modified,
                breakaway: amplitude,
                blocks: transition_blocks(length, stretch.min(1.0), amplitude),
                exponent: exponent.clamp(1.0, 20.0),
                damping,
                sliding: Sliding::none(amplitude),
            },
            (Family::TwoState, &[distance, weakening, stribeck_velocity]) => {
                FrictionModel::TwoState {
                    distance,
                    breakaway: amplitude,
                    sliding: stribeck(amplitude, weakening, stribeck_velocity),
                }
            }
            (Family::Hsieh, &[length, linear_length, creep, softness, exponent]) => {
                FrictionModel::Hsieh(HsiehParams {
                    k1: amplitude / linear_length,
                    k2: amplitude / length,
                    beta: 1.0 / length,
                    viscous: damping,
                    creep,
                    hardening: amplitude.powf(exponent) / softness,
                    hardening_exponent: exponent,
                })
            }
            _ => return None,
        })
    }
}

/// A Stribeck curve without lag.
fn stribeck(breakaway: f64, weakening: f64, stribeck_velocity: f64) -> Sliding {
    Sliding {
        coulomb: breakaway * weakening.min(1.0),
        stribeck_velocity,
        stribeck_exponent: STRIBECK_EXPONENT,
        attraction: f64::INFINITY,
    }
}

/// Blocks of Leuven's transition curve.
const TRANSITION_BLOCKS: usize = 8;

/// Maxwell-slip blocks whose virgin curve meets `F_s·(1 − exp(−(z/length)^stretch))` where it has risen by equal steps
/// of the force, and `F_s` after the last. The curve is concave, so every stiffness is positive.
fn transition_blocks(length: f64, stretch: f64, breakaway: f64) -> Vec<Block> {
    let steps = TRANSITION_BLOCKS as f64;
    let place = |share: f64| length * (-(1.0 - share).ln()).powf(1.0 / stretch);
    // The last chord ends half a step before the top, where the curve would never arrive.
    let mut corners: Vec<(f64, f64)> = (0..TRANSITION_BLOCKS)
        .map(|i| i as f64 / steps)
        .chain([1.0 - 0.5 / steps])
        .map(|share| (place(share), share * breakaway))
        .collect();
    let reached = 1.0 - 0.5 / steps;
    for corner in &mut corners {
        corner.1 /= reached;
    }
    let slopes: Vec<f64> = corners
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
        .chain([0.0])
        .collect();
    corners[1..]
        .iter()
        .zip(slopes.windows(2))
        .map(|(corner, slopes)| {
            let stiffness = slopes[0] - slopes[1];
            Block {
                stiffness,
                weight: stiffness * corner.0 / breakaway,
            }
        })
        .collect()
}
