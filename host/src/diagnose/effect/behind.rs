//! A load behind a spring and a motor that has the encoder, where the load swings within what is recorded: what the spring changes, and what play does
//! beside it. The load swings on its contact after each gap, which a simulation's own force shows of its spring, and the recording of both.

use super::Scene;
use super::ahead::DAMPING;
use super::grid::spread;
use crate::diagnose::weak::Column;
use std::f64::consts::TAU;
use std::ops::Range;

/// Most radians of the load's own swing in one step of the simulation.
const STEP: f64 = 0.15;
/// Slowest swing (Hz), and how many are tried up to what the samples resolve, from where on they are refined.
const SLOWEST_HZ: f64 = 15.0;
const FASTEST_HZ: f64 = 150.0;
const SWINGS: usize = 18;
/// Gaps that are tried for each.
pub(super) const GAPS: usize = 18;
/// Most periods of the swing in a sample.
const SEEN: f64 = 0.2;
/// The load's share of the inertia, which is the coefficient.
pub(super) const LOAD: Range<f64> = 0.2..1.1;

/// Frequencies (Hz) at which the load may swing behind a motor that stands.
pub fn swings(scene: &Scene) -> Vec<f64> {
    let fastest = FASTEST_HZ.min(SEEN / scene.s.dt);
    match scene.core.mass > 0.0 && fastest > SLOWEST_HZ {
        true => spread(SLOWEST_HZ, fastest, SWINGS),
        false => Vec::new(),
    }
}

/// A frequency (Hz) brought within those.
pub(super) fn within(hz: f64, scene: &Scene) -> f64 {
    hz.clamp(SLOWEST_HZ, (SEEN / scene.s.dt).max(SLOWEST_HZ))
}

/// What a gap and a spring change in the effort, of a load that had all of the inertia and of the friction: beside a simulation that has the
/// spring what the gap does, else all that differs from a load that is bolted to the motor.
pub fn behind(gap: f64, hz: f64, scene: &Scene) -> Column {
    let (s, core) = (scene.s, scene.core);
    let passed = |gap: f64| transmitted(0.5 * gap, TAU * hz, scene);
    if core.beside_simulation.is_some() && gap > 0.0 {
        return Column::of(less(&passed(gap), &passed(0.0)));
    }
    Column {
        value: less(&passed(gap), &core.friction),
        curved: s.x.iter().map(|x| -core.mass * x).collect(),
        ..Column::default()
    }
}

/// What a spring on which the load swings at `hz` changes in the effort of a simulation in which it swings at `simulated` (Hz), of a load that
/// had all of the inertia and of the friction.
pub(super) fn another_spring([hz, simulated]: [f64; 2], scene: &Scene) -> Column {
    let [own, other] = [hz, simulated].map(|hz| transmitted(0.0, TAU * hz, scene));
    Column::of(less(&own, &other))
}

fn less(own: &[f64], other: &[f64]) -> Vec<f64> {
    own.iter().zip(other).map(|(a, b)| a - b).collect()
}

fn transmitted(half: f64, w: f64, scene: &Scene) -> Vec<f64> {
    let (s, core) = (scene.s, scene.core);
    let viscous = core.beside_simulation.unwrap_or(0.0);
    let (stiffness, damping) = (core.mass * w * w, 2.0 * DAMPING * w * core.mass);
    // Blocks that stick are springs, too.
    let sticks: f64 = core.blocks.iter().map(|(k, _)| k).sum();
    let fastest = (w / STEP).max((w * w + sticks / core.mass).sqrt());
    let steps = (fastest * s.dt).ceil().max(1.0) as usize;
    let h = s.dt / steps as f64;
    let mut effort = vec![0.0; s.x.len()];
    let mut deflection = vec![0.0; core.blocks.len()];
    for piece in &s.pieces {
        deflection.fill(0.0);
        let (mut load, mut v) = (s.x[piece.start], 0.0);
        for i in piece.clone() {
            let next = (i + 1).min(piece.end - 1);
            let motor = (s.x[next] - s.x[i]) / s.dt;
            for step in 0..steps {
                let apart = s.x[i] + motor * h * step as f64 - load;
                let beyond = apart - apart.clamp(-half, half);
                let mut force = 0.0;
                if beyond != 0.0 || half == 0.0 {
                    force = stiffness * beyond + damping * (motor - v);
                    // Parts that touch push and never pull.
                    if half > 0.0 && force * beyond < 0.0 {
                        force = 0.0;
                    }
                }
                if step == 0 {
                    effort[i] = force;
                }
                let mut resists = viscous * v;
                for (z, (k, d)) in deflection.iter_mut().zip(&core.blocks) {
                    *z = (*z + v * h).clamp(-d, *d);
                    resists += k * *z;
                }
                v += h * (force - resists) / core.mass;
                load += h * v;
            }
        }
    }
    effort
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::effect::tests::Stage;
    use preslide_fit::recording::MotionKind;

    /// What crosses the gap passes nothing, and on the whole the contact passes what holds the load. That the gap comes out right is shown on a
    /// machine of another's making (`python/tests/test_preslide.py`).
    #[test]
    fn a_gap_passes_nothing_and_its_flanks_what_holds_the_load() {
        let mut stage = Stage::new(MotionKind::Linear, 1.0);
        stage.core.mass = 0.02;
        stage.core.beside_simulation = Some(0.0);
        let scene = stage.scene();
        let (w, level) = (TAU * 90.0, 1.0);
        let [with, without] = [1e-3, 0.0].map(|half| transmitted(half, w, &scene));
        let zeros = |force: &[f64]| force.iter().filter(|f| **f == 0.0).count();
        assert!(zeros(&with) > 20 && zeros(&with) < with.len() / 2);
        // The inertia is a hundredth of a newton: in sliding it is the friction, whose blocks hold 1 N.
        let slides = |i: &usize| scene.s.v[*i].abs() > 0.05;
        let mean = |force: &[f64]| {
            let own: Vec<usize> = (0..force.len()).filter(slides).collect();
            let along = own.iter().map(|i| force[*i] * scene.s.v[*i].signum());
            along.sum::<f64>() / own.len() as f64
        };
        let [with_gap, stiff] = [&with, &without].map(|force| mean(force));
        // Less a load that is bolted on, the spring alone leaves nothing in sliding.
        let spring = mean(&behind(0.0, 90.0, &scene).value);
        eprintln!(
            "{spring:.3} N of the spring alone, {with_gap:.3} N with the gap, {stiff:.3} N without, of {level} N"
        );
        assert!((stiff / level - 1.0).abs() < 0.05, "{stiff}");
        assert!(spring.abs() < 0.05 * level, "{spring}");
        assert!((0.6..1.0).contains(&(with_gap / level)), "{with_gap}");
    }
}
