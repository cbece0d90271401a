//! What gcc makes of the library's own kernels: the same formulation in C (`peers`), on the same model and state.

use preslide::Friction;
use preslide::kernels::{CountGms, SlipReserve, Whole};

use crate::kernels::{BREAKAWAY, SLIDING, blocks, built, counts, packed_force};
use crate::motion::{COUNT, SAMPLE_TIME};
use crate::stub::Row;

/// One kernel of `build.rs` at every measured N.
macro_rules! translated {
    ($kernel:literal, $model:ident, |$blocks:ident| $force:expr, |$units:ident| $make:expr) => {
        translated!(@ $kernel, $model, $blocks, $force, $units, $make, 1 2 3 4 6 8 10)
    };
    (@ $kernel:literal, $model:ident, $blocks:ident, $force:expr, $units:ident, $make:expr, $($n:literal)*) => {
        $({
            type State = <$model<$n> as Friction>::State;
            // SAFETY: build.rs compiles the function with this N and this name; its structures are the library's, `repr(C)`.
            unsafe extern "C" {
                #[link_name = concat!("cycles__", $kernel, "__", $n)]
                fn step(model: &$model<$n>, state: &mut State, displacement: Whole, velocity: Whole) -> Whole;
            }
            let $blocks = &blocks::<$n>();
            let $units = counts($force);
            let model: $model<$n> = built($make);
            let row = Row { kernel: $kernel, blocks: $n, units: $units };
            let call = row.run(&model, model.at_rest(), step, |_, _, _| ());
            row.print_measured::<State>(&call, None);
        })*
    };
}

pub fn run() {
    translated!(
        "slip_reserve_i32_gcc_O2",
        SlipReserve,
        |blocks| packed_force(blocks),
        |units| { SlipReserve::try_new(blocks, BREAKAWAY, units) }
    );
    translated!(
        "gms_i32_gcc_O2",
        CountGms,
        |blocks| CountGms::finest_force(blocks, BREAKAWAY, COUNT),
        |units| CountGms::try_new(blocks, BREAKAWAY, SLIDING, SAMPLE_TIME, units)
    );
}
