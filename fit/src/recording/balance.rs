//! The energy balance of motion that does not close: what the effort gives is kept as kinetic energy, stored by position, or taken by
//! friction along the path. Friction that gives is an effort of the opposite sign.

use super::segments::Strokes;
use nalgebra::{DMatrix, DVector};

/// Stretches over which a velocity is taken.
const STRETCHES: usize = 500;
/// Fewest samples.
const FEWEST: usize = 200;
/// Share of the work's deviation that the balance may leave.
const LEFT: f64 = 0.2;
/// Share of the work exchanged that friction must make up: less may be another force that the balance does not know.
const MOST: f64 = 0.5;

/// Work (J for force and torque) that friction takes along a run, negative where the effort's sign is opposite, and the work exchanged;
/// `None` where the balance does not say.
pub(super) fn friction(x: &[f64], effort: &[f64], strokes: &Strokes) -> Option<(f64, f64)> {
    let (x, effort) = (
        x.get(strokes.run.clone())?,
        effort.get(strokes.run.clone())?,
    );
    // In one direction friction is a constant force.
    if strokes.reversals.is_empty() || x.len() < FEWEST {
        return None;
    }
    let half = (x.len() / STRETCHES / 2).max(2);
    let (mut work, mut path, mut exchanged) = (0.0, 0.0, 0.0);
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for i in 1..x.len() {
        let step = x[i] - x[i - 1];
        let given = 0.5 * (effort[i] + effort[i - 1]) * step;
        work += given;
        exchanged += given.abs();
        path += step.abs();
        if i % half == 0 && i >= half && i + half < x.len() {
            let (at, speed) = (x[i] - x[0], x[i + half] - x[i - half]);
            rows.push([speed * speed, path, at, at * at, 1.0]);
            right.push(work);
        }
    }
    let scale: [f64; 5] =
        std::array::from_fn(|k| rows.iter().map(|r| r[k].abs()).fold(1e-300, f64::max));
    let matrix = DMatrix::from_fn(rows.len(), 5, |i, k| rows[i][k] / scale[k]);
    let right = DVector::from_vec(right);
    let found = matrix.clone().svd(true, true).solve(&right, 1e-9).ok()?;
    let left = (&matrix * &found - &right).norm();
    let deviation = (&right - DVector::repeat(right.len(), right.mean())).norm();
    // Scaled, a coefficient is the most that its part comes to.
    let friction = found[1];
    let told = friction.abs() >= MOST * exchanged && left <= LEFT * deviation;
    told.then_some((friction, exchanged))
}

#[cfg(test)]
mod tests {
    use super::super::segments;

    /// There and half the way back with friction (N), inertia, a spring and a constant force.
    fn stroke(sign: f64, friction: f64) -> Option<(f64, f64)> {
        let phase = |i: usize| std::f64::consts::PI * i as f64 / 1000.0;
        let x: Vec<f64> = (0..=1500).map(|i| -phase(i).cos()).collect();
        let force =
            |i: usize| friction * phase(i).sin().signum() + phase(i).cos() + 0.5 * x[i] + 0.3;
        let f: Vec<f64> = (0..=1500).map(|i| sign * force(i)).collect();
        super::friction(&x, &f, &segments::strokes(&x, 0..x.len()))
    }

    #[test]
    fn friction_tells_the_sign_of_motion_that_does_not_close() {
        for sign in [1.0, -1.0] {
            let (taken, exchanged) = stroke(sign, 1.4).expect("told");
            assert!((taken / (4.2 * sign) - 1.0).abs() < 0.01, "{taken} J");
            assert!(exchanged > 4.2);
        }
        assert_eq!(stroke(1.0, 0.1), None);
        let one_way: Vec<f64> = (0..500).map(f64::from).collect();
        let alone = segments::strokes(&one_way, 0..500);
        assert_eq!(super::friction(&one_way, &one_way, &alone), None);
    }
}
