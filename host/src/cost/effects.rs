//! What effects add to a control tick: rows named `with_ID_ARITHMETIC`, each a `Gms<4>` with that effect alone.

use super::{Cost, CostTable};
use preslide_fit::effects::Effect;

/// Blocks of the friction model that the effects were measured beside.
const BESIDE: usize = 4;

/// Numbers of cosines for which a map was measured; others lie on the line through them.
const MAPS: [usize; 2] = [2, 8];

/// Growth of a control tick, and of code and state, by a model's effects.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectsCost {
    /// Cycles, mean.
    pub cycles_mean: f64,
    /// The sum of the effects' worst paths.
    pub cycles_worst: f64,
    /// Instructions, mean.
    pub instructions: f64,
    /// Code and parameters (bytes).
    pub flash_bytes: f64,
    /// State (bytes).
    pub ram_bytes: f64,
    /// Each effect's id with its cycles, mean.
    pub each: Vec<(&'static str, f64)>,
    /// Effects that the table does not have.
    pub missing: Vec<&'static str>,
}

impl CostTable {
    /// The cost of `effects` composed with a friction model, in the arithmetic `f32` or `i16f16`. What I16F16 cannot hold
    /// was measured in `f32` alone and is taken from there.
    ///
    /// Costs add: the step that keeps the position once, and of every effect its growth over that.
    pub fn effects(&self, effects: &[Effect], arithmetic: &str) -> EffectsCost {
        let mut sum = EffectsCost {
            cycles_mean: 0.0,
            cycles_worst: 0.0,
            instructions: 0.0,
            flash_bytes: 0.0,
            ram_bytes: 0.0,
            each: Vec::new(),
            missing: Vec::new(),
        };
        if effects.is_empty() {
            return sum;
        }
        let nothing = |arithmetic: &str| self.with("nothing", arithmetic);
        match (
            self.cost(&format!("gms_{arithmetic}"), BESIDE),
            nothing(arithmetic),
        ) {
            (Some(bare), Some(nothing)) => sum.add(1.0, &nothing, &bare),
            _ => {
                sum.missing = effects.iter().map(Effect::id).collect();
                return sum;
            }
        }
        for effect in effects {
            let found = [arithmetic, "f32"].into_iter().find_map(|arithmetic| {
                Some((self.growth(effect, arithmetic)?, nothing(arithmetic)?))
            });
            let Some((parts, nothing)) = found else {
                sum.missing.push(effect.id());
                continue;
            };
            let before = sum.cycles_mean;
            for (share, with) in &parts {
                sum.add(*share, with, &nothing);
            }
            sum.each.push((effect.id(), sum.cycles_mean - before));
        }
        sum
    }

    fn with(&self, name: &str, arithmetic: &str) -> Option<Cost> {
        self.cost(&format!("with_{name}_{arithmetic}"), BESIDE)
    }

    /// Rows with their shares, which sum to 1.
    fn growth(&self, effect: &Effect, arithmetic: &str) -> Option<Vec<(f64, Cost)>> {
        let with = |name: &str| self.with(name, arithmetic);
        let row = effect.form.cost();
        if !effect.form.is_map() {
            return Some(vec![(1.0, with(row)?)]);
        }
        let [few, many] = MAPS;
        let far = (effect.cosines().len() as f64 - few as f64) / (many - few) as f64;
        Some(vec![
            (1.0 - far, with(&format!("{row}_{few}"))?),
            (far, with(&format!("{row}_{many}"))?),
        ])
    }
}

impl EffectsCost {
    fn add(&mut self, share: f64, with: &Cost, without: &Cost) {
        self.cycles_mean += share * (with.cycles_mean - without.cycles_mean);
        self.cycles_worst += share * (with.cycles_worst - without.cycles_worst);
        self.instructions += share * (with.instructions - without.instructions);
        self.flash_bytes += share * (with.flash_bytes - without.flash_bytes);
        self.ram_bytes += share * (with.ram_bytes - without.ram_bytes);
    }

    /// `cost` with the effects beside it.
    pub fn beside(&self, cost: Cost) -> Cost {
        let mean = cost.cycles_mean + self.cycles_mean;
        Cost {
            cycles_mean: mean,
            // Each row's worst path has its own call taken off, which may leave a cycle less than nothing.
            cycles_worst: (cost.cycles_worst + self.cycles_worst).max(mean),
            instructions: cost.instructions + self.instructions,
            flash_bytes: (cost.flash_bytes + self.flash_bytes).ceil(),
            ram_bytes: cost.ram_bytes + self.ram_bytes,
            ..cost
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_fit::effects::form;

    fn effect(id: &str, values: &[(&str, f64)]) -> Effect {
        Effect::new(id, values).unwrap()
    }

    fn map(id: &str, cosines: usize) -> Effect {
        let unit = if id == "position_force" { "_N" } else { "" };
        let keys: Vec<String> = (1..=cosines).map(|i| format!("cosine{i}{unit}")).collect();
        let mut values = vec![("from_m", 0.0), ("to_m", 1e-3)];
        values.extend(keys.iter().map(|key| (key.as_str(), 0.01)));
        effect(id, &values)
    }

    /// Every effect that a controller can use was measured, in the arithmetic that can hold it.
    #[test]
    fn every_effect_of_a_controller_has_its_cycles() {
        let table = CostTable::of_cpu("cortex-m4").unwrap();
        let all = form::ALL.into_iter().chain([&form::VISCOUS]);
        let of_controllers = all.filter(|form| form.controller.is_ok());
        let effects: Vec<Effect> = of_controllers
            .map(|form| Effect::of(form, form.example))
            .collect();
        for arithmetic in ["f32", "i16f16"] {
            let all = table.effects(&effects, arithmetic);
            assert_eq!(all.missing, Vec::<&str>::new());
            assert_eq!(all.each.len(), effects.len());
            assert!(all.each.iter().all(|(_, cycles)| *cycles > 0.0), "{all:?}");
            let nothing = table
                .cost(&format!("with_nothing_{arithmetic}"), 4)
                .unwrap();
            let bare = table.cost(&format!("gms_{arithmetic}"), 4).unwrap();
            let each: f64 = all.each.iter().map(|(_, cycles)| cycles).sum();
            let sum = each + nothing.cycles_mean - bare.cycles_mean;
            assert!((all.cycles_mean - sum).abs() < 1e-9);
            let beside = all.beside(bare);
            assert!(beside.cycles_worst >= beside.cycles_mean);
        }
    }

    #[test]
    fn a_map_costs_by_its_cosines_and_no_effects_cost_nothing() {
        let table = CostTable::of_cpu("cortex-m4").unwrap();
        let map = |cosines: usize| {
            let map = map("position_friction", cosines);
            table.effects(&[map], "f32").cycles_mean
        };
        let row = |name| table.cost(name, 4).unwrap().cycles_mean;
        let eight = row("with_position_friction_8_f32") - row("gms_f32");
        assert!((map(8) - eight).abs() < 1e-9);
        assert!((map(5) - (map(2) + map(8)) / 2.0).abs() < 1e-9);
        assert!(map(16) > map(8));
        assert_eq!(table.effects(&[], "f32").cycles_worst, 0.0);
    }

    #[test]
    fn a_table_without_effects_says_so() {
        let text = "kernel,n,cycles_mean,cycles_worst\ngms_f32,4,51.5,70\n";
        let table = CostTable::parse(text, "board").unwrap();
        let cost = table.effects(&[effect("constant_force", &[("force_N", 0.1)])], "f32");
        assert_eq!(cost.missing, ["constant_force"]);
        assert_eq!(cost.cycles_mean, 0.0);
    }
}
