//! The registers of the mps2-an386 that are used: CMSDK timer, UARTs and watchdog (Arm DDI 0479, Cortex-M System
//! Design Kit; addresses from Arm application note 386).

#![allow(unsafe_code)]

/// Cycles of the peripheral clock per second.
pub const CLOCK_HZ: u32 = 25_000_000;

fn read(address: usize) -> u32 {
    // Safety: every caller is in this module and passes a register's address.
    unsafe { (address as *const u32).read_volatile() }
}

fn write(address: usize, value: u32) {
    // Safety: as above.
    unsafe { (address as *mut u32).write_volatile(value) }
}

/// Timer0: the control rate.
pub struct Timer;

impl Timer {
    const CONTROL: usize = 0x4000_0000;
    const VALUE: usize = 0x4000_0004;
    const RELOAD: usize = 0x4000_0008;
    const INTERRUPT: usize = 0x4000_000C;

    /// Sets the period in clock cycles and starts.
    pub fn start(cycles: u32) {
        write(Self::RELOAD, cycles - 1);
        write(Self::VALUE, cycles - 1);
        Self::run(true);
    }

    /// Lets the timer go on or stops it where it is; the interrupt stays enabled.
    pub fn run(on: bool) {
        write(Self::CONTROL, 0b1000 | u32::from(on));
    }

    /// It counts.
    pub fn is_running() -> bool {
        read(Self::CONTROL) & 1 != 0
    }

    /// Takes the interrupt back; whether it was there.
    pub fn acknowledge() -> bool {
        let pending = read(Self::INTERRUPT) & 1 != 0;
        write(Self::INTERRUPT, 1);
        pending
    }

    /// The next tick is due already.
    pub fn is_due() -> bool {
        read(Self::INTERRUPT) & 1 != 0
    }
}

/// A UART without interrupts.
pub struct Uart(usize);

impl Uart {
    /// Reports to the host.
    pub const LINK: Uart = Uart(0x4000_4000);
    /// Lock step with the stage.
    pub const STAGE: Uart = Uart(0x4000_5000);

    /// Enables both directions.
    pub fn start(&self) {
        // The emulation does not wait for bits; 16 is the smallest divider that it takes.
        write(self.0 + 0x10, 16);
        write(self.0 + 0x08, 0b11);
    }

    /// Waits until there is room.
    pub fn send(&self, byte: u8) {
        while read(self.0 + 4) & 1 != 0 {}
        write(self.0, byte.into());
    }

    /// A byte, if there is one.
    pub fn receive(&self) -> Option<u8> {
        (read(self.0 + 4) & 2 != 0).then(|| read(self.0) as u8)
    }
}

/// The watchdog: its first expiry is the non-maskable interrupt, its second a reset.
pub struct Watchdog;

impl Watchdog {
    const LOAD: usize = 0x4000_8000;
    const CONTROL: usize = 0x4000_8008;
    const CLEAR: usize = 0x4000_800C;
    const LOCK: usize = 0x4000_8C00;

    /// Starts with a time-out in clock cycles.
    pub fn start(cycles: u32) {
        write(Self::LOCK, 0x1ACC_E551);
        write(Self::LOAD, cycles);
        write(Self::CONTROL, 0b11);
    }

    /// Silences it.
    pub fn stop() {
        write(Self::CONTROL, 0);
    }

    /// The control task is alive.
    pub fn feed() {
        write(Self::CLEAR, 1);
    }
}

/// Most of the stack that was ever used (bytes): `cortex-m-rt` painted it before the start.
pub fn stack_high_water() -> usize {
    unsafe extern "C" {
        static mut _stack_start: u32;
        static mut _stack_end: u32;
    }
    let start = &raw const _stack_start as usize;
    let end = &raw const _stack_end as usize;
    let mut address = end;
    while address < start && read(address) == cortex_m_rt::STACK_PAINT_VALUE {
        address += 4;
    }
    start - address
}
