//! The effects that a trial can hold: those of the catalogue that one recording can show, and others that
//! are in no catalogue. Here: names, parameters and how they are drawn; what they do is in `friction.rs`
//! and `plant.rs`.
//!
//! Ranges are those of the design ("Parameter ranges to expect on the paper's axis"); an effect without a
//! range there is drawn so that it is as visible as the others. Left out: `lead_error`, which shows only
//! against a reference.

use super::draw::Draw;

/// The table of effects: in the code, in labels, and the parameters in the order of [`Effect::values`].
macro_rules! effects {
    (
        catalogue { $($inside:ident $inside_name:ident: $($inside_key:ident)*;)* }
        outside { $($(#[$doc:meta])* $outside:ident $outside_name:ident: $($outside_key:ident)*;)* }
    ) => {
        /// An effect. The names of the catalogue's are those of the design; the rest is outside it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // the catalogue documents them; those outside it are documented in the table
        pub enum Id {
            $($inside,)*
            $($(#[$doc])* $outside,)*
        }

        /// Effects of the catalogue, in its order.
        pub const CATALOGUE: [Id; 25] = [$(Id::$inside),*];

        /// Effects that are in no catalogue: the right answer is `unknown-physics`.
        pub const OUTSIDE: [Id; 10] = [$(Id::$outside),*];

        impl Id {
            /// Name in the catalogue, or, outside it, in labels only; and the parameters'.
            fn names(self) -> (&'static str, &'static [&'static str]) {
                match self {
                    $(Id::$inside => (stringify!($inside_name), &[$(stringify!($inside_key)),*]),)*
                    $(Id::$outside => (stringify!($outside_name), &[$(stringify!($outside_key)),*]),)*
                }
            }
        }
    };
}

effects! {
catalogue {
    ConstantForce constant_force: force_N;
    CoulombAsymmetry coulomb_asymmetry: asymmetry;
    Viscous viscous: viscous_N_s_per_m;
    QuadraticDrag quadratic_drag: drag_N_s2_per_m2;
    Stribeck stribeck: level velocity_m_s exponent;
    FrictionalLag frictional_lag: level velocity_m_s exponent time_constant_s;
    PositionSpring position_spring: stiffness_N_per_m centre_m;
    PositionForce position_force: bend_N bump_N bump_m bump_width_m;
    PositionFriction position_friction: slope_level bend_level;
    LocalFrictionSpot local_friction_spot: level position_m width_m;
    PeriodicForce periodic_force: force_N period_m phase_rad;
    PeriodicFriction periodic_friction: level period_m phase_rad;
    EncoderError encoder_error: error_m period_m phase_rad;
    Backlash backlash: gap_m;
    DriveCompliance drive_compliance: stiffness_N_per_m frequency_Hz;
    ChannelDelay channel_delay: delay_s;
    ActuatorDeadZone actuator_dead_zone: width_N;
    ActuatorSaturation actuator_saturation: limit_N;
    LoadDependentFriction load_dependent_friction: level_per_N;
    ThermalDrift thermal_drift: level_per_K;
    RunIn run_in: level path_m;
    DwellAging dwell_aging: level_per_decade time_constant_s erasing_path_m;
    Creep creep: rate_m_s share_of_breakaway;
    ExternalVibration external_vibration: force_N frequency_Hz phase_rad;
    PreslidingShape presliding_shape: stiffness_factor;
}
outside {
    /// Bursts of a damped vibration at random times.
    RandomBursts random_bursts: force_N frequency_Hz decay_s mean_interval_s;
    /// A force in the direction of motion that starts at each reversal and relaxes with time, not path.
    RelaxingMemory relaxing_memory: force_N time_constant_s;
    /// A magnetic detent that grows with speed: `A·|v|/(v0 + |v|)·cos(2πx/p)`.
    SpeedDetent speed_detent: force_N period_m phase_rad velocity_m_s;
    /// Friction that is higher when speeding up than when slowing down.
    AccelerationFriction acceleration_friction: level power_m2_s3;
    /// A friction level that switches by the clock, as from a pump or a lubricator nearby.
    TimeOfDay time_of_day: level period_s;
    /// A friction level lowered by the highest speed of the last seconds.
    SpeedHistory speed_history: level velocity_m_s time_constant_s;
    /// Each reversal stirs the grease: the level rises by a step, and a path lets it settle again.
    ReversalChurn reversal_churn: level path_m;
    /// A cage that rattles at one speed: the level is higher in a narrow band of it.
    SpeedBand speed_band: level velocity_m_s width_m_s;
    /// Rollers that slip and never find back: the level waves with the path travelled, whichever way, not with the position.
    PathRipple path_ripple: level path_m phase_rad;
    /// A machine nearby that runs up: a shaking force whose frequency drifts.
    DriftingShake drifting_shake: force_N frequency_Hz rate_Hz_s phase_rad;
}
}

/// Effects that can be confined to one end of the travel.
pub const CORNER: [Id; 6] = [
    Id::CoulombAsymmetry,
    Id::Viscous,
    Id::Stribeck,
    Id::PositionSpring,
    Id::PeriodicForce,
    Id::PeriodicFriction,
];

/// Pairs that occur together on real stages, or are easily taken for each other.
pub const PAIRS: [(Id, Id); 16] = [
    (Id::Stribeck, Id::Viscous),
    (Id::PeriodicForce, Id::Stribeck),
    (Id::PeriodicForce, Id::PeriodicFriction),
    (Id::PositionFriction, Id::Viscous),
    (Id::ConstantForce, Id::Stribeck),
    (Id::PositionSpring, Id::PeriodicForce),
    (Id::LocalFrictionSpot, Id::PositionFriction),
    (Id::ChannelDelay, Id::Viscous),
    (Id::ExternalVibration, Id::PeriodicForce),
    (Id::ThermalDrift, Id::Viscous),
    (Id::EncoderError, Id::PeriodicForce),
    (Id::LoadDependentFriction, Id::PositionFriction),
    (Id::DriveCompliance, Id::Viscous),
    (Id::DwellAging, Id::Stribeck),
    (Id::ConstantForce, Id::PositionSpring),
    (Id::PeriodicFriction, Id::Viscous),
];

impl Id {
    /// Name in the catalogue, or, outside it, in labels only.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    /// Whether the motor's mass and the load's move apart.
    pub fn needs_two_masses(self) -> bool {
        matches!(self, Id::Backlash | Id::DriveCompliance)
    }
}

/// Half, typical or double.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// Half of typical.
    Weak,
    /// The middle of the design's range.
    Typical,
    /// Double of typical.
    Strong,
}

impl Strength {
    /// Multiplies the typical amplitude.
    pub fn factor(self) -> f64 {
        match self {
            Strength::Weak => 0.5,
            Strength::Typical => 1.0,
            Strength::Strong => 2.0,
        }
    }

    /// Name in labels and tables.
    pub fn name(self) -> &'static str {
        match self {
            Strength::Weak => "weak",
            Strength::Typical => "typical",
            Strength::Strong => "strong",
        }
    }
}

/// An effect with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Which one.
    pub id: Id,
    /// Parameters in SI, named by [`Effect::parameters`].
    pub values: [f64; 4],
    /// Position (m) beyond which it acts, towards the end of the travel with the same sign; everywhere without.
    pub corner: Option<f64>,
}

/// Length over which an effect in a corner fades in (m).
const CORNER_EDGE: f64 = 0.3e-3;

impl Effect {
    /// Parameters by name, in SI.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.id.names().1.iter().copied().zip(self.values)
    }

    /// Share of the amplitude that acts at position `x` (m).
    pub fn presence(&self, x: f64) -> f64 {
        match self.corner {
            None => 1.0,
            Some(edge) => 1.0 / (1.0 + (-(x - edge) * edge.signum() / CORNER_EDGE).exp()),
        }
    }

    /// Draws an effect `strength` times as strong as is typical, on an axis with the given half travel (m)
    /// and breakaway force (N). Everything but the amplitude depends on `draw` alone.
    pub fn draw(id: Id, strength: f64, half_travel: f64, breakaway: f64, draw: &mut Draw) -> Self {
        let s = strength * draw.log_uniform(0.8, 1.25);
        let signed = s * draw.sign();
        let phase = draw.uniform(0.0, std::f64::consts::TAU);
        let friction = breakaway / 0.9;
        let values = match id {
            Id::ConstantForce => [0.1 * signed, 0.0, 0.0, 0.0],
            Id::CoulombAsymmetry => [0.07 * signed, 0.0, 0.0, 0.0],
            Id::Viscous => [10.0 * s, 0.0, 0.0, 0.0],
            Id::QuadraticDrag => [150.0 * s, 0.0, 0.0, 0.0],
            Id::Stribeck => [
                0.2 * s,
                draw.log_uniform(0.2e-3, 2e-3),
                draw.uniform(0.7, 2.0),
                0.0,
            ],
            Id::FrictionalLag => [
                0.3 * s,
                draw.log_uniform(1e-3, 4e-3),
                draw.uniform(0.8, 1.5),
                draw.log_uniform(10e-3, 50e-3),
            ],
            Id::PositionSpring => [
                8.0 * s,
                0.3 * half_travel * draw.uniform(-1.0, 1.0),
                0.0,
                0.0,
            ],
            Id::PositionForce => [
                0.06 * signed,
                0.08 * s * draw.sign(),
                half_travel * draw.uniform(-0.6, 0.6),
                half_travel * draw.uniform(0.15, 0.3),
            ],
            Id::PositionFriction => [0.12 * signed, 0.12 * s * draw.uniform(-1.0, 1.0), 0.0, 0.0],
            Id::LocalFrictionSpot => [
                0.35 * s,
                half_travel * draw.uniform(-0.85, 0.85),
                draw.log_uniform(0.2e-3, 1e-3),
                0.0,
            ],
            Id::PeriodicForce => {
                let period = match draw.whole(0, 3) {
                    0 => 2e-3 / 7.0,
                    1 => 2e-3,
                    _ => draw.log_uniform(0.2e-3, 3e-3),
                };
                [0.03 * s, period, phase, 0.0]
            }
            Id::PeriodicFriction => {
                let period = if draw.chance(0.5) {
                    2e-3
                } else {
                    draw.log_uniform(0.8e-3, 5e-3)
                };
                [0.08 * s, period, phase, 0.0]
            }
            Id::EncoderError => {
                let order = draw.whole(1, 3) as f64;
                [0.1e-6 * s, super::ENCODER_PERIOD_M / order, phase, 0.0]
            }
            Id::Backlash => [4e-6 * s, 0.0, 0.0, 0.0],
            // Resonances of about 170, 120 and 85 Hz with 40 % of the mass on the motor's side.
            Id::DriveCompliance => [4.8e5 * draw.uniform(0.8, 1.25) / s, 0.0, 0.0, 0.0],
            Id::ChannelDelay => [1e-3 * s, 0.0, 0.0, 0.0],
            Id::ActuatorDeadZone => [0.1 * s, 0.0, 0.0, 0.0],
            Id::ActuatorSaturation => [breakaway + 1.4 / s.powf(0.4), 0.0, 0.0, 0.0],
            Id::LoadDependentFriction => [0.012 * s, 0.0, 0.0, 0.0],
            Id::ThermalDrift => [-0.015 * s, 0.0, 0.0, 0.0],
            Id::RunIn => [0.12 * s, draw.log_uniform(0.1, 0.4), 0.0, 0.0],
            Id::DwellAging => [
                0.04 * s,
                draw.log_uniform(0.2, 0.6),
                draw.log_uniform(5e-6, 50e-6),
                0.0,
            ],
            Id::Creep => [15e-9 * s, draw.uniform(0.12, 0.2), 0.0, 0.0],
            Id::ExternalVibration => [0.02 * s, draw.log_uniform(2.0, 60.0), phase, 0.0],
            // How far the model's stiffness is off, on top of its two blocks.
            Id::PreslidingShape => [1.0 + s, 0.0, 0.0, 0.0],
            Id::RandomBursts => [
                0.25 * s * friction,
                draw.uniform(15.0, 45.0),
                draw.uniform(0.05, 0.2),
                draw.uniform(0.8, 2.0),
            ],
            Id::RelaxingMemory => [0.15 * s * friction, draw.log_uniform(0.05, 0.4), 0.0, 0.0],
            Id::SpeedDetent => [
                0.12 * s * friction,
                draw.log_uniform(0.4e-3, 3e-3),
                phase,
                draw.log_uniform(2e-3, 8e-3),
            ],
            Id::AccelerationFriction => [0.15 * s, draw.log_uniform(1e-3, 3e-3), 0.0, 0.0],
            Id::TimeOfDay => [0.12 * s, draw.uniform(4.0, 9.0), 0.0, 0.0],
            Id::ReversalChurn => [0.12 * s, draw.log_uniform(2e-3, 8e-3), 0.0, 0.0],
            Id::SpeedBand => {
                let speed = draw.log_uniform(2e-3, 10e-3);
                [0.3 * s, speed, speed * draw.uniform(0.15, 0.3), 0.0]
            }
            Id::PathRipple => [0.15 * s, draw.log_uniform(1e-3, 6e-3), phase, 0.0],
            Id::DriftingShake => [
                0.1 * s * friction,
                draw.uniform(3.0, 10.0),
                draw.uniform(0.05, 0.25),
                phase,
            ],
            Id::SpeedHistory => [
                0.25 * s,
                draw.log_uniform(2e-3, 8e-3),
                draw.uniform(0.5, 2.0),
                0.0,
            ],
        };
        Effect {
            id,
            values,
            corner: None,
        }
    }
}
