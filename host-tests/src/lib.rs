//! Host checks of Preslide: an independent reference, and the paths and parameters that it is driven with;
//! and the trials that the diagnosis is judged by.

pub mod deviation;
pub mod path;
pub mod reference;
pub mod table3;
pub mod trials;
