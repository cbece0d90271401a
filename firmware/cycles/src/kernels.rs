//! The library's kernels that are measured, with the paper's parameters.

use fixed::types::I16F16;
use preslide::kernels::{CountGms, PackedSlipReserve, Scaled, SlipReserve, Whole};
use preslide::{
    Block, BoucWen, Coulomb, Dahl, ElastoPlastic, Friction, Gms, Hsieh, HsiehParams, Leuven,
    LeuvenForm, LuGre, Motion, ParamError, QuasiStaticGms, Sliding, TwoState, Units,
};

use crate::checksum::Checksum;
use crate::motion::{COUNT, Jumps, SAMPLE_TIME};
use crate::stub;

#[path = "../../../host/src/paper/table_3.rs"]
mod table_3;

/// Breakaway force \[N\] (Table 2).
pub const BREAKAWAY: f64 = 0.9;

/// 10 % Stribeck effect at 1 mm/s, and a lag of 45 ms: the paper gives neither for its stage.
pub const SLIDING: Sliding = Sliding {
    coulomb: 0.81,
    stribeck_velocity: 1e-3,
    stribeck_exponent: 2.0,
    attraction: 20.0,
};

/// Counts, millinewtons and millimetres per second, for fixed point.
pub const COUNTS: Units = Units {
    length: COUNT,
    force: 1e-3,
    velocity: 1e-3,
};

/// `k_i` \[N/m\] and `α_i` of N blocks: a column of Table 3, and for N = 1 the virgin curve's secant at 20 µm.
pub const fn table_3<const N: usize>() -> [(f64, f64); N] {
    let column: &[(f64, f64)] = match N {
        1 => &[(40_000.0, 1.0)],
        2..=10 => table_3::TABLE_3[N - 2],
        _ => panic!("Table 3 has 2 to 10 blocks"),
    };
    let mut blocks = [(0.0, 0.0); N];
    let mut i = 0;
    while i < N {
        blocks[i] = column[i];
        i += 1;
    }
    blocks
}

pub fn blocks<const N: usize>() -> [Block; N] {
    table_3().map(|(stiffness, weight)| Block { stiffness, weight })
}

/// A model that the library refuses is a fault of this file: the run ends with the library's reason.
pub fn built<M>(model: Result<M, ParamError>) -> M {
    match model {
        Ok(model) => model,
        Err(error) => panic!("{error}"),
    }
}

/// The kernels in whole numbers, as a control task takes them.
type Packed<const PAIRS: usize, S> = Scaled<PackedSlipReserve<PAIRS>, S>;
type OneByOne<const N: usize, S> = Scaled<SlipReserve<N>, S>;
type Full<const N: usize, S> = Scaled<CountGms<N>, S>;

/// One kernel at every measured N.
macro_rules! sweep {
    ($kernel:literal, $model:ident < N, $scalar:ty >, $units:expr, $make:expr) => {
        sweep!(@ $kernel, $units, $make, [$model<1, $scalar>] 1, [$model<2, $scalar>] 2, [$model<3, $scalar>] 3,
               [$model<4, $scalar>] 4, [$model<6, $scalar>] 6, [$model<8, $scalar>] 8, [$model<10, $scalar>] 10)
    };
    ($kernel:literal, $model:ident < PAIRS, $scalar:ty >, $units:expr, $make:expr) => {
        sweep!(@ $kernel, $units, $make, [$model<1, $scalar>] 1, [$model<1, $scalar>] 2, [$model<2, $scalar>] 3,
               [$model<2, $scalar>] 4, [$model<3, $scalar>] 6, [$model<4, $scalar>] 8, [$model<5, $scalar>] 10)
    };
    (@ $kernel:literal, $units:expr, $make:expr, $([$model:ty] $n:literal),*) => {
        $({
            let make = $make;
            stub!($kernel, $n, $model, $units, built(make(&blocks::<$n>(), $units)));
        })*
    };
}

/// Table 2.
const HSIEH: HsiehParams = HsiehParams {
    k1: 51_540.0,
    k2: 2_026_400.0,
    viscous: 5000.0,
    beta: 3_216_500.0,
    creep: 500.0,
    hardening: 31_200.0,
    hardening_exponent: 3.22,
};

/// The Leuven model with the blocks of Table 3.
macro_rules! leuven {
    ($kernel:literal, $form:ident, $($n:literal)*) => {
        $(stub!(
            $kernel,
            $n,
            Leuven<$n, f32>,
            Units::SI,
            built(Leuven::try_new(LeuvenForm::$form, &blocks(), BREAKAWAY, 5.0, 0.0, SLIDING, Units::SI))
        );)*
    };
}

pub fn run() {
    sweep!("gms_f32", Gms<N, f32>, Units::SI, |blocks, units| {
        Gms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    });
    sweep!("gms_i16f16", Gms<N, I16F16>, COUNTS, |blocks, units| {
        Gms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    });
    sweep!("quasi_static_f32", QuasiStaticGms<N, f32>, Units::SI, |blocks, units| {
        QuasiStaticGms::try_new(blocks, BREAKAWAY, units)
    });
    sweep!("quasi_static_i16f16", QuasiStaticGms<N, I16F16>, COUNTS, |blocks, units| {
        QuasiStaticGms::try_new(blocks, BREAKAWAY, units)
    });
    sweep!("packed_f32", Packed<PAIRS, f32>, Units::SI, |blocks, units| {
        Packed::<_, f32>::try_new(blocks, BREAKAWAY, units)
    });
    in_whole_numbers();
    // Table 2's parameters; Dahl also with the exponent 1, which needs no power.
    stub!(
        "dahl_n1_f32",
        1,
        Dahl<f32>,
        Units::SI,
        built(Dahl::try_new(320e3, BREAKAWAY, 1.0, Units::SI))
    );
    stub!(
        "dahl_n1.6_f32",
        1,
        Dahl<f32>,
        Units::SI,
        built(Dahl::try_new(320e3, BREAKAWAY, 1.6, Units::SI))
    );
    stub!(
        "lugre_f32",
        1,
        LuGre<f32>,
        Units::SI,
        built(LuGre::try_new(195e3, 4416.0, BREAKAWAY, SLIDING, Units::SI))
    );
    stub!(
        "coulomb_f32",
        1,
        Coulomb<f32>,
        Units::SI,
        built(Coulomb::try_new(BREAKAWAY, 5.0, Units::SI))
    );
    stub!(
        "hsieh_f32",
        1,
        Hsieh<f32>,
        Units::SI,
        built(Hsieh::try_new(&HSIEH, SAMPLE_TIME, Units::SI))
    );
    // The paper has no parameters of the next four: LuGre's stiffness, and shapes in the middle of their ranges.
    stub!(
        "bouc_wen_f32",
        1,
        BoucWen<f32>,
        Units::SI,
        built(BoucWen::try_new(195e3, BREAKAWAY, 1.6, 0.8, Units::SI))
    );
    stub!(
        "elasto_plastic_f32",
        1,
        ElastoPlastic<f32>,
        Units::SI,
        built(ElastoPlastic::try_new(
            195e3,
            4416.0,
            2e-6,
            BREAKAWAY,
            SLIDING,
            Units::SI
        ))
    );
    stub!(
        "two_state_f32",
        1,
        TwoState<f32>,
        Units::SI,
        built(TwoState::try_new(
            30e-6,
            BREAKAWAY,
            SLIDING,
            SAMPLE_TIME,
            Units::SI
        ))
    );
    leuven!("leuven_f32", Modified, 1 4 8);
    leuven!("leuven_original_f32", Original, 8);
}

/// Those without `f32` and without the crate `fixed`'s products.
pub fn in_whole_numbers() {
    sweep!("count_gms_i16f16", Full<N, I16F16>, COUNTS, |blocks, units| {
        Full::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    });
    sweep!("slip_reserve_i16f16", OneByOne<N, I16F16>, COUNTS, |blocks, units| {
        OneByOne::try_new(blocks, BREAKAWAY, units)
    });
    sweep!("packed_i16f16", Packed<PAIRS, I16F16>, COUNTS, |blocks, units| {
        Packed::try_new(blocks, BREAKAWAY, units)
    });
}

/// Steps of [`long_runs`].
pub const LONG: usize = 1_000_000;

/// The kernels in whole numbers over a million random displacements (counts) and velocities (0.1 µm/s), six blocks: `report` gets name
/// and checksum.
pub fn long_runs(report: impl Fn(&str, u64)) {
    let blocks = &blocks::<6>();
    let counts = |force| Units {
        length: COUNT,
        force,
        velocity: 1e-7,
    };
    let slip = counts(PackedSlipReserve::<3>::finest_force(
        blocks, BREAKAWAY, COUNT,
    ));
    let full = counts(CountGms::finest_force(blocks, BREAKAWAY, COUNT));
    let gms = CountGms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, full);
    report("count_gms", long_run(&built(gms)));
    let plain = built(SlipReserve::try_new(blocks, BREAKAWAY, slip));
    report("slip_reserve", long_run(&plain));
    let packed = built(PackedSlipReserve::<3>::try_new(blocks, BREAKAWAY, slip));
    report("packed", long_run(&packed));
}

#[inline(never)]
fn long_run<F: Friction<Scalar = Whole>>(model: &F) -> u64 {
    let mut state = model.at_rest();
    let mut checksum = Checksum::new();
    for (displacement, velocity) in Jumps::new().take(LONG) {
        let motion = Motion {
            displacement: Whole::from_bits(displacement),
            velocity: Whole::from_bits(velocity),
        };
        checksum.add_whole(model.step(&mut state, motion).to_bits());
    }
    checksum.value()
}
