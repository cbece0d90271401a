//! The effort of a model along a recording, as a column.

use super::weak::Column;
use preslide_fit::model::{Measured, Model};
use preslide_fit::recording::Recording;
use preslide_fit::signal::Kinematics;

/// The effort of a model along a recording, its inertia exact within the rows' kernel: a filtered acceleration is not.
///
/// # Errors
/// An effect that needs what was not recorded.
pub(super) fn effort_of(model: &Model, recording: &Recording) -> Result<Column, String> {
    let kinematics = Kinematics::of(recording);
    // What acts behind the actuator acts on the inertia's force, too.
    let measured = Measured {
        t_s: Some(&recording.t_s),
        acceleration: Some(&kinematics.acceleration),
        temperature_c: recording.temperature_c.as_deref(),
        load_n: recording.load_n.as_deref(),
    };
    let mut value = model.force_along(kinematics.path(recording), &measured)?;
    value
        .iter_mut()
        .zip(&kinematics.acceleration)
        .for_each(|(f, a)| *f -= model.inertia * a);
    let curved = recording
        .position
        .iter()
        .map(|x| model.inertia * x)
        .collect();
    Ok(Column {
        value,
        curved,
        ..Column::default()
    })
}
