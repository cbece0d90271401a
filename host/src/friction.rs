//! The library's friction models, chosen at run time and run along a recording in `f64`.

use preslide::{
    Block, Coulomb, Dahl, Friction, Gms, Hsieh, HsiehParams, LuGre, Motion, ParamError,
    QuasiStaticGms, Sliding, Units,
};
use std::ops::Range;

/// Most blocks that a model file may have.
pub const MOST_BLOCKS: usize = 16;

/// A friction model and its parameters, in SI.
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

/// A motion to run a model along.
#[derive(Clone, Copy)]
pub struct Path<'a> {
    /// Position (m or rad).
    pub position: &'a [f64],
    /// Velocity (m/s or rad/s).
    pub velocity: &'a [f64],
    /// Contiguous samples; a model keeps its state from one to the next.
    pub pieces: &'a [Range<usize>],
    /// Time between samples (s).
    pub sample_time: f64,
}

impl Path<'_> {
    /// The force (N or N·m) of `model` at every sample, from rest; `creep` (m/s or rad/s) is the rate at which the
    /// contact gives way under its highest force.
    fn run<M: Friction<Scalar = f64>>(
        &self,
        model: &M,
        creep: f64,
    ) -> Result<Vec<f64>, ParamError> {
        let yielding = match model.limit() {
            _ if creep == 0.0 => 0.0,
            Some(limit) if limit > 0.0 => creep * self.sample_time / limit,
            _ => {
                return Err(ParamError {
                    parameter: "rate of creep, of a friction model without a highest force,",
                    block: None,
                    value: creep,
                    bound: preslide::Bound::AtMost(0.0),
                });
            }
        };
        let mut state = model.at_rest();
        let mut force = vec![0.0; self.position.len()];
        let mut now = 0.0;
        for piece in self.pieces {
            let Some(&(mut last)) = self.position.get(piece.start) else {
                continue;
            };
            for i in piece.clone() {
                let motion = Motion {
                    displacement: self.position[i] - last - yielding * now,
                    velocity: self.velocity[i],
                };
                last = self.position[i];
                now = model.step(&mut state, motion);
                force[i] = now;
            }
        }
        Ok(force)
    }
}

/// Calls `$body` with `$n` bound to a constant equal to the number of blocks.
macro_rules! with_blocks {
    ($blocks:expr, $array:ident => $body:expr, [$($n:literal)*]) => {
        match $blocks.len() {
            $($n => {
                let mut $array = [Block { stiffness: 0.0, weight: 0.0 }; $n];
                $array.copy_from_slice($blocks);
                $body
            })*
            other => Err(ParamError {
                parameter: "number of blocks",
                block: None,
                value: other as f64,
                bound: preslide::Bound::AtMost(MOST_BLOCKS as f64),
            }),
        }
    };
}

impl FrictionModel {
    /// Its name in model files and tables.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Coulomb { .. } => "coulomb",
            Self::Dahl { .. } => "dahl",
            Self::LuGre { .. } => "lugre",
            Self::Hsieh(_) => "hsieh",
            Self::Gms { .. } => "gms",
        }
    }

    /// The force (N) at which the body breaks away, where the model has such a parameter.
    pub fn breakaway(&self) -> Option<f64> {
        match self {
            Self::Coulomb { coulomb } | Self::Dahl { coulomb, .. } => Some(*coulomb),
            Self::LuGre { breakaway, .. } | Self::Gms { breakaway, .. } => Some(*breakaway),
            Self::Hsieh(_) => None,
        }
    }

    /// A quasi-static GMS from stiffnesses (N/m) and yield displacements (m).
    pub fn maxwell_slip(stiffness: &[f64], yields: &[f64]) -> Self {
        let breakaway: f64 = stiffness.iter().zip(yields).map(|(k, d)| k * d).sum();
        Self::Gms {
            breakaway,
            blocks: stiffness
                .iter()
                .zip(yields)
                .map(|(&k, d)| Block {
                    stiffness: k,
                    weight: k * d / breakaway,
                })
                .collect(),
            sliding: None,
        }
    }

    /// The friction force at every sample of `path`, computed by the library.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter.
    pub fn force(&self, path: Path) -> Result<Vec<f64>, ParamError> {
        self.force_creeping(path, 0.0)
    }

    /// The same with a contact that gives way under load, at the rate `creep` (m/s or rad/s) under its highest force.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter, or where there is creep but no highest force.
    pub fn force_creeping(&self, path: Path, creep: f64) -> Result<Vec<f64>, ParamError> {
        let units = Units::SI;
        match self {
            Self::Coulomb { coulomb } => {
                path.run(&Coulomb::<f64>::try_new(*coulomb, 0.0, units)?, creep)
            }
            Self::Dahl {
                stiffness,
                coulomb,
                exponent,
            } => path.run(
                &Dahl::<f64>::try_new(*stiffness, *coulomb, *exponent, units)?,
                creep,
            ),
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                sliding,
            } => path.run(
                &LuGre::<f64>::try_new(*stiffness, *damping, *breakaway, *sliding, units)?,
                creep,
            ),
            Self::Hsieh(params) => path.run(
                &Hsieh::<f64>::try_new(params, path.sample_time, units)?,
                creep,
            ),
            Self::Gms {
                breakaway,
                blocks,
                sliding: None,
            } => with_blocks!(blocks, array => path.run(&QuasiStaticGms::<_, f64>::try_new(
                &array, *breakaway, units,
            )?, creep), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16]),
            Self::Gms {
                breakaway,
                blocks,
                sliding: Some(sliding),
            } => with_blocks!(blocks, array => path.run(&Gms::<_, f64>::try_new(
                &array, *breakaway, *sliding, path.sample_time, units,
            )?, creep), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16]),
        }
    }
}
