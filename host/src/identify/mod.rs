//! From a recording to parameters.

pub mod refine;
pub mod regression;
pub mod search;
pub mod stop;
pub mod split;
pub mod virgin;
