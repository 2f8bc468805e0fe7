//! One axis of a panel.

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

    /// A linear axis that shows all of `values`, and zero.
    pub fn around(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite())
            .fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        let room = 0.04 * (high - low);
        let below = if low < 0.0 { room } else { 0.0 };
        match high - low {
            0.0 => PlotAxis::linear(label, 0.0, 1.0),
            _ => PlotAxis::linear(label, low - below, high + room),
        }
    }

    /// A logarithmic axis that shows all positive `values`.
    pub fn log_around(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite() && *v > 0.0)
            .fold((f64::INFINITY, 0.0f64), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        let (low, high) = if high > 0.0 {
            (low / 1.5, high * 1.5)
        } else {
            (0.1, 1.0)
        };
        PlotAxis {
            log: true,
            ..PlotAxis::linear(label, low, high)
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
