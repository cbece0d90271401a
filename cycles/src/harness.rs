//! One run of the measuring program: what it printed, and the paths that were recorded meanwhile.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

use super::disassembly::Disassembly;
use super::recorder::{Paths, Recorder, TakenPath, Watched};
use super::table::{self, Row};
use super::{PREFIX, PriceOf, price_paths};

/// A run, ready to be priced.
pub struct Run {
    pub printed: Printed,
    disassembly: Disassembly,
    recording: Paths,
}

impl Run {
    /// Runs the program under the recorder.
    pub fn of(program: &Path, recorder: &Recorder) -> Result<Self> {
        let disassembly = Disassembly::of(program)?;
        let entries: Vec<u32> = disassembly
            .functions_named(PREFIX)
            .map(|(address, _)| address)
            .collect();
        let watched = Watched {
            entries: &entries,
            skipped: &[],
            ends_inside: false,
        };
        let (recording, printed) = recorder.record(program, &watched)?;
        Ok(Self {
            printed: Printed::parse(&printed)?,
            disassembly,
            recording,
        })
    }

    /// A row for every kernel, as a core prices its paths.
    pub fn rows(&self, price_of: PriceOf) -> Result<Vec<Row>> {
        let kernels = self.printed.kernels.iter();
        kernels.map(|kernel| self.row(kernel, price_of)).collect()
    }

    fn row(&self, kernel: &Kernel, price_of: PriceOf) -> Result<Row> {
        let mut row = price_paths(&self.disassembly, self.paths(kernel)?, price_of)?;
        if row.calls != kernel.calls {
            // The linker folds functions of equal code: their calls cannot be told apart.
            bail!(
                "{}: {} calls were made, {} recorded",
                kernel.function(),
                kernel.calls,
                row.calls
            );
        }
        row.cycles_in_tick = self.cycles_in_tick(kernel, price_of)?;
        row.kernel.clone_from(&kernel.name);
        row.blocks = kernel.blocks;
        row.flash_bytes += kernel.model_bytes;
        row.ram_bytes = Some(kernel.state_bytes);
        if table::is_friction(&kernel.name) {
            row.error = kernel.error;
        }
        Ok(row)
    }

    /// By how much the control tick grows with the kernel inlined; `None` where no such tick was measured.
    fn cycles_in_tick(&self, kernel: &Kernel, price_of: PriceOf) -> Result<Option<f64>> {
        let with = self.recorded(&format!("tick__{}", kernel.function()));
        let without = self.recorded("tick__empty_call__1");
        let (Some(with), Some(without)) = (with, without) else {
            return Ok(None);
        };
        let mean =
            |paths| price_paths(&self.disassembly, paths, price_of).map(|row| row.cycles_mean);
        Ok(Some(mean(with)? - mean(without)?))
    }

    fn paths(&self, kernel: &Kernel) -> Result<&[TakenPath]> {
        let function = kernel.function();
        self.recorded(&function)
            .with_context(|| format!("no call of {PREFIX}{function} was recorded"))
    }

    fn recorded(&self, function: &str) -> Option<&[TakenPath]> {
        let mut functions = self.disassembly.functions_named(PREFIX);
        let (entry, _) = functions.find(|(_, found)| *found == function)?;
        self.recording.get(&entry).map(Vec::as_slice)
    }
}

/// What the measuring program prints (`firmware/cycles/src/main.rs`).
#[derive(Debug, Default)]
pub struct Printed {
    /// Of the motion.
    pub seed: String,
    pub kernels: Vec<Kernel>,
    /// Of the forces, by kernel and run.
    pub checksums: BTreeMap<String, String>,
}

/// A kernel's line.
#[derive(Debug)]
pub struct Kernel {
    name: String,
    blocks: u32,
    calls: u32,
    model_bytes: u32,
    state_bytes: u32,
    error: Option<f64>,
}

impl Kernel {
    fn parse(name: &str, blocks: &str, values: &[&str]) -> Result<Self> {
        let number = |text: &str| text.parse::<u32>();
        Ok(Self {
            name: name.to_string(),
            blocks: number(blocks)?,
            calls: number(value("calls", values)?)?,
            model_bytes: number(value("model", values)?)?,
            state_bytes: number(value("state", values)?)?,
            error: value("error", values)?.parse().ok(),
        })
    }

    /// Its function's name after [`PREFIX`].
    fn function(&self) -> String {
        format!("{}__{}", self.name, self.blocks)
    }
}

impl Printed {
    fn parse(text: &str) -> Result<Self> {
        let mut printed = Self::default();
        for line in text.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            match words[..] {
                ["motion", "seed", seed] => printed.seed = seed.to_string(),
                ["kernel", name, blocks, ref values @ ..] => {
                    let wrong = || format!("`{line}`");
                    let kernel = Kernel::parse(name, blocks, values).with_context(wrong)?;
                    printed.kernels.push(kernel);
                    let checksum = value("checksum", values).with_context(wrong)?.to_string();
                    let forces = format!("{name} {blocks}");
                    printed.checksums.insert(forces, checksum);
                }
                ["agreement", kernel, "steps", steps, "checksum", checksum] => {
                    let forces = format!("{kernel} steps {steps}");
                    printed.checksums.insert(forces, checksum.to_string());
                }
                _ => bail!("the harness printed `{line}`"),
            }
        }
        match printed.ticks() {
            0 => bail!("the harness measured nothing"),
            _ => Ok(printed),
        }
    }

    /// How long the motion was (ticks): every kernel is called once in each.
    pub fn ticks(&self) -> u32 {
        self.kernels.last().map_or(0, |kernel| kernel.calls)
    }
}

/// The word after a name.
fn value<'a>(name: &str, words: &[&'a str]) -> Result<&'a str> {
    let mut pairs = words.chunks_exact(2);
    let found = pairs.find(|pair| pair[0] == name);
    found
        .map(|pair| pair[1])
        .with_context(|| format!("no {name}"))
}

#[cfg(test)]
mod tests {
    use super::Printed;

    #[test]
    fn what_the_program_prints_is_read_and_what_it_does_not_print_is_refused() {
        let kernel = "kernel gms_f32 4 calls 100 model 32 state 16 error 0.25 checksum 0a1b";
        let printed = Printed::parse(&format!(
            "motion seed 7\n{kernel}\nagreement gms_f32 steps 1000000 checksum 22"
        ))
        .unwrap();
        assert_eq!((printed.seed.as_str(), printed.ticks()), ("7", 100));
        assert_eq!(printed.kernels[0].function(), "gms_f32__4");
        assert_eq!(printed.kernels[0].error, Some(0.25));
        assert_eq!(printed.checksums["gms_f32 4"], "0a1b");
        assert_eq!(printed.checksums["gms_f32 steps 1000000"], "22");

        let refused = |text: &str| format!("{:#}", Printed::parse(text).unwrap_err());
        assert!(refused("panicked").contains("printed `panicked`"));
        assert!(refused(&kernel.replace("32 state", "x state")).contains("invalid digit"));
        assert!(refused("motion seed 7").contains("measured nothing"));
    }
}
