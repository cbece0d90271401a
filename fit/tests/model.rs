//! Model files: what is written is read back as it was, and what is wrong is named by its key.

use preslide::Sliding;
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use preslide_host_tests::refusal::refuses;

fn kinds() -> Vec<FrictionModel> {
    let mut kinds = FrictionModel::one_of_each(0.9, 1e-6);
    kinds.extend([
        // `identify` writes this where the effort does not resist the motion.
        FrictionModel::Coulomb { coulomb: 0.0 },
        FrictionModel::LuGre {
            stiffness: 1e5,
            damping: 0.0,
            breakaway: 0.9,
            sliding: Sliding::none(0.9),
        },
        FrictionModel::maxwell_slip(&[270_313.0, 1.0 / 3.0], &[1e-6, 0.7]),
        FrictionModel::maxwell_slip(&[1e5; 16], &[1e-6; 16]),
    ]);
    kinds
}

#[test]
fn every_kind_is_read_back_as_it_was_written() {
    for motion in [MotionKind::Linear, MotionKind::Rotary] {
        for friction in kinds() {
            let model = Model {
                motion,
                effort_unit: (motion == MotionKind::Rotary).then_some("A"),
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
        (
            "\"linear\"",
            "\"linear\"\neffort_unit = \"N\"",
            &["effort_unit", "A, V or raw"],
        ),
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
