//! `[friction]`: its keys, and the friction model that they describe.

use crate::friction::{Curve, FrictionModel, Law, MOST_BLOCKS, is_damping, with_keys};
use preslide::{Block, Sliding};
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
            /// Those that the file has, with their values.
            fn given(&self) -> impl Iterator<Item = (&'static str, f64)> {
                let keys = [$((stringify!($key), self.$key)),*];
                keys.into_iter().filter_map(|(key, value)| Some((key, value?)))
            }
        }
    };
}

with_keys! { keys }

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
        // One of its law, whose every parameter is then replaced.
        let all = FrictionModel::one_of_each(1.0, 1.0);
        let mut kinds: Vec<&str> = all.iter().map(FrictionModel::kind).collect();
        kinds.dedup();
        let of_kind = all.iter().find(|model| model.kind() == self.kind);
        let Some(mut model) = of_kind.cloned() else {
            let last = kinds.pop().unwrap_or_default();
            let (other, kinds) = (&self.kind, kinds.join(", "));
            let reason = format!("\"{other}\" is not known; use {kinds} or {last}");
            return Err(("kind", reason));
        };
        let Law {
            mut scalars,
            blocks,
            curve,
            ..
        } = model.law();
        // What follows from the breakaway force comes after it.
        scalars.sort_by_key(|(key, _)| *key != "breakaway_N");
        let mut scalars = scalars.into_iter().peekable();
        let mut breakaway = 0.0;
        if let Some((key, force)) = scalars.next_if(|(key, _)| *key == "breakaway_N") {
            *force = self.need(key)?;
            breakaway = *force;
        }
        if let Some(blocks) = blocks {
            *blocks = self.blocks()?;
        }
        for (key, value) in scalars {
            *value = match self.value(key) {
                None if is_damping(key) => 0.0,
                _ => self.need(key)?,
            };
        }
        match curve {
            Curve::None => {}
            Curve::Always(sliding) => {
                *sliding = self.sliding(breakaway)?.unwrap_or(Sliding::none(breakaway));
            }
            Curve::Optional(sliding) => *sliding = self.sliding(breakaway)?,
        }
        self.nothing_unused(&model)?;
        Ok(model)
    }

    fn value(&self, key: &str) -> Option<f64> {
        self.given()
            .find(|(name, _)| *name == key)
            .map(|(_, value)| value)
    }

    fn need(&self, key: &'static str) -> Result<f64, Wrong> {
        let missing = || (key, format!("missing; kind = \"{}\" needs it", self.kind));
        self.value(key).ok_or_else(missing)
    }

    /// A key that the kind does not have would be a parameter that is silently not used.
    fn nothing_unused(&self, model: &FrictionModel) -> Result<(), Wrong> {
        let kind = &self.kind;
        if self.blocks.is_some() && model.blocks().is_empty() {
            let reason = format!("kind = \"{kind}\" has no blocks; remove it");
            return Err(("blocks", reason));
        }
        let used = model.scalars();
        let unused = |(key, _): &(&str, f64)| !used.iter().any(|(name, _)| name == key);
        match self.given().find(unused) {
            Some((key, _)) => Err((key, format!("kind = \"{kind}\" does not use it; remove it"))),
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
