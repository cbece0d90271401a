//! What Preslide's kernels are measured against: the textbook model in C, built by gcc for the same core.

use preslide::Units;

use crate::kernels::{BREAKAWAY, SLIDING, table_3};
use crate::motion::SAMPLE_TIME;
use crate::stub::Row;

/// The C peer's `struct gms`.
#[repr(C)]
struct TextbookGms<const N: usize, S> {
    stiffness: [S; N],
    weight: [S; N],
    breakaway: S,
    coulomb: S,
    stribeck_velocity: S,
    attraction: S,
    sample_time: S,
}

/// The C peer's `struct gms_state`.
#[repr(C)]
struct TextbookState<const N: usize, S> {
    force: [S; N],
    slipping: [i32; N],
    direction: i32,
}

impl<const N: usize, S: preslide::Scalar> TextbookGms<N, S> {
    fn new() -> Self {
        let scalar = |value: f64| S::try_from_f64(value).unwrap_or(S::ZERO);
        Self {
            stiffness: table_3::<N>().map(|(stiffness, _)| scalar(stiffness)),
            weight: table_3::<N>().map(|(_, weight)| scalar(weight)),
            breakaway: scalar(BREAKAWAY),
            coulomb: scalar(SLIDING.coulomb),
            stribeck_velocity: scalar(SLIDING.stribeck_velocity),
            attraction: scalar(SLIDING.attraction),
            sample_time: scalar(SAMPLE_TIME),
        }
    }
}

/// One build of `peers/gms.c` at every measured N.
macro_rules! textbook {
    ($kernel:literal, $scalar:ty) => {
        textbook!($kernel, $scalar, 1 2 3 4 6 8 10)
    };
    ($kernel:literal, $scalar:ty, $($n:literal)*) => {
        $({
            // SAFETY: build.rs compiles the function with this type, this N and this name.
            unsafe extern "C" {
                #[link_name = concat!("cycles__", $kernel, "__", $n)]
                fn step(
                    model: &TextbookGms<$n, $scalar>,
                    state: &mut TextbookState<$n, $scalar>,
                    displacement: $scalar,
                    velocity: $scalar,
                ) -> $scalar;
            }
            let row = Row { kernel: $kernel, blocks: $n, units: Units::SI };
            let state = TextbookState { force: [0.0; $n], slipping: [0; $n], direction: 0 };
            let call = row.run(&TextbookGms::new(), state, step, |_, _, _| ());
            row.print_measured::<TextbookState<$n, $scalar>>(&call, None);
        })*
    };
}

pub fn run() {
    textbook!("textbook_float_O2", f32);
    textbook!("textbook_float_O3_fast", f32);
    textbook!("textbook_double_O2", f64);
}
