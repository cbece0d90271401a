//! Code in CCM SRAM, which has no wait states. `ccm.x` says what belongs there.

#![allow(unsafe_code)]

/// Copies the code from flash to where it runs. Nothing of `ccm.x` may be called before.
pub fn load() {
    unsafe extern "C" {
        static mut __ccm_start: u32;
        static __ccm_end: u32;
        static __ccm_load: u32;
    }
    let (start, end) = (&raw mut __ccm_start, &raw const __ccm_end);
    let words = (end as usize - start as usize) / 4;
    for word in 0..words {
        // Safety: the linker reserves both ranges, aligned to words, and they do not overlap. Volatile, because the
        // compiler would make this loop a call of `memcpy`, which is itself among what is copied.
        unsafe {
            let value = (&raw const __ccm_load).add(word).read_volatile();
            start.add(word).write_volatile(value);
        }
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
