//! What the tool's commands do with a fit: what is left out of it, what another law or a budget makes of it, source for a controller.

pub mod capture;
pub mod compare;
pub mod cost;
pub mod diagnose;
pub mod drive;
pub mod export;
pub mod fleet;
pub mod paper;
pub mod plan;
pub mod predict;
pub mod tune;
