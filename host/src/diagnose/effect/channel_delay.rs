//! The force is recorded `τ` after the motion: `−τ·dF/dt`.

use super::{BARE, Card, Class, Effect, Part, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;

/// `channel_delay`.
pub struct ChannelDelay;

/// The column of a delay of an effort at the samples.
pub(in crate::diagnose) fn late(effort: &[f64]) -> Column {
    Column {
        sloped: effort.iter().map(|f| -f).collect(),
        ..Column::default()
    }
}

static CARD: Card = Card {
    id: form::CHANNEL_DELAY.id,
    name: "time shift between channels",
    words: "force and position sampled at different times",
    class: Class::Drive,
    axis: Axis::Acceleration,
    experiment: "fast sine motion at two frequencies: a delay's phase grows in proportion",
    shown_by: &[Part::Fast, Part::Nested],
    coefficient: "delay_s",
    acts_on_effort: true,
    ..BARE
};

impl Effect for ChannelDelay {
    fn card(&self) -> &Card {
        &CARD
    }

    fn columns(&self, _: &[f64], scene: &Scene) -> Vec<Column> {
        vec![late(&scene.core.fitted)]
    }

    /// A sample between reading the position and writing the force is how controllers work.
    fn is_harmless(&self, scene: &Scene, coefficients: &[f64]) -> bool {
        coefficients.iter().all(|delay| delay.abs() <= scene.s.dt)
    }
}
