//! The models once more in `f64`, from the paper's equations, sharing no code, formulation or data layout with
//! the library that they check.

mod dahl;
mod encoder;
mod hsieh;
mod lugre;
mod masing;
mod maxwell_slip;
mod ode;
mod stribeck;

pub use dahl::Dahl;
pub use encoder::SteadyMotion;
pub use hsieh::Hsieh;
pub use lugre::LuGre;
pub use masing::Masing;
pub use maxwell_slip::MaxwellSlip;
pub use stribeck::Stribeck;
