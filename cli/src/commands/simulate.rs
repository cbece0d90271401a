//! `preslide simulate`.

use super::{Failure, OutputArgs, ReadingArgs, command_line, outputs, parse_frequency, write_text};
use clap::{ArgGroup, Args};
use preslide_fit::model::Model;
use preslide_fit::recording::Needs;
use preslide_fit::simulate::closed::{Controller, motion_in_loop};
use preslide_fit::simulate::ramp::{Ramp, parse_ramp};
use preslide_fit::simulate::{Simulation, force_of_motion, motion_of_force, motion_with_inertia};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Compute the force that a motion takes, or the motion under a force or a controller
#[derive(Args)]
#[command(
    after_help = "Example: preslide simulate model.toml --motion axis.csv --report simulation.html\n         preslide simulate model.toml --reference plan.csv --controller gains.toml"
)]
#[command(group = ArgGroup::new("input").required(true).args(["motion", "force", "reference", "ramp"]))]
pub struct Simulate {
    /// Model file, as `identify` writes it
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,

    /// Motion → force: t_s and x_m or q_rad; an effort, if any, is compared
    #[arg(long, value_name = "REC")]
    motion: Option<PathBuf>,

    /// Force → motion: t_s and force_N or torque_Nm; with inertia, friction and every effect, or quasi-static if the model has no
    /// inertia. A position, if any, starts the motion and is compared
    #[arg(long, value_name = "REC")]
    force: Option<PathBuf>,

    /// Measured positions that --force starts from
    #[arg(long, value_name = "SAMPLES", default_value_t = 20, requires = "force")]
    given: usize,

    /// Reference → motion in closed loop, with --controller: t_s and x_ref_m or q_ref_rad, compared with x_m or q_rad; without a
    /// reference column these are the reference
    #[arg(long, value_name = "REC", requires = "controller")]
    reference: Option<PathBuf>,

    /// Gains of the controller for --reference: schema = "preslide.controller/1", rate_Hz, proportional_N_per_m, limit_N, and
    /// integral_N_per_m_s, derivative_N_s_per_m, deadband_m if need be
    #[arg(long, value_name = "GAINS.toml", requires = "reference")]
    controller: Option<PathBuf>,

    /// Quasi-static, through these forces (N or N·m) at a constant rate (per second): "0,0.9,0,0.6,-0.9@0.01"
    #[arg(long, value_name = "FORCES@RATE", value_parser = parse_ramp, allow_hyphen_values = true)]
    ramp: Option<Ramp>,

    /// Samples per second of --ramp (Hz)
    #[arg(long, value_name = "HZ", default_value = "10Hz", value_parser = parse_frequency, conflicts_with_all = ["motion", "force", "reference"])]
    rate: f64,

    #[command(flatten)]
    reading: ReadingArgs,

    /// Write the simulated recording
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,

    #[command(flatten)]
    outputs: OutputArgs,
}

impl Simulate {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let inputs = [
            Some(&self.model),
            self.motion.as_ref(),
            self.force.as_ref(),
            self.reference.as_ref(),
            self.controller.as_ref(),
        ];
        let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
        outputs::check(
            &inputs,
            &[("-o", self.output.as_ref())],
            Some(&self.outputs),
        )?;
        let model = Model::load(&self.model)?;
        let (found, name) = self.simulate(&model)?;

        explain!("{}", found.table().to_text());
        for note in &found.notes {
            explain!("Note: {note}.");
        }
        if let Some(path) = &self.output {
            write_text(path, &found.to_csv())?;
        }
        let seconds = start.elapsed().as_secs_f64();
        self.outputs.write(&found.to_json(&model, seconds), || {
            found.page(&name, command_line())
        })?;
        if found.breakaway.is_some() {
            return Err(Failure::Data(format!("{name}: {}", found.conclusion())));
        }
        explain!("{}", found.conclusion());
        let compared = self.motion.as_ref().or(self.force.as_ref());
        let compared =
            compared.filter(|_| found.agreement.is_some() || found.position_error.is_some());
        say!(
            "Next: {}",
            match compared {
                Some(path) =>
                    self.reading
                        .command("diagnose", std::slice::from_ref(path), Some(&self.model)),
                None => {
                    let motion: Vec<PathBuf> = self.motion.iter().cloned().collect();
                    self.reading.export(&motion, &self.model, &[])
                }
            }
        );
        Ok(())
    }

    fn simulate(&self, model: &Model) -> Result<(Simulation, String), Failure> {
        if let Some(path) = &self.motion {
            let recording = self
                .reading
                .load(std::slice::from_ref(path), Needs::Motion)?;
            let found = force_of_motion(model, &recording).map_err(Failure::Input)?;
            return Ok((found, recording.name));
        }
        if let (Some(path), Some(gains)) = (&self.reference, &self.controller) {
            let controller = Controller::load(gains).map_err(Failure::Input)?;
            let recording = self
                .reading
                .load(std::slice::from_ref(path), Needs::Motion)?;
            let found = motion_in_loop(model, &recording, &controller).map_err(Failure::Input)?;
            return Ok((found, recording.name));
        }
        if let Some(path) = &self.force {
            let recording = self
                .reading
                .load(std::slice::from_ref(path), Needs::Effort)?;
            if recording.kind != model.motion {
                return Err(Failure::Input(format!(
                    "{}: the effort is that of a {} axis, the model is {}; use a model of the same axis, or --map with the ratio of the drive",
                    recording.name,
                    recording.kind.name(),
                    model.motion.name()
                )));
            }
            if model.inertia > 0.0 {
                let found =
                    motion_with_inertia(model, &recording, self.given).map_err(Failure::Input)?;
                return Ok((found, recording.name));
            }
            let found = motion_of_force(
                model,
                &recording.t_s,
                &recording.effort,
                recording.sample_time_s(),
            )
            .map_err(Failure::Input)?;
            return Ok((found, recording.name));
        }
        // The argument group sees to it that one of the three is given.
        let Some(ramp) = &self.ramp else {
            return Err(Failure::Input(
                "give --motion, --force or --ramp".to_owned(),
            ));
        };
        let (t_s, force) = ramp.samples(self.rate).map_err(Failure::Input)?;
        let found =
            motion_of_force(model, &t_s, &force, 1.0 / self.rate).map_err(Failure::Input)?;
        Ok((found, "force ramp".to_owned()))
    }
}
