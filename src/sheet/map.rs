//! Maps as data: values over two axes.

use std::ops::Range;

use ndarray::Array2;
use serde::Serialize;

use super::Units;
use super::chart::Mark;

/// What an axis counts; picks on a page are shared between axes that count the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    Time,
    Position,
    Frequency,
    Wavenumber,
}

impl Role {
    /// Name and symbol.
    pub(crate) fn words(self) -> [&'static str; 2] {
        match self {
            Role::Time => ["time", "t"],
            Role::Position => ["position", "x"],
            Role::Frequency => ["frequency", "f"],
            Role::Wavenumber => ["wavenumber", "k"],
        }
    }
}

/// What the colours of a map reach over.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Colors {
    /// Linear between two values; if these are symmetric about 0, the colours diverge from it.
    Between(Range<f64>),
    /// Logarithmic, down from the largest value.
    #[default]
    Powers,
}

/// A dashed line over a map, broken where its points are not finite.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Empty for one that goes on with the one before.
    pub label: String,
    pub points: Vec<(f64, f64)>,
}

/// Values over two axes, each row from the lower end of the vertical axis on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeatChart {
    /// Above the frame; may be empty.
    pub title: String,
    /// What to look for, in one sentence on a page; may be empty.
    pub caption: String,
    pub x_label: String,
    pub y_label: String,
    /// What the colours mean, with its unit.
    pub label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Whether columns are evenly spaced in the logarithm of x.
    pub log_x: bool,
    pub values: Array2<f64>,
    pub colors: Colors,
    /// Uprights over the map.
    pub marks: Vec<Mark>,
    pub curves: Vec<Curve>,
    /// What x and y count, for a page.
    pub roles: Option<[Role; 2]>,
}

impl HeatChart {
    /// Values over two axes with the centres of their cells; the vertical one has no negative values.
    pub(crate) fn over(
        units: &Units,
        roles: [Role; 2],
        [x, y]: [&[f64]; 2],
        values: Array2<f64>,
    ) -> HeatChart {
        let vertical = range(y);
        HeatChart {
            x_label: units.label(roles[0]),
            y_label: units.label(roles[1]),
            x: range(x),
            y: vertical.start.max(0.0)..vertical.end,
            values,
            roles: Some(roles),
            ..HeatChart::default()
        }
    }
}

/// The ends of an axis whose cells have these centres.
pub(crate) fn edges(centres: &[f64]) -> (f64, f64) {
    match centres {
        [] => (0.0, 1.0),
        [only] => (only - 0.5, only + 0.5),
        [first, second, ..] => {
            let half = (second - first) / 2.0;
            (first - half, centres[centres.len() - 1] + half)
        }
    }
}

/// The range of an axis whose cells have these centres.
pub(crate) fn range(centres: &[f64]) -> Range<f64> {
    let (low, high) = edges(centres);
    low..high
}
