//! The friction model, chosen by type.

use core::marker::PhantomData;
use fixed::types::I16F16;
use preslide::{Block, Friction, ParamError, QuasiStaticGms, Scalar, Units};
use preslide_link::{MOST_BLOCKS, ModelSettings, Refusal};

/// How a controller comes by its friction model.
pub trait Model: Clone + 'static {
    /// The friction model.
    type Friction: Friction + 'static;

    /// The units that it computes in.
    const UNITS: Units;

    /// Validates and computes, for ticks of `sample_time` (s).
    ///
    /// # Errors
    /// The first parameter that is not finite, out of range, or does not fit the number type.
    fn build(&self, sample_time: f64) -> Result<Self::Friction, ParamError>;

    /// This model with settings from the command link.
    ///
    /// # Errors
    /// [`Refusal::CompiledIn`] where the link cannot set it.
    fn set(&self, settings: &ModelSettings) -> Result<Self, Refusal>;

    /// What the command link set, or could; `None` for a model that was compiled in.
    fn settings(&self) -> Option<ModelSettings>;
}

/// The number type of the controller, with the units to use it in.
pub trait Number: Scalar + 'static {
    /// Units in which the paper's axis fits the type.
    const UNITS: Units;
}

impl Number for f32 {
    const UNITS: Units = Units::SI;
}

impl Number for I16F16 {
    /// A displacement of 1 is a count, a force of 1 a millinewton.
    const UNITS: Units = Units {
        length: 25e-9,
        force: 1e-3,
        velocity: 1e-3,
    };
}

/// Maxwell-slip blocks that the command link can set.
#[derive(Clone)]
pub struct Blocks<S>(ModelSettings, PhantomData<S>);

impl<S> Blocks<S> {
    /// With these settings.
    pub const fn new(settings: ModelSettings) -> Self {
        Self(settings, PhantomData)
    }
}

impl<S: Number> Model for Blocks<S> {
    type Friction = QuasiStaticGms<MOST_BLOCKS, S>;
    const UNITS: Units = S::UNITS;

    fn build(&self, _sample_time: f64) -> Result<Self::Friction, ParamError> {
        let blocks = self.0.blocks.map(|(stiffness, weight)| Block {
            stiffness: stiffness.into(),
            weight: weight.into(),
        });
        QuasiStaticGms::try_new(&blocks, self.0.breakaway_n.into(), S::UNITS)
    }

    fn set(&self, settings: &ModelSettings) -> Result<Self, Refusal> {
        Ok(Self::new(*settings))
    }

    fn settings(&self) -> Option<ModelSettings> {
        Some(self.0)
    }
}

/// What `preslide export` wrote: its function `model`, in the number type that it was exported for. Without `--kernel` that is single
/// precision, because 16 bits before the point hold ±0.8 mm of counts and effects act along the whole travel.
pub struct Exported<F>(pub fn(f64, Units) -> Result<F, ParamError>);

impl<F> Clone for Exported<F> {
    fn clone(&self) -> Self {
        Self(self.0)
    }
}

impl<F: Friction<Scalar: Number> + 'static> Model for Exported<F> {
    type Friction = F;
    const UNITS: Units = <F::Scalar as Number>::UNITS;

    fn build(&self, sample_time: f64) -> Result<F, ParamError> {
        (self.0)(sample_time, Self::UNITS)
    }

    fn set(&self, _settings: &ModelSettings) -> Result<Self, Refusal> {
        Err(Refusal::CompiledIn)
    }

    fn settings(&self) -> Option<ModelSettings> {
        None
    }
}

/// Declares a board's `Model` and `MODEL`: what `preslide export` wrote into the file that the build was given in PRESLIDE_MODEL,
/// or else blocks in the number type named, which the link can set. The board's build script tells which.
#[macro_export]
macro_rules! model {
    ($number:ty) => {
        #[cfg(exported_model)]
        #[allow(dead_code)]
        mod exported {
            include!(env!("PRESLIDE_MODEL"));
        }
        #[cfg(exported_model)]
        type Model = $crate::Exported<exported::Model>;
        #[cfg(exported_model)]
        const MODEL: Model = $crate::Exported(exported::model);

        #[cfg(not(exported_model))]
        type Model = $crate::Blocks<$number>;
        #[cfg(not(exported_model))]
        const MODEL: Model = $crate::Blocks::new($crate::STARTING_MODEL);
    };
}

/// What the controller starts with: the paper's Table 3, four blocks.
pub const STARTING_MODEL: ModelSettings = ModelSettings {
    breakaway_n: 0.9,
    blocks: [
        (313_728.0, 0.339),
        (43_670.0, 0.236),
        (10_545.0, 0.171),
        (5_858.0, 0.253),
    ],
};
