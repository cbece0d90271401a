//! Headers of files, and what is made of them.

use super::*;
use preslide_host_tests::refusal::refuses;

fn names(list: &str) -> Vec<String> {
    list.split(',').map(str::to_string).collect()
}
fn plan_of(list: &str, map: &[(&str, &str)]) -> Result<Plan, Problem> {
    let map: Vec<_> = map
        .iter()
        .map(|(a, b)| (a.to_string(), b.to_string()))
        .collect();
    plan(&Names {
        columns: &names(list),
        units: &[],
        listing: list,
        map: &map,
        ignore: &[],
        needs: Needs::Both,
        sample_time: None,
    })
}

/// The roles that a header gives beside time, position and force, with their factors.
fn taken(name: &str) -> Option<(&'static str, f64)> {
    let plan = plan_of(&format!("t_s,x_m,friction_N,{name}"), &[]).expect(name);
    let mut more = plan.sources.iter().skip(3);
    more.next().map(|s| (s.known.name, s.terms[0].factor))
}

#[test]
fn other_quantities_are_not_mistaken_for_known_ones() {
    for name in [
        "voltage_cmd_V",
        "voltage_uq_raw",
        "vsupply_raw",
        "pos_error_rad",
        "qd_ref_rad_s",
        "torque_std_Nm",
        "torque_enabled",
        "current_iq_A",
        "pulse_flag",
        "anticogging_on",
        "time_of_day",
        "x2_m",
        "run",
        "temp_raw",
        "x",
        "velocity",
        "x_furlong",
        "t_ms",
    ] {
        assert_eq!(taken(name), None, "{name}");
    }
}

#[test]
fn a_name_with_a_known_unit_is_converted_where_the_role_is_free() {
    for (name, target, factor) in [
        ("v_mm_s", "v_m_s", 1e-3),
        ("speed (mm/s)", "v_m_s", 1e-3),
        ("x_ref_mm", "x_ref_m", 1e-3),
        ("temperature_K", "temperature_C", 1.0),
        ("temp_C", "temperature_C", 1.0),
        ("pressure_bar", "pressure_Pa", 1e5),
        ("Load [kN]", "normal_N", 1e3),
    ] {
        assert_eq!(taken(name), Some((target, factor)), "{name}");
    }
    let german = plan_of("Zeit [ms],Istposition [mm],Istkraft [N]", &[]).expect("names");
    assert_eq!(german.sources.len(), 3);
    let map = [("x_m", "Position[counts]*25e-9")];
    let plan = plan_of("t_s,Position [counts],force_N", &map);
    let source = &plan.expect("a blank more or less").sources[0];
    assert_eq!(source.terms[0].factor, 25e-9);
    let plan = plan_of("Time [ms],Position (deg),torque_mNm", &[]).expect("a scope's names");
    assert_eq!(
        (plan.kind, plan.role),
        (MotionKind::Rotary, EffortRole::Torque)
    );
    let said = &plan.warnings[0].message;
    for part in ["t_s=0.001*Time [ms]", "torque_Nm=0.001*torque_mNm"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn whose_it_is_and_that_it_was_measured_change_no_quantity() {
    for (header, taken) in [
        (
            "t_s,q_rad,qd_rad_s,current_iq_A,voltage_uq_raw,anticogging_on",
            "current_A=current_iq_A",
        ),
        ("t_s,q_rad,Motor current(A)", "current_A=Motor current(A)"),
        (
            "t_s,q_rad,MotorCurrent[mA]",
            "current_A=0.001*MotorCurrent[mA]",
        ),
        (
            "t_s,q_rad,Active Current [A],Position Error [deg]",
            "current_A=Active Current [A]",
        ),
        ("t_s,q_rad,Stromistwert in A", "current_A=Stromistwert in A"),
        (
            "t_s,q_rad,Current Feedback (A),Current Command (A)",
            "current_A=Current Feedback (A)",
        ),
        (
            "t_s,q_rad,iq_measured_A,id_measured_A,iq_ref_A,ia_A",
            "current_A=iq_measured_A",
        ),
        (
            "t_s,Position actual value [deg],Torque actual value [mNm],Position demand value [deg]",
            "q_rad=0.017453292519943295*Position actual value [deg], torque_Nm=0.001*Torque actual value [mNm]",
        ),
        (
            "t_s,ActPos [mm],ActVelo [mm/s],Istkraft / N",
            "force_N=Istkraft / N, x_m=0.001*ActPos [mm]",
        ),
        ("t_s,ActVelo [mm/s],force_N", "v_m_s=0.001*ActVelo [mm/s]"),
    ] {
        let plan = plan_of(header, &[]).unwrap_or_else(|e| panic!("{header}: {e}"));
        let said = &plan.warnings[0].message;
        assert_eq!(
            said,
            &format!("by their names and units: {taken}"),
            "{header}"
        );
    }
    // A plainer name goes first, and what is known is not joined by a guess.
    let plan = plan_of("t_s,x_m,current_A,current_iq_A", &[]).expect("plain");
    assert_eq!(plan.unused, [3]);
    assert_eq!(taken("motor_velocity_mm_s"), None);
}

#[test]
fn what_its_names_do_not_tell_is_proposed_whole() {
    for (header, maps) in [
        (
            "time,position,velocity,torque",
            "--map q_rad=position --map torque_Nm=torque",
        ),
        (
            "t_s,motor_q_rad,joint_q_rad,motor_torque_raw",
            "--map q_rad=motor_q_rad --map effort_raw=motor_torque_raw",
        ),
        (
            "t_s,q_rad,motor_current_A,drive_current_A",
            "--map current_A=motor_current_A",
        ),
        (
            "t_s,q_rad,current_cmd_A,qd_rad_s",
            "--map current_A=current_cmd_A",
        ),
        (
            "t_s,q_rad,motor_current_A,load_cell_N",
            "--map current_A=motor_current_A",
        ),
        (
            "t_s,q_rad,Motor current/A,i_a_A",
            "--map 'current_A=Motor current/A'",
        ),
        (
            "t_s,q_rad,drive voltage (V)",
            "--map 'voltage_V=drive voltage (V)'",
        ),
        ("t_s,x,friction_N", "--map x_m=x"),
        ("t_s,x_furlong,friction_N", "--map 'x_m=FACTOR*x_furlong'"),
        ("t_s,x_m,friction_N,force_N", "--map friction_N=friction_N"),
    ] {
        refuses(plan_of(header, &[]), &[maps, header]);
    }
}

#[test]
fn a_mapping_chooses_between_two_columns_and_scales() {
    let both = plan_of("t_s,x_m,force_N,friction_N", &[]);
    refuses(
        both,
        &["both give the effort", "--map friction_N=friction_N"],
    );
    let map = [("friction_N", "friction_N")];
    let plan = plan_of("t_s,x_m,force_N,friction_N", &map).expect("chosen");
    assert_eq!((plan.role, plan.unused), (EffortRole::Friction, vec![2]));
    let map = [
        ("t_s", "t"),
        ("x_m", "1e-3*x_mm"),
        ("force_N", "-2 * gtau*vir"),
    ];
    let plan = plan_of("t,x_mm,vir,gtau", &map).expect("scaled");
    let products: Vec<_> = plan
        .sources
        .iter()
        .map(|s| (s.terms[0].factor, s.terms[0].columns.as_slice()))
        .collect();
    assert_eq!(products, [(1.0, &[0][..]), (1e-3, &[1]), (-2.0, &[3, 2])]);
}

#[test]
fn mappings_that_cannot_be_followed_say_what_would_work() {
    for (map, hint) in [
        (vec![("force", "f")], "`force` is not a column"),
        (vec![("force", "f")], "force_N"),
        (
            vec![("force_N", "g")],
            "no column `g`; the file has t_s, x_m, f",
        ),
        (vec![("force_N", "2")], "FACTOR*COLUMN"),
        (vec![("force_N", "f[counts]")], "force_N=FACTOR*f[counts]"),
        (vec![("force_N", "")], "no column ``"),
        (
            vec![("force_N", "f"), ("friction_N", "f")],
            "already mapped",
        ),
        (
            vec![("force_N", "f"), ("segment", "2*f")],
            "without a factor",
        ),
    ] {
        refuses(plan_of("t_s,x_m,f", &map), &[hint]);
    }
}

#[test]
fn all_that_is_missing_is_named_at_once() {
    refuses(
        plan_of("qd_rad_s,torque_mean_Nm,torque_std_Nm", &[]),
        &["t_s", "torque_Nm", "torque_std_Nm"],
    );
}

#[test]
fn axes_do_not_mix() {
    let factor = "--map 'force_N=FACTOR*torque_Nm'";
    for (header, part) in [
        ("t_s,x_m,torque_Nm", factor),
        (
            "t_s,x_m,q_rad,force_N",
            "both give the position; choose one",
        ),
        (
            "t_s,x_m,x_m,force_N",
            "both give the position; rename or remove one",
        ),
    ] {
        refuses(plan_of(header, &[]), &[part]);
    }
    let plan = plan_of("t_s,x_m,qd_rad_s,force_N", &[]).expect("position decides");
    assert!(plan.warnings.iter().any(|w| w.code == "other-axis"));
    assert_eq!(plan.kind, MotionKind::Linear);
}
