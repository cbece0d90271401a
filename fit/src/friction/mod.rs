//! The library's friction models, chosen at run time and run along a recording in `f64`.

mod contact;
mod family;
mod law;
mod laws;
mod search;

pub use contact::Tick;
pub(crate) use law::{Curve, Law};
pub(crate) use laws::with_keys;
pub use laws::{Family, FrictionModel};
pub use search::{Bounded, Span};

use contact::{AtWork, Driven};
use preslide::{Block, Friction, ParamError, Sliding, Units};
use std::ops::Range;

/// Most blocks that a model file may have.
pub const MOST_BLOCKS: usize = 16;

/// A motion to run a model along.
#[derive(Clone, Copy)]
pub struct Path<'a> {
    /// Position (m or rad).
    pub position: &'a [f64],
    /// Velocity (m/s or rad/s).
    pub velocity: &'a [f64],
    /// Contiguous samples; a model keeps its state from one to the next.
    pub pieces: &'a [Range<usize>],
    /// Time between samples (s).
    pub sample_time: f64,
}

/// What lies between the measured motion and the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transmission {
    /// Rate (m/s or rad/s) and share `p` (-) of Eyring's law, by which the contact gives way: `rate·sinh(F/(p·F_limit))`.
    pub creep: Option<(f64, f64)>,
    /// Play (m or rad), the whole width.
    pub gap: f64,
}

/// Something to do with any of the library's models, in the number type `S`.
pub trait Visitor<S = f64> {
    /// The result.
    type Outcome;

    /// Does it.
    fn visit<M: Friction<Scalar = S, State: Send> + Send + 'static>(
        self,
        model: M,
    ) -> Self::Outcome;
}

impl FrictionModel {
    /// Its name in tables.
    pub fn name(&self) -> String {
        self.clone().law().name
    }

    /// Its name in model files and tables.
    pub fn kind(&self) -> &'static str {
        self.clone().law().kind
    }

    /// The scalar parameters by their keys on a linear axis; those of the Stribeck curve last.
    pub fn scalars(&self) -> Vec<(&'static str, f64)> {
        let mut copy = self.clone();
        let own = copy.law().scalars.into_iter();
        let mut scalars: Vec<_> = own.map(|(key, value)| (key, *value)).collect();
        if let Some(sliding) = self.sliding() {
            scalars.extend([
                ("coulomb_N", sliding.coulomb),
                ("stribeck_velocity_m_s", sliding.stribeck_velocity),
                ("stribeck_exponent", sliding.stribeck_exponent),
                ("attraction_N_per_s", sliding.attraction),
            ]);
        }
        scalars
    }

    /// Number of parameters to identify, a Stribeck curve's exponent and lag taken as known; weights sum to one.
    pub fn parameter_count(&self) -> usize {
        let curve = 2 * usize::from(self.sliding().is_some());
        let blocks = (2 * self.blocks().len()).saturating_sub(1);
        self.clone().law().scalars.len() + blocks + curve
    }

    /// The same at `factor` times the force, its displacements and velocities as they are; `None` where the library bounds no such force.
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        self.breakaway()?;
        let mut scaled = self.clone();
        let law = scaled.law();
        for (key, value) in law.scalars {
            if key.contains("_N") {
                *value *= factor;
            }
        }
        let blocks = law.blocks.into_iter().flatten();
        blocks.for_each(|b| b.stiffness *= factor);
        if let Some(sliding) = law.curve.given() {
            sliding.coulomb *= factor;
            sliding.attraction *= factor;
        }
        Some(scaled)
    }

    /// The same without damping and along a Stribeck curve of another form, which follows from its breakaway force (N); `None` where the
    /// law has no such curve.
    pub fn along(&self, curve: impl Fn(f64) -> Sliding) -> Option<Self> {
        let (mut other, curve) = (self.clone(), curve(self.breakaway()?));
        match other.law().curve {
            Curve::None => return None,
            Curve::Always(sliding) => *sliding = curve,
            Curve::Optional(sliding) => *sliding = Some(curve),
        }
        if let Some(damping) = other.damping() {
            *damping = 0.0;
        }
        Some(other)
    }

    /// A viscous term of its own.
    fn damping(&mut self) -> Option<&mut f64> {
        let mut scalars = self.law().scalars.into_iter();
        let damping = scalars.find(|(key, _)| is_damping(key));
        damping.map(|(_, value)| value)
    }

    /// The key of the force at which the body breaks away, and that force (N), where the model has such a parameter.
    pub fn level(&self) -> Option<(&'static str, f64)> {
        let mut copy = self.clone();
        let mut scalars = copy.law().scalars.into_iter();
        let level = scalars.find(|(key, _)| matches!(*key, "breakaway_N" | "coulomb_N"));
        level.map(|(key, value)| (key, *value))
    }

    /// The force (N) at which the body breaks away, where the model has such a parameter.
    pub fn breakaway(&self) -> Option<f64> {
        self.level().map(|(_, force)| force)
    }

    /// The Stribeck curve, where the model has one.
    pub fn sliding(&self) -> Option<Sliding> {
        self.clone().law().curve.given().copied()
    }

    /// A quasi-static GMS from stiffnesses (N/m) and yield displacements (m).
    pub fn maxwell_slip(stiffness: &[f64], yields: &[f64]) -> Self {
        let breakaway: f64 = stiffness.iter().zip(yields).map(|(k, d)| k * d).sum();
        Self::Gms {
            breakaway,
            blocks: stiffness
                .iter()
                .zip(yields)
                .map(|(&k, d)| Block {
                    stiffness: k,
                    weight: k * d / breakaway,
                })
                .collect(),
            sliding: None,
        }
    }

    /// The friction force at every sample of `path`, computed by the library.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter.
    pub fn force(&self, path: Path) -> Result<Vec<f64>, ParamError> {
        self.force_through(path, Transmission::default())
    }

    /// The same behind a transmission that is not stiff and tight.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter, or where there is creep but no highest force.
    pub fn force_through(
        &self,
        path: Path,
        transmission: Transmission,
    ) -> Result<Vec<f64>, ParamError> {
        self.visit(path.sample_time, Driven { path, transmission })?
    }

    /// The same from rest, tick after tick of `sample_time` (s).
    ///
    /// # Errors
    /// As there.
    pub fn at_work(
        &self,
        transmission: Transmission,
        sample_time: f64,
    ) -> Result<Tick, ParamError> {
        let visitor = AtWork {
            transmission,
            sample_time,
        };
        self.visit(sample_time, visitor)?
    }

    /// Hands the library's model, in SI and for ticks of `sample_time` (s), to `visitor`.
    ///
    /// # Errors
    /// [`ParamError`] where the library refuses a parameter.
    pub fn visit<V: Visitor>(
        &self,
        sample_time: f64,
        visitor: V,
    ) -> Result<V::Outcome, ParamError> {
        self.visit_in(sample_time, Units::SI, visitor)
    }
}

/// What a viscous term of a law's own is called; a file may leave it out.
pub(crate) fn is_damping(key: &str) -> bool {
    key.starts_with("damping")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scale of a million, as a power of two so that scaling rounds nothing.
    const MILLION: f64 = 1_048_576.0;

    /// The friction along three strokes that shrink.
    fn force(
        model: &FrictionModel,
        l: f64,
        transmission: Transmission,
    ) -> Result<Vec<f64>, ParamError> {
        let (samples, sample_time) = (900, 1e-3);
        let phase = |i: usize| i as f64 * 0.021;
        let position: Vec<f64> = (0..samples)
            .map(|i| l * phase(i).sin() * (1.0 - i as f64 / 1200.0))
            .collect();
        let rate = |i: usize| match i {
            0 => 0.0,
            i => (position[i] - position[i - 1]) / sample_time,
        };
        let velocity: Vec<f64> = (0..samples).map(rate).collect();
        let path = Path {
            position: &position,
            velocity: &velocity,
            pieces: &[0..400, 400..samples],
            sample_time,
        };
        model.force_through(path, transmission)
    }

    /// Units are the user's choice: a law of a million newtons or a millionth of a metre is the same law.
    #[test]
    fn every_law_is_the_same_at_any_scale_of_force_and_length() {
        let transmissions = |l: f64| {
            let (creep, gap) = (Some((1e-3 * l, 0.2)), 0.05 * l);
            [(None, 0.0), (None, gap), (creep, 0.0), (creep, gap)]
                .map(|(creep, gap)| Transmission { creep, gap })
        };
        let mut crept = 0;
        for (law, model) in FrictionModel::one_of_each(1.0, 1.0).iter().enumerate() {
            for (k, transmission) in transmissions(1.0).into_iter().enumerate() {
                // A law without a highest force has none that creep could be a share of, and says so.
                let one = match force(model, 1.0, transmission) {
                    Err(_) if transmission.creep.is_some() => continue,
                    one => one.unwrap_or_else(|e| panic!("{model:?}: {e}")),
                };
                crept += usize::from(transmission.creep.is_some());
                let most = one.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
                assert!(most > 0.5, "{model:?}: {most}");
                for f in [1.0 / MILLION, 1.0, 1024.0, MILLION] {
                    for l in [1.0 / MILLION, 1.0, MILLION] {
                        let scaled = force(
                            &FrictionModel::one_of_each(f, l)[law],
                            l,
                            transmissions(l)[k],
                        )
                        .unwrap_or_else(|e| panic!("{}, {f} N, {l} m: {e}", model.name()));
                        let worst = one
                            .iter()
                            .zip(&scaled)
                            .map(|(a, b)| (a - b / f).abs())
                            .fold(0.0, f64::max);
                        // Scaled by powers of two, only what is not scaled itself rounds otherwise.
                        assert!(
                            worst <= 1e-5 * most,
                            "{}, transmission {k}, force {f} N, length {l} m: off by {worst} of {most}",
                            model.name()
                        );
                        assert!(scaled.iter().all(|f| f.is_finite()));
                    }
                }
            }
        }
        assert!(crept >= 8, "creep went with {crept} laws and gaps only");
    }
}
