//! Instructions of the Cortex-M DSP extension, and the same in portable code: the bits are equal.
//!
//! This is the only module of the library that may hold `unsafe`; everywhere else the compiler refuses it.
//! `core::arch::arm` has these instructions as functions, but on nightly compilers only.
#![allow(unsafe_code)]

#[cfg(dsp_instructions)]
pub(super) use instructions::*;
#[cfg(not(dsp_instructions))]
pub(super) use portable::*;

#[cfg(dsp_instructions)]
mod instructions {
    use core::arch::asm;

    /// Both halfwords of `a` less those of `b`, unsigned, not below 0.
    #[inline(always)]
    pub(in super::super) fn subtract_to_zero(a: u32, b: u32) -> u32 {
        let difference;
        // SAFETY: register to register, no memory; UQSUB16 changes no flag (Armv7-M ARM, A7.7.216).
        unsafe {
            asm!("uqsub16 {d}, {a}, {b}", d = lateout(reg) difference, a = in(reg) a, b = in(reg) b,
                 options(pure, nomem, nostack, preserves_flags));
        }
        difference
    }

    /// `sum` plus the products of the halfwords of `a` and `b`, signed. The caller proves that it does not overflow.
    #[inline(always)]
    pub(in super::super) fn add_products(a: u32, b: u32, sum: i32) -> i32 {
        let result;
        // SAFETY: register to register, no memory; SMLAD sets the Q flag on overflow only, which is excluded.
        unsafe {
            asm!("smlad {r}, {a}, {b}, {s}", r = lateout(reg) result, a = in(reg) a, b = in(reg) b, s = in(reg) sum,
                 options(pure, nomem, nostack, preserves_flags));
        }
        result
    }

    /// `full·turned + reserve·sign`, wrapping, on a path that the compiler cannot make depend on the values.
    #[inline(always)]
    pub(in super::super) fn turn(full: u32, reserve: u32, turned: u32, sign: i32) -> u32 {
        let result;
        // SAFETY: register to register, no memory; MUL and MLA change no flag.
        unsafe {
            asm!("mul {t}, {f}, {r}", "mla {t}, {w}, {s}, {t}", t = out(reg) result,
                 f = in(reg) full, r = in(reg) turned, w = in(reg) reserve, s = in(reg) sign,
                 options(pure, nomem, nostack, preserves_flags));
        }
        result
    }
}

#[cfg(not(dsp_instructions))]
mod portable {
    /// Both halfwords of `a` less those of `b`, unsigned, not below 0.
    #[inline(always)]
    pub(in super::super) fn subtract_to_zero(a: u32, b: u32) -> u32 {
        let low = (a as u16).saturating_sub(b as u16);
        let high = ((a >> 16) as u16).saturating_sub((b >> 16) as u16);
        u32::from(high) << 16 | u32::from(low)
    }

    /// `sum` plus the products of the halfwords of `a` and `b`, signed. The caller proves that it does not overflow.
    #[inline(always)]
    pub(in super::super) fn add_products(a: u32, b: u32, sum: i32) -> i32 {
        let low = i32::from(a as u16 as i16) * i32::from(b as u16 as i16);
        let high = i32::from((a >> 16) as u16 as i16) * i32::from((b >> 16) as u16 as i16);
        sum.wrapping_add(low).wrapping_add(high)
    }

    /// `full·turned + reserve·sign`, wrapping.
    #[inline(always)]
    pub(in super::super) fn turn(full: u32, reserve: u32, turned: u32, sign: i32) -> u32 {
        full.wrapping_mul(turned)
            .wrapping_add(reserve.wrapping_mul(sign.cast_unsigned()))
    }
}
