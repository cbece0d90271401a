//! All integration tests of the program, linked once: `cargo test -p preslide-cli --test all export::` runs a module.

mod binary;
mod cli;
mod exit_codes;
mod export;
mod export_c;
mod fleet;
mod reading;

#[test]
fn every_file_of_tests_runs() {
    let none: [&str; 0] = [];
    assert_eq!(
        preslide_host_tests::forgotten_tests(env!("CARGO_MANIFEST_DIR")),
        none
    );
}
