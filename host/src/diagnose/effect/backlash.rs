//! A play of the whole width `gap` between motor and load.

use super::ahead::{self, ENCODER_ON_LOAD, ahead};
use super::behind::{self, NONE, across};
use super::drive_compliance::{DriveCompliance, MOTOR_SHARE};
use super::grid::one;
use super::lack::both_directions;
use super::readout::enter;
use super::{BARE, Card, Class, Effect, Fitted, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::{Effect as Entry, form};
use preslide_fit::model::Model;
use preslide_fit::statistics::{Estimate, spread};

/// Key of the coefficient: how much of the difference that the gap makes is there.
const SHARE: &str = "share";
/// Frequencies (Hz) at which a load swings behind a gap, its share and damping, from where on all are refined: much damped, a load
/// crosses gaps of another width and springs of another stiffness nearly as the true one, and the way there has no other minimum (made
/// belts and servos: 60 % of the mismatch and more at twice or half the gap, where lightly damped ones take 5 to 60 %).
const SWINGS_HZ: [f64; 2] = [40.0, 100.0];
/// See [`SWINGS_HZ`].
const LOAD: f64 = 0.45;
/// See [`SWINGS_HZ`].
const DAMPED: f64 = 0.5;
/// Widest of the gaps behind which a load swings, of the narrowest: friction's own lengths, which bound it elsewhere, are the gap's where it
/// hid in them.
const WIDEST: f64 = 300.0;
/// Gaps that are simulated for each contact: they cost most of an effect's time, and are refined.
const SIMULATED: usize = 12;
/// Half of a 95 % interval of a gap, at least, in what its contact gives under the usual effort: the flanks of a narrow one are blurred. Chosen
/// on two made axes whose gaps of 50 and 100 µm came out at a half.
const BLURRED: f64 = 2.0;
/// Place of the contact among the shapes, and its key.
const CONTACT: usize = 1;
const CONTACT_KEY: &str = "contact_Hz";

/// Why a model file cannot hold a gap behind which the load swings.
const SWINGS: &str = "the load swings behind the gap, and a model file's gap has a stiff contact";

/// `backlash`.
pub struct Backlash;

static CARD: Card = Card {
    id: form::BACKLASH.id,
    name: "backlash",
    words: "a gap between motor and load",
    class: Class::Drive,
    axis: Axis::SinceReversal,
    experiment: "slow reversals under a constant push to one side",
    shown_by: &[Part::Nested],
    // A motor with the encoder needs the gap alone where the load behind it is not seen to swing. Beside a simulation that has the spring, it needs
    // the swing; where it swings in the recording, all.
    shape: &[
        ("gap_m", Scale::Logarithmic),
        (CONTACT_KEY, Scale::Logarithmic),
        (ahead::SHARE, Scale::Chosen),
        (behind::SHARE, Scale::Logarithmic),
        (behind::DAMPING_RATIO, Scale::Logarithmic),
    ],
    coefficient: SHARE,
    acts_on_effort: true,
    lacks: both_directions,
    ..BARE
};

impl Effect for Backlash {
    fn card(&self) -> &Card {
        &CARD
    }

    /// A gap passes nothing for a while, which no hysteresis does.
    fn is_law(&self) -> bool {
        false
    }

    fn excludes(&self, shape: &[f64]) -> Vec<&'static str> {
        match shape {
            // The spring of its contact is one.
            [] | [_] => Vec::new(),
            _ => vec![form::DRIVE_COMPLIANCE.id],
        }
    }

    fn shape_in(&self, entry: &Entry, _: &Model) -> Vec<f64> {
        vec![entry.get("gap_m")]
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let shortest = shortest_yield(scene);
        let longest = (200.0 * shortest).min(scene.s.travel() / 20.0);
        let mut shapes = one(shortest, longest, 9);
        if let Some(hz) = scene.core.simulated_swing {
            let gaps = spread(shortest, longest, behind::GAPS).into_iter();
            shapes.extend(gaps.map(|gap| vec![gap, hz]));
        } else {
            for hz in behind::seen(SWINGS_HZ, scene) {
                let gaps = spread(longest / WIDEST, longest, SIMULATED).into_iter();
                shapes.extend(gaps.map(|gap| vec![gap, hz, NONE, LOAD, DAMPED]));
            }
        }
        for [contact, share] in ahead::contacts(scene) {
            let gaps = spread(shortest, longest, SIMULATED).into_iter();
            shapes.extend(gaps.map(|gap| vec![gap, contact, share]));
        }
        shapes
    }

    fn valleys(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        // Stiffer, less damped and of another width: what much damping smoothed over.
        let times: [&[f64]; 4] = [&[0.7, 1.0, 1.4, 2.0], &[1.0, 2.0, 3.5], &[1.0], &[1.0, 0.3]];
        behind::valleys(shape, times)
    }

    fn simpler(&self, shape: &[f64]) -> Option<(&'static dyn Effect, Vec<f64>)> {
        let &[_, hz, NONE, share, damping] = shape else {
            return None;
        };
        Some((&DriveCompliance, vec![0.0, hz, NONE, share, damping]))
    }

    fn within(&self, scene: &Scene, shape: &[f64], index: usize) -> f64 {
        match index {
            CONTACT if shape.len() == 3 => ahead::within(shape[index], scene),
            _ => behind::of_load(scene, shape, index),
        }
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        if let Some(load) = behind::Load::of(shape) {
            // One that the contact gives more than is a spring.
            if load.gap < load.gives(scene) {
                return Vec::new();
            }
            return vec![load.in_place_of_one_bolted_on(scene)];
        }
        let gap = match *shape {
            [gap] => gap,
            [gap, hz] => return vec![across(gap, hz, scene)],
            [gap, contact, share] => return ahead(gap, [contact, share], scene),
            _ => return Vec::new(),
        };
        let (s, core) = (scene.s, scene.core);
        let mass = (1.0 - MOTOR_SHARE) * core.mass;
        let mut value: Vec<f64> = core.friction.iter().map(|f| -f).collect();
        for piece in &s.pieces {
            let mut load = Load::new(&core.blocks, s.x[piece.start], gap);
            for i in piece.clone() {
                value[i] += load.effort(s.x[i], mass * s.a[i]);
            }
        }
        vec![Column::of(value)]
    }

    fn admits(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        match (shape, coefficients) {
            (&[_, _, share], &[c]) => ahead::is_motor(share, c),
            (&[_, _], &[c]) => behind::LOAD.contains(&c),
            (&[_, _, NONE, share, _], &[c]) => behind::is_load(share, c),
            // The whole difference that the gap makes, or it is none.
            (_, &[c]) => (0.4..1.6).contains(&c),
            _ => false,
        }
    }

    fn in_simulation(&self, shape: &[f64]) -> Option<bool> {
        // Its own effort does not show it: a spring swings alike, and a motor ahead of the load is driven by the measured effort.
        (shape.len() > 1).then_some(false)
    }

    fn values(&self, fitted: &Fitted) -> Vec<(String, Estimate)> {
        if let Some(load) = behind::Load::of(fitted.shape) {
            let mut least = behind::LEAST_ERRORS;
            least[0] += BLURRED * load.gives(&fitted.scene) / load.gap;
            let mut values = vec![fitted.entry(SHARE, 0)];
            values.extend(ahead::widened(fitted, &CARD, &least));
            values.retain(|(key, _)| key != ahead::SHARE);
            return values;
        }
        match fitted.shape {
            [_, _, share] => ahead::with_own_share(fitted, &CARD, *share),
            [_, _] => {
                let mut values = vec![fitted.entry(behind::SHARE, 0)];
                values.extend(ahead::widened(fitted, &CARD, &[ahead::LEAST_ERROR; 3]));
                values
            }
            _ => fitted.one(&CARD),
        }
    }

    fn extend(&self, values: &[(String, Estimate)], model: &mut Model) -> Result<(), String> {
        let has = |own: &str| values.iter().any(|(key, _)| key == own);
        if has(behind::DAMPING_RATIO) {
            return Err(SWINGS.to_owned());
        }
        if has(CONTACT_KEY) {
            return Err(ENCODER_ON_LOAD.to_owned());
        }
        enter(self.id(), values, &[SHARE], model)
    }
}

/// The shortest yield that carries a hundredth of the friction (m or rad).
fn shortest_yield(scene: &Scene) -> f64 {
    let core = scene.core;
    let carrying = core
        .blocks
        .iter()
        .filter(|(k, d)| k * d > 0.01 * core.level);
    carrying.map(|b| b.1).fold(1.0, f64::min)
}

/// The load behind a gap, which pushes and never pulls.
struct Load<'a> {
    /// Stiffness and yield of the blocks that hold the load.
    blocks: &'a [(f64, f64)],
    deflection: Vec<f64>,
    /// Where it is (m or rad), and which flank touches; 0 where none does.
    x: f64,
    flank: f64,
    half: f64,
}

impl<'a> Load<'a> {
    fn new(blocks: &'a [(f64, f64)], motor: f64, gap: f64) -> Self {
        Self {
            blocks,
            deflection: vec![0.0; blocks.len()],
            x: motor,
            flank: 0.0,
            half: 0.5 * gap,
        }
    }

    /// What the motor, at `motor`, feels of the load's friction, and of its `inertia` in the gap, where it feels none.
    fn effort(&mut self, motor: f64, inertia: f64) -> f64 {
        if self.flank == 0.0 && (motor - self.x).abs() >= self.half {
            self.flank = (motor - self.x).signum();
        }
        if self.flank == 0.0 {
            return -inertia;
        }
        let by = motor - self.flank * self.half - self.x;
        let moved = |z: f64, d: f64| (z + by).clamp(-d, d);
        let blocks = self.blocks.iter().zip(&self.deflection);
        let friction: f64 = blocks.map(|(&(k, d), z)| k * moved(*z, d)).sum();
        if (friction + inertia) * self.flank < 0.0 {
            self.flank = 0.0;
            return -inertia;
        }
        self.x += by;
        for (z, &(_, d)) in self.deflection.iter_mut().zip(self.blocks) {
            *z = moved(*z, d);
        }
        friction
    }
}
