//! The friction model, chosen by type.

use crate::starting;
use fixed::types::I16F16;
use preslide::{Friction, ParamError, Scalar, Units};
use preslide_link::MOST_PARAMETERS;

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

    /// What the command link may set of it.
    fn table(&mut self) -> Table<'_>;
}

/// The parameters of a model, which the command link sets and flash keeps.
pub struct Table<'a> {
    /// Which they are, and in which order; 0 where there are none.
    pub layout: u32,
    /// Of what was compiled in: what was saved over another model does not come back over this one.
    pub origin: u32,
    /// SI units.
    pub values: &'a mut [f64],
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

/// What `preslide export` wrote: its function `with` over its `PARAMETERS`, in the number type that it was exported for. Without `--kernel`
/// that is single precision, because 16 bits before the point hold ±0.8 mm of counts and effects act along the whole travel.
#[derive(Clone)]
pub struct Exported<F, const N: usize> {
    layout: u32,
    origin: u32,
    values: [f64; N],
    build: Build<F, N>,
}

/// `with` of what `preslide export` wrote.
type Build<F, const N: usize> = fn(&[f64; N], f64, Units) -> Result<F, ParamError>;

impl<F, const N: usize> Exported<F, N> {
    /// Of the file's `LAYOUT`, `PARAMETERS` and `with`. A model of more parameters than the link takes is as it was compiled in.
    pub const fn new(layout: u32, values: [f64; N], build: Build<F, N>) -> Self {
        let layout = if N > MOST_PARAMETERS { 0 } else { layout };
        let (mut origin, mut value) = (layout, 0);
        while value < N {
            let bits = values[value].to_bits();
            origin = fnv(fnv(origin, bits as u32), (bits >> 32) as u32);
            value += 1;
        }
        Self {
            layout,
            origin,
            values,
            build,
        }
    }
}

/// A step of FNV-1a, of words.
pub(crate) const fn fnv(hash: u32, word: u32) -> u32 {
    (hash ^ word).wrapping_mul(0x0100_0193)
}

impl<F: Friction<Scalar: Number> + 'static, const N: usize> Model for Exported<F, N> {
    type Friction = F;
    const UNITS: Units = <F::Scalar as Number>::UNITS;

    fn build(&self, sample_time: f64) -> Result<F, ParamError> {
        (self.build)(&self.values, sample_time, Self::UNITS)
    }

    fn table(&mut self) -> Table<'_> {
        Table {
            layout: self.layout,
            origin: self.origin,
            values: match N > MOST_PARAMETERS {
                true => &mut [],
                false => &mut self.values,
            },
        }
    }
}

/// The model that a board starts with where none was exported for it, four quasi-static blocks in any number type.
pub type Starting<S> = Exported<starting::Model<S>, { starting::PARAMETERS.len() }>;

impl<S: Number> Starting<S> {
    /// The paper's Table 3.
    pub const PAPER: Self =
        Exported::new(starting::LAYOUT, starting::PARAMETERS, starting::with::<S>);
}

/// Declares a board's `Model` and `MODEL`: what `preslide export` wrote into the file that the build was given in PRESLIDE_MODEL,
/// or else [`Starting`] in the number type named. The board's build script tells which.
#[macro_export]
macro_rules! model {
    ($number:ty) => {
        #[cfg(exported_model)]
        #[allow(dead_code)]
        mod exported {
            include!(env!("PRESLIDE_MODEL"));
        }
        #[cfg(exported_model)]
        type Model = $crate::Exported<exported::Model, { exported::PARAMETERS.len() }>;
        #[cfg(exported_model)]
        const MODEL: Model =
            $crate::Exported::new(exported::LAYOUT, exported::PARAMETERS, exported::with);

        #[cfg(not(exported_model))]
        type Model = $crate::Starting<$number>;
        #[cfg(not(exported_model))]
        const MODEL: Model = $crate::Starting::PAPER;
    };
}
