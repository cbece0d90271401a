//! MATLAB v5 `.mat` files: the numeric vectors of the file, by name.
//!
//! Level 5 format as MathWorks documents it ("MAT-File Format", R2019b): a 128-byte header, then
//! one element per variable, usually compressed with zlib. Read here rather than by a crate: of
//! those tried, `matfile` 0.5 takes a truncated file for a complete one with fewer variables and
//! `matrw` 0.1 panics; neither bounds what it inflates.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::LoadOptions;
use super::error::Problem;
use super::variables::Variable;

/// Whether the file says that it is a MATLAB file, of any version.
pub(super) fn is_mat(start: &[u8]) -> bool {
    start.starts_with(b"MATLAB ")
}

const HEADER_BYTES: usize = 128;
/// Array classes `mxDOUBLE_CLASS` to `mxUINT64_CLASS`.
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
const CLASSES: [&str; 6] = ["unknown", "cell", "struct", "object", "char", "sparse"];
const MI_INT32: u32 = 5;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

/// Bytes yet to be read, and where they stand in the file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Inside inflated data offsets mean nothing: errors name the compressed element instead.
    fixed: bool,
}

impl<'a> Cursor<'a> {
    fn error(&self, reason: impl std::fmt::Display) -> Problem {
        Problem::Other(format!("at byte {}: {reason}", self.at))
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], Problem> {
        let Some((head, tail)) = self.bytes.split_at_checked(n) else {
            return Err(self.error(format!(
                "{n} bytes announced, {} there: the file is truncated or corrupt; copy or export it again",
                self.bytes.len()
            )));
        };
        self.bytes = tail;
        if !self.fixed {
            self.at += n;
        }
        Ok(head)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], Problem> {
        let mut raw = [0; N];
        raw.copy_from_slice(self.take(N)?);
        if self.big_endian {
            raw.reverse();
        }
        Ok(raw)
    }

    fn u32(&mut self) -> Result<u32, Problem> {
        Ok(u32::from_le_bytes(self.number()?))
    }

    /// Type and payload of the next element; small elements share their tag's 8 bytes.
    fn element(&mut self) -> Result<(u32, Cursor<'a>), Problem> {
        let tag = self.u32()?;
        let (kind, size, padding) = if tag >> 16 != 0 {
            let size = (tag >> 16) as usize;
            if size > 4 {
                return Err(self.error(
                    "a small element of over 4 bytes: the file is corrupt; export it again",
                ));
            }
            (tag & 0xffff, size, 4 - size)
        } else {
            let size = self.u32()? as usize;
            // Only compressed elements are not padded to 8 bytes.
            (
                tag,
                size,
                if tag == MI_COMPRESSED {
                    0
                } else {
                    size.wrapping_neg() % 8
                },
            )
        };
        let at = self.at;
        let payload = self.take(size)?;
        // Some writers leave the padding off at the very end.
        let padding = padding.min(self.bytes.len());
        self.take(padding)?;
        Ok((
            kind,
            Cursor {
                bytes: payload,
                at,
                big_endian: self.big_endian,
                fixed: self.fixed,
            },
        ))
    }
}

/// Whether a file of that extension is one of MATLAB 4, whose first variable's type, sizes and name begin it.
fn is_v4(bytes: &[u8]) -> bool {
    let Some((words, _)) = bytes.as_chunks::<4>().0.split_at_checked(5) else {
        return false;
    };
    let words = |of: fn([u8; 4]) -> u32| words.iter().map(|w| of(*w)).collect::<Vec<_>>();
    [u32::from_le_bytes, u32::from_be_bytes]
        .into_iter()
        .any(|of| {
            let [kind, rows, columns, imaginary, name] = words(of)[..] else {
                return false;
            };
            // Thousands are the machine, tens the number's type, ones the matrix's.
            let is_kind =
                kind < 5000 && kind / 100 % 10 == 0 && kind / 10 % 10 < 6 && kind % 10 < 3;
            is_kind && imaginary < 2 && (2..64).contains(&name) && rows > 0 && columns > 0
        })
}

/// Every variable of the file.
pub(super) fn variables(bytes: &[u8], options: &LoadOptions) -> Result<Vec<Variable>, Problem> {
    if bytes.is_empty() {
        return Err(Problem::empty());
    }
    let mut cursor = Cursor {
        bytes,
        at: 0,
        big_endian: false,
        fixed: false,
    };
    if is_v4(bytes) {
        return Err(Problem::Other(
            "is a MATLAB v4 file; save it with `save(..., '-v7')` or export CSV".into(),
        ));
    }
    let header = cursor.take(HEADER_BYTES)?;
    cursor.big_endian = match header.get(126..) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => {
            cursor.at = 126;
            return Err(
                cursor.error("no MATLAB v5 header; save it with `save(..., '-v7')` or export CSV")
            );
        }
    };
    // What all elements together may inflate to: a corrupt or hostile file can announce terabytes.
    let mut budget = options.max_bytes;
    let mut found = Vec::new();
    while !cursor.bytes.is_empty() {
        let (kind, mut payload) = cursor.element()?;
        match kind {
            MI_MATRIX => found.push(variable(&mut payload, &mut budget)?),
            MI_COMPRESSED => {
                let inflated = inflate(&payload, &mut budget)?;
                let mut inner = Cursor {
                    bytes: &inflated,
                    fixed: true,
                    ..payload
                };
                let (kind, mut matrix) = inner.element()?;
                if kind != MI_MATRIX {
                    return Err(inner.error(format!(
                        "an element of type {kind} where a variable should be; export it again"
                    )));
                }
                found.push(variable(&mut matrix, &mut budget)?);
            }
            _ => {
                return Err(cursor.error(format!(
                    "an element of type {kind} where a variable should be; export it again"
                )));
            }
        }
    }
    Ok(found)
}

fn inflate(payload: &Cursor<'_>, budget: &mut u64) -> Result<Vec<u8>, Problem> {
    let mut inflated = Vec::new();
    let n = ZlibDecoder::new(payload.bytes)
        .take(budget.saturating_add(1))
        .read_to_end(&mut inflated)
        .map_err(|e| {
            payload.error(format!(
                "compressed data are corrupt or truncated ({e}); copy or export it again"
            ))
        })?;
    spend(payload, n, budget)?;
    Ok(inflated)
}

fn spend(at: &Cursor<'_>, bytes: usize, budget: &mut u64) -> Result<(), Problem> {
    *budget = budget.checked_sub(bytes as u64).ok_or_else(|| {
        at.error("the variables unpack to more than the size limit; export fewer of them")
    })?;
    Ok(())
}

/// One variable from the inside of its matrix element.
fn variable(matrix: &mut Cursor<'_>, budget: &mut u64) -> Result<Variable, Problem> {
    let (_, mut flags) = matrix.element()?;
    let word = flags.u32()?;
    let (class, complex) = (word & 0xff, word & 0x0800 != 0);
    if class == 17 || class == 16 {
        // Opaque objects and function handles have neither size nor name in the usual places.
        return Ok(Variable {
            name: String::new(),
            unit: None,
            dimensions: Vec::new(),
            values: Err("object"),
        });
    }
    let (kind, mut sizes) = matrix.element()?;
    if kind != MI_INT32 {
        return Err(sizes.error(
            "the sizes of a variable are not 32-bit integers: the file is corrupt; export it again",
        ));
    }
    let mut dimensions = Vec::new();
    while !sizes.bytes.is_empty() {
        dimensions.push(sizes.u32()? as usize);
    }
    let (_, name) = matrix.element()?;
    let name = String::from_utf8_lossy(name.bytes).into_owned();
    let values = if !NUMERIC.contains(&class) {
        Err(CLASSES.get(class as usize).copied().unwrap_or("unknown"))
    } else if complex {
        Err("complex")
    } else {
        let (kind, mut payload) = matrix.element()?;
        let values = numbers(kind, &mut payload, budget)?;
        let announced = dimensions.iter().try_fold(1usize, |n, &d| n.checked_mul(d));
        if announced != Some(values.len()) {
            return Err(payload.error(format!(
                "`{name}` holds {} numbers, which is not its size; export it again",
                values.len()
            )));
        }
        Ok(values)
    };
    Ok(Variable {
        name,
        unit: None,
        dimensions,
        values,
    })
}

/// Numbers as stored: MATLAB picks the smallest type that holds them, whatever their class.
fn numbers(kind: u32, payload: &mut Cursor<'_>, budget: &mut u64) -> Result<Vec<f64>, Problem> {
    type Read = fn(&mut Cursor<'_>) -> Result<f64, Problem>;
    let (bytes, read): (usize, Read) = match kind {
        1 => (1, |c| Ok(i8::from_le_bytes(c.number()?).into())),
        2 => (1, |c| Ok(u8::from_le_bytes(c.number()?).into())),
        3 => (2, |c| Ok(i16::from_le_bytes(c.number()?).into())),
        4 => (2, |c| Ok(u16::from_le_bytes(c.number()?).into())),
        5 => (4, |c| Ok(i32::from_le_bytes(c.number()?).into())),
        6 => (4, |c| Ok(u32::from_le_bytes(c.number()?).into())),
        7 => (4, |c| Ok(f32::from_le_bytes(c.number()?).into())),
        9 => (8, |c| Ok(f64::from_le_bytes(c.number()?))),
        12 => (8, |c| Ok(i64::from_le_bytes(c.number()?) as f64)),
        13 => (8, |c| Ok(u64::from_le_bytes(c.number()?) as f64)),
        _ => {
            return Err(payload.error(format!(
                "numbers of unknown type {kind}; export the file again"
            )));
        }
    };
    let count = payload.bytes.len() / bytes;
    spend(payload, count.saturating_mul(8), budget)?;
    let mut values = Vec::with_capacity(count);
    while !payload.bytes.is_empty() {
        values.push(read(payload)?);
    }
    Ok(values)
}

#[cfg(test)]
pub(super) mod tests;
