//! Products of two words. A core whose multiplier gives the lower word only takes four products of halves for the upper one, which is
//! a third of what the compiler's routine for 64 bits takes there.

/// The upper word of a product, rounded down.
#[inline(always)]
pub(super) fn upper(a: i32, b: i32) -> i32 {
    if cfg!(short_products) {
        upper_of_halves(a, b)
    } else {
        ((i64::from(a) * i64::from(b)) >> 32) as i32
    }
}

/// Both words of a product.
#[inline(always)]
pub(super) fn whole(a: u32, b: u32) -> [u32; 2] {
    if cfg!(short_products) {
        // A factor with its sign bit set counts 2³² less as a signed one.
        let [a, b] = [a.cast_signed(), b.cast_signed()];
        let upper = upper_of_halves(a, b)
            .wrapping_add(b & (a >> 31))
            .wrapping_add(a & (b >> 31));
        [upper.cast_unsigned(), a.wrapping_mul(b).cast_unsigned()]
    } else {
        let product = u64::from(a) * u64::from(b);
        [(product >> 32) as u32, product as u32]
    }
}

#[inline(always)]
fn upper_of_halves(a: i32, b: i32) -> i32 {
    let low = |word: i32| word & 0xffff;
    let high = |word: i32| word >> 16;
    let lowest = low(a).cast_unsigned() * low(b).cast_unsigned();
    // Neither sum overflows: a product of a signed and an unsigned half leaves room for half a word.
    let middle = high(a) * low(b) + (lowest >> 16).cast_signed();
    let other = low(a) * high(b) + low(middle);
    high(a) * high(b) + high(middle) + high(other)
}

#[cfg(test)]
mod tests {
    use super::upper_of_halves;

    #[test]
    fn halves_give_the_upper_word_of_every_product() {
        let edges = [
            0,
            1,
            -1,
            2,
            0x7fff,
            -0x8000,
            0xffff,
            0x1_0000,
            -0x1_0000,
            i32::MAX,
            i32::MIN,
        ];
        let mut random = 0x1727_2018_u32;
        let mut any = || {
            for (left, shift) in [(true, 13), (false, 17), (true, 5)] {
                random ^= if left {
                    random << shift
                } else {
                    random >> shift
                };
            }
            random.cast_signed() >> (random % 32)
        };
        let pairs = edges.iter().flat_map(|a| edges.iter().map(|b| (*a, *b)));
        for (a, b) in pairs.chain(core::iter::repeat_with(|| (any(), any())).take(100_000)) {
            let upper = (i64::from(a) * i64::from(b)) >> 32;
            assert_eq!(i64::from(upper_of_halves(a, b)), upper, "{a} · {b}");
        }
    }
}
