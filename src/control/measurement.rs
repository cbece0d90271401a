//! What a board measures.

/// What a board measures in a tick, raw.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement<C> {
    /// The quadrature counter.
    pub count: C,
    /// The supply voltage in the codes that [`super::Hardware::supply_code`] scales.
    pub supply: u16,
    /// The winding's current in the codes that [`super::Hardware::current_code`] scales; 0 where it is not measured.
    pub current: i16,
    /// This tick started after the next one was due.
    pub late: bool,
}
