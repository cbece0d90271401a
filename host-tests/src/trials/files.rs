//! A trial as the diagnosis gets it: the recording as CSV and the model as TOML.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};

use super::scenario::Scenario;
use super::{ENCODER_PERIOD_M, Trial};
use crate::table::{Recording, Table};

impl Trial {
    /// Writes the recording in the project's format (design, "Recording").
    ///
    /// # Errors
    /// Those of the stream.
    pub fn write_csv(&self, out: impl Write) -> io::Result<()> {
        let mut out = BufWriter::new(out);
        let r = &self.recording;
        write!(out, "t_s,x_m,force_N")?;
        if r.numbered {
            write!(out, ",segment,repeat")?;
        }
        for (name, column) in [
            ("temperature_C", &r.temperature_c),
            ("normal_N", &r.normal_n),
        ] {
            if column.is_some() {
                write!(out, ",{name}")?;
            }
        }
        writeln!(out)?;
        for i in 0..r.t_s.len() {
            // A tenth of a nanometre and of a millinewton: below the count and the noise.
            let (t, x, force) = (r.t_s[i], r.x_m[i], r.force_n[i]);
            write!(out, "{t:.3},{x:.10},{force:.4}")?;
            if r.numbered {
                write!(out, ",{},{}", r.segment[i], r.repeat[i])?;
            }
            for column in [&r.temperature_c, &r.normal_n].into_iter().flatten() {
                write!(out, ",{:.3}", column[i])?;
            }
            writeln!(out)?;
        }
        out.flush()
    }

    /// What the tool is given, for a judge that does not need files.
    pub fn given(&self, name: impl Into<String>) -> Recording {
        let mut text = Vec::new();
        let table = self
            .write_csv(&mut text)
            .map_err(|e| e.to_string())
            .and_then(|()| Table::parse(&String::from_utf8_lossy(&text)));
        let table = table.unwrap_or_else(|e| panic!("a trial that is no table: {e}"));
        Recording::new(name, table, Some(self.model_toml.clone()))
    }
}

/// The model file that a diagnosis starts from: mass and Maxwell-slip blocks, and the known periods.
pub(super) fn model_toml(scenario: &Scenario) -> String {
    let breakaway: f64 = scenario.model_blocks.iter().map(|(_, limit)| limit).sum();
    let mut text = format!(
        "schema = \"preslide.model/1\"\nmotion = \"linear\"\n\n[inertia]\nmass_kg = {:?}\n\n[friction]\nkind = \"gms\"\n\
         breakaway_N = {breakaway:?}\nblocks = [\n",
        scenario.model_mass
    );
    // Rounding must not make the weights add up to more than 1.
    let last = scenario.model_blocks.len().saturating_sub(1);
    let mut left = 1.0;
    for (i, (stiffness, limit)) in scenario.model_blocks.iter().enumerate() {
        let weight = if i == last { left } else { limit / breakaway };
        left -= weight;
        let _ = writeln!(
            text,
            "  {{ stiffness_N_per_m = {stiffness:?}, weight = {weight:?} }},"
        );
    }
    let _ = writeln!(
        text,
        "]\n\n[mechanics]\nscrew_lead_m = 0.002\nencoder_period_m = {ENCODER_PERIOD_M:?}\nencoder_count_m = {:?}",
        scenario.encoder_count
    );
    text
}
