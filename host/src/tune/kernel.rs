//! The library's Maxwell-slip kernels, chosen at run time and run along encoder counts.

use crate::friction::FrictionModel;
use preslide::kernels::{ConstantTimeSlipReserve, CountGms, PackedSlipReserve, SlipReserve};
use preslide::{
    Block, Bound, Friction, Gms, Motion, ParamError, QuasiStaticGms, Scalar, Sliding, Units,
};
use std::ops::Range;

/// Most blocks that a kernel was measured with.
pub const MOST_BLOCKS: usize = 10;

/// A kernel of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// [`Gms`] in `f32`.
    GmsF32,
    /// [`CountGms`].
    GmsI32,
    /// [`QuasiStaticGms`] in `f32`.
    QuasiStaticF32,
    /// [`SlipReserve`].
    SlipReserve,
    /// [`PackedSlipReserve`].
    Packed,
    /// [`ConstantTimeSlipReserve`].
    ConstantTime,
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

impl Counts<'_> {
    fn run<M: Friction>(&self, model: &M, units: Units) -> Vec<f64> {
        // Fixed point rounds to nearest.
        let scalar = |value: f64| {
            let limit = M::Scalar::greatest();
            M::Scalar::try_from_f64(value.clamp(-limit, limit)).unwrap_or(M::Scalar::ZERO)
        };
        let mut state = model.at_rest();
        let mut force = vec![0.0; self.position.len()];
        for piece in self.pieces {
            let mut last = self.position[piece.start];
            for i in piece.clone() {
                let travelled = (self.position[i] - last) as f64 * self.count;
                last = self.position[i];
                let motion = Motion {
                    displacement: scalar(travelled / units.length),
                    velocity: scalar(self.velocity[i] / units.velocity),
                };
                force[i] = model.step(&mut state, motion).to_f64() * units.force;
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
            other => Err(ParamError {
                parameter: "number of blocks",
                block: None,
                value: other as f64,
                bound: Bound::AtMost(MOST_BLOCKS as f64),
            }),
        }
    };
}

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::GmsF32,
        Self::GmsI32,
        Self::QuasiStaticF32,
        Self::SlipReserve,
        Self::Packed,
        Self::ConstantTime,
    ];

    /// Its name in the table of costs.
    pub fn name(self) -> &'static str {
        match self {
            Self::GmsF32 => "gms_f32",
            Self::GmsI32 => "gms_i32",
            Self::QuasiStaticF32 => "quasi_static_f32",
            Self::SlipReserve => "slip_reserve_i32",
            Self::Packed => "packed",
            Self::ConstantTime => "constant_time",
        }
    }

    /// The arithmetic of the controller and the effects around it: fixed point where the kernel computes in whole numbers.
    pub fn arithmetic(self) -> &'static str {
        match self {
            Self::GmsF32 | Self::QuasiStaticF32 => "f32",
            Self::GmsI32 | Self::SlipReserve | Self::Packed | Self::ConstantTime => "i16f16",
        }
    }

    /// The numbers that the kernel itself computes in.
    pub fn numbers(self) -> &'static str {
        match self {
            Self::GmsF32 | Self::QuasiStaticF32 => "f32",
            Self::GmsI32 | Self::SlipReserve => "i32",
            Self::Packed | Self::ConstantTime => "2×16 bit",
        }
    }

    /// What it is, in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::GmsF32 => "f32, full law",
            Self::GmsI32 => "i32, full law",
            Self::QuasiStaticF32 => "f32, quasi-static",
            Self::SlipReserve => "i32, quasi-static, safe code",
            Self::Packed => "2×16 bit, quasi-static, with DSP instructions where the core has them",
            Self::ConstantTime => "2×16 bit, quasi-static, one path whatever moves",
        }
    }

    /// The force (N or N·m) of a GMS model in this kernel's arithmetic.
    ///
    /// # Errors
    /// [`ParamError`] where the model lies outside the kernel's range.
    pub fn force(
        self,
        blocks: &[Block],
        breakaway: f64,
        sliding: Option<Sliding>,
        counts: &Counts,
    ) -> Result<Vec<f64>, ParamError> {
        let sliding = sliding.unwrap_or(Sliding::none(breakaway));
        let whole = |force: f64| Units {
            length: counts.count,
            force,
            velocity: sliding.stribeck_velocity * 1e-4,
        };
        let (count, ts) = (counts.count, counts.sample_time);
        with_blocks!(blocks, array, PAIRS => {
            let packed = whole(PackedSlipReserve::<PAIRS>::finest_force(&array, breakaway, count));
            match self {
                Self::GmsF32 => Gms::<_, f32>::try_new(&array, breakaway, sliding, ts, Units::SI)
                    .map(|model| counts.run(&model, Units::SI)),
                Self::QuasiStaticF32 => QuasiStaticGms::<_, f32>::try_new(&array, breakaway, Units::SI)
                    .map(|model| counts.run(&model, Units::SI)),
                Self::GmsI32 => {
                    let units = whole(CountGms::finest_force(&array, breakaway, count));
                    CountGms::try_new(&array, breakaway, sliding, ts, units).map(|model| counts.run(&model, units))
                }
                Self::SlipReserve => {
                    let units = whole(SlipReserve::finest_force(&array, breakaway, count));
                    SlipReserve::try_new(&array, breakaway, units).map(|model| counts.run(&model, units))
                }
                Self::Packed => PackedSlipReserve::<PAIRS>::try_new(&array, breakaway, packed)
                    .map(|model| counts.run(&model, packed)),
                Self::ConstantTime => ConstantTimeSlipReserve::<PAIRS>::try_new(&array, breakaway, packed)
                    .map(|model| counts.run(&model, packed)),
            }
        }, 1 1, 2 1, 3 2, 4 2, 5 3, 6 3, 7 4, 8 4, 9 5, 10 5)
    }

    /// The same for a model of any kind; `None` where it is no Maxwell-slip model.
    pub fn force_of(
        self,
        friction: &FrictionModel,
        counts: &Counts,
    ) -> Option<Result<Vec<f64>, ParamError>> {
        match friction {
            FrictionModel::Gms {
                breakaway,
                blocks,
                sliding,
            } => Some(self.force(blocks, *breakaway, *sliding, counts)),
            _ => None,
        }
    }
}
