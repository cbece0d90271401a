//! What a recording tells that cannot show friction by direction: one-way turning, a jog, a few strokes.

use crate::recording::{MotionKind, Recording};
use crate::signal::Kinematics;
use crate::statistics::jackknife;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Stretches of time that are left out one by one: what the others say of each is the error, how they scatter the confidence.
const STRETCHES: usize = 6;

/// A coefficient is told where it is this many standard errors away from zero …
const CERTAIN: f64 = 3.0;

/// … and where the squared error on the stretches left out is this many times larger without it: a slow speed-up beside a ripple, or an
/// acceleration that is mostly the encoder's noise, scatters little and is wrong.
const TELLING: f64 = 2.0;

/// Inertia, viscous friction and constant effort, each where it is certain, and what stays open; a sentence.
pub(super) fn told(recording: &Recording) -> String {
    let kinematics = Kinematics::of(recording);
    let effort = DVector::from(kinematics.filter.smooth(&recording.effort));
    let terms = terms(recording, &kinematics);
    let n = recording.len();
    let length = n.div_ceil(STRETCHES).max(4);
    let stretches: Vec<Range<usize>> = (0..n)
        .step_by(length)
        .map(|start| start..(start + length).min(n))
        .collect();
    let fits = Fits::of(&terms, &effort, &stretches);
    let (mut told, mut open) = (Vec::new(), Vec::new());
    for (j, (name, unit)) in names(recording).into_iter().enumerate() {
        let certain = fits.as_ref().filter(|fits| {
            let without = Fits::of(&terms.clone().remove_column(j), &effort, &stretches);
            // No mass and no viscosity is negative: what seems so follows something else.
            let possible = j == CONSTANT || fits.value(j) > 0.0;
            possible
                && fits.value(j).abs() > CERTAIN * fits.error(j)
                && without.is_some_and(|without| without.left > TELLING * fits.left)
        });
        match certain {
            Some(fits) => told.push(format!(
                "{name} {:.4e} ± {:.1e} {unit}",
                fits.value(j),
                fits.error(j)
            )),
            None => open.push(name),
        }
    }
    open.extend(["Coulomb friction apart from a constant load", "pre-sliding"]);
    let told = match told.is_empty() {
        true => "nothing for certain".to_owned(),
        false => told.join(", "),
    };
    format!(
        "what it tells, from {} stretches of time: {told}; what it does not: {}; `preslide diagnose` looks for what the effort follows besides",
        stretches.len(),
        open.join(", ")
    )
}

/// Column of the constant effort.
const CONSTANT: usize = 2;

/// Acceleration, velocity and a constant; and weight or a spring, which is not told but else passes for the others.
fn terms(recording: &Recording, kinematics: &Kinematics) -> DMatrix<f64> {
    let q = &recording.position;
    let beside = match recording.kind {
        MotionKind::Linear => 1,
        MotionKind::Rotary => 2,
    };
    DMatrix::from_fn(recording.len(), CONSTANT + 1 + beside, |i, j| match j {
        0 => kinematics.acceleration[i],
        1 => kinematics.velocity[i],
        CONSTANT => 1.0,
        _ if beside == 1 => q[i],
        3 => q[i].sin(),
        _ => q[i].cos(),
    })
}

/// What the three are called, with their units.
fn names(recording: &Recording) -> [(&'static str, String); 3] {
    let unit = recording.effort_unit();
    let x = recording.position_unit();
    let inertia = match (recording.kind, unit) {
        (MotionKind::Linear, "N") => ("mass", "kg".to_owned()),
        (MotionKind::Rotary, "Nm") => ("inertia", "kg·m²".to_owned()),
        _ => ("inertia", format!("{unit}·s²/{x}")),
    };
    [
        inertia,
        ("viscous friction", format!("{unit}·s/{x}")),
        (
            "constant effort (load and the friction of this direction together)",
            unit.to_owned(),
        ),
    ]
}

/// Least squares on all stretches, and on all but each.
struct Fits {
    whole: DVector<f64>,
    without: Vec<DVector<f64>>,
    /// Sum of squares that is left on each stretch by the fit to the others.
    left: f64,
}

impl Fits {
    /// `None` where the terms cannot be told apart.
    fn of(terms: &DMatrix<f64>, effort: &DVector<f64>, stretches: &[Range<usize>]) -> Option<Self> {
        // In units of their own size: columns differ by many orders of magnitude.
        let sizes: Vec<f64> = terms
            .column_iter()
            .map(|c| c.norm().max(f64::MIN_POSITIVE))
            .collect();
        let scaled = DMatrix::from_fn(terms.nrows(), terms.ncols(), |i, j| {
            terms[(i, j)] / sizes[j]
        });
        let sums = |rows: &Range<usize>| {
            let part = scaled.rows_range(rows.clone());
            let of_effort = part.transpose() * effort.rows_range(rows.clone());
            (part.transpose() * part, of_effort)
        };
        let parts: Vec<_> = stretches.iter().map(sums).collect();
        let solve = |left_out: Option<usize>| -> Option<DVector<f64>> {
            let mut kept = parts
                .iter()
                .enumerate()
                .filter(|(i, _)| Some(*i) != left_out);
            let (_, (square, wanted)) = kept.next()?;
            let (mut square, mut wanted) = (square.clone(), wanted.clone());
            kept.for_each(|(_, part)| {
                square += &part.0;
                wanted += &part.1;
            });
            Some(square.cholesky()?.solve(&wanted))
        };
        let whole = solve(None)?;
        let without = (0..parts.len())
            .map(|i| solve(Some(i)))
            .collect::<Option<Vec<_>>>()?;
        let left = stretches.iter().zip(&without).map(|(rows, fit)| {
            let rest = effort.rows_range(rows.clone()) - scaled.rows_range(rows.clone()) * fit;
            rest.norm_squared()
        });
        let left = left.sum();
        let in_units = |fit: DVector<f64>| DVector::from_fn(fit.len(), |j, _| fit[j] / sizes[j]);
        Some(Self {
            whole: in_units(whole),
            without: without.into_iter().map(in_units).collect(),
            left,
        })
    }

    fn value(&self, j: usize) -> f64 {
        self.whole[j]
    }

    /// The jackknife's standard error.
    fn error(&self, j: usize) -> f64 {
        jackknife(&self.without.iter().map(|fit| fit[j]).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{LoadOptions, load_csv};
    use std::f64::consts::TAU;

    /// What is told of a rotary recording of `seconds` at 200 Hz; angle and torque by time.
    fn of(seconds: u32, row: impl Fn(f64) -> [f64; 2]) -> String {
        let mut text = "t_s,q_rad,torque_Nm\n".to_owned();
        for i in 0..200 * seconds {
            let t = f64::from(i) * 0.005;
            let [q, torque] = row(t);
            text += &format!("{t:.3},{:.5},{torque:.6}\n", q);
        }
        let recording = load_csv(text.as_bytes(), "turns.csv", &LoadOptions::default());
        told(&recording.unwrap_or_else(|e| panic!("{e}")))
    }

    #[test]
    fn a_spindle_tells_its_viscous_friction_and_a_sweep_under_gravity_no_mass() {
        // Speed 60 ± 50 rad/s in 10 s: inertia 2 g·m², 0.15 N·m, 2 mN·m·s.
        let w = TAU / 10.0;
        let spindle = of(60, |t| {
            let (sin, cos) = (w * t).sin_cos();
            let speed = 60.0 - 50.0 * cos;
            [
                60.0 * t - 50.0 / w * sin,
                2e-3 * 50.0 * w * sin + 0.15 + 2e-3 * speed,
            ]
        });
        for part in [
            "inertia 2.0",
            "viscous friction 2.0",
            "constant effort",
            " 1.5",
        ] {
            assert!(spindle.contains(part), "{part}: {spindle}");
        }
        // Half a turn in a minute: gravity of 3.3 N·m, upwards and downwards, is told as an inertia of -10 or 10 kg·m² by a fit without it.
        for gravity in [3.3, -3.3] {
            let sweep = of(60, |t| {
                let u = t / 60.0;
                let q = -1.5 + 3.0 * (u - (TAU * u).sin() / TAU);
                [q, gravity * q.sin() + 0.1]
            });
            let (told, open) = sweep.split_once("does not").expect("two parts");
            assert!(
                !told.contains("inertia") && open.contains("inertia"),
                "{sweep}"
            );
            assert!(!told.contains("viscous"), "{sweep}");
        }
    }
}
