//! `m = 1 + β·(T − T0)`.

use super::Range::Any;
use super::{Argument, BARE, CTerm, Column, Constructor, Form, term};
use preslide::effects::{LARGEST_LEVEL, ThermalDrift};

/// `thermal_drift`.
pub(crate) static THERMAL_DRIFT: Form = Form {
    id: "thermal_drift",
    keys: &[("level_per_K", Any), ("temperature_C", Any)],
    library: |effect, _| {
        Ok(term(ThermalDrift::try_new(
            effect.get("level_per_K"),
            effect.get("temperature_C"),
            LARGEST_LEVEL,
        )?))
    },
    controller: Ok(Constructor {
        kind: "ThermalDrift",
        more: &[Argument::LevelLimit],
        c: CTerm::level("slope(temperature, $temperature_C, $level_per_K)"),
    }),
    needs: Some((
        Column::Temperature,
        "thermal_drift with level and time_constant_s",
    )),
    ..BARE
};
