//! The laws that checks run through: a row each, with parameters, and its equation solved by other means in a file beside this one, which shares no
//! code, formulation or data layout with the library. To add a law: that file, and a row in [`all`].

mod any;
mod bouc_wen;
mod dahl;
mod elasto_plastic;
mod hsieh;
mod leuven;
mod lugre;
mod two_state;

pub use any::{AnyLaw, built};
pub use bouc_wen::BoucWen;
pub use dahl::Dahl;
pub use hsieh::Hsieh;

use crate::accuracy::{Bounds, Tick, bounds};
use preslide::{HsiehParams, LeuvenForm, Sliding};
use preslide_fit::friction::FrictionModel;
use preslide_host_tests::path::{COUNT, SAMPLE_TIME, random_reversals};
use preslide_host_tests::reference::Stribeck;
use preslide_host_tests::table3::{BREAKAWAY, blocks, column, falling, hsieh};

/// A law, and what is known of it.
pub struct Law {
    pub name: &'static str,
    /// As on the paper's stage, for `bits.txt`.
    pub stage: FrictionModel,
    /// Parameters up to the ends of their ranges; of the first ones nothing is damped and nothing creeps.
    pub models: Vec<FrictionModel>,
    /// By how much (N) the force along a path may depend on the steps in which it is walked.
    pub steps: f64,
    pub equations: Vec<Equation>,
}

/// A model, its equation, and how near they are along a path.
pub struct Equation {
    pub what: String,
    pub model: FrictionModel,
    pub path: Vec<Tick>,
    /// Force (N) after so many counts more at that velocity (m/s).
    pub force: Force,
    pub bounds: Vec<Bounds>,
}

type Force = Box<dyn FnMut(i32, f64) -> f64 + Send>;

const SEED: u64 = 1227;
const STIFFNESS: f64 = 195_000.0;

/// Counts in a tick and a velocity (m/s): standstill or a hundred Stribeck velocities, where the table needs no
/// interpolation, changing every few ticks.
pub fn jumping() -> Vec<Tick> {
    let counts = random_reversals(SEED, 20_000, 4_000.0, 200.0);
    let ticks = counts.into_iter().enumerate().map(|(i, counts)| {
        let speed = if i / 7 % 3 == 0 { 0.1 } else { 0.0 };
        (counts, speed * f64::from(counts.signum()))
    });
    ticks.collect()
}

/// None faster than 2 mm/s: the references integrate adaptively.
pub fn slow() -> Vec<Tick> {
    random_reversals(SEED, 100_000, 2_000.0, 4.0)
        .into_iter()
        .map(|counts| (counts, f64::from(counts) * COUNT / SAMPLE_TIME))
        .collect()
}

fn weakening() -> Sliding {
    falling(0.8 * BREAKAWAY, 2_000.0)
}

/// The same curves for references, from a Coulomb force (N).
fn stribeck(coulomb: f64) -> Stribeck {
    Stribeck {
        breakaway: BREAKAWAY,
        coulomb,
        velocity: 1e-3,
        exponent: 2.0,
    }
}

/// With a lag, for `bits.txt`.
pub const LAGGING: Sliding = Sliding {
    coulomb: 0.81,
    stribeck_velocity: 1e-3,
    stribeck_exponent: 1.5,
    attraction: 20.0,
};

fn metres(counts: i32) -> f64 {
    f64::from(counts) * COUNT
}

/// Bounds in `f32` and `f64`: largest, RMS and mean error (N).
fn floats(within: [[f64; 3]; 2]) -> Vec<Bounds> {
    let of = |number, [max, rms, bias]: [f64; 3]| bounds(number, max, rms, bias);
    vec![of("f32", within[0]), of("f64", within[1])]
}

/// The laws.
pub fn all() -> Vec<Law> {
    let leuven = [
        ("Leuven", LeuvenForm::Modified),
        ("Leuven, original", LeuvenForm::Original),
    ];
    let mut all = vec![
        gms(),
        quasi_static(),
        dahl(),
        lugre(),
        bouc_wen(),
        elasto_plastic(),
        two_state(),
        hsieh_and_pan(),
    ];
    all.extend(leuven.map(|(name, form)| self::leuven(name, form)));
    all
}

#[test]
fn every_law_of_a_model_file_has_a_row() {
    let rows = all();
    for model in FrictionModel::one_of_each(1.0, 1.0) {
        let kind = model.kind();
        let has_row = rows.iter().any(|law| law.stage.kind() == kind);
        // Coulomb's force is checked for itself.
        assert!(has_row || kind == "coulomb", "{kind}");
    }
}

/// Its equations, block by block, are another check's.
fn gms() -> Law {
    let model = |blocks: &[_], sliding| FrictionModel::Gms {
        breakaway: BREAKAWAY,
        blocks: blocks.to_vec(),
        sliding: Some(sliding),
    };
    let slow_lag = falling(0.8 * BREAKAWAY, 500.0);
    Law {
        name: "Gms",
        stage: model(&blocks::<4>(), LAGGING),
        models: vec![
            model(&blocks::<6>(), slow_lag),
            model(&blocks::<6>(), weakening()),
            model(&blocks::<10>(), slow_lag),
        ],
        steps: 1e-12,
        equations: Vec::new(),
    }
}

/// As [`gms`].
fn quasi_static() -> Law {
    let model = |blocks: &[_]| FrictionModel::Gms {
        breakaway: BREAKAWAY,
        blocks: blocks.to_vec(),
        sliding: None,
    };
    Law {
        name: "QuasiStaticGms",
        stage: model(&blocks::<6>()),
        models: vec![model(&blocks::<6>()), model(&blocks::<10>())],
        steps: 1e-12,
        equations: Vec::new(),
    }
}

fn dahl() -> Law {
    let model = |exponent| FrictionModel::Dahl {
        stiffness: 320_000.0,
        coulomb: BREAKAWAY,
        exponent,
    };
    let equation = |exponent: f64| {
        let mut equation = Dahl {
            stiffness: 320_000.0,
            coulomb: BREAKAWAY,
            exponent,
            force: 0.0,
        };
        let mut within = floats([[3.5e-6, 1e-6, 5e-8], [1.2e-12, 4e-13, 2e-14]]);
        if exponent != 1.001 {
            within.extend([
                bounds("I16F16", 4.5e-3, 1.6e-3, 1.2e-4),
                bounds("I8F24", 2e-5, 5e-6, 4e-7),
                bounds("I32F32", 1.6e-6, 2e-7, 5e-9),
            ]);
        }
        Equation {
            what: format!("Dahl, n = {exponent}"),
            model: model(exponent),
            path: slow(),
            force: Box::new(move |counts, _| equation.advance(metres(counts))),
            bounds: within,
        }
    };
    Law {
        name: "Dahl",
        stage: model(1.6),
        // On either side of 1, and so near it that the equation is another.
        models: [1.6, 0.4, 0.5, 0.9999, 1.0, 1.00001].map(model).into(),
        steps: 1e-9,
        equations: [0.5, 1.0, 1.001, 1.6, 3.0].map(equation).into(),
    }
}

fn lugre() -> Law {
    let model = |damping, sliding| FrictionModel::LuGre {
        stiffness: STIFFNESS,
        damping,
        breakaway: BREAKAWAY,
        sliding,
    };
    let equation = |coulomb: f64, within: [Bounds; 4]| {
        let mut equations = lugre::LuGre {
            stiffness: STIFFNESS,
            damping: 4_416.0,
            stribeck: stribeck(coulomb),
            sample_time: SAMPLE_TIME,
            elastic: 0.0,
        };
        Equation {
            what: format!("LuGre, F_c = {coulomb} N"),
            model: model(4_416.0, falling(coulomb, f64::INFINITY)),
            path: slow(),
            force: Box::new(move |counts, v| equations.advance(metres(counts), v)),
            bounds: within.to_vec(),
        }
    };
    // Rounding alone; with a Stribeck effect the table's error, too.
    let flat = [
        bounds("f32", 1.3e-5, 2e-6, 7e-8),
        bounds("f64", 5e-14, 8e-15, 1e-15),
        bounds("I16F16", 2.2e-3, 4e-4, 5e-5),
        bounds("I32F32", 1.1e-5, 2e-6, 5e-8),
    ];
    let weak = [
        bounds("f32", 1.5e-3, 1.7e-4, 1.3e-5),
        bounds("f64", 1.5e-3, 1.7e-4, 1.3e-5),
        bounds("I16F16", 1.8e-2, 7e-3, 3e-4),
        bounds("I32F32", 1.5e-3, 1.7e-4, 1.3e-5),
    ];
    Law {
        name: "LuGre",
        stage: model(4_416.0, LAGGING),
        models: vec![
            model(0.0, Sliding::none(BREAKAWAY)),
            model(0.0, weakening()),
            model(300.0, weakening()),
            model(4_416.0, weakening()),
        ],
        steps: 1e-12,
        equations: vec![equation(BREAKAWAY, flat), equation(0.6, weak)],
    }
}

fn bouc_wen() -> Law {
    let model = |stiffness, exponent, shape| FrictionModel::BoucWen {
        stiffness,
        coulomb: BREAKAWAY,
        exponent,
        shape,
    };
    let equation = |(exponent, shape, max, rms): (f64, f64, f64, f64)| {
        let mut equation = BoucWen::new(320_000.0, BREAKAWAY, exponent, shape);
        Equation {
            what: format!("Bouc-Wen, n = {exponent}, sigma = {shape}"),
            model: model(320_000.0, exponent, shape),
            path: jumping(),
            force: Box::new(move |counts, _| equation.advance(metres(counts))),
            bounds: floats([[max + 5e-6, rms + 1.5e-6, 6e-7], [max, rms, 2e-7]]),
        }
    };
    let shapes = [(1.6, 0.75), (1.0, 0.5), (20.0, 2.0)];
    // The power's kink at `u = 0` costs the fourth-order step its order, most for n = 1 with another slope beyond it.
    let equations = [
        (1.0, 1.0, 2e-7, 2e-8),
        (1.0, 0.5, 1.5e-4, 5e-6),
        (1.6, 0.75, 1.2e-5, 1e-6),
        (3.0, 2.0, 6e-5, 6e-6),
    ];
    Law {
        name: "BoucWen",
        stage: model(STIFFNESS, 1.6, 0.8),
        models: shapes.map(|(n, shape)| model(320_000.0, n, shape)).to_vec(),
        steps: 2e-5,
        equations: equations.map(equation).into(),
    }
}

fn elasto_plastic() -> Law {
    let model = |damping, elastic, sliding| FrictionModel::ElastoPlastic {
        stiffness: STIFFNESS,
        damping,
        elastic,
        breakaway: BREAKAWAY,
        sliding,
    };
    let equation = |damping| {
        let mut equation = elasto_plastic::ElastoPlastic {
            stiffness: STIFFNESS,
            damping,
            elastic: 1.5e-6,
            stribeck: stribeck(0.8 * BREAKAWAY),
            sample_time: SAMPLE_TIME,
            deflection: 0.0,
        };
        Equation {
            what: format!("elasto-plastic, sigma_1 = {damping}"),
            model: model(damping, 1.5e-6, weakening()),
            path: jumping(),
            force: Box::new(move |counts, v| equation.advance(metres(counts), v)),
            bounds: floats([[5e-6, 2e-6, 7e-7], [1.2e-6, 1.2e-7, 2e-8]]),
        }
    };
    Law {
        name: "ElastoPlastic",
        stage: model(400.0, 2e-6, LAGGING),
        models: [0.0, 10.0, 100.0, 300.0]
            .map(|damping| model(damping, 1.5e-6, weakening()))
            .to_vec(),
        steps: 5e-6,
        equations: [0.0, 1.0].map(equation).into(),
    }
}

fn two_state() -> Law {
    let model = |presliding, sliding| FrictionModel::TwoState {
        presliding,
        breakaway: BREAKAWAY,
        sliding,
    };
    let mut equation = two_state::TwoState::new(
        35e-6,
        stribeck(0.8 * BREAKAWAY),
        weakening().attraction,
        SAMPLE_TIME,
        COUNT,
    );
    Law {
        name: "TwoState",
        stage: model(30e-6, LAGGING),
        models: vec![model(35e-6, weakening())],
        steps: 1e-12,
        equations: vec![Equation {
            what: "two-state".to_owned(),
            model: model(35e-6, weakening()),
            path: jumping(),
            force: Box::new(move |counts, v| equation.advance(counts, v)),
            bounds: floats([[8e-6, 1.2e-6, 2e-7], [1.5e-14, 3e-15, 3e-16]]),
        }],
    }
}

/// The reference of the same parameters.
pub fn marched(params: &HsiehParams) -> Hsieh {
    Hsieh::new([
        params.k1,
        params.k2,
        params.beta,
        params.creep,
        params.hardening,
        params.hardening_exponent,
    ])
}

fn hsieh_and_pan() -> Law {
    let model = |viscous, creep| FrictionModel::Hsieh(hsieh(viscous, creep));
    // The library solves each tick at its end: an error of the order of a tick, not of rounding.
    let equation = |viscous, [max, rms, bias]: [f64; 3]| {
        let mut equations = marched(&hsieh(viscous, 500.0));
        Equation {
            what: format!("Hsieh, C_v = {viscous} N·s/m"),
            model: model(viscous, 500.0),
            path: slow().into_iter().take(10_000).collect(),
            force: Box::new(move |counts, v| {
                let (force, plastic) = equations.advance(metres(counts), SAMPLE_TIME, 500);
                force + viscous * (v - plastic)
            }),
            bounds: ["f32", "f64", "I32F32 of 10 mN"]
                .map(|number| bounds(number, max, rms, bias))
                .to_vec(),
        }
    };
    let sets = [
        (0.0, 0.0),
        (0.0, 500.0),
        (40.0, 1e-7),
        (100.0, 500.0),
        (4_416.0, 500.0),
    ];
    Law {
        name: "Hsieh",
        stage: model(5_000.0, 500.0),
        models: sets.map(|(viscous, creep)| model(viscous, creep)).to_vec(),
        steps: 1e-6,
        equations: vec![
            equation(0.0, [9e-3, 5e-4, 3e-5]),
            equation(100.0, [5e-2, 1.2e-3, 3e-6]),
        ],
    }
}

fn leuven(name: &'static str, form: LeuvenForm) -> Law {
    let model = |blocks: &[_], exponent, damping, sliding| FrictionModel::Leuven {
        form,
        breakaway: BREAKAWAY,
        blocks: blocks.to_vec(),
        exponent,
        damping,
        sliding,
    };
    let equation = |damping| {
        let original = form == LeuvenForm::Original;
        let mut equation = leuven::Leuven::new(column(6), BREAKAWAY, 2.0, damping, original);
        Equation {
            what: format!("{name}, sigma_1 = {damping}"),
            model: model(&blocks::<6>(), 2.0, damping, Sliding::none(BREAKAWAY)),
            path: jumping(),
            force: Box::new(move |counts, v| equation.advance(metres(counts), v)),
            bounds: floats([[6e-6, 6e-7, 3e-7], [6e-6, 2e-7, 1.5e-8]]),
        }
    };
    Law {
        name,
        stage: model(&blocks::<4>(), 5.0, 9.0, LAGGING),
        models: [0.0, 10.0, 100.0, 300.0]
            .map(|damping| model(&blocks::<6>(), 2.0, damping, weakening()))
            .to_vec(),
        steps: 1e-4,
        equations: [0.0, 0.5].map(equation).into(),
    }
}
