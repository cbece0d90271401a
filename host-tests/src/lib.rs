//! Host checks of Preslide: an independent reference, and the paths and parameters that it is driven with.

pub mod deviation;
pub mod path;
pub mod reference;
pub mod table3;
