//! A friction model beside an outer task's orders comes from where the one that it wraps comes from.

use crate::{Model, Table};
use preslide::control::NoFriction;
use preslide::control::koopman::{Guided, OuterSettings};
use preslide::{ParamError, Units};

/// The model `M` beside the orders of an outer task ([`preslide::control::koopman::Outer`]); outermost, so `Guiding<Observing<M>>`. Gains and
/// model are to be those that the outer task's map was learnt with.
#[derive(Clone)]
pub struct Guiding<M> {
    model: M,
    ticks: u32,
    limit: f64,
}

impl<M> Guiding<M> {
    /// Guides `model` by the orders of an outer task of these settings.
    pub const fn new<const STATES: usize, const BLOCKS: usize, const MOVES: usize>(
        model: M,
        settings: &OuterSettings<STATES, BLOCKS, MOVES>,
    ) -> Self {
        Self {
            model,
            ticks: settings.ticks,
            limit: settings.cost.force,
        }
    }
}

impl<M: Model> Model for Guiding<M> {
    type Friction = Guided<M::Friction>;
    const UNITS: Units = M::UNITS;

    fn build(&self, sample_time: f64) -> Result<Self::Friction, ParamError> {
        let friction = self.model.build(sample_time)?;
        Guided::try_new(friction, self.ticks, self.limit, Self::UNITS)
    }

    fn table(&mut self) -> Table<'_> {
        self.model.table()
    }
}

/// Declares a board's outer task, where the build was given PRESLIDE_KOOPMAN: `outer_task::Outer`, `outer_task::SETTINGS`, and the board's
/// `Source` and `SOURCE`, the friction model that was exported, or none, beside the orders.
#[macro_export]
macro_rules! outer_task {
    () => {
        #[cfg(outer_task)]
        mod outer_task {
            include!(env!("PRESLIDE_KOOPMAN"));
        }
        #[cfg(all(outer_task, exported_model))]
        type Guided = Model;
        #[cfg(all(outer_task, exported_model))]
        const GUIDED: Guided = MODEL;
        #[cfg(all(outer_task, not(exported_model)))]
        type Guided = $crate::Unmodelled;
        #[cfg(all(outer_task, not(exported_model)))]
        const GUIDED: Guided = $crate::Unmodelled;

        #[cfg(outer_task)]
        type Source = $crate::Guiding<Guided>;
        #[cfg(outer_task)]
        const SOURCE: Source = $crate::Guiding::new(GUIDED, &outer_task::SETTINGS);
    };
}

/// No friction model, in single precision: the feedback alone, which an outer task may guide.
#[derive(Clone, Copy)]
pub struct Unmodelled;

impl Model for Unmodelled {
    type Friction = NoFriction<f32>;
    const UNITS: Units = Units::SI;

    fn build(&self, _sample_time: f64) -> Result<Self::Friction, ParamError> {
        Ok(NoFriction::new())
    }

    fn table(&mut self) -> Table<'_> {
        Table {
            layout: 0,
            origin: 0,
            values: &mut [],
        }
    }
}
