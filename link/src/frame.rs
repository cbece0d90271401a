//! Frames: postcard, CRC-16, COBS, a zero byte.

use crate::Refusal;
use crc::{CRC_16_IBM_3740, Crc};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Most bytes of a frame, its zero byte included.
pub const LARGEST_FRAME: usize = 64;

/// Payload and CRC; COBS adds one byte in 254 and the closing zero.
const LARGEST_BODY: usize = LARGEST_FRAME - 2;

const CHECK: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Why a frame could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than [`LARGEST_FRAME`].
    Oversized,
    /// Too short, or COBS's lengths do not fit.
    Malformed,
    /// The CRC differs.
    Checksum,
    /// No such message, or bytes left over behind it.
    Unknown,
}

impl From<FrameError> for Refusal {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::Oversized => Refusal::Oversized,
            FrameError::Malformed => Refusal::Malformed,
            FrameError::Checksum => Refusal::Checksum,
            FrameError::Unknown => Refusal::Unknown,
        }
    }
}

/// Writes `message` as a frame; how many bytes of `out` it takes, or `None` where it does not fit.
pub fn encode<T: Serialize>(message: &T, out: &mut [u8; LARGEST_FRAME]) -> Option<usize> {
    let mut body = [0; LARGEST_BODY];
    let payload = postcard::to_slice(message, body.get_mut(..LARGEST_BODY - 2)?)
        .ok()?
        .len();
    let check = CHECK.checksum(body.get(..payload)?).to_le_bytes();
    body.get_mut(payload..payload + 2)?.copy_from_slice(&check);
    let length =
        cobs::try_encode(body.get(..payload + 2)?, out.get_mut(..LARGEST_FRAME - 1)?).ok()?;
    *out.get_mut(length)? = 0;
    Some(length + 1)
}

/// Collects bytes into frames. Garbage costs the frame that it is in and nothing more.
#[derive(Clone, Debug)]
pub struct Deframer {
    bytes: [u8; LARGEST_FRAME],
    length: usize,
}

impl Default for Deframer {
    fn default() -> Self {
        Self::new()
    }
}

impl Deframer {
    /// Nothing received.
    pub const fn new() -> Self {
        Self {
            bytes: [0; LARGEST_FRAME],
            length: 0,
        }
    }

    /// Takes a byte; the message, or what was wrong with it, when it was a frame's last.
    ///
    /// An empty frame (two zeros in a row, as a sender may use to flush the line) is no error.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            // Counts on beyond the buffer, so that the frame's end knows.
            self.length = self.length.saturating_add(1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        (length > 0).then(|| self.read(length))
    }

    fn read<T: DeserializeOwned>(&mut self, length: usize) -> Result<T, FrameError> {
        let frame = self.bytes.get_mut(..length).ok_or(FrameError::Oversized)?;
        let length = cobs::decode_in_place(frame).map_err(|_| FrameError::Malformed)?;
        let body = frame.get(..length).ok_or(FrameError::Malformed)?;
        let (payload, check) = body.split_last_chunk::<2>().ok_or(FrameError::Malformed)?;
        if CHECK.checksum(payload) != u16::from_le_bytes(*check) {
            return Err(FrameError::Checksum);
        }
        match postcard::take_from_bytes(payload) {
            Ok((message, [])) => Ok(message),
            _ => Err(FrameError::Unknown),
        }
    }
}
