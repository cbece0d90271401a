//! Every bad parameter is refused by the error that names it.

use fixed::types::{I0F32, I1F31, I2F30, I4F28, I8F24, I16F16, I30F2};
use preslide::Bound::{self, AtLeast, AtMost, Positive, Representable, Resolvable};
use preslide::{
    Block, Coulomb, Dahl, EncoderScale, Gms, Hsieh, HsiehParams, LuGre, ParamError, QuasiStaticGms,
    Scalar, Sliding, Units,
};
use preslide_host_tests::refusal::{NEVER, not_negative, positive, refused, refused_in};
use preslide_host_tests::table3::hsieh;

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

#[test]
fn good_parameters_are_accepted() {
    assert_eq!(gms(&GOOD, 1.0, SLIDING, 1e-3), None);
    assert_eq!(gms(&GOOD, 1.0, Sliding::none(1.0), 1.0), None);
}

#[test]
fn a_block_that_is_not_finite_and_positive_is_refused_by_its_number() {
    for bad in NEVER.into_iter().chain([0.0]) {
        let mut blocks = GOOD;
        blocks[1].stiffness = bad;
        for error in [
            gms(&blocks, 1.0, SLIDING, 1e-3),
            quasi_static::<f32>(&blocks, Units::SI),
        ] {
            refused_in(Some(2), error, "stiffness", Positive);
        }
        let mut blocks = GOOD;
        blocks[0].weight = bad;
        let error = gms(&blocks, 1.0, SLIDING, 1e-3);
        refused_in(Some(1), error, "weight", Positive);
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
            refused(error, "sum of the weights", Bound::SumToOne);
        }
    }
}

#[test]
fn forces_times_and_sliding_out_of_range_are_refused() {
    let sliding = |sliding| gms(&GOOD, 1.0, sliding, 1e-3);
    positive("breakaway force", |bad| gms(&GOOD, bad, SLIDING, 1e-3));
    positive("sample time", |bad| gms(&GOOD, 1.0, SLIDING, bad));
    positive("Coulomb force", |coulomb| {
        sliding(Sliding { coulomb, ..SLIDING })
    });
    positive("Stribeck velocity", |stribeck_velocity| {
        sliding(Sliding {
            stribeck_velocity,
            ..SLIDING
        })
    });
    // An infinite one is a lag of none.
    for attraction in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        let error = sliding(Sliding {
            attraction,
            ..SLIDING
        });
        refused(error, "attraction parameter", Bound::NotNegative);
    }
    let error = gms(&GOOD, 1.0, SLIDING, 1.5);
    refused(error, "sample time", AtMost(1.0));
    let coulomb = 1.0 + 1e-12;
    let error = sliding(Sliding { coulomb, ..SLIDING });
    refused(error, "Coulomb force", AtMost(1.0));
    for (stribeck_exponent, bound) in [
        (0.99, AtLeast(1.0)),
        (4.01, AtMost(4.0)),
        (f64::INFINITY, AtMost(4.0)),
        (f64::NAN, AtLeast(1.0)),
    ] {
        let error = sliding(Sliding {
            stribeck_exponent,
            ..SLIDING
        });
        refused(error, "Stribeck exponent", bound);
    }
}

#[test]
fn units_that_are_not_positive_are_refused() {
    let of = |units| quasi_static::<f64>(&GOOD, units);
    positive("unit of length", |bad| of(units(bad, 1.0)));
    positive("unit of force", |bad| of(units(1.0, bad)));
    positive("unit of velocity", |velocity| {
        of(Units {
            velocity,
            ..Units::SI
        })
    });
}

#[test]
fn values_too_large_for_the_number_type_are_refused() {
    let greatest = Representable(I16F16::MAX.to_num());
    // Yield displacements 0.25 and 0.5, in units of 10 µm: 25,000 and 50,000, doubled on a reversal.
    let error = quasi_static::<I16F16>(&GOOD, units(1e-5, 1.0));
    refused_in(Some(1), error, "twice the yield displacement", greatest);
    // Stiffness 2 and 1 in units of 1e5 and 5e4.
    let error = quasi_static::<I16F16>(&GOOD, units(1.0, 2e-5));
    refused_in(Some(1), error, "stiffness", greatest);
    // The sum of the blocks' forces, each of which fits.
    let error = quasi_static::<I8F24>(&GOOD, units(0.1, 1.0 / 128.0));
    let greatest = Representable(I8F24::MAX.to_num());
    refused(error, "breakaway force", greatest);
    // f32 at its own end.
    let error = quasi_static::<f32>(&GOOD, units(1.0, 1e-39));
    let greatest = Representable(f64::from(f32::MAX));
    refused_in(Some(1), error, "stiffness", greatest);
}

#[test]
fn values_that_round_to_zero_in_the_number_type_are_refused() {
    let error = quasi_static::<I16F16>(&GOOD, units(1e-3, 1e3));
    refused_in(Some(1), error, "stiffness", Resolvable);
    let error = quasi_static::<I16F16>(&GOOD, units(1e6, 1e6));
    refused_in(Some(1), error, "yield displacement", Resolvable);
    let error = quasi_static::<f32>(&GOOD, units(1e-30, 1e30));
    refused_in(Some(1), error, "stiffness", Resolvable);
    // Already zero in f64.
    let blocks = [
        Block {
            stiffness: 1e300,
            ..GOOD[0]
        },
        GOOD[1],
    ];
    let error = quasi_static::<f64>(&blocks, units(1e100, 1.0));
    refused_in(Some(1), error, "yield displacement", Resolvable);
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
    refused_in(Some(1), error, "stiffness", Resolvable);
}

#[test]
fn dahl_refuses_each_bad_parameter() {
    let new = |stiffness, coulomb, exponent| {
        Dahl::<f64>::try_new(stiffness, coulomb, exponent, Units::SI).err()
    };
    positive("stiffness", |bad| new(bad, 1.0, 1.0));
    positive("Coulomb force", |bad| new(1.0, bad, 1.0));
    refused(new(1.0, 1.0, 0.05), "exponent n", AtLeast(0.1));
    refused(new(1.0, 1.0, f64::NAN), "exponent n", AtLeast(0.1));
    refused(new(1.0, 1.0, 5.5), "exponent n", AtMost(5.0));
    let steep = new(1e308, 1e-10, 1.0);
    refused(
        steep,
        "stiffness over Coulomb force",
        Representable(f64::MAX),
    );
}

#[test]
fn lugre_refuses_each_bad_parameter() {
    let new = |stiffness, damping, breakaway| {
        LuGre::<f64>::try_new(stiffness, damping, breakaway, SLIDING, Units::SI).err()
    };
    positive("stiffness", |bad| new(bad, 0.0, 1.0));
    positive("breakaway force", |bad| new(1.0, 0.0, bad));
    not_negative("damping", |bad| new(1.0, bad, 1.0));
    refused(new(1.0, 0.0, 0.4), "Coulomb force", AtMost(0.4));
    // The product fits; that of the rounded stiffness and deflection, which is what runs, does not.
    let none = Sliding::none(32_767.99);
    let error = LuGre::<I16F16>::try_new(19_999.9, 0.0, 32_767.99, none, Units::SI).err();
    let greatest = Representable(I16F16::MAX.to_num());
    refused(error, "breakaway force", greatest);
}

#[test]
fn coulomb_refuses_each_bad_parameter() {
    let new = |force, viscous| Coulomb::<f64>::try_new(force, viscous, Units::SI).err();
    not_negative("Coulomb force", |bad| new(bad, 0.0));
    not_negative("viscous coefficient", |bad| new(1.0, bad));
    let error = Coulomb::<I8F24>::try_new(200.0, 0.0, Units::SI).err();
    let greatest = Representable(I8F24::MAX.to_num());
    refused(error, "Coulomb force", greatest);
}

#[test]
fn hsieh_refuses_each_bad_parameter() {
    let good = hsieh(0.0, 500.0);
    let timed = |params, time| Hsieh::<f64>::try_new(&params, time, Units::SI).err();
    let new = |params| timed(params, 1e-3);
    assert_eq!(new(good), None);
    positive("k1", |k1| new(HsiehParams { k1, ..good }));
    positive("beta", |beta| new(HsiehParams { beta, ..good }));
    positive("hardening", |hardening| {
        new(HsiehParams { hardening, ..good })
    });
    let with_exponent = |hardening_exponent| {
        new(HsiehParams {
            hardening_exponent,
            ..good
        })
    };
    positive("hardening exponent", with_exponent);
    positive("sample time", |bad| timed(good, bad));
    not_negative("k2", |k2| new(HsiehParams { k2, ..good }));
    not_negative("viscous coefficient", |viscous| {
        new(HsiehParams { viscous, ..good })
    });
    not_negative("creep rate", |creep| new(HsiehParams { creep, ..good }));
    refused(with_exponent(21.0), "hardening exponent", AtMost(20.0));
    let error = Hsieh::<I16F16>::try_new(&good, 1e-3, Units::SI).err();
    refused(error, "k1", Representable(I16F16::MAX.to_num()));
}

#[test]
fn encoder_refuses_each_bad_parameter() {
    let new = |count, time, window, timeout| {
        EncoderScale::<f32>::try_new(count, time, window, timeout, Units::SI).err()
    };
    assert_eq!(new(25e-9, 50e-6, 1e-3, 2.0), None);
    positive("length of a count", |bad| new(bad, 50e-6, 1e-3, 2.0));
    positive("sample time", |bad| new(25e-9, bad, 1e-3, 2.0));
    positive("velocity window", |bad| new(25e-9, 50e-6, bad, 2.0));
    positive("velocity timeout", |bad| new(25e-9, 50e-6, 1e-3, bad));
    let short = new(25e-9, 50e-6, 1e-3, 5e-4);
    refused(short, "velocity timeout", AtLeast(1e-3));
    let long = new(1e30, 1e-30, 1e-3, 2.0);
    refused(long, "count per tick", Representable(f64::from(f32::MAX)));
    let fine = new(1e-30, 1e30, 1e-3, 2.0);
    refused(fine, "count per tick", Resolvable);
    let error = EncoderScale::<I16F16>::try_new(25e-9, 50e-6, 1e-3, 2.0, Units::SI).err();
    refused(error, "length of a count", Resolvable);
}
