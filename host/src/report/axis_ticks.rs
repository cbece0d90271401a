//! The range of an axis in a picture, and where its ticks stand. (On the page plotly.js places its own.)

/// The drawn range of an axis, in display units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    lo: f64,
    hi: f64,
    log: bool,
}

/// A tick: where, and what is written there.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub text: String,
}

impl Span {
    /// The range of the finite `values` with a margin; an arbitrary one when there is none. On a log axis the values
    /// are positive (see `drawing`).
    pub fn over(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let to_axis = |v: f64| if log { v.log10() } else { v };
        let (lo, hi) = values
            .map(to_axis)
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
                (lo.min(v), hi.max(v))
            });
        let (lo, hi) = if lo > hi { (0.0, 1.0) } else { (lo, hi) };
        let margin = match hi - lo {
            width if width > 0.0 => 0.04 * width,
            _ if log || lo == 0.0 => 0.5,
            _ => 0.05 * lo.abs(),
        };
        Span {
            lo: lo - margin,
            hi: hi + margin,
            log,
        }
    }

    /// Where `value` lies: 0 at the start of the axis, 1 at its end. Bounded, so that pixels stay computable when the
    /// range exceeds what f64 can subtract.
    pub fn fraction(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        ((value - self.lo) / (self.hi - self.lo)).clamp(-1.0, 2.0)
    }

    /// About `about` ticks at round values.
    pub fn ticks(&self, about: usize) -> Vec<Tick> {
        if !self.log {
            return linear_ticks(self.lo, self.hi, about);
        }
        let (first, last) = (self.lo.ceil() as i32, self.hi.floor() as i32);
        let decades = i64::from(last) - i64::from(first) + 1;
        if decades >= 3 {
            let step = (decades as usize).div_ceil(about.max(1));
            return (first..=last)
                .step_by(step)
                .map(|e| Tick {
                    at: 10f64.powi(e),
                    text: power_of_ten(e),
                })
                .collect();
        }
        let fine: Vec<Tick> = (first - 1..=last)
            .flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(e)))
            .filter(|v| (0.0..=1.0).contains(&self.fraction(*v)))
            .map(|at| Tick {
                at,
                text: number(at),
            })
            .collect();
        if fine.len() >= 2 {
            fine
        } else {
            linear_ticks(10f64.powf(self.lo), 10f64.powf(self.hi), about)
        }
    }
}

fn linear_ticks(lo: f64, hi: f64, about: usize) -> Vec<Tick> {
    let raw = (hi - lo) / about.max(1) as f64;
    let power = 10f64.powf(raw.log10().floor());
    if !(raw.is_finite() && power > 0.0 && power.is_finite()) {
        return Vec::new();
    }
    let step = power
        * [1.0, 2.0, 5.0]
            .into_iter()
            .find(|m| m * power >= raw)
            .unwrap_or(10.0);
    // A power of ten common to all ticks keeps long numbers off the axis.
    let largest = lo.abs().max(hi.abs());
    let common = if (1e-3..1e5).contains(&largest) {
        0
    } else {
        largest.log10().floor() as i32
    };
    let unit = 10f64.powi(common);
    let decimals = (-(step / unit).log10().floor()).clamp(0.0, 12.0) as usize;
    let first = (lo / step).ceil();
    // A step below the resolution of f64 at this magnitude would never end.
    (0..=2 * about)
        .map(|i| (first + i as f64) * step)
        .take_while(|at| *at <= hi)
        .map(|at| {
            let mantissa = minus(format!("{:.decimals$}", at / unit + 0.0));
            let text = if common == 0 || at == 0.0 {
                mantissa
            } else {
                format!("{mantissa}·{}", power_of_ten(common))
            };
            Tick { at, text }
        })
        .collect()
}

/// A positive number of one digit, plain or with a power of ten.
fn number(value: f64) -> String {
    let exponent = value.log10().floor() as i32;
    if (-3..5).contains(&exponent) {
        let decimals = (-exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!(
            "{:.0}·{}",
            value / 10f64.powi(exponent),
            power_of_ten(exponent)
        )
    }
}

fn power_of_ten(exponent: i32) -> String {
    let superscript = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' => char::from_u32('⁴' as u32 + (c as u32 - '4' as u32)).unwrap_or(c),
        _ => '⁰',
    };
    format!(
        "10{}",
        exponent
            .to_string()
            .chars()
            .map(superscript)
            .collect::<String>()
    )
}

fn minus(text: String) -> String {
    text.replacen('-', "−", 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(span: Span, about: usize) -> Vec<String> {
        span.ticks(about).into_iter().map(|t| t.text).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        let span = Span::over([-0.9, 0.9].into_iter(), false);
        assert_eq!(texts(span, 4), ["−0.5", "0.0", "0.5"]);
        let large = Span::over([0.0, 270_313.0].into_iter(), false);
        assert_eq!(texts(large, 3), ["0", "1·10⁵", "2·10⁵"]);
        for tick in span.ticks(9) {
            assert!((0.0..=1.0).contains(&span.fraction(tick.at)));
        }
    }

    #[test]
    fn log_ticks_are_decades_or_one_two_five() {
        assert_eq!(
            texts(Span::over([1e-3, 10.0].into_iter(), true), 6),
            ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"]
        );
        assert_eq!(
            texts(Span::over([0.1, 3.0].into_iter(), true), 6),
            ["0.1", "0.2", "0.5", "1", "2"]
        );
        assert!(texts(Span::over([3.1, 3.4].into_iter(), true), 6).len() >= 2);
        assert!(texts(Span::over([1e-300, 1e300].into_iter(), true), 6).len() <= 7);
    }

    #[test]
    fn degenerate_ranges_neither_panic_nor_run_away() {
        for values in [
            vec![],
            vec![0.0],
            vec![5.0, 5.0],
            vec![-1e308, 1e308],
            vec![1e9, 1e9 + 1e-7],
            vec![5e-324],
        ] {
            for log in [false, true] {
                assert!(
                    Span::over(values.iter().copied(), log).ticks(8).len() <= 17,
                    "{values:?}"
                );
            }
        }
    }
}
