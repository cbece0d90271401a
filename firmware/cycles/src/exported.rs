//! What `preslide export --lang c` writes of Table 3's six blocks, built by gcc: its forces must be those of the library's kernels.

use preslide::kernels::{PackedSlipReserve, Scaled};
use preslide::{Friction, Gms, QuasiStaticGms, Units};

use crate::kernels::{BREAKAWAY, SLIDING, blocks, built};
use crate::motion::SAMPLE_TIME;
use crate::stub::Row;

/// An exported model, as many words as it remembers, the library's model, and whether two forces are the same.
macro_rules! exported {
    ($name:literal, $words:literal, $model:expr, $are_same:expr) => {{
        type State = [u32; $words];
        // C has its own: two arrays of six, which this is as long as.
        type Model = [u32; 12];
        // SAFETY: build.rs compiles the file of this name, with these functions.
        unsafe extern "C" {
            #[link_name = concat!("cycles__exported_c_", $name, "__6")]
            fn step(model: &Model, state: &mut State, displacement: f32, velocity: f32) -> f32;
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
        let row = Row {
            kernel: concat!("exported_c_", $name),
            blocks: 6,
            units: Units::SI,
        };
        let compare = |motion, force: f32| {
            let wanted: f32 = model.step(&mut own, motion);
            assert!(
                $are_same(force, wanted),
                "{}: {force} N in C, {wanted} N in Rust",
                $name
            );
        };
        let call = row.run_watched(&Model::default(), state, step, |_, _, _| (), compare);
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
    let gms = Gms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, Units::SI);
    exported!("gms_f32", 8, gms, near);
    let quasi_static = QuasiStaticGms::try_new(blocks, BREAKAWAY, Units::SI);
    exported!("quasi_static_f32", 6, quasi_static, same_bits);
    let packed = Scaled::<PackedSlipReserve<3>, f32>::try_new(blocks, BREAKAWAY, Units::SI);
    exported!("packed_f32", 8, packed, same_bits);
}
