//! `[friction]`: its keys, and the friction model that they describe.

use crate::friction::{FrictionModel, MOST_BLOCKS};
use preslide::{Block, HsiehParams, LeuvenForm, Sliding};
use serde::Deserialize;

/// The scalar keys that belong to one kind or another.
macro_rules! keys {
    ($($key:ident)*) => {
        /// Keys of a linear axis; those of a rotary one are translated first ([`super::ROTARY`]).
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(non_snake_case)] // unit symbols are written as in the file
        pub(super) struct FrictionToml {
            kind: String,
            pub(super) viscous_N_s_per_m: Option<f64>,
            blocks: Option<Vec<BlockToml>>,
            $($key: Option<f64>,)*
        }

        impl FrictionToml {
            /// Those that the file has.
            fn given(&self) -> impl Iterator<Item = &'static str> {
                let keys = [$((stringify!($key), self.$key)),*];
                keys.into_iter().filter_map(|(key, value)| value.map(|_| key))
            }
        }
    };
}

keys! {
    breakaway_N coulomb_N stribeck_velocity_m_s stribeck_exponent attraction_N_per_s stiffness_N_per_m exponent damping_N_s_per_m
    k1_N_per_m k2_N_per_m beta_per_m creep_per_s hardening hardening_exponent shape elastic_m presliding_m
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub(super) struct BlockToml {
    stiffness_N_per_m: f64,
    weight: f64,
}

/// The key that is wrong, and why.
type Wrong = (&'static str, String);

impl FrictionToml {
    /// The model that the keys describe, or the key that is wrong and why.
    pub(super) fn model(&self) -> Result<FrictionModel, Wrong> {
        let model = match self.kind.as_str() {
            "coulomb" => FrictionModel::Coulomb {
                coulomb: self.coulomb()?,
            },
            "dahl" => FrictionModel::Dahl {
                stiffness: self.stiffness()?,
                coulomb: self.coulomb()?,
                exponent: self.exponent()?,
            },
            "bouc_wen" => FrictionModel::BoucWen {
                stiffness: self.stiffness()?,
                coulomb: self.coulomb()?,
                exponent: self.exponent()?,
                shape: self.need("shape", self.shape)?,
            },
            "hsieh" => self.hsieh()?,
            "lugre" | "elasto_plastic" | "leuven" | "leuven_original" | "two_state" | "gms" => {
                self.with_stribeck(self.need("breakaway_N", self.breakaway_N)?)?
            }
            other => {
                let reason = format!(
                    "\"{other}\" is not known; use coulomb, dahl, bouc_wen, lugre, elasto_plastic, leuven, leuven_original, two_state, hsieh or gms"
                );
                return Err(("kind", reason));
            }
        };
        self.nothing_unused(&model)?;
        Ok(model)
    }

    fn hsieh(&self) -> Result<FrictionModel, Wrong> {
        Ok(FrictionModel::Hsieh(HsiehParams {
            k1: self.need("k1_N_per_m", self.k1_N_per_m)?,
            k2: self.need("k2_N_per_m", self.k2_N_per_m)?,
            beta: self.need("beta_per_m", self.beta_per_m)?,
            viscous: self.damping(),
            creep: self.need("creep_per_s", self.creep_per_s)?,
            hardening: self.need("hardening", self.hardening)?,
            hardening_exponent: self.need("hardening_exponent", self.hardening_exponent)?,
        }))
    }

    /// The kinds that slide along a Stribeck curve after they broke away at `breakaway` (N).
    fn with_stribeck(&self, breakaway: f64) -> Result<FrictionModel, Wrong> {
        let curve = || Ok::<_, Wrong>(self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway)));
        Ok(match self.kind.as_str() {
            "lugre" => FrictionModel::LuGre {
                stiffness: self.stiffness()?,
                damping: self.damping(),
                breakaway,
                sliding: curve()?,
            },
            "elasto_plastic" => FrictionModel::ElastoPlastic {
                stiffness: self.stiffness()?,
                damping: self.damping(),
                elastic: self.need("elastic_m", self.elastic_m)?,
                breakaway,
                sliding: curve()?,
            },
            "two_state" => FrictionModel::TwoState {
                distance: self.need("presliding_m", self.presliding_m)?,
                breakaway,
                sliding: curve()?,
            },
            "gms" => FrictionModel::Gms {
                breakaway,
                blocks: self.blocks()?,
                sliding: self.sliding(breakaway)?,
            },
            leuven => FrictionModel::Leuven {
                form: match leuven {
                    "leuven_original" => LeuvenForm::Original,
                    _ => LeuvenForm::Modified,
                },
                breakaway,
                blocks: self.blocks()?,
                exponent: self.exponent()?,
                damping: self.damping(),
                sliding: curve()?,
            },
        })
    }

    fn need(&self, key: &'static str, value: Option<f64>) -> Result<f64, Wrong> {
        value.ok_or_else(|| (key, format!("missing; kind = \"{}\" needs it", self.kind)))
    }

    fn stiffness(&self) -> Result<f64, Wrong> {
        self.need("stiffness_N_per_m", self.stiffness_N_per_m)
    }

    fn coulomb(&self) -> Result<f64, Wrong> {
        self.need("coulomb_N", self.coulomb_N)
    }

    fn exponent(&self) -> Result<f64, Wrong> {
        self.need("exponent", self.exponent)
    }

    fn damping(&self) -> f64 {
        self.damping_N_s_per_m.unwrap_or(0.0)
    }

    /// A key that the kind does not have would be a parameter that is silently not used.
    fn nothing_unused(&self, model: &FrictionModel) -> Result<(), Wrong> {
        let kind = &self.kind;
        if self.blocks.is_some() && model.blocks().is_empty() {
            let reason = format!("kind = \"{kind}\" has no blocks; remove it");
            return Err(("blocks", reason));
        }
        let used = model.scalars();
        let unused = |key: &&str| !used.iter().any(|(name, _)| name == key);
        match self.given().find(unused) {
            Some(key) => Err((key, format!("kind = \"{kind}\" does not use it; remove it"))),
            None => Ok(()),
        }
    }

    /// The blocks of the kinds that are made of them.
    fn blocks(&self) -> Result<Vec<Block>, Wrong> {
        let blocks = self.blocks.as_ref().ok_or((
            "blocks",
            format!("missing; kind = \"{}\" needs it", self.kind),
        ))?;
        if blocks.is_empty() || blocks.len() > MOST_BLOCKS {
            let reason = format!("{} blocks; give 1 to {MOST_BLOCKS}", blocks.len());
            return Err(("blocks", reason));
        }
        Ok(blocks
            .iter()
            .map(|block| Block {
                stiffness: block.stiffness_N_per_m,
                weight: block.weight,
            })
            .collect())
    }

    /// The Stribeck keys, which come together or not at all.
    fn sliding(&self, breakaway: f64) -> Result<Option<Sliding>, Wrong> {
        match (self.coulomb_N, self.stribeck_velocity_m_s) {
            (None, None) => Ok(None),
            (Some(coulomb), Some(stribeck_velocity)) => Ok(Some(Sliding {
                coulomb,
                stribeck_velocity,
                stribeck_exponent: self.stribeck_exponent.unwrap_or(2.0),
                attraction: self.attraction_N_per_s.unwrap_or(f64::INFINITY),
            })),
            (Some(_), None) => Err((
                "stribeck_velocity_m_s",
                format!("missing; needed because coulomb_N differs from breakaway_N = {breakaway}"),
            )),
            (None, Some(_)) => Err((
                "coulomb_N",
                "missing; needed because stribeck_velocity_m_s is given".to_owned(),
            )),
        }
    }
}

impl FrictionModel {
    /// The scalar parameters by their keys on a linear axis; those of the Stribeck curve last.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        let mut copy = self.clone();
        let own = copy.own_scalars().into_iter();
        let mut scalars: Vec<_> = own.map(|(key, value)| (key, *value)).collect();
        if let Some(sliding) = self.sliding() {
            scalars.extend([
                ("coulomb_N", sliding.coulomb),
                ("stribeck_velocity_m_s", sliding.stribeck_velocity),
                ("stribeck_exponent", sliding.stribeck_exponent),
                ("attraction_N_per_s", sliding.attraction),
            ]);
        }
        scalars
    }

    /// Those beside the Stribeck curve.
    pub(crate) fn own_scalars(&mut self) -> Vec<(&'static str, &mut f64)> {
        match self {
            Self::Coulomb { coulomb } => vec![("coulomb_N", coulomb)],
            Self::Dahl {
                stiffness,
                coulomb,
                exponent,
            } => vec![
                ("stiffness_N_per_m", stiffness),
                ("coulomb_N", coulomb),
                ("exponent", exponent),
            ],
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                ..
            } => vec![
                ("stiffness_N_per_m", stiffness),
                ("damping_N_s_per_m", damping),
                ("breakaway_N", breakaway),
            ],
            Self::BoucWen {
                stiffness,
                coulomb,
                exponent,
                shape,
            } => vec![
                ("stiffness_N_per_m", stiffness),
                ("coulomb_N", coulomb),
                ("exponent", exponent),
                ("shape", shape),
            ],
            Self::ElastoPlastic {
                stiffness,
                damping,
                elastic,
                breakaway,
                ..
            } => vec![
                ("stiffness_N_per_m", stiffness),
                ("damping_N_s_per_m", damping),
                ("elastic_m", elastic),
                ("breakaway_N", breakaway),
            ],
            Self::Leuven {
                breakaway,
                exponent,
                damping,
                ..
            } => vec![
                ("breakaway_N", breakaway),
                ("exponent", exponent),
                ("damping_N_s_per_m", damping),
            ],
            Self::TwoState {
                distance,
                breakaway,
                ..
            } => vec![("presliding_m", distance), ("breakaway_N", breakaway)],
            Self::Hsieh(p) => vec![
                ("k1_N_per_m", &mut p.k1),
                ("k2_N_per_m", &mut p.k2),
                ("beta_per_m", &mut p.beta),
                ("damping_N_s_per_m", &mut p.viscous),
                ("creep_per_s", &mut p.creep),
                ("hardening", &mut p.hardening),
                ("hardening_exponent", &mut p.hardening_exponent),
            ],
            Self::Gms { breakaway, .. } => vec![("breakaway_N", breakaway)],
        }
    }
}
