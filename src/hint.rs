//! What the compiler is told about branches.

/// The branch that calls this is rarely taken.
///
/// Rust has a hint for it since 1.95 (`build.rs` asks the compiler), for which the cycle tables hold; before, an empty function that is
/// cold says the same as well as it can.
#[inline(always)]
#[cfg_attr(not(cold_path), cold)]
pub(crate) fn cold_path() {
    #[cfg(cold_path)]
    #[allow(clippy::incompatible_msrv)]
    core::hint::cold_path();
}
