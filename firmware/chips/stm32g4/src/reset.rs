//! What the board was reset by.

use embassy_stm32::pac;
use preslide_link::ResetCause;

/// Reads the flags and clears them for the next time. The chip has one flag for power that came on and power that sagged.
pub fn cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    if flags.borrstf() {
        ResetCause::Power
    } else if flags.iwdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else {
        ResetCause::Pin
    }
}
