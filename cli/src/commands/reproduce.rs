//! `preslide reproduce`.

use super::{Failure, OutputArgs, command_line};
use clap::Args;
use preslide_fit::progress::Progress;
use preslide_sim::reproduce::experiment::SEED;
use preslide_sim::reproduce::{STEPS, literal, reproduce};
use std::time::Instant;

/// Reproduce the paper's Tables 2–3, Figures 6–8 and experiment, beside what optimal breakpoints reach
#[derive(Args)]
#[command(
    after_help = "Example: preslide reproduce --report reproduction.html\n\nDisplacements are in m, forces in N, NMSE in %."
)]
pub struct Reproduce {
    /// Seed of the experiment's simulated repeats
    #[arg(long, value_name = "N", default_value_t = SEED)]
    seed: u64,
    #[command(flatten)]
    outputs: OutputArgs,
}

impl Reproduce {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let progress = Progress::new("reproduce", STEPS);
        let found = reproduce(self.seed, &progress).map_err(Failure::Tool)?;
        progress.finish();
        let of_paper = [
            found.size_table(),
            found.recovery_table(),
            found.column_table(),
            literal::table(&found.literal),
        ];
        let more = [found.figure_6.tables(), found.experiment.tables()];
        for table in of_paper.iter().chain(more.iter().flatten()) {
            explain!("{}", table.to_text());
        }
        for remark in found.remarks() {
            explain!("Note: {remark}.");
        }
        explain!("Note: {}.", literal::remark(&found.literal));
        for remark in found.figure_6.remarks() {
            explain!("Note: {remark}.");
        }
        explain!("{}.", found.experiment.answer());
        explain!("{}", found.recommendation);
        let seconds = start.elapsed().as_secs_f64();
        self.outputs
            .write(&found.to_json(seconds), || found.page(command_line()))
    }
}
