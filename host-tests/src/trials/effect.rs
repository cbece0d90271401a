//! The effects that a trial can hold: those of the catalogue that one recording can show, and others that
//! are in no catalogue; one row each, of its name, its parameters, how these are drawn, and what it does. What remembers the past is in
//! `friction.rs`, what acts between command and encoder in `plant.rs`. Below, those that can be added to real recordings.
//!
//! Ranges are those of the design ("Parameter ranges to expect on the paper's axis"); an effect without a
//! range there is drawn so that it is as visible as the others. Left out: `lead_error`, which shows only
//! against a reference.

use std::f64::consts::TAU;

use super::draw::Draw;

/// What the effects of an instant make of the hysteresis: its level (-), that level's difference between the two directions
/// (-), and the force (N) beside it.
pub struct Acting {
    /// The level.
    pub level: f64,
    /// Half of the difference.
    pub tilt: f64,
    /// The force.
    pub added: f64,
}

impl Acting {
    /// Without effects.
    pub const NONE: Self = Self {
        level: 1.0,
        tilt: 0.0,
        added: 0.0,
    };
}

/// What effects may know of an instant.
#[derive(Clone, Copy)]
pub struct Present<'a> {
    /// Time (s).
    pub t: f64,
    /// Position (m).
    pub x: f64,
    /// Velocity (m/s).
    pub v: f64,
    /// Temperature above the nominal one (K).
    pub warmer: f64,
    /// Preload above the nominal one (N).
    pub loaded: f64,
    /// Half of the travel (m), which is about 0.
    pub half_travel: f64,
    /// When [`Id::RandomBursts`] start (s).
    pub bursts: &'a [f64],
    /// Share of an effect that acts here, and the [corner](Effect::corner) that it is confined to.
    pub here: f64,
    /// See `here`.
    pub corner: Option<f64>,
}

impl Present<'_> {
    fn speed(&self) -> f64 {
        self.v.abs()
    }

    /// From −1 to 1.
    fn along(&self) -> f64 {
        self.x / self.half_travel
    }

    /// From 1 at the ends to −1/2 in the middle.
    fn bend(&self) -> f64 {
        let xi = self.along();
        1.5 * xi * xi - 0.5
    }

    fn wave(&self, period: f64, phase: f64) -> f64 {
        (TAU * self.x / period + phase).cos()
    }
}

fn bell(away: f64) -> f64 {
    (-away * away).exp()
}

/// What parameters are made of.
struct Drawn<'a> {
    /// Times typical, and the same of either sign.
    s: f64,
    signed: f64,
    /// An angle (rad).
    phase: f64,
    half_travel: f64,
    breakaway: f64,
    /// Breakaway over its usual value.
    friction: f64,
    draw: &'a mut Draw,
}

/// An effect of the table.
struct Row {
    /// In the catalogue, or, outside it, in labels only.
    name: &'static str,
    keys: &'static [&'static str],
    /// Its values, in the order of the keys.
    drawn: fn(&mut Drawn) -> Vec<f64>,
    acts: Acts,
}

/// What an effect of such values adds at an instant.
type Acts = fn([f64; 4], &Present, &mut Acting);

impl Row {
    const fn of(
        name: &'static str,
        keys: &'static [&'static str],
        drawn: fn(&mut Drawn) -> Vec<f64>,
    ) -> Self {
        Self {
            name,
            keys,
            drawn,
            acts: |_, _, _| (),
        }
    }

    /// What is a function of position, velocity, time, temperature and load as they are now.
    const fn acts(self, acts: Acts) -> Self {
        Self { acts, ..self }
    }
}

/// The table of effects. A number is that of an effect's stream of draws: a new one of the catalogue stands last in it with the next, 35, so that the
/// draws of the others stay.
macro_rules! effects {
    (
        catalogue { $($inside:ident $(= $own:literal)?: $inside_row:expr;)* }
        outside { $($(#[$doc:meta])* $outside:ident $(= $number:literal)?: $outside_row:expr;)* }
    ) => {
        /// An effect. The names of the catalogue's are those of the design; the rest is outside it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)] // the catalogue documents them; those outside it are documented in the table
        pub enum Id {
            $($inside $(= $own)?,)*
            $($(#[$doc])* $outside $(= $number)?,)*
        }

        /// Effects of the catalogue, in its order.
        pub const CATALOGUE: [Id; [$(Id::$inside),*].len()] = [$(Id::$inside),*];

        /// Effects that are in no catalogue: the right answer is `unknown-physics`.
        pub const OUTSIDE: [Id; [$(Id::$outside),*].len()] = [$(Id::$outside),*];

        impl Id {
            fn row(self) -> Row {
                match self {
                    $(Id::$inside => $inside_row,)*
                    $(Id::$outside => $outside_row,)*
                }
            }
        }
    };
}

effects! {
catalogue {
    ConstantForce: Row::of("constant_force", &["force_N"], |d| vec![0.1 * d.signed])
        .acts(|[force, ..], _, sum| sum.added += force);
    CoulombAsymmetry: Row::of("coulomb_asymmetry", &["asymmetry"], |d| vec![0.07 * d.signed])
        .acts(|[tilt, ..], at, sum| sum.tilt += at.here * tilt);
    Viscous: Row::of("viscous", &["viscous_N_s_per_m"], |d| vec![10.0 * d.s])
        .acts(|[viscous, ..], at, sum| sum.added += at.here * viscous * at.v);
    QuadraticDrag: Row::of("quadratic_drag", &["drag_N_s2_per_m2"], |d| vec![150.0 * d.s])
        .acts(|[drag, ..], at, sum| sum.added += drag * at.v * at.speed());
    Stribeck: Row::of("stribeck", &["level", "velocity_m_s", "exponent"], |d| {
        vec![0.2 * d.s, d.draw.log_uniform(0.2e-3, 2e-3), d.draw.uniform(0.7, 2.0)]
    })
    .acts(|[level, v_s, exponent, _], at, sum| sum.level += at.here * level * (-(at.speed() / v_s).powf(exponent)).exp());
    FrictionalLag: Row::of("frictional_lag", &["level", "velocity_m_s", "exponent", "time_constant_s"], |d| {
        vec![0.3 * d.s, d.draw.log_uniform(1e-3, 4e-3), d.draw.uniform(0.8, 1.5), d.draw.log_uniform(10e-3, 50e-3)]
    });
    PositionSpring: Row::of("position_spring", &["stiffness_N_per_m", "centre_m"], |d| {
        vec![8.0 * d.s, 0.3 * d.half_travel * d.draw.uniform(-1.0, 1.0)]
    })
    .acts(|[stiffness, centre, ..], at, sum| {
        // In a corner the spring begins at the edge, as an end stop or a cable guide does.
        sum.added += match at.corner {
            None => stiffness * (at.x - centre),
            Some(edge) => 4.0 * stiffness * at.here * (at.x - edge),
        }
    });
    PositionForce: Row::of("position_force", &["bend_N", "bump_N", "bump_m", "bump_width_m"], |d| {
        vec![
            0.06 * d.signed,
            0.08 * d.s * d.draw.sign(),
            d.half_travel * d.draw.uniform(-0.6, 0.6),
            d.half_travel * d.draw.uniform(0.15, 0.3),
        ]
    })
    .acts(|[bend, bump, place, width], at, sum| sum.added += bend * at.bend() + bump * bell((at.x - place) / width));
    PositionFriction: Row::of("position_friction", &["slope_level", "bend_level"], |d| {
        vec![0.12 * d.signed, 0.12 * d.s * d.draw.uniform(-1.0, 1.0)]
    })
    .acts(|[slope, bend, ..], at, sum| sum.level += slope * at.along() + bend * at.bend());
    LocalFrictionSpot: Row::of("local_friction_spot", &["level", "position_m", "width_m"], |d| {
        vec![0.35 * d.s, d.half_travel * d.draw.uniform(-0.85, 0.85), d.draw.log_uniform(0.2e-3, 1e-3)]
    })
    .acts(|[level, place, width, _], at, sum| sum.level += level * bell((at.x - place) / width));
    PeriodicForce: Row::of("periodic_force", &["force_N", "period_m", "phase_rad"], |d| {
        let period = match d.draw.whole(0, 3) {
            0 => 2e-3 / 7.0,
            1 => 2e-3,
            _ => d.draw.log_uniform(0.2e-3, 3e-3),
        };
        vec![0.03 * d.s, period, d.phase]
    })
    .acts(|[force, period, phase, _], at, sum| sum.added += at.here * force * at.wave(period, phase));
    PeriodicFriction: Row::of("periodic_friction", &["level", "period_m", "phase_rad"], |d| {
        let period = if d.draw.chance(0.5) { 2e-3 } else { d.draw.log_uniform(0.8e-3, 5e-3) };
        vec![0.08 * d.s, period, d.phase]
    })
    .acts(|[level, period, phase, _], at, sum| sum.level += at.here * level * at.wave(period, phase));
    EncoderError: Row::of("encoder_error", &["error_m", "period_m", "phase_rad"], |d| {
        let order = d.draw.whole(1, 3) as f64;
        vec![0.1e-6 * d.s, super::ENCODER_PERIOD_M / order, d.phase]
    });
    Backlash: Row::of("backlash", &["gap_m"], |d| vec![4e-6 * d.s]);
    // Resonances of about 170, 120 and 85 Hz with 40 % of the mass on the motor's side; the scenario, which knows the mass, fills in which.
    DriveCompliance: Row::of("drive_compliance", &["stiffness_N_per_m", "frequency_Hz"], |d| {
        vec![4.8e5 * d.draw.uniform(0.8, 1.25) / d.s, 0.0]
    });
    ChannelDelay: Row::of("channel_delay", &["delay_s"], |d| vec![1e-3 * d.s]);
    ActuatorDeadZone: Row::of("actuator_dead_zone", &["width_N"], |d| vec![0.1 * d.s]);
    ActuatorSaturation: Row::of("actuator_saturation", &["limit_N"], |d| vec![d.breakaway + 1.4 / d.s.powf(0.4)]);
    LoadDependentFriction: Row::of("load_dependent_friction", &["level_per_N"], |d| vec![0.012 * d.s])
        .acts(|[level, ..], at, sum| sum.level += level * at.loaded);
    ThermalDrift: Row::of("thermal_drift", &["level_per_K"], |d| vec![-0.015 * d.s])
        .acts(|[level, ..], at, sum| sum.level += level * at.warmer);
    RunIn: Row::of("run_in", &["level", "path_m"], |d| vec![0.12 * d.s, d.draw.log_uniform(0.1, 0.4)]);
    DwellAging: Row::of("dwell_aging", &["level_per_decade", "time_constant_s", "erasing_path_m"], |d| {
        vec![0.04 * d.s, d.draw.log_uniform(0.2, 0.6), d.draw.log_uniform(5e-6, 50e-6)]
    });
    Creep: Row::of("creep", &["rate_m_s", "share_of_breakaway"], |d| vec![15e-9 * d.s, d.draw.uniform(0.12, 0.2)]);
    ExternalVibration: Row::of("external_vibration", &["force_N", "frequency_Hz", "phase_rad"], |d| {
        vec![0.02 * d.s, d.draw.log_uniform(2.0, 60.0), d.phase]
    })
    .acts(|[force, frequency, phase, _], at, sum| sum.added += force * (TAU * frequency * at.t + phase).sin());
    // How far the model's stiffness is off, on top of its two blocks.
    PreslidingShape: Row::of("presliding_shape", &["stiffness_factor"], |d| vec![1.0 + d.s]);
}
outside {
    /// Bursts of a damped vibration at random times.
    RandomBursts = 25: Row::of("random_bursts", &["force_N", "frequency_Hz", "decay_s", "mean_interval_s"], |d| {
        vec![0.25 * d.s * d.friction, d.draw.uniform(15.0, 45.0), d.draw.uniform(0.05, 0.2), d.draw.uniform(0.8, 2.0)]
    })
    .acts(|[force, frequency, decay, _], at, sum| {
        let since = at.bursts.iter().map(|start| at.t - start);
        for since in since.filter(|s| (0.0..8.0 * decay).contains(s)) {
            sum.added += force * (-since / decay).exp() * (TAU * frequency * since).sin();
        }
    });
    /// A force in the direction of motion that starts at each reversal and relaxes with time, not path.
    RelaxingMemory: Row::of("relaxing_memory", &["force_N", "time_constant_s"], |d| {
        vec![0.15 * d.s * d.friction, d.draw.log_uniform(0.05, 0.4)]
    });
    /// A magnetic detent that grows with speed: `A·|v|/(v0 + |v|)·cos(2πx/p)`.
    SpeedDetent: Row::of("speed_detent", &["force_N", "period_m", "phase_rad", "velocity_m_s"], |d| {
        vec![0.12 * d.s * d.friction, d.draw.log_uniform(0.4e-3, 3e-3), d.phase, d.draw.log_uniform(2e-3, 8e-3)]
    })
    .acts(|[force, period, phase, v0], at, sum| sum.added += force * at.speed() / (v0 + at.speed()) * at.wave(period, phase));
    /// Friction that is higher when speeding up than when slowing down.
    AccelerationFriction: Row::of("acceleration_friction", &["level", "power_m2_s3"], |d| {
        vec![0.15 * d.s, d.draw.log_uniform(1e-3, 3e-3)]
    });
    /// A friction level that switches by the clock, as from a pump or a lubricator nearby.
    TimeOfDay: Row::of("time_of_day", &["level", "period_s"], |d| vec![0.12 * d.s, d.draw.uniform(4.0, 9.0)])
        // The clock's switch takes 0.1 s, as a valve does.
        .acts(|[level, period, ..], at, sum| sum.level += level * ((TAU * at.t / period).sin() * period / 0.6).tanh());
    /// A friction level lowered by the highest speed of the last seconds.
    SpeedHistory: Row::of("speed_history", &["level", "velocity_m_s", "time_constant_s"], |d| {
        vec![0.25 * d.s, d.draw.log_uniform(2e-3, 8e-3), d.draw.uniform(0.5, 2.0)]
    });
    /// Each reversal stirs the grease: the level rises by a step, and a path lets it settle again.
    ReversalChurn: Row::of("reversal_churn", &["level", "path_m"], |d| vec![0.12 * d.s, d.draw.log_uniform(2e-3, 8e-3)]);
    /// A cage that rattles at one speed: the level is higher in a narrow band of it.
    SpeedBand: Row::of("speed_band", &["level", "velocity_m_s", "width_m_s"], |d| {
        let speed = d.draw.log_uniform(2e-3, 10e-3);
        vec![0.3 * d.s, speed, speed * d.draw.uniform(0.15, 0.3)]
    })
    .acts(|[level, band, width, _], at, sum| sum.level += level * bell((at.speed() - band) / width));
    /// Rollers that slip and never find back: the level waves with the path travelled, whichever way, not with the position.
    PathRipple: Row::of("path_ripple", &["level", "path_m", "phase_rad"], |d| {
        vec![0.15 * d.s, d.draw.log_uniform(1e-3, 6e-3), d.phase]
    });
    /// A machine nearby that runs up: a shaking force whose frequency drifts.
    DriftingShake: Row::of("drifting_shake", &["force_N", "frequency_Hz", "rate_Hz_s", "phase_rad"], |d| {
        vec![0.1 * d.s * d.friction, d.draw.uniform(3.0, 10.0), d.draw.uniform(0.05, 0.25), d.phase]
    })
    .acts(|[force, frequency, rate, phase], at, sum| {
        let turns = (frequency + 0.5 * rate * at.t) * at.t;
        sum.added += force * (TAU * turns + phase).sin();
    });
}
}

/// What is done to a real recording so that it has an effect.
pub enum Change {
    /// A force is added, here in any scale. Friction's level is taken to be the same everywhere.
    Force(fn(&On) -> f64),
    /// The effort is read later.
    Delay,
    /// The position is misread, so many times over the travel.
    Misreading(f64),
}

/// A row of a recording, as a force that is added sees it.
pub struct On {
    /// Time (s).
    pub t: f64,
    /// Position (m or rad) and velocity.
    pub x: f64,
    /// See `x`.
    pub v: f64,
    /// The force of a stop, which is friction's sign.
    pub friction: f64,
    /// From 0 to 1 along the travel.
    pub along: f64,
    /// Top speed.
    pub top: f64,
    /// A drawn place along the travel, and a drawn phase.
    pub place: f64,
    /// See `place`.
    pub phase: f64,
    /// A frequency (Hz) that the recording can show.
    pub shake: f64,
}

impl On {
    fn waves(&self, many: f64) -> f64 {
        (TAU * many * self.along + self.phase).cos()
    }

    fn bump(&self, widths: f64) -> f64 {
        bell(widths * (self.along - self.place))
    }
}

/// What of an effect in a recording an answer must meet.
pub enum Shows {
    /// Its name.
    Name,
    /// So many periods in the travel.
    Periods(f64),
    /// The frequency.
    Frequency,
    /// A bump at its place, so many widths (1/e) of it in the travel.
    Bump(f64),
    /// The same, its place stated.
    Spot(f64),
    /// Low speeds.
    Slow,
}

/// An effect that can be added to a real recording.
pub struct Injected {
    /// Its id.
    pub id: &'static str,
    /// How.
    pub change: Change,
    /// What must be found.
    pub shows: Shows,
    /// It raises the friction in one place or direction and lowers it by as much in another: friction does not push.
    pub both_ways: bool,
}

/// Periods in the travel of a force, of friction, of an encoder; widths of a spot of friction and a bump of force in it.
const WAVES: [f64; 3] = [12.0, 7.0, 40.0];
/// See [`WAVES`].
const SPOTS: [f64; 2] = [15.0, 5.0];

const fn injected(id: &'static str, change: Change, shows: Shows) -> Injected {
    Injected {
        id,
        change,
        shows,
        both_ways: false,
    }
}

const fn both_ways(injected: Injected) -> Injected {
    Injected {
        both_ways: true,
        ..injected
    }
}

/// What can be added: every effect that a force of the motion, or a change of one column, can make.
pub static INJECTED: [Injected; 15] = {
    use Change::{Delay, Force, Misreading};
    use Shows::{Bump, Frequency, Name, Periods, Slow, Spot};
    [
        injected("constant_force", Force(|_| 1.0), Name),
        injected("viscous", Force(|on| on.v), Name),
        injected(
            "stribeck",
            Force(|on| on.friction * (-on.v.abs() / (0.1 * on.top)).exp()),
            Slow,
        ),
        // Higher one way, lower the other: the same sign for both.
        both_ways(injected(
            "coulomb_asymmetry",
            Force(|on| on.friction.abs()),
            Name,
        )),
        injected("position_spring", Force(|on| on.along - on.place), Name),
        both_ways(injected(
            "position_friction",
            Force(|on| on.friction * (2.0 * on.along - 1.0)),
            Name,
        )),
        injected(
            "local_friction_spot",
            Force(|on| on.friction * on.bump(SPOTS[0])),
            Spot(SPOTS[0]),
        ),
        injected(
            "periodic_force",
            Force(|on| on.waves(WAVES[0])),
            Periods(WAVES[0]),
        ),
        both_ways(injected(
            "periodic_friction",
            Force(|on| on.friction * on.waves(WAVES[1])),
            Periods(WAVES[1]),
        )),
        injected("encoder_error", Misreading(WAVES[2]), Periods(WAVES[2])),
        injected("channel_delay", Delay, Name),
        injected(
            "external_vibration",
            Force(|on| (TAU * on.shake * on.t + on.phase).sin()),
            Frequency,
        ),
        injected("quadratic_drag", Force(|on| on.v * on.v.abs()), Name),
        injected(
            "position_force",
            Force(|on| on.bump(SPOTS[1])),
            Bump(SPOTS[1]),
        ),
        injected("gravity", Force(|on| (on.x - on.phase).sin()), Name),
    ]
};

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
        self.row().name
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
        self.id.row().keys.iter().copied().zip(self.values)
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
        let drawn = (id.row().drawn)(&mut Drawn {
            s,
            signed: s * draw.sign(),
            phase: draw.uniform(0.0, TAU),
            half_travel,
            breakaway,
            friction: breakaway / 0.9,
            draw,
        });
        let mut values = [0.0; 4];
        values[..drawn.len()].copy_from_slice(&drawn);
        Effect {
            id,
            values,
            corner: None,
        }
    }

    /// Adds what it does at an instant, unless that takes a memory.
    pub fn act(&self, at: &Present, sum: &mut Acting) {
        let own = Present {
            here: self.presence(at.x),
            corner: self.corner,
            ..*at
        };
        (self.id.row().acts)(self.values, &own, sum);
    }
}
