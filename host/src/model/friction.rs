//! `[friction]`: its keys, and the friction model that they describe.

use crate::friction::{FrictionModel, MOST_BLOCKS};
use preslide::{Block, HsiehParams, LeuvenForm, Sliding};
use serde::Deserialize;

/// Keys of a linear axis; those of a rotary one are translated first ([`super::ROTARY`]).
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)] // unit symbols are written as in the file
pub(super) struct FrictionToml {
    kind: String,
    pub(super) viscous_N_s_per_m: Option<f64>,
    breakaway_N: Option<f64>,
    coulomb_N: Option<f64>,
    stribeck_velocity_m_s: Option<f64>,
    stribeck_exponent: Option<f64>,
    attraction_N_per_s: Option<f64>,
    blocks: Option<Vec<BlockToml>>,
    stiffness_N_per_m: Option<f64>,
    exponent: Option<f64>,
    damping_N_s_per_m: Option<f64>,
    k1_N_per_m: Option<f64>,
    k2_N_per_m: Option<f64>,
    beta_per_m: Option<f64>,
    creep_per_s: Option<f64>,
    hardening: Option<f64>,
    hardening_exponent: Option<f64>,
    shape: Option<f64>,
    elastic_m: Option<f64>,
    presliding_m: Option<f64>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub(super) struct BlockToml {
    stiffness_N_per_m: f64,
    weight: f64,
}

impl FrictionToml {
    /// The model that the keys describe, or the key that is wrong and why.
    pub(super) fn model(&self) -> Result<FrictionModel, (&'static str, String)> {
        let kind = self.kind.as_str();
        let need = |key: &'static str, value: Option<f64>| {
            value.ok_or_else(|| (key, format!("missing; kind = \"{kind}\" needs it")))
        };
        let model = match kind {
            "coulomb" => FrictionModel::Coulomb {
                coulomb: need("coulomb_N", self.coulomb_N)?,
            },
            "dahl" => FrictionModel::Dahl {
                stiffness: need("stiffness_N_per_m", self.stiffness_N_per_m)?,
                coulomb: need("coulomb_N", self.coulomb_N)?,
                exponent: need("exponent", self.exponent)?,
            },
            "lugre" => {
                let breakaway = need("breakaway_N", self.breakaway_N)?;
                FrictionModel::LuGre {
                    stiffness: need("stiffness_N_per_m", self.stiffness_N_per_m)?,
                    damping: self.damping_N_s_per_m.unwrap_or(0.0),
                    breakaway,
                    sliding: self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway)),
                }
            }
            "hsieh" => FrictionModel::Hsieh(HsiehParams {
                k1: need("k1_N_per_m", self.k1_N_per_m)?,
                k2: need("k2_N_per_m", self.k2_N_per_m)?,
                beta: need("beta_per_m", self.beta_per_m)?,
                viscous: self.damping_N_s_per_m.unwrap_or(0.0),
                creep: need("creep_per_s", self.creep_per_s)?,
                hardening: need("hardening", self.hardening)?,
                hardening_exponent: need("hardening_exponent", self.hardening_exponent)?,
            }),
            "gms" => {
                let breakaway = need("breakaway_N", self.breakaway_N)?;
                FrictionModel::Gms {
                    breakaway,
                    blocks: self.blocks()?,
                    sliding: self.sliding(breakaway)?,
                }
            }
            "bouc_wen" => FrictionModel::BoucWen {
                stiffness: need("stiffness_N_per_m", self.stiffness_N_per_m)?,
                coulomb: need("coulomb_N", self.coulomb_N)?,
                exponent: need("exponent", self.exponent)?,
                shape: need("shape", self.shape)?,
            },
            "elasto_plastic" => {
                let breakaway = need("breakaway_N", self.breakaway_N)?;
                FrictionModel::ElastoPlastic {
                    stiffness: need("stiffness_N_per_m", self.stiffness_N_per_m)?,
                    damping: self.damping_N_s_per_m.unwrap_or(0.0),
                    elastic: need("elastic_m", self.elastic_m)?,
                    breakaway,
                    sliding: self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway)),
                }
            }
            "leuven" | "leuven_original" => {
                let breakaway = need("breakaway_N", self.breakaway_N)?;
                FrictionModel::Leuven {
                    form: if kind == "leuven" {
                        LeuvenForm::Modified
                    } else {
                        LeuvenForm::Original
                    },
                    breakaway,
                    blocks: self.blocks()?,
                    exponent: need("exponent", self.exponent)?,
                    damping: self.damping_N_s_per_m.unwrap_or(0.0),
                    sliding: self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway)),
                }
            }
            "two_state" => {
                let breakaway = need("breakaway_N", self.breakaway_N)?;
                FrictionModel::TwoState {
                    distance: need("presliding_m", self.presliding_m)?,
                    breakaway,
                    sliding: self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway)),
                }
            }
            other => {
                let reason = format!(
                    "\"{other}\" is not known; use coulomb, dahl, bouc_wen, lugre, elasto_plastic, leuven, leuven_original, two_state, hsieh or gms"
                );
                return Err(("kind", reason));
            }
        };
        // A key that the kind does not have would be a parameter that is silently not used.
        let used = model.scalars();
        let has_blocks = matches!(
            model,
            FrictionModel::Gms { .. } | FrictionModel::Leuven { .. }
        );
        if self.blocks.is_some() && !has_blocks {
            return Err((
                "blocks",
                format!("kind = \"{kind}\" has no blocks; remove it"),
            ));
        }
        match self
            .given()
            .find(|key| !used.iter().any(|(name, _)| name == key))
        {
            Some(key) => Err((key, format!("kind = \"{kind}\" does not use it; remove it"))),
            None => Ok(model),
        }
    }

    /// The scalar keys of the file that belong to one kind or another.
    fn given(&self) -> impl Iterator<Item = &'static str> {
        [
            ("breakaway_N", self.breakaway_N),
            ("coulomb_N", self.coulomb_N),
            ("stribeck_velocity_m_s", self.stribeck_velocity_m_s),
            ("stribeck_exponent", self.stribeck_exponent),
            ("attraction_N_per_s", self.attraction_N_per_s),
            ("stiffness_N_per_m", self.stiffness_N_per_m),
            ("exponent", self.exponent),
            ("damping_N_s_per_m", self.damping_N_s_per_m),
            ("k1_N_per_m", self.k1_N_per_m),
            ("k2_N_per_m", self.k2_N_per_m),
            ("beta_per_m", self.beta_per_m),
            ("creep_per_s", self.creep_per_s),
            ("hardening", self.hardening),
            ("hardening_exponent", self.hardening_exponent),
            ("shape", self.shape),
            ("elastic_m", self.elastic_m),
            ("presliding_m", self.presliding_m),
        ]
        .into_iter()
        .filter_map(|(key, value)| value.map(|_| key))
    }

    /// The blocks of the kinds that are made of them.
    fn blocks(&self) -> Result<Vec<Block>, (&'static str, String)> {
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
    fn sliding(&self, breakaway: f64) -> Result<Option<Sliding>, (&'static str, String)> {
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
    /// The scalar parameters by their keys on a linear axis.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        let stribeck = |sliding: &Sliding| {
            vec![
                ("coulomb_N", sliding.coulomb),
                ("stribeck_velocity_m_s", sliding.stribeck_velocity),
                ("stribeck_exponent", sliding.stribeck_exponent),
                ("attraction_N_per_s", sliding.attraction),
            ]
        };
        match self {
            Self::Coulomb { coulomb } => vec![("coulomb_N", *coulomb)],
            Self::Dahl {
                stiffness,
                coulomb,
                exponent,
            } => vec![
                ("stiffness_N_per_m", *stiffness),
                ("coulomb_N", *coulomb),
                ("exponent", *exponent),
            ],
            Self::LuGre {
                stiffness,
                damping,
                breakaway,
                sliding,
            } => [
                vec![
                    ("stiffness_N_per_m", *stiffness),
                    ("damping_N_s_per_m", *damping),
                    ("breakaway_N", *breakaway),
                ],
                stribeck(sliding),
            ]
            .concat(),
            Self::BoucWen {
                stiffness,
                coulomb,
                exponent,
                shape,
            } => vec![
                ("stiffness_N_per_m", *stiffness),
                ("coulomb_N", *coulomb),
                ("exponent", *exponent),
                ("shape", *shape),
            ],
            Self::ElastoPlastic {
                stiffness,
                damping,
                elastic,
                breakaway,
                sliding,
            } => [
                vec![
                    ("stiffness_N_per_m", *stiffness),
                    ("damping_N_s_per_m", *damping),
                    ("elastic_m", *elastic),
                    ("breakaway_N", *breakaway),
                ],
                stribeck(sliding),
            ]
            .concat(),
            Self::Leuven {
                breakaway,
                exponent,
                damping,
                sliding,
                ..
            } => [
                vec![
                    ("breakaway_N", *breakaway),
                    ("exponent", *exponent),
                    ("damping_N_s_per_m", *damping),
                ],
                stribeck(sliding),
            ]
            .concat(),
            Self::TwoState {
                distance,
                breakaway,
                sliding,
            } => [
                vec![("presliding_m", *distance), ("breakaway_N", *breakaway)],
                stribeck(sliding),
            ]
            .concat(),
            Self::Hsieh(p) => vec![
                ("k1_N_per_m", p.k1),
                ("k2_N_per_m", p.k2),
                ("beta_per_m", p.beta),
                ("damping_N_s_per_m", p.viscous),
                ("creep_per_s", p.creep),
                ("hardening", p.hardening),
                ("hardening_exponent", p.hardening_exponent),
            ],
            Self::Gms {
                breakaway, sliding, ..
            } => [
                vec![("breakaway_N", *breakaway)],
                sliding.as_ref().map(stribeck).unwrap_or_default(),
            ]
            .concat(),
        }
    }
}
