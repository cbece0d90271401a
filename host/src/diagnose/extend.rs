//! The model file that a diagnosis ends in: the confident effects on the user's own model with its parameters refitted, or on the refitted core.

use super::effect::ALWAYS_FREE;
use super::given::{Given, delay_of};
use super::is_late;
use super::modelled::effort_of;
use super::named::Name;
use super::null_model::{Hypothesis, NullModel};
use super::parameters::parameters;
use super::term::Term;
use super::verdict::{Diagnosis, Extended};
use super::weak::Column;
use preslide_fit::friction::{FrictionModel, MOST_BLOCKS};
use preslide_fit::model::{Model, key_of};
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::quantity;
use preslide_fit::report::units::name_and_unit;
use preslide_fit::simulate::force_of_motion;

/// NMSE on rows held out, over that of the refitted core, up to which the user's own friction law stays: more is a hysteresis that it does not
/// have.
const AS_GOOD: f64 = 1.25;

/// A model, and its NMSE (%) on rows held out: what the file leaves, and what its parameters cost on rows that they were not fitted to.
struct Candidate {
    written: Extended,
    left: f64,
}

/// Why nothing is refitted where friction reverses with the speed.
const ANOTHER_LAW: &str = "nothing: friction reverses with the speed, as no law of a model file does, and a refit would bend the parameters to that";

/// Share of the friction level that the weakest blocks have together: no identification repeats to within as much.
const WEAKEST: f64 = 0.005;

impl Diagnosis {
    /// The extended model, of the user's or of the fit's: never one that leaves more on rows held out, or by the simulation that
    /// `preslide simulate` makes. Against a simulation the effects are what it lacks, and inertia and friction are the recording's own, which their
    /// levels refer to. `recording` is the one that was diagnosed.
    pub fn extended_model(&self, recording: &Recording) -> &Extended {
        self.extended_model.get_or_init(|| self.extend(recording))
    }

    fn extend(&self, recording: &Recording) -> Extended {
        let (null, user) = (&self.null, self.user.as_ref());
        let mut terms = self.states[1].terms.clone();
        for term in &mut terms {
            if let Some(effect) = term.effect() {
                term.shape = effect.storable(&term.shape);
            }
        }
        let refitted = null.fit(&terms);
        let state = refitted.as_ref().unwrap_or(&self.states[1]);
        let coarse = (user.is_some() && !null.core.corrects).then(|| {
            let null = null.coarser(&terms)?;
            Some((null.fit(&terms)?, null))
        });
        let coarse = coarse.flatten();
        let (on, of) = coarse.as_ref().map_or((state, null), |(s, n)| (s, n));
        let core = self.on_the_core(of, on, recording, user);
        let recording = &recording.at_one_rate();
        let of_fit = self.fit.as_ref().and_then(|fit| fit.model());
        let of_fit = of_fit.as_ref();
        let judged = of_fit.filter(|_| user.is_none());
        let judged = judged.and_then(|m| Given::of(null, &self.states[1], recording, m, None));
        let own = user.zip(self.given_model.as_ref());
        let Some((user, given)) = own.or_else(|| of_fit.zip(judged.as_ref())) else {
            return core;
        };
        let nmse = |model: &Model| {
            let modelled = null.rows.weak.rows(&effort_of(model, recording).ok()?);
            let measured = null.rows.weak.rows(&Column::of(recording.effort.clone()));
            let left = measured.iter().zip(modelled);
            Some(
                null.rows
                    .nmse(&left.map(|(f, m)| f - m).collect::<Vec<_>>()),
            )
        };
        let candidate = |written: Extended, optimism: f64| {
            let left = nmse(&written.model)? + optimism.max(0.0);
            Some(Candidate { written, left })
        };
        let own = self.on_their_own(state, given.model.clone(), user, recording.effort_unit());
        let own = candidate(own, given.refitted.test - given.refitted.train);
        let core = candidate(core, self.extended.test - self.extended.train);
        let wrong_shape = self.confident().any(|e| matches!(e.name, Name::Hysteresis));
        // What follows the speed alone no blocks stand for, either.
        let core = core.filter(|_| given.law.is_none());
        let best = match (own, core) {
            (Some(own), Some(core)) if wrong_shape || own.left > AS_GOOD * core.left => core,
            (Some(own), _) => own,
            (None, Some(core)) => core,
            (None, None) => return as_given(user),
        };
        let simulated = |model: &Model| {
            let found = force_of_motion(model, recording).ok()?;
            Some(found.agreement?.nmse)
        };
        let by_simulation = simulated(&best.written.model).zip(simulated(user));
        let is_better =
            best.left < given.stands && by_simulation.is_none_or(|(left, stands)| left < stands);
        let mut written = if is_better {
            best.written
        } else {
            as_given(user)
        };
        if given.law.is_some() {
            written.is_of_another_law = true;
            if !is_better {
                written.replaces = vec![ANOTHER_LAW.to_owned()];
            }
        }
        written
    }

    /// The confident effects on the user's own friction law, its parameters refitted.
    fn on_their_own(
        &self,
        state: &Hypothesis,
        mut model: Model,
        user: &Model,
        effort: &str,
    ) -> Extended {
        let mut refused = Vec::new();
        let in_fit = |term: &Term| {
            let mut own = self.effects.iter().filter(|e| e.in_fit);
            own.any(|e| e.term.as_ref().is_some_and(|own| own.is_like(term)))
        };
        for index in (self.given..state.terms.len()).filter(|i| !in_fit(&state.terms[*i])) {
            enter(&self.null, state, index, &mut model, &mut refused);
        }
        self.enter_channel(&mut model, &mut refused);
        Extended {
            replaces: changes(user, &model, effort),
            model,
            refused,
            is_on_the_core: false,
            is_as_given: false,
            is_of_another_law: false,
        }
    }

    /// Enters what lies between the machine and the recorded effort: a delay, an end.
    fn enter_channel(&self, model: &mut Model, refused: &mut Vec<String>) {
        for own in self.effects.iter().filter(|e| e.is_in_the_channel()) {
            let has = model.effects.iter().any(|e| e.id() == own.id());
            if let Name::Entry(effect) = own.name
                && (!has || effect.card().recurs)
                && let Err(reason) = effect.extend(&own.parameters, model)
            {
                refused.push(format!("{}: {reason}", own.id()));
            }
        }
        let late = self
            .allowed
            .map(|delay| ("delay_s".to_owned(), delay.delay_s));
        if let Some(late) = late.filter(|_| !is_late(model))
            && let Err(reason) = ALWAYS_FREE.extend(&[late], model)
        {
            refused.push(format!("{}: {reason}", ALWAYS_FREE.id()));
        }
    }

    /// All effects on the refitted core.
    fn on_the_core(
        &self,
        null: &NullModel,
        state: &Hypothesis,
        recording: &Recording,
        user: Option<&Model>,
    ) -> Extended {
        let inertia = match state.normal.coefficients.first() {
            Some(_) if null.core.corrects => null.baseline.mass,
            Some(mass) if null.rows.inertial => *mass,
            _ => 0.0,
        };
        let mut blocks = if null.core.corrects {
            null.baseline.blocks.clone()
        } else {
            null.blocks(state)
        };
        // The library takes so many blocks, and each costs cycles: the weakest give way.
        blocks.sort_by(|a, b| (b.0 * b.1).total_cmp(&(a.0 * a.1)));
        let level: f64 = blocks.iter().map(|(k, d)| k * d).sum();
        let mut lacks = level;
        blocks.retain(|(k, d)| {
            let is_needed = lacks > WEAKEST * level;
            lacks -= k * d;
            is_needed
        });
        blocks.truncate(MOST_BLOCKS);
        blocks.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (stiffness, yields): (Vec<f64>, Vec<f64>) = blocks.into_iter().unzip();
        let mut model = Model {
            effort_unit: recording.role.other_unit(),
            inertia,
            mechanics: user.map(|m| m.mechanics.clone()).unwrap_or_default(),
            ..Model::of_friction(
                recording.kind,
                FrictionModel::maxwell_slip(&stiffness, &yields),
            )
        };
        let mut refused = Vec::new();
        for index in 0..state.terms.len() {
            enter(null, state, index, &mut model, &mut refused);
        }
        self.enter_channel(&mut model, &mut refused);
        let effort = recording.effort_unit();
        let mut replaces = user.map(|u| changes(u, &model, effort)).unwrap_or_default();
        if let Some(user) = user {
            replaces.push(format!(
                "{} by a finer hysteresis, {} (`preslide tune` chooses fewer blocks)",
                user.friction.name(),
                model.friction.name()
            ));
        }
        Extended {
            model,
            refused,
            replaces,
            is_on_the_core: true,
            is_as_given: false,
            is_of_another_law: false,
        }
    }
}

/// Enters term `index` of a hypothesis in a model.
fn enter(
    null: &NullModel,
    state: &Hypothesis,
    index: usize,
    model: &mut Model,
    refused: &mut Vec<String>,
) {
    let Some(effect) = state.terms[index].effect() else {
        return;
    };
    let values = parameters(null, state, index);
    if let Err(reason) = effect.extend(&values, model) {
        refused.push(format!("{}: {reason}", effect.id()));
    }
}

/// The user's model, where nothing that was found predicts better.
fn as_given(user: &Model) -> Extended {
    Extended {
        model: user.clone(),
        refused: Vec::new(),
        replaces: vec![
            "nothing: no refit leaves less on stretches held out and by `preslide simulate` than the model as it is"
                .to_owned(),
        ],
        is_on_the_core: false,
        is_as_given: true,
        is_of_another_law: false,
    }
}

/// The numbers of a model that another one has otherwise.
fn changes(user: &Model, model: &Model, effort: &str) -> Vec<String> {
    let level = |m: &Model| m.friction.breakaway().unwrap_or(0.0);
    let pairs = [
        ("mass_kg", user.inertia, model.inertia),
        ("breakaway_N", level(user), level(model)),
        ("viscous_N_s_per_m", user.viscous, model.viscous),
        (
            "constant_force_N",
            user.constant_force,
            model.constant_force,
        ),
    ];
    let late = is_late(user).then(|| ("channel_delay.delay_s", delay_of(user), delay_of(model)));
    let changed = pairs
        .into_iter()
        .chain(late)
        .filter(|(_, from, to)| from != to);
    let mut changed: Vec<String> = changed
        .filter_map(|(key, from, to)| {
            let (name, unit) = name_and_unit(&key_of(model.motion, key), effort);
            let [from, to] = [from, to].map(|value| quantity(value, &unit));
            (from != to).then(|| format!("{name} {from} by {to}"))
        })
        .collect();
    changed.extend(changed_effects(user, model, effort));
    if model.viscous < 0.0 && user.viscous >= 0.0 {
        changed.push("a friction that does not fall with speed by one that does: do not use it beyond the speeds of the recording".to_owned());
    }
    changed
}

/// The numbers of a model's effects that another one has otherwise, and the effects that it has not; of a delay [`changes`] tells.
fn changed_effects(user: &Model, model: &Model, effort: &str) -> Vec<String> {
    let mut changed = Vec::new();
    let told = user.effects.iter().enumerate();
    for (number, effect) in told.filter(|(_, e)| e.id() != ALWAYS_FREE.id()) {
        let before = user.effects[..number].iter();
        let nth = before.filter(|e| e.id() == effect.id()).count();
        let Some(own) = model.of(effect.form).nth(nth) else {
            changed.push(format!("{} by none", effect.id().replace('_', " ")));
            continue;
        };
        for (key, from) in &effect.values {
            let [from, to] = [*from, own.get(key)];
            let key = key_of(model.motion, &format!("{}.{key}", effect.id()));
            let (name, unit) = name_and_unit(&key, effort);
            let [from, to] = [from, to].map(|value| quantity(value, &unit));
            if from != to {
                changed.push(format!("{name} {from} by {to}"));
            }
        }
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_fit::effects::{Effect, form};
    use preslide_fit::recording::MotionKind;

    #[test]
    fn every_number_that_changes_is_told() {
        let coulomb = |coulomb| FrictionModel::Coulomb { coulomb };
        let model = |coulomb_n, effects: Vec<Effect>| Model {
            effects,
            ..Model::of_friction(MotionKind::Rotary, coulomb(coulomb_n))
        };
        let spring = |stiffness, centre| Effect::of(&form::POSITION_SPRING, &[stiffness, centre]);
        let slant = Effect::of(&form::VISCOUS_ASYMMETRY, &[2.0]);
        let user = model(3.0, vec![spring(22.0, 0.1), slant]);
        for (model, told) in [
            (user.clone(), vec![]),
            (
                model(2.0, vec![spring(0.5, 0.1)]),
                vec![
                    "breakaway 3.00",
                    "position spring",
                    "viscous asymmetry by none",
                ],
            ),
            (
                model(3.0, vec![spring(22.0, 0.2)]),
                vec!["centre 0.1", "viscous asymmetry by none"],
            ),
        ] {
            let changed = changes(&user, &model, "Nm");
            println!("{changed:?}");
            assert_eq!(changed.len(), told.len());
            let all = changed.iter().zip(told);
            all.for_each(|(own, told)| assert!(own.contains(told), "{own}"));
        }
    }
}
