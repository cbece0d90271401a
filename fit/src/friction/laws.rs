//! The friction models, each described once. Names, keys of model files, exported source, costs, fits and tests are made from these.
//!
//! To add a law: a variant of [`FrictionModel`], its row of `laws!` and its parameters in `one_of_each`. To have it fitted: a variant of [`Family`], in `ALL` and with an arm of `search`.

use super::law::{Curve, Law, laws};
use super::search::{Bounded, Span, bounded, stribeck, transition_blocks, weakening};
use super::{MOST_BLOCKS, Visitor};
use clap::ValueEnum;
use preslide::{
    Block, BoucWen, Bound, Coulomb, Dahl, ElastoPlastic, Gms, Hsieh, HsiehParams, Leuven,
    LeuvenForm, LuGre, ParamError, QuasiStaticGms, Scalar, Sliding, TwoState, Units,
};

/// A friction model and its parameters, in SI. Fields are named as their keys in a model file, without the unit.
#[derive(Clone, Debug, PartialEq)]
pub enum FrictionModel {
    /// [`Coulomb`]; viscous friction is kept beside every model, see [`crate::model::Model`].
    Coulomb {
        /// `F_c` (N).
        coulomb: f64,
    },
    /// [`Dahl`].
    Dahl {
        /// `σ0` (N/m).
        stiffness: f64,
        /// `F_c` (N).
        coulomb: f64,
        /// `n` (-).
        exponent: f64,
    },
    /// [`LuGre`].
    LuGre {
        /// `σ0` (N/m).
        stiffness: f64,
        /// `σp` (N·s/m).
        damping: f64,
        /// `F_s` (N).
        breakaway: f64,
        /// Stribeck curve.
        sliding: Sliding,
    },
    /// [`BoucWen`].
    BoucWen {
        /// `σ0` (N/m).
        stiffness: f64,
        /// `F_c` (N).
        coulomb: f64,
        /// `n` (-).
        exponent: f64,
        /// `σ` (-).
        shape: f64,
    },
    /// [`ElastoPlastic`].
    ElastoPlastic {
        /// `σ0` (N/m).
        stiffness: f64,
        /// `σ1` (N·s/m).
        damping: f64,
        /// `z_ba` (m).
        elastic: f64,
        /// `F_s` (N).
        breakaway: f64,
        /// Stribeck curve.
        sliding: Sliding,
    },
    /// [`Leuven`].
    Leuven {
        /// State equation.
        form: LeuvenForm,
        /// `F_s` (N).
        breakaway: f64,
        /// 1…[`MOST_BLOCKS`] blocks.
        blocks: Vec<Block>,
        /// `n` (-).
        exponent: f64,
        /// `σ1` (N·s/m).
        damping: f64,
        /// Stribeck curve.
        sliding: Sliding,
    },
    /// [`TwoState`].
    TwoState {
        /// `s` (m).
        presliding: f64,
        /// `F_s` (N).
        breakaway: f64,
        /// Stribeck curve and lag.
        sliding: Sliding,
    },
    /// [`Hsieh`].
    Hsieh(HsiehParams),
    /// [`QuasiStaticGms`], or [`Gms`] where `sliding` is given.
    Gms {
        /// `F_s` (N).
        breakaway: f64,
        /// 1…[`MOST_BLOCKS`] blocks.
        blocks: Vec<Block>,
        /// Stribeck curve and lag; `None` for the quasi-static law.
        sliding: Option<Sliding>,
    },
}

/// The scalar keys that belong to one law or another, on a linear axis, handed to a macro.
macro_rules! with_keys {
    ($do:ident) => {
        $do! {
            breakaway_N coulomb_N stribeck_velocity_m_s stribeck_exponent attraction_N_per_s stiffness_N_per_m exponent damping_N_s_per_m
            k1_N_per_m k2_N_per_m beta_per_m creep_per_s hardening hardening_exponent shape elastic_m presliding_m
        }
    };
}
pub(crate) use with_keys;

impl FrictionModel {
    /// The blocks of the laws that are made of them; none for the others.
    pub fn blocks(&self) -> &[Block] {
        match self {
            Self::Gms { blocks, .. } | Self::Leuven { blocks, .. } => blocks,
            _ => &[],
        }
    }

    /// One model of every law, of forces in units of `f` newtons and lengths in units of `l` metres.
    pub fn one_of_each(f: f64, l: f64) -> Vec<Self> {
        let (stiffness, damping, breakaway) = (8.0 * f / l, 0.02 * f / l, f);
        let blocks = || {
            [(5.0, 0.5), (2.0, 0.3), (0.5, 0.2)]
                .map(|(k, weight)| Block {
                    stiffness: k * f / l,
                    weight,
                })
                .to_vec()
        };
        let sliding = Sliding {
            coulomb: 0.8 * f,
            stribeck_velocity: 3.0 * l,
            stribeck_exponent: 2.0,
            attraction: 50.0 * f,
        };
        let leuven = |form| Self::Leuven {
            form,
            breakaway,
            blocks: blocks(),
            exponent: 1.5,
            damping,
            sliding,
        };
        let gms = |sliding| Self::Gms {
            breakaway,
            blocks: blocks(),
            sliding,
        };
        vec![
            Self::Coulomb { coulomb: f },
            Self::Dahl {
                stiffness,
                coulomb: f,
                exponent: 1.3,
            },
            Self::BoucWen {
                stiffness,
                coulomb: f,
                exponent: 1.2,
                shape: 0.7,
            },
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                sliding,
            },
            Self::ElastoPlastic {
                stiffness,
                damping,
                elastic: 0.04 * l,
                breakaway,
                sliding,
            },
            leuven(LeuvenForm::Modified),
            leuven(LeuvenForm::Original),
            Self::TwoState {
                presliding: 0.2 * l,
                breakaway,
                sliding,
            },
            Self::Hsieh(HsiehParams {
                k1: 0.2 * f / l,
                k2: 6.0 * f / l,
                beta: 7.0 / l,
                viscous: 0.0,
                creep: 5.0,
                hardening: 40.0 * f * f / l,
                hardening_exponent: 2.0,
            }),
            gms(None),
            gms(Some(sliding)),
        ]
    }
}

laws! {
    sample_time;
    Self::Coulomb { coulomb } => Coulomb(coulomb, 0.0) {
        kind: "coulomb",
        name: "Coulomb + viscous",
        scalars: [coulomb_N: coulomb],
    }
    Self::Dahl { stiffness, coulomb, exponent } => Dahl(stiffness, coulomb, exponent) {
        kind: "dahl",
        name: ["Dahl", "Dahl, n = 1"][usize::from(*exponent == 1.0)],
        scalars: [stiffness_N_per_m: stiffness, coulomb_N: coulomb, exponent: exponent],
        length: *coulomb / *stiffness,
    }
    Self::LuGre { stiffness, damping, breakaway, sliding } => LuGre(stiffness, damping, breakaway, sliding) {
        kind: "lugre",
        name: "LuGre",
        scalars: [stiffness_N_per_m: stiffness, damping_N_s_per_m: damping, breakaway_N: breakaway],
        length: *breakaway / *stiffness,
        curve: Curve::Always(sliding),
    }
    Self::BoucWen { stiffness, coulomb, exponent, shape } => BoucWen(stiffness, coulomb, exponent, shape) {
        kind: "bouc_wen",
        name: "Bouc-Wen",
        scalars: [stiffness_N_per_m: stiffness, coulomb_N: coulomb, exponent: exponent, shape: shape],
        length: *coulomb / *stiffness,
    }
    Self::ElastoPlastic { stiffness, damping, elastic, breakaway, sliding } =>
        ElastoPlastic(stiffness, damping, elastic, breakaway, sliding) {
        kind: "elasto_plastic",
        name: "elasto-plastic",
        scalars: [stiffness_N_per_m: stiffness, damping_N_s_per_m: damping, elastic_m: elastic, breakaway_N: breakaway],
        length: *breakaway / *stiffness,
        curve: Curve::Always(sliding),
    }
    Self::Leuven { form, breakaway, blocks, exponent, damping, sliding } =>
        Leuven of blocks(form, blocks, breakaway, exponent, damping, sliding) {
        kind: ["leuven", "leuven_original"][original(*form)],
        name: ["Leuven", "Leuven, original"][original(*form)],
        scalars: [breakaway_N: breakaway, exponent: exponent, damping_N_s_per_m: damping],
        length: blocks.iter().map(|b| b.yield_displacement(*breakaway)).fold(f64::INFINITY, f64::min),
        blocks: Some(blocks),
        curve: Curve::Always(sliding),
    }
    Self::TwoState { presliding, breakaway, sliding } => TwoState(presliding, breakaway, sliding, sample_time) {
        kind: "two_state",
        name: "two-state",
        scalars: [presliding_m: presliding, breakaway_N: breakaway],
        length: *presliding,
        curve: Curve::Always(sliding),
    }
    Self::Hsieh(params) => Hsieh(&params, sample_time) {
        kind: "hsieh",
        name: "Hsieh",
        scalars: [
            k1_N_per_m: &mut params.k1, k2_N_per_m: &mut params.k2, beta_per_m: &mut params.beta, damping_N_s_per_m: &mut params.viscous,
            creep_per_s: &mut params.creep, hardening: &mut params.hardening, hardening_exponent: &mut params.hardening_exponent
        ],
        length: 1.0 / params.beta,
    }
    Self::Gms { breakaway, blocks, sliding: sliding @ None } => QuasiStaticGms of blocks(blocks, breakaway) {
        kind: "gms",
        name: format!("GMS, N = {}", blocks.len()),
        scalars: [breakaway_N: breakaway],
        blocks: Some(blocks),
        curve: Curve::Optional(sliding),
    }
    Self::Gms { breakaway, blocks, sliding: Some(sliding) } => Gms of blocks(blocks, breakaway, sliding, sample_time) {
        kind: "gms",
        name: format!("GMS, N = {}", blocks.len()),
        scalars: [breakaway_N: breakaway],
        blocks: Some(blocks),
        curve: Curve::Always(sliding),
    }
}

fn original(form: LeuvenForm) -> usize {
    usize::from(form == LeuvenForm::Original)
}

/// How a law is searched for.
pub(super) struct Search {
    /// Bounds of the nonlinear parameters.
    pub(super) bounds: fn(&Span) -> Vec<Bounded>,
    /// See [`Family::model`].
    pub(super) model: fn(&[f64], f64, f64) -> Option<FrictionModel>,
}

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

impl Family {
    /// All of them, in the order of tables.
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

    /// How it is searched for.
    pub(super) fn search(self) -> Search {
        match self {
            Family::Dahl => Search {
                bounds: |span| {
                    vec![
                        span.length("pre-sliding length", 1.0),
                        bounded("exponent", 0.1, 5.0),
                    ]
                },
                model: |place, coulomb, _| {
                    let [length, exponent] = place.try_into().ok()?;
                    Some(FrictionModel::Dahl {
                        stiffness: coulomb / length,
                        coulomb,
                        exponent,
                    })
                },
            },
            Family::DahlLinear => Search {
                bounds: |span| vec![span.length("pre-sliding length", 1.0)],
                model: |place, coulomb, _| {
                    let [length] = place.try_into().ok()?;
                    Some(FrictionModel::Dahl {
                        stiffness: coulomb / length,
                        coulomb,
                        exponent: 1.0,
                    })
                },
            },
            Family::LuGre => Search {
                bounds: |span| {
                    vec![
                        span.length("pre-sliding length", 1.0),
                        weakening(),
                        span.stribeck_velocity(),
                    ]
                },
                model: |place, breakaway, damping| {
                    let [length, weakening, velocity] = place.try_into().ok()?;
                    Some(FrictionModel::LuGre {
                        stiffness: breakaway / length,
                        damping,
                        breakaway,
                        sliding: stribeck(breakaway, weakening, velocity),
                    })
                },
            },
            Family::BoucWen => Search {
                bounds: |span| {
                    vec![
                        span.length("pre-sliding length", 1.0),
                        bounded("exponent", 1.0, 10.0),
                        bounded("shape", 0.5, 2.0),
                    ]
                },
                model: |place, coulomb, _| {
                    let [length, exponent, shape]: [f64; 3] = place.try_into().ok()?;
                    Some(FrictionModel::BoucWen {
                        stiffness: coulomb / length,
                        coulomb,
                        exponent: exponent.max(1.0),
                        shape: shape.clamp(0.5, 2.0),
                    })
                },
            },
            Family::ElastoPlastic => Search {
                bounds: |span| {
                    vec![
                        span.length("pre-sliding length", 1.0),
                        bounded("elastic share of the pre-sliding length", 0.01, 0.9),
                        weakening(),
                        span.stribeck_velocity(),
                    ]
                },
                model: |place, breakaway, damping| {
                    let [length, elastic, weakening, velocity]: [f64; 4] = place.try_into().ok()?;
                    let weakening = weakening.min(1.0);
                    Some(FrictionModel::ElastoPlastic {
                        stiffness: breakaway / length,
                        damping,
                        // Not to exceed the library's bound by rounding.
                        elastic: elastic.min(0.9 - 1e-9) * weakening * length,
                        breakaway,
                        sliding: stribeck(breakaway, weakening, velocity),
                    })
                },
            },
            Family::Leuven => Search {
                bounds: |span| {
                    vec![
                        span.length("transition length", 1.0),
                        // 1 is an exponential; below it the curve is the steeper at its start.
                        bounded("transition exponent", 0.3, 1.0),
                        bounded("exponent", 1.0, 20.0),
                    ]
                },
                model: |place, breakaway, damping| {
                    let [length, stretch, exponent]: [f64; 3] = place.try_into().ok()?;
                    Some(FrictionModel::Leuven {
                        form: LeuvenForm::Modified,
                        breakaway,
                        blocks: transition_blocks(length, stretch.min(1.0), breakaway),
                        exponent: exponent.clamp(1.0, 20.0),
                        damping,
                        sliding: Sliding::none(breakaway),
                    })
                },
            },
            Family::TwoState => Search {
                bounds: |span| {
                    vec![
                        span.length("pre-sliding distance", 3.0),
                        weakening(),
                        span.stribeck_velocity(),
                    ]
                },
                model: |place, breakaway, _| {
                    let [presliding, weakening, velocity] = place.try_into().ok()?;
                    Some(FrictionModel::TwoState {
                        presliding,
                        breakaway,
                        sliding: stribeck(breakaway, weakening, velocity),
                    })
                },
            },
            Family::Hsieh => Search {
                bounds: |span: &Span| {
                    vec![
                        span.length("pre-sliding length", 1.0),
                        bounded("linear stiffness", 0.1 * span.longest, 1e3 * span.longest),
                        bounded("creep", 0.01 / span.duration, 3.0 / span.sample_time),
                        bounded("hardening", 1e-3 * span.shortest, 10.0 * span.longest),
                        bounded("hardening exponent", 0.5, 10.0),
                    ]
                },
                // The hardening scales with the amplitude as `ψ = ψ'·amplitudeᵃ`.
                model: |place, amplitude: f64, damping| {
                    let [length, linear_length, creep, softness, exponent] =
                        place.try_into().ok()?;
                    Some(FrictionModel::Hsieh(HsiehParams {
                        k1: amplitude / linear_length,
                        k2: amplitude / length,
                        beta: 1.0 / length,
                        viscous: damping,
                        creep,
                        hardening: amplitude.powf(exponent) / softness,
                        hardening_exponent: exponent,
                    }))
                },
            },
        }
    }
}
