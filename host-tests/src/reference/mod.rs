//! The models once more in `f64`, from the paper's equations, sharing no code, formulation or data layout with
//! the library that they check: what several checks use. Those of the laws with a row of their own stand in `tests/laws/`.

mod encoder;
mod level;
mod masing;
mod maxwell_slip;
mod observer;
pub mod ode;
mod stribeck;

pub use encoder::SteadyMotion;
pub use level::Level;
pub use masing::Masing;
pub use maxwell_slip::MaxwellSlip;
pub use observer::WalkingDisturbance;
pub use stribeck::Stribeck;
