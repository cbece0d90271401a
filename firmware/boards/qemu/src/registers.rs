//! The registers of the mps2-an386 that are used: CMSDK timer, UARTs and watchdog (Arm DDI 0479, Cortex-M System
//! Design Kit; addresses from Arm application note 386).

#![allow(unsafe_code)]

use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use cortex_m_semihosting::{nr, syscall};

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

/// A file of the host, through semihosting: one call moves a whole message, with the emulator standing still.
///
/// QEMU's UART instead holds a single byte, which one of its threads hands to another: ten times a tick, that took 0.5 ms
/// a tick where this takes 0.08 ms (measured on two busy cores), and the wait had to be hidden from timer and watchdog.
pub struct HostFile {
    name: &'static core::ffi::CStr,
    mode: usize,
    /// Its handle plus one; 0 until it is opened.
    handle: AtomicUsize,
}

impl HostFile {
    /// QEMU's standard input.
    pub const INPUT: &'static Self = &INPUT;
    /// QEMU's standard output.
    pub const OUTPUT: &'static Self = &OUTPUT;
    /// QEMU's standard error.
    #[cfg(feature = "log")]
    pub const ERROR: &'static Self = &ERROR;

    fn handle(&self) -> usize {
        let known = self.handle.load(Ordering::Relaxed);
        if known > 0 {
            return known - 1;
        }
        let name = self.name.to_bytes();
        // Safety: the operation reads three words: the name, which ends in a zero, the mode and the name's length.
        let handle = unsafe { syscall(nr::OPEN, &[name.as_ptr() as usize, self.mode, name.len()]) };
        self.handle.store(handle.wrapping_add(1), Ordering::Relaxed);
        handle
    }

    /// Writes all of it; a reader that is gone shows in the next [`read`](Self::read).
    pub fn write(&self, bytes: &[u8]) {
        // Safety: the operation reads `bytes`.
        unsafe {
            syscall(
                nr::WRITE,
                &[self.handle(), bytes.as_ptr() as usize, bytes.len()],
            )
        };
    }

    /// Waits until `bytes` is full; whether it is, rather than the file at its end.
    pub fn read(&self, bytes: &mut [u8]) -> bool {
        let mut rest = bytes;
        while !rest.is_empty() {
            // Safety: the operation writes to `rest` and nothing beyond.
            let missing = unsafe {
                syscall(
                    nr::READ,
                    &[self.handle(), rest.as_mut_ptr() as usize, rest.len()],
                )
            };
            let Some(got) = rest.len().checked_sub(missing).filter(|got| *got > 0) else {
                return false;
            };
            rest = rest.split_at_mut(got).1;
        }
        true
    }
}

static INPUT: HostFile = HostFile {
    name: c"/dev/stdin",
    mode: nr::open::R_BINARY,
    handle: AtomicUsize::new(0),
};

static OUTPUT: HostFile = HostFile {
    name: c"/dev/stdout",
    mode: nr::open::W_TRUNC_BINARY,
    handle: AtomicUsize::new(0),
};

#[cfg(feature = "log")]
static ERROR: HostFile = HostFile {
    name: c"/dev/stderr",
    mode: nr::open::W_TRUNC_BINARY,
    handle: AtomicUsize::new(0),
};

/// The UART of the command link.
pub struct Uart;

impl Uart {
    const DATA: usize = 0x4000_4000;
    const STATE: usize = 0x4000_4004;
    const CONTROL: usize = 0x4000_4008;
    const INTERRUPT: usize = 0x4000_400C;
    const DIVIDER: usize = 0x4000_4010;

    /// Enables it and both its interrupts.
    pub fn start() {
        // The emulation does not wait for bits; 16 is the smallest divider that it takes.
        write(Self::DIVIDER, 16);
        write(Self::CONTROL, 0b1111);
    }

    /// The byte that came, in the interrupt of one; to be called until there is none.
    pub fn receive() -> Option<u8> {
        write(Self::INTERRUPT, 0b10);
        (read(Self::STATE) & 0b10 != 0).then(|| read(Self::DATA) as u8)
    }

    /// Whether it takes a byte now.
    pub fn can_send() -> bool {
        write(Self::INTERRUPT, 0b01);
        !HELD.load(Ordering::Relaxed) && read(Self::STATE) & 0b01 == 0
    }

    /// Has it look full for as long as `held`, to be told once a tick; whether it has room again.
    pub fn hold(held: bool) -> bool {
        HELD.swap(held, Ordering::Relaxed) && !held
    }

    /// Sends a byte; its end is an interrupt.
    pub fn send(byte: u8) {
        write(Self::DATA, byte.into());
    }
}

static HELD: AtomicBool = AtomicBool::new(false);

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
