//! A model as Rust source for the firmware (constants, the composed type, and the function that builds it), and as a simulator's joint.
//!
//! The source names everything by its full path, so it can be a file module or be `include!`d. The type is generic over
//! the number type; `f32` is the default.

pub mod joint;
mod sha256;
mod source;

pub use crate::model::{reduced, refused};
pub use sha256::sha256;
pub use source::{Options, carried, rust_source};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionModel;
    use crate::model::Model;
    use crate::recording::MotionKind;
    use preslide::{Block, HsiehParams, Sliding};

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

    /// The code of every kind is compiled in `tests/export.rs`; here, that the right constructor is chosen.
    #[test]
    fn every_kind_of_friction_has_its_type() {
        let sliding = Sliding {
            coulomb: 0.7,
            stribeck_velocity: 0.01,
            stribeck_exponent: 2.0,
            attraction: f64::INFINITY,
        };
        let blocks = vec![Block {
            stiffness: 1e4,
            weight: 1.0,
        }];
        for (friction, parts) in [
            (
                FrictionModel::Coulomb { coulomb: 0.9 },
                &["= ::preslide::Coulomb<S>"][..],
            ),
            (
                FrictionModel::Dahl {
                    stiffness: 1e5,
                    coulomb: 0.9,
                    exponent: 1.0,
                },
                &[
                    "= ::preslide::Dahl<S>",
                    "DAHL_STIFFNESS_N_PER_M: f64 = 100000.0",
                ],
            ),
            (
                FrictionModel::LuGre {
                    stiffness: 1e5,
                    damping: 3.0,
                    breakaway: 0.9,
                    sliding,
                },
                &["= ::preslide::LuGre<S>", "f64 = f64::INFINITY"],
            ),
            (
                FrictionModel::Hsieh(HsiehParams {
                    k1: 1.0,
                    k2: 2.0,
                    beta: 3.0,
                    viscous: 0.0,
                    creep: 0.1,
                    hardening: 0.2,
                    hardening_exponent: 1.0,
                }),
                &["= ::preslide::Hsieh<S>"],
            ),
            (
                FrictionModel::Gms {
                    breakaway: 0.9,
                    blocks: blocks.clone(),
                    sliding: None,
                },
                &["= ::preslide::QuasiStaticGms<1, S>", "_sample_time: f64"],
            ),
            (
                FrictionModel::Gms {
                    breakaway: 0.9,
                    blocks,
                    sliding: Some(sliding),
                },
                &["= ::preslide::Gms<1, S>", "    sample_time: f64"],
            ),
        ] {
            let text = source(&model(friction), None).expect("exportable");
            for part in parts {
                assert!(text.contains(part), "`{part}` is not in:\n{text}");
            }
            assert!(!text.contains("With"), "{text}");
        }
    }

    /// Hsieh's model has no breakaway force from which a bound could be taken.
    #[test]
    fn a_bound_is_asked_for_where_there_is_none() {
        let hsieh = FrictionModel::Hsieh(HsiehParams {
            k1: 1.0,
            k2: 2.0,
            beta: 3.0,
            viscous: 0.0,
            creep: 0.1,
            hardening: 0.2,
            hardening_exponent: 1.0,
        });
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
