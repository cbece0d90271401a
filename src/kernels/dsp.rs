//! Instructions of the Cortex-M DSP extension, and the same in portable code: the bits are equal.
//!
//! This is the only module of the library that may hold `unsafe`; everywhere else the compiler refuses it.
//! `core::arch::arm` has these instructions as functions, but on nightly compilers only.
#![allow(unsafe_code)]

#[cfg(dsp_instructions)]
pub(super) use instructions::*;
#[cfg(not(dsp_instructions))]
pub(super) use portable::*;

/// Two blocks, the first in the low halves: `2·D` and `k`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(super) struct Pair {
    pub(super) full: u32,
    pub(super) stiffness: u32,
}

#[cfg(dsp_instructions)]
mod instructions {
    use super::Pair;
    use core::arch::asm;

    /// `w ← max(w − advance, 0)` in every half word; returns `Σ k·w`, which the caller has proved to fit.
    #[inline(always)]
    pub(in super::super) fn advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        advance: u32,
    ) -> i32 {
        let mut reserve = reserves.as_mut_ptr();
        let mut stiffness = pairs.as_ptr().cast::<u32>().wrapping_add(1);
        let mut sum = 0;
        for _ in 0..PAIRS {
            // SAFETY: the pointers stand on `reserves[i]` and on the stiffness of `pairs[i]`, `i < PAIRS`; no other
            // memory is touched and the stack is not used. UQSUB16 changes no flag, SMLAD the Q flag on overflow only,
            // which the caller has excluded.
            unsafe {
                asm!(
                    "ldr {w}, [{reserve}]",
                    "ldr {k}, [{stiffness}], #8",
                    "uqsub16 {w}, {w}, {advance}",
                    "str {w}, [{reserve}], #4",
                    "smlad {sum}, {w}, {k}, {sum}",
                    w = out(reg) _, k = out(reg) _, reserve = inout(reg) reserve, stiffness = inout(reg) stiffness,
                    advance = in(reg) advance, sum = inout(reg) sum,
                    options(nostack, preserves_flags)
                );
            }
        }
        sum
    }

    /// The same after `w ← w + turned·(2·D − 2·w)`, `turned` being 1 on a reversal and 0 otherwise: one path for both.
    #[inline(always)]
    pub(in super::super) fn turn_and_advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        turned: u32,
        advance: u32,
    ) -> i32 {
        let (mut reserve, mut pair) = (reserves.as_mut_ptr(), pairs.as_ptr());
        let mut sum = 0;
        for _ in 0..PAIRS {
            // SAFETY: the pointers stand on `reserves[i]` and `pairs[i]`, `i < PAIRS`; for the rest see `advance`. SUB and
            // MLA change no flag.
            unsafe {
                asm!(
                    "ldr {w}, [{reserve}]",
                    "ldr {t}, [{pair}], #4",
                    "ldr {k}, [{pair}], #4",
                    "sub {t}, {t}, {w}, lsl #1",
                    "mla {w}, {t}, {turned}, {w}",
                    "uqsub16 {w}, {w}, {advance}",
                    "str {w}, [{reserve}], #4",
                    "smlad {sum}, {w}, {k}, {sum}",
                    w = out(reg) _, t = out(reg) _, k = out(reg) _,
                    reserve = inout(reg) reserve, pair = inout(reg) pair,
                    turned = in(reg) turned, advance = in(reg) advance, sum = inout(reg) sum,
                    options(nostack, preserves_flags)
                );
            }
        }
        sum
    }
}

#[cfg(not(dsp_instructions))]
mod portable {
    use super::Pair;

    /// `w ← max(w − advance, 0)` in every half word; returns `Σ k·w`, which the caller has proved to fit.
    #[inline(always)]
    pub(in super::super) fn advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        advance: u32,
    ) -> i32 {
        let halves = |word: u32| [word as u16, (word >> 16) as u16];
        let mut sum = 0_i32;
        for (reserve, pair) in reserves.iter_mut().zip(pairs) {
            let ([low, high], [a, b]) = (halves(*reserve), halves(advance));
            let [low, high] = [low.saturating_sub(a), high.saturating_sub(b)];
            *reserve = u32::from(high) << 16 | u32::from(low);
            for (w, k) in [low, high].into_iter().zip(halves(pair.stiffness)) {
                sum = sum.wrapping_add(i32::from(w.cast_signed()) * i32::from(k.cast_signed()));
            }
        }
        sum
    }

    /// The same after `w ← w + turned·(2·D − 2·w)`, `turned` being 1 on a reversal and 0 otherwise.
    #[inline(always)]
    pub(in super::super) fn turn_and_advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        turned: u32,
        amount: u32,
    ) -> i32 {
        for (reserve, pair) in reserves.iter_mut().zip(pairs) {
            let turn = pair.full.wrapping_sub(reserve.wrapping_mul(2));
            *reserve = reserve.wrapping_add(turned.wrapping_mul(turn));
        }
        advance(reserves, pairs, amount)
    }
}
