//! Round numbers along an axis, and how they are written.

use std::ops::Range;

/// A labelled value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub text: String,
}

/// How the values of a linear axis are written: `(value - offset) / 10^exponent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Notation {
    pub offset: f64,
    pub exponent: i32,
}

impl Notation {
    /// Keeps tick labels short: large offsets and powers of a thousand go to the axis label.
    pub fn of(low: f64, high: f64) -> Self {
        let span = high - low;
        let mut largest = low.abs().max(high.abs());
        let mut offset = 0.0;
        if largest > 1e5 * span {
            offset = low;
            largest = span;
        }
        let exponent = if (1e-2..1e5).contains(&largest) || largest == 0.0 {
            0
        } else {
            3 * (largest.log10() / 3.0).floor() as i32
        };
        Notation { offset, exponent }
    }

    /// `label` with the offset before and the power of ten inside its unit's brackets.
    pub fn label(&self, label: &str) -> String {
        let (name, unit) = match label.rfind(" (").filter(|_| label.ends_with(')')) {
            Some(at) => (&label[..at], &label[at + 2..label.len() - 1]),
            None => (label, ""),
        };
        let mut out = name.to_owned();
        if self.offset != 0.0 {
            out.push_str(&format!(" − {}", self.offset));
        }
        let power = match self.exponent {
            0 => String::new(),
            exponent => power_of_ten(exponent),
        };
        match (power.is_empty(), unit.is_empty()) {
            (true, true) => out,
            (false, false) => format!("{out} ({power} {unit})"),
            _ => format!("{out} ({power}{unit})"),
        }
    }
}

/// Multiples of 1, 2 or 5 times a power of ten inside `low..=high`, at most about `count`.
pub(super) fn linear(low: f64, high: f64, count: usize, notation: Notation) -> Vec<Tick> {
    let (low, high) = (low - notation.offset, high - notation.offset);
    let step = round_step((high - low) / count.max(1) as f64);
    let unit = 10f64.powi(notation.exponent);
    let decimals = (-(step / unit).log10().floor()).clamp(0.0, 12.0) as usize;
    let slack = 1e-9 * (high - low);
    let first = ((low - slack) / step).ceil();
    (0..=2 * count + 4)
        .map(|index| (first + index as f64) * step)
        .take_while(|value| *value <= high + slack)
        .map(|value| Tick {
            value: value + notation.offset,
            text: decimal(value / unit, decimals),
        })
        .collect()
}

/// Powers of ten inside `low..=high`, thinned to about `count`; within one decade 1, 2, 5, or,
/// where these are not two, every digit.
pub(super) fn logarithmic(low: f64, high: f64, count: usize) -> Vec<Tick> {
    let (bottom, top) = (low.log10(), high.log10());
    let (first, last) = ((bottom - 1e-9).ceil() as i32, (top + 1e-9).floor() as i32);
    if last - first >= 1 {
        let step = ((last - first) as usize / count.max(1) + 1) as i32;
        return (first..=last)
            .filter(|exponent| exponent.rem_euclid(step) == 0)
            .map(|exponent| Tick {
                value: 10f64.powi(exponent),
                text: power_of_ten(exponent),
            })
            .collect();
    }
    let with = |digits: &[u8]| -> Vec<Tick> {
        (first - 1..=last)
            .flat_map(|exponent| digits.iter().map(move |&digit| multiple(digit, exponent)))
            .filter(|tick| (low..=high).contains(&tick.value))
            .collect()
    };
    let few = with(&[1, 2, 5]);
    if few.len() > 1 {
        few
    } else {
        with(&[1, 2, 3, 4, 5, 6, 7, 8, 9])
    }
}

fn multiple(digit: u8, exponent: i32) -> Tick {
    Tick {
        value: f64::from(digit) * 10f64.powi(exponent),
        text: match digit {
            1 => power_of_ten(exponent),
            _ => format!("{digit}·{}", power_of_ten(exponent)),
        },
    }
}

fn round_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    match rough / power {
        r if r <= 1.0 => power,
        r if r <= 2.0 => 2.0 * power,
        r if r <= 5.0 => 5.0 * power,
        _ => 10.0 * power,
    }
}

fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.into(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// A positive value with two digits: `3.2·10⁻⁸`.
pub(super) fn scientific(value: f64) -> String {
    let text = format!("{value:.1e}");
    match text.split_once('e') {
        Some((digits, exponent)) => {
            let raised: String = exponent.chars().map(raise).collect();
            format!("{digits}·10{raised}")
        }
        None => text,
    }
}

/// `10` with a raised exponent.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = exponent.to_string().chars().map(raise).collect::<String>();
    format!("10{raised}")
}

/// A tick's label in ASCII with the fewest digits that identify it, all labels of an axis in one
/// format: with exponents where the axis's largest magnitude (on a logarithmic one, either end) is
/// tiny or huge.
pub(super) fn short(v: f64, axis: &Range<f64>, logarithmic: bool) -> String {
    let plain = |size: f64| (1e-3..=1e5).contains(&size);
    if logarithmic {
        // Decades come from logarithms, and are ones only to rounding.
        return match plain(axis.start) && plain(axis.end) {
            true => trimmed(format!("{v:.*}", (3 - magnitude(v)).max(0) as usize)),
            false => match format!("{v:.3e}").split_once('e') {
                Some((digits, power)) => format!("{}e{power}", trimmed(digits.into())),
                None => format!("{v:e}"),
            },
        };
    }
    let largest = axis.start.abs().max(axis.end.abs());
    let exponent = if plain(largest) {
        0
    } else {
        magnitude(largest)
    };
    let unit = 10f64.powi(exponent);
    // Ticks are sums of steps of two digits at most, about a tenth of the span.
    let decimals = (3 - magnitude((axis.end - axis.start) / unit)).clamp(0, 12) as usize;
    let digits = trimmed(format!("{:.decimals$}", v / unit));
    match exponent {
        _ if digits == "0" || digits == "-0" => "0".into(),
        0 => digits,
        _ => format!("{digits}e{exponent}"),
    }
}

/// The power of ten of a number's first digit, 0 for 0.
fn magnitude(v: f64) -> i32 {
    match v == 0.0 {
        true => 0,
        // A decade that misses by rounding is one.
        false => (v.abs().log10() + 1e-12).floor() as i32,
    }
}

fn trimmed(digits: String) -> String {
    match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.').into(),
        false => digits,
    }
}

fn raise(c: char) -> char {
    match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁻',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.text.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        let notation = Notation::of(-1.0, 1.0);
        assert_eq!(
            texts(&linear(-1.0, 1.0, 5, notation)),
            ["−1.0", "−0.5", "0.0", "0.5", "1.0"]
        );
    }

    #[test]
    fn thousands_and_offsets_move_to_the_label() {
        let kilo = Notation::of(0.0, 2.5e5);
        assert_eq!(kilo.label("frequency (Hz)"), "frequency (10³ Hz)");
        assert_eq!(kilo.label("site"), "site (10³)");
        assert_eq!(
            texts(&linear(0.0, 2.5e5, 5, kilo)),
            ["0", "50", "100", "150", "200", "250"]
        );
        let late = Notation::of(1.7e9, 1.7e9 + 10.0);
        assert_eq!(late.label("time (s)"), "time − 1700000000 (s)");
        assert_eq!(linear(1.7e9, 1.7e9 + 10.0, 5, late)[1].text, "2");
    }

    #[test]
    fn decades_are_thinned() {
        assert_eq!(texts(&logarithmic(1e-8, 1.0, 4)), ["10⁻⁶", "10⁻³", "10⁰"]);
        assert_eq!(texts(&logarithmic(1.5, 7.0, 4)), ["2·10⁰", "5·10⁰"]);
        assert_eq!(texts(&logarithmic(1.5, 3.4, 4)), ["2·10⁰", "3·10⁰"]);
    }

    #[test]
    fn labels_of_one_axis_are_written_alike() {
        let texts = |axis: Range<f64>, logarithmic, ticks: &[f64]| -> Vec<String> {
            let ticks = ticks.iter();
            ticks.map(|v| short(*v, &axis, logarithmic)).collect()
        };
        let sums = [3.469e-18, 0.25, 0.30000000000000004, -0.5];
        assert_eq!(texts(-0.5..1.0, false, &sums), ["0", "0.25", "0.3", "-0.5"]);
        let across = [9.5e-4, 1e-3, 1.05e-3];
        assert_eq!(
            texts(9.2e-4..1.07e-3, false, &across),
            ["0.00095", "0.001", "0.00105"]
        );
        let tiny = [0.0, 5e-5, 9.999999999999998e-5, 1.5e-4];
        assert_eq!(
            texts(0.0..1.7e-4, false, &tiny),
            ["0", "0.5e-4", "1e-4", "1.5e-4"]
        );
        let huge = [-1e6, 2.5e5, 1e6];
        assert_eq!(texts(-1e6..1.2e6, false, &huge), ["-1e6", "0.25e6", "1e6"]);
        // Far from 0, a step apart.
        assert_eq!(
            texts(400.0..400.5, false, &[400.0, 400.25]),
            ["400", "400.25"]
        );
        let decades = [9.999999999999998e-5, 1e-2, 1.0, 20.0];
        assert_eq!(
            texts(1e-4..20.0, true, &decades),
            ["1e-4", "1e-2", "1e0", "2e1"]
        );
        let few = [0.0010000000000000002, 0.03, 1.0, 1000.0];
        assert_eq!(texts(1e-3..1e3, true, &few), ["0.001", "0.03", "1", "1000"]);
    }
}
