//! Placeholder until the effects branch lands.
/// An effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Id.
    pub id: &'static str,
    /// Values.
    pub values: Vec<(String, f64)>,
}
