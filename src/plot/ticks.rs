//! Round numbers along an axis, and how they are written.

use crate::unit::{self, power_of_ten};

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
        let (name, unit) = unit::split(label);
        let label = match self.offset {
            0.0 => label.to_owned(),
            offset => unit::label(&format!("{name} − {offset}"), unit),
        };
        unit::in_powers_of_ten(&label, self.exponent)
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
    let power = power_of_ten(exponent);
    Tick {
        value: f64::from(digit) * 10f64.powi(exponent),
        text: match (digit, exponent) {
            (_, 0..=3) => format!("{digit}{}", "0".repeat(exponent as usize)),
            (_, -3..=-1) => format!("0.{}{digit}", "0".repeat(-exponent as usize - 1)),
            (1, _) => power,
            _ => format!("{digit}·{power}"),
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
        assert_eq!(texts(&logarithmic(1.5, 7.0, 4)), ["2", "5"]);
        assert_eq!(texts(&logarithmic(1.5e-2, 3.4e-2, 4)), ["0.02", "0.03"]);
        assert_eq!(texts(&logarithmic(2e3, 6e3, 4)), ["2000", "5000"]);
        assert_eq!(texts(&logarithmic(2e5, 6e5, 4)), ["2·10⁵", "5·10⁵"]);
    }
}
