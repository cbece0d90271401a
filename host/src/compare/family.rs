//! The models with parameters that enter nonlinearly: their parameters, where these may lie, and what is left linear.

use crate::friction::FrictionModel;
use preslide::{HsiehParams, Sliding};

/// A friction model that is fitted by a nonlinear optimiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// [`FrictionModel::Dahl`].
    Dahl,
    /// [`FrictionModel::Dahl`] with `n = 1`, the usual choice in controllers.
    DahlLinear,
    /// [`FrictionModel::LuGre`].
    LuGre,
    /// [`FrictionModel::Hsieh`].
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

/// The exponent of LuGre's Stribeck curve; one recording seldom tells it from the Stribeck velocity.
const STRIBECK_EXPONENT: f64 = 2.0;

impl Family {
    /// All of them.
    pub const ALL: [Family; 4] = [
        Family::Dahl,
        Family::DahlLinear,
        Family::LuGre,
        Family::Hsieh,
    ];

    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Family::Dahl => "Dahl",
            Family::DahlLinear => "Dahl, n = 1",
            Family::LuGre => "LuGre",
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
            Family::Hsieh => vec![
                bounded("1/beta", shortest, longest),
                bounded("k_2s/(beta*k_1s)", 0.1 * span.longest, 1e3 * span.longest),
                bounded("rho", 0.01 / span.duration, 3.0 / span.sample_time),
                bounded("1/psi", 1e-3 * span.shortest, 10.0 * span.longest),
                bounded("a", 0.5, 10.0),
            ],
        }
    }

    /// Whether the model has a viscous term of its own: LuGre's `σp·dz/dt`, Hsieh's `C_v·dx_s/dt`.
    pub fn is_damped(self) -> bool {
        matches!(self, Family::LuGre | Family::Hsieh)
    }

    /// Number of friction parameters that are fitted, without offset and rigid body.
    pub fn parameter_count(self) -> usize {
        match self {
            Family::Dahl => 3,
            Family::DahlLinear => 2,
            Family::LuGre => 5,
            Family::Hsieh => 7,
        }
    }

    /// The model with the nonlinear parameters `place`, whose force is
    /// `amplitude·(force of model(place, 1, 0)) + damping·(force of model(place, 1, 1) − force of model(place, 1, 0))`.
    ///
    /// `amplitude` (N or N·m) is `F_c` (Dahl), `F_s` (LuGre), `k_2s/β` (Hsieh); `damping` (N·s/m or N·m·s/rad) is
    /// `σp` (LuGre), `C_v` (Hsieh). Hsieh's hardening scales with the amplitude as `ψ = ψ'·amplitudeᵃ`. `None`
    /// where `place` has the wrong length.
    pub fn model(self, place: &[f64], amplitude: f64, damping: f64) -> Option<FrictionModel> {
        Some(match (self, place) {
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
                sliding: Sliding {
                    coulomb: amplitude * weakening.min(1.0),
                    stribeck_velocity,
                    stribeck_exponent: STRIBECK_EXPONENT,
                    attraction: f64::INFINITY,
                },
            },
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
