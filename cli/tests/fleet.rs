//! `preslide fleet` on made axes: a row a recording, whatever is wrong with one of them, and nothing made twice.

use preslide_host_tests::made::{Blocks, sines};
use std::path::Path;
use std::process::{Command, Output};

const AXES: usize = 3;
const DAYS: usize = 7;

/// A recording of six seconds: a mass on Coulomb and viscous friction with two blocks, and noise that repeats.
fn recording(mass: f64, level: f64, noise: u64) -> String {
    let blocks = [(4e4, 0.6), (1.5e4, 0.4)].map(|(k, share)| (k, share * level / k));
    let (mut blocks, mut random) = (Blocks::new(&blocks), noise);
    let mut text = "t_s,x_m,force_N\n".to_owned();
    for i in 0..1200 {
        let t = 5e-3 * f64::from(i);
        let [x, v, a] = sines(&[[0.03, 3.1, 0.0], [0.01, 8.2, 1.0]], t);
        let mut force = mass * a + 20.0 * v + blocks.force(x);
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        force += 0.05 * ((random >> 33) as f64 / f64::from(1_u32 << 31) - 0.5);
        text += &format!("{t:.3},{x:.9},{force:.6}\n");
    }
    text
}

/// Axes of which the second has a third more friction on its last day, and one recording that is none.
fn fleet(folder: &Path) {
    for axis in 0..AXES {
        let own = folder.join(format!("axis{axis}"));
        std::fs::create_dir_all(&own).expect("a folder");
        for day in 0..DAYS {
            let seed = (axis * 100 + day) as u64 + 1;
            let wobble = 1.0 + 0.01 * ((seed * 7919 % 13) as f64 / 6.0 - 1.0);
            let worn = if axis == 1 && day == DAYS - 1 {
                1.33
            } else {
                1.0
            };
            let text = recording(2.0 * wobble, 4.0 * wobble * worn, seed);
            std::fs::write(own.join(format!("2026-11-{:02}.csv", day + 1)), text).expect("written");
        }
    }
    std::fs::write(folder.join("axis2/2026-11-03.csv"), "no recording\n").expect("written");
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_preslide"))
        .current_dir(folder)
        .arg("fleet")
        .args(arguments)
        .output()
        .expect("the binary runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The cells of a line, quoted where they hold a comma.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("one").push(c),
        }
    }
    cells
}

fn column(csv: &str, name: &str) -> Vec<String> {
    let mut lines = csv.lines().map(cells);
    let head = lines.next().expect("a head");
    let at = head.iter().position(|h| h == name);
    let at = at.unwrap_or_else(|| panic!("no {name} in {head:?}"));
    lines.map(|own| own[at].clone()).collect()
}

#[test]
fn a_fleet_has_one_row_per_recording_and_resumes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    fleet(&folder.path().join("line"));
    let made = run(
        folder.path(),
        &[
            "line",
            "-o",
            "fleet.csv",
            "--fit-only",
            "--jobs",
            "2",
            "--json",
            "fleet.json",
        ],
    );
    assert!(made.status.success(), "{}", text(&made.stderr));
    let said = text(&made.stdout).replace('\n', " ");
    assert!(
        said.contains("21 recordings of 3 axes, 1 without an answer"),
        "{said}"
    );
    assert!(
        said.contains("raises an alarm on 1 of them: axis1"),
        "{said}"
    );
    assert!(said.contains("axis2/2026-11-03.csv"), "{said}");
    let table = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("written");
    let csv = table("fleet.csv");
    let summary: serde_json::Value = serde_json::from_str(&table("fleet.json")).expect("a summary");
    assert_eq!(summary["schema"], "preslide.fleet-summary/1");
    let counts = ["recordings", "axes", "made"].map(|key| summary[key].as_u64().expect(key));
    assert_eq!(counts, [21, 3, 21]);
    assert_eq!(summary["errors"][0]["file"], "axis2/2026-11-03.csv");
    assert_eq!(summary["errors"][0]["reason"], column(&csv, "error")[16]);
    let counts = ["with_history", "with_alarm"].map(|key| summary[key].as_u64().expect(key));
    assert_eq!(counts, [3, 1]);
    assert!(
        summary["newest_unread"]
            .as_array()
            .expect("axes")
            .is_empty()
    );
    let worn = &summary["newest"][0].clone();
    assert_eq!(
        (&worn["axis"], &worn["alarm"]),
        (&"axis1".into(), &true.into())
    );
    assert_eq!(worn["parameter"], "coulomb_N");
    let share = worn["by"].as_f64().expect("a change") / worn["usual"].as_f64().expect("a mean");
    assert!((share - 0.33).abs() < 0.05, "{worn}");
    let levels: Vec<f64> = column(&csv, "coulomb_N")
        .iter()
        .filter_map(|v| v.parse().ok())
        .collect();
    assert_eq!((column(&csv, "axis").len(), levels.len()), (21, 20));
    assert!((levels[13] / levels[12] - 1.33).abs() < 0.05, "{levels:?}");

    // A logger that failed after the day that raised the alarm does not hide it.
    let empty = folder.path().join("line/axis1/2026-11-08.csv");
    std::fs::write(&empty, "").expect("written");
    let failed = run(
        folder.path(),
        &[
            "line",
            "-o",
            "fleet.csv",
            "--fit-only",
            "--json",
            "fleet.json",
        ],
    );
    std::fs::remove_file(&empty).expect("removed");
    let said = text(&failed.stdout).replace('\n', " ");
    assert!(
        said.contains("raises an alarm on 1 of them: axis1")
            && said.contains("Newer files of axis1 could not be read"),
        "{said}"
    );
    let summary: serde_json::Value = serde_json::from_str(&table("fleet.json")).expect("a summary");
    assert_eq!(summary["newest"][0], *worn);
    assert_eq!(summary["newest_unread"], serde_json::json!(["axis1"]));

    // Killed while it wrote the ninth row.
    let journal = folder.path().join("fleet.csv.rows.jsonl");
    let kept = std::fs::read_to_string(&journal).expect("a journal");
    let mut torn: String = kept.lines().take(9).map(|l| format!("{l}\n")).collect();
    torn += &kept.lines().nth(9).expect("rows")[..40];
    std::fs::write(&journal, torn).expect("written");
    let again = run(folder.path(), &["line", "-o", "fleet.csv", "--fit-only"]);
    let told = text(&again.stderr);
    assert!(told.contains("of 13"), "13 of 21 were left to do: {told}");
    // But for the seconds that it took.
    let without = |csv: &str| -> Vec<String> {
        csv.lines()
            .map(|l| l.rsplit_once(',').expect("columns").0.to_owned())
            .collect()
    };
    assert_eq!(without(&table("fleet.csv")), without(&csv));

    // Two machines, and a third that makes the table of what they made.
    for part in ["1/2", "2/2"] {
        let own = run(
            folder.path(),
            &["line", "-o", "parts.csv", "--fit-only", "--part", part],
        );
        assert!(own.status.success(), "{}", text(&own.stderr));
    }
    let joined = run(folder.path(), &["line", "-o", "parts.csv", "--fit-only"]);
    assert!(
        !text(&joined.stderr).contains("recordings: 1 of"),
        "{}",
        text(&joined.stderr)
    );
    assert_eq!(without(&table("parts.csv")), without(&csv));

    // A new recording, and nothing else.
    std::fs::write(
        folder.path().join("line/axis0/2026-11-08.csv"),
        recording(2.0, 4.0, 77),
    )
    .expect("written");
    let next = run(
        folder.path(),
        &["line/*/*.csv", "-o", "fleet.csv", "--fit-only"],
    );
    assert!(
        text(&next.stderr).contains("of 1 ("),
        "{}",
        text(&next.stderr)
    );
    assert!(
        text(&next.stdout).contains("22 recordings"),
        "{}",
        text(&next.stdout)
    );
}

/// Folders with files of the same names, and what a shell makes of a pattern: each row is of its own file, each axis by itself.
#[test]
fn files_of_the_same_name_in_two_folders_are_two_axes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut files = Vec::new();
    for (line, level) in [("line1", 4.0), ("line2", 6.0)] {
        let own = folder.path().join(line).join("axis");
        std::fs::create_dir_all(&own).expect("a folder");
        std::fs::write(own.join("2026-11-01.csv"), recording(2.0, level, 5)).expect("written");
        files.push(format!("{line}/axis/2026-11-01.csv"));
    }
    for given in [
        vec!["line1", "line2"],
        files.iter().map(String::as_str).collect(),
    ] {
        let arguments = [given, vec!["-o", "fleet.csv", "--fit-only"]].concat();
        let made = run(folder.path(), &arguments);
        assert!(made.status.success(), "{}", text(&made.stderr));
        let csv = std::fs::read_to_string(folder.path().join("fleet.csv")).expect("written");
        assert_eq!(column(&csv, "axis"), ["line1/axis", "line2/axis"]);
        let levels: Vec<f64> = column(&csv, "coulomb_N")
            .iter()
            .map(|v| v.parse().expect("a number"))
            .collect();
        assert!(
            (levels[0] - 4.0).abs() < 0.3 && (levels[1] - 6.0).abs() < 0.3,
            "{levels:?}"
        );
    }
}

/// A table may lie among its recordings, and never in place of one.
#[test]
fn a_recording_is_not_overwritten_by_the_table() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let of_press = folder.path().join("press_1.csv");
    std::fs::write(&of_press, recording(2.0, 4.0, 6)).expect("written");
    let lost = run(folder.path(), &[".", "-o", "press_1.csv", "--fit-only"]);
    assert_eq!(lost.status.code(), Some(2));
    assert!(
        text(&lost.stderr).contains("would overwrite the input"),
        "{}",
        text(&lost.stderr)
    );
    assert!(
        std::fs::read_to_string(&of_press)
            .expect("there")
            .starts_with("t_s,x_m")
    );
    for _ in 0..2 {
        let among = run(folder.path(), &[".", "-o", "fleet.csv", "--fit-only"]);
        assert!(
            text(&among.stdout).contains("1 recording of 1 axis"),
            "{}",
            text(&among.stdout)
        );
    }
}

#[test]
fn a_fleet_with_diagnoses_has_verdicts_a_page_and_a_parquet_table() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let line = folder.path().join("line");
    std::fs::create_dir_all(&line).expect("a folder");
    for day in 1..=2 {
        std::fs::write(
            line.join(format!("press_{day}.csv")),
            recording(2.0, 4.0, day),
        )
        .expect("written");
    }
    let made = run(
        folder.path(),
        &["line", "-o", "fleet.parquet", "--report", "fleet.html"],
    );
    assert!(made.status.success(), "{}", text(&made.stderr));
    assert!(
        text(&made.stdout).contains("2 recordings of 1 axis,"),
        "{}",
        text(&made.stdout)
    );
    let table = std::fs::read(folder.path().join("fleet.parquet")).expect("written");
    assert!(table.starts_with(b"PAR1") && table.ends_with(b"PAR1"));
    let page = std::fs::read_to_string(folder.path().join("fleet.html")).expect("written");
    assert!(page.contains("What drifted"));
}

#[test]
fn reports_wrong_requests() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let refused = |arguments: &[&str]| {
        let run = run(folder.path(), arguments);
        assert_eq!(run.status.code(), Some(2), "{arguments:?}");
        text(&run.stderr)
    };
    assert!(refused(&["nowhere", "-o", "fleet.csv"]).contains("nowhere: no recording there"));
    assert!(refused(&["nowhere", "-o", "fleet.csv", "--part", "3/2"]).contains("such as 1/8"));
    assert!(refused(&["nowhere", "-o", "fleet.xlsx"]).contains(".parquet or .csv"));
}
