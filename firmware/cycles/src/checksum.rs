//! One number for a series of forces, so that two processors can be compared.

/// FNV-1a over the forces' bits as `f64`, which holds every kernel's force exactly.
pub struct Checksum(u64);

impl Checksum {
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    // Once in the image and not once a kernel.
    #[inline(never)]
    pub fn add(&mut self, force: f64) {
        for byte in force.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// A force in whole numbers.
    pub fn add_whole(&mut self, force: i32) {
        self.0 = (self.0 ^ u64::from(force.cast_unsigned())).wrapping_mul(0x0100_0000_01b3);
    }

    pub fn value(&self) -> u64 {
        self.0
    }
}
