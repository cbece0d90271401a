use super::cores::{Comparison, OnCore, budget_on};
use super::recommend::recommend;
use super::{Budget, of_model, of_recording};
use crate::cost::{CORES, CostTable};
use preslide_fit::identify::{Options, identify};
use preslide_fit::kernel::Kernel;
use preslide_fit::model::Model;
use preslide_fit::progress::Progress;
use preslide_fit::recording::{LoadOptions, load_csv};
use preslide_host_tests::path::recorded;

fn model(blocks: &str) -> Model {
    let text = format!(
        "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"gms\"\nbreakaway_N = 0.9\nblocks = [{blocks}]\n"
    );
    Model::parse(&text).unwrap()
}

const TWO: &str = "{ stiffness_N_per_m = 113948.0, weight = 0.616 }, { stiffness_N_per_m = 8870.0, weight = 0.384 }";

fn budget(share: f64) -> Budget {
    Budget {
        clock: 170e6,
        rate: 20e3,
        share,
    }
}

#[test]
fn the_cheapest_arithmetic_that_is_accurate_is_recommended() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let tuning = of_model(&model(TWO), 25e-9, &costs, budget(0.05)).unwrap();
    assert_eq!(
        tuning.choices.len(),
        Kernel::ALL.len(),
        "{:?}",
        tuning.notes
    );
    let (index, reason) = tuning.recommended.clone().unwrap();
    let chosen = &tuning.choices[index];
    for other in &tuning.choices {
        assert!(
            other.arithmetic < 1.0,
            "{:?}: {} %",
            other.kernel,
            other.arithmetic
        );
        let worst = |c: &super::Choice| c.tick.unwrap().worst;
        assert!(worst(chosen) <= worst(other));
    }
    assert!((chosen.share - chosen.cost.cycles_worst / 8_500.0).abs() < 1e-12);
    assert!(reason.contains("--recording"), "{reason}");
    let json = tuning.to_json(0.0);
    assert_eq!(json["recommended"]["kernel"], chosen.kernel.name());
    assert_eq!(json["rows"].as_array().unwrap().len(), tuning.choices.len());
}

#[test]
fn a_budget_below_the_cheapest_kernel_says_that_nothing_fits_and_what_would() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let tuning = of_model(&model(TWO), 25e-9, &costs, budget(1e-4)).unwrap();
    let reason = tuning.recommended.clone().unwrap_err();
    assert!(
        reason.contains("nothing fits") && reason.contains("--rate"),
        "{reason}"
    );
    assert_eq!(tuning.to_json(0.0)["fits"], false);
    // As it is typed.
    let said = |option: &str| {
        let told = reason.split(option).nth(1).expect(option).trim_start();
        let end = told.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        told[..end.unwrap_or(told.len())]
            .parse::<f64>()
            .expect(option)
    };
    let (rate, share) = (said("--rate to"), 0.01 * said("--budget"));
    for would in [
        Budget {
            rate,
            ..budget(1e-4)
        },
        budget(share),
    ] {
        let tuning = of_model(&model(TWO), 25e-9, &costs, would).unwrap();
        assert!(
            tuning.recommended.is_ok(),
            "{reason}: {:?}",
            tuning.recommended
        );
    }
}

#[test]
fn a_kernel_whose_range_the_model_leaves_is_left_out_with_the_reason() {
    let soft = "{ stiffness_N_per_m = 100.0, weight = 1.0 }"; // 9 mm of yield displacement
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let tuning = of_model(&model(soft), 25e-9, &costs, budget(0.05)).unwrap();
    assert!(tuning.choices.iter().all(|c| c.kernel != Kernel::Packed));
    assert!(
        tuning
            .notes
            .iter()
            .any(|n| n.starts_with("packed") && n.contains("yield displacement"))
    );
}

/// A count that is short beside the blocks' yields, 5 and 39 µm, takes nothing; one of their size is said; one far longer is refused, though no
/// arithmetic rounds on it.
#[test]
fn counts_longer_than_the_blocks_are_said_and_then_refused() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    for (count, least, most, note) in [
        (25e-9, 0.0, 1.0, false),
        (4e-6, 2.0, 44.0, true),
        (1e-3, 90.0, 500.0, true),
    ] {
        let tuning = of_model(&model(TWO), count, &costs, budget(0.05)).unwrap();
        let lost = tuning.counting;
        assert!((least..most).contains(&lost), "{count}: {lost} %");
        let said = tuning.notes.iter().any(|n| n.contains("counts"));
        assert_eq!(said, note, "{count}: {:?}", tuning.notes);
        let refused = lost > super::TOO_COARSE;
        assert_eq!(tuning.recommended.is_err(), refused, "{count}");
        if let Err(reason) = tuning.recommended {
            assert!(reason.contains("--count 1.00 mm"), "{reason}");
        }
    }
}

/// What is named can be typed: no rate of 0 Hz, no budget above the processor.
#[test]
fn a_clock_in_the_wrong_unit_is_said_to_be_one() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let slow = |clock| {
        let budget = Budget {
            clock,
            ..budget(0.05)
        };
        of_model(&model(TWO), 25e-9, &costs, budget)
            .unwrap()
            .recommended
            .unwrap_err()
    };
    let reason = slow(1e3);
    assert!(
        reason.contains("0.001 MHz is given: check its unit"),
        "{reason}"
    );
    let reason = slow(20e6);
    assert!(
        reason.contains("lower --rate to") && !reason.contains("unit"),
        "{reason}"
    );
}

#[test]
fn a_model_without_blocks_is_refused() {
    let text = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"coulomb\"\ncoulomb_N = 0.9\n";
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let error = of_model(&Model::parse(text).unwrap(), 25e-9, &costs, budget(0.05)).unwrap_err();
    assert!(error.contains("Coulomb"), "{error}");
}

#[test]
fn blocks_that_the_encoder_does_not_see_are_told() {
    let text = "schema = \"preslide.model/1\"\nmotion = \"linear\"\n[friction]\nkind = \"gms\"\nbreakaway_N = 1.0\nblocks = [{ stiffness_N_per_m = 1e6, weight = 0.5 }, { stiffness_N_per_m = 1e4, weight = 0.5 }]\n";
    let (model, costs) = (
        Model::parse(text).unwrap(),
        CostTable::of_cpu("cortex-m4").unwrap(),
    );
    // They yield at 0.5 and 50 µm.
    for (count, told) in [(1e-7, None), (1e-5, Some("1 of 2")), (1e-4, Some("2 of 2"))] {
        let notes = of_model(&model, count, &costs, budget(0.05)).unwrap().notes;
        let unseen = notes.iter().find(|note| note.contains("unseen"));
        assert_eq!(unseen.is_some(), told.is_some(), "{notes:?}");
        assert!(
            told.is_none_or(|told| unseen.unwrap().ends_with(told)),
            "{notes:?}"
        );
    }
}

#[test]
fn a_clock_too_slow_for_the_whole_tick_fits_nothing_though_friction_alone_would() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let slow = Budget {
        clock: 8e6,
        ..budget(0.5)
    };
    let tuning = of_model(&model(TWO), 25e-9, &costs, slow).unwrap();
    assert!(tuning.choices.iter().any(|c| c.share <= slow.share));
    let reason = tuning.recommended.clone().unwrap_err();
    assert!(
        reason.contains("whole control tick") && reason.contains("--rate"),
        "{reason}"
    );
}

#[test]
fn every_core_gets_its_own_kernel() {
    let cores = CORES.iter().map(|core| {
        let costs = core.costs().unwrap();
        let budget = budget_on(core, None, 20e3, 0.05);
        assert_eq!(budget.clock, core.clock);
        let tuning = of_model(&model(TWO), 25e-9, &costs, budget).unwrap();
        OnCore { core, tuning }
    });
    let comparison = Comparison {
        cores: cores.collect(),
    };
    assert!(comparison.fits());
    let json = comparison.to_json(0.0);
    let chosen = |index: usize| json["cores"][index]["tuning"]["recommended"]["kernel"].clone();
    for (index, core) in CORES.iter().enumerate() {
        let kernel = chosen(index);
        let is_float = kernel.as_str().is_some_and(|name| name.ends_with("f32"));
        assert!(
            kernel.is_string() && (core.title.contains("M4F") || !is_float),
            "{}: {kernel}",
            core.title
        );
    }
    assert!(
        comparison
            .notes()
            .iter()
            .any(|note| note.contains("Cortex-M0+"))
    );
    assert_eq!(comparison.table().rows.len(), CORES.len());
}

/// Whatever is recommended keeps the bound that the recommendation states; where nothing does, that is said.
#[test]
fn nothing_is_recommended_that_adds_more_than_the_bound() {
    let costs = CostTable::of_cpu("cortex-m4").unwrap();
    let tuning = of_model(&model(TWO), 25e-9, &costs, budget(0.05)).unwrap();
    for (added, fits) in [(0.3, true), (0.7, false), (107.6, false), (f64::NAN, false)] {
        let mut choices = tuning.choices.clone();
        choices.iter_mut().for_each(|c| c.arithmetic = added);
        let told = recommend(&choices, budget(0.05), None);
        assert_eq!(told.is_ok(), fits, "{added}: {told:?}");
        if let Err(reason) = told {
            assert!(reason.contains("adds at most 0.5 %"), "{reason}");
        }
    }
    // Only a kernel that the budget has no time for is exact: it is named with the budget that it needs.
    let mut choices = tuning.choices.clone();
    for choice in &mut choices {
        let exact = choice.kernel == Kernel::GmsF32;
        (choice.arithmetic, choice.share) = if exact { (0.0, 0.08) } else { (3.0, 0.01) };
    }
    let reason = recommend(&choices, budget(0.05), None).unwrap_err();
    assert!(reason.contains("--budget 8.00% for gms_f32"), "{reason}");
}

/// As many blocks as `identify` recommends; where they are beyond the budget, what it would recommend of the rest. In either case the arithmetic is
/// the one that the sentence says it is.
#[test]
fn a_recording_is_tuned_for_the_blocks_that_identify_recommends() {
    let text = recorded(|v, f| 1e5 * v * (1.0 - f / 0.9 * v.signum()), |_, f| f);
    let recording = load_csv(text.as_bytes(), "made.csv", &LoadOptions::default()).unwrap();
    let found = identify(&recording, &Options::default(), &Progress::new("", 0)).unwrap();
    let wanted = found.best().size();
    assert!(wanted > 1);
    let (costs, budget) = (CostTable::of_cpu("cortex-m4").unwrap(), budget(0.05));
    let tuning = of_recording(&recording, &found, &model(TWO), 25e-9, &costs, budget).unwrap();
    let of_fewer = tuning.choices.iter().filter(|c| c.cost.blocks < wanted);
    let of_fewer: Vec<super::Choice> = of_fewer.cloned().collect();
    let fewer = found.recommended_among(|n| n < wanted).expect("fewer");
    for (choices, blocks) in [(&tuning.choices, wanted), (&of_fewer, fewer.size())] {
        let (index, reason) = recommend(choices, budget, Some(&found)).unwrap();
        let chosen = &choices[index];
        assert_eq!(chosen.cost.blocks, blocks, "{reason}");
        let worst = |c: &super::Choice| c.tick.unwrap().worst;
        let rivals = choices
            .iter()
            .filter(|c| c.cost.blocks == blocks && c.arithmetic <= 0.5);
        assert!(rivals.into_iter().all(|c| worst(chosen) <= worst(c)));
        let said = format!("control tick at worst, {:.0} cycles", worst(chosen));
        assert!(reason.contains(&said), "{reason}");
    }
}
