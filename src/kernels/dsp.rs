//! Instructions of the Cortex-M DSP extension, and the same in portable code: the bits are equal.
//!
//! This is the only module of the library that may hold `unsafe`; everywhere else the compiler refuses it.
//! `core::arch::arm` has these instructions as functions, but on nightly compilers only.
#![allow(unsafe_code)]

#[cfg(dsp_instructions)]
pub(super) use instructions::*;
#[cfg(not(dsp_instructions))]
pub(super) use portable::*;

/// Has the compiler work out `sum` here and not later, which costs no instruction. A core with eight registers would save what it waits for.
#[inline(always)]
pub(super) fn settled(sum: i32) -> i32 {
    #[cfg(short_products)]
    {
        let settled;
        // SAFETY: there is no instruction. It stands for one that touches memory, so that none of the next block's moves ahead of it.
        unsafe {
            core::arch::asm!("/* {} */", inlateout(reg) sum => settled, options(nostack, preserves_flags));
        }
        settled
    }
    #[cfg(not(short_products))]
    sum
}

/// Two blocks, the first in the low halves: `2·D` and `k`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C)]
pub(super) struct Pair {
    pub(super) full: u32,
    pub(super) stiffness: u32,
}

#[cfg(dsp_instructions)]
mod instructions {
    use super::Pair;
    use core::arch::asm;
    use core::sync::atomic::{Ordering, compiler_fence};

    /// `advance ∈ [0, 32768]` in both halves of a word. For the compiler it touches memory, so that nothing is loaded before it: a load
    /// that stands apart from the next one costs a cycle more.
    #[inline(always)]
    pub(in super::super) fn both(advance: i32) -> u32 {
        let both;
        // SAFETY: it touches no memory and changes no flag.
        unsafe {
            asm!(
                "orr {both}, {advance}, {advance}, lsl #16",
                advance = in(reg) advance, both = lateout(reg) both,
                options(nostack, preserves_flags)
            );
        }
        both
    }

    /// `w ← max(w − advance, 0)` in every half word; returns `start + Σ k·w`, which the caller has proved to fit.
    #[inline(always)]
    pub(in super::super) fn advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        advance: u32,
        start: i32,
    ) -> i32 {
        let mut sum = start;
        for (w, pair) in reserves.iter_mut().zip(pairs) {
            // It costs no instruction, and keeps the loads of all pairs from being gathered, which takes registers to be saved.
            compiler_fence(Ordering::SeqCst);
            // SAFETY: neither instruction touches memory. UQSUB16 changes no flag, SMLAD the Q flag on overflow only, which the
            // caller has excluded.
            unsafe {
                asm!(
                    "uqsub16 {w}, {w}, {advance}",
                    "smlad {sum}, {w}, {k}, {sum}",
                    w = inout(reg) *w, k = in(reg) pair.stiffness, advance = in(reg) advance, sum = inout(reg) sum,
                    options(pure, nomem, nostack, preserves_flags)
                );
            }
        }
        sum
    }
}

#[cfg(not(dsp_instructions))]
mod portable {
    use super::Pair;

    /// `advance ∈ [0, 32768]` in both halves of a word.
    #[inline(always)]
    pub(in super::super) fn both(advance: i32) -> u32 {
        let advance = advance.cast_unsigned();
        advance | advance << 16
    }

    /// `w ← max(w − advance, 0)` in every half word; returns `start + Σ k·w`, which the caller has proved to fit.
    #[inline(always)]
    pub(in super::super) fn advance<const PAIRS: usize>(
        reserves: &mut [u32; PAIRS],
        pairs: &[Pair; PAIRS],
        advance: u32,
        start: i32,
    ) -> i32 {
        let halves = |word: u32| [word as u16, (word >> 16) as u16];
        let mut sum = start;
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
}
