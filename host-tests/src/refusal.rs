//! Parameters that a constructor must refuse, and by which name and bound.

use preslide::{Bound, ParamError};

/// The error names this parameter of no block, and this bound.
///
/// # Panics
/// Where it does not, or there is none.
#[track_caller]
pub fn refused(error: Option<ParamError>, parameter: &str, bound: Bound) {
    refused_in(None, error, parameter, bound);
}

/// The error names this block, too, where the parameter is one of a block.
///
/// # Panics
/// Where it does not, or there is none.
#[track_caller]
pub fn refused_in(block: Option<usize>, error: Option<ParamError>, parameter: &str, bound: Bound) {
    let error = error.expect("must be refused");
    let told = (error.parameter, error.block, error.bound);
    assert_eq!(told, (parameter, block, bound), "{error}");
    assert!(error.to_string().starts_with(parameter), "{error}");
}

/// What is not finite and above zero is refused.
///
/// # Panics
/// Where one is not.
#[track_caller]
pub fn positive(parameter: &str, with: impl Fn(f64) -> Option<ParamError>) {
    refused(with(0.0), parameter, Bound::Positive);
    for bad in NEVER {
        refused(with(bad), parameter, Bound::Positive);
    }
}

/// What is not finite or below zero is refused.
///
/// # Panics
/// Where one is not.
#[track_caller]
pub fn not_negative(parameter: &str, with: impl Fn(f64) -> Option<ParamError>) {
    for bad in NEVER {
        refused(with(bad), parameter, Bound::NotNegative);
    }
}

/// No magnitudes.
pub const NEVER: [f64; 4] = [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// It is refused, in words that say all of these.
#[track_caller]
pub fn refuses<T>(answer: Result<T, impl std::fmt::Display>, parts: &[&str]) {
    let said = answer.err().expect("refused").to_string();
    for part in parts {
        assert!(said.contains(part), "`{part}` is not in: {said}");
    }
}
