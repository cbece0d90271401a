//! The steady-state runs of a screw drive as one recording.

use super::root;
use nalgebra::{DMatrix, DVector};
use preslide_host::recording::{self, LoadOptions, Recording};
use std::fmt::Write as _;

/// Every run has its own rate, 4 to 156 Hz, and one recording has one: the runs are brought to this step [s].
const STEP: f64 = 25.6e-3;
/// Each run is cut into so many repeats, so that a fold that is held out has every speed.
const REPEATS: usize = 5;

/// A table of numbers, row by row.
fn numbers(name: &str) -> Result<Vec<Vec<f64>>, String> {
    let fail = |e: csv::Error| format!("{name}: {e}");
    let mut rows = Vec::new();
    let mut reader = csv::Reader::from_path(root().join(name)).map_err(fail)?;
    for record in reader.records() {
        let cells = record.map_err(fail)?;
        // Runs backwards are labelled "n10".
        let row = cells
            .iter()
            .map(|c| c.replace('n', "-").parse::<f64>())
            .collect::<Result<Vec<f64>, _>>()
            .map_err(|e| format!("{name}: {e}"))?;
        rows.push(row);
    }
    Ok(rows)
}

/// The runs of `drive` at one rate: averaged where theirs is higher, interpolated where it is lower.
pub fn steady_state(drive: u32) -> Result<Recording, String> {
    let rows = numbers(&format!("screw_drives/drive{drive}_steady_state.csv"))?;
    let mut text = "t_s,qd_rad_s,torque_Nm,segment,repeat\n".to_owned();
    for (segment, run) in rows.chunk_by(|a, b| a[0] == b[0]).enumerate() {
        let end = run.last().map_or(0.0, |row| row[1]);
        let samples = (end / STEP) as usize;
        for i in 0..samples {
            let t = i as f64 * STEP;
            let near: Vec<&Vec<f64>> = run
                .iter()
                .filter(|row| (row[1] - t).abs() <= 0.5 * STEP)
                .collect();
            let value = |column: usize| {
                if near.len() > 1 {
                    return near.iter().map(|row| row[column]).sum::<f64>() / near.len() as f64;
                }
                let next = run.partition_point(|row| row[1] <= t).min(run.len() - 1);
                let (a, b) = (&run[next.saturating_sub(1)], &run[next]);
                let share = ((t - a[1]) / (b[1] - a[1]).max(1e-12)).clamp(0.0, 1.0);
                a[column] + share * (b[column] - a[column])
            };
            let repeat = i * REPEATS / samples.max(1);
            let _ = writeln!(
                text,
                "{t:.6},{:.6},{:.9},{segment},{repeat}",
                value(2),
                value(3)
            );
        }
    }
    let name = format!("drive{drive}_steady_state.csv");
    recording::load_csv(text.as_bytes(), &name, &LoadOptions::default()).map_err(|e| e.to_string())
}

/// The Stribeck curve through the published mean torque of each speed: Coulomb torque [N·m], Stribeck velocity [rad/s] and the
/// level that is added at rest [-], with a viscous and a constant torque beside it; least squares over the velocity.
pub fn stribeck(drive: u32) -> Result<[f64; 3], String> {
    let map = numbers(&format!("screw_drives/drive{drive}_stribeck_map.csv"))?;
    let torque = DVector::from_iterator(map.len(), map.iter().map(|row| row[1]));
    let mut best = (f64::INFINITY, [0.0; 3]);
    for i in 0..200 {
        let velocity = 0.05 * 400.0_f64.powf(f64::from(i) / 199.0);
        let columns = DMatrix::from_fn(map.len(), 4, |row, column| {
            let v = map[row][0];
            match column {
                0 => v.signum(),
                1 => v.signum() * (-v.abs() / velocity).exp(),
                2 => v,
                _ => 1.0,
            }
        });
        let Ok(c) = columns.clone().svd(true, true).solve(&torque, 1e-12) else {
            continue;
        };
        let error = (&torque - columns * &c).norm();
        if error < best.0 {
            best = (error, [c[0], velocity, c[1] / c[0]]);
        }
    }
    Ok(best.1)
}
