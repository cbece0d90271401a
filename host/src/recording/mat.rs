//! MATLAB v5 `.mat` files: the numeric vectors of the file, by name.
//!
//! Level 5 format as MathWorks documents it ("MAT-File Format", R2019b): a 128-byte header, then
//! one element per variable, usually compressed with zlib. Read here rather than by a crate: of
//! those tried, `matfile` 0.5 takes a truncated file for a complete one with fewer variables and
//! `matrw` 0.1 panics; neither bounds what it inflates.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::LoadOptions;
use super::columns;
use super::error::Problem;
use super::extra::Reading;
use super::labels::Labels;
use super::table::{Data, Place, Table};

/// Bytes that [`is_mat`] looks at.
pub(super) const MAGIC_BYTES: u64 = 10;

/// Whether the file says that it is a MATLAB file, of any version.
pub(super) fn is_mat(start: &[u8]) -> bool {
    start.starts_with(b"MATLAB ") || start.starts_with(HDF5)
}

const HDF5: &[u8] = b"\x89HDF";
const HEADER_BYTES: usize = 128;
/// Array classes `mxDOUBLE_CLASS` to `mxUINT64_CLASS`.
const NUMERIC: std::ops::RangeInclusive<u32> = 6..=15;
const CLASSES: [&str; 6] = ["unknown", "cell", "struct", "object", "char", "sparse"];
const MI_INT32: u32 = 5;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

/// A variable of the file.
#[derive(Debug)]
struct Variable {
    name: String,
    dimensions: Vec<usize>,
    /// Real numbers in column-major order, or why there are none.
    values: Result<Vec<f64>, &'static str>,
}

impl Variable {
    /// "qm 24841×1", for messages.
    fn describe(&self) -> String {
        let size: Vec<String> = self.dimensions.iter().map(usize::to_string).collect();
        let class = self
            .values
            .as_ref()
            .err()
            .map(|c| format!(" {c}"))
            .unwrap_or_default();
        format!("{} {}{class}", self.name, size.join("×"))
    }

    /// The numbers of a row or column vector.
    fn vector(&self) -> Option<&[f64]> {
        let long = self.dimensions.iter().filter(|&&d| d != 1).count();
        self.values.as_deref().ok().filter(|_| long <= 1)
    }
}

/// Reads the variables that `--map` and the column names ask for.
pub(super) fn read(bytes: &[u8], options: &LoadOptions) -> Result<Table, Problem> {
    let variables = variables(bytes, options)?;
    let listing = variables
        .iter()
        .map(Variable::describe)
        .collect::<Vec<_>>()
        .join(", ");
    let names: Vec<String> = variables.iter().map(|v| v.name.clone()).collect();
    let plan = columns::plan(&columns::Names {
        columns: &names,
        units: &[],
        listing: &format!("the variables {listing}"),
        map: &options.map,
        ignore: &options.ignore,
        needs: options.needs,
    })?;
    let mut data = Vec::new();
    let mut length: Option<(String, usize)> = None;
    for source in &plan.sources {
        let mut product: Option<(&str, Vec<f64>)> = None;
        let mut factor = source.factor;
        for variable in source.columns.iter().filter_map(|&i| variables.get(i)) {
            let values = variable.vector().ok_or_else(|| Problem::Map {
                map: format!("{}={}", source.known.name, variable.name),
                reason: format!(
                    "`{}` is no vector of real numbers; the file has {listing}",
                    variable.describe()
                ),
            })?;
            match (&mut product, values) {
                (_, [scalar]) => factor *= scalar,
                (None, values) => product = Some((&variable.name, values.to_vec())),
                (Some((first, product)), values) => {
                    same_length(first, product.len(), &variable.name, values.len())?;
                    product.iter_mut().zip(values).for_each(|(p, v)| *p *= v);
                }
            }
        }
        let (name, mut values) = product.unwrap_or((source.known.name, vec![1.0]));
        values
            .iter_mut()
            .for_each(|v| *v = *v * factor + source.offset + 0.0);
        if let Some(at) = values.iter().position(|&v| columns::plausible(v).is_err()) {
            return Err(Problem::Cell {
                at: Place::Elements.of(at),
                column: name.into(),
                what: format!(
                    "`{}` is not finite, or beyond what any sensor gives",
                    values.get(at).copied().unwrap_or(f64::NAN)
                ),
            });
        }
        match &length {
            None => length = Some((name.into(), values.len())),
            Some((first, n)) => same_length(first, *n, name, values.len())?,
        }
        if values.len() > options.max_samples {
            return Err(Problem::TooManySamples {
                at: format!("variable `{name}`"),
                limit: options.max_samples,
            });
        }
        data.push(if source.known.slot.is_label() {
            let mut labels = Labels::default();
            if !values.iter().all(|v| labels.push(&v.to_string())) {
                return Err(Problem::Cell {
                    at: "its elements".into(),
                    column: name.into(),
                    what: "over a million different parts".into(),
                });
            }
            Data::Labels(labels)
        } else {
            Data::Numbers(values)
        });
    }
    let extra = further(&variables, &plan.unused);
    Ok(Table {
        plan,
        data,
        extra,
        place: Place::Elements,
        first_change: Vec::new(),
    })
}

/// The variables that have no role.
fn further(variables: &[Variable], unused: &[usize]) -> Vec<Reading> {
    let reading = |variable: &Variable| {
        let mut reading = Reading::new(&variable.name);
        match variable.vector() {
            Some(values) if values.iter().all(|v| v.is_finite()) => {
                reading.values = values.to_vec()
            }
            Some(_) => reading.refuse("holds numbers that are not finite".to_owned()),
            None => reading.refuse("no vector of real numbers".to_owned()),
        }
        reading
    };
    unused
        .iter()
        .filter_map(|&i| variables.get(i))
        .map(reading)
        .collect()
}

fn same_length(
    first: &str,
    first_len: usize,
    second: &str,
    second_len: usize,
) -> Result<(), Problem> {
    if first_len == second_len {
        return Ok(());
    }
    Err(Problem::Lengths {
        first: first.into(),
        first_len,
        second: second.into(),
        second_len,
    })
}

/// Bytes yet to be read, and where they stand in the file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Inside inflated data offsets mean nothing: errors name the compressed element instead.
    fixed: bool,
}

impl<'a> Cursor<'a> {
    fn error(&self, reason: impl Into<String>) -> Problem {
        Problem::Mat {
            offset: self.at,
            reason: reason.into(),
        }
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

fn variables(bytes: &[u8], options: &LoadOptions) -> Result<Vec<Variable>, Problem> {
    if bytes.is_empty() {
        return Err(Problem::Empty);
    }
    let mut cursor = Cursor {
        bytes,
        at: 0,
        big_endian: false,
        fixed: false,
    };
    if bytes.starts_with(HDF5) || bytes.starts_with(b"MATLAB 7.3") {
        return Err(
            cursor.error("a MATLAB v7.3 (HDF5) file; save it again with `save(..., '-v7')`")
        );
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
mod tests;
