//! Every bad parameter is refused by the error that names it.

use fixed::types::{I0F32, I1F31, I2F30, I4F28, I8F24, I16F16, I30F2};
use preslide::{
    Block, Bound, Coulomb, Dahl, EncoderScale, Gms, Hsieh, HsiehParams, LuGre, ParamError,
    QuasiStaticGms, Scalar, Sliding, Units,
};

const NOT_POSITIVE: [f64; 5] = [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
const NEGATIVE: [f64; 4] = [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

const GOOD: [Block; 2] = [
    Block {
        stiffness: 2.0,
        weight: 0.5,
    },
    Block {
        stiffness: 1.0,
        weight: 0.5,
    },
];

const SLIDING: Sliding = Sliding {
    coulomb: 0.5,
    stribeck_velocity: 1.0,
    stribeck_exponent: 2.0,
    attraction: 10.0,
};

fn units(length: f64, force: f64) -> Units {
    Units {
        length,
        force,
        velocity: 1.0,
    }
}

fn gms(blocks: &[Block; 2], breakaway: f64, sliding: Sliding, time: f64) -> Option<ParamError> {
    Gms::<2, f64>::try_new(blocks, breakaway, sliding, time, Units::SI).err()
}

fn quasi_static<S: Scalar>(blocks: &[Block; 2], units: Units) -> Option<ParamError> {
    QuasiStaticGms::<2, S>::try_new(blocks, 1.0, units).err()
}

/// The error names this parameter, block and bound, and carries the value.
#[track_caller]
fn refused(error: Option<ParamError>, parameter: &str, block: Option<usize>, bound: Bound) {
    let error = error.expect("must be refused");
    assert_eq!(error.parameter, parameter, "{error}");
    assert_eq!(error.block, block, "{error}");
    assert_eq!(error.bound, bound, "{error}");
    assert!(error.to_string().starts_with(parameter), "{error}");
}

#[test]
fn good_parameters_are_accepted() {
    assert_eq!(gms(&GOOD, 1.0, SLIDING, 1e-3), None);
    assert_eq!(gms(&GOOD, 1.0, Sliding::none(1.0), 1.0), None);
}

#[test]
fn a_block_that_is_not_finite_and_positive_is_refused_by_its_number() {
    for bad in NOT_POSITIVE {
        let mut blocks = GOOD;
        blocks[1].stiffness = bad;
        refused(
            gms(&blocks, 1.0, SLIDING, 1e-3),
            "stiffness",
            Some(2),
            Bound::Positive,
        );
        refused(
            quasi_static::<f32>(&blocks, Units::SI),
            "stiffness",
            Some(2),
            Bound::Positive,
        );
        let mut blocks = GOOD;
        blocks[0].weight = bad;
        refused(
            gms(&blocks, 1.0, SLIDING, 1e-3),
            "weight",
            Some(1),
            Bound::Positive,
        );
    }
}

#[test]
fn weights_that_do_not_sum_to_one_are_refused() {
    for (weight, accepted) in [
        (0.5, true),
        (0.5049, true),
        (0.4951, true),
        (0.506, false),
        (0.494, false),
    ] {
        let blocks = [GOOD[0], Block { weight, ..GOOD[1] }];
        let error = quasi_static::<f64>(&blocks, Units::SI);
        if accepted {
            assert_eq!(error, None);
        } else {
            refused(error, "sum of the weights", None, Bound::SumToOne);
        }
    }
}

#[test]
fn forces_times_and_sliding_out_of_range_are_refused() {
    for bad in NOT_POSITIVE {
        refused(
            gms(&GOOD, bad, SLIDING, 1e-3),
            "breakaway force",
            None,
            Bound::Positive,
        );
        refused(
            gms(&GOOD, 1.0, SLIDING, bad),
            "sample time",
            None,
            Bound::Positive,
        );
        let sliding = Sliding {
            coulomb: bad,
            ..SLIDING
        };
        refused(
            gms(&GOOD, 1.0, sliding, 1e-3),
            "Coulomb force",
            None,
            Bound::Positive,
        );
        let sliding = Sliding {
            stribeck_velocity: bad,
            ..SLIDING
        };
        refused(
            gms(&GOOD, 1.0, sliding, 1e-3),
            "Stribeck velocity",
            None,
            Bound::Positive,
        );
    }
    for bad in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        let sliding = Sliding {
            attraction: bad,
            ..SLIDING
        };
        refused(
            gms(&GOOD, 1.0, sliding, 1e-3),
            "attraction parameter",
            None,
            Bound::NotNegative,
        );
    }
    refused(
        gms(&GOOD, 1.0, SLIDING, 1.5),
        "sample time",
        None,
        Bound::AtMost(1.0),
    );
    let over = Sliding {
        coulomb: 1.0 + 1e-12,
        ..SLIDING
    };
    refused(
        gms(&GOOD, 1.0, over, 1e-3),
        "Coulomb force",
        None,
        Bound::AtMost(1.0),
    );
    for (exponent, bound) in [
        (0.99, Bound::AtLeast(1.0)),
        (4.01, Bound::AtMost(4.0)),
        (f64::INFINITY, Bound::AtMost(4.0)),
        (f64::NAN, Bound::AtLeast(1.0)),
    ] {
        let sliding = Sliding {
            stribeck_exponent: exponent,
            ..SLIDING
        };
        refused(
            gms(&GOOD, 1.0, sliding, 1e-3),
            "Stribeck exponent",
            None,
            bound,
        );
    }
}

#[test]
fn units_that_are_not_positive_are_refused() {
    for bad in NOT_POSITIVE {
        refused(
            quasi_static::<f64>(&GOOD, units(bad, 1.0)),
            "unit of length",
            None,
            Bound::Positive,
        );
        refused(
            quasi_static::<f64>(&GOOD, units(1.0, bad)),
            "unit of force",
            None,
            Bound::Positive,
        );
        let velocity = Units {
            velocity: bad,
            ..Units::SI
        };
        refused(
            quasi_static::<f64>(&GOOD, velocity),
            "unit of velocity",
            None,
            Bound::Positive,
        );
    }
}

#[test]
fn values_too_large_for_the_number_type_are_refused() {
    let greatest = Bound::Representable(I16F16::MAX.to_num());
    // Yield displacements 0.25 and 0.5, in units of 10 µm: 25,000 and 50,000, doubled on a reversal.
    let error = quasi_static::<I16F16>(&GOOD, units(1e-5, 1.0));
    refused(error, "twice the yield displacement", Some(1), greatest);
    // Stiffness 2 and 1 in units of 1e5 and 5e4.
    let error = quasi_static::<I16F16>(&GOOD, units(1.0, 2e-5));
    refused(error, "stiffness", Some(1), greatest);
    // The sum of the blocks' forces, each of which fits.
    let error = quasi_static::<I8F24>(&GOOD, units(0.1, 1.0 / 128.0));
    refused(
        error,
        "breakaway force",
        None,
        Bound::Representable(I8F24::MAX.to_num()),
    );
    // f32 at its own end.
    let error = quasi_static::<f32>(&GOOD, units(1.0, 1e-39));
    refused(
        error,
        "stiffness",
        Some(1),
        Bound::Representable(f64::from(f32::MAX)),
    );
}

#[test]
fn values_that_round_to_zero_in_the_number_type_are_refused() {
    let error = quasi_static::<I16F16>(&GOOD, units(1e-3, 1e3));
    refused(error, "stiffness", Some(1), Bound::Resolvable);
    let error = quasi_static::<I16F16>(&GOOD, units(1e6, 1e6));
    refused(error, "yield displacement", Some(1), Bound::Resolvable);
    let error = quasi_static::<f32>(&GOOD, units(1e-30, 1e30));
    refused(error, "stiffness", Some(1), Bound::Resolvable);
    // Already zero in f64.
    let blocks = [
        Block {
            stiffness: 1e300,
            ..GOOD[0]
        },
        GOOD[1],
    ];
    let error = quasi_static::<f64>(&blocks, units(1e100, 1.0));
    refused(error, "yield displacement", Some(1), Bound::Resolvable);
}

#[test]
fn types_that_cannot_hold_a_model_are_refused() {
    let quarter = units(1.0, 4.0);
    for error in [
        Dahl::<I2F30>::try_new(0.5, 1.0, 1.0, quarter).err(),
        Dahl::<I1F31>::try_new(0.5, 1.0, 1.0, quarter).err(),
        Dahl::<I0F32>::try_new(0.25, 1.0, 1.0, quarter).err(),
    ] {
        assert_eq!(error.expect("refused").parameter, "u on a reversal");
    }
    let mild = Sliding {
        stribeck_velocity: 50.0,
        ..SLIDING
    };
    let error = Gms::<2, I4F28>::try_new(&GOOD, 1.0, mild, 1e-3, Units::SI).err();
    assert_eq!(
        error.expect("refused").parameter,
        "number of Stribeck table intervals"
    );
    assert!(Gms::<2, I8F24>::try_new(&GOOD, 1.0, mild, 1e-3, Units::SI).is_ok());
    // The quasi-static form needs no more than its own range.
    assert!(QuasiStaticGms::<2, I2F30>::try_new(&GOOD, 1.0, quarter).is_ok());
    assert!(QuasiStaticGms::<2, I0F32>::try_new(&GOOD, 1.0, units(4.0, 32.0)).is_ok());
    let error = QuasiStaticGms::<2, I30F2>::try_new(&GOOD, 1.0, units(1.0, 100.0)).err();
    refused(error, "stiffness", Some(1), Bound::Resolvable);
}

#[test]
fn dahl_refuses_each_bad_parameter() {
    let new = |stiffness, coulomb, exponent| {
        Dahl::<f64>::try_new(stiffness, coulomb, exponent, Units::SI).err()
    };
    for bad in NOT_POSITIVE {
        refused(new(bad, 1.0, 1.0), "stiffness", None, Bound::Positive);
        refused(new(1.0, bad, 1.0), "Coulomb force", None, Bound::Positive);
    }
    refused(new(1.0, 1.0, 0.05), "exponent n", None, Bound::AtLeast(0.1));
    refused(
        new(1.0, 1.0, f64::NAN),
        "exponent n",
        None,
        Bound::AtLeast(0.1),
    );
    refused(new(1.0, 1.0, 5.5), "exponent n", None, Bound::AtMost(5.0));
    refused(
        new(1e308, 1e-10, 1.0),
        "stiffness over Coulomb force",
        None,
        Bound::Representable(f64::MAX),
    );
}

#[test]
fn lugre_refuses_each_bad_parameter() {
    let new = |stiffness, damping, breakaway| {
        LuGre::<f64>::try_new(stiffness, damping, breakaway, SLIDING, Units::SI).err()
    };
    for bad in NOT_POSITIVE {
        refused(new(bad, 0.0, 1.0), "stiffness", None, Bound::Positive);
        refused(new(1.0, 0.0, bad), "breakaway force", None, Bound::Positive);
    }
    for bad in NEGATIVE {
        refused(new(1.0, bad, 1.0), "damping", None, Bound::NotNegative);
    }
    refused(
        new(1.0, 0.0, 0.4),
        "Coulomb force",
        None,
        Bound::AtMost(0.4),
    );
    // The product fits; that of the rounded stiffness and deflection, which is what runs, does not.
    let none = Sliding::none(32_767.99);
    let error = LuGre::<I16F16>::try_new(19_999.9, 0.0, 32_767.99, none, Units::SI).err();
    refused(
        error,
        "breakaway force",
        None,
        Bound::Representable(I16F16::MAX.to_num()),
    );
}

#[test]
fn coulomb_refuses_each_bad_parameter() {
    for bad in NEGATIVE {
        refused(
            Coulomb::<f64>::try_new(bad, 0.0, Units::SI).err(),
            "Coulomb force",
            None,
            Bound::NotNegative,
        );
        refused(
            Coulomb::<f64>::try_new(1.0, bad, Units::SI).err(),
            "viscous coefficient",
            None,
            Bound::NotNegative,
        );
    }
    let error = Coulomb::<I8F24>::try_new(200.0, 0.0, Units::SI).err();
    refused(
        error,
        "Coulomb force",
        None,
        Bound::Representable(I8F24::MAX.to_num()),
    );
}

#[test]
fn hsieh_refuses_each_bad_parameter() {
    let good = HsiehParams {
        k1: 51_540.0,
        k2: 2_026_400.0,
        beta: 3_216_500.0,
        viscous: 0.0,
        creep: 500.0,
        hardening: 31_200.0,
        hardening_exponent: 3.22,
    };
    let new = |params: HsiehParams, time| Hsieh::<f64>::try_new(&params, time, Units::SI).err();
    assert_eq!(new(good, 1e-3), None);
    for bad in NOT_POSITIVE {
        refused(
            new(HsiehParams { k1: bad, ..good }, 1e-3),
            "k1",
            None,
            Bound::Positive,
        );
        refused(
            new(HsiehParams { beta: bad, ..good }, 1e-3),
            "beta",
            None,
            Bound::Positive,
        );
        refused(
            new(
                HsiehParams {
                    hardening: bad,
                    ..good
                },
                1e-3,
            ),
            "hardening",
            None,
            Bound::Positive,
        );
        let exponent = HsiehParams {
            hardening_exponent: bad,
            ..good
        };
        refused(
            new(exponent, 1e-3),
            "hardening exponent",
            None,
            Bound::Positive,
        );
        refused(new(good, bad), "sample time", None, Bound::Positive);
    }
    for bad in NEGATIVE {
        refused(
            new(HsiehParams { k2: bad, ..good }, 1e-3),
            "k2",
            None,
            Bound::NotNegative,
        );
        refused(
            new(
                HsiehParams {
                    viscous: bad,
                    ..good
                },
                1e-3,
            ),
            "viscous coefficient",
            None,
            Bound::NotNegative,
        );
        refused(
            new(HsiehParams { creep: bad, ..good }, 1e-3),
            "creep rate",
            None,
            Bound::NotNegative,
        );
    }
    let error = new(
        HsiehParams {
            hardening_exponent: 21.0,
            ..good
        },
        1e-3,
    );
    refused(error, "hardening exponent", None, Bound::AtMost(20.0));
    let error = Hsieh::<I16F16>::try_new(&good, 1e-3, Units::SI).err();
    refused(
        error,
        "k1",
        None,
        Bound::Representable(I16F16::MAX.to_num()),
    );
}

#[test]
fn encoder_refuses_each_bad_parameter() {
    let new = |count, time, window, timeout| {
        EncoderScale::<f32>::try_new(count, time, window, timeout, Units::SI).err()
    };
    assert_eq!(new(25e-9, 50e-6, 1e-3, 2.0), None);
    for bad in NOT_POSITIVE {
        refused(
            new(bad, 50e-6, 1e-3, 2.0),
            "length of a count",
            None,
            Bound::Positive,
        );
        refused(
            new(25e-9, bad, 1e-3, 2.0),
            "sample time",
            None,
            Bound::Positive,
        );
        refused(
            new(25e-9, 50e-6, bad, 2.0),
            "velocity window",
            None,
            Bound::Positive,
        );
        refused(
            new(25e-9, 50e-6, 1e-3, bad),
            "velocity timeout",
            None,
            Bound::Positive,
        );
    }
    refused(
        new(25e-9, 50e-6, 1e-3, 5e-4),
        "velocity timeout",
        None,
        Bound::AtLeast(1e-3),
    );
    refused(
        new(1e30, 1e-30, 1e-3, 2.0),
        "count per tick",
        None,
        Bound::Representable(f64::from(f32::MAX)),
    );
    refused(
        new(1e-30, 1e30, 1e-3, 2.0),
        "count per tick",
        None,
        Bound::Resolvable,
    );
    let error = EncoderScale::<I16F16>::try_new(25e-9, 50e-6, 1e-3, 2.0, Units::SI).err();
    refused(error, "length of a count", None, Bound::Resolvable);
}
