//! Effects read and written.

use super::*;
use preslide_host_tests::refusal::refuses;

#[test]
fn a_forms_example_is_what_a_model_file_may_have() {
    for form in form::ALL {
        let effect = example(form);
        let values: Vec<_> = (effect.values.iter().map(|(key, v)| (key.as_str(), *v))).collect();
        assert_eq!(Effect::new(form.id, &values).as_ref(), Ok(&effect));
    }
}

#[test]
fn every_effect_is_read_back_as_it_was_written() {
    for motion in [MotionKind::Linear, MotionKind::Rotary] {
        let mut effects = every();
        if motion == MotionKind::Rotary {
            effects.push(example(&form::GRAVITY));
        }
        let model = Model {
            motion,
            ..model(effects)
        };
        let text = model.to_toml(&[]);
        assert_eq!(Model::parse(&text).as_ref(), Ok(&model), "{text}");
        if motion == MotionKind::Rotary {
            for key in [
                "drag_Nm_s2_per_rad2",
                "cosine3_Nm",
                "period_rad",
                "phase_rad",
                "angle_rad",
                "load_N",
                "stiffness_Nm_per_rad",
                "rate_rad_s",
            ] {
                assert!(
                    text.contains(&format!("\n{key} = ")),
                    "{key} is not in:\n{text}"
                );
            }
        }
    }
    let mut shuffled = example(&form::POSITION_FORCE);
    shuffled.values.reverse();
    let given: Vec<_> = shuffled
        .values
        .iter()
        .map(|(k, v)| (k.as_str(), *v))
        .collect();
    assert_eq!(
        Effect::new("position_force", &given).as_ref(),
        Ok(&example(&form::POSITION_FORCE))
    );
}

#[test]
fn what_is_wrong_is_named_with_the_remedy() {
    let head = model(vec![]).to_toml(&[]);
    for (entry, parts) in [
        ("", &["effects[2].id", "missing"][..]),
        ("id = 3", &["effects[2].id", "string"]),
        (
            "id = \"warp\"",
            &["effects[2].id", "\"warp\"", "not known", "stribeck"],
        ),
        (
            "id = \"viscous\"",
            &["effects[2].id", "viscous_N_s_per_m", "[friction]"],
        ),
        ("id = \"lead_error\"", &["lead_error", "calibration"]),
        (
            "id = \"periodic_lead_error\"",
            &["periodic_lead_error", "calibration"],
        ),
        ("id = \"presliding_shape\"", &["more blocks"]),
        (
            "id = \"run_in\"\nlevel = 0.1",
            &["effects[2].path_m", "missing", "level, path_m"],
        ),
        (
            "id = \"run_in\"\nlevel = 0.1\npath_m = 1.0\nspeed = 2",
            &["effects[2].speed", "unknown key", "level, path_m"],
        ),
        (
            "id = \"run_in\"\nlevel = \"much\"\npath_m = 1.0",
            &["effects[2].level", "number"],
        ),
        (
            "id = \"run_in\"\nlevel = nan\npath_m = 1.0",
            &["effects[2].level", "NaN"],
        ),
        (
            "id = \"run_in\"\nlevel = 0.1\npath_m = 0",
            &["effects[2].path_m", "0 must be above zero"],
        ),
        (
            "id = \"stribeck\"\nlevel = 0.1\nvelocity_m_s = 1e-3\nexponent = 9.0",
            &["effects[2].exponent", "1 to 4"],
        ),
        (
            "id = \"coulomb_asymmetry\"\nasymmetry = -1.5",
            &["effects[2].asymmetry", "±1"],
        ),
        (
            "id = \"thermal_drift\"\nlevel = 0.1\ntemperature_C = 20.0",
            &[
                "effects[2].level",
                "unknown key",
                "level_per_K",
                "time_constant_s",
            ],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1\ncosine1_N = 1\ncosine3_N = 1",
            &["effects[2].cosine2_N", "missing", "gap"],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1",
            &["effects[2].cosine1_N", "missing"],
        ),
        (
            "id = \"position_force\"\nfrom_m = 0\nto_m = 1\ncosine1 = 1",
            &["effects[2].cosine1", "unknown key", "cosine1_N"],
        ),
        (
            "id = \"position_friction\"\nfrom_m = 1\nto_m = 1\ncosine1 = 0.1",
            &["effects[2].to_m", "above from_m"],
        ),
        (
            "id = \"encoder_error\"\nerror_m = 1.0\nperiod_m = 1e-5\nphase_rad = 0",
            &["effects[2].", "encoder_error", "encoder error"],
        ),
    ] {
        refuses(
            Model::parse(&format!("{head}\n[[effects]]\n{entry}\n")),
            parts,
        );
    }
    let rotary = head
        .replace("linear", "rotary")
        .replace("mass_kg", "inertia_kg_m2")
        .replace("_N_s_per_m", "_Nm_s_per_rad")
        .replace("_N ", "_Nm ");
    refuses(
        Model::parse(&format!(
            "{rotary}\n[[effects]]\nid = \"periodic_force\"\nforce_Nm = 1.0\n"
        )),
        &[
            "effects[2].period_rad: missing",
            "force_Nm, period_rad, phase_rad",
        ],
    );
    let many: Vec<_> = (1..=MOST_TERMS + 1).map(|j| format!("cosine{j}")).collect();
    let mut values: Vec<_> = many.iter().map(|key| (key.as_str(), 0.1)).collect();
    values.extend([("from_m", 0.0), ("to_m", 1.0)]);
    assert!(
        Effect::new("position_friction", &values)
            .expect_err("too many")
            .contains("at most 16")
    );
    assert!(
        Effect::new("run_in", &[("level", 0.1), ("level", 0.1), ("path_m", 1.0)])
            .expect_err("twice")
            .contains("twice")
    );
}
