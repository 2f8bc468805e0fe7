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
