//! The limits of faults, in SI; [`Monitor`](super::Monitor) has them in counts, codes and ticks.

/// Bounds of what counts as healthy (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultLimits {
    /// Fastest motion the axis can make (m/s or rad/s).
    pub top_speed: f64,
    /// Largest position error (m or rad).
    pub following_error: f64,
    /// |duty| (-) that moves the axis whatever the friction.
    pub frozen_duty: f64,
    /// Time (s) at that duty in which the axis must come on by two counts.
    pub frozen_time: f64,
    /// Lowest supply voltage (V).
    pub supply_min: f64,
    /// Highest supply voltage (V).
    pub supply_max: f64,
    /// Time (s) that the supply may be outside.
    pub supply_time: f64,
    /// Late ticks in a row that are ridden out.
    pub overruns: u32,
    /// Largest current (A).
    pub current_max: f64,
    /// Current (A) that the winding stands for ever.
    pub current_rated: f64,
    /// Thermal time constant of the winding `τ` (s): the fault comes when `∫(i² − i_rated²)dt`, held above 0, exceeds
    /// `i_rated²·τ`, so at twice the rated current after a third of it.
    pub thermal_time: f64,
    /// Largest reading of the current sense (A) while the bridge is off; what is read there is taken off afterwards.
    pub current_offset: f64,
}
