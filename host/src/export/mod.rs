//! A model as source for the firmware, in Rust (constants, the composed type, and the function that builds it) or C, and as a simulator's joint.
//!
//! The Rust source names everything by its full path, so it can be a file module or be `include!`d. The type is generic over
//! the number type; `f32` is the default.

mod bound;
mod c;
mod constants;
pub mod joint;
mod source;
mod terms;

pub use bound::{Bound, Reached, bounded_terms, bounds, reached};
pub use c::{C, c_source};
pub use constants::{layout, parameters};
use preslide_fit::friction::Visitor;
use preslide_fit::kernel::Kernel;
use preslide_fit::model::Model;
pub use preslide_fit::model::{reduced, refused};
use sha2::Digest as _;
pub use source::rust_source;
pub use terms::carried;

/// SHA-256 in hexadecimal, to name a recording by its bytes: the same figure as `sha256sum`.
pub fn sha256(bytes: &[u8]) -> String {
    format!("{:x}", sha2::Sha256::digest(bytes))
}

/// What to write beside the parameters.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Comments at the head: where the model comes from.
    pub remarks: Vec<String>,
    /// Bound on each force that grows with speed or position (N or N·m); without it ten times the breakaway force, or twice what a term
    /// has on a recording, the larger of the two.
    pub limit: Option<f64>,
    /// What the terms with a bound have on recordings.
    pub reached: Vec<Reached>,
    /// Ticks per second (Hz) of C code in which time plays a part; Rust's takes them when the model is built.
    pub rate: Option<f64>,
    /// Length of an encoder count (m or rad), for C in whole numbers.
    pub count: Option<f64>,
    /// The form of a Maxwell-slip model's law; without it, the one that takes every model, in `f32`.
    pub kernel: Option<Kernel>,
}

/// The remarks at the head, with the bounds and where they cut.
fn remarks(model: &Model, options: &Options) -> Result<Vec<String>, String> {
    let mut remarks = options.remarks.clone();
    let bounds = bounds(model, options)?.into_iter();
    remarks.extend(bounds.map(|bound| format!("{}.", bound.said_with_remedy())));
    Ok(remarks)
}

/// The kernel for the model, if one is requested.
///
/// # Errors
/// A model that has not the kernel's law, or that its range does not hold: why, and what to take.
fn fitting(kernel: Option<Kernel>, model: &Model) -> Result<Option<Kernel>, String> {
    let Some(kernel) = kernel else {
        return Ok(None);
    };
    let (name, friction) = (kernel.name(), &model.friction);
    if friction.sliding().is_some() && !kernel.has_sliding() {
        return Err(format!(
            "--kernel {name} is quasi-static, and the model has a Stribeck curve: take {}, {}, or auto",
            Kernel::GmsF32.name(),
            Kernel::CountGms.name()
        ));
    }
    match kernel.visit(friction, 1e-3, Held) {
        Some(Ok(())) => Ok(Some(kernel)),
        Some(Err(reason)) => Err(format!("--kernel {name} cannot run this model: {reason}")),
        None => Err(format!(
            "--kernel {name} is a form of Maxwell slip, and the friction of the model is {}; leave --kernel out",
            friction.name()
        )),
    }
}

/// That a model could be built is all.
struct Held;

impl Visitor for Held {
    type Outcome = ();

    fn visit<M: preslide::Friction<Scalar = f64>>(self, _model: M) {}
}

/// Whether a controller can use all that a model has.
///
/// # Errors
/// Which effects none can use, why, and the options that leave them out.
pub fn no_refused(model: &Model) -> Result<(), String> {
    let refused = refused(model);
    if refused.is_empty() {
        return Ok(());
    }
    let list: Vec<String> = refused
        .iter()
        .map(|(id, reason)| format!("{id} ({reason})"))
        .collect();
    let remedy: Vec<String> = refused
        .iter()
        .map(|(id, _)| format!("--without {id}"))
        .collect();
    Err(format!(
        "no controller can compensate {}; export the rest with {}",
        list.join("; "),
        remedy.join(" ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use preslide_fit::friction::FrictionModel;
    use preslide_fit::model::Model;
    use preslide_fit::recording::MotionKind;

    fn model(friction: FrictionModel) -> Model {
        Model::of_friction(MotionKind::Linear, friction)
    }

    fn source(model: &Model, limit: Option<f64>) -> Result<String, String> {
        let options = Options {
            limit,
            ..Options::default()
        };
        rust_source(model, &options)
    }

    /// The constructor that is written is the one that `fit` calls, whose code is compiled in `tests/export.rs`; here, that it is complete.
    #[test]
    fn every_kind_of_friction_has_its_type() {
        for friction in FrictionModel::one_of_each(0.9, 1e-5) {
            let (law, arguments) = friction.constructor();
            let timed = arguments.contains(&"sample_time");
            let sizes = friction.blocks().len();
            let kind = match sizes {
                0 => format!("= ::preslide::{law}<S>;"),
                n => format!("= ::preslide::{law}<{n}, S>;"),
            };
            let time = if timed {
                "    sample_time: f64"
            } else {
                "    _sample_time: f64"
            };
            let scalars = friction.scalars();
            let text = source(&model(friction), None).expect("exportable");
            for part in [&kind, time] {
                assert!(text.contains(part), "`{part}` is not in:\n{text}");
            }
            for (key, _) in scalars {
                let used = text.matches(&key.to_lowercase()).count();
                // Of `PARAMETERS`, and to build the model.
                assert!(used >= 2, "{key} is not used in:\n{text}");
            }
            assert!(!text.contains("With"), "{text}");
        }
    }

    #[test]
    fn numbers_are_written_as_rust_has_them() {
        let laws = FrictionModel::one_of_each(1.0, 1e-5);
        let of = |wanted: &str| {
            let mut law = laws.iter().find(|law| law.kind() == wanted).cloned();
            match law.as_mut().expect("a law") {
                FrictionModel::Dahl { stiffness, .. } => *stiffness = 1e5,
                FrictionModel::LuGre { sliding, .. } => sliding.attraction = f64::INFINITY,
                _ => {}
            }
            source(&model(law.expect("a law")), None).expect("exportable")
        };
        assert!(of("dahl").contains("DAHL_STIFFNESS_N_PER_M: f64 = 100000.0"));
        assert!(of("lugre").contains("f64 = f64::INFINITY"));
    }

    /// Hsieh's model has no breakaway force from which a bound could be taken.
    #[test]
    fn demands_a_bound_if_the_model_has_none() {
        let hsieh = FrictionModel::one_of_each(0.9, 1e-5)
            .into_iter()
            .find(|model| model.kind() == "hsieh");
        let hsieh = hsieh.expect("a law");
        let model = Model {
            viscous: 2.0,
            ..model(hsieh)
        };
        assert!(
            source(&model, None)
                .expect_err("no bound")
                .contains("--limit")
        );
        assert!(
            source(&model, Some(3.0))
                .expect("bounded")
                .contains("FORCE_LIMIT: f64 = 3.0")
        );
        assert!(
            source(&model, Some(-3.0))
                .expect_err("negative")
                .contains("--limit")
        );
    }
}
