use super::loadable;
use preslide_fit::model::Model;

fn model(blocks: &str) -> Model {
    let text = format!(
        "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[inertia]\nmass_kg = 3.0\n[friction]\nkind = \"gms\"\nbreakaway_N = 0.9\nblocks = [{blocks}]\n"
    );
    Model::parse(&text).expect("a model")
}

#[test]
fn fewer_blocks_are_split_without_a_difference() {
    let two = model(
        "{ stiffness_N_per_m = 2e5, weight = 0.6 }, { stiffness_N_per_m = 1e4, weight = 0.4 }",
    );
    let loaded = loadable(&two).expect("blocks");
    assert!(loaded.deviation < 1e-12, "{}", loaded.deviation);
    let sum: f32 = loaded.settings.blocks.iter().map(|block| block.1).sum();
    assert!((sum - 1.0).abs() < 1e-6);
    assert!(
        loaded
            .settings
            .blocks
            .iter()
            .all(|block| block.0 > 0.0 && block.1 > 0.0)
    );
    assert!(loaded.left_out.is_empty());
}

#[test]
fn more_blocks_are_joined_and_the_difference_is_told() {
    let six = model(
        "{ stiffness_N_per_m = 2e5, weight = 0.3 }, { stiffness_N_per_m = 1e5, weight = 0.2 }, { stiffness_N_per_m = 4e4, weight = 0.2 }, \
         { stiffness_N_per_m = 1e4, weight = 0.1 }, { stiffness_N_per_m = 5e3, weight = 0.1 }, { stiffness_N_per_m = 2e3, weight = 0.1 }",
    );
    let loaded = loadable(&six).expect("blocks");
    // A tenth of the force at most: neighbours yield within a factor of three.
    assert!(
        loaded.deviation > 0.001 && loaded.deviation < 0.1,
        "{}",
        loaded.deviation
    );
    let sum: f32 = loaded.settings.blocks.iter().map(|block| block.1).sum();
    assert!((sum - 1.0).abs() < 1e-6);
}

#[test]
fn another_kind_of_model_is_refused_with_the_way_that_works() {
    let text = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 0.9\n";
    let error = loadable(&Model::parse(text).expect("a model")).expect_err("no blocks");
    assert!(error.contains("preslide export"), "{error}");
}
