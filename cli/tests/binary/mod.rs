//! The `preslide` binary and files for it.

use preslide_host_tests::made::Blocks;
use std::fmt::Write as _;
use std::process::{Command, Output};
use tempfile::TempDir;

/// What a run of the binary left behind.
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let run = Run {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        };
        assert!(!run.err.contains("panicked"), "panic:\n{}", run.err);
        run
    }
}

impl Run {
    /// The exit code, and every one of `parts` on stderr.
    pub fn fails(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.err);
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is not in:\n{}", self.err);
        }
    }

    pub fn succeeds(&self) -> &Self {
        assert_eq!(self.code, Some(0), "{}", self.err);
        self
    }
}

/// A model file.
pub const MODEL: &str = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"gms\"\nbreakaway_N = 0.9\nblocks = [\n{ stiffness_N_per_m = 270313.0, weight = 0.25 },\n{ stiffness_N_per_m = 20000.0, weight = 0.75 },\n]\n";

/// Runs the binary.
pub fn preslide(arguments: &[&str]) -> Run {
    Command::new(env!("CARGO_BIN_EXE_preslide"))
        .args(arguments)
        .output()
        .expect("the binary runs")
        .into()
}

/// Files of one test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    pub fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

/// Six cycles of two nested loops of a single Maxwell-slip block, 4000 N/m and 1 N, with a little viscous friction
/// and a ripple; header and samples.
pub fn recording(header: &str) -> String {
    let mut text = format!("{header}\n");
    let mut block = Blocks::new(&[(4000.0, 2.5e-4)]);
    for i in 0..2400 {
        let time = f64::from(i) * 0.01;
        let turn = std::f64::consts::TAU * f64::from(i % 400) / 400.0;
        let x = 1e-3 * (turn.sin() + 0.4 * (3.0 * turn).sin());
        let ripple = 0.01 * f64::from((i * 7919) % 101 - 50) / 50.0;
        writeln!(text, "{time:.3},{x:.9},{:.6}", block.force(x) + ripple).expect("memory");
    }
    text
}

/// Its columns.
pub const HEADER: &str = "t_s,x_m,friction_N";
