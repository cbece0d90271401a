//! The laws that are fitted: parameters that enter nonlinearly, where these may lie, and what is left linear.

use super::{Bounded, Family, FrictionModel, Span};

/// A recording of which nothing but its form matters.
const ANY: Span = Span {
    shortest: 1.0,
    longest: 1.0,
    speed: 1.0,
    sample_time: 1.0,
    duration: 1.0,
};

impl Family {
    /// The nonlinear parameters. Every one is a length, a velocity, a rate or a ratio: the level of the force is
    /// linear and is solved for, see [`Family::model`].
    pub fn parameters(self, span: &Span) -> Vec<Bounded> {
        (self.search().bounds)(span)
    }

    /// The model with the parameters `nonlinear`, whose force is
    /// `amplitude·(force of model(nonlinear, 1, 0)) + damping·(force of model(nonlinear, 1, 1) − force of model(nonlinear, 1, 0))`.
    ///
    /// `amplitude` (N or N·m) is `F_c` (Dahl, Bouc-Wen), `k_2s/β` (Hsieh), else `F_s`; `damping` (N·s/m or N·m·s/rad) is
    /// `σp` (LuGre), `σ1` (elasto-plastic, Leuven), `C_v` (Hsieh). `None` where `nonlinear` has the wrong length.
    pub fn model(self, nonlinear: &[f64], amplitude: f64, damping: f64) -> Option<FrictionModel> {
        (self.search().model)(nonlinear, amplitude, damping)
    }

    /// One of its models.
    fn example(self) -> Option<FrictionModel> {
        let least = self.parameters(&ANY).into_iter().map(|b| b.from);
        self.model(&least.collect::<Vec<_>>(), 1.0, 0.0)
    }

    /// Its name in messages and tables.
    pub fn name(self) -> String {
        self.example()
            .map_or_else(String::new, |model| model.name())
    }

    /// Whether the model has a viscous term of its own: LuGre's `σp·dz/dt` and its relatives', Hsieh's `C_v·dx_s/dt`.
    pub fn is_damped(self) -> bool {
        let model = self.example();
        model.is_some_and(|mut model| model.damping().is_some())
    }

    /// Number of friction parameters that are fitted, without offset and rigid body.
    pub fn parameter_count(self) -> usize {
        self.parameters(&ANY).len() + 1 + usize::from(self.is_damped())
    }
}
