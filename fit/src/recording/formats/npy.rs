//! One array as NumPy writes it (the NPY format, versions 1 to 3): magic, version, length, a Python dictionary of three keys, numbers.
//!
//! By hand, because the crate for it (npyz) brings a grammar of Python and integers of any length along, sixteen crates for that one
//! line of text: 18 of the 346 CPU seconds that the program took from nothing.

use std::io::{BufReader, Read};

use super::spend;

/// The longest dictionary that is read. NumPy's own reader stops at 10 000; only records of thousands of fields need more.
const MOST_HEADER_BYTES: u32 = 1 << 20;

pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    /// Whether the first index is the fastest.
    pub(super) is_fortran: bool,
    /// Real numbers in the file's order, or what they are instead.
    pub(super) values: Result<Vec<f64>, &'static str>,
}

/// Reads an array, whose numbers are taken off `budget` (bytes).
pub(super) fn read(reader: impl Read, budget: &mut u64) -> Result<Array, String> {
    let mut reader = BufReader::new(reader);
    let header = header(&mut reader)?;
    let entries = entries(&header).ok_or("its header is not a Python dictionary")?;
    let entry = |key: &str| {
        let found = entries.iter().find(|(name, _)| *name == key);
        found
            .map(|(_, value)| *value)
            .ok_or(format!("its header lacks `{key}`"))
    };
    let is_fortran = match entry("fortran_order")? {
        "True" => true,
        "False" => false,
        other => {
            return Err(format!(
                "its `fortran_order` is `{other}`, not True or False"
            ));
        }
    };
    let shape = entry("shape")?;
    let shape = lengths(shape).ok_or_else(|| format!("its `shape` is `{shape}`, no lengths"))?;
    let kind = Kind::of(entry("descr")?);

    let count = shape.iter().try_fold(1u64, |n, &d| n.checked_mul(d as u64));
    let bytes = count.and_then(|n| n.checked_mul(8)).unwrap_or(u64::MAX);
    spend(budget, bytes)?;
    let values = match (kind, count) {
        (Some(kind), Some(count)) => Ok(kind.numbers(&mut reader, count).map_err(broken)?),
        _ => Err("no real numbers"),
    };
    Ok(Array {
        shape,
        is_fortran,
        values,
    })
}

fn broken(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => "it ends too early".to_owned(),
        _ => error.to_string(),
    }
}

/// The dictionary as text.
fn header(reader: &mut impl Read) -> Result<String, String> {
    let mut start = [0; 8];
    reader.read_exact(&mut start).map_err(broken)?;
    let [magic @ .., major, minor] = start;
    if magic != *b"\x93NUMPY" {
        return Err("it does not start as NumPy's arrays do".to_owned());
    }
    let mut length = [0; 4];
    match (major, minor) {
        (1, 0) => reader.read_exact(&mut length[..2]),
        (2 | 3, 0) => reader.read_exact(&mut length),
        _ => {
            return Err(format!(
                "it has version {major}.{minor}, and 1.0 to 3.0 are read"
            ));
        }
    }
    .map_err(broken)?;
    let length = u32::from_le_bytes(length);
    if length > MOST_HEADER_BYTES {
        return Err(format!(
            "its header takes {length} bytes, more than {MOST_HEADER_BYTES}"
        ));
    }
    let mut text = vec![0; length as usize];
    reader.read_exact(&mut text).map_err(broken)?;
    // Versions 1 and 2 are Latin-1, where all that is read here is ASCII.
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// Keys and values of a dictionary whose keys are text, the values as they are written; `None` where it is none.
fn entries(dictionary: &str) -> Option<Vec<(&str, &str)>> {
    let inside = dictionary.trim().strip_prefix('{')?.strip_suffix('}')?;
    let pairs = split(inside, ',').into_iter().map(str::trim);
    pairs
        .filter(|pair| !pair.is_empty())
        .map(|pair| match split(pair, ':')[..] {
            [key, value] => Some((quoted(key)?, value.trim())),
            _ => None,
        })
        .collect()
}

/// Splits where `mark` stands in no bracket and no quotation.
fn split(text: &str, mark: char) -> Vec<&str> {
    let (mut parts, mut from, mut depth) = (Vec::new(), 0, 0u32);
    let mut quote = None;
    let mut characters = text.char_indices();
    while let Some((at, c)) = characters.next() {
        match (quote, c) {
            (Some(_), '\\') => {
                // What it stands before closes nothing.
                characters.next();
            }
            (Some(open), _) => quote = quote.filter(|_| c != open),
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
            (None, _) if c == mark && depth == 0 => {
                parts.push(&text[from..at]);
                from = at + c.len_utf8();
            }
            (None, _) => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

/// What stands between quotation marks.
fn quoted(text: &str) -> Option<&str> {
    let text = text.trim();
    ['\'', '"']
        .into_iter()
        .find_map(|quote| text.strip_prefix(quote)?.strip_suffix(quote))
}

/// The lengths of a tuple or list.
fn lengths(text: &str) -> Option<Vec<usize>> {
    let tuple = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    let list = || text.strip_prefix('[')?.strip_suffix(']');
    let numbers = tuple.or_else(list)?.split(',').map(str::trim);
    // Python 2 wrote long integers as 5L.
    numbers
        .filter(|number| !number.is_empty())
        .map(|number| number.trim_end_matches('L').parse().ok())
        .collect()
}

/// How a real number is stored.
#[derive(Clone, Copy)]
struct Kind {
    /// NumPy's letter for it: `f` float, `i` signed, `u` unsigned, `b` true or false, `m` and `M` counted time.
    letter: u8,
    bytes: usize,
    is_big_endian: bool,
}

impl Kind {
    /// Of `'<f8'` and the like; `None` for text, complex numbers, objects and records.
    fn of(descr: &str) -> Option<Self> {
        let descr = quoted(descr)?;
        // '<M8[ns]' counts nanoseconds.
        let plain = descr.split('[').next()?;
        let &[order, letter, size] = plain.as_bytes() else {
            return None;
        };
        let bytes = usize::from(size.checked_sub(b'0')?);
        let is_known = match letter {
            b'f' => matches!(bytes, 4 | 8),
            b'i' | b'u' => matches!(bytes, 1 | 2 | 4 | 8),
            b'm' | b'M' => bytes == 8,
            b'b' => bytes == 1,
            _ => false,
        };
        is_known.then_some(Self {
            letter,
            bytes,
            is_big_endian: order == b'>',
        })
    }

    /// The number whose bytes stand at the start of `item`, with zeros behind.
    fn number(self, mut item: [u8; 8]) -> f64 {
        if self.is_big_endian {
            item[..self.bytes].reverse();
        }
        let bits = u64::from_le_bytes(item);
        match (self.letter, self.bytes) {
            (b'f', 4) => f64::from(f32::from_bits(bits as u32)),
            (b'f', _) => f64::from_bits(bits),
            (b'u' | b'b', _) => bits as f64,
            _ => {
                // The sign goes up to the top bit and back.
                let unused = 64 - 8 * self.bytes;
                ((bits << unused) as i64 >> unused) as f64
            }
        }
    }

    /// The next `count` numbers; grows as they come, since a damaged header may promise any number of them.
    fn numbers(self, reader: &mut impl Read, count: u64) -> std::io::Result<Vec<f64>> {
        let numbers = (0..count).map(|_| {
            let mut item = [0; 8];
            reader.read_exact(&mut item[..self.bytes])?;
            Ok(self.number(item))
        });
        let numbers = numbers.collect::<std::io::Result<_>>()?;
        // At the end of its entry the archive compares the checksum.
        let _ = reader.read(&mut [0])?;
        Ok(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An array of a version, whose header is padded to 64 bytes as NumPy does.
    fn file(version: u8, dictionary: &str, data: &[u8]) -> Vec<u8> {
        let length_bytes = if version == 1 { 2 } else { 4 };
        let mut text = dictionary.to_owned();
        while !(8 + length_bytes + text.len() + 1).is_multiple_of(64) {
            text.push(' ');
        }
        text.push('\n');
        let length = (text.len() as u32).to_le_bytes();
        let parts: [&[u8]; 5] = [
            b"\x93NUMPY",
            &[version, 0],
            &length[..length_bytes],
            text.as_bytes(),
            data,
        ];
        parts.concat()
    }

    fn of(descr: &str, data: &[u8]) -> Result<Array, String> {
        let count = data.len() / descr[3..4].parse::<usize>().expect("a size");
        let dictionary =
            format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({count},), }}");
        read(file(1, &dictionary, data).as_slice(), &mut 1000)
    }

    #[track_caller]
    fn holds(descr: &str, data: &[u8], expected: &[f64]) {
        let array = of(descr, data).expect(descr);
        assert_eq!(array.shape, [expected.len()], "{descr}");
        assert_eq!(array.values.as_deref(), Ok(expected), "{descr}");
    }

    #[test]
    fn every_real_type_in_both_byte_orders() {
        holds("'<f8'", &[0, 0, 0, 0, 0, 0, 0xf8, 0x3f], &[1.5]);
        holds("'>f8'", &[0xbf, 0xf8, 0, 0, 0, 0, 0, 0], &[-1.5]);
        holds("'<f4'", &[0, 0, 0xc0, 0x3f], &[1.5]);
        holds("'>f4'", &[0xbf, 0xc0, 0, 0], &[-1.5]);
        holds("'|i1'", &[0xff, 0x7f, 0x80], &[-1.0, 127.0, -128.0]);
        holds("'<i2'", &[0xfe, 0xff, 0, 1], &[-2.0, 256.0]);
        holds("'>i2'", &[0xff, 0xfe, 0, 1], &[-2.0, 1.0]);
        holds("'<i4'", &[0xfd, 0xff, 0xff, 0xff], &[-3.0]);
        holds("'>i4'", &[0, 1, 0, 0], &[65536.0]);
        holds("'<i8'", &[0xfc, 255, 255, 255, 255, 255, 255, 255], &[-4.0]);
        holds("'>i8'", &[0x80, 0, 0, 0, 0, 0, 0, 0], &[-(2f64.powi(63))]);
        holds("'|u1'", &[0xff, 0], &[255.0, 0.0]);
        holds("'<u2'", &[0xfe, 0xff], &[65534.0]);
        holds("'>u4'", &[0xff, 0xff, 0xff, 0xff], &[4_294_967_295.0]);
        holds("'<u8'", &[0, 0, 0, 0, 0, 0, 0, 0x80], &[2f64.powi(63)]);
        holds("'|b1'", &[0, 1, 1], &[0.0, 1.0, 1.0]);
        holds("'<M8[ns]'", &[0, 2, 0, 0, 0, 0, 0, 0], &[512.0]);
        holds("\"<f4\"", &[0, 0, 0x80, 0x3f], &[1.0]);
    }

    #[test]
    fn text_complex_numbers_and_records_are_no_real_numbers() {
        let record = "[('t', '<f8'), (\"a 'shape': (9,), }\", '<i2', (2,))]";
        for descr in ["'<U5'", "'|S3'", "'|O'", "'<c16'", "'<f2'", record] {
            let dictionary = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (2,)}}");
            let array = read(file(3, &dictionary, &[0; 64]).as_slice(), &mut 1000).expect(descr);
            assert_eq!(array.values, Err("no real numbers"), "{descr}");
            assert_eq!(array.shape, [2], "{descr}");
        }
    }

    #[test]
    fn shapes_orders_and_versions() {
        for (shape, lengths) in [
            ("()", &[][..]),
            ("(1,)", &[1]),
            ("(1, 1)", &[1, 1]),
            ("(1L,)", &[1]),
            ("[1]", &[1]),
        ] {
            for version in [1, 2, 3] {
                let dictionary =
                    format!("{{'shape': {shape}, 'fortran_order': True, 'descr': '|i1'}}");
                let array = read(file(version, &dictionary, &[7]).as_slice(), &mut 8);
                let array = array.expect(shape);
                assert_eq!(array.shape, lengths);
                assert!(array.is_fortran);
                assert_eq!(array.values, Ok(vec![7.0]));
            }
        }
    }

    #[test]
    fn what_is_damaged_says_what_is_wrong() {
        let good = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}";
        let told = |bytes: &[u8]| read(bytes, &mut 1000).err().expect("refused");
        let whole = file(1, good, &[0; 16]);
        for end in 0..whole.len() {
            let told = told(&whole[..end]);
            assert!(told == "it ends too early", "{end}: {told}");
        }
        for (wrong, word) in [
            ("", "dictionary"),
            ("{'descr': '<f8'", "dictionary"),
            ("{descr: '<f8'}", "dictionary"),
            ("{'descr': '<f8', 'shape': (2,)}", "fortran_order"),
            ("{'fortran_order': 1, 'shape': (2,)}", "not True or False"),
            ("{'fortran_order': True, 'shape': 2}", "no lengths"),
            ("{'fortran_order': True, 'shape': (-2,)}", "no lengths"),
            ("{'fortran_order': True, 'shape': (2,)}", "descr"),
        ] {
            let told = told(&file(1, wrong, &[0; 16]));
            assert!(told.contains(word), "{wrong}: {told}");
        }
        assert!(told(b"\x93NUMPX\x01\0\0\0").contains("does not start"));
        assert!(told(b"\x93NUMPY\x04\0\0\0\0\0").contains("version 4.0"));
        assert!(told(b"\x93NUMPY\x02\0\xff\xff\xff\xff").contains("4294967295 bytes"));
    }

    #[test]
    fn what_a_header_promises_is_bounded() {
        for shape in ["(126,)", "(9999999999999,)", "(4294967296, 4294967296, 2)"] {
            let dictionary =
                format!("{{'descr': '|i1', 'fortran_order': False, 'shape': {shape}}}");
            let told = read(file(1, &dictionary, &[0; 126]).as_slice(), &mut 1000).err();
            assert!(told.is_some_and(|told| told.contains("memory")), "{shape}");
        }
    }
}
