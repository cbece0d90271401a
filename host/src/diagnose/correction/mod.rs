//! What is to be added to a simulation's force so that it meets the recording: deltas in absolute units, term by term, never the recording's
//! whole friction.

mod code;
mod present;

use super::core::SLIPS;
use super::effect;
use super::expr::{Expr, Function, Input};
use super::named::{Name, Named};
use super::null_model::{Hypothesis, NullModel};
use super::signals::Signals;
use super::simulation::{Correction as Core, Few, few_blocks};
use super::term::Term;
use super::weak::Column;
pub use code::Language;
use preslide_fit::recording::Recording;
use preslide_fit::signal::Deflection;
use preslide_fit::statistics::{Estimate, nmse};

/// Parallel springs that slip: stiffness (N/m or N·m/rad, or that over a level) and yield displacement (m or rad).
type Blocks = Vec<(f64, f64)>;

/// What a simulation lacks compared with a recording.
pub struct Correction {
    /// What is added, one after the other.
    pub terms: Vec<Added>,
    /// What is stated, and left out since the samples are worse with it.
    left_out: Vec<&'static str>,
    /// Blocks of the friction's difference; a stiffness below zero is what the simulation has too much of.
    blocks: Blocks,
    /// Blocks of the recording's own friction, over its level.
    direction: Blocks,
    /// Velocity and acceleration that the terms were computed with.
    motion: [Vec<f64>; 2],
    /// Effort of the simulation for the recorded motion (N or N·m).
    simulated: Vec<f64>,
    /// Part of the measured effort's variance (%) that simulation and corrected simulation leave at the samples.
    pub left: [f64; 2],
}

/// How certain a term is that stands for nothing that is stated, and goes with the others.
const REFITTED: &str = "refitted";

/// A term of a correction.
pub struct Added {
    /// Id in JSON and code; the second of one kind has a `_2` behind it.
    pub id: String,
    /// What it is, for a person.
    words: &'static str,
    /// `certain`, `likely`, or [`REFITTED`].
    certainty: &'static str,
    /// Keys of a linear axis, in absolute units.
    pub parameters: Vec<(String, Estimate)>,
    /// Force at the samples (N or N·m).
    pub force: Vec<f64>,
    /// The same as a formula; `None` if it is not a function of the motion at one instant.
    formula: Option<Expr>,
}

impl Correction {
    /// What a simulation of this effort for the recorded motion (N or N·m) lacks of a recording; `None` where none of the `effects` is stated. Where
    /// the effort was reproduced from another motion, inertia and friction are not fitted to what that misses: they stand where they are stated.
    pub(super) fn of(
        (null, state): (&NullModel, &Hypothesis),
        effects: &[Named],
        recording: &Recording,
        (simulated, is_reproduced): (Vec<f64>, bool),
    ) -> Option<Self> {
        effects.iter().find(|e| e.confident)?;
        let s = &null.rows.s;
        let stated = |term: &Term| effects.iter().find(|e| e.confident && e.is_of(term));
        let own = state.terms.iter().enumerate();
        let own: Vec<_> = own
            .filter_map(|(i, term)| Some((i, term, stated(term)?)))
            .collect();
        let mut left = null.rows.target.clone();
        for (index, _, _) in &own {
            let force = state.force_of(*index);
            left.iter_mut().zip(force).for_each(|(l, f)| *l -= f);
        }
        let mut few = few_blocks(null, &left)?;
        let stands = |core: Core| {
            let own = |e: &Named| matches!(e.name, Name::Correction(own) if own == core);
            !is_reproduced || effects.iter().any(|e| e.confident && own(e))
        };
        if !stands(Core::Friction) {
            few.blocks.clear();
        }
        let level = null.baseline.level;
        let direction: Blocks = null
            .baseline
            .blocks
            .iter()
            .map(|(k, d)| (k / level, *d))
            .collect();
        let [difference, _] = deflected(s, &few.blocks);
        let [all, slipping] = deflected(s, &direction);
        let along = Along {
            s,
            sums: [difference, all, slipping],
        };
        let mut terms: Vec<Added> = Vec::new();
        if null.core.first_of_friction() > 0 && stands(Core::Inertia) {
            terms.push(along.of_core(effects, Core::Inertia, &few));
        }
        if stands(Core::Friction) {
            terms.push(along.of_core(effects, Core::Friction, &few));
        }
        for (index, term, stated) in own {
            let mut added = along.of_effect(stated, term, state.coefficients(index), null);
            let before = terms.iter().filter(|t| t.words == added.words).count();
            if before > 0 {
                added.id += &format!("_{}", before + 1);
            }
            terms.push(added);
        }
        let (left, left_out) = leave_out(&mut terms, &simulated, recording);
        terms.iter().find(|t| t.certainty != REFITTED)?;
        Some(Self {
            terms,
            left_out,
            blocks: few.blocks,
            direction,
            motion: [s.v.clone(), s.a.clone()],
            simulated,
            left,
        })
    }
}

/// Takes out, the worst first, what the samples are worse with than the simulation by itself: what the fit sees through its kernel may swing otherwise
/// there. What simulation and corrected simulation leave (%) is printed, and what went.
fn leave_out(
    terms: &mut Vec<Added>,
    simulated: &[f64],
    recording: &Recording,
) -> ([f64; 2], Vec<&'static str>) {
    let all: Vec<usize> = (0..simulated.len()).collect();
    let left = |terms: &[Added], without: usize| {
        let mut sum = simulated.to_vec();
        for (_, term) in terms.iter().enumerate().filter(|(i, _)| *i != without) {
            sum.iter_mut().zip(&term.force).for_each(|(c, f)| *c += f);
        }
        nmse(&recording.effort, &sum, &all)
    };
    let alone = left(&[], 0);
    let mut gone = Vec::new();
    let mut corrected = left(terms, terms.len());
    while corrected > alone {
        let without = (0..terms.len()).map(|i| (i, left(terms, i)));
        let Some((worst, less)) = without.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        gone.push(terms.remove(worst).words);
        corrected = less;
    }
    ([alone, corrected], gone)
}

impl Named {
    /// Whether it is this term.
    fn is_of(&self, term: &Term) -> bool {
        let own = self.term.as_ref();
        own.is_some_and(|own| own.is_like(term) && own.shape == term.shape)
    }
}

/// A motion, and the sums over blocks along it: of the correction, of the direction, and of what slips of it.
struct Along<'a> {
    s: &'a Signals,
    sums: [Vec<f64>; 3],
}

impl Along<'_> {
    /// A formula at the samples.
    fn force(&self, formula: &Expr) -> Vec<f64> {
        let s = self.s;
        let of = |column: &Option<Vec<f64>>, i: usize| column.as_ref().map_or(0.0, |c| c[i]);
        let at = |i: usize| {
            formula.value(&|input| match input {
                Input::Time => s.t[i],
                Input::Position => s.x[i],
                Input::Velocity => s.v[i],
                Input::Acceleration => s.a[i],
                Input::Path => s.path[i],
                Input::Temperature => of(&s.temperature, i),
                Input::Load => of(&s.load, i),
                Input::Blocks => self.sums[0][i],
                Input::Direction => self.sums[1][i],
                Input::Slipping => self.sums[2][i],
            })
        };
        (0..s.x.len()).map(at).collect()
    }

    /// An effect, by its formula or by its columns.
    fn of_effect(
        &self,
        stated: &Named,
        term: &Term,
        coefficients: &[f64],
        null: &NullModel,
    ) -> Added {
        let level = null.baseline.level;
        let effect = effect::by_id(stated.id());
        let formula = effect.and_then(|effect| effect.formula(&stated.parameters, level));
        let force = match &formula {
            Some(formula) => self.force(formula),
            None => self.of_columns(&term.columns(&null.scene()), coefficients),
        };
        let absolute = stated
            .parameters
            .iter()
            .map(|(key, e)| absolute(key, e, level));
        Added {
            id: stated.id().to_owned(),
            words: stated.name.words(),
            certainty: stated.certainty(),
            parameters: absolute.collect(),
            force,
            formula,
        }
    }

    /// Inertia, or level and shape of the hysteresis.
    fn of_core(&self, effects: &[Named], core: Core, few: &Few) -> Added {
        let stated = |e: &&Named| matches!(e.name, Name::Correction(own) if own == core);
        let stated = effects.iter().find(stated);
        let (key, value, formula) = match core {
            Core::Inertia => (
                "mass_kg",
                few.inertia,
                few.inertia * Expr::from(Input::Acceleration),
            ),
            Core::Friction => {
                let sliding = few.blocks.iter().map(|(k, d)| k * d);
                let smooth = few.smooth.iter();
                let formula =
                    smooth
                        .clone()
                        .fold(Expr::from(Input::Blocks), |sum, (level, slow)| {
                            sum + *level
                                * (1.0 / slow * Expr::from(Input::Velocity)).of(Function::Tanh)
                        });
                (
                    "coulomb_N",
                    sliding.chain(smooth.map(|own| own.0)).sum(),
                    formula,
                )
            }
        };
        let ci95 = stated.and_then(|e| e.parameters[0].1.ci95);
        let estimate = Estimate { value, ci95 };
        Added {
            id: core.id().to_owned(),
            words: match core {
                Core::Inertia => "inertia",
                Core::Friction => "Coulomb friction, and how it builds up after a reversal",
            },
            certainty: stated
                .filter(|e| e.confident)
                .map_or(REFITTED, |e| e.certainty()),
            parameters: vec![(key.to_owned(), estimate)],
            force: self.force(&formula),
            formula: Some(formula),
        }
    }

    /// The sum of columns, derivatives taken.
    fn of_columns(&self, columns: &[Column], coefficients: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; self.s.x.len()];
        for (column, c) in columns.iter().zip(coefficients) {
            let slope = |values: &Vec<f64>| match values.is_empty() {
                true => Vec::new(),
                false => self.s.smooth_slope(values),
            };
            let parts = [
                column.value.clone(),
                slope(&column.sloped),
                slope(&slope(&column.curved)),
            ];
            for part in parts {
                force.iter_mut().zip(part).for_each(|(f, p)| *f += c * p);
            }
        }
        force
    }
}

/// Force of blocks along a motion from no force on, and the part of those that slip.
fn deflected(s: &Signals, blocks: &Blocks) -> [Vec<f64>; 2] {
    let (mut all, mut slipping) = (vec![0.0; s.x.len()], vec![0.0; s.x.len()]);
    for &(k, d) in blocks {
        for (i, z) in Deflection::along(&s.x, &s.pieces, d)
            .z
            .into_iter()
            .enumerate()
        {
            all[i] += k * z;
            if z.abs() >= SLIPS * d {
                slipping[i] += k * z;
            }
        }
    }
    [all, slipping]
}

/// A parameter that is a share of the friction level, as a force.
fn absolute(key: &str, estimate: &Estimate, level: f64) -> (String, Estimate) {
    let number = |key: &str| {
        key.strip_prefix("cosine")
            .is_some_and(|n| n.parse::<u32>().is_ok())
    };
    let named = match key {
        "asymmetry" => Some("half_difference_N".to_owned()),
        _ if key.starts_with("level") => Some(key.replacen("level", "force_N", 1)),
        _ if number(key) => Some(format!("{key}_N")),
        _ => None,
    };
    let scaled = Estimate {
        value: level * estimate.value,
        ci95: estimate.ci95.map(|ends| ends.map(|end| level * end)),
    };
    named.map_or_else(|| (key.to_owned(), *estimate), |key| (key, scaled))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::effect::tests::{Stage, shapes};
    use crate::diagnose::effect::{ALL, Fitted};
    use preslide_fit::recording::MotionKind;
    use std::collections::BTreeSet;

    /// Every formula is the force that its effect was fitted with, whatever its shape and coefficients.
    #[test]
    fn formulas_are_what_their_effects_are_fitted_with() {
        let mut told = BTreeSet::new();
        for kind in [MotionKind::Linear, MotionKind::Rotary] {
            let stage = Stage::new(kind, 1.0);
            let (scene, level) = (stage.scene(), stage.core.level);
            let s = &stage.s;
            let share = |(k, d): &(f64, f64)| (k / level, *d);
            let direction: Blocks = stage.core.blocks.iter().map(share).collect();
            let [all, slipping] = deflected(s, &direction);
            let along = Along {
                s,
                sums: [vec![0.0; s.x.len()], all, slipping],
            };
            for effect in ALL {
                for shape in &shapes(effect, &scene) {
                    let columns = effect.columns(shape, &scene);
                    let coefficients: Vec<f64> =
                        (1..=columns.len()).map(|i| 0.3 / i as f64).collect();
                    let values = effect.values(&Fitted {
                        shape,
                        coefficients: &coefficients,
                        shape_errors: &[],
                        errors: &[],
                        folds: 2,
                        at_shape: &|_| None,
                        scene,
                    });
                    let Some(formula) = effect.formula(&values, level) else {
                        continue;
                    };
                    let own = along.force(&formula);
                    let fitted = along.of_columns(&columns, &coefficients);
                    let largest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
                    let size = largest(&mut fitted.iter().map(|f| f.abs()));
                    let apart = largest(&mut own.iter().zip(&fitted).map(|(a, b)| (a - b).abs()));
                    assert!(
                        apart <= 1e-9 * size,
                        "{} {shape:?}: {apart} of {size}: {formula}",
                        effect.id()
                    );
                    told.insert(effect.id());
                }
            }
        }
        for effect in ALL {
            let is_told = told.contains(effect.id());
            assert_eq!(is_told, effect.card().formula.is_some(), "{}", effect.id());
        }
    }
}
