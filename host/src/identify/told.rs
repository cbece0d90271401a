//! What a recording tells that cannot show friction by direction: one-way turning, a jog, a few strokes.

use crate::recording::{MotionKind, Recording};
use crate::signal::Kinematics;
use nalgebra::{DMatrix, DVector};

/// Stretches of time that are fitted one by one; their scatter is the confidence.
const STRETCHES: usize = 6;

/// A coefficient is told where it is this many standard errors of the stretches' mean away from zero.
const CERTAIN: f64 = 3.0;

/// Inertia, viscous friction and constant effort, each where the stretches agree on it, and what stays open; a sentence.
pub(super) fn told(recording: &Recording) -> String {
    let kinematics = Kinematics::of(recording);
    let effort = kinematics.filter.smooth(&recording.effort);
    let rows: Vec<usize> = (0..recording.len()).collect();
    let fit = |rows: &[usize]| -> Option<DVector<f64>> {
        let of = |i: usize, j: usize| match j {
            0 => kinematics.acceleration[rows[i]],
            1 => kinematics.velocity[rows[i]],
            _ => 1.0,
        };
        let columns = DMatrix::from_fn(rows.len(), 3, of);
        let wanted = DVector::from_fn(rows.len(), |i, _| effort[rows[i]]);
        let normal = columns.transpose() * &columns;
        Some(normal.cholesky()?.solve(&(columns.transpose() * wanted)))
    };
    let whole = fit(&rows);
    let parts: Vec<DVector<f64>> = rows
        .chunks(rows.len().div_ceil(STRETCHES).max(4))
        .filter_map(fit)
        .collect();
    let unit = recording.effort_unit();
    let x = recording.position_unit();
    let (mass, constant) = match (recording.kind, unit) {
        (MotionKind::Linear, "N") => ("mass", "kg".to_owned()),
        (MotionKind::Rotary, "Nm") => ("inertia", "kg·m²".to_owned()),
        _ => ("inertia", format!("{unit}·s²/{x}")),
    };
    let names = [
        (mass, constant),
        ("viscous friction", format!("{unit}·s/{x}")),
        (
            "constant effort (load and the friction of this direction together)",
            unit.to_owned(),
        ),
    ];
    let (mut told, mut open) = (Vec::new(), Vec::new());
    for (j, (name, unit)) in names.iter().enumerate() {
        let n = parts.len() as f64;
        let mean = parts.iter().map(|p| p[j]).sum::<f64>() / n;
        let variance = parts.iter().map(|p| (p[j] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let error = (variance / n).sqrt();
        match &whole {
            Some(whole) if error.is_finite() && whole[j].abs() > CERTAIN * error => {
                told.push(format!("{name} {:.4e} ± {error:.1e} {unit}", whole[j]));
            }
            _ => open.push((*name).to_owned()),
        }
    }
    open.push("Coulomb friction apart from a constant load".to_owned());
    open.push("pre-sliding".to_owned());
    let told = match told.is_empty() {
        true => "nothing for certain".to_owned(),
        false => told.join(", "),
    };
    format!(
        "what it tells, from {} stretches of time: {told}; what it does not: {}",
        parts.len(),
        open.join(", ")
    )
}
