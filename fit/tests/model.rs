//! Model files: what is written is read back as it was, and what is wrong is named by its key.

use preslide::{Block, HsiehParams, LeuvenForm, Sliding};
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use preslide_host_tests::refusal::refuses;

fn kinds() -> Vec<FrictionModel> {
    let sliding = Sliding {
        coulomb: 0.7,
        stribeck_velocity: 0.01,
        stribeck_exponent: 2.0,
        attraction: 40.0,
    };
    let blocks = vec![
        Block {
            stiffness: 270_313.0,
            weight: 0.1,
        },
        Block {
            stiffness: 1.0 / 3.0,
            weight: 0.9,
        },
    ];
    vec![
        FrictionModel::Coulomb { coulomb: 0.9 },
        // `identify` writes this where the effort does not resist the motion.
        FrictionModel::Coulomb { coulomb: 0.0 },
        FrictionModel::Dahl {
            stiffness: 1e5,
            coulomb: 0.9,
            exponent: 1.5,
        },
        FrictionModel::LuGre {
            stiffness: 1e5,
            damping: 300.0,
            breakaway: 0.9,
            sliding,
        },
        FrictionModel::LuGre {
            stiffness: 1e5,
            damping: 0.0,
            breakaway: 0.9,
            sliding: Sliding::none(0.9),
        },
        FrictionModel::BoucWen {
            stiffness: 1e5,
            coulomb: 0.9,
            exponent: 1.5,
            shape: 0.75,
        },
        FrictionModel::ElastoPlastic {
            stiffness: 1e5,
            damping: 20.0,
            elastic: 1e-6,
            breakaway: 0.9,
            sliding,
        },
        FrictionModel::Leuven {
            form: LeuvenForm::Modified,
            breakaway: 0.9,
            blocks: blocks.clone(),
            exponent: 2.0,
            damping: 0.0,
            sliding,
        },
        FrictionModel::Leuven {
            form: LeuvenForm::Original,
            breakaway: 0.9,
            blocks: blocks.clone(),
            exponent: 1.0,
            damping: 20.0,
            sliding: Sliding::none(0.9),
        },
        FrictionModel::TwoState {
            distance: 35e-6,
            breakaway: 0.9,
            sliding,
        },
        FrictionModel::Hsieh(HsiehParams {
            k1: 1e5,
            k2: 1e4,
            beta: 3e4,
            viscous: 2.0,
            creep: 0.1,
            hardening: 0.2,
            hardening_exponent: 1.0,
        }),
        FrictionModel::Gms {
            breakaway: 0.9,
            blocks: blocks.clone(),
            sliding: None,
        },
        FrictionModel::Gms {
            breakaway: 0.9,
            blocks,
            sliding: Some(sliding),
        },
        FrictionModel::maxwell_slip(&[1e5; 16], &[1e-6; 16]),
    ]
}

#[test]
fn every_kind_is_read_back_as_it_was_written() {
    for motion in [MotionKind::Linear, MotionKind::Rotary] {
        for friction in kinds() {
            let model = Model {
                motion,
                inertia: 3.9,
                viscous: -0.1,
                friction,
                constant_force: 1.0 / 7.0,
                effects: Vec::new(),
                mechanics: vec![
                    ("screw_lead_m".to_owned(), 0.002),
                    ("encoder_count_m".to_owned(), 2.5e-8),
                ],
            };
            let text = model.to_toml(&["made by a test\nof two lines".to_owned()]);
            assert_eq!(Model::parse(&text).as_ref(), Ok(&model), "{text}");
            let bare = Model {
                inertia: 0.0,
                constant_force: 0.0,
                mechanics: Vec::new(),
                ..model
            };
            let text = bare.to_toml(&[]);
            assert_eq!(Model::parse(&text).as_ref(), Ok(&bare), "{text}");
        }
    }
}

const GMS: &str = r#"schema = "preslide.model/1"
motion = "linear"
[inertia]
mass_kg = 3.9
[friction]
kind = "gms"
breakaway_N = 0.9
blocks = [
  { stiffness_N_per_m = 270313.0, weight = 0.25 },
  { stiffness_N_per_m = 20000.0, weight = 0.75 },
]
viscous_N_s_per_m = 0.5
[mechanics]
screw_lead_m = 0.002
[[effects]]
id = "constant_force"
force_N = 0.1
"#;

#[test]
fn what_is_wrong_is_named_by_its_key() {
    assert!(Model::parse(GMS).is_ok());
    for (from, to, parts) in [
        (
            "breakaway_N",
            "colour = 1\nbreakaway_N",
            &["colour", "line 7"][..],
        ),
        (
            "weight = 0.25",
            "weight = 0.25, spring = 1",
            &["spring", "line 9"],
        ),
        (
            "screw_lead_m",
            "screw_led_m",
            &["screw_led_m", "screw_lead_m"],
        ),
        ("= 20000.0", "= -20000.0", &["stiffness", "-20000"]),
        ("= 20000.0", "= 0.0", &["stiffness"]),
        ("= 20000.0", "= inf", &["stiffness"]),
        ("= 20000.0", "= \"stiff\"", &["line 10"]),
        ("0.75", "0.74", &["weight", "0.99"]),
        ("0.75", "-0.75", &["weight"]),
        ("breakaway_N = 0.9", "", &["breakaway_N", "missing"]),
        ("breakaway_N = 0.9", "breakaway_N = -0.9", &["breakaway"]),
        (
            "breakaway_N = 0.9",
            "breakaway_N = 0.9\ncoulomb_N = 0.5",
            &["stribeck_velocity_m_s", "missing"],
        ),
        (
            "breakaway_N = 0.9",
            "breakaway_N = 0.9\nexponent = 1.0",
            &["exponent", "does not use it"],
        ),
        (
            "kind = \"gms\"",
            "kind = \"gsm\"",
            &["kind", "gsm", "use coulomb"],
        ),
        (
            "kind = \"gms\"",
            "kind = \"dahl\"",
            &["friction.stiffness_N_per_m", "missing"],
        ),
        ("3.9", "-3.9", &["mass_kg", "-3.9"]),
        ("0.002", "0.0", &["screw_lead_m"]),
        ("constant_force", "cogging", &["effects[1].id", "cogging"]),
        (
            "force_N = 0.1",
            "force_N = 0.1\nphase = 2",
            &["effects[1].phase", "unknown key"],
        ),
        ("force_N = 0.1", "", &["effects[1].force_N", "missing"]),
        ("model/1", "model/2", &["schema", "preslide.model/1"]),
        ("\"linear\"", "\"circular\"", &["motion", "rotary"]),
        (
            "\"linear\"",
            "\"rotary\"",
            &["a key of a linear axis", "rotary unit"],
        ),
    ] {
        let text = GMS.replacen(from, to, 1);
        assert_ne!(text, GMS, "{from}");
        refuses(Model::parse(&text), parts);
    }
}

/// A bad value in a rotary file is named by the rotary key, which the file has.
#[test]
fn rotary_files_are_spoken_to_in_their_own_words() {
    let rotary = GMS
        .replace("linear", "rotary")
        .replace("mass_kg", "inertia_kg_m2")
        .replace("breakaway_N", "breakaway_Nm")
        .replace("stiffness_N_per_m", "stiffness_Nm_per_rad")
        .replace("viscous_N_s_per_m", "viscous_Nm_s_per_rad")
        .replace("force_N", "force_Nm")
        .replace("screw_lead_m", "motor_period_rad");
    let model = Model::parse(&rotary).expect("a rotary model");
    assert_eq!(model.motion, MotionKind::Rotary);
    assert!(model.to_toml(&[]).contains("motor_period_rad = 0.002"));
    for (from, to, key) in [
        ("breakaway_Nm = 0.9", "", "friction.breakaway_Nm"),
        (
            "inertia_kg_m2 = 3.9",
            "inertia_kg_m2 = -3.9",
            "inertia.inertia_kg_m2",
        ),
        ("force_Nm = 0.1", "", "effects[1].force_Nm"),
        ("inertia_kg_m2", "inertia_kgm2", "inertia_kgm2"),
    ] {
        refuses(Model::parse(&rotary.replacen(from, to, 1)), &[key]);
    }
}
