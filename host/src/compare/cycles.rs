//! What one update of a model costs on a microcontroller, from the project's own measurements.

use crate::friction::FrictionModel;

/// `cargo xtask cycles` writes this table.
const CORTEX_M4: &str = include_str!("../../../firmware/cycles/cortex-m4.csv");

/// Cost of one update on a Cortex-M4F.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycles {
    /// Row of the table: model and arithmetic.
    pub kernel: String,
    /// Mean over a random motion.
    pub mean: f64,
    /// Worst seen.
    pub worst: f64,
}

/// Kernel and number of blocks under which the table lists a model in `f32`.
fn kernel(model: &FrictionModel) -> Option<(&'static str, usize)> {
    match model {
        FrictionModel::Coulomb { .. } => Some(("coulomb_f32", 1)),
        // The library drops the powers where n is 1.
        FrictionModel::Dahl { exponent, .. } if (exponent - 1.0).abs() < 1e-4 => {
            Some(("dahl_n1_f32", 1))
        }
        FrictionModel::Dahl { .. } => Some(("dahl_n1.6_f32", 1)),
        FrictionModel::LuGre { .. } => Some(("lugre_f32", 1)),
        FrictionModel::Hsieh(_) => None,
        FrictionModel::Gms {
            blocks,
            sliding: None,
            ..
        } => Some(("quasi_static_f32", blocks.len())),
        FrictionModel::Gms { blocks, .. } => Some(("gms_f32", blocks.len())),
    }
}

/// The cost of `model` in `f32`, or `None` where it was not measured.
pub fn cycles(model: &FrictionModel) -> Option<Cycles> {
    let (kernel, blocks) = kernel(model)?;
    let mut table = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(CORTEX_M4.as_bytes());
    let head = table.headers().ok()?.clone();
    let column = |name: &str| head.iter().position(|column| column == name);
    let (name, n) = (column("kernel")?, column("n")?);
    let (mean, worst) = (column("cycles_mean")?, column("cycles_worst")?);
    let row = table.records().filter_map(Result::ok).find(|row| {
        row.get(name) == Some(kernel)
            && row.get(n).and_then(|n| n.parse::<usize>().ok()) == Some(blocks)
    })?;
    let number = |column: usize| row.get(column)?.parse::<f64>().ok();
    Some(Cycles {
        kernel: kernel.to_owned(),
        mean: number(mean)?,
        worst: number(worst)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide::{HsiehParams, Sliding};

    /// Every model that the firmware measures is found; the others are said not to be.
    #[test]
    fn finds_the_measured_kernels() {
        let block = |n: usize| FrictionModel::maxwell_slip(&vec![1.0; n], &vec![1.0; n]);
        let dahl = |exponent| FrictionModel::Dahl {
            stiffness: 1.0,
            coulomb: 1.0,
            exponent,
        };
        let lugre = FrictionModel::LuGre {
            stiffness: 1.0,
            damping: 0.0,
            breakaway: 1.0,
            sliding: Sliding::none(1.0),
        };
        for model in [
            block(1),
            block(6),
            dahl(1.0),
            dahl(0.7),
            lugre,
            FrictionModel::Coulomb { coulomb: 1.0 },
        ] {
            let cost = cycles(&model).unwrap();
            assert!(cost.mean > 1.0 && cost.worst >= cost.mean, "{cost:?}");
        }
        assert!(cycles(&block(1)).unwrap().mean < cycles(&block(6)).unwrap().mean);
        assert_eq!(cycles(&block(11)), None);
        let hsieh = FrictionModel::Hsieh(HsiehParams {
            k1: 1.0,
            k2: 1.0,
            beta: 1.0,
            viscous: 0.0,
            creep: 0.0,
            hardening: 1.0,
            hardening_exponent: 1.0,
        });
        assert_eq!(cycles(&hsieh), None);
    }
}
