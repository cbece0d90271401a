//! The library's friction models, chosen at run time and run along a recording in `f64`.

mod contact;

pub use contact::Tick;

use contact::{AtWork, Driven};
use preslide::{
    Block, BoucWen, Coulomb, Dahl, ElastoPlastic, Friction, Gms, Hsieh, HsiehParams, Leuven,
    LeuvenForm, LuGre, ParamError, QuasiStaticGms, Sliding, TwoState, Units,
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
        distance: f64,
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

/// What lies between the measured motion and the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transmission {
    /// Rate (m/s or rad/s) and share `p` (-) of Eyring's law, by which the contact gives way: `rate·sinh(F/(p·F_limit))`.
    pub creep: Option<(f64, f64)>,
    /// Play (m or rad), the whole width.
    pub gap: f64,
}

/// Something to do with any of the library's models, in the number type `S`.
pub trait Visitor<S = f64> {
    /// The result.
    type Outcome;

    /// Does it.
    fn visit<M: Friction<Scalar = S, State: Send> + Send + 'static>(
        self,
        model: M,
    ) -> Self::Outcome;
}

/// Calls `$body` with `$n` bound to a constant equal to the number of blocks.
macro_rules! with_blocks {
    ($blocks:expr, $array:ident => $body:expr, [$($n:literal)*]) => {
        match $blocks.len() {
            $($n => {
                let mut $array = [preslide::Block { stiffness: 0.0, weight: 0.0 }; $n];
                $array.copy_from_slice($blocks);
                $body
            })*
            other => Err(preslide::ParamError::new("number of blocks", other as f64, preslide::Bound::AtMost(MOST_BLOCKS as f64))),
        }
    };
}

impl FrictionModel {
    /// Its name in tables.
    pub fn name(&self) -> String {
        match self {
            Self::Coulomb { .. } => "Coulomb + viscous".to_owned(),
            Self::Dahl { exponent: 1.0, .. } => "Dahl, n = 1".to_owned(),
            Self::Dahl { .. } => "Dahl".to_owned(),
            Self::LuGre { .. } => "LuGre".to_owned(),
            Self::BoucWen { .. } => "Bouc-Wen".to_owned(),
            Self::ElastoPlastic { .. } => "elasto-plastic".to_owned(),
            Self::Leuven {
                form: LeuvenForm::Modified,
                ..
            } => "Leuven".to_owned(),
            Self::Leuven { .. } => "Leuven, original".to_owned(),
            Self::TwoState { .. } => "two-state".to_owned(),
            Self::Hsieh(_) => "Hsieh".to_owned(),
            Self::Gms { blocks, .. } => format!("GMS, N = {}", blocks.len()),
        }
    }

    /// Its name in model files and tables.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Coulomb { .. } => "coulomb",
            Self::Dahl { .. } => "dahl",
            Self::LuGre { .. } => "lugre",
            Self::BoucWen { .. } => "bouc_wen",
            Self::ElastoPlastic { .. } => "elasto_plastic",
            Self::Leuven {
                form: LeuvenForm::Modified,
                ..
            } => "leuven",
            Self::Leuven {
                form: LeuvenForm::Original,
                ..
            } => "leuven_original",
            Self::TwoState { .. } => "two_state",
            Self::Hsieh(_) => "hsieh",
            Self::Gms { .. } => "gms",
        }
    }

    /// The same at `factor` times the force, its displacements and velocities as they are; `None` where the library bounds no such force.
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        let mut scaled = self.clone();
        if let Self::Hsieh(_) = scaled {
            return None;
        }
        for (key, value) in scaled.own_scalars() {
            if key.contains("_N") {
                *value *= factor;
            }
        }
        let (blocks, sliding) = scaled.shape();
        blocks.iter_mut().for_each(|b| b.stiffness *= factor);
        if let Some(sliding) = sliding {
            sliding.coulomb *= factor;
            sliding.attraction *= factor;
        }
        Some(scaled)
    }

    /// The same without damping and along a Stribeck curve of another form, which follows from its breakaway force (N); `None` where the
    /// law has no such curve.
    pub fn along(&self, curve: impl Fn(f64) -> Sliding) -> Option<Self> {
        let (mut other, curve) = (self.clone(), curve(self.breakaway()?));
        if let Self::Gms { sliding, .. } = &mut other {
            *sliding = Some(curve);
            return Some(other);
        }
        *other.shape().1? = curve;
        let mut scalars = other.own_scalars().into_iter();
        if let Some((_, damping)) = scalars.find(|(key, _)| key.starts_with("damping")) {
            *damping = 0.0;
        }
        Some(other)
    }

    /// Blocks and Stribeck curve, of the kinds that have them.
    fn shape(&mut self) -> (&mut [Block], Option<&mut Sliding>) {
        match self {
            Self::LuGre { sliding, .. }
            | Self::ElastoPlastic { sliding, .. }
            | Self::TwoState { sliding, .. } => (&mut [], Some(sliding)),
            Self::Leuven {
                blocks, sliding, ..
            } => (blocks, Some(sliding)),
            Self::Gms {
                blocks, sliding, ..
            } => (blocks, sliding.as_mut()),
            Self::Coulomb { .. } | Self::Dahl { .. } | Self::BoucWen { .. } | Self::Hsieh(_) => {
                (&mut [], None)
            }
        }
    }

    /// The force (N) at which the body breaks away, where the model has such a parameter.
    pub fn breakaway(&self) -> Option<f64> {
        match self {
            Self::Coulomb { coulomb }
            | Self::Dahl { coulomb, .. }
            | Self::BoucWen { coulomb, .. } => Some(*coulomb),
            Self::LuGre { breakaway, .. }
            | Self::ElastoPlastic { breakaway, .. }
            | Self::Leuven { breakaway, .. }
            | Self::TwoState { breakaway, .. }
            | Self::Gms { breakaway, .. } => Some(*breakaway),
            Self::Hsieh(_) => None,
        }
    }

    /// The blocks of the kinds that are made of them; none for the others.
    pub fn blocks(&self) -> &[Block] {
        match self {
            Self::Gms { blocks, .. } | Self::Leuven { blocks, .. } => blocks,
            _ => &[],
        }
    }

    /// The Stribeck curve, where the model has one.
    pub fn sliding(&self) -> Option<Sliding> {
        self.clone().shape().1.copied()
    }

    /// One model of every kind, of forces in units of `f` newtons and lengths in units of `l` metres.
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
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                sliding,
            },
            Self::BoucWen {
                stiffness,
                coulomb: f,
                exponent: 1.2,
                shape: 0.7,
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
                distance: 0.2 * l,
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
        self.force_through(path, Transmission::default())
    }

    /// The same behind a transmission that is not stiff and tight.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter, or where there is creep but no highest force.
    pub fn force_through(
        &self,
        path: Path,
        transmission: Transmission,
    ) -> Result<Vec<f64>, ParamError> {
        self.visit(path.sample_time, Driven { path, transmission })?
    }

    /// The same from rest, tick after tick of `sample_time` (s).
    ///
    /// # Errors
    /// As there.
    pub fn at_work(
        &self,
        transmission: Transmission,
        sample_time: f64,
    ) -> Result<Tick, ParamError> {
        let visitor = AtWork {
            transmission,
            sample_time,
        };
        self.visit(sample_time, visitor)?
    }

    /// Hands the library's model, in SI and for ticks of `sample_time` (s), to `visitor`.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter.
    pub fn visit<V: Visitor>(
        &self,
        sample_time: f64,
        visitor: V,
    ) -> Result<V::Outcome, ParamError> {
        let units = Units::SI;
        Ok(match self {
            Self::Coulomb { coulomb } => {
                visitor.visit(Coulomb::<f64>::try_new(*coulomb, 0.0, units)?)
            }
            Self::Dahl {
                stiffness,
                coulomb,
                exponent,
            } => visitor.visit(Dahl::<f64>::try_new(
                *stiffness, *coulomb, *exponent, units,
            )?),
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                sliding,
            } => visitor.visit(LuGre::<f64>::try_new(
                *stiffness, *damping, *breakaway, *sliding, units,
            )?),
            Self::BoucWen {
                stiffness,
                coulomb,
                exponent,
                shape,
            } => visitor.visit(BoucWen::<f64>::try_new(
                *stiffness, *coulomb, *exponent, *shape, units,
            )?),
            Self::ElastoPlastic {
                stiffness,
                damping,
                elastic,
                breakaway,
                sliding,
            } => visitor.visit(ElastoPlastic::<f64>::try_new(
                *stiffness, *damping, *elastic, *breakaway, *sliding, units,
            )?),
            Self::Leuven {
                form,
                breakaway,
                blocks,
                exponent,
                damping,
                sliding,
            } => with_blocks!(blocks, array => Ok(visitor.visit(Leuven::<_, f64>::try_new(
                *form, &array, *breakaway, *exponent, *damping, *sliding, units,
            )?)), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16])?,
            Self::TwoState {
                distance,
                breakaway,
                sliding,
            } => visitor.visit(TwoState::<f64>::try_new(
                *distance,
                *breakaway,
                *sliding,
                sample_time,
                units,
            )?),
            Self::Hsieh(params) => {
                visitor.visit(Hsieh::<f64>::try_new(params, sample_time, units)?)
            }
            Self::Gms {
                breakaway,
                blocks,
                sliding: None,
            } => with_blocks!(blocks, array => Ok(visitor.visit(QuasiStaticGms::<_, f64>::try_new(
                &array, *breakaway, units,
            )?)), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16])?,
            Self::Gms {
                breakaway,
                blocks,
                sliding: Some(sliding),
            } => with_blocks!(blocks, array => Ok(visitor.visit(Gms::<_, f64>::try_new(
                &array, *breakaway, *sliding, sample_time, units,
            )?)), [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16])?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scale of a million, as a power of two so that scaling rounds nothing.
    const MILLION: f64 = 1_048_576.0;

    /// The friction along three strokes that shrink.
    fn force(
        model: &FrictionModel,
        l: f64,
        transmission: Transmission,
    ) -> Result<Vec<f64>, ParamError> {
        let (samples, sample_time) = (900, 1e-3);
        let phase = |i: usize| i as f64 * 0.021;
        let position: Vec<f64> = (0..samples)
            .map(|i| l * phase(i).sin() * (1.0 - i as f64 / 1200.0))
            .collect();
        let rate = |i: usize| match i {
            0 => 0.0,
            i => (position[i] - position[i - 1]) / sample_time,
        };
        let velocity: Vec<f64> = (0..samples).map(rate).collect();
        let path = Path {
            position: &position,
            velocity: &velocity,
            pieces: &[0..400, 400..samples],
            sample_time,
        };
        model.force_through(path, transmission)
    }

    /// Units are the user's choice: a law of a million newtons or a millionth of a metre is the same law.
    #[test]
    fn every_law_is_the_same_at_any_scale_of_force_and_length() {
        let transmissions = |l: f64| {
            let (creep, gap) = (Some((1e-3 * l, 0.2)), 0.05 * l);
            [(None, 0.0), (None, gap), (creep, 0.0), (creep, gap)]
                .map(|(creep, gap)| Transmission { creep, gap })
        };
        let mut crept = 0;
        for (law, model) in FrictionModel::one_of_each(1.0, 1.0).iter().enumerate() {
            for (k, transmission) in transmissions(1.0).into_iter().enumerate() {
                // A law without a highest force has none that creep could be a share of, and says so.
                let one = match force(model, 1.0, transmission) {
                    Err(_) if transmission.creep.is_some() => continue,
                    one => one.unwrap_or_else(|e| panic!("{model:?}: {e}")),
                };
                crept += usize::from(transmission.creep.is_some());
                let most = one.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
                assert!(most > 0.5, "{model:?}: {most}");
                for f in [1.0 / MILLION, 1.0, 1024.0, MILLION] {
                    for l in [1.0 / MILLION, 1.0, MILLION] {
                        let scaled = force(
                            &FrictionModel::one_of_each(f, l)[law],
                            l,
                            transmissions(l)[k],
                        )
                        .unwrap_or_else(|e| panic!("{}, {f} N, {l} m: {e}", model.name()));
                        let worst = one
                            .iter()
                            .zip(&scaled)
                            .map(|(a, b)| (a - b / f).abs())
                            .fold(0.0, f64::max);
                        // Scaled by powers of two, only what is not scaled itself rounds otherwise.
                        assert!(
                            worst <= 1e-5 * most,
                            "{}, transmission {k}, force {f} N, length {l} m: off by {worst} of {most}",
                            model.name()
                        );
                        assert!(scaled.iter().all(|f| f.is_finite()));
                    }
                }
            }
        }
        assert!(crept >= 8, "creep went with {crept} laws and gaps only");
    }
}
