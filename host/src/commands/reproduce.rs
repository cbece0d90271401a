//! `preslide reproduce`.

use super::{Failure, OutputArgs, command_line};
use clap::Args;
use preslide_host::progress::Progress;
use preslide_host::reproduce::{STEPS, reproduce};
use std::time::Instant;

/// The paper's Table 3 and Figures 7–8 from its own parameters, beside what optimal breakpoints reach
#[derive(Args)]
#[command(
    after_help = "Example: preslide reproduce --report reproduction.html\n\nDisplacements are in m, forces in N, NMSE in %."
)]
pub struct Reproduce {
    #[command(flatten)]
    outputs: OutputArgs,
}

impl Reproduce {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        let start = Instant::now();
        let progress = Progress::new("reproduce", STEPS);
        let found = reproduce(&progress).map_err(Failure::Tool)?;
        progress.finish();
        for table in [
            found.size_table(),
            found.recovery_table(),
            found.column_table(),
            found.closure_table(),
        ] {
            say!("{}", table.to_text());
        }
        for remark in found.remarks() {
            say!("Note: {remark}.");
        }
        say!("{}", found.recommendation);
        let seconds = start.elapsed().as_secs_f64();
        self.outputs
            .write(&found.to_json(seconds), || found.page(command_line()))
    }
}
