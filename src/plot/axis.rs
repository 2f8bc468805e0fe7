//! One axis of a panel.

use std::ops::Range;

use super::ticks::{self, Notation, Tick};

/// A range of values with its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlotAxis {
    pub label: String,
    pub low: f64,
    pub high: f64,
    pub log: bool,
    /// Label of a second reading of the same axis, and what values are multiplied by for it.
    pub second: Option<(String, f64)>,
}

/// The range of a linear axis that shows all of `values`, and zero.
pub fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    let room = 0.04 * (high - low);
    let below = if low < 0.0 { room } else { 0.0 };
    match high - low {
        0.0 => 0.0..1.0,
        _ => low - below..high + room,
    }
}

/// The range of a logarithmic axis that shows the positive `values` within `decades` of the largest.
pub(super) fn log_around(values: impl Iterator<Item = f64>, decades: f64) -> Range<f64> {
    let positive = values.filter(|v| v.is_finite() && *v > 0.0);
    let (low, high) = positive.fold((f64::INFINITY, 0.0f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    match high > 0.0 {
        true => (low / 1.5).max(high * 10f64.powf(-decades))..high * 1.5,
        false => 0.1..1.0,
    }
}

impl PlotAxis {
    /// A linear axis; an empty or undefined range is widened to one unit.
    pub fn linear(label: &str, low: f64, high: f64) -> Self {
        let (low, high) = match (low.is_finite() && high.is_finite(), low < high) {
            (true, true) => (low, high),
            (true, false) => (low - 0.5, low + 0.5),
            (false, _) => (0.0, 1.0),
        };
        PlotAxis {
            label: label.into(),
            low,
            high,
            log: false,
            second: None,
        }
    }

    /// A linear or logarithmic axis over a range.
    pub fn over(label: &str, range: &Range<f64>, log: bool) -> Self {
        let log = log && range.start > 0.0 && range.end > range.start;
        PlotAxis {
            log,
            ..PlotAxis::linear(label, range.start, range.end)
        }
    }

    pub fn with_second(self, second: Option<(String, f64)>) -> Self {
        PlotAxis { second, ..self }
    }

    /// Place of `value` between the ends, 0 to 1; `None` where it cannot be placed.
    pub fn share(&self, value: f64) -> Option<f64> {
        let share = if self.log {
            (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln())
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.is_finite().then_some(share)
    }

    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        if self.log {
            ticks::logarithmic(self.low, self.high, count)
        } else {
            ticks::linear(self.low, self.high, count, self.notation())
        }
    }

    /// The second reading as an axis of its own.
    pub fn second_axis(&self) -> Option<PlotAxis> {
        let (label, factor) = self.second.as_ref()?;
        Some(PlotAxis::linear(
            label,
            self.low * factor,
            self.high * factor,
        ))
    }

    pub fn title(&self) -> String {
        if self.log {
            self.label.clone()
        } else {
            self.notation().label(&self.label)
        }
    }

    fn notation(&self) -> Notation {
        Notation::of(self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_node_does_not_stretch_a_logarithmic_axis() {
        let range = |values: &[f64]| log_around(values.iter().copied(), 8.0);
        let node = range(&[1.0, 1e-32, 0.2, f64::NAN, 0.0]);
        assert!((node.start / 1e-8 - 1.0).abs() < 1e-12 && node.end == 1.5);
        assert_eq!(range(&[1.0, 0.3]), 0.3 / 1.5..1.5);
        assert_eq!(range(&[0.0]), 0.1..1.0);
    }
}
