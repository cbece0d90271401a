//! The board that drives the axis: its rate, its bridge, its converters.

use crate::param::{ParamError, at_least, at_most, not_negative, positive};

/// The time base, the bridge and the converters of the board that drives the axis.
///
/// Rate and PWM steps stand here and nowhere else: a board builds this constant from the clock that it sets
/// ([`Hardware::edge_aligned`], [`Hardware::centre_aligned`]) and sets its timers from the constant, so that the clock cannot be
/// edited alone. A clock that does not divide into the rate does not compile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hardware {
    /// Ticks of the control task per second (Hz), at least 10.
    pub rate_hz: u32,
    /// PWM codes at full duty, 1…32000. The sign of a code is the direction.
    pub steps: u16,
    /// One code of the supply measurement (V).
    pub supply_code: f64,
    /// One code of the current measurement (A).
    pub current_code: f64,
    /// Both gates of a half bridge are off for so long after either edge of the PWM (s), at most a tenth of a tick; what that
    /// costs of the voltage is made up for. 0 where it is not known, or the gate driver's own.
    pub dead_time: f64,
    /// Forward voltage (V) of the diodes that carry the current meanwhile.
    pub diode_drop: f64,
}

impl Hardware {
    /// A PWM timer that counts up at `clock_hz`, one period a tick; supply in mV, current in 0.1 mA, as the application's.
    ///
    /// # Panics
    /// Where the clock is no multiple of the rate or makes more than 32000 steps: in a constant, that is a compile error.
    pub const fn edge_aligned(clock_hz: u32, rate_hz: u32) -> Self {
        assert!(rate_hz >= 10, "the control rate must be at least 10 Hz");
        assert!(
            clock_hz.is_multiple_of(rate_hz),
            "the timer's clock must be a multiple of the control rate"
        );
        let steps = clock_hz / rate_hz;
        assert!(
            steps >= 1 && steps <= 32_000,
            "a PWM period must be 1 to 32000 clocks"
        );
        Self {
            rate_hz,
            steps: steps as u16,
            supply_code: 1e-3,
            current_code: 1e-4,
            dead_time: 0.0,
            diode_drop: 0.0,
        }
    }

    /// With this dead time (s) and diodes of this forward voltage (V).
    #[must_use]
    pub const fn with_dead_time(self, dead_time: f64, diode_drop: f64) -> Self {
        Self {
            dead_time,
            diode_drop,
            ..self
        }
    }

    /// A PWM timer that counts up and down, one period a tick: half the steps of [`Hardware::edge_aligned`].
    ///
    /// # Panics
    /// As there; the clock must be an even multiple of the rate.
    pub const fn centre_aligned(clock_hz: u32, rate_hz: u32) -> Self {
        assert!(
            clock_hz.is_multiple_of(2),
            "the timer's clock must be an even multiple of the control rate"
        );
        Self::edge_aligned(clock_hz / 2, rate_hz)
    }

    /// `T_s` (s).
    pub const fn sample_time(&self) -> f64 {
        1.0 / self.rate_hz as f64
    }

    pub(crate) fn check(&self) -> Result<(), ParamError> {
        at_least("control rate", self.rate_hz.into(), 10.0)?;
        positive("PWM steps", self.steps.into())?;
        at_most("PWM steps", self.steps.into(), 32_000.0)?;
        positive("supply code", self.supply_code)?;
        positive("current code", self.current_code)?;
        not_negative("dead time", self.dead_time)?;
        at_most("dead time", self.dead_time, 0.1 * self.sample_time())?;
        not_negative("diode drop", self.diode_drop)?;
        Ok(())
    }
}
