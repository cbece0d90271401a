//! A load behind a spring and a motor that has the encoder, where the load swings within what is recorded: what the spring changes, and what play does
//! beside it. The load swings on its contact after each gap, which a simulation's own force shows of its spring, and the recording of both.

use super::ahead::{DAMPING, resolved};
use super::{Baseline, Scene};
use crate::diagnose::noise::rms;
use crate::diagnose::weak::Column;
use preslide_fit::statistics::spread;
use std::f64::consts::TAU;
use std::ops::Range;

/// Most radians of the load's own swing in one step of the simulation.
const STEP: f64 = 0.15;
/// Most steps of a load in a sample, twice those that the fastest swing needs that is seen. What holds it stiffer is taken to be no stiffer: a light
/// tribometer took ten minutes.
const STEPS: f64 = 16.0;
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

/// Longest yield of its friction, of the gap.
const YIELDS: f64 = 0.1;
/// Key of the load's share of the inertia.
pub(super) const SHARE: &str = "load_share";
/// Key of the damping ratio of the contact on which it is seen to swing.
pub(super) const DAMPING_RATIO: &str = "damping_ratio";
/// In a shape of gap, swing, share and damping, where an effect has the motor's share ahead of a load: none.
pub(super) const NONE: f64 = 0.0;
/// Between which the load's share and the damping ratio are refined: a motor has some of the inertia, and parts that touch rattle.
const SHARES: [f64; 2] = [0.1, 0.95];
/// See [`SHARES`].
const DAMPED: [f64; 2] = [0.01, 0.5];
/// Most that a spring without play is damped, of steel or a belt: what is damped more is a delay.
const SPRING_DAMPED: f64 = 0.2;
/// How much of the assumed difference is there before friction and inertia are found beside it.
const SOME: Range<f64> = 0.3..3.0;
/// Half of a 95 % interval of gap, swing, share and damping at least, relative to what is found: how far off those of four made belts and servos
/// with play came out that it was chosen on, of which friction was all on the load's side (0.07, 0.17, 0.09 and 0.43).
pub(super) const LEAST_ERRORS: [f64; 5] = [0.1, 0.2, 0.0, 0.2, 0.6];

/// A load behind play and a spring, that all of the friction holds.
pub struct Load {
    /// The play's whole width (m or rad).
    pub gap: f64,
    /// Frequency (Hz) at which it swings behind a motor that stands.
    pub hz: f64,
    /// Its share of the inertia.
    pub share: f64,
    /// Damping ratio of its contact.
    pub damping: f64,
}

/// Frequencies (Hz) at which the load may swing behind a motor that stands.
pub fn swings(scene: &Scene) -> Vec<f64> {
    let fastest = FASTEST_HZ.min(SEEN / scene.s.dt);
    match scene.core.mass > 0.0 && fastest > SLOWEST_HZ {
        true => spread(SLOWEST_HZ, fastest, SWINGS),
        false => Vec::new(),
    }
}

/// How fast (rad/s) a mass swings on blocks that stick.
fn sticking(blocks: &[(f64, f64)], mass: f64) -> f64 {
    (blocks.iter().map(|(k, _)| k).sum::<f64>() / mass).sqrt()
}

/// A shape parameter of such a load brought within what a recording can resolve and a drive can have.
pub(super) fn of_load(scene: &Scene, shape: &[f64], index: usize) -> f64 {
    match index {
        1 => within(shape[index], scene),
        3 => shape[index].clamp(SHARES[0], SHARES[1]),
        4 if shape[0] == 0.0 => shape[index].clamp(DAMPED[0], SPRING_DAMPED),
        4 => shape[index].clamp(DAMPED[0], DAMPED[1]),
        _ => shape[index],
    }
}

/// Shapes of a load from which its search may find a better one: `times` its gap, swing, share and damping.
pub(super) fn valleys(shape: &[f64], times: [&[f64]; 4]) -> Vec<Vec<f64>> {
    let &[gap, hz, NONE, share, damping] = shape else {
        return Vec::new();
    };
    let mut all = vec![vec![gap, hz, NONE, share, damping]];
    for (index, times) in [0, 1, 3, 4].into_iter().zip(times) {
        let each = |shape: Vec<f64>| {
            times.iter().map(move |by| {
                let mut shape = shape.clone();
                shape[index] *= by;
                shape
            })
        };
        all = all.into_iter().flat_map(each).collect();
    }
    all
}

/// Whether `times` a share of the inertia is one that a load may have, and enough of the difference that it makes.
pub(super) fn is_load(share: f64, times: f64) -> bool {
    SOME.contains(&times) && LOAD.contains(&(share * times))
}

/// Those of some swings (Hz) that the samples resolve.
pub(super) fn seen<const N: usize>(some: [f64; N], scene: &Scene) -> impl Iterator<Item = f64> {
    resolved(some, SEEN, scene)
}

/// A frequency (Hz) brought within those.
pub(super) fn within(hz: f64, scene: &Scene) -> f64 {
    hz.clamp(SLOWEST_HZ, (SEEN / scene.s.dt).max(SLOWEST_HZ))
}

/// What a spring changes in the effort, of a load that had all of the inertia.
pub fn swinging(hz: f64, scene: &Scene) -> Column {
    Load::whole(0.0, hz).in_place_of_one_bolted_on(scene)
}

/// What a gap changes in the effort of a simulation that has the spring, of a load that had all of the inertia.
pub(super) fn across(gap: f64, hz: f64, scene: &Scene) -> Column {
    let [with, without] = [gap, 0.0].map(|gap| Load::whole(gap, hz).transmitted(scene));
    Column::of(less(with, &without))
}

/// What a spring on which the load swings at `hz` changes in the effort of a simulation in which it swings at `simulated` (Hz), of a load that
/// had all of the inertia.
pub(super) fn another_spring([hz, simulated]: [f64; 2], scene: &Scene) -> Column {
    let [own, other] = [hz, simulated].map(|hz| Load::whole(0.0, hz).transmitted(scene));
    Column::of(less(own, &other))
}

fn less(mut own: Vec<f64>, other: &[f64]) -> Vec<f64> {
    own.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
    own
}

impl Load {
    /// The load of a shape of gap, swing, share and damping.
    pub(super) fn of(shape: &[f64]) -> Option<Self> {
        match *shape {
            [gap, hz, NONE, share, damping] => Some(Self {
                gap,
                hz,
                share,
                damping,
            }),
            _ => None,
        }
    }

    fn whole(gap: f64, hz: f64) -> Self {
        Self {
            gap,
            hz,
            share: 1.0,
            damping: DAMPING,
        }
    }

    /// How far its contact gives under the usual effort (m or rad).
    pub(super) fn gives(&self, scene: &Scene) -> f64 {
        let usual = rms(&scene.core.fitted);
        self.share * usual / self.stiffness(scene)
    }

    fn stiffness(&self, scene: &Scene) -> f64 {
        self.share * scene.core.mass * (TAU * self.hz).powi(2)
    }

    /// All in which the effort differs from that of a load that is bolted to the motor.
    pub(super) fn in_place_of_one_bolted_on(&self, scene: &Scene) -> Column {
        let (s, core) = (scene.s, scene.core);
        let load = self.share * core.mass;
        let sloped = match core.viscous {
            0.0 => Vec::new(),
            viscous => s.x.iter().map(|x| -viscous * x).collect(),
        };
        Column {
            value: less(self.transmitted(scene), &core.friction),
            sloped,
            curved: s.x.iter().map(|x| -load * x).collect(),
        }
    }

    /// Friction that yields over a good part of the gap is what a fit without the gap made of it; and what sticks is a spring, no stiffer than
    /// [`STEPS`] in `dt` (s) resolve.
    fn blocks(&self, core: &Baseline, dt: f64) -> Vec<(f64, f64)> {
        let longest = match self.gap {
            0.0 => f64::INFINITY,
            gap => YIELDS * gap,
        };
        let within = |&(k, d): &(f64, f64)| (k * d / d.min(longest), d.min(longest));
        let blocks: Vec<(f64, f64)> = core.blocks.iter().map(within).collect();
        let held = dt * sticking(&blocks, self.share * core.mass);
        let soft = (STEPS / held).min(1.0).powi(2);
        blocks.iter().map(|(k, d)| (k * soft, d / soft)).collect()
    }

    /// What crosses play and spring (N or N·m) at the samples.
    fn transmitted(&self, scene: &Scene) -> Vec<f64> {
        let (s, core) = (scene.s, scene.core);
        let (w, half, mass) = (TAU * self.hz, 0.5 * self.gap, self.share * core.mass);
        let (stiffness, damping) = (self.stiffness(scene), 2.0 * self.damping * w * mass);
        let blocks = self.blocks(core, s.dt);
        let fastest = (w / STEP).max(w.hypot(sticking(&blocks, mass)));
        let steps = (fastest * s.dt).ceil().max(1.0) as usize;
        let h = s.dt / steps as f64;
        let mut effort = vec![0.0; s.x.len()];
        let mut deflection = vec![0.0; blocks.len()];
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
                    let mut resists = core.viscous * v;
                    for (z, (k, d)) in deflection.iter_mut().zip(&blocks) {
                        *z = (*z + v * h).clamp(-d, *d);
                        resists += k * *z;
                    }
                    v += h * (force - resists) / mass;
                    load += h * v;
                }
            }
        }
        effort
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::effect::tests::Stage;
    use preslide_fit::recording::MotionKind;

    /// Of a load of no mass the steps would be without end.
    #[test]
    fn friction_that_holds_a_light_load_costs_no_more() {
        let mut stage = Stage::new(MotionKind::Linear, 1.0);
        stage.core.mass = 1e-15;
        let force = Load::whole(0.0, 90.0).transmitted(&stage.scene());
        assert!(force.iter().all(|f| f.is_finite()));
    }

    /// What crosses the gap passes nothing, and on the whole the contact passes what holds the load. That the gap comes out right is shown on a
    /// machine of another's making (`python/tests/test_preslide.py`).
    #[test]
    fn a_gap_passes_nothing_and_its_flanks_what_holds_the_load() {
        let mut stage = Stage::new(MotionKind::Linear, 1.0);
        stage.core.mass = 0.02;
        let scene = stage.scene();
        let (hz, level) = (90.0, 1.0);
        let [with, without] = [2e-3, 0.0].map(|gap| Load::whole(gap, hz).transmitted(&scene));
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
        let spring = mean(&swinging(hz, &scene).value);
        eprintln!(
            "{spring:.3} N of the spring alone, {with_gap:.3} N with the gap, {stiff:.3} N without, of {level} N"
        );
        assert!((stiff / level - 1.0).abs() < 0.05, "{stiff}");
        assert!(spring.abs() < 0.05 * level, "{spring}");
        assert!((0.6..1.0).contains(&(with_gap / level)), "{with_gap}");
    }
}
