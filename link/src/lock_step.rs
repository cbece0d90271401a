//! The lock step between an emulated board and the simulated stage: one exchange a tick, of fixed length.
//!
//! The command link's bytes travel in it, at most one a tick, so that a run depends on nothing but ticks.

/// From the board: what the bridge got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// PWM code.
    pub code: i16,
    /// The bridge is driven; where it is not, all its switches are open.
    pub driven: bool,
}

/// To the board: what its registers will show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Quadrature counter.
    pub count: u32,
    /// The counter where the index pulse came, if it came in the last tick.
    pub index: Option<u32>,
    /// Supply (mV).
    pub supply: u16,
    /// Winding current (0.1 mA).
    pub current: i16,
    /// A byte on the command link.
    pub byte: Option<u8>,
    /// Fault injection: nobody reads the line, whose transmitter stays full.
    pub unread: bool,
    /// Fault injection: the control task dawdles for longer than a tick.
    pub dawdle: bool,
    /// Fault injection: the control task hangs.
    pub hang: bool,
    /// Fault injection: the next run of the outer task takes longer than its sample.
    pub outlast: bool,
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

impl Exchange<3> for Order {
    fn to_bytes(self) -> [u8; 3] {
        let [low, high] = self.code.to_le_bytes();
        [low, high, u8::from(self.driven)]
    }

    fn from_bytes([low, high, driven]: [u8; 3]) -> Self {
        Self {
            code: i16::from_le_bytes([low, high]),
            driven: driven != 0,
        }
    }
}

impl Exchange<14> for Reading {
    fn to_bytes(self) -> [u8; 14] {
        let [c0, c1, c2, c3] = self.count.to_le_bytes();
        let [x0, x1, x2, x3] = self.index.unwrap_or(0).to_le_bytes();
        let [s0, s1] = self.supply.to_le_bytes();
        let [i0, i1] = self.current.to_le_bytes();
        let flags = u8::from(self.byte.is_some())
            | u8::from(self.dawdle) << 1
            | u8::from(self.hang) << 2
            | u8::from(self.quit) << 3
            | u8::from(self.index.is_some()) << 4
            | u8::from(self.unread) << 5
            | u8::from(self.outlast) << 6;
        let byte = self.byte.unwrap_or(0);
        [c0, c1, c2, c3, x0, x1, x2, x3, s0, s1, i0, i1, flags, byte]
    }

    fn from_bytes([c0, c1, c2, c3, x0, x1, x2, x3, s0, s1, i0, i1, flags, byte]: [u8; 14]) -> Self {
        Self {
            count: u32::from_le_bytes([c0, c1, c2, c3]),
            index: (flags & 16 != 0).then_some(u32::from_le_bytes([x0, x1, x2, x3])),
            supply: u16::from_le_bytes([s0, s1]),
            current: i16::from_le_bytes([i0, i1]),
            byte: (flags & 1 != 0).then_some(byte),
            unread: flags & 32 != 0,
            outlast: flags & 64 != 0,
            dawdle: flags & 2 != 0,
            hang: flags & 4 != 0,
            quit: flags & 8 != 0,
        }
    }
}
