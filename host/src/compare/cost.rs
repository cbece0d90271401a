//! What one update of a model costs on a Cortex-M4F in `f32`.

use crate::cost::{Cost, CostTable};
use preslide_fit::friction::FrictionModel;
use std::sync::LazyLock;

/// Kernel and number of blocks under which the table lists a model in `f32`.
fn kernel(model: &FrictionModel) -> (String, usize) {
    let law = match model {
        // The library drops the powers where n is 1.
        FrictionModel::Dahl { exponent, .. } if (exponent - 1.0).abs() < 1e-4 => "dahl_n1",
        FrictionModel::Dahl { .. } => "dahl_n1.6",
        FrictionModel::Gms { sliding: None, .. } => "quasi_static",
        other => other.kind(),
    };
    (format!("{law}_f32"), model.blocks().len().max(1))
}

/// The cost of `model` in `f32`, or `None` where it was not measured.
pub fn cost(model: &FrictionModel) -> Option<Cost> {
    static CORTEX_M4: LazyLock<Option<CostTable>> =
        LazyLock::new(|| CostTable::of_cpu("cortex-m4").ok());
    let (kernel, blocks) = kernel(model);
    CORTEX_M4.as_ref()?.cost(&kernel, blocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind of model was measured; Maxwell-slip models only up to ten blocks.
    #[test]
    fn finds_the_measured_kernels() {
        let block = |n: usize| FrictionModel::maxwell_slip(&vec![1.0; n], &vec![1.0; n]);
        let mut models = FrictionModel::one_of_each(1.0, 1e-5);
        let (stiffness, coulomb, exponent) = (1.0, 1.0, 1.0);
        models.push(FrictionModel::Dahl {
            stiffness,
            coulomb,
            exponent,
        });
        for mut model in models {
            // Measured with so many alone.
            if let FrictionModel::Leuven { blocks, .. } = &mut model {
                blocks.resize(8, blocks[0]);
            }
            let cost = cost(&model).unwrap();
            assert!(cost.inlined, "{cost:?}");
            assert!(
                cost.cycles_mean > 1.0 && cost.cycles_worst >= cost.cycles_mean,
                "{cost:?}"
            );
        }
        let mean = |n: usize| cost(&block(n)).unwrap().cycles_mean;
        assert!(mean(1) < mean(6));
        // On the line through the largest that were measured.
        assert!((mean(12) - 2.0 * mean(10) + mean(8)).abs() < 1e-9);
    }
}
