//! A model file as a running controller takes it: the parameters of the model that its firmware was built with.

#[cfg(test)]
mod tests;

use crate::export::{carried, layout, parameters};
use preslide::Block;
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::{Model, refused};
use preslide_fit::recording::MotionKind;
use preslide_link::MOST_PARAMETERS;

/// Maxwell-slip blocks, without anything beside them, of firmware that no model was exported for.
pub const MOST_BLOCKS: usize = 4;

/// What a controller takes of a model, and what it leaves out.
#[derive(Clone, Debug, PartialEq)]
pub struct Loadable {
    /// By name, in the controller's order.
    pub parameters: Vec<(String, f64)>,
    /// Blocks that the model's were split into or joined to; `None` where it goes as it is.
    pub blocks: Option<usize>,
    /// Largest difference of the virgin curve that four blocks make, as a share of the breakaway force.
    pub deviation: f64,
    /// What is not sent, in words.
    pub left_out: Vec<String>,
}

/// A model for a controller whose parameters have this layout ([`preslide_link::Identity::model`]): all of it for firmware that was built for
/// a model of the same parts. For firmware that none was built for, its blocks alone: fewer than four are split in halves, which
/// changes nothing; of more, those that yield at the most similar displacement are joined.
///
/// # Errors
/// A model of other parts than the firmware's, and what to do.
pub fn loadable(model: &Model, of_controller: u32) -> Result<Loadable, String> {
    let whole = parameters(model);
    if whole.len() <= MOST_PARAMETERS && layout(&whole) == of_controller {
        let refused = refused(model).into_iter();
        return Ok(Loadable {
            parameters: whole,
            blocks: None,
            deviation: 0.0,
            left_out: refused.map(|(id, _)| id.to_owned()).collect(),
        });
    }
    let starting = blocks_alone(model).filter(|l| layout(&l.parameters) == of_controller);
    starting.ok_or_else(|| {
        let build = "`preslide export MODEL.toml -o stage_model.rs`, then build with PRESLIDE_MODEL=/full/path/to/stage_model.rs";
        match whole.len() > MOST_PARAMETERS {
            true => format!(
                "it has {} parameters, and the link takes {MOST_PARAMETERS}. Compile it in: {build}",
                whole.len()
            ),
            false => format!(
                "the controller's firmware was built for a model with other parts (kind, number of blocks, effects). Build it for this one: {build}; from then on `load` changes every number of it"
            ),
        }
    })
}

/// The layout of firmware that no model was exported for.
pub fn starting() -> u32 {
    let block = Block {
        stiffness: 1.0,
        weight: 1.0,
    };
    let friction = FrictionModel::Gms {
        breakaway: 1.0,
        blocks: vec![block; MOST_BLOCKS],
        sliding: None,
    };
    layout(&parameters(&Model::of_friction(
        MotionKind::Linear,
        friction,
    )))
}

/// Four blocks; `None` for a model that is not made of Maxwell-slip blocks.
fn blocks_alone(model: &Model) -> Option<Loadable> {
    let FrictionModel::Gms {
        breakaway,
        blocks,
        sliding,
    } = &model.friction
    else {
        return None;
    };
    let mut fitted = blocks.clone();
    while fitted.len() > MOST_BLOCKS {
        join(&mut fitted);
    }
    while fitted.len() < MOST_BLOCKS {
        split(&mut fitted);
    }
    let stribeck = sliding.is_some().then(|| "the Stribeck curve".to_owned());
    let effects = carried(model);
    let effects = effects.iter().map(|effect| effect.id().to_owned());
    let deviation = deviation(blocks, &fitted, *breakaway);
    let friction = FrictionModel::Gms {
        breakaway: *breakaway,
        blocks: fitted,
        sliding: None,
    };
    Some(Loadable {
        parameters: parameters(&Model::of_friction(model.motion, friction)),
        blocks: (blocks.len() != MOST_BLOCKS).then_some(MOST_BLOCKS),
        deviation,
        left_out: stribeck.into_iter().chain(effects).collect(),
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
