//! Gains of the observer in `preslide::control`, and the margins that they leave.

mod gains;
mod machine;
mod margins;
mod present;
mod proposal;
#[cfg(test)]
mod tests;

pub use gains::{Belief, Gains};
pub use machine::Machine;
pub use margins::{Feedback, Margins};
pub use proposal::{
    Case, DEMANDS, Demands, Known, Proposal, UNCERTAINTY, UNMODELLED_KG, USUAL_DAMPING, cases,
    propose, take_mass,
};
