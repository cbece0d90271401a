//! How many blocks, in which arithmetic: accuracy against cycles.

pub mod cores;
pub mod kernel;
mod present;
#[cfg(test)]
mod tests;

use crate::cost::{Cost, CostTable, Standing, WholeTick};
use crate::effects::Effect;
use crate::export::{carried, refused};
use crate::friction::{FrictionModel, Path};
use crate::identify::{Identification, Method};
use crate::model::Model;
use crate::recording::Recording;
use kernel::{Counts, Kernel};
use std::ops::Range;

/// What the controller gives.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Core clock (Hz).
    pub clock: f64,
    /// Control ticks per second (Hz).
    pub rate: f64,
    /// Share of the processor that friction may take (-).
    pub share: f64,
}

impl Budget {
    /// Share of the processor (-) that so many cycles a tick take.
    pub fn share_of(&self, cycles: f64) -> f64 {
        cycles * self.rate / self.clock
    }
}

/// One kernel at one number of blocks.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The kernel.
    pub kernel: Kernel,
    /// Its cost.
    pub cost: Cost,
    /// Share of the processor on the worst path (-).
    pub share: f64,
    /// The whole control tick with the kernel in it, where the table has one.
    pub tick: Option<WholeTick>,
    /// NMSE (13) of the model on motion that was not fitted, and of the arithmetic (%); `None` without a recording.
    pub nmse_test: Option<f64>,
    /// Rms of what the arithmetic adds, against the same model in `f64` on the same counts (% of `F_s`).
    pub arithmetic: f64,
}

impl Choice {
    /// Friction stays within its budget, and the whole tick, where it is known, within the time between two.
    pub fn fits(&self, budget: Budget) -> bool {
        let whole = self.tick.map_or(0.0, |tick| budget.share_of(tick.worst));
        self.share <= budget.share && whole <= 1.0
    }
}

/// All choices, and the one to take.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// By number of blocks, then as [`Kernel::ALL`].
    pub choices: Vec<Choice>,
    /// Index into `choices`, and why; or why nothing fits.
    pub recommended: Result<(usize, String), String>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// The budget that was given.
    pub budget: Budget,
    /// Where the costs come from.
    pub origin: String,
    /// Whether a recording decided the accuracy.
    pub recorded: bool,
}

/// A model to be tuned, with its error on motion that was not fitted (%).
struct Sized {
    model: Model,
    nmse_test: Option<f64>,
}

/// Another block is worth its cycles if it takes away a tenth of the error…
const WORTH: f64 = 0.1;
/// …and at least this much of it (percentage points of NMSE).
const LEAST_WORTH: f64 = 0.05;
/// Arithmetic may add this much (% of `F_s`, rms) before a dearer kernel is taken.
const ARITHMETIC: f64 = 0.5;

/// Tunes the model's own number of blocks, along strokes made up for it.
///
/// # Errors
/// Why the model cannot be tuned.
pub fn of_model(
    model: &Model,
    count: f64,
    costs: &CostTable,
    budget: Budget,
) -> Result<Tuning, String> {
    let motion = made_up_strokes(&model.friction, count, 1.0 / budget.rate)?;
    let sized = Sized {
        model: model.clone(),
        nmse_test: None,
    };
    tuning(&[sized], model, &motion, None, costs, budget)
}

/// Tunes what `identify` found on a recording, at every number of blocks, beside the effects of `model`.
///
/// # Errors
/// Why the recording cannot be tuned for.
pub fn of_recording(
    recording: &Recording,
    found: &Identification,
    model: &Model,
    count: f64,
    costs: &CostTable,
    budget: Budget,
) -> Result<Tuning, String> {
    let models: Vec<Sized> = found
        .candidates
        .iter()
        .filter(|c| c.size() > 0 && c.method == Method::Optimal)
        .map(|c| Sized {
            model: c.model.clone(),
            nmse_test: Some(c.nmse_test),
        })
        .collect();
    if models.is_empty() {
        return Err(
            "identify found no Maxwell-slip model in this recording; try `preslide compare`"
                .to_owned(),
        );
    }
    let motion = Motion {
        position: recording
            .position
            .iter()
            .map(|x| (x / count).round() as i64)
            .collect(),
        velocity: found.velocity.clone(),
        pieces: recording.pieces.clone(),
        count,
        sample_time: recording.sample_time_s(),
    };
    let mean = found.effort.iter().sum::<f64>() / found.effort.len() as f64;
    let variance =
        found.effort.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / found.effort.len() as f64;
    tuning(&models, model, &motion, Some(variance), costs, budget)
}

/// A motion in counts.
struct Motion {
    position: Vec<i64>,
    velocity: Vec<f64>,
    pieces: Vec<Range<usize>>,
    count: f64,
    sample_time: f64,
}

impl Motion {
    fn counts(&self) -> Counts<'_> {
        Counts {
            position: &self.position,
            velocity: &self.velocity,
            pieces: &self.pieces,
            count: self.count,
            sample_time: self.sample_time,
        }
    }
}

/// Strokes forth and back whose length shrinks from four times the longest yield displacement to a count: they take every
/// block through slip, reversal and inner loops.
fn made_up_strokes(
    friction: &FrictionModel,
    count: f64,
    sample_time: f64,
) -> Result<Motion, String> {
    let FrictionModel::Gms {
        breakaway,
        blocks,
        sliding,
    } = friction
    else {
        return Err(format!(
            "the model is a {}, and only Maxwell-slip models (kind = \"gms\") have blocks to tune; `preslide compare` lists what the others cost",
            friction.kind()
        ));
    };
    let longest = blocks
        .iter()
        .map(|b| b.yield_displacement(*breakaway))
        .fold(0.0, f64::max);
    let mut position = Vec::new();
    let (mut at, mut stroke, mut forward) = (0.0, (4.0 * longest / count).clamp(8.0, 1e6), 1.0);
    while stroke >= 1.0 {
        let ticks = (stroke as usize).clamp(1, 500);
        let start = at;
        for tick in 1..=ticks {
            at = start + forward * stroke * tick as f64 / ticks as f64;
            position.push(at.round() as i64);
        }
        forward = -forward;
        stroke *= 0.9;
    }
    let speed = sliding.map_or(1.0, |s| s.stribeck_velocity);
    let samples = position.len();
    Ok(Motion {
        velocity: position
            .windows(2)
            .map(|w| (w[1] - w[0]).signum() as f64 * speed)
            .chain([0.0])
            .collect(),
        position,
        pieces: std::iter::once(0..samples).collect(),
        count,
        sample_time,
    })
}

fn tuning(
    models: &[Sized],
    with_effects: &Model,
    motion: &Motion,
    variance: Option<f64>,
    costs: &CostTable,
    budget: Budget,
) -> Result<Tuning, String> {
    let position: Vec<f64> = motion
        .position
        .iter()
        .map(|&c| c as f64 * motion.count)
        .collect();
    let path = Path {
        position: &position,
        velocity: &motion.velocity,
        pieces: &motion.pieces,
        sample_time: motion.sample_time,
    };
    let refused = refused(with_effects);
    let mut effects = carried(with_effects);
    effects.retain(|effect| refused.iter().all(|(id, _)| *id != effect.id));
    let (mut choices, mut notes) = (Vec::new(), effects_notes(&effects, &refused, costs));
    for sized in models {
        let FrictionModel::Gms {
            breakaway, blocks, ..
        } = &sized.model.friction
        else {
            continue;
        };
        let exact = sized
            .model
            .friction
            .force(path)
            .map_err(|e| e.to_string())?;
        for kernel in Kernel::ALL {
            let Some(cost) = costs.cost(kernel.name(), blocks.len()) else {
                notes.push(format!(
                    "{} with N = {} is not in the table of costs",
                    kernel.name(),
                    blocks.len()
                ));
                continue;
            };
            let force = match kernel.force_of(&sized.model.friction, &motion.counts()) {
                Some(Ok(force)) => force,
                Some(Err(reason)) => {
                    notes.push(format!(
                        "{} with N = {} cannot run this model: {reason}",
                        kernel.name(),
                        blocks.len()
                    ));
                    continue;
                }
                None => continue,
            };
            let squares: f64 = force.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum();
            let cost = costs.effects(&effects, kernel.arithmetic()).beside(cost);
            let mean_square = squares / force.len().max(1) as f64;
            let added = variance.map_or(0.0, |variance| 100.0 * mean_square / variance);
            choices.push(Choice {
                kernel,
                share: budget.share_of(cost.cycles_worst),
                tick: costs.whole_tick(kernel.arithmetic(), &cost),
                cost,
                nmse_test: sized.nmse_test.map(|nmse| nmse + added),
                arithmetic: 100.0 * mean_square.sqrt() / breakaway,
            });
        }
    }
    if let Standing::Estimated(spread) = costs.standing {
        notes.push(format!(
            "the cycles are estimates, ±{:.0} %: the worst and the shares count the dear end",
            100.0 * spread
        ));
    }
    if costs.standing == Standing::Range {
        notes
            .push("the cycles are a range: the worst and the shares count the dear end".to_owned());
    }
    if choices.iter().any(|c| c.tick.is_none()) {
        notes.push(
            "the table of costs has no whole control tick, so shares are of friction alone"
                .to_owned(),
        );
    }
    if choices.iter().any(|c| !c.cost.inlined) {
        notes.push(
            "the table of costs has calls only: its cycles include the call, and inlined it takes less".to_owned(),
        );
    }
    let recommended = recommend(&choices, budget);
    Ok(Tuning {
        choices,
        recommended,
        notes,
        budget,
        origin: costs.origin.clone(),
        recorded: variance.is_some(),
    })
}

/// Whose cycles are in the figures, and whose are not.
fn effects_notes(
    effects: &[Effect],
    refused: &[(&'static str, &'static str)],
    costs: &CostTable,
) -> Vec<String> {
    let mut notes = Vec::new();
    let (float, fixed) = (
        costs.effects(effects, "f32"),
        costs.effects(effects, "i16f16"),
    );
    if !float.each.is_empty() {
        let list: Vec<String> = float
            .each
            .iter()
            .zip(&fixed.each)
            .map(|((id, float), (_, fixed))| format!("{id} {float:.0} and {fixed:.0}"))
            .collect();
        notes.push(format!(
            "cycles, flash and RAM include the model's effects, measured beside four blocks in f32 and in I16F16: {}; a kernel in whole numbers \
             is given those in I16F16, which the firmware has to compute beside it (no type composes the two)",
            list.join(", ")
        ));
    }
    if !float.missing.is_empty() {
        notes.push(format!(
            "the table of costs lacks {}: not counted",
            float.missing.join(", ")
        ));
    }
    for (id, reason) in refused {
        notes.push(format!("{id} is not counted: {reason}"));
    }
    notes
}

/// The fewest blocks after which no more are worth their cycles, in the cheapest arithmetic that adds little.
fn recommend(choices: &[Choice], budget: Budget) -> Result<(usize, String), String> {
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let cheapest = choices.iter().min_by(|a, b| a.share.total_cmp(&b.share));
    let Some(cheapest) = cheapest else {
        return Err("no kernel can run this model; see the notes".to_owned());
    };
    if cheapest.share > budget.share {
        let name = cheapest.kernel.name();
        return Err(format!(
            "nothing fits: the cheapest, {name} with N = {}, takes {} of the processor, the budget is {}; lower --rate to {:.0} Hz or allow --budget {:.2}%",
            cheapest.cost.blocks,
            percent(cheapest.share),
            percent(budget.share),
            budget.rate * budget.share / cheapest.share,
            100.0 * cheapest.share,
        ));
    }
    let fitting: Vec<&Choice> = choices.iter().filter(|c| c.fits(budget)).collect();
    let shortest = choices.iter().filter_map(|c| c.tick.map(|tick| tick.worst));
    let shortest = shortest.fold(f64::INFINITY, f64::min);
    if fitting.is_empty() {
        return Err(format!(
            "nothing fits: the whole control tick takes {shortest:.0} cycles at worst with the cheapest kernel, and {:.0} lie between two ticks; lower --rate to {:.0} Hz",
            budget.clock / budget.rate,
            budget.clock / shortest,
        ));
    }
    let sound = |c: &&Choice| c.arithmetic <= ARITHMETIC;
    let pool: Vec<&Choice> = match fitting.iter().copied().filter(sound).collect::<Vec<_>>() {
        sound if sound.is_empty() => fitting,
        sound => sound,
    };
    let best = pool
        .iter()
        .filter_map(|c| c.nmse_test)
        .fold(f64::INFINITY, f64::min);
    let enough = |c: &&&Choice| {
        c.nmse_test
            .is_none_or(|nmse| nmse <= best + (WORTH * best).max(LEAST_WORTH))
    };
    let chosen = pool.iter().filter(enough).min_by(|a, b| {
        let blocks = a.cost.blocks.cmp(&b.cost.blocks);
        blocks.then(a.share.total_cmp(&b.share))
    });
    let Some(chosen) = chosen else {
        return Err("no choice has a finite error; see the notes".to_owned());
    };
    let index = choices
        .iter()
        .position(|c| std::ptr::eq(c, *chosen))
        .unwrap_or(0);
    let blocks = chosen.cost.blocks;
    let accuracy = match chosen.nmse_test {
        Some(nmse) if blocks == 1 => {
            format!(
                "N = 1 is enough here: it leaves {nmse:.2} % NMSE on motion that was not fitted, and no larger model that fits leaves less than {best:.2} %"
            )
        }
        Some(nmse) => format!(
            "N = {blocks} leaves {nmse:.2} % NMSE on motion that was not fitted; more blocks that fit the budget reach {best:.2} % at best, fewer leave more than a tenth more"
        ),
        None => format!("the model has N = {blocks}; give --recording to have N chosen as well"),
    };
    let whole = chosen.tick.map_or(String::new(), |tick| {
        format!(
            "; the whole control tick then takes {} at worst, {:.0} cycles",
            percent(budget.share_of(tick.worst)),
            tick.worst
        )
    });
    let reason = format!(
        "{accuracy}; {} ({}) is the cheapest arithmetic that adds at most {ARITHMETIC} % of F_s (it adds {:.3} %) and takes {} of the processor at worst, {:.0} cycles a tick, of {} allowed{whole}",
        chosen.kernel.name(),
        chosen.kernel.description(),
        chosen.arithmetic,
        percent(chosen.share),
        chosen.cost.cycles_worst,
        percent(budget.share),
    );
    Ok((index, reason))
}
