//! The linear part of the stage, solved exactly over one step.
//!
//! ```text
//! L·di/dt   = V − R·i − K·v_r                        K = k_t·N·2π/lead  [N/A = V·s/m]
//! dq/dt     = v_r − v                                q = rotor − mass, at the stage
//! M_r·dv_r/dt = K·i − k·q − c·(v_r − v) − d·v_r       M_r = J·(N·2π/lead)²
//! m·dv/dt   = k·q + c·(v_r − v) − b·v                dx/dt = v
//! ```
//! With the voltage held, the flow over a step is a constant matrix: it has no step-size error, however stiff the winding
//! (22 µs) or the coupling.

use std::f64::consts::TAU;

use nalgebra::SMatrix;

use super::config::StageConfig;

/// Current \[A\], rotor lead q \[m\], rotor velocity [m/s], mass velocity [m/s]: the first four states of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LinearState {
    pub(super) current_a: f64,
    pub(super) lead_m: f64,
    pub(super) rotor_m_s: f64,
    pub(super) velocity_m_s: f64,
}

/// Coefficients of the equations above, at the stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients {
    /// K [N/A].
    pub(super) force_constant: f64,
    /// M_r \[kg\].
    pub(super) rotor_kg: f64,
    /// d [N·s/m].
    pub(super) rotor_damping: f64,
}

impl Coefficients {
    pub(super) fn new(config: &StageConfig) -> Self {
        let turns = config.drive.gear_ratio * TAU / config.drive.screw_lead_m;
        Self {
            force_constant: config.motor.torque_constant_nm_per_a * turns,
            rotor_kg: config.motor.rotor_inertia_kg_m2 * turns * turns,
            rotor_damping: config.motor.damping_nm_s_per_rad * turns * turns,
        }
    }
}

/// The flow of the linear part over one step. Where the electrical stage solves the winding, the current is held instead: its
/// mean over the step acts.
#[derive(Debug, Clone)]
pub(super) struct Flow {
    /// Rows: the four states and dx; columns: the four states and the voltage.
    rows: [[f64; 5]; 5],
}

impl Flow {
    pub(super) fn new(config: &StageConfig, k: &Coefficients, step_s: f64) -> Self {
        let (motor, drive) = (&config.motor, &config.drive);
        let (stiffness, damping) = (drive.stiffness_n_per_m, drive.damping_n_s_per_m);
        let (l, m) = (motor.inductance_h, config.mass_kg);
        // States i, q, v_r, v, x and the held voltage.
        let mut a = SMatrix::<f64, 6, 6>::zeros();
        if config.electrical.is_none() {
            a[(0, 0)] = -motor.resistance_ohm / l;
            a[(0, 2)] = -k.force_constant / l;
            a[(0, 5)] = 1.0 / l;
        }
        a[(1, 2)] = 1.0;
        a[(1, 3)] = -1.0;
        a[(2, 0)] = k.force_constant / k.rotor_kg;
        a[(2, 1)] = -stiffness / k.rotor_kg;
        a[(2, 2)] = -(damping + k.rotor_damping) / k.rotor_kg;
        a[(2, 3)] = damping / k.rotor_kg;
        a[(3, 1)] = stiffness / m;
        a[(3, 2)] = damping / m;
        a[(3, 3)] = -(damping + config.friction.viscous_n_s_per_m) / m;
        a[(4, 3)] = 1.0;
        let flow = (a * step_s).exp();
        let columns = [0, 1, 2, 3, 5];
        Self {
            rows: std::array::from_fn(|row| columns.map(|column| flow[(row, column)])),
        }
    }

    /// The state one step on, and the displacement of the mass \[m\].
    pub(super) fn step(&self, s: LinearState, voltage_v: f64) -> (LinearState, f64) {
        let input = [
            s.current_a,
            s.lead_m,
            s.rotor_m_s,
            s.velocity_m_s,
            voltage_v,
        ];
        let [current_a, lead_m, rotor_m_s, velocity_m_s, dx] = self
            .rows
            .map(|row| row.iter().zip(&input).map(|(a, x)| a * x).sum::<f64>());
        let next = LinearState {
            current_a,
            lead_m,
            rotor_m_s,
            velocity_m_s,
        };
        (next, dx)
    }
}
