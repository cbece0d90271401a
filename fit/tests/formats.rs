//! One recording in the formats of other tools, each file written by its own tool (`formats/make.py`), against the formula that
//! the script follows. What a build without the feature says is tested in that build.

use preslide_fit::recording::{LoadOptions, MotionKind, Recording, load, parse_map};
use preslide_host_tests::refusal::refuses;
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/formats")
        .join(name)
}

fn read(name: &str, map: &[&str]) -> Result<Recording, String> {
    let options = LoadOptions {
        map: map.iter().map(|m| parse_map(m).expect("a map")).collect(),
        ..LoadOptions::default()
    };
    load(&path(name), &options).map_err(|e| e.to_string())
}

/// Position (rad) at a time (s).
fn position(t: f64) -> f64 {
    0.5 * (1.3 * t).sin() * (1.0 + 0.2 * (0.17 * t).sin())
}

/// Largest deviation of time, position and torque from what was written.
fn deviation(recording: &Recording) -> [f64; 3] {
    assert_eq!(recording.len(), 600, "{}", recording.name);
    assert_eq!(recording.kind, MotionKind::Rotary, "{}", recording.name);
    let worst = |of: &dyn Fn(usize) -> f64| (0..600).map(of).fold(0.0, f64::max);
    let t = |i: usize| i as f64 * 0.02;
    let torque = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(599));
        3.0 * position(t(i)) + (position(t(after)) - position(t(before))).signum()
    };
    [
        worst(&|i| (recording.t_s[i] - t(i)).abs()),
        worst(&|i| (recording.position[i] - position(t(i))).abs()),
        worst(&|i| (recording.effort[i] - torque(i)).abs()),
    ]
}

/// Reads the file and compares it; `torque` is the rounding of its type there (N·m).
#[track_caller]
fn check(name: &str, map: &[&str], torque: f64) -> Recording {
    let recording = read(name, map).unwrap_or_else(|e| panic!("{e}"));
    let [t, q, f] = deviation(&recording);
    println!("{name}: max deviation {t:.1e} s, {q:.1e} rad, {f:.1e} N·m");
    assert!(t < 1e-12 && q < 1e-12 && f <= torque, "{name}: {t} {q} {f}");
    recording
}

/// Rounding of torques below 4 N·m in single precision.
const SINGLE: f64 = 2.4e-7;

#[test]
fn npz_by_names_and_as_a_table() {
    check("columns.npz", &[], SINGLE);
    let table = ["t_s=data[:,0]", "q_rad=data[:,1]", "torque_Nm=1*data[:,2]"];
    check("table.npz", &table, 1e-12);
    let told = read("table.npz", &[]).expect_err("no names");
    assert!(
        told.contains("data[:,2]") && told.contains("rate"),
        "{told}"
    );
}

#[test]
fn damaged_files_say_so_and_do_not_panic() {
    let folder = tempfile::tempdir().expect("folder");
    let names = [
        "columns.npz",
        "zstd.parquet",
        "groups.h5",
        "v73.mat",
        "joints.mcap",
        "joints.db3",
    ];
    for name in names {
        let whole = std::fs::read(path(name)).expect("there");
        for part in [20, whole.len() / 3, whole.len() / 2, whole.len() - 9] {
            let cut = folder.path().join(name);
            std::fs::write(&cut, &whole[..part]).expect("written");
            // A bag that is cut may still hold joint states, and SQLite may not read its last page.
            if let Err(told) = load(&cut, &LoadOptions::default()) {
                assert!(told.to_string().contains(name), "{told}");
            }
            let mut wrong = whole.clone();
            wrong[part] ^= 0x5a;
            std::fs::write(&cut, &wrong).expect("written");
            let _ = load(&cut, &LoadOptions::default());
        }
        let small = LoadOptions {
            max_bytes: 2048,
            ..LoadOptions::default()
        };
        refuses(load(&path(name), &small), &["exceed the limit"]);
    }
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_of_pandas_in_three_compressions() {
    for name in ["snappy.parquet", "zstd.parquet", "gzip.parquet"] {
        let read = check(name, &["t_s=stamp[s]"], 1e-12);
        assert!(read.extra.iter().any(|e| e.name == "counts"), "{name}");
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn hdf5_of_h5py_and_in_the_layout_of_matlab() {
    let map = [
        "t_s=axis1/t_s",
        "q_rad=axis1/q_rad",
        "torque_Nm=axis1/torque_Nm",
    ];
    check("groups.h5", &map, SINGLE);
    check("v73.mat", &[], 1e-12);
}

#[cfg(feature = "mcap")]
#[test]
fn mcap_of_ros_2() {
    let map = ["q_rad=elbow.position", "torque_Nm=elbow.effort"];
    let read = check("joints.mcap", &map, 1e-12);
    assert!(read.extra.iter().any(|e| e.name == "wrist.position"));
}

#[cfg(feature = "mcap")]
#[test]
fn joints_are_proposed() {
    refuses(
        read("joints.mcap", &[]),
        &["elbow.position", "wrist.effort", "--map"],
    );
}

#[cfg(feature = "db3")]
#[test]
fn db3_of_ros_2() {
    let map = ["q_rad=elbow.position", "torque_Nm=elbow.effort"];
    check("joints.db3", &map, 1e-12);
}

#[cfg(not(feature = "formats"))]
#[test]
fn a_build_without_a_reader_names_the_feature() {
    for (name, feature, there) in [
        ("zstd.parquet", "parquet", cfg!(feature = "parquet")),
        ("v73.mat", "hdf5", cfg!(feature = "hdf5")),
        ("joints.mcap", "mcap", cfg!(feature = "mcap")),
        ("joints.db3", "db3", cfg!(feature = "db3")),
    ] {
        if !there {
            refuses(read(name, &[]), &[&format!("--features {feature}")]);
        }
    }
}

#[test]
fn formats_that_no_crate_reads_well_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("folder");
    let zip = |name: &str| {
        let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default();
        zip.start_file(name, options).expect("memory");
        zip.finish().expect("memory").into_inner()
    };
    // Of a compressed file, and numbers as they are in memory.
    let noise: Vec<u8> = (1..4000_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8 | 1)
        .collect();
    let numbers: Vec<u8> = (0..500)
        .flat_map(|i| (f64::from(i) * 0.01).to_le_bytes())
        .collect();
    let v4: Vec<u8> = [0_u32, 1000, 1, 0, 4]
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    for (start, parts) in [
        (b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec(), ["TDMS", "npTDMS"]),
        (b"MDF     4.10    ".to_vec(), ["MDF", "asammdf"]),
        (b"#ROSBAG V2.0\n".to_vec(), ["ROS 1", "rosbags-convert"]),
        (b"\x93NUMPY\x01\0".to_vec(), ["NumPy", "savez"]),
        (
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0\0".to_vec(),
            ["Excel 97", "as CSV"],
        ),
        (b"\x1f\x8b\x08\0".to_vec(), ["gzip", "gunzip"]),
        (b"\xff\xfe\0\0t\0\0\0".to_vec(), ["UTF-32", "UTF-8"]),
        (zip("xl/workbook.xml"), ["Excel workbook", "as CSV"]),
        (zip("content.xml"), ["OpenDocument", "as CSV"]),
        (zip("run 1/axis.csv"), ["zip archive", "`run 1/axis.csv`"]),
        (noise, ["binary file", "CSV in UTF-8"]),
        (numbers, ["binary file", "CSV in UTF-8"]),
    ] {
        let file = folder.path().join("file");
        std::fs::write(&file, start).expect("written");
        let told = load(&file, &LoadOptions::default()).expect_err("refused");
        let told = told.to_string();
        assert!(parts.iter().all(|p| told.contains(p)), "{told}");
    }
    let file = folder.path().join("old.mat");
    std::fs::write(&file, v4).expect("written");
    refuses(
        load(&file, &LoadOptions::default()),
        &["MATLAB v4", "'-v7'"],
    );
}
