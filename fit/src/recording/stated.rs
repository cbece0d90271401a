//! The sample time in a line above the samples: `Sample rate: 500 Hz`, `# dt = 2 ms`, `SampleTime[ms];2`.

use super::units::{self, Dimension};

/// What a sample time is called, and what its inverse, without blanks and signs.
const TIMES: [&str; 9] = [
    "sampletime",
    "samplingtime",
    "sampleperiod",
    "samplingperiod",
    "sampleinterval",
    "samplinginterval",
    "cycletime",
    "abtastzeit",
    "zykluszeit",
];
const RATES: [&str; 6] = [
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "abtastrate",
    "abtastfrequenz",
];
/// The same, where they are all that stands before the number.
const SHORT_TIMES: [&str; 3] = ["dt", "ts", "deltat"];
const SHORT_RATES: [&str; 4] = ["fs", "rate", "frequency", "frequenz"];

/// The sample time (s) of such a line.
pub(super) fn sample_time(line: &str) -> Option<f64> {
    let at = line.find(|c: char| c.is_ascii_digit())?;
    let (before, after) = line.split_at(at);
    let end = after.find(|c: char| !(c.is_ascii_digit() || ".eE-+".contains(c)));
    let (number, after) = after.split_at(end.unwrap_or(after.len()));
    let number: f64 = number.trim_end_matches(['.', 'e', 'E']).parse().ok()?;
    // The unit stands behind the number, or in brackets behind the name.
    let bracket = before.split_once(['[', '(']);
    let (name, inside) =
        match bracket.and_then(|(name, rest)| Some((name, rest.split_once([']', ')'])?))) {
            Some((name, (unit, _))) => (name, Some(unit)),
            None => (before, None),
        };
    let word = |text: &str| {
        let text = text.trim_start_matches(|c: char| !c.is_alphabetic() && c != 'µ');
        let end = text.find(|c: char| !(c.is_alphabetic() || "µ/".contains(c)));
        text[..end.unwrap_or(text.len())].to_owned()
    };
    let unit = inside.map_or_else(|| word(after), str::to_owned);
    let name: String = name.chars().filter(|c| c.is_alphabetic()).collect();
    let name = name.to_lowercase();
    let called = |long: &[&str], short: &[&str]| {
        long.iter().any(|w| name.contains(w)) || short.contains(&name.as_str())
    };
    let time = if called(&TIMES, &SHORT_TIMES) {
        match units::unit(&unit) {
            Some(u) if u.dimension == Dimension::Time => number * u.factor,
            None if unit.is_empty() => number,
            _ => return None,
        }
    } else if called(&RATES, &SHORT_RATES) {
        match unit.to_lowercase().as_str() {
            "hz" | "" | "samples/s" | "/s" => 1.0 / number,
            "khz" => 1e-3 / number,
            _ => return None,
        }
    } else {
        return None;
    };
    (time.is_finite() && time > 0.0).then_some(time)
}

#[cfg(test)]
mod tests {
    use super::sample_time;

    #[test]
    fn sample_times_and_rates_are_read_with_their_units() {
        for (line, time) in [
            ("Sample rate: 500 Hz", 2e-3),
            ("Sampling Rate [kHz];2", 0.5e-3),
            ("# fs = 250", 4e-3),
            ("# dt=0.002", 2e-3),
            ("% Ts: 125 us", 125e-6),
            ("SampleTime[ms]\t2\tSampleTime[ms]\t2", 2e-3),
            ("Abtastzeit (µs): 250", 250e-6),
            ("Rate;1000", 1e-3),
        ] {
            let found = sample_time(line).unwrap_or_else(|| panic!("{line}"));
            assert!((found / time - 1.0).abs() < 1e-12, "{line}: {found}");
        }
        for line in [
            "",
            "Sample rate",
            "# logger v1.2",
            "# date 2024-03-31",
            "Sample rate: 0 Hz",
            "Sample time 5 mm",
            "baud rate 115200",
            "t_s,x_m,force_N",
        ] {
            assert_eq!(sample_time(line), None, "{line}");
        }
    }
}
