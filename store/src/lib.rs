//! What a controller keeps over a reset: two slots of flash, one of them always whole.
//!
//! A save erases the slot that does not hold the newest record and writes there, its CRC last. Wherever the power is cut, the other
//! slot is untouched, so the next start finds the new record or the one before it.
#![no_std]

use crc::{CRC_32_ISO_HDLC, Crc};
use embedded_storage::nor_flash::NorFlash;

/// Longest record (bytes).
pub const LONGEST: usize = 488;

/// Number of the save, version of the record's layout, its length; then the record, filled up to words; then the CRC of all that.
const HEADER: usize = 12;
const TAIL: usize = 4;
const IMAGE: usize = 512;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Why nothing was saved; the record before it is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// The record is longer than [`LONGEST`].
    TooLong,
    /// Erasing, writing or reading failed, or what is read differs from what was written.
    Flash,
}

/// Two slots.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    offsets: [u32; 2],
    /// Bytes that are erased for a slot.
    length: u32,
    version: u32,
}

impl<F: NorFlash> Slots<F> {
    /// Slots of `length` bytes (a multiple of the pages that `flash` erases) at two offsets; only records of `version` are read.
    /// `None` where a record does not fit.
    pub fn new(flash: F, offsets: [u32; 2], length: u32, version: u32) -> Option<Self> {
        let whole = |offset: u32| (offset as usize).is_multiple_of(F::ERASE_SIZE);
        let fits = length as usize >= IMAGE
            && whole(length)
            && offsets.iter().all(|offset| whole(*offset))
            && offsets.iter().max()?.checked_add(length)? as usize <= flash.capacity()
            && offsets[0].abs_diff(offsets[1]) >= length
            && IMAGE.is_multiple_of(F::WRITE_SIZE);
        fits.then_some(Self {
            flash,
            offsets,
            length,
            version,
        })
    }

    /// The newest whole record; how many bytes of `into` it takes.
    pub fn load(&mut self, into: &mut [u8; LONGEST]) -> Option<usize> {
        let (slot, _) = self.newest()?;
        let mut image = [0; IMAGE];
        let (_, length) = self.read(slot, &mut image)?;
        let record = image.get(HEADER..HEADER + length)?;
        into.get_mut(..length)?.copy_from_slice(record);
        Some(length)
    }

    /// Saves a record. The one before it stays until this one is whole.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreError> {
        let newest = self.newest();
        let number = newest.map_or(1, |(_, number)| number.wrapping_add(1));
        let other = newest.map_or(0, |(slot, _)| 1 - slot);
        let mut image = [0xFF; IMAGE];
        let end = self
            .fill(&mut image, number, record)
            .ok_or(StoreError::TooLong)?;
        let written = end.next_multiple_of(F::WRITE_SIZE);
        let offset = self.offset(other);
        let flash = |_| StoreError::Flash;
        self.flash
            .erase(offset, offset + self.length)
            .map_err(flash)?;
        let image = image.get(..written).ok_or(StoreError::TooLong)?;
        self.flash.write(offset, image).map_err(flash)?;
        let mut back = [0; IMAGE];
        match self.read(other, &mut back) {
            Some((found, _)) if found == number && back.get(..end) == image.get(..end) => Ok(()),
            _ => Err(StoreError::Flash),
        }
    }

    /// Forgets all records, the older one first.
    ///
    /// # Errors
    /// [`StoreError::Flash`].
    pub fn forget(&mut self) -> Result<(), StoreError> {
        let newest = self.newest().map_or(0, |(slot, _)| slot);
        for slot in [1 - newest, newest] {
            let offset = self.offset(slot);
            let erased = self.flash.erase(offset, offset + self.length);
            erased.map_err(|_| StoreError::Flash)?;
        }
        Ok(())
    }

    /// The flash.
    pub fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    fn offset(&self, slot: usize) -> u32 {
        if slot == 0 {
            self.offsets[0]
        } else {
            self.offsets[1]
        }
    }

    /// The slot with the newest whole record, and its number.
    fn newest(&mut self) -> Option<(usize, u32)> {
        let mut image = [0; IMAGE];
        let mut number = |slot| Some((slot, self.read(slot, &mut image)?.0));
        match (number(0), number(1)) {
            // Numbers wrap; flash wears out long before.
            (Some(a), Some(b)) if a.1.wrapping_sub(b.1).cast_signed() > 0 => Some(a),
            (Some(a), None) => Some(a),
            (_, b) => b,
        }
    }

    /// Number and length of the slot's record, where it is whole.
    fn read(&mut self, slot: usize, image: &mut [u8; IMAGE]) -> Option<(u32, usize)> {
        let offset = self.offset(slot);
        self.flash.read(offset, image).ok()?;
        let word = |at: usize| {
            let bytes = image.get(at..at.checked_add(4)?)?.first_chunk::<4>()?;
            Some(u32::from_le_bytes(*bytes))
        };
        let length = word(8)? as usize;
        if word(4)? != self.version || length > LONGEST {
            return None;
        }
        let end = HEADER + length.next_multiple_of(4);
        let check = CHECK.checksum(image.get(..end)?);
        (word(end)? == check).then_some((word(0)?, length))
    }

    /// The image of a record; where it ends.
    fn fill(&self, image: &mut [u8; IMAGE], number: u32, record: &[u8]) -> Option<usize> {
        if record.len() > LONGEST {
            return None;
        }
        let header = [number, self.version, record.len() as u32];
        for (place, word) in image.chunks_exact_mut(4).zip(header) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        image
            .get_mut(HEADER..HEADER + record.len())?
            .copy_from_slice(record);
        let end = HEADER + record.len().next_multiple_of(4);
        let check = CHECK.checksum(image.get(..end)?).to_le_bytes();
        image.get_mut(end..end + TAIL)?.copy_from_slice(&check);
        Some(end + TAIL)
    }
}
