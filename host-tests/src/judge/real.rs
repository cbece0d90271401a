//! Real machines in `../shared`: their files with the columns under the tool's names, and what is known of each.
//!
//! What is known is in `../shared/benches/README.md` and in the recordings' own papers. Amperes and volts are read as if one were
//! one newton (metre): no figure of an effort depends on it.

use std::path::PathBuf;

use super::table::{Recording, Table};

/// A machine, how it is read, and what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Name in tables.
    pub name: &'static str,
    /// Files below `../shared`, together one recording.
    pub files: &'static [&'static str],
    /// Text of a model file that lacks a term which the data need.
    pub model: Option<&'static str>,
    /// Columns: the tool's name, the file's, a factor.
    pub columns: &'static [(&'static str, &'static str, f64)],
    /// Effects known to be there, each as the names that are right for it.
    pub known: &'static [&'static [&'static str]],
    /// What must not be named confidently.
    pub absent: &'static [&'static str],
    /// Verdicts that are right besides names; none asked where empty.
    pub verdicts: &'static [&'static str],
}

/// Everything that is friction.
pub const FRICTION: [&str; 12] = [
    "coulomb_asymmetry",
    "stribeck",
    "frictional_lag",
    "position_friction",
    "local_friction_spot",
    "periodic_friction",
    "load_dependent_friction",
    "thermal_drift",
    "run_in",
    "dwell_aging",
    "creep",
    "presliding_shape",
];

type Columns = &'static [(&'static str, &'static str, f64)];
const EMPS: Columns = &[
    ("t_s", "t_s", 1.0),
    ("x_m", "x_m", 1.0),
    ("force_N", "force_N", 1.0),
];
/// Friction is negative while the position grows.
const TRIBOMETER: Columns = &[
    ("t_s", "t_s", 1.0),
    ("x_m", "x_m", 1.0),
    ("force_N", "friction_N", -1.0),
    ("normal_N", "normal_N", 1.0),
];
const JOINT: Columns = &[
    ("t_s", "t_s", 1.0),
    ("q_rad", "joint_q_rad", 1.0),
    ("torque_Nm", "motor_torque_raw", 1.0),
];
/// Motor 6 = 32·(q5 + q6); motor 5 = 45·q5.
const JOINT_6: Columns = &[
    ("t_s", "t_s", 1.0),
    ("q_rad", "qm6_motor_rad", 1.0 / 32.0),
    ("torque_Nm", "torque_or_current6", 1.0),
    ("axis5_rad", "qm5_motor_rad", 1.0 / 45.0),
];
const DAMPER: Columns = &[
    ("t_s", "t_s", 1.0),
    ("x_m", "x_m", 1.0),
    ("force_N", "force_N", 1.0),
];
const SERVO: Columns = &[
    ("t_s", "t_s", 1.0),
    ("q_rad", "q_rad", 1.0),
    ("torque_Nm", "voltage_V", 1.0),
    ("temperature_C", "temp_C", 1.0),
];
const PENDULUM: Columns = &[
    ("t_s", "time", 1.0),
    ("q_rad", "position", 1.0),
    ("torque_Nm", "torque", 1.0),
];
const CURRENT: Columns = &[
    ("t_s", "t_s", 1.0),
    ("q_rad", "q_rad", 1.0),
    ("torque_Nm", "current_iq_A", 1.0),
];

/// A machine of which nothing is stated.
const BARE: Machine = Machine {
    name: "",
    files: &[],
    model: None,
    columns: EMPS,
    known: &[],
    absent: &[],
    verdicts: &[],
};

/// Machines with something known, and the controls, which have no friction.
pub const MACHINES: &[Machine] = &[
    Machine {
        name: "emps",
        files: &["recordings/emps/emps_tracking.csv"],
        // Viscous friction by direction and a ripple of half a turn of its screw: `../shared/design/diagnosis.md`.
        known: &[
            &["constant_force", "coulomb_asymmetry"],
            &["viscous"],
            &["viscous_asymmetry"],
            &["periodic_force"],
        ],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    // Published: 95.1 kg, 203.5 N·s/m, 20.39 N, −3.165 N.
    Machine {
        name: "emps without offset",
        files: &["recordings/emps/emps_tracking.csv"],
        model: Some(
            "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 95.1\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 20.4\nviscous_N_s_per_m = 203.5\n",
        ),
        known: &[&["constant_force", "coulomb_asymmetry"]],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    Machine {
        name: "emps without viscous",
        files: &["recordings/emps/emps_tracking.csv"],
        model: Some(
            "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 95.1\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 20.4\n[[effects]]\nid = \"constant_force\"\nforce_N = -3.165\n",
        ),
        known: &[&["viscous"]],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    // One block that yields after 1e-6 of the travel, where `identify` finds yields of micrometres.
    Machine {
        name: "tribometer, stiff",
        files: &["recordings/tribometer_reciprocating/reciprocating_5N.csv"],
        model: Some(
            "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 0.1\n[friction]\nkind = \"gms\"\nbreakaway_N = 0.6\nblocks = [ { stiffness_N_per_m = 2.6e9, weight = 1.0 } ]\n",
        ),
        columns: TRIBOMETER,
        known: &[&["presliding_shape"]],
        absent: &["gravity", "channel_delay"],
        ..BARE
    },
    Machine {
        name: "tribometer",
        files: &["recordings/tribometer_reciprocating/reciprocating_5N.csv"],
        columns: TRIBOMETER,
        absent: &["gravity", "periodic_force", "channel_delay"],
        ..BARE
    },
    Machine {
        name: "seal_5bar",
        files: &["recordings/pneumatic_seal/O-ring_5bar.csv"],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    Machine {
        name: "gimbal",
        files: &["recordings/laas_cogging/speed_control_b.csv"],
        columns: CURRENT,
        known: &[&["periodic_force"]],
        ..BARE
    },
    Machine {
        name: "joint1",
        files: &["benches/staubli_tx40/joint1_5kHz.csv"],
        columns: JOINT,
        known: &[&["viscous"]],
        absent: &["gravity"],
        ..BARE
    },
    Machine {
        name: "joint4",
        files: &["benches/staubli_tx40/joint4_5kHz.csv"],
        columns: JOINT,
        known: &[&["periodic_force"], &["viscous"]],
        ..BARE
    },
    Machine {
        name: "joint5",
        files: &["benches/staubli_tx40/joint5_5kHz.csv"],
        columns: JOINT,
        known: &[&["viscous"]],
        ..BARE
    },
    Machine {
        name: "joint6",
        files: &["benches/staubli_tx40/all_joints_2500Hz.csv"],
        columns: JOINT_6,
        known: &[&["axis_coupling"]],
        ..BARE
    },
    Machine {
        name: "damper_30lb",
        files: &["benches/brfd_damper/ds2_0.25Hz_30lb_25mm.csv"],
        columns: DAMPER,
        known: &[&["backlash"]],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    Machine {
        name: "damper_35lb",
        files: &["benches/brfd_damper/ds1_0.5Hz_35lb_25mm.csv"],
        columns: DAMPER,
        known: &[&["backlash"]],
        absent: &["gravity", "encoder_error"],
        ..BARE
    },
    Machine {
        name: "servo",
        files: &[
            "benches/bam_xl330/xl330_kp200_lift_and_drop.csv",
            "benches/bam_xl330/xl330_kp200_sin_sin.csv",
            "benches/bam_xl330/xl330_kp200_sin_time_square.csv",
            "benches/bam_xl330/xl330_kp200_up_and_down.csv",
            "benches/bam_xl330/xl330_kp400_lift_and_drop.csv",
            "benches/bam_xl330/xl330_kp400_sin_sin.csv",
            "benches/bam_xl330/xl330_kp400_sin_time_square.csv",
            "benches/bam_xl330/xl330_kp400_up_and_down.csv",
        ],
        columns: SERVO,
        known: &[&["gravity"], &["viscous"], &["load_dependent_friction"]],
        absent: &["constant_force"],
        ..BARE
    },
    Machine {
        name: "pendulum_gravcomp",
        files: &["benches/dfki_pendulum/gravcomp.csv"],
        columns: PENDULUM,
        known: &[&["gravity"]],
        ..BARE
    },
    Machine {
        name: "pendulum_sysid",
        files: &["benches/dfki_pendulum/sysid.csv"],
        columns: PENDULUM,
        verdicts: &["insufficient-data", "unknown-physics"],
        ..BARE
    },
    Machine {
        name: "pendulum_energy",
        files: &["benches/dfki_pendulum/energy.csv"],
        columns: PENDULUM,
        verdicts: &["insufficient-data", "unknown-physics"],
        ..BARE
    },
    Machine {
        name: "outrunner",
        files: &[
            "benches/odrive_cogging/slow_goodgains_2__nocomp_0.csv",
            "benches/odrive_cogging/slow_goodgains_2__nocomp_1.csv",
            "benches/odrive_cogging/slow_goodgains_2__nocomp_2.csv",
        ],
        columns: CURRENT,
        known: &[&["periodic_force"]],
        ..BARE
    },
    Machine {
        name: "silverbox",
        files: &["benches/controls/silverbox_SNLS80mV.csv"],
        columns: &[("x_m", "V2", 1.0), ("force_N", "V1", 1.0)],
        absent: &FRICTION,
        ..BARE
    },
    Machine {
        name: "tanks",
        files: &["benches/controls/cascaded_tanks.csv"],
        columns: &[("x_m", "yEst", 1.0), ("force_N", "uEst", 1.0)],
        absent: &FRICTION,
        verdicts: &["insufficient-data", "unknown-physics"],
        ..BARE
    },
];

/// Sample times (s) of files without a clock.
const CLOCKS: [(&str, f64); 2] = [("silverbox", 1.0 / 610.35), ("tanks", 4.0)];

/// The folder of real machines' data; where it is absent, `None` and a loud line.
pub fn shared() -> Option<PathBuf> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared"));
    if root.join("benches").is_dir() {
        return Some(root);
    }
    eprintln!("SKIPPED: ../shared is absent, and with it every real machine");
    None
}

/// A machine by its name.
pub fn machine(name: &str) -> Option<&'static Machine> {
    MACHINES.iter().find(|machine| machine.name == name)
}

impl Machine {
    /// Its recording.
    ///
    /// # Errors
    /// Where a file or a column is missing.
    pub fn recording(&self) -> Result<Recording, String> {
        let root = shared().ok_or("../shared is absent")?;
        let parts = self.files.iter().map(|file| {
            let read = Table::read(&root.join(file))?;
            let mut table = Table::default();
            for (name, source, factor) in self.columns {
                let at = read
                    .find(source)
                    .ok_or(format!("{file}: no column `{source}`"))?;
                let column = read.columns[at].iter().map(|value| factor * value);
                table.names.push((*name).to_owned());
                table.columns.push(column.collect());
            }
            if let Some((_, step)) = CLOCKS.iter().find(|clock| clock.0 == self.name) {
                let clock = (0..table.len()).map(|i| i as f64 * step).collect();
                table.names.insert(0, "t_s".to_owned());
                table.columns.insert(0, clock);
            }
            Ok(table)
        });
        Ok(Recording {
            name: self.name.to_owned(),
            parts: parts.collect::<Result<_, String>>()?,
            model: self.model.map(str::to_owned),
            arguments: Vec::new(),
        })
    }
}
