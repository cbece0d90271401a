//! C in whole numbers: the library's bits, whatever comes in.

use super::*;
use crate::export::{full, packed_i16f16};
use preslide::fixed::types::I16F16;

/// What whole numbers stand for where a count is 25 nm and the breakaway force 0.9 N.
const COUNT: f64 = 25e-9;
const COUNTS: Units = Units {
    length: COUNT,
    force: 1e-3,
    velocity: COUNT * 1e4,
};

/// Displacements and velocities of every size, the ends of the type and rests among them.
fn any_counts() -> Vec<[i32; 2]> {
    let mut next = xorshift();
    let mut any = || match next() % 64 {
        0 => i32::MAX,
        1 => i32::MIN,
        2..10 => 0,
        _ => next() as i32 >> (next() % 32),
    };
    (0..STEPS).map(|_| [any(), any()]).collect()
}

/// Compiled by every compiler that is here, as for firmware and under the sanitizers: the library's bits.
fn assert_whole_numbers<F: Friction<Scalar = I16F16>>(model: &str, more: &[&str], library: &F) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let count = [&["--count", "25e-9"][..], more].concat();
    let source = exported_by(folder.path(), &file(model), &count);
    let code = std::fs::read_to_string(source).expect("written");
    assert!(
        !code.contains("float") && !code.contains("math.h"),
        "{code}"
    );
    let rows = any_counts();
    let mut state = library.at_rest();
    let step = |&[dx, v]: &[i32; 2]| {
        let motion = Motion {
            displacement: I16F16::from_bits(dx),
            velocity: I16F16::from_bits(v),
        };
        library.step(&mut state, motion).to_bits()
    };
    let wanted: Vec<i32> = rows.iter().map(step).collect();
    let [most, least] = [800, 100].map(|units| units << 16);
    let size = |f: &i32| f.unsigned_abs();
    assert!(wanted.iter().any(|f| size(f) > most) && wanted.iter().any(|f| size(f) < least));
    for compiler in compilers() {
        // The second also as a core that multiplies by halves.
        let sanitized = [&["-DWHOLE", "-D__ARM_ARCH_6M__"], &SANITIZED[..]].concat();
        for flags in [&["-DWHOLE", "-O2"][..], &sanitized] {
            let program = compiled(folder.path(), compiler, flags);
            let c = run(
                &program,
                rows.iter().flatten().flat_map(|v| v.to_le_bytes()),
            );
            let c: Vec<i32> = c.into_iter().map(i32::from_le_bytes).collect();
            assert!(c == wanted, "{model} {more:?} {compiler} {flags:?}");
        }
    }
}

#[test]
fn kernels_in_whole_numbers_have_the_librarys_bits_in_c() {
    use preslide::effects::{ConstantForce, Viscous, With};
    use preslide::kernels::{Scaled, SlipReserve};
    type OneByOne = Scaled<SlipReserve<4>, I16F16>;

    let packed = packed_i16f16::model::<I16F16>(STEP, COUNTS).expect("valid");
    let of = |kernel| ["--kernel", kernel];
    assert_whole_numbers("packed.toml", &of("packed_i16f16"), &packed);
    let (blocks, breakaway) = (packed_i16f16::BLOCKS, packed_i16f16::GMS_BREAKAWAY_N);
    let one_by_one = || OneByOne::try_new(&blocks, breakaway, COUNTS).expect("valid");
    assert_whole_numbers("packed.toml", &of("slip_reserve_i16f16"), &one_by_one());
    // Of the full law with its viscous friction, without the effect that C has in single precision alone.
    let sliding = preslide::Sliding {
        coulomb: full::GMS_COULOMB_N,
        stribeck_velocity: full::GMS_STRIBECK_VELOCITY_M_S,
        stribeck_exponent: full::GMS_STRIBECK_EXPONENT,
        attraction: full::GMS_ATTRACTION_N_PER_S,
    };
    let friction = Scaled::<preslide::kernels::CountGms<3>, I16F16>::try_new(
        &full::BLOCKS,
        full::GMS_BREAKAWAY_N,
        sliding,
        STEP,
        COUNTS,
    );
    let viscous = |b, limit| Viscous::try_new(b, limit, COUNTS).expect("valid");
    let with = With::try_new(friction.expect("valid"), viscous(12.0, 9.0)).expect("valid");
    let more = [
        "--kernel",
        "count_gms_i16f16",
        "--without",
        "periodic_force",
    ];
    assert_whole_numbers("full.toml", &more, &with);
    // Where tune chooses, beside forces of both signs.
    let folder = tempfile::tempdir().expect("temporary folder");
    let model = std::fs::read_to_string(file("packed.toml")).expect("kept");
    let more = "breakaway_N = 0.9\nviscous_N_s_per_m = -7.0\n";
    let model = model.replace("breakaway_N = 0.9\n", more)
        + "\n[[effects]]\nid = \"constant_force\"\nforce_N = -0.2\n";
    let written = folder.path().join("forces.toml");
    std::fs::write(&written, model).expect("written");
    let constant = ConstantForce::try_new(-0.2, COUNTS).expect("valid");
    let with = With::try_new(one_by_one(), (viscous(-7.0, 3.0), constant)).expect("valid");
    let more = ["--kernel", "auto", "--cpu", "rp2040", "--limit", "3"];
    assert_whole_numbers(&written.display().to_string(), &more, &with);
}
