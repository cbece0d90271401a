//! `preslide tune`.

use super::{
    AxisArgs, Failure, OutputArgs, ReadingArgs, SplitArgs, command_line, of_axis, outputs,
    parse_clock, parse_frequency, thin,
};
use clap::Args;
use preslide_drive::quantity::{self, Quantity};
use preslide_fit::identify::{MANY, identify};
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::Needs;
use preslide_fit::report::Page;
use preslide_host::cost::{CORES, Core, CostTable, DEFAULT};
use preslide_host::tune::cores::{Comparison, OnCore, budget_on};
use preslide_host::tune::observer::{DEMANDS, Known, Proposal, propose, take_mass};
use preslide_host::tune::{Budget, Choice, TOO_COARSE, Tuning, of_model, of_recording};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Choose number of blocks and arithmetic for a cycle budget
#[derive(Args)]
#[command(
    after_help = "Example: preslide tune model.toml --recording axis.csv --count 25e-9 --clock 170MHz --rate 20kHz --budget 5%"
)]
pub struct Tune {
    /// Model to run, with its number of blocks unless a recording is given
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,

    /// Identify every number of blocks on this recording and tune those
    #[arg(long, value_name = "REC")]
    recording: Vec<PathBuf>,

    #[command(flatten)]
    reading: ReadingArgs,

    #[command(flatten)]
    split: SplitArgs,

    /// Core or chip whose costs to use: cortex-m4 (stm32g4), hazard3 (rp2350-riscv), cortex-m0+ (rp2040);
    /// all compares them; or a table of costs measured on your own board, in the columns of firmware/cycles/cortex-m4.csv
    #[arg(
        long,
        visible_alias = "table",
        default_value = DEFAULT,
        value_name = "CORE, all or FILE.csv"
    )]
    cpu: String,

    /// Core clock [default: the core's rated one; 170 MHz for your own table]
    #[arg(long, value_name = "FREQUENCY", value_parser = parse_clock)]
    clock: Option<f64>,

    /// Control rate
    #[arg(long, value_name = "HZ", default_value = "20kHz", value_parser = parse_frequency)]
    rate: f64,

    /// Share of the processor that friction may take
    #[arg(long, default_value = "5%", value_parser = parse_percent)]
    budget: f64,

    /// Length of an encoder count, such as 25nm, 2.5urad or 25e-9 (m or rad); without it, encoder_count_m of the model's [mechanics]
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_length)]
    count: Option<Quantity>,

    /// First mode of the drive (rotor against load): propose an observer's gains too; needs a Maxwell-slip model and --axis
    #[arg(long, value_name = "FREQUENCY", value_parser = parse_frequency)]
    resonance: Option<f64>,

    /// Damping ratio of that mode
    #[arg(long, default_value = "3%", value_parser = parse_percent, requires = "resonance")]
    damping: f64,

    /// Noise of the encoder beside its resolution, RMS, such as 5nm
    #[arg(long, value_name = "LENGTH", value_parser = quantity::positive_length, requires = "resonance")]
    noise: Option<Quantity>,

    #[command(flatten)]
    axis: AxisArgs,

    #[command(flatten)]
    outputs: OutputArgs,
}

/// Every core beside each other, in place of a core's name.
const ALL: &str = "all";

/// Share of the processor that friction may take, where none is given.
pub(super) const SHARE: f64 = 0.05;

/// No encoder has so long a count (m or rad): a unit was left out.
const LONGEST: f64 = 0.1;

/// Length of an encoder count (m or rad): as given, or else from the model in `file`.
pub(super) fn count_of(
    known: Option<&Quantity>,
    model: &Model,
    file: &Path,
) -> Result<f64, Failure> {
    let count = known.map(|known| known.value).or(model.count()).ok_or_else(|| {
        Failure::Input(format!(
            "{}: how long is an encoder count? Give --count, such as 25nm, or encoder_count_m under [mechanics] of the model",
            file.display()
        ))
    })?;
    if !(count > 0.0 && count < LONGEST) {
        return Err(Failure::Input(format!(
            "--count {count}: an encoder's count is above 0 and below {LONGEST} m or rad; give its unit, such as 25nm"
        )));
    }
    Ok(count)
}

/// Costs of a core or of a file's table, and the budget: `clock` (Hz) or the core's own, `rate` (Hz) and `share` (-).
pub(super) fn plan(
    cpu: &str,
    clock: Option<f64>,
    rate: f64,
    share: f64,
) -> Result<(CostTable, Budget), String> {
    let costs = CostTable::of_cpu_or_file(cpu)?;
    // A table of one's own says nothing about a clock.
    let core = Core::named(cpu).or_else(|_| Core::named(DEFAULT))?;
    Ok((costs, budget_on(core, clock, rate, share)))
}

/// `5%` or `0.05`.
pub fn parse_percent(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let share = number.trim().parse::<f64>().map(|value| value * scale);
    match share {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err("give a share above 0 and up to 100%, such as 5%".to_owned()),
    }
}

/// What is said of an observer.
struct Observed {
    /// Where its numbers come from.
    note: String,
    /// Its gains, or why there are none.
    proposal: Result<Proposal, String>,
}

impl Observed {
    fn outcome(&self) -> Result<(), String> {
        self.proposal.as_ref().map(|_| ()).map_err(Clone::clone)
    }
}

impl Tune {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let inputs = std::iter::once(&self.model).chain(&self.recording);
        let mut inputs: Vec<&Path> = inputs.map(PathBuf::as_path).collect();
        inputs.extend(self.axis.file());
        outputs::check(&inputs, &[], Some(&self.outputs))?;
        let model = Model::load(&self.model)?;
        of_axis(
            &model,
            &self.model,
            &[
                ("--count", self.count.as_ref()),
                ("--noise", self.noise.as_ref()),
            ],
        )?;
        let plans = self.plans().map_err(Failure::Input)?;
        let count = count_of(self.count.as_ref(), &model, &self.model)?;
        let observer = self.observer(&model, count)?;
        let observer = observer.as_ref();
        let mut tunings = Vec::new();
        if self.recording.is_empty() {
            for (costs, budget) in &plans {
                tunings.push(of_model(&model, count, costs, *budget).map_err(Failure::Input)?);
            }
        } else {
            let recording = thin(self.reading.load(&self.recording, Needs::Both)?, MANY);
            model.check_fits(&recording).map_err(Failure::Input)?;
            let options = self.split.options(&recording)?;
            let progress = Progress::new("tune", 20);
            let found = identify(&recording, &options, &progress).map_err(Failure::Data)?;
            progress.finish();
            for (costs, budget) in &plans {
                let tuning = of_recording(&recording, &found, &model, count, costs, *budget);
                tunings.push(tuning.map_err(Failure::Data)?);
            }
        }
        let blocks = if self.cpu == ALL {
            self.compare(tunings, observer, start)
        } else {
            tunings
                .into_iter()
                .try_for_each(|tuning| self.present(&tuning, observer, start))
        };
        // The blocks have their answer without an observer, which is a question of its own.
        let observer = observer.map_or(Ok(()), Observed::outcome);
        match (blocks, observer) {
            (Err(Failure::Data(blocks)), Err(observer)) => {
                Err(Failure::Data(format!("{blocks}\n{observer}")))
            }
            (Err(blocks), _) => Err(blocks),
            (Ok(()), observer) => observer.map_err(Failure::Data),
        }
    }

    /// The observer's gains, where a resonance is given.
    fn observer(&self, model: &Model, count: f64) -> Result<Option<Observed>, Failure> {
        let Some(mode_hz) = self.resonance else {
            return Ok(None);
        };
        let Some(file) = self.axis.chosen() else {
            return Err(Failure::Input(
                "--resonance: an observer's gains follow from the gains, the motor and the limits of your axis; name its description with --axis AXIS.toml or PRESLIDE_AXIS (copy axis.toml from the root of the project and replace its numbers, those marked first)".to_owned(),
            ));
        };
        let file = file.display().to_string();
        let mut axis = self.axis.read()?.axis();
        let in_model =
            |reason: String| Failure::Input(format!("{}: {reason}", self.model.display()));
        let note = take_mass(&mut axis, model, &file).map_err(in_model)?;
        axis.encoder.count = count;
        let known = Known {
            noise: self.noise.as_ref().map_or(0.0, |noise| noise.value),
            mode_damping: self.damping,
            ..Known::of_model(model, mode_hz).map_err(in_model)?
        };
        let proposal = propose(&axis, &known, &DEMANDS);
        Ok(Some(Observed {
            note,
            proposal: proposal.map_err(|reason| format!("{file}: {reason}")),
        }))
    }

    /// JSON and page, with the observer where there is one.
    fn write(
        &self,
        mut json: serde_json::Value,
        page: impl FnOnce() -> Page,
        observer: Option<&Observed>,
    ) -> Result<(), Failure> {
        let proposal = observer.and_then(|observer| observer.proposal.as_ref().ok());
        if let Some(proposal) = proposal {
            explain!("{}", proposal.table().to_text());
            json["observer"] = proposal.to_json();
        }
        self.outputs.write(&json, || {
            let mut page = page();
            page.sections.extend(proposal.map(Proposal::section));
            page
        })?;
        if let Some(observer) = observer {
            explain!("{}.", observer.note);
        }
        if let Some(proposal) = proposal {
            explain!("{}.", proposal.recommendation());
        }
        Ok(())
    }

    /// Costs and budget of each requested core.
    fn plans(&self) -> Result<Vec<(CostTable, Budget)>, String> {
        let on = |core| budget_on(core, self.clock, self.rate, self.budget);
        if self.cpu == ALL {
            return CORES
                .iter()
                .map(|core| Ok((core.costs()?, on(core))))
                .collect();
        }
        Ok(vec![plan(&self.cpu, self.clock, self.rate, self.budget)?])
    }

    /// The command that writes what was chosen: the kernel, or first a model of so many blocks.
    fn next(&self, chosen: &Choice) -> String {
        if !self.recording.is_empty() {
            let identify = self.reading.command("identify", &self.recording, None);
            return format!("{identify} --blocks {} -o model.toml", chosen.cost.blocks);
        }
        let kernel = ["--kernel", chosen.kernel.name()].map(str::to_owned);
        self.reading.export(&[], &self.model, &kernel)
    }

    fn present(
        &self,
        tuning: &Tuning,
        observer: Option<&Observed>,
        start: Instant,
    ) -> Result<(), Failure> {
        explain!("{}", tuning.table().to_text());
        for note in &tuning.notes {
            explain!("Note: {note}.");
        }
        let seconds = start.elapsed().as_secs_f64();
        let page = || tuning.page(command_line());
        self.write(tuning.to_json(seconds), page, observer)?;
        match &tuning.recommended {
            Ok((best, _)) => {
                explain!("{}", tuning.recommendation());
                if let Some(chosen) = tuning.choices.get(*best) {
                    say!("Next: {}", self.next(chosen));
                }
                Ok(())
            }
            Err(reason) => Err(Failure::Data(reason.clone())),
        }
    }

    fn compare(
        &self,
        tunings: Vec<Tuning>,
        observer: Option<&Observed>,
        start: Instant,
    ) -> Result<(), Failure> {
        let on = |(core, tuning)| OnCore { core, tuning };
        let comparison = Comparison {
            cores: CORES.iter().zip(tunings).map(on).collect(),
        };
        explain!("{}", comparison.table().to_text());
        for note in comparison.notes() {
            explain!("Note: {note}.");
        }
        let seconds = start.elapsed().as_secs_f64();
        let page = || comparison.page(command_line());
        self.write(comparison.to_json(seconds), page, observer)?;
        if comparison.fits() {
            return Ok(());
        }
        // Counts are too coarse for every core, and no rate or budget mends that.
        let coarse = comparison.cores.iter().map(|on| &on.tuning);
        let mut coarse = coarse.filter(|tuning| tuning.counting > TOO_COARSE);
        if let Some(Err(reason)) = coarse.next().map(|tuning| &tuning.recommended) {
            return Err(Failure::Data(reason.clone()));
        }
        Err(Failure::Data(
            "nothing fits on any core; lower --rate or allow more --budget".to_owned(),
        ))
    }
}
