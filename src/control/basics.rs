//! An axis from the few numbers that nobody but its owner knows.

use super::{
    Axis, Encoder, FaultLimits, FeedForward, Hardware, Limits, Motor, Notch, PidGains,
    VelocitySource,
};
use crate::param::{ParamError, positive};
use core::f64::consts::PI;
use core::fmt;

/// Ticks in which the loop's crossover turns by 2π: a window of [`WINDOW`] ticks and the tick itself then cost it 5° of phase. At 20 kHz that is
/// 25 Hz, far below the first mode of most drives; raise the gains where yours is stiff.
const CROSSOVER: f64 = 800.0;
/// Ticks over which velocity is measured.
const WINDOW: f64 = 20.0;
/// Damping of the loop, the motor's own included (-).
const DAMPING: f64 = 0.7;
/// The integral's share of the crossover (-): slow enough to cost no more than 11° of phase.
const INTEGRAL: f64 = 0.2;

/// What has to be known of an axis (SI: m and N, or rad and N·m). The rest of an [`Axis`] follows from it.
///
/// ```
/// use preslide::control::{Basics, Coefficients, Controller, Hardware, Measurement, Planner};
/// use preslide::{Block, QuasiStaticGms, Units};
///
/// let axis = Basics {
///     hardware: Hardware::edge_aligned(170_000_000, 20_000),
///     count: 25e-9,
///     mass: 4.0,
///     force_per_ampere: 20.7,
///     resistance: 3.4,
///     supply: 6.0,
///     current: 0.68,
///     speed: 15e-3,
///     travel: Some((-12.5e-3, 12.5e-3)),
/// }
/// .axis()?;
/// let blocks = [Block { stiffness: 113_948.0, weight: 0.616 }, Block { stiffness: 8_870.0, weight: 0.384 }];
/// let friction = QuasiStaticGms::<2>::try_new(&blocks, 0.9, Units::SI)?;
/// let mut controller = Controller::new(Coefficients::try_new(&axis, friction, Units::SI)?, 0_u32);
/// let mut planner = Planner::try_new(&axis)?;
/// controller.enable().expect("nothing speaks against it");
/// controller.start(planner.by(1e-3, 5e-3, 0.5)?).expect("within the limits");
/// let command = controller.tick(Measurement { count: 0, supply: 6000, current: 0, late: false });
/// assert!(command.enabled);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// Everything that is wrong is told at once:
///
/// ```
/// # use preslide::control::{Basics, Hardware};
/// # let hardware = Hardware::edge_aligned(170_000_000, 20_000);
/// let wrong = Basics { hardware, count: 0.0, mass: -4.0, force_per_ampere: 20.7, resistance: 3.4, supply: 6.0, current: 0.68, speed: 15e-3, travel: None };
/// let told = wrong.axis().unwrap_err().to_string();
/// assert!(told.contains("length of a count") && told.contains("moving mass"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basics {
    /// Rate, PWM and converters.
    pub hardware: Hardware,
    /// One encoder count (m).
    pub count: f64,
    /// What moves, with the rotor's inertia reflected to the stage (kg).
    pub mass: f64,
    /// The motor's force at the stage (N/A), in SI its back-EMF too (V·s/m): `k_M·2π·n/lead` of a motor behind gear and screw.
    pub force_per_ampere: f64,
    /// The winding's resistance (Ω).
    pub resistance: f64,
    /// The supply (V).
    pub supply: f64,
    /// The winding's rated current (A).
    pub current: f64,
    /// The largest speed of a motion (m/s).
    pub speed: f64,
    /// Lowest and highest position (m); `None` for an axis without end.
    pub travel: Option<(f64, f64)>,
}

impl Basics {
    /// The axis. Its fields are yours to change before it is used.
    ///
    /// - Duty holds the standing winding within its rated current, or is full: that is the largest force `F`. Half of `F` is left to the
    ///   acceleration; integral and friction model may take half of it each.
    /// - `K_p = m·ω²`, `K_d = 2ζ·m·ω` less what the motor brakes, `K_i = ω·K_p/5` at the crossover `ω = 2π·rate/800`, `ζ = 0.7`.
    /// - The smoothing of a reference takes half of `1/ω`; a fade takes ten turns of the crossover.
    /// - A following error is a fault where `K_p` alone answers it with a third of `F`; so is a speed a third above the largest, a supply a quarter
    ///   off, half more than the rated current, and as much current as rated but for 5 s.
    ///
    /// # Errors
    /// Every value that is not finite, not positive or in the wrong order.
    // Large, since there is no heap; once, where there is a stack.
    #[allow(clippy::result_large_err)]
    pub fn axis(&self) -> Result<Axis, BasicsError> {
        self.check()?;
        let Self {
            hardware,
            count,
            mass,
            force_per_ampere,
            resistance,
            supply,
            current,
            speed,
            travel,
        } = *self;
        let tick = hardware.sample_time();
        let omega = 2.0 * PI / (CROSSOVER * tick);
        let duty_limit = (current * resistance / supply).min(1.0);
        let motor = Motor {
            torque_constant: force_per_ampere,
            resistance,
            resistance_span: 0.0,
            inductance: 0.0,
            // A screw of 2π a turn is none: the motor's angle is the stage's place.
            gear_ratio: 1.0,
            screw_lead: 2.0 * PI,
            efficiency: 1.0,
            supply,
            reversed: false,
        };
        let force = duty_limit * supply * motor.force_per_volt();
        let acceleration = 0.5 * force / mass;
        let proportional = mass * omega * omega;
        let own = motor.braking();
        Ok(Axis {
            hardware,
            encoder: Encoder {
                count,
                window: WINDOW * tick,
                timeout: 0.5,
                reversed: false,
                turn: 0,
            },
            motor,
            gains: PidGains {
                proportional,
                integral: INTEGRAL * omega * proportional,
                derivative: (2.0 * DAMPING * mass * omega - own).max(0.0),
                integral_limit: 0.5 * force,
                // Friction that sticks and an integrator hunt about an error that no count shows.
                deadband: 1.2 * count,
            },
            notch: Notch::NONE,
            feed_forward: FeedForward {
                drive: VelocitySource::Reference,
                share: 1.0,
                limit: 0.5 * force,
                mass,
            },
            limits: Limits {
                speed,
                acceleration,
                jerk: 4.0 * acceleration * omega,
                travel,
            },
            duty_limit,
            watch: FaultLimits {
                top_speed: speed * 4.0 / 3.0,
                following_error: force / proportional / 3.0,
                // More than the acceleration takes: an axis that brakes by it comes on against the push, too.
                frozen_duty: 0.6 * duty_limit,
                frozen_time: 100.0 * tick,
                supply_min: 0.75 * supply,
                supply_max: 1.25 * supply,
                supply_time: 20.0 * tick,
                overruns: 2,
                current_max: 1.5 * current,
                current_rated: current,
                thermal_time: 5.0,
                current_offset: 0.07 * current,
            },
            fade_time: 10.0 * CROSSOVER * tick,
            silence: 2.0,
        })
    }

    #[allow(clippy::result_large_err)]
    fn check(&self) -> Result<(), BasicsError> {
        let (low, high) = self.travel.unwrap_or((0.0, 1.0));
        let values = [
            ("length of a count", self.count),
            ("moving mass", self.mass),
            ("force per ampere", self.force_per_ampere),
            ("resistance", self.resistance),
            ("supply voltage", self.supply),
            ("rated current", self.current),
            ("speed limit", self.speed),
            ("travel from its low to its high end", high - low),
        ];
        let mut wrong = [None; 9];
        wrong[0] = self.hardware.check().err();
        for (place, (name, value)) in wrong.iter_mut().skip(1).zip(values) {
            *place = positive(name, value).err();
        }
        match wrong.iter().any(Option::is_some) {
            true => Err(BasicsError(wrong)),
            false => Ok(()),
        }
    }
}

/// Everything that is wrong with [`Basics`], a line each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasicsError([Option<ParamError>; 9]);

impl BasicsError {
    /// Each of them.
    pub fn errors(&self) -> impl Iterator<Item = &ParamError> {
        self.0.iter().flatten()
    }
}

impl fmt::Display for BasicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, error) in self.errors().enumerate() {
            let line = if n == 0 { "" } else { "\n" };
            write!(f, "{line}{error}")?;
        }
        Ok(())
    }
}

impl core::error::Error for BasicsError {}
