//! `m = 1 + c·(load − load0)`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Column, Constructor, Form, term};
use preslide::Units;
use preslide::effects::{LARGEST_LEVEL, LoadDependentFriction};

/// `load_dependent_friction`.
pub(crate) static LOAD_DEPENDENT_FRICTION: Form = Form {
    id: "load_dependent_friction",
    keys: &[("level_per_N", Any), ("load_N", Any)],
    library: |effect, _| {
        Ok(term(LoadDependentFriction::try_new(
            effect.get("level_per_N"),
            effect.get("load_N"),
            LARGEST_LEVEL,
            Units::SI,
        )?))
    },
    controller: Ok(Constructor {
        kind: "LoadDependentFriction",
        more: &[Argument::LevelLimit, Argument::Units],
        c: CTerm::level("slope(load, $load_N, $level_per_N)"),
    }),
    needs: Some((Column::Load, "a constant friction level")),
    ..BARE
};
