//! Both kinds of numbers beside what they are to agree with.

use super::{Arithmetic, Scalar};
use fixed::types::{I0F32, I16F16, I32F0, I32F32, I40F24, I64F64};
use fixed::{FixedI32, types::extra::U16};

#[test]
fn the_whole_part_is_given_inside_the_range_only() {
    let floats = [
        (0.0, Some(0)),
        (63.99, Some(63)),
        (64.0, None),
        (-0.5, None),
    ];
    for (value, whole) in floats {
        assert_eq!((value as f32).whole_below(64), whole, "{value}");
        assert_eq!(value.whole_below(64), whole, "{value}");
        assert_eq!(I16F16::from_num(value).whole_below(64), whole, "{value}");
    }
    for value in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(value.whole_below(64), None);
    }
    assert_eq!(I0F32::from_num(0.25).whole_below(64), Some(0));
}

#[test]
fn a_direction_turns_the_sign_without_overflow() {
    assert_eq!(2.5_f32.along(-1.0), -2.5);
    assert_eq!(I16F16::MIN.along(-I16F16::ONE), I16F16::MAX);
    assert_eq!(I16F16::MIN.along(I16F16::ONE), I16F16::MIN);
}

#[test]
fn a_part_of_a_unit_gives_floats_the_same_bits() {
    for unit in [25e-9, 5.0e-7, 1.1, 3e8] {
        for value in [0, 1, -1, 65_537, -123_456_789, i32::MIN, i32::MAX] {
            let (narrow, wide) = (unit as f32, unit);
            assert_eq!(
                narrow.per_q16().of_q16(value),
                f32::from_q16(value) * narrow
            );
            assert_eq!(wide.per_q16().of_q16(value), f64::from_q16(value) * wide);
        }
    }
}

/// Every pair of a few hundred bit patterns: the ends, powers of two and their neighbours, and a scatter between.
#[test]
fn fixed_point_gives_the_bits_of_the_fixed_crate() {
    let mut scatter = 1_u64;
    let patterns: [i64; 256] = core::array::from_fn(|i| {
        scatter = scatter
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        match i {
            0..192 => (1_i64 << (i / 3)).wrapping_add(i as i64 % 3 - 1),
            _ => scatter.cast_signed() >> (scatter % 64),
        }
    });
    macro_rules! compare {
        ($($t:ty),+) => {$(
            for &a in &patterns {
                let x = <$t>::from_bits(a as _);
                // In a wider type, because `fixed` cannot round up what lies above its last whole number.
                let nearest = I64F64::from_num(x).saturating_round().saturating_to_num::<i32>();
                assert_eq!(x.round_to_int(), nearest, "{x:?}");
                let whole = a as i32;
                assert_eq!(<$t>::from_int(whole), <$t>::saturating_from_num(whole), "{whole}");
                let q16 = FixedI32::<U16>::from_bits(whole);
                assert_eq!(<$t>::from_q16(whole), <$t>::saturating_from_num(q16), "{q16}");
                let unit = <$t>::from_bits(0x5a5a);
                assert_eq!(unit.per_q16().of_q16(whole), <$t>::from_q16(whole).mul_input(unit), "{q16}");
                for &b in &patterns {
                    let y = <$t>::from_bits(b as _);
                    assert_eq!(x.mul_input(y), x.saturating_mul(y), "{x:?} {y:?}");
                }
            }
        )+};
    }
    compare!(I16F16, I0F32, I32F0, I32F32, I40F24);
}
