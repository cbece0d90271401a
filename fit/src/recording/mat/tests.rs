//! MATLAB files written here, whole and damaged.

use preslide_host_tests::refusal::refuses;
use std::io::Write;

use super::*;
use crate::recording::tests::{load_mat, options};
use crate::recording::{LoadOptions, Recording, RecordingError};

/// A v5 file in one's own hand: `(name, class, type, bytes, rows, columns)` each.
struct Writer {
    bytes: Vec<u8>,
    big_endian: bool,
    compressed: bool,
}

impl Writer {
    fn new(big_endian: bool, compressed: bool) -> Self {
        let mut bytes = b"MATLAB 5.0 MAT-file, written by a test".to_vec();
        bytes.resize(124, b' ');
        bytes.extend(if big_endian {
            *b"\x01\x00MI"
        } else {
            *b"\x00\x01IM"
        });
        Writer {
            bytes,
            big_endian,
            compressed,
        }
    }
    fn word(&self, v: u32) -> [u8; 4] {
        if self.big_endian {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    }
    fn element(&self, kind: u32, payload: &[u8]) -> Vec<u8> {
        let mut out = self.word(kind).to_vec();
        out.extend(self.word(payload.len() as u32));
        out.extend(payload);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }
    fn variable(
        mut self,
        name: &str,
        class: u32,
        size: [u32; 2],
        kind: u32,
        payload: &[u8],
    ) -> Self {
        let mut inside = self.element(6, &[self.word(class), self.word(0)].concat());
        inside.extend(self.element(5, &[self.word(size[0]), self.word(size[1])].concat()));
        if name.len() <= 4 {
            // The small form, as MATLAB writes short names.
            inside.extend(self.word((name.len() as u32) << 16 | 1));
            inside.extend(name.as_bytes());
            inside.resize(inside.len().next_multiple_of(8), 0);
        } else {
            inside.extend(self.element(1, name.as_bytes()));
        }
        inside.extend(self.element(kind, payload));
        let matrix = self.element(14, &inside);
        if self.compressed {
            let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            zip.write_all(&matrix).expect("memory");
            let zip = zip.finish().expect("memory");
            self.bytes.extend(self.word(15));
            self.bytes.extend(self.word(zip.len() as u32));
            self.bytes.extend(zip);
        } else {
            self.bytes.extend(matrix);
        }
        self
    }
    fn doubles(self, name: &str, values: &[f64]) -> Self {
        let big = self.big_endian;
        let payload: Vec<u8> = values
            .iter()
            .flat_map(|v| {
                if big {
                    v.to_be_bytes()
                } else {
                    v.to_le_bytes()
                }
            })
            .collect();
        self.variable(name, 6, [values.len() as u32, 1], 9, &payload)
    }
}

/// Variables of every kind, of which `u` is a force.
pub(in crate::recording) fn recording(big_endian: bool, compressed: bool) -> Vec<u8> {
    Writer::new(big_endian, compressed)
        .variable("note", 4, [1, 2], 16, b"ab")
        .variable("t_s", 6, [1, 4], 2, &[0, 1, 2, 3])
        .doubles("x_m", &[0.0, 0.5, 1.0, 0.25])
        .doubles("gain", &[-2.0])
        .doubles("u", &[1.0, 2.0, 3.0, 4.0])
        .variable("small", 12, [4, 1], 1, &[255, 1, 2, 3])
        .bytes
}

fn load(bytes: &[u8], map: &[(&str, &str)]) -> Result<Recording, RecordingError> {
    load_mat(bytes, "test.mat", &options(map))
}

#[test]
fn both_byte_orders_compressed_or_not_give_the_same_recording() {
    for (big, compressed) in [(false, false), (false, true), (true, false), (true, true)] {
        let r = load(&recording(big, compressed), &[("force_N", "0.5*gain*u")]).expect("readable");
        assert_eq!(r.t_s, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(r.position, [0.0, 0.5, 1.0, 0.25]);
        assert_eq!(r.effort, [-1.0, -2.0, -3.0, -4.0]);
        let r = load(&recording(big, compressed), &[("force_N", "small")]).expect("readable");
        assert_eq!(r.effort, [-1.0, 1.0, 2.0, 3.0]);
    }
}

#[test]
fn messages_list_the_variables_with_their_sizes() {
    for (map, parts) in [
        (&[][..], &["x_m 4×1", "gain 1×1", "note 1×2 char"][..]),
        (&[("force_N", "note")], &["not a vector of real numbers"]),
        (
            &[("force_N", "gain")],
            &["`force_N` has 1 samples, `t_s` 4"],
        ),
    ] {
        refuses(load(&recording(false, true), map), parts);
    }
}

#[test]
fn truncation_at_every_byte_is_an_error() {
    for compressed in [false, true] {
        let bytes = recording(false, compressed);
        // The last variable is not needed for this recording, and yet its loss is an error.
        for length in 0..bytes.len() {
            let Ok(r) = load(&bytes[..length], &[("force_N", "u")]) else {
                continue;
            };
            // Between two variables the file is a complete one of fewer variables.
            let ends_at_a_variable = load(&bytes[..length], &[("force_N", "small")]).is_err();
            assert!(
                ends_at_a_variable && r.len() == 4,
                "{length} of {}",
                bytes.len()
            );
            assert!(
                variables(&bytes[..length], &LoadOptions::default()).is_ok_and(|v| v.len() == 5)
            );
        }
    }
}

#[test]
fn other_versions_say_how_to_save() {
    for head in [&b"MATLAB 5.0"[..], &[0; 200]] {
        refuses(load(head, &[]), &["at byte"]);
    }
    refuses(load(b"", &[]), &["is empty"]);
}

#[test]
fn what_unpacks_beyond_the_limit_is_refused() {
    let bytes = Writer::new(false, true)
        .doubles("t_s", &vec![0.0; 1 << 20])
        .bytes;
    assert!(bytes.len() < 64 * 1024, "compresses well");
    let options = LoadOptions {
        max_bytes: 1 << 20,
        ..LoadOptions::default()
    };
    refuses(
        load_mat(bytes.as_slice(), "bomb.mat", &options),
        &["size limit"],
    );
}
