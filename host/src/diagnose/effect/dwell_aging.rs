//! `m = 1 + a·log10(1 + θ/τ)`: the age `θ` of the contact grows with time and is erased along a path (Dieterich 1979).

use super::{BARE, Card, Class, Effect, Part, Scale, Scene};
use crate::diagnose::axis::Axis;
use crate::diagnose::weak::Column;
use preslide_fit::effects::form;
use preslide_fit::statistics::{bounds, quantile_between_ranks, spread};

/// Ages from which the level grows that are tried (s): rests that a recording has last as long.
const TIME_CONSTANTS_S: [f64; 2] = [0.1, 0.5];

/// `dwell_aging`.
pub struct DwellAging;

static CARD: Card = Card {
    id: form::DWELL_AGING.id,
    name: "ageing at rest",
    words: "a breakaway peak that grows with the duration of rest",
    class: Class::Drift,
    axis: Axis::Time,
    experiment: "rests of 0.1, 1 and 10 s before the same slow move",
    shown_by: &[Part::Rests, Part::Speeds],
    coefficient: "level_per_decade",
    shape: &[
        ("time_constant_s", Scale::Logarithmic),
        ("erasing_path_m", Scale::Logarithmic),
    ],
    is_transient: true,
    lacks: |s| {
        let (from, to) = bounds(&s.dwell);
        (to < 10.0 * from.max(0.02)).then_some("rests of different length")
    },
    ..BARE
};

impl Effect for DwellAging {
    fn card(&self) -> &Card {
        &CARD
    }

    fn grid(&self, scene: &Scene) -> Vec<Vec<f64>> {
        let (least, most) = bounds(&scene.s.dwell);
        if most <= 0.05 || most < 1.5 * least {
            return Vec::new();
        }
        let erased = quantile_between_ranks(&scene.s.last_stroke, 0.5);
        let paths = spread(erased / 300.0, erased, 5);
        TIME_CONSTANTS_S
            .iter()
            .flat_map(|&time| paths.iter().map(move |&path| vec![time, path]))
            .collect()
    }

    fn columns(&self, shape: &[f64], scene: &Scene) -> Vec<Column> {
        let &[time_constant, erasing] = shape else {
            return Vec::new();
        };
        let (mut age, mut path) = (0.0, 0.0);
        let aged = scene.s.path.iter().map(|&now| {
            age = (age + scene.s.dt) / (1.0 + (now - path) / erasing);
            path = now;
            (1.0f64 + age / time_constant).log10()
        });
        let level: Vec<f64> = aged.collect();
        vec![scene.friction(|i| level[i])]
    }

    fn admits(&self, _: &[f64], coefficients: &[f64]) -> bool {
        matches!(coefficients, [c] if *c > 0.0)
    }
}
