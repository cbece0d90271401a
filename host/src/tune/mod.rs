//! How many blocks, in which arithmetic: accuracy against cycles.

pub mod cores;
mod counts;
pub mod observer;
mod present;
mod recommend;
#[cfg(test)]
mod tests;

pub use counts::{TOO_COARSE, counting, counting_note, too_coarse};

use crate::cost::{Cost, CostTable, WholeTick};
use crate::export::{carried, refused};
use preslide::ParamError;
use preslide_fit::effects::Effect;
use preslide_fit::friction::{FrictionModel, Path};
use preslide_fit::identify::Identification;
use preslide_fit::kernel::{Arithmetic, Counts, Kernel};
use preslide_fit::model::Model;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;
use recommend::recommend;
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
    /// Kernel, cycles and flash in a sentence, on the core of that name.
    pub fn said(&self, core: &str) -> String {
        let whole = self.tick.map_or(String::new(), |tick| {
            format!(
                " (the whole control tick with it: {:.0}, and {:.0} at worst)",
                tick.mean, tick.worst
            )
        });
        format!(
            "Kernel {} ({}) for {core}: {:.0} cycles a tick on average, {:.0} at worst{whole}; {:.0} bytes of flash, effects included.",
            self.kernel.name(),
            self.kernel.description(),
            self.cost.cycles_mean,
            self.cost.cycles_worst,
            self.cost.flash_bytes
        )
    }

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
    /// What the encoder's counts alone take from the model, see [`counting`] (NMSE, %).
    pub counting: f64,
}

impl Tuning {
    /// The choice to take.
    ///
    /// # Errors
    /// Why nothing fits.
    pub fn chosen(mut self) -> Result<Choice, String> {
        let (index, _) = self.recommended?;
        Ok(self.choices.swap_remove(index))
    }
}

/// A model to be tuned, with its error on motion that was not fitted (%).
struct Sized {
    model: Model,
    nmse_test: Option<f64>,
}

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
    tuning(&[sized], (model, None), &motion, costs, budget)
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
        .optimal()
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
    if found.best().size() == 0 {
        return Err(format!(
            "{}: `preslide identify` recommends Coulomb + viscous friction for this recording, which has no blocks to tune; `preslide identify … --blocks N -o MODEL.toml` and `preslide tune MODEL.toml` without --recording tune so many all the same",
            recording.name
        ));
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
    tuning(&models, (model, Some(found)), &motion, costs, budget)
}

/// What an encoder does not see of the blocks.
fn unseen_note(friction: &FrictionModel, count: f64, unit: &str) -> Option<String> {
    let (blocks, breakaway) = (friction.blocks(), friction.breakaway()?);
    let within = blocks
        .iter()
        .filter(|b| b.yield_displacement(breakaway) < count);
    let (unseen, all) = (within.count(), blocks.len());
    (unseen > 0).then(|| {
        format!(
            "blocks that yield within one encoder count ({}), unseen by the encoder: {unseen} of {all}",
            quantity(count, unit)
        )
    })
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

    /// What the model gives along it in `f64` (N or N·m).
    fn force_of(&self, friction: &FrictionModel) -> Result<Vec<f64>, ParamError> {
        let position: Vec<f64> = self
            .position
            .iter()
            .map(|&c| c as f64 * self.count)
            .collect();
        friction.force(Path {
            position: &position,
            velocity: &self.velocity,
            pieces: &self.pieces,
            sample_time: self.sample_time,
        })
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
            "the friction of the model is {}, and only Maxwell-slip models (kind = \"gms\") have blocks to tune; `preslide compare` lists what the others cost",
            friction.name()
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

/// Every kernel tried with every model, and the one to take.
fn tuning(
    models: &[Sized],
    (with_effects, found): (&Model, Option<&Identification>),
    motion: &Motion,
    costs: &CostTable,
    budget: Budget,
) -> Result<Tuning, String> {
    let refused = refused(with_effects);
    let mut effects = carried(with_effects);
    effects.retain(|effect| refused.iter().all(|(id, _)| *id != effect.id()));
    let variance = found.map(|found| {
        let samples = found.effort.len() as f64;
        let mean = found.effort.iter().sum::<f64>() / samples;
        found.effort.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / samples
    });
    let bench = Bench {
        motion,
        variance,
        effects: &effects,
        costs,
        budget,
    };
    let mut notes = effects_notes(&effects, &refused, costs);
    let unit = with_effects.motion.unit();
    notes.extend(unseen_note(&with_effects.friction, motion.count, unit));
    let largest = models
        .iter()
        .map(|sized| counting(&sized.model.friction, motion.count));
    let counting = largest.fold(0.0, f64::max);
    notes.extend(counting_note(counting, motion.count, unit));
    let (mut choices, mut without) = (Vec::new(), Vec::new());
    for sized in models {
        for tried in bench.choices(sized)? {
            match tried {
                Ok(choice) => choices.push(choice),
                Err(reason) => without.push(reason),
            }
        }
    }
    without.sort_by_key(|w| w.kernel.name());
    notes.extend(without_kernel(&without));
    notes.extend(cycles_notes(&choices));
    Ok(Tuning {
        recommended: match counting > TOO_COARSE {
            true => Err(too_coarse(counting, motion.count, unit)),
            false => recommend(&choices, budget, found),
        },
        counting,
        choices,
        notes,
        budget,
        origin: costs.origin.clone(),
        recorded: variance.is_some(),
    })
}

/// What kernels are tried on.
struct Bench<'a> {
    motion: &'a Motion,
    /// Of the recorded effort (N² or N²·m²).
    variance: Option<f64>,
    /// Those beside the friction model that a controller can use.
    effects: &'a [Effect],
    costs: &'a CostTable,
    budget: Budget,
}

impl Bench<'_> {
    /// The model in each kernel that has its law; in place of a choice, why there is none.
    fn choices(&self, sized: &Sized) -> Result<Vec<Result<Choice, Without>>, String> {
        let friction = &sized.model.friction;
        let FrictionModel::Gms {
            breakaway, blocks, ..
        } = friction
        else {
            return Ok(Vec::new());
        };
        let exact = self.motion.force_of(friction).map_err(|e| e.to_string())?;
        let choice = |kernel: Kernel, force: &[f64], alone: Cost| {
            let squares: f64 = force.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum();
            let mean_square = squares / force.len().max(1) as f64;
            let added = self.variance.map_or(0.0, |v| 100.0 * mean_square / v);
            let effects = self.costs.effects(self.effects, kernel.arithmetic().name());
            let cost = effects.beside(alone);
            Choice {
                kernel,
                share: self.budget.share_of(cost.cycles_worst),
                tick: self.costs.whole_tick(kernel.arithmetic().name(), &cost),
                cost,
                nmse_test: sized.nmse_test.map(|nmse| nmse + added),
                arithmetic: 100.0 * mean_square.sqrt() / breakaway,
            }
        };
        let tried = Kernel::ALL.into_iter().filter_map(|kernel| {
            let run = self.run(kernel, friction, blocks.len())?;
            Some(run.map(|(force, cost)| choice(kernel, &force, cost)))
        });
        Ok(tried.collect())
    }

    /// What a kernel computes along the motion (N or N·m) and costs alone; `None` where it does not have the law.
    fn run(
        &self,
        kernel: Kernel,
        friction: &FrictionModel,
        blocks: usize,
    ) -> Option<Result<(Vec<f64>, Cost), Without>> {
        let without = |reason: String| Without {
            kernel,
            blocks,
            reason,
        };
        let Some(cost) = self.costs.cost(kernel.name(), blocks) else {
            let reason = "it is not in the table of costs".to_owned();
            return Some(Err(without(reason)));
        };
        let force = kernel.force(friction, &self.motion.counts())?;
        Some(
            force
                .map(|force| (force, cost))
                .map_err(|reason| without(reason.to_string())),
        )
    }
}

/// Why a kernel does not run a model.
struct Without {
    kernel: Kernel,
    blocks: usize,
    reason: String,
}

/// A note for each kernel that does not run every size.
fn without_kernel(without: &[Without]) -> impl Iterator<Item = String> {
    let alike = without.chunk_by(|a, b| a.kernel == b.kernel);
    alike.filter_map(|of_kernel| {
        let first = of_kernel.first()?;
        let sizes: Vec<String> = of_kernel.iter().map(|w| w.blocks.to_string()).collect();
        let at = match sizes.len() {
            1 => String::new(),
            _ => format!("at N = {} ", first.blocks),
        };
        Some(format!(
            "{} cannot run this model with N = {}: {at}{}",
            first.kernel.name(),
            sizes.join(", "),
            first.reason
        ))
    })
}

/// What the cycles of the table are worth, and what they leave out.
fn cycles_notes(choices: &[Choice]) -> Vec<String> {
    let mut notes = Vec::new();
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
    notes
}

/// Whose cycles are in the figures, and whose are not.
fn effects_notes(
    effects: &[Effect],
    refused: &[(&'static str, &'static str)],
    costs: &CostTable,
) -> Vec<String> {
    let mut notes = Vec::new();
    let (float, fixed) = (
        costs.effects(effects, Arithmetic::F32.name()),
        costs.effects(effects, Arithmetic::I16F16.name()),
    );
    if !float.each.is_empty() {
        let list: Vec<String> = float
            .each
            .iter()
            .zip(&fixed.each)
            .map(|((id, float), (_, fixed))| {
                format!("{} {float:.0} and {fixed:.0}", id.replace('_', " "))
            })
            .collect();
        notes.push(format!(
            "cycles, flash and RAM include the model's effects, as they were measured in f32 and in I16F16 in a controller of four blocks: {} cycles",
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
