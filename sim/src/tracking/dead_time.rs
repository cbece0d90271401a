//! What the bridge's dead time costs, and what making up for it wins back.
//!
//! The friction fed forward is the stage's own ([`Perfect`]), so that nothing else hides the bridge's part.

use super::{Axis, FIXED_UNITS, Perfect, Step, Tracking, TrackingError, motions};
use crate::stage::{ElectricalConfig, StageConfig};
use fixed::types::I16F16;
use preslide::control::{Hardware, Settings};
use preslide::{Scalar, Units};
use preslide_fit::report::Table;
use rayon::prelude::*;

/// A bridge, and whether the controller knows of its dead time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bridge {
    /// Duty acts as its mean voltage.
    Ideal,
    /// It switches, without dead time.
    Switching,
    /// With dead time, of which the controller does not know.
    Dead,
    /// With dead time, which the controller makes up for.
    MadeUp,
}

/// RMS errors (m) over the nested triangles and the slide, all seeds; NaN where a run ended in a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Nested triangles.
    pub nested_m: f64,
    /// Slide at 1 mm/s.
    pub slide_m: f64,
}

/// A row of the study: both arithmetics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The bridge.
    pub bridge: Bridge,
    /// In `f32`, and in fixed point.
    pub errors: [Errors; 2],
}

/// All bridges, with the dead time and the diodes of `electrical`, on a stage of each seed.
///
/// # Errors
/// [`TrackingError`] where a controller or a stage cannot be built.
pub fn study(
    settings: &Settings,
    electrical: &ElectricalConfig,
    seeds: &[u64],
) -> Result<Vec<Row>, TrackingError> {
    let bridges = [
        Bridge::Ideal,
        Bridge::Switching,
        Bridge::Dead,
        Bridge::MadeUp,
    ];
    let row = |&bridge: &Bridge| {
        Ok(Row {
            bridge,
            errors: [
                errors::<f32>(settings, electrical, bridge, Units::SI, seeds)?,
                errors::<I16F16>(settings, electrical, bridge, FIXED_UNITS, seeds)?,
            ],
        })
    };
    bridges.par_iter().map(row).collect()
}

/// Of what the dead time added to an error, the share that making up for it wins back (-).
pub fn share(rows: &[Row], error: impl Fn(&Row) -> f64) -> f64 {
    let of = |bridge| {
        let row = rows.iter().find(|row| row.bridge == bridge);
        row.map_or(f64::NAN, &error)
    };
    (of(Bridge::Dead) - of(Bridge::MadeUp)) / (of(Bridge::Dead) - of(Bridge::Switching))
}

fn errors<S: Scalar + Send + Sync>(
    settings: &Settings,
    electrical: &ElectricalConfig,
    bridge: Bridge,
    units: Units,
    seeds: &[u64],
) -> Result<Errors, TrackingError> {
    let hardware = match bridge {
        Bridge::MadeUp => settings
            .hardware
            .with_dead_time(electrical.dead_time_s, electrical.diode_v),
        _ => Hardware {
            dead_time: 0.0,
            ..settings.hardware
        },
    };
    let settings = &Settings {
        hardware,
        ..*settings
    };
    let electrical = match bridge {
        Bridge::Ideal => None,
        Bridge::Switching => Some(ElectricalConfig {
            dead_time_s: 0.0,
            ..electrical.clone()
        }),
        Bridge::Dead | Bridge::MadeUp => Some(electrical.clone()),
    };
    let stage = StageConfig {
        electrical,
        ..StageConfig::default()
    };
    let rms = |steps: Vec<Step>| {
        let moves = Step::plan_all(&steps, settings)?;
        let mut tracking = Tracking::default();
        for &seed in seeds {
            let stage = StageConfig {
                seed,
                ..stage.clone()
            };
            let friction = Perfect::<S>::try_new(&stage, units)?;
            let mut axis = Axis::try_new(settings, friction, units, stage)?;
            axis.follow(&moves, |now| tracking.add(&now, settings.encoder.count));
        }
        Ok::<_, TrackingError>(tracking.rms_m().unwrap_or(f64::NAN))
    };
    Ok(Errors {
        nested_m: rms(motions::nested_triangles())?,
        slide_m: rms(motions::slide())?,
    })
}

/// A column's head and its error, metres.
type Column = (&'static str, fn(&Row) -> f64);

/// The rows for people.
pub fn print(rows: &[Row]) -> String {
    let name = |row: &Row| match row.bridge {
        Bridge::Ideal => "ideal",
        Bridge::Switching => "switching, no dead time",
        Bridge::Dead => "dead time, not compensated",
        Bridge::MadeUp => "dead time, compensated",
    };
    let columns: [Column; 4] = [
        ("nested, f32", |row| row.errors[0].nested_m),
        ("nested, fixed", |row| row.errors[1].nested_m),
        ("slide, f32", |row| row.errors[0].slide_m),
        ("slide, fixed", |row| row.errors[1].slide_m),
    ];
    let caption = "RMS error (nm) with the stage's own friction fed forward";
    let mut table = Table::of(caption, rows).column("bridge", |row| name(row).to_owned());
    for (head, error) in columns {
        table = table.column(head, |row| format!("{:.1}", 1e9 * error(row)));
    }
    let mut table = table.table();
    let won = columns.map(|(_, error)| format!("{:.1} %", 100.0 * share(rows, error)));
    let name = "won back of the dead time's loss".to_owned();
    table.rows.push([name].into_iter().chain(won).collect());
    table.to_text()
}
