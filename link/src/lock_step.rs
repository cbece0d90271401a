//! The lock step between an emulated board and the simulated stage: one exchange a tick, of fixed length.
//!
//! The command link's bytes travel in it, at most one a tick, so that a run depends on nothing but ticks.

/// From the board: what the bridge got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// PWM code.
    pub code: i16,
}

/// To the board: what its registers will show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Quadrature counter.
    pub count: u32,
    /// Supply (mV).
    pub supply: u16,
    /// Winding current (0.1 mA).
    pub current: i16,
    /// A byte on the command link.
    pub byte: Option<u8>,
    /// Fault injection: the control task dawdles for longer than a tick.
    pub dawdle: bool,
    /// Fault injection: the control task hangs.
    pub hang: bool,
    /// The run is over.
    pub quit: bool,
}

/// Something of fixed length on the wire, little endian.
pub trait Exchange<const LENGTH: usize>: Sized {
    /// As bytes.
    fn to_bytes(self) -> [u8; LENGTH];
    /// From bytes.
    fn from_bytes(bytes: [u8; LENGTH]) -> Self;
}

impl Exchange<2> for Order {
    fn to_bytes(self) -> [u8; 2] {
        self.code.to_le_bytes()
    }

    fn from_bytes(bytes: [u8; 2]) -> Self {
        Self {
            code: i16::from_le_bytes(bytes),
        }
    }
}

impl Exchange<10> for Reading {
    fn to_bytes(self) -> [u8; 10] {
        let [c0, c1, c2, c3] = self.count.to_le_bytes();
        let [s0, s1] = self.supply.to_le_bytes();
        let [i0, i1] = self.current.to_le_bytes();
        let flags = u8::from(self.byte.is_some())
            | u8::from(self.dawdle) << 1
            | u8::from(self.hang) << 2
            | u8::from(self.quit) << 3;
        [
            c0,
            c1,
            c2,
            c3,
            s0,
            s1,
            i0,
            i1,
            flags,
            self.byte.unwrap_or(0),
        ]
    }

    fn from_bytes([c0, c1, c2, c3, s0, s1, i0, i1, flags, byte]: [u8; 10]) -> Self {
        Self {
            count: u32::from_le_bytes([c0, c1, c2, c3]),
            supply: u16::from_le_bytes([s0, s1]),
            current: i16::from_le_bytes([i0, i1]),
            byte: (flags & 1 != 0).then_some(byte),
            dawdle: flags & 2 != 0,
            hang: flags & 4 != 0,
            quit: flags & 8 != 0,
        }
    }
}
