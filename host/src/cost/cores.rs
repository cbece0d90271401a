//! The cores whose costs are known, and how well.

use super::CostTable;

/// How the figures of a core were got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// Counted by the core itself, simulated to the cycle or on a board.
    Exact,
    /// Counted instructions, priced by the core's manual.
    Priced,
}

impl Standing {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Priced => "priced",
        }
    }
}

/// A core, and chips that have it.
#[derive(Debug)]
pub struct Core {
    /// Names on the command line: the core's own, then its chips'.
    pub names: &'static [&'static str],
    /// For people.
    pub title: &'static str,
    /// Rated clock of the chip named first (Hz).
    pub clock: f64,
    /// How well the figures are known.
    pub standing: Standing,
    /// Where they come from.
    origin: &'static str,
    table: &'static str,
}

/// Written by `cargo xtask cycles`.
const CORTEX_M4: &str = include_str!("../../../firmware/cycles/cortex-m4.csv");
/// Written by `cargo xtask cycles --m0plus`.
const CORTEX_M0PLUS: &str = include_str!("../../../firmware/cycles/cortex-m0plus.csv");
/// Written by `cargo xtask cycles --hazard3`.
const HAZARD3: &str = include_str!("../../../firmware/cycles/hazard3-rp2350.csv");

/// The core that figures without a core's name are for.
pub const DEFAULT: &str = "cortex-m4";

/// Every core with figures.
pub const CORES: &[Core] = &[
    Core {
        names: &[DEFAULT, "cortex-m4f", "stm32g4", "stm32f4", "stm32l4"],
        title: "Cortex-M4F (STM32G4)",
        clock: 170e6,
        standing: Standing::Priced,
        origin: "instruction paths from QEMU priced by the Cortex-M4 manual, no wait states, not confirmed on a board",
        table: CORTEX_M4,
    },
    Core {
        names: &["hazard3", "rp2350-riscv"],
        title: "Hazard3 (RP2350, RISC-V)",
        clock: 150e6,
        standing: Standing::Exact,
        origin: "exact: the core's RTL simulated in the RP2350's configuration, no wait states",
        table: HAZARD3,
    },
    Core {
        names: &["cortex-m0+", "cortex-m0plus", "rp2040"],
        title: "Cortex-M0+ (RP2040)",
        clock: 133e6,
        standing: Standing::Priced,
        origin: "instruction paths from QEMU at the one price that the Cortex-M0+ manual has for each instruction, no wait states, not confirmed on a board",
        table: CORTEX_M0PLUS,
    },
];

impl Core {
    /// The core of this name, or of the chip so named.
    ///
    /// # Errors
    /// Why there are no figures, and for which cores there are.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let wanted = name.to_lowercase();
        let is = |names: &[&str]| names.contains(&wanted.as_str());
        if let Some(core) = CORES.iter().find(|core| is(core.names)) {
            return Ok(core);
        }
        let remedy =
            "for another core run firmware/cycles on a board and give its output as --cpu FILE.csv";
        let known: Vec<String> = CORES.iter().map(|core| core.names.join(", ")).collect();
        Err(format!(
            "--cpu {name}: no figures; known are {}, and all for a comparison; {remedy}",
            known.join("; ")
        ))
    }

    /// What its kernels cost.
    ///
    /// # Errors
    /// Line and reason where the committed table cannot be read.
    pub fn costs(&self) -> Result<CostTable, String> {
        let table = CostTable::parse(self.table, self.origin)?;
        Ok(CostTable {
            standing: self.standing,
            ..table
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_fit::kernel::Kernel;

    #[test]
    fn every_core_has_every_kernel_and_effects() {
        for core in CORES {
            let costs = core.costs().unwrap();
            assert_eq!(costs.standing, core.standing, "{}", core.title);
            for kernel in Kernel::ALL {
                for n in [1, 4, 5, 10] {
                    let cost = costs.cost(kernel.name(), n).unwrap();
                    let (mean, worst) = (cost.cycles_mean, cost.cycles_worst);
                    let name = format!("{}, {} N = {n}", core.title, kernel.name());
                    assert!(cost.inlined && mean > 0.0, "{name}: {mean}");
                    assert!(worst >= 0.9 * mean, "{name}: {mean}, worst {worst}");
                }
            }
            for name in ["with_stribeck_f32", "with_viscous_i16f16"] {
                assert!(costs.cost(name, 4).is_some(), "{}: {name}", core.title);
            }
        }
    }

    #[test]
    fn chips_lead_to_their_cores_and_an_unknown_one_lists_them() {
        assert_eq!(Core::named("STM32G4").unwrap().names[0], "cortex-m4");
        assert_eq!(
            Core::named("rp2350-riscv").unwrap().standing,
            Standing::Exact
        );
        let error = Core::named("avr").unwrap_err();
        assert!(
            error.contains("rp2040") && error.contains("--cpu FILE.csv"),
            "{error}"
        );
    }

    /// Without a float unit `f32` is software: the order of the arithmetics turns round.
    #[test]
    fn a_core_without_a_float_unit_pays_for_floats() {
        let ratio = |cpu: &str| {
            let costs = Core::named(cpu).unwrap().costs().unwrap();
            let cycles = |kernel| costs.cost(kernel, 6).unwrap().cycles_mean;
            cycles("gms_f32") / cycles("count_gms_i16f16")
        };
        assert!(ratio("stm32g4") < 2.0, "{}", ratio("stm32g4"));
        for cpu in ["rp2040", "rp2350-riscv"] {
            assert!(ratio(cpu) > 5.0, "{cpu}: {}", ratio(cpu));
        }
    }
}
