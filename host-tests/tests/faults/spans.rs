//! Readings at and beyond the ends of their codes.

use preslide_app::Scales;
use preslide_axis::{AxisFile, OWN};
use proptest::prelude::*;

/// A sensor of ±10 A: 6.6 A read 0.05 A; and 70 V, 4.5 V.
#[test]
fn a_reading_beyond_its_codes_is_the_largest() {
    let scales = Scales::new(80.0, 20.0);
    assert_eq!(scales.current(1352), i16::MAX);
    assert_eq!(scales.current(-1352), i16::MIN);
    assert_eq!(scales.current(100), 4882);
    assert_eq!(scales.supply(3584), u16::MAX);
    assert_eq!(scales.supply(2048), 40_000);
}

proptest! {
    /// Whatever the spans, a larger code never reads as less, and what fits reads as it is.
    #[test]
    fn readings_rise_with_their_codes(full in 0.1..1e5_f64, span in 0.1..1e5_f64, code in 0_u16..4095, of in -4095..4095) {
        let scales = Scales::new(full, span);
        prop_assert!(scales.supply(code) <= scales.supply(code + 1));
        prop_assert!(scales.current(of) <= scales.current(of + 1));
        let (volts, amperes) = (full * f64::from(code) / 4096.0, span * f64::from(of) / 4096.0);
        let supply = (volts * 1e3).min(65_535.0);
        let current = (amperes * 1e4).clamp(-32_768.0, 32_767.0);
        prop_assert!((f64::from(scales.supply(code)) - supply).abs() <= 2.0);
        prop_assert!((f64::from(scales.current(of)) - current).abs() <= 2.0);
    }
}

/// A limit that the board's converter does not reach is refused where the file is read, with its key and the remedy.
#[test]
fn a_limit_beyond_what_a_board_reads_is_refused() {
    let refused = |from: &str, to: &str| {
        assert_eq!(OWN.matches(from).count(), 1, "{from}");
        let error = AxisFile::parse("axis.toml", &OWN.replace(from, to));
        error.expect_err("out of reach").to_string()
    };
    let told = refused("current_span = 6.4 ", "current_span = 2.0 ");
    assert!(
        told.contains("watch.current_max") && told.contains("boards.stm32g474.current_span"),
        "{told}"
    );
    let told = refused("supply_full = 36.3 ", "supply_full = 7.2 ");
    assert!(
        told.contains("watch.supply_max") && told.contains("boards.stm32g474.supply_full"),
        "{told}"
    );
    let told = refused("current_max = 1.0", "current_max = 3.25");
    assert!(
        told.contains("largest current") || told.contains("watch.current_max"),
        "{told}"
    );
}
