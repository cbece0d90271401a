use super::{Loadable, loadable, starting};
use crate::export::{layout, parameters};
use preslide_fit::model::Model;

fn model(blocks: &str) -> Model {
    let text = format!(
        "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 3.0\n[friction]\nkind = \"gms\"\nbreakaway_N = 0.9\nblocks = [{blocks}]\n"
    );
    Model::parse(&text).expect("a model")
}

fn weights(loaded: &Loadable) -> f64 {
    let weights = loaded
        .parameters
        .iter()
        .filter(|(name, _)| name == "weight");
    weights.map(|(_, value)| value).sum()
}

#[test]
fn fewer_blocks_are_split_without_a_difference() {
    let two = model(
        "{ stiffness_N_per_m = 2e5, weight = 0.6 }, { stiffness_N_per_m = 1e4, weight = 0.4 }",
    );
    let loaded = loadable(&two, starting()).expect("blocks");
    assert_eq!(loaded.blocks, Some(4));
    assert!(loaded.deviation < 1e-12, "{}", loaded.deviation);
    assert!((weights(&loaded) - 1.0).abs() < 1e-12);
    assert!(loaded.parameters.iter().all(|(_, value)| *value > 0.0));
    assert!(loaded.left_out.is_empty());
}

#[test]
fn joins_surplus_blocks_and_reports_the_difference() {
    let six = model(
        "{ stiffness_N_per_m = 2e5, weight = 0.3 }, { stiffness_N_per_m = 1e5, weight = 0.2 }, { stiffness_N_per_m = 4e4, weight = 0.2 }, \
         { stiffness_N_per_m = 1e4, weight = 0.1 }, { stiffness_N_per_m = 5e3, weight = 0.1 }, { stiffness_N_per_m = 2e3, weight = 0.1 }",
    );
    let loaded = loadable(&six, starting()).expect("blocks");
    // A tenth of the force at most: neighbours yield within a factor of three.
    assert!(
        loaded.deviation > 0.001 && loaded.deviation < 0.1,
        "{}",
        loaded.deviation
    );
    assert!((weights(&loaded) - 1.0).abs() < 1e-12);
}

#[test]
fn models_without_blocks_are_sent_or_refused_with_a_remedy() {
    let with = |friction: &str, more: &str| {
        let text = format!(
            "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\n{friction}\n{more}"
        );
        Model::parse(&text).expect("a model")
    };
    let ripple = "viscous_N_s_per_m = 12.0\n[[effects]]\nid = \"periodic_force\"\nforce_N = 0.1\nperiod_m = 2e-3\nphase_rad = 0.2\n";
    let blocks = with(
        "kind = \"gms\"\nbreakaway_N = 0.9\nblocks = [{ stiffness_N_per_m = 2e5, weight = 1.0 }]",
        ripple,
    );
    let told = loadable(&blocks, starting()).expect("blocks");
    assert_eq!(told.left_out, ["viscous", "periodic_force"]);
    // Firmware that was built for it takes all of it, and no other's.
    let whole = parameters(&blocks);
    let own = loadable(&blocks, layout(&whole)).expect("of the same parts");
    assert_eq!(own.blocks, None);
    assert_eq!((own.parameters, own.left_out), (whole, Vec::new()));
    for (model, firmware) in [
        (with("kind = \"coulomb\"\ncoulomb_N = 0.9", ""), starting()),
        (blocks, starting() + 1),
    ] {
        let error = loadable(&model, firmware).expect_err("other parts");
        assert!(error.contains("preslide export"), "{error}");
    }
}
