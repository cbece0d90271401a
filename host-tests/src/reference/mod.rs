//! The models once more in `f64`, from the paper's equations, sharing no code, formulation or data layout with
//! the library that they check.

mod bouc_wen;
mod dahl;
mod elasto_plastic;
mod encoder;
mod hsieh;
mod leuven;
mod level;
mod lugre;
mod masing;
mod maxwell_slip;
mod observer;
mod ode;
mod stribeck;
mod two_state;

pub use bouc_wen::BoucWen;
pub use dahl::Dahl;
pub use elasto_plastic::ElastoPlastic;
pub use encoder::SteadyMotion;
pub use hsieh::Hsieh;
pub use leuven::Leuven;
pub use level::Level;
pub use lugre::LuGre;
pub use masing::Masing;
pub use maxwell_slip::MaxwellSlip;
pub use observer::WalkingDisturbance;
pub use stribeck::Stribeck;
pub use two_state::TwoState;
