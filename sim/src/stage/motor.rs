//! The motor of the stage.

use serde::{Deserialize, Serialize};

/// A brushed DC motor. Faulhaber 1724 006 SR (paper, Table 1).
///
/// Its sheet was not found in public text; the values are assumptions of the right size beside the sheets of its
/// neighbours: 1524 T 006 SR has 5.1 Ω, 6.0 mN·m/A, 110 µH, 0.58 g·cm²; 1331 T 006 SR has 2.83 Ω, 5.35 mN·m/A, 70 µH,
/// 0.71 g·cm².
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorConfig {
    /// Winding resistance \[Ω\]. 3.41: assumption, see above.
    pub resistance_ohm: f64,
    /// Winding inductance \[H\]. 75 µH: assumption, see above.
    pub inductance_h: f64,
    /// Torque constant [N·m/A], equal to the back-EMF constant [V·s/rad]. 6.59 mN·m/A: assumption, see above.
    pub torque_constant_nm_per_a: f64,
    /// Rotor inertia [kg·m²]. 1 g·cm²: assumption, see above.
    pub rotor_inertia_kg_m2: f64,
    /// Viscous damping of the rotor, beside the back-EMF [N·m·s/rad]. 0: assumption; losses are in the friction truth.
    pub damping_nm_s_per_rad: f64,
}

impl Default for MotorConfig {
    fn default() -> Self {
        Self {
            resistance_ohm: 3.41,
            inductance_h: 75e-6,
            torque_constant_nm_per_a: 6.59e-3,
            rotor_inertia_kg_m2: 1e-7,
            damping_nm_s_per_rad: 0.0,
        }
    }
}
