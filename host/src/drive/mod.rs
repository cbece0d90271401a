//! A model file as the command link takes it: four Maxwell-slip blocks.

#[cfg(test)]
mod tests;

use preslide::Block;
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_link::{MOST_BLOCKS, ModelSettings};

/// What the link takes of a model, and what it leaves out.
#[derive(Clone, Debug, PartialEq)]
pub struct Loadable {
    /// The blocks.
    pub settings: ModelSettings,
    /// Largest difference of the virgin curve that four blocks make, as a share of the breakaway force.
    pub deviation: f64,
    /// What is not sent, in words.
    pub left_out: Vec<String>,
}

/// The model's blocks as the link takes them: fewer than four are split in halves, which changes nothing; of more, those that yield at
/// the most similar displacement are joined.
///
/// # Errors
/// A model that is not made of Maxwell-slip blocks, and what to do.
pub fn loadable(model: &Model) -> Result<Loadable, String> {
    let FrictionModel::Gms {
        breakaway,
        blocks,
        sliding,
    } = &model.friction
    else {
        return Err(
            "only Maxwell-slip blocks (kind = \"gms\") can be loaded at run time; `preslide export` and PRESLIDE_MODEL compile in \
             any other model"
                .to_owned(),
        );
    };
    let mut fitted = blocks.clone();
    while fitted.len() > MOST_BLOCKS {
        join(&mut fitted);
    }
    while fitted.len() < MOST_BLOCKS {
        split(&mut fitted);
    }
    let mut left_out: Vec<String> = Vec::new();
    if sliding.is_some() {
        left_out.push("the Stribeck curve".to_owned());
    }
    if model.viscous != 0.0 {
        left_out.push(format!("viscous friction {:.3}", model.viscous));
    }
    if model.constant_force != 0.0 {
        left_out.push(format!("the constant force {:.3}", model.constant_force));
    }
    left_out.extend(model.effects.iter().map(|effect| effect.id().to_owned()));
    let mut pairs = [(0.0, 0.0); MOST_BLOCKS];
    for (pair, block) in pairs.iter_mut().zip(&fitted) {
        *pair = (block.stiffness as f32, block.weight as f32);
    }
    Ok(Loadable {
        settings: ModelSettings {
            breakaway_n: *breakaway as f32,
            blocks: pairs,
        },
        deviation: deviation(blocks, &fitted, *breakaway),
        left_out,
    })
}

/// Displacement at which a block yields, per breakaway force (1/stiffness units).
fn yields(block: &Block) -> f64 {
    block.weight / block.stiffness
}

fn join(blocks: &mut Vec<Block>) {
    blocks.sort_by(|a, b| yields(a).total_cmp(&yields(b)));
    let ratio = |i: usize| yields(&blocks[i + 1]) / yields(&blocks[i]);
    let closest = (0..blocks.len() - 1).min_by(|a, b| ratio(*a).total_cmp(&ratio(*b)));
    if let Some(i) = closest {
        let other = blocks.remove(i + 1);
        blocks[i].stiffness += other.stiffness;
        blocks[i].weight += other.weight;
    }
}

fn split(blocks: &mut Vec<Block>) {
    let heaviest = blocks
        .iter_mut()
        .max_by(|a, b| a.weight.total_cmp(&b.weight));
    if let Some(block) = heaviest {
        block.stiffness /= 2.0;
        block.weight /= 2.0;
        let half = *block;
        blocks.push(half);
    }
}

/// Largest difference of the virgin curves, which are straight between the displacements at which a block yields.
fn deviation(before: &[Block], after: &[Block], breakaway: f64) -> f64 {
    let force = |blocks: &[Block], x: f64| -> f64 {
        let of = |b: &Block| (b.stiffness * x).min(b.weight * breakaway);
        blocks.iter().map(of).sum()
    };
    let corners = before.iter().chain(after).map(|b| yields(b) * breakaway);
    let differences = corners.map(|x| (force(before, x) - force(after, x)).abs() / breakaway);
    differences.fold(0.0, f64::max)
}
