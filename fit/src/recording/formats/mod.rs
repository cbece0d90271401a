//! Files of other tools that hold columns by name, each read by a crate; large ones are cargo features.

#[cfg(feature = "db3")]
mod db3;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(feature = "mcap")]
mod mcap;
mod npy;
mod npz;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(any(feature = "mcap", feature = "db3"))]
mod ros;

use std::fs::File;
use std::path::Path;

use super::error::Problem;
use super::variables::Variable;

/// What a file is, by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Npz,
    Npy,
    Parquet,
    /// MATLAB v7.3 files are HDF5 files.
    Hdf5,
    Mcap,
    /// The SQLite files of ROS 2 bags.
    Db3,
    /// Known by name, and read by nothing here.
    Other,
}

/// First bytes, format, what it is called, the cargo feature that reads it, what to do where none does.
type Row = (
    &'static [u8],
    Format,
    &'static str,
    Option<&'static str>,
    &'static str,
);

#[rustfmt::skip]
const FORMATS: [Row; 25] = [
    (b"PK\x03\x04", Format::Npz, "an NPZ file", None, "give it as a file, for it cannot be read from a stream"),
    (b"\x93NUMPY", Format::Npy, "a single NumPy array, whose columns have no names", None, "write the columns by name: numpy.savez(\"rec.npz\", t_s=..., x_m=..., force_N=...)"),
    (b"PAR1", Format::Parquet, "a Parquet file", Some("parquet"), "pandas.read_parquet(...).to_csv(...)"),
    (b"\x89HDF\r\n\x1a\n", Format::Hdf5, "an HDF5 file", Some("hdf5"), "export its columns as CSV"),
    (b"MATLAB 7.3", Format::Hdf5, "a MATLAB v7.3 (HDF5) file", Some("hdf5"), "save(..., '-v7')"),
    (b"\x89MCAP", Format::Mcap, "an MCAP file", Some("mcap"), "export its columns as CSV"),
    (b"SQLite format 3\0", Format::Db3, "an SQLite file (of a ROS 2 bag?)", Some("db3"), "export its columns as CSV"),
    (b"TDSm", Format::Other, "a TDMS file", None, "convert it with Python's npTDMS: TdmsFile.read(...).as_dataframe().to_csv(...)"),
    (b"MDF     ", Format::Other, "an MDF file", None, "convert it with Python's asammdf: MDF(...).export(\"csv\", ...)"),
    (b"UnFinMF ", Format::Other, "an unfinished MDF file", None, "convert it with Python's asammdf: MDF(...).export(\"csv\", ...)"),
    (b"#ROSBAG V2.0", Format::Other, "a ROS 1 bag", None, "rosbags-convert makes an MCAP of it"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", Format::Other, "an Excel 97 workbook (.xls)", None, "open it and save the sheet as CSV"),
    (b"ULog\x01\x12\x35", Format::Other, "a ULog file of PX4", None, "pyulog's ulog2csv makes CSV of it"),
    (b"ARROW1", Format::Other, "an Arrow or Feather file", None, "pandas.read_feather(...).to_csv(...)"),
    (b"\x1f\x8b", Format::Other, "compressed with gzip", None, "unpack it: gunzip FILE"),
    (b"BZh", Format::Other, "compressed with bzip2", None, "unpack it: bunzip2 FILE"),
    (b"\xfd7zXZ\0", Format::Other, "compressed with xz", None, "unpack it: unxz FILE"),
    (b"\x28\xb5\x2f\xfd", Format::Other, "compressed with Zstandard", None, "unpack it: unzstd FILE"),
    (b"7z\xbc\xaf\x27\x1c", Format::Other, "a 7z archive", None, "unpack it: 7z x FILE"),
    (b"Rar!\x1a\x07", Format::Other, "a RAR archive", None, "unpack it"),
    (b"RIFF", Format::Other, "a WAV or AVI file", None, "export its samples as CSV"),
    (b"\x89PNG\r\n\x1a\n", Format::Other, "a PNG picture", None, "export the samples behind it as CSV"),
    (b"%PDF-", Format::Other, "a PDF", None, "export the samples behind it as CSV"),
    (b"\xff\xfe\0\0", Format::Other, "text in UTF-32", None, "save it as UTF-8"),
    (b"\x7fELF", Format::Other, "a program", None, "give the recording"),
];

/// Bytes that mark a format.
pub(super) const MAGIC_BYTES: u64 = 16;

/// The format of a file that starts so; `None` for text and what is not known.
pub(super) fn of(start: &[u8]) -> Option<Format> {
    let row = FORMATS.iter().find(|row| start.starts_with(row.0));
    row.map(|row| row.1)
}

/// A file to read, and the bytes that its numbers may take together.
#[allow(dead_code, reason = "which of them is needed depends on the features")]
pub(super) struct Input<'a> {
    pub(super) path: &'a Path,
    pub(super) file: File,
    pub(super) start: &'a [u8],
    pub(super) budget: u64,
}

#[cfg(any(feature = "hdf5", feature = "mcap"))]
impl Input<'_> {
    /// All bytes of the file.
    fn bytes(&mut self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut self.file, &mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

/// Every column or variable of the file.
///
/// # Errors
/// A format that this build does not read, with what would; a file that is damaged or too large.
pub(super) fn variables(format: Format, input: Input) -> Result<Vec<Variable>, Problem> {
    let found = match format {
        Format::Npz => npz::variables(input),
        #[cfg(feature = "parquet")]
        Format::Parquet => parquet::variables(input),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => hdf5::variables(input),
        #[cfg(feature = "mcap")]
        Format::Mcap => mcap::variables(input),
        #[cfg(feature = "db3")]
        Format::Db3 => db3::variables(input),
        _ => return Err(refusal(input.start)),
    };
    found.map_err(|reason| Problem::Other(format!("is {reason}")))
}

/// Why a file of that kind is not read, and what would be.
pub(super) fn refusal(start: &[u8]) -> Problem {
    let row = FORMATS.iter().find(|row| start.starts_with(row.0));
    let (what, remedy) = match row {
        Some((_, _, what, Some(feature), otherwise)) => (
            *what,
            format!(
                "to read it, build the tool with it (cargo build --release -p preslide-cli --features {feature}), or convert the file: {otherwise}"
            ),
        ),
        Some((_, _, what, None, otherwise)) => (*what, (*otherwise).to_owned()),
        None => ("a file of another kind", "export CSV".to_owned()),
    };
    Problem::Other(format!("is {what}; {remedy}"))
}

/// Takes `bytes` off what the numbers may take.
fn spend(budget: &mut u64, bytes: u64) -> Result<(), String> {
    *budget = budget.checked_sub(bytes).ok_or(
        "a file whose columns take more memory than the limit; write fewer of them, or split it",
    )?;
    Ok(())
}
