//! Power is cut at every byte of a save, and at random: one record is always whole.

use crc::{CRC_32_ISO_HDLC, Crc};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use preslide_store::{LONGEST, Slots, StoreError};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PAGE: u32 = 2048;
const VERSION: u32 = 7;

/// Bytes of a double word, which has an ECC.
const WORD: usize = 8;

/// Flash in pages of 2 KiB that is written in double words, as the STM32G4's, and loses power after so many bytes of work.
struct Flash {
    bytes: Vec<u8>,
    /// Double words whose ECC finds two wrong bits: to read one is an error, as the board's driver tells it, until its page is erased.
    torn: Vec<bool>,
    /// Reads that met such a word.
    torn_reads: u32,
    /// Bytes until the power is cut; erasing and writing a byte both count.
    left: u64,
    /// What a byte holds that was being erased or written then.
    rng: ChaCha8Rng,
}

impl Flash {
    fn new(seed: u64) -> Self {
        Self {
            bytes: vec![0xFF; 2 * PAGE as usize],
            torn: vec![false; 2 * PAGE as usize / WORD],
            torn_reads: 0,
            left: u64::MAX,
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Changes a byte, unless the power is gone; in the moment it goes, the byte ends as anything, and its double word mostly as
    /// none that its ECC knows.
    fn change(&mut self, at: usize, value: u8) -> Result<(), NorFlashErrorKind> {
        match self.left {
            0 => return Err(NorFlashErrorKind::Other),
            1 => {
                self.bytes[at] = self.rng.random();
                self.torn[at / WORD] = self.rng.random_range(0..4) > 0;
            }
            _ => self.bytes[at] = value,
        }
        self.left -= 1;
        Ok(())
    }
}

impl ErrorType for &mut Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for &mut Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let from = offset as usize;
        // The bytes come all the same, whatever they are.
        into.copy_from_slice(&self.bytes[from..from + into.len()]);
        let words = from / WORD..(from + into.len()).div_ceil(WORD);
        if self.torn[words].contains(&true) {
            self.torn_reads += 1;
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for &mut Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        assert!(from.is_multiple_of(PAGE) && to.is_multiple_of(PAGE));
        // The pulse works on the whole page: what it is cut off from is nowhere as it was.
        let words = from as usize / WORD..to as usize / WORD;
        for word in words.clone().filter(|_| self.left > 0) {
            self.torn[word] = self.rng.random_range(0..4) == 0;
        }
        (from as usize..to as usize).try_for_each(|at| self.change(at, 0xFF))?;
        if self.left > 0 {
            self.torn[words].fill(false);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        assert!(bytes.len().is_multiple_of(8), "written in double words");
        for (at, byte) in (offset as usize..).zip(bytes) {
            assert!(
                self.left < 2 || self.bytes[at] == 0xFF,
                "written twice without an erase"
            );
            self.change(at, *byte)?;
        }
        Ok(())
    }
}

fn slots(flash: &mut Flash) -> Slots<&mut Flash> {
    Slots::new(flash, [0, PAGE], PAGE, VERSION).expect("two pages")
}

fn loaded(flash: &mut Flash) -> Option<Vec<u8>> {
    let mut record = [0; LONGEST];
    let length = slots(flash).load(&mut record)?;
    Some(record[..length].to_vec())
}

/// After a cut the record is the old or the new one, and the next save works.
fn survives(flash: &mut Flash, old: &Option<Vec<u8>>, new: &[u8], cut: u64) -> bool {
    flash.left = cut;
    let saved = slots(flash).save(new);
    let power_held = flash.left > 0;
    flash.left = u64::MAX;
    let found = loaded(flash);
    let is_new = found.as_deref() == Some(new);
    assert!(is_new || found == *old, "cut after {cut} bytes: {found:?}");
    assert!(
        !power_held || (saved.is_ok() && is_new),
        "no cut, but {saved:?}"
    );
    is_new
}

#[test]
fn power_cut_at_every_byte_leaves_a_whole_record() {
    let (old, new) = (vec![0xA5; 205], vec![0x3C; 199]);
    let mut kept = 0;
    // Both slots used before, one only, none.
    for saves in 0..3 {
        for cut in 0..u64::from(PAGE) + 240 {
            let mut flash = Flash::new(cut);
            for _ in 0..saves {
                slots(&mut flash).save(&old).expect("power is on");
            }
            let before = (saves > 0).then(|| old.clone());
            kept += u32::from(!survives(&mut flash, &before, &new, cut));
            slots(&mut flash).save(&new).expect("the next save works");
            assert_eq!(loaded(&mut flash).as_deref(), Some(&new[..]));
        }
    }
    println!("{kept} of {} cuts kept the old record", 3 * (PAGE + 240));
    assert!(kept > 3 * PAGE, "the cuts must reach into the saves");
}

#[test]
fn a_hundred_thousand_random_cuts_in_one_life() {
    const SEED: u64 = 15;
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut flash = Flash::new(SEED);
    let (mut record, mut new_ones) = (None, 0);
    for _ in 0..100_000 {
        let length = rng.random_range(0..=LONGEST);
        let next: Vec<u8> = (0..length).map(|_| rng.random()).collect();
        let cut = rng.random_range(0..u64::from(PAGE) + 520);
        if survives(&mut flash, &record, &next, cut) {
            record = Some(next);
            new_ones += 1;
        }
    }
    println!(
        "{new_ones} of 100000 saves were whole when the power went; {} reads met torn words",
        flash.torn_reads
    );
    assert!(new_ones > 5000 && flash.torn_reads > 50_000);
}

/// Flash that holds anything, most often with a header that is nearly one and a CRC that is right: what is read has the length told.
fn reads_anything(images: u64, seed: u64) {
    let check = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut flash, mut found) = (Flash::new(16), 0_u64);
    for _ in 0..images {
        for slot in [0, PAGE as usize] {
            let image = &mut flash.bytes[slot..slot + 512];
            rng.fill_bytes(image);
            let length = rng.random_range(0..LONGEST + 8);
            image[4..8]
                .copy_from_slice(&(VERSION + u32::from(rng.random_range(0..8) == 0)).to_le_bytes());
            image[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            let end = (12 + length.next_multiple_of(4)).min(508);
            let right = check.checksum(&image[..end]) ^ u32::from(rng.random_range(0..8) == 0);
            image[end..end + 4].copy_from_slice(&right.to_le_bytes());
        }
        let lengths = [8, PAGE as usize + 8]
            .map(|at| u32::from_le_bytes(flash.bytes[at..at + 4].try_into().expect("four")));
        if let Some(record) = loaded(&mut flash) {
            found += 1;
            assert!(record.len() <= LONGEST && lengths.contains(&(record.len() as u32)));
        }
    }
    println!("{found} records in {images} images");
    assert!(found > images / 2);
}

#[test]
fn a_hundred_thousand_images_are_read_without_harm() {
    reads_anything(100_000, 16);
}

/// As many of another seed with `INPUTS=100000000 SEED=7`.
#[test]
#[ignore = "long study: cargo xtask test --all"]
fn ten_million_images_are_read_without_harm() {
    let told = |name, usual| std::env::var(name).map_or(usual, |n| n.parse().expect("a number"));
    reads_anything(told("INPUTS", 10_000_000), told("SEED", 16));
}

#[test]
fn another_version_is_not_read_and_what_does_not_fit_is_refused() {
    let mut flash = Flash::new(1);
    slots(&mut flash).save(&[1, 2, 3]).expect("power is on");
    let mut record = [0; LONGEST];
    let mut other = Slots::new(&mut flash, [0, PAGE], PAGE, VERSION + 1).expect("two pages");
    assert_eq!(other.load(&mut record), None);
    assert_eq!(
        slots(&mut flash).save(&[0; LONGEST + 1]),
        Err(StoreError::TooLong)
    );
    assert_eq!(loaded(&mut flash), Some(vec![1, 2, 3]));
    slots(&mut flash).forget().expect("power is on");
    assert_eq!(loaded(&mut flash), None);
    assert!(Slots::new(&mut flash, [0, 1024], PAGE, VERSION).is_none());
    assert!(Slots::new(&mut flash, [PAGE, PAGE], PAGE, VERSION).is_none());
    assert!(Slots::new(&mut flash, [0, 2 * PAGE], PAGE, VERSION).is_none());
}
