//! The board's converter, and its codes as the control task reads them: supply in mV, current in 0.1 mA. What is beyond those ends at them.

/// Supply and current, converted at one phase of every PWM period; the end of that is the control task's interrupt. embedded-hal has no
/// such trait.
pub trait Sense {
    /// Takes the interrupt back.
    fn acknowledge(&mut self);

    /// Supply (mV) and winding current (0.1 mA), positive where a positive code drives it.
    fn read(&mut self) -> (u16, i16);

    /// The next tick is due already.
    fn is_due(&mut self) -> bool;
}

/// Codes of a converter of 12 bits.
const FULL: i64 = 4096;

/// The two scales of a board.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    supply_mv: i64,
    span: i64,
}

impl Scales {
    /// `supply_full` (V) is the supply at full scale, `current_span` (A) the current from end to end of the scale.
    pub const fn new(supply_full: f64, current_span: f64) -> Self {
        // `as` saturates.
        Self {
            supply_mv: (supply_full * 1e3 + 0.5) as u32 as i64,
            span: (current_span * 1e4 + 0.5) as u32 as i64,
        }
    }

    /// The supply (mV) of a code.
    #[inline]
    pub fn supply(&self, code: u16) -> u16 {
        let read = i64::from(code) * self.supply_mv / FULL;
        if read > 65_535 { u16::MAX } else { read as u16 }
    }

    /// The current (0.1 mA) of so many codes from where there is none.
    #[inline]
    pub fn current(&self, codes: i32) -> i16 {
        let read = i64::from(codes) * self.span / FULL;
        if read > 32_767 {
            i16::MAX
        } else if read < -32_768 {
            i16::MIN
        } else {
            read as i16
        }
    }
}
