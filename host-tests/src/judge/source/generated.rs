//! Generators of trials that are Python programs, run once for each seed and kept under `target/`: that of stages in
//! `../shared/generators/stage`, and that of a laboratory's machines in `host-tests/generators/labs`.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::judge::case::{Case, Place, Sort, Truth};
use crate::judge::real::shared;
use crate::judge::table::{Recording, Table};
use crate::judge::tool::{Tool, parallel};

/// A program that makes trials: `NNN/rec.csv`, `base.toml` and `label.json` in a folder.
pub struct Generator {
    /// Name of the source.
    pub source: &'static str,
    script: fn() -> Option<PathBuf>,
    /// What makes a set.
    arguments: &'static [&'static str],
}

/// Nanometre stages.
pub const STAGE: Generator = Generator {
    source: "stage",
    script: || Some(shared()?.join("generators/stage/trials.py")),
    arguments: &["--n-per", "1"],
};

/// Nine kinds of machine from pumps to direct-drive tables under eight laws, 190 trials, each label with what an oracle sees of its effects; by
/// somebody who had read neither the diagnosis nor another generator.
pub const LABS: Generator = Generator {
    source: "labs",
    script: || Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("generators/labs/trials.py")),
    arguments: &["--n-clean", "60", "--n-effect", "100", "--n-strange", "30"],
};

/// Where generated sets and the Python environment are kept.
fn kept() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../target/judge"))
}

fn run(command: &mut Command) -> Result<(), String> {
    eprintln!("$ {command:?}");
    let status = command.status().map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{command:?}: {status}"))
    }
}

/// A Python with numpy, numba and scipy: the one given, or an environment that is made once.
fn python(given: Option<&Path>) -> Result<PathBuf, String> {
    if let Some(given) = given {
        return Ok(given.to_owned());
    }
    let folder = kept().join("python");
    let python = folder.join("bin/python");
    if !python.exists() {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        run(Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "numpy", "numba", "scipy"]))?;
    }
    Ok(python)
}

impl Generator {
    fn folder_of(&self, seed: u64) -> PathBuf {
        kept().join(format!("{}-{seed}", self.source))
    }

    /// The folder of the trials of a seed, where they were generated before.
    pub fn kept_folder(&self, seed: u64) -> Option<PathBuf> {
        let folder = self.folder_of(seed);
        folder.join("complete").exists().then_some(folder)
    }

    /// The folder of the trials of a seed, generated where it is not there.
    ///
    /// # Errors
    /// Where the generator is absent or fails.
    pub fn folder(&self, seed: u64, given: Option<&Path>) -> Result<PathBuf, String> {
        let script = (self.script)().ok_or("../shared is absent")?;
        let folder = self.folder_of(seed);
        let done = folder.join("complete");
        if !done.exists() {
            let mut command = Command::new(python(given)?);
            // The generator's folder may be read-only, and is no place for what is compiled.
            command
                .env("PYTHONDONTWRITEBYTECODE", "1")
                .env("NUMBA_CACHE_DIR", kept().join("numba"))
                .arg(&script)
                .arg(&folder)
                .args(self.arguments);
            run(command.args(["--seed", &seed.to_string()]))?;
            std::fs::write(&done, "").map_err(|e| format!("{}: {e}", done.display()))?;
        }
        Ok(folder)
    }
}

/// What a label of the stage calls a parameter, whose effect it is, and what the tool calls it.
const PARAMETERS: [(&str, &str, &str); 12] = [
    ("bias", "constant_force", "force_N"),
    ("asym", "coulomb_asymmetry", "asymmetry"),
    ("visc", "viscous", "viscous_N_s_per_m"),
    ("quad", "quadratic_drag", "drag_N_s2_per_m2"),
    ("str_a", "stribeck", "level"),
    ("str_vs", "stribeck", "velocity_m_s"),
    ("spring", "position_spring", "stiffness_N_per_m"),
    ("spot_x", "local_friction_spot", "position_m"),
    ("cog_a", "periodic_force", "force_N"),
    ("cog_p", "periodic_force", "period_m"),
    ("delay", "channel_delay", "delay_s"),
    ("vib_f", "external_vibration", "frequency_Hz"),
];

/// That generator reads the position and then holds its command for a sample of 1 ms (`sim.py`: 20 steps with one `u`), so what it records
/// acts half a sample later. A label's delay leaves that out.
const HOLD_S: f64 = 0.5e-3;

fn truth(effect: &Value, parameters: &Value) -> Truth {
    let id = effect["id"].as_str().unwrap_or_default();
    let id = if id == "unknown" {
        effect["raw"].as_str().unwrap_or(id)
    } else {
        id
    };
    let value = |key: &str| {
        let labelled = parameters[key].as_f64();
        labelled.map(|v| if key == "delay" { v - HOLD_S } else { v })
    };
    let place = match id {
        "stribeck" => value("str_vs").map(|v| Place::new("velocity", 0.0, 2.0 * v)),
        "local_friction_spot" => value("spot_x")
            .zip(value("spot_w"))
            .map(|(x, w)| Place::new("position", x - 1.5 * w, x + 1.5 * w)),
        _ => None,
    };
    let own = PARAMETERS.iter().filter(|p| p.1 == id);
    Truth {
        seen: effect["seen"].as_bool(),
        seen_beside_a_fit: effect["seen_fitted"].as_bool(),
        place,
        parameters: own
            .filter_map(|p| Some((p.2.to_owned(), value(p.0)?)))
            .collect(),
        ..Truth::named(id)
    }
}

/// What a machine has besides what was concealed: `labs` gives the user of a machine whose friction is tanh(v/v0) a model of blocks.
fn native(label: &Value, model: Option<&str>) -> Vec<Truth> {
    let is_smooth = model.is_some() && label["law"] == "tanh";
    Vec::from_iter(is_smooth.then(|| Truth::named("presliding_shape")))
}

/// What an effect has in it besides: a force over the travel has a mean.
fn implied(truth: &Truth) -> Option<String> {
    let of_the_travel = ["position_force", "position_spring", "gravity"];
    of_the_travel
        .contains(&truth.id.as_str())
        .then(|| "constant_force".to_owned())
}

/// A trial and what its label says.
struct Question {
    recording: Recording,
    sort: Sort,
    strength: f64,
    truth: Vec<Truth>,
    native: Vec<Truth>,
}

fn question(folder: &Path) -> Result<Question, String> {
    let read = |name: &str| {
        let file = folder.join(name);
        std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))
    };
    let label: Value = serde_json::from_str(&read("label.json")?).map_err(|e| e.to_string())?;
    let sort = match label["kind"].as_str() {
        Some("clean") => Sort::Clean,
        Some("single") => Sort::Single,
        Some("pair") => Sort::Pair,
        Some("masked") => Sort::Masked,
        Some("unknown") => Sort::Stranger,
        kind => return Err(format!("{}: a label of kind {kind:?}", folder.display())),
    };
    let effects = label["effects"].as_array().cloned().unwrap_or_default();
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let strength = effects
        .first()
        .and_then(|e| e["severity"].as_f64())
        .unwrap_or(0.0);
    let truth = effects.iter().map(|e| truth(e, &label["params"])).collect();
    let table = Table::parse(&read("rec.csv")?)?;
    let model = folder.join("base.toml").exists();
    let model = model.then(|| read("base.toml")).transpose()?;
    Ok(Question {
        native: native(&label, model.as_deref()),
        recording: Recording::new(name, table, model),
        sort,
        strength,
        truth,
    })
}

/// Asks the tool of every `every`th trial in a folder of the source whose sort is wanted.
///
/// # Errors
/// Where a trial cannot be read.
pub fn cases(
    tool: &Tool,
    (source, folder): (&'static str, &Path),
    every: usize,
    wanted: impl Fn(Sort) -> bool + Sync,
    jobs: usize,
) -> Result<Vec<Case>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut trials: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    trials.retain(|path| path.join("label.json").exists());
    trials.sort();
    let trials: Vec<PathBuf> = trials.into_iter().step_by(every).collect();
    let answered = parallel(&trials, jobs, |path| {
        let asked = question(path)?;
        if !wanted(asked.sort) {
            return Ok(None);
        }
        let (answer, seconds) = tool.diagnose(&asked.recording);
        let case = Case {
            source,
            name: asked.recording.name,
            sort: asked.sort,
            strength: asked.strength,
            neutral: asked.truth.iter().filter_map(implied).collect(),
            truth: asked.truth,
            native: asked.native,
            absent: None,
            there: None,
            verdicts: &[],
            answer,
            seconds,
        };
        eprintln!("{}", case.line());
        Ok(Some(case))
    });
    answered.into_iter().filter_map(Result::transpose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn another_shape_is_no_false_name_where_the_user_has_a_model() {
        let smooth = json!({"law": "tanh", "params": {}});
        let told = |model| {
            native(&smooth, model)
                .iter()
                .any(|t| t.id == "presliding_shape")
        };
        assert!(told(Some("")) && !told(None));
        assert!(native(&json!({"law": "iwan", "params": {}}), Some("")).is_empty());
    }
}
