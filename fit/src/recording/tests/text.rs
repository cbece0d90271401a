//! Text: layouts, cells, and what is refused of them.

use std::io::{self, Read};

use super::*;

fn load(csv: &str) -> Result<Recording, RecordingError> {
    text(csv, &[])
}

#[test]
fn bad_cells_name_file_line_and_column() {
    for (cell, reason) in [
        ("nan", "not finite"),
        ("NaN", "not finite"),
        ("inf", "not finite"),
        ("1e999", "not finite"),
        ("", "is empty"),
        ("abc", "not a number"),
        ("1.2.3", "not a number"),
        ("0x10", "not a number"),
    ] {
        let csv = format!("# remark\n\nt_s,x_m,force_N\n0,0,1\n1,{cell},1\n2,0,1\n");
        refuses(load(&csv), &["test.csv", "line 5, column `x_m`", reason]);
    }
}

#[test]
fn what_is_no_text_of_rows_below_a_header_is_refused() {
    for (csv, parts) in [
        (
            "t_s,x_m,force_N\n0,0,1\n1,0\n",
            &["line 3: 2 cells where the header has 3"][..],
        ),
        ("t_s,x_m,force_N\n0,0,0,1,1,5\n", &["decimal commas"]),
        // Names between commas, the sample between semicolons.
        ("t_s,x_m,force_N\n0;0;1\n", &["holds one sample"]),
        (
            "0,0,1\n1,0,1\n",
            &["line 1: `0` is a number", "t_s,x_m,force_N"],
        ),
        ("", &["is empty", "header"]),
        ("\n\n", &["is empty", "header"]),
        ("# only a remark\n", &["is empty", "header"]),
        ("\u{feff}", &["is empty", "header"]),
        ("t_s,x_m,force_N\n", &["holds no sample"]),
        ("t_s,x_m,force_N\n0,0,1\n", &["holds one sample"]),
        ("t_s,x_m\0,force_N\n", &["a zero byte"]),
    ] {
        refuses(load(csv), parts);
    }
}

#[test]
fn what_drives_write_around_the_samples_is_read() {
    let plain = load("t_s,x_m,force_N\n0,0,1\n1,1e-3,1\n2,0,1\n").expect("plain");
    let utf16 = |mark: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let text = format!("{mark}t_s;x_m;force_N\r\n0;0;1\r\n1;0,001;1\r\n2;0;1\r\n");
        text.encode_utf16().flat_map(bytes).collect()
    };
    for (name, text) in [
        (
            "semicolons",
            b"t_s;x_m;force_N\n0;0;1\n1;1e-3;1\n2;0;1\n".to_vec(),
        ),
        (
            "decimal commas",
            b"t_s;x_m;force_N\n0,0;0,0;1,0\n1,0;0,001;1,0\n2,0;0,0;1,0\n".to_vec(),
        ),
        (
            "tabs",
            b"t_s\tx_m\tforce_N\n0\t0\t1\n1\t1e-3\t1\n2\t0\t1\n".to_vec(),
        ),
        (
            "blanks",
            b"   t_s x_m  force_N\n 0 0 1\n 1   1e-3 1\n 2 0 1 \n".to_vec(),
        ),
        ("CR", b"t_s,x_m,force_N\r0,0,1\r1,1e-3,1\r2,0,1\r".to_vec()),
        (
            "a units row",
            b"Time,Position,Force\nms,mm,kN\n0,0,0.001\n1000,1,0.001\n2000,0,0.001\n".to_vec(),
        ),
        (
            "metadata",
            b"Scope 4.2\nRate;1000\n\nt_s;x_m;force_N\n0;0;1\n1;1e-3;1\n2;0;1\n".to_vec(),
        ),
        (
            "a footer",
            b"t_s,x_m,force_N\n0,0,1\n1,1e-3,1\n2,0,1\nmean,1,1\nend of file\n".to_vec(),
        ),
        (
            "Latin-1",
            b"t_s,x_m,force_N,Temp_\xb0C,note\n0,0,1,3,\xe4\n1,1e-3,1,4,\xe4\n2,0,1,5,\xe4\n"
                .to_vec(),
        ),
        ("UTF-16", utf16("\u{feff}", u16::to_le_bytes)),
        ("UTF-16 without a mark", utf16("", u16::to_le_bytes)),
        ("the other UTF-16", utf16("", u16::to_be_bytes)),
        (
            "a remark for a header",
            b"# t_s x_m force_N\n0 0 1\n1 1e-3 1\n2 0 1\n".to_vec(),
        ),
    ] {
        let read = load_csv(text.as_slice(), name, &LoadOptions::default());
        let read = read.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            (&read.t_s, &read.position, &read.effort),
            (&plain.t_s, &plain.position, &plain.effort),
            "{name}"
        );
        let has_footer = warns(&read, "footer") && said(&read, "footer").contains("line 5");
        assert_eq!(has_footer, name == "a footer");
    }
}

#[test]
fn all_bad_cells_are_counted_and_absurd_ones_refused() {
    for (csv, parts) in [
        (
            "t_s,x_m,force_N\n0,0,1\n1,nan,1\n2,0,1\n3,0,x\n4,0,1\n",
            &["line 3", "1 more", "line 5"][..],
        ),
        (
            "t_s,x_m,force_N\n0,0,1\n1,0,1e288\n2,0,1\n",
            &["line 3", "force_N", "no sensor"],
        ),
    ] {
        refuses(load(csv), parts);
    }
    let rows: String = (0..100).map(|i| format!("{i},{},1,{i}\n", i % 7)).collect();
    refuses(
        load(&format!("t_s,x_m,force_N,repeat\n{rows}")),
        &["repeat", "counts rows"],
    );
    let floats = load("t_s,x_m,force_N,repeat\n0,0,1,0.0\n1,1,1,1.0\n2,0,1,1.0\n").expect("1.0");
    assert_eq!(floats.repeat, [0, 1, 1]);
}

#[test]
fn bom_crlf_quotes_spaces_and_remarks_are_accepted() {
    let plain = load("t_s,x_m,force_N,note\n-0,0,1,a\n1,1e-3,1,b\n2,0,1,c\n").expect("plain");
    let odd = load("\u{feff}# remark\r\n\r\n\"t_s\", \"x_m\" ,force_N,note\r\n-0, 0,1,a\r\n1,\"1e-3\",1,b\r\n2,0,1,c")
        .expect("odd");
    assert_eq!(
        (&plain.t_s, &plain.position, &plain.effort),
        (&odd.t_s, &odd.position, &odd.effort)
    );
    assert!(plain.t_s.first().is_some_and(|t| t.is_sign_positive()));
    assert!(said(&odd, "unused-columns").contains("note"));
}

/// Rows without end, made on the fly.
struct Endless {
    row: u64,
    buffer: Vec<u8>,
}
impl Read for Endless {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.buffer.is_empty() {
            self.buffer = format!("{},{},1\n", self.row, self.row % 7).into_bytes();
            self.row += 1;
        }
        let n = out.len().min(self.buffer.len());
        out[..n].copy_from_slice(&self.buffer[..n]);
        self.buffer.drain(..n);
        Ok(n)
    }
}

#[test]
fn a_stream_without_end_is_refused_at_the_sample_limit() {
    let options = LoadOptions {
        max_samples: 50_000,
        ..LoadOptions::default()
    };
    let input = (&b"t_s,x_m,force_N\n"[..]).chain(Endless {
        row: 0,
        buffer: Vec::new(),
    });
    let parts = ["more than 50000 samples", "line 50002"];
    refuses(load_csv(input, "endless.csv", &options), &parts);
}

#[test]
fn a_line_without_end_is_refused_before_it_fills_memory() {
    for head in ["", "t_s,x_m,force_N\n", "t_s,x_m,force_N\n0,0,\"1\n"] {
        let e = load_csv(
            head.as_bytes().chain(io::repeat(b'1')),
            "long.csv",
            &LoadOptions::default(),
        );
        let e = e.expect_err("endless line").to_string();
        assert!(e.contains("64 KiB") || e.contains("not a number"), "{e}");
    }
}

/// A drive's own unit in the row of units: the others are applied, and the question names column, unit and map.
#[test]
fn an_unknown_unit_leaves_the_row_one_of_units() {
    let rows: String = swing(|_, x, _| *x *= 1e3)
        .lines()
        .skip(1)
        .map(|l| l.replace(',', ";") + "\n")
        .collect();
    for head in [
        "Time;Position;Force\ns;LU;kN\n",
        "Zeit;Lage;Kraft\n[s];[LU];[kN]\n",
    ] {
        let csv = format!("{head}{rows}");
        let position = if head.starts_with('T') {
            "Position"
        } else {
            "Lage"
        };
        let named = format!("`{position} [LU]`");
        let map = format!("--map 'x_m=FACTOR*{position} [LU]'");
        refuses(text(&csv, &[]), &["no known unit at", &named, &map]);
        let map = format!("0.001*{position} [LU]");
        let r = text(&csv, &[("x_m", &map)]).expect("with its factor");
        assert!((r.ends().1 - 0.015).abs() < 1e-6);
        assert!(r.effort.iter().any(|f| *f > 2.9e3), "kN are applied");
        let bare = text(&csv, &[("x_m", position)]).expect("as it is");
        let said = said(&bare, "unit-of-another-kind");
        assert!(
            said.contains("is in LU, which is not a unit of x_m"),
            "{said}"
        );
    }
}

/// Times and days in the words and forms of loggers.
#[test]
fn stamps_of_a_day_and_a_time_are_taken_for_the_time() {
    let csv = |name: &str, of: &dyn Fn(u32, f64) -> String| {
        let row = |i: u32| {
            let (minute, second) = (i / 6000, f64::from(i % 6000) * 0.01);
            let x = 0.01 * (f64::from(i) * 0.02).sin();
            format!(
                "{};{x:.6};{:.3}\n",
                of(minute, second),
                (f64::from(i) * 0.02).cos().signum()
            )
        };
        format!(
            "{name};x_m;force_N\n{}",
            (0..9000).map(row).collect::<String>()
        )
    };
    let german = |m: u32, s: f64| format!("02.01.2026 03:{m:02}:{s:06.3}");
    let compact = |m: u32, s: f64| format!("20260102T03{m:02}{s:06.3}");
    let of_day = |m: u32, s: f64| format!("02.01.2026;03:{m:02}:{s:06.3}");
    for csv in [
        csv("Datum", &german),
        csv("Date", &german),
        csv("日時", &german),
        csv("时间", &german),
        csv("Heure", &german),
        csv("timestamp", &compact),
        csv("Datum;Uhrzeit", &of_day),
    ] {
        let r = read(&csv);
        let head = csv.lines().next().unwrap_or_default();
        assert!((r.sample_time_s() - 0.01).abs() < 1e-9, "{head}");
        assert!((r.t_s[8999] - r.t_s[0] - 89.99).abs() < 1e-6, "{head}");
    }
}

/// A comma at the end of the header is no column, unless something stands below it.
#[test]
fn a_header_may_end_with_a_comma() {
    let plain = swing(|_, _, _| {});
    let header = |more: &str| plain.replacen("force_N\n", &format!("force_N{more}\n"), 1);
    let r = read(&header(","));
    assert_eq!(r.effort, read(&plain).effort);
    assert!(!warns(&r, "nameless-column"));
    let below: String = header(",")
        .lines()
        .enumerate()
        .map(|(i, l)| match i {
            0 => format!("{l}\n"),
            _ => format!("{l},{}\n", i % 7),
        })
        .collect();
    assert!(said(&read(&below), "nameless-column").contains("number 4"));
    let unread = text(&below.replace("x_m", "pos"), &[]);
    refuses(unread, &["t_s, pos, force_N and a column without a name"]);
}
