//! Memory that lasts as long as the program.

use core::cell::UnsafeCell;

/// What one thread alone uses.
pub struct Alone<T>(UnsafeCell<T>);

// SAFETY: nothing here runs beside anything else.
unsafe impl<T> Sync for Alone<T> {}

impl<T> Alone<T> {
    pub const fn new(value: T) -> Self {
        Self(UnsafeCell::new(value))
    }

    /// # Safety
    /// No reference of an earlier call is in use.
    #[expect(clippy::mut_from_ref)]
    pub unsafe fn lend(&self) -> &mut T {
        // SAFETY: one thread, and no other reference.
        unsafe { &mut *self.0.get() }
    }
}
