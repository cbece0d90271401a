//! A proposal for people and for machines.

use super::{DEMANDS, Proposal};
use preslide_fit::model::keys_of;
use preslide_fit::report::{Section, Table};
use serde_json::{Value, json};

/// A number of five digits: of a stage a gain is some 10⁵, of a small joint 1.
fn five(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

impl Proposal {
    /// What to write into the axis's description and the program.
    pub fn recommendation(&self) -> String {
        let s = &self.settings;
        format!(
            "Observer: set the integral gain to 0 and build the controller with ObserverSettings {{ position: {:?}, velocity: {:?}, disturbance: {:?}, mass: {:?}, braking: {:?}, limit: {:?}, top_speed: {:?} }}",
            five(s.position),
            five(s.velocity),
            five(s.disturbance),
            five(s.mass),
            five(s.braking),
            s.limit,
            s.top_speed
        )
    }

    /// Every case with its margins.
    pub fn table(&self) -> Table {
        let factor = |sign: &str, value: f64| match value.is_finite() {
            true => format!("{sign}{value:.2}"),
            false => "to none".to_owned(),
        };
        Table::of(format!(
                "The loop with the observer; required in every case: ×{} and ÷{} of gain, {}° of phase, at most {} at the drive's first mode",
                DEMANDS.gain, DEMANDS.gain, DEMANDS.phase_deg, DEMANDS.at_mode
            ), &self.cases).column("case", |(case, _)| case.name.clone()).column("gain may grow", |(_, m)| factor("×", m.gain)).column("may shrink", |(_, m)| factor("÷", m.reduction)).column("phase [°]", |(_, m)| format!("{:.1}", m.phase_deg)).column("crossover [Hz]", |(_, m)| format!("{:.0}", m.crossover_hz)).column("gain at the mode", |(_, m)| format!("{:.2}", m.at_mode)).column("peak of the sensitivity", |(_, m)| {
                    format!("{:.2}", 1.0 / m.distance)
                }).table()
    }

    /// The page's section.
    pub fn section(&self) -> Section {
        Section {
            heading: "Observer".to_owned(),
            paragraphs: vec![self.recommendation()],
            tables: vec![self.table()],
            figures: Vec::new(),
        }
    }

    /// For `preslide.tuning/1`.
    pub fn to_json(&self) -> Value {
        let s = &self.settings;
        let unbounded = |value: f64| value.is_finite().then_some(value);
        let cases = self.cases.iter().map(|(case, margins)| {
            json!({
                "case": case.name,
                "mass_kg": case.machine.mass,
                "contact_stiffness_N_per_m": case.machine.contact,
                "delay_ticks": case.machine.delay,
                "gain_margin": unbounded(margins.gain),
                "gain_reduction": unbounded(margins.reduction),
                "phase_deg": margins.phase_deg,
                "crossover_Hz": margins.crossover_hz,
                "gain_at_mode": margins.at_mode,
                "sensitivity_peak": 1.0 / margins.distance,
            })
        });
        let answer = json!({
            "position_gain": s.position,
            "velocity_gain_per_s": s.velocity,
            "disturbance_gain_N_per_m": s.disturbance,
            "mass_kg": s.mass,
            "braking_N_s_per_m": s.braking,
            "limit_N": s.limit,
            "top_speed_m_s": s.top_speed,
            "integral_gain_N_per_m_s": self.gains.integral,
            "walk_N2_per_s": self.belief.walk,
            "cases": cases.collect::<Vec<_>>(),
        });
        keys_of(self.motion, answer)
    }
}
