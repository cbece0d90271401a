//! What `preslide export --lang c` writes of Table 3's six blocks, built by gcc: its forces must be those of the library's kernels.

use fixed::types::I16F16;
use preslide::kernels::{CountGms, PackedSlipReserve, Scaled, SlipReserve};
use preslide::{Friction, Gms, QuasiStaticGms, Units};

use crate::kernels::{BREAKAWAY, SLIDING, blocks, built};
use crate::motion::{COUNT, SAMPLE_TIME};
use crate::stub::Row;

/// Two arrays of six.
const BLOCKS: usize = 12;
/// The full law's in whole numbers, and its table.
const BLOCKS_AND_TABLE: usize = BLOCKS + 64 * 4;

/// What export writes takes and gives at [`COUNT`] and 20 kHz: counts, millinewtons, counts a tick.
const WHOLE: Units = Units {
    length: COUNT,
    force: 1e-3,
    velocity: COUNT * 20_000.0,
};

/// An exported model, as many words as its constants are and as it remembers, the library's model in units, and whether two forces are the same.
macro_rules! exported {
    ($name:literal, $number:ty, $constants:expr, $words:literal, $model:expr, $units:expr, $are_same:expr) => {{
        type State = [u32; $words];
        // C has its own, which this is as long as.
        type Model = [u32; $constants];
        // SAFETY: build.rs compiles the file of this name, with these functions.
        unsafe extern "C" {
            #[link_name = concat!("cycles__exported_c_", $name, "__6")]
            fn step(
                model: &Model,
                state: &mut State,
                displacement: $number,
                velocity: $number,
            ) -> $number;
            #[link_name = concat!($name, "_rest")]
            fn rest(state: &mut State);
            #[link_name = concat!($name, "_bytes")]
            static BYTES: u32;
        }
        let mut state: State = [0; $words];
        // SAFETY: as above, and the state is as long as C's.
        unsafe {
            assert_eq!(BYTES as usize, size_of::<State>(), "{}", $name);
            rest(&mut state);
        }
        let model = built($model);
        let mut own = model.at_rest();
        let constants: Model = [0; $constants];
        let row = Row {
            kernel: concat!("exported_c_", $name),
            blocks: 6,
            units: $units,
        };
        let compare = |motion, force: $number| {
            let wanted: $number = model.step(&mut own, motion);
            assert!(
                $are_same(force, wanted),
                "{}: {force} in C, {wanted} in Rust",
                $name
            );
        };
        let call = row.run_watched(&constants, state, step, |_, _, _| (), compare);
        row.print_measured::<State>(&call, None);
    }};
}

fn same_bits(c: f32, rust: f32) -> bool {
    c.to_bits() == rust.to_bits()
}

/// C has the Stribeck curve and the lag from `math.h`, the library from tables (N).
fn near(c: f32, rust: f32) -> bool {
    (c - rust).abs() <= 5e-4
}

pub fn run() {
    let blocks = &blocks::<6>();
    let si = Units::SI;
    let gms = Gms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, si);
    exported!("gms_f32", f32, BLOCKS, 8, gms, si, near);
    let quasi_static = QuasiStaticGms::try_new(blocks, BREAKAWAY, si);
    exported!(
        "quasi_static_f32",
        f32,
        BLOCKS,
        6,
        quasi_static,
        si,
        same_bits
    );
    let packed = Scaled::<PackedSlipReserve<3>, f32>::try_new(blocks, BREAKAWAY, si);
    exported!("packed_f32", f32, BLOCKS, 8, packed, si, same_bits);

    let same = |c: I16F16, rust: I16F16| c == rust;
    let full =
        Scaled::<CountGms<6>, I16F16>::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, WHOLE);
    exported!(
        "count_gms_i16f16",
        I16F16,
        BLOCKS_AND_TABLE,
        9,
        full,
        WHOLE,
        same
    );
    let packed = Scaled::<PackedSlipReserve<3>, I16F16>::try_new(blocks, BREAKAWAY, WHOLE);
    exported!("packed_i16f16", I16F16, BLOCKS, 8, packed, WHOLE, same);
    let one_by_one = Scaled::<SlipReserve<6>, I16F16>::try_new(blocks, BREAKAWAY, WHOLE);
    exported!(
        "slip_reserve_i16f16",
        I16F16,
        BLOCKS,
        8,
        one_by_one,
        WHOLE,
        same
    );
}
