//! The library's Maxwell-slip kernels by name, each in the number type of the controller around it: run along encoder counts, handed
//! to what takes any friction model, and named in exported source.

use crate::friction::{FrictionModel, Visitor};
use preslide::fixed::types::I16F16;
use preslide::kernels::{CountGms, PackedSlipReserve, Scaled, SlipReserve};
use preslide::{
    Block, Bound, Friction, Gms, Motion, ParamError, QuasiStaticGms, Scalar, Sliding, Units,
};
use std::ops::Range;

/// Most blocks of a kernel, the same as of a model.
pub const MOST_BLOCKS: usize = 16;

/// A kernel of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// [`Gms`] in `f32`.
    GmsF32,
    /// [`CountGms`] for a controller in I16F16.
    CountGms,
    /// [`QuasiStaticGms`] in `f32`.
    QuasiStaticF32,
    /// [`PackedSlipReserve`] for a controller in `f32`.
    PackedF32,
    /// [`PackedSlipReserve`] for a controller in I16F16.
    Packed,
    /// [`SlipReserve`] for a controller in I16F16.
    SlipReserve,
}

/// The number type of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// `f32`.
    F32,
    /// I16F16.
    I16F16,
}

impl Arithmetic {
    /// Its name in the table of costs.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::I16F16 => "i16f16",
        }
    }

    /// The type in exported source.
    pub fn source(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::I16F16 => "::preslide::fixed::types::I16F16",
        }
    }
}

/// A motion as the encoder reports it.
pub struct Counts<'a> {
    /// Position (counts).
    pub position: &'a [i64],
    /// Velocity (m/s or rad/s).
    pub velocity: &'a [f64],
    /// Contiguous samples.
    pub pieces: &'a [Range<usize>],
    /// Length of a count (m or rad).
    pub count: f64,
    /// Time between samples (s).
    pub sample_time: f64,
}

/// A run of a kernel along counts: its force (N or N·m).
struct Along<'a> {
    counts: &'a Counts<'a>,
    units: Units,
}

impl<S: Scalar> Visitor<S> for Along<'_> {
    type Outcome = Vec<f64>;

    fn visit<M: Friction<Scalar = S>>(self, model: M) -> Vec<f64> {
        let mut state = model.at_rest();
        self.run(&mut |motion| model.step(&mut state, motion))
    }
}

impl Along<'_> {
    /// Compiled once an arithmetic, and not once for each kernel of each size.
    fn run<S: Scalar>(&self, step: &mut dyn FnMut(Motion<S>) -> S) -> Vec<f64> {
        let Self { counts, units } = self;
        // Fixed point rounds to nearest.
        let scalar = |value: f64| {
            let limit = S::greatest();
            S::try_from_f64(value.clamp(-limit, limit)).unwrap_or(S::ZERO)
        };
        let mut force = vec![0.0; counts.position.len()];
        for piece in counts.pieces {
            let mut last = counts.position[piece.start];
            for i in piece.clone() {
                let travelled = (counts.position[i] - last) as f64 * counts.count;
                last = counts.position[i];
                let motion = Motion {
                    displacement: scalar(travelled / units.length),
                    velocity: scalar(counts.velocity[i] / units.velocity),
                };
                force[i] = step(motion).to_f64() * units.force;
            }
        }
        force
    }
}

/// Calls `$body` with the blocks as an array and half their number, rounded up, as `$pairs`.
macro_rules! with_blocks {
    ($blocks:expr, $array:ident, $pairs:ident => $body:expr, $($n:literal $half:literal),*) => {
        match $blocks.len() {
            $($n => {
                const $pairs: usize = $half;
                let mut $array = [Block { stiffness: 0.0, weight: 0.0 }; $n];
                $array.copy_from_slice($blocks);
                $body
            })*
            other => Err(ParamError::new("number of blocks", other as f64, Bound::AtMost(MOST_BLOCKS as f64))),
        }
    };
}

/// What a kernel in whole numbers computes with.
pub struct WholeNumbers {
    /// Of each block `2·D_i` in units of length, and `k_i` in units of force per unit of length; of the full law what [`CountGms::blocks`] says.
    pub blocks: Vec<[i32; 2]>,
    /// Binary places from the controller's units to the kernel's, as [`Scaled::places`] says.
    pub places: (u32, u32, i32),
    /// Greatest force in the controller's units.
    pub limit: f64,
    /// The Stribeck curve and the lag.
    pub curves: Option<Curves>,
}

/// What the full law has beside its blocks: see [`CountGms`].
pub struct Curves {
    /// [`CountGms::longest`].
    pub longest: i32,
    /// [`CountGms::curves`].
    pub table: (u32, Vec<[i32; 4]>),
}

impl WholeNumbers {
    fn of<K: preslide::kernels::Kernel, S: Scalar>(
        model: &Scaled<K, S>,
        blocks: impl Iterator<Item = [i32; 2]>,
    ) -> Self {
        Self {
            blocks: blocks.collect(),
            places: model.places(),
            limit: model.limit().map_or(f64::INFINITY, S::to_f64),
            curves: None,
        }
    }
}

/// A Maxwell-slip model's own parameters.
struct MaxwellSlip<'a> {
    blocks: &'a [Block],
    breakaway: f64,
    sliding: Option<Sliding>,
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::GmsF32,
        Self::CountGms,
        Self::QuasiStaticF32,
        Self::PackedF32,
        Self::Packed,
        Self::SlipReserve,
    ];

    /// Its name on the command line and in the table of costs: the law's form, and the number type of the controller.
    pub fn name(self) -> &'static str {
        match self {
            Self::GmsF32 => "gms_f32",
            Self::CountGms => "count_gms_i16f16",
            Self::QuasiStaticF32 => "quasi_static_f32",
            Self::PackedF32 => "packed_f32",
            Self::Packed => "packed_i16f16",
            Self::SlipReserve => "slip_reserve_i16f16",
        }
    }

    /// The kernel of that name.
    ///
    /// # Errors
    /// Which there are.
    pub fn named(name: &str) -> Result<Self, String> {
        if let Some(kernel) = Self::ALL.into_iter().find(|kernel| kernel.name() == name) {
            return Ok(kernel);
        }
        let known: Vec<&str> = Self::ALL.iter().map(|kernel| kernel.name()).collect();
        Err(format!(
            "no kernel {name}: known are {}, and auto for what `preslide tune` recommends",
            known.join(", ")
        ))
    }

    /// The number type of the controller and the effects around it.
    pub fn arithmetic(self) -> Arithmetic {
        match self {
            Self::GmsF32 | Self::QuasiStaticF32 | Self::PackedF32 => Arithmetic::F32,
            Self::CountGms | Self::Packed | Self::SlipReserve => Arithmetic::I16F16,
        }
    }

    /// The numbers that the kernel itself computes in.
    pub fn numbers(self) -> &'static str {
        match self {
            Self::GmsF32 | Self::QuasiStaticF32 => "f32",
            Self::CountGms | Self::SlipReserve => "i32",
            Self::PackedF32 | Self::Packed => "2×16 bit",
        }
    }

    /// It has the Stribeck curve and the lag.
    pub fn has_sliding(self) -> bool {
        matches!(self, Self::GmsF32 | Self::CountGms)
    }

    /// What it is, in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::GmsF32 => "f32, full law",
            Self::CountGms => "i32 in a controller in I16F16, full law",
            Self::QuasiStaticF32 => "f32, quasi-static",
            Self::PackedF32 => {
                "2×16 bit in a controller in f32, quasi-static, with DSP instructions where the core has them"
            }
            Self::Packed => {
                "2×16 bit in a controller in I16F16, quasi-static, with DSP instructions where the core has them"
            }
            Self::SlipReserve => "i32 in a controller in I16F16, quasi-static",
        }
    }

    /// The library's type with N blocks, over the number type `S`, as source.
    pub fn source(self, blocks: usize) -> String {
        let scaled = |kernel: &str, n: usize| {
            format!("::preslide::kernels::Scaled<::preslide::kernels::{kernel}<{n}>, S>")
        };
        match self {
            Self::GmsF32 => format!("::preslide::Gms<{blocks}, S>"),
            Self::QuasiStaticF32 => format!("::preslide::QuasiStaticGms<{blocks}, S>"),
            Self::CountGms => scaled("CountGms", blocks),
            Self::SlipReserve => scaled("SlipReserve", blocks),
            Self::PackedF32 | Self::Packed => scaled("PackedSlipReserve", blocks.div_ceil(2)),
        }
    }

    /// The force (N or N·m) of a Maxwell-slip model in this kernel's arithmetic, in I16F16 with the count, a thousandth of the breakaway
    /// force and the Stribeck velocity as units; `None` where the model is another one.
    pub fn force(
        self,
        friction: &FrictionModel,
        counts: &Counts,
    ) -> Option<Result<Vec<f64>, ParamError>> {
        let model = MaxwellSlip::of(friction)?;
        let time = counts.sample_time;
        Some(match self.arithmetic() {
            Arithmetic::F32 => {
                let units = Units::SI;
                self.hand::<f32, _>(&model, time, units, Along { counts, units })
            }
            Arithmetic::I16F16 => {
                let units = Units {
                    length: counts.count,
                    force: 1e-3 * model.breakaway,
                    velocity: model.sliding.map_or(1.0, |s| s.stribeck_velocity),
                };
                self.hand::<I16F16, _>(&model, time, units, Along { counts, units })
            }
        })
    }

    /// Hands the kernel with the parameters of a Maxwell-slip model, in SI and `f64` around it, to `visitor`; `None` where the model is
    /// another one. `sample_time` in s.
    pub fn visit<V: Visitor>(
        self,
        friction: &FrictionModel,
        sample_time: f64,
        visitor: V,
    ) -> Option<Result<V::Outcome, ParamError>> {
        let model = MaxwellSlip::of(friction)?;
        Some(self.hand::<f64, V>(&model, sample_time, Units::SI, visitor))
    }

    /// What a kernel computes with; `None` where that is no whole numbers, or the model no Maxwell slip. `sample_time` in s.
    ///
    /// # Errors
    /// As [`Kernel::visit`]'s.
    pub fn whole_numbers(
        self,
        friction: &FrictionModel,
        sample_time: f64,
        units: Units,
    ) -> Option<Result<WholeNumbers, ParamError>> {
        let model = MaxwellSlip::of(friction)?;
        match self {
            Self::GmsF32 | Self::QuasiStaticF32 => None,
            Self::PackedF32 => Some(self.whole::<f32>(&model, sample_time, units)),
            Self::CountGms | Self::Packed | Self::SlipReserve => {
                Some(self.whole::<I16F16>(&model, sample_time, units))
            }
        }
    }

    fn whole<S: Scalar>(
        self,
        model: &MaxwellSlip,
        sample_time: f64,
        units: Units,
    ) -> Result<WholeNumbers, ParamError> {
        let &MaxwellSlip {
            blocks, breakaway, ..
        } = model;
        let sliding = model.sliding.unwrap_or(Sliding::none(breakaway));
        with_blocks!(blocks, array, PAIRS => Ok(match self {
            Self::CountGms => {
                let model = Scaled::<CountGms<_>, S>::try_new(&array, breakaway, sliding, sample_time, units)?;
                let kernel = model.kernel();
                let (intervals, table) = kernel.curves();
                let curves = Curves { longest: kernel.longest(), table: (intervals, table.collect()) };
                WholeNumbers { curves: Some(curves), ..WholeNumbers::of(&model, kernel.blocks()) }
            }
            Self::SlipReserve => {
                let model = Scaled::<SlipReserve<_>, S>::try_new(&array, breakaway, units)?;
                WholeNumbers::of(&model, model.kernel().blocks())
            }
            _ => {
                let model = Scaled::<PackedSlipReserve<PAIRS>, S>::try_new(&array, breakaway, units)?;
                WholeNumbers::of(&model, model.kernel().blocks().take(blocks.len()))
            }
        }), 1 1, 2 1, 3 2, 4 2, 5 3, 6 3, 7 4, 8 4, 9 5, 10 5, 11 6, 12 6, 13 7, 14 7, 15 8, 16 8)
    }

    fn hand<S: Scalar + Send + 'static, V: Visitor<S>>(
        self,
        model: &MaxwellSlip,
        sample_time: f64,
        units: Units,
        visitor: V,
    ) -> Result<V::Outcome, ParamError> {
        let &MaxwellSlip {
            blocks, breakaway, ..
        } = model;
        let sliding = model.sliding.unwrap_or(Sliding::none(breakaway));
        with_blocks!(blocks, array, PAIRS => Ok(match self {
            Self::GmsF32 => visitor.visit(Gms::<_, S>::try_new(&array, breakaway, sliding, sample_time, units)?),
            Self::QuasiStaticF32 => visitor.visit(QuasiStaticGms::<_, S>::try_new(&array, breakaway, units)?),
            Self::CountGms => {
                visitor.visit(Scaled::<CountGms<_>, S>::try_new(&array, breakaway, sliding, sample_time, units)?)
            }
            Self::SlipReserve => visitor.visit(Scaled::<SlipReserve<_>, S>::try_new(&array, breakaway, units)?),
            Self::PackedF32 | Self::Packed => {
                visitor.visit(Scaled::<PackedSlipReserve<PAIRS>, S>::try_new(&array, breakaway, units)?)
            }
        }), 1 1, 2 1, 3 2, 4 2, 5 3, 6 3, 7 4, 8 4, 9 5, 10 5, 11 6, 12 6, 13 7, 14 7, 15 8, 16 8)
    }
}

impl<'a> MaxwellSlip<'a> {
    fn of(friction: &'a FrictionModel) -> Option<Self> {
        match friction {
            FrictionModel::Gms {
                breakaway,
                blocks,
                sliding,
            } => Some(Self {
                blocks,
                breakaway: *breakaway,
                sliding: *sliding,
            }),
            _ => None,
        }
    }
}
