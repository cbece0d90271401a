//! All integration tests of the workspace in one program, which is linked once: `cargo test -p preslide-host-tests --test all accuracy::` runs a module.

mod accuracy;
mod answers;
mod axis;
mod basics;
mod bits;
mod control;
mod diagnose;
mod effects;
mod electrical;
mod encoder;
mod encoder_on_load;
mod family;
mod faults;
mod identify;
mod identify_core;
mod kernels;
mod koopman;
mod laws;
mod learning;
mod measured;
mod mutants;
mod notch;
mod observer;
mod on_the_fit;
mod outer;
mod parameters;
mod places;
mod plain;
mod properties;
mod real;
mod reference;
mod simulate;
mod simulated;
mod soak;
mod swap;
mod swing;
mod tracking;
mod trials;
mod units;
mod where_forces_go;
mod winding;

#[test]
fn every_file_of_tests_runs() {
    let none: [&str; 0] = [];
    assert_eq!(
        preslide_host_tests::forgotten_tests(env!("CARGO_MANIFEST_DIR")),
        none
    );
}
