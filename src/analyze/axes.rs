//! The axes of the results: what each counts, its names and its bins.

use std::borrow::Cow;

use crate::arrays::LargeArray;
use crate::field::Axis;
use crate::sheet::{Role, Units};
use crate::unit::{label, split};

/// The axes of the results. An axis without a unit counts samples or sites.
#[derive(Debug, Clone)]
pub struct Axes {
    /// Times analyzed; `origin` is the first of them.
    pub time: Axis,
    pub n_times: usize,
    /// Sites analyzed; `origin` is the first of them.
    pub space: Axis,
    pub n_sites: usize,
    /// Frequencies `m df`, in cycles per time unit, from 0.
    pub frequency: Vec<f64>,
    /// Wavenumbers `m dk`, in rad per length unit, from 0.
    pub wavenumber: Vec<f64>,
    /// Wavenumbers of both signs, ascending; positive travels towards +x.
    pub wavenumber_signed: Vec<f64>,
}

impl Axes {
    pub fn times(&self) -> Vec<f64> {
        (0..self.n_times).map(|n| self.time.at(n)).collect()
    }

    pub fn positions(&self) -> Vec<f64> {
        (0..self.n_sites).map(|j| self.space.at(j)).collect()
    }

    /// The row of the time nearest to `t`.
    pub(super) fn row_at(&self, t: f64) -> usize {
        let index = ((t - self.time.origin) / self.time.step).round().max(0.0);
        (index as usize).min(self.n_times.saturating_sub(1))
    }

    /// In words where they are not known.
    pub(crate) fn units(&self) -> Units {
        Units::in_words(&self.time, &self.space, None)
    }

    /// Rows and columns of an array of an analysis.
    pub(super) fn shape(&self, array: LargeArray) -> (usize, usize) {
        let [rows, columns] = Side::of(array).map(|side| side.grid(self).count);
        (rows, columns)
    }
}

/// Evenly spaced coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub first: f64,
    pub step: f64,
    pub count: usize,
}

impl Grid {
    pub fn at(&self, index: usize) -> f64 {
        self.first + index as f64 * self.step
    }
}

/// One of the [`Axes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Time,
    Space,
    Frequency,
    Wavenumber,
    /// Of both signs.
    SignedWavenumber,
}

impl Side {
    pub const ALL: [Side; 5] = [
        Side::Time,
        Side::Space,
        Side::Frequency,
        Side::Wavenumber,
        Side::SignedWavenumber,
    ];

    /// The axes of rows and of columns.
    pub fn of(array: LargeArray) -> [Side; 2] {
        let named = |name| Side::ALL.into_iter().find(|side| side.name() == name);
        array
            .axes()
            .map(|name| named(name).expect("an axis of an analysis"))
    }

    /// The array that holds its coordinates.
    pub fn name(self) -> &'static str {
        match self {
            Side::SignedWavenumber => "wavenumber_signed",
            _ => self.role().words()[0],
        }
    }

    pub fn role(self) -> Role {
        match self {
            Side::Time => Role::Time,
            Side::Space => Role::Position,
            Side::Frequency => Role::Frequency,
            Side::Wavenumber | Side::SignedWavenumber => Role::Wavenumber,
        }
    }

    /// In words where it is not known.
    pub fn unit(self, axes: &Axes) -> String {
        axes.units().unit(self.role()).into()
    }

    /// `time (s)`, `position (m)`, `frequency (Hz)`: always in cycles, `wavenumber (rad/m)`: always in rad. `time (samples)` or
    /// `site` where they are counted, the name alone where a step has no unit.
    pub fn label(self, axes: &Axes) -> String {
        let of = |axis: &Axis, counted: &str| match &axis.unit {
            Some(unit) => format!("{} ({unit})", self.name()),
            None if axis.step == 1.0 => counted.into(),
            None => self.name().into(),
        };
        match self {
            Side::Time => of(&axes.time, "time (samples)"),
            Side::Space => of(&axes.space, "site"),
            _ => {
                let unit = self.unit(axes).replace("/unit of", " per unit of");
                label(self.role().words()[0], &unit)
            }
        }
    }

    /// Of its array; empty for a step without one.
    pub fn array_unit(self, axes: &Axes) -> String {
        match self {
            Side::Time | Side::Space => split(&self.label(axes)).1.into(),
            _ => self.unit(axes),
        }
    }

    pub fn coordinates(self, axes: &Axes) -> Cow<'_, [f64]> {
        match self {
            Side::Time => axes.times().into(),
            Side::Space => axes.positions().into(),
            Side::Frequency => (&axes.frequency).into(),
            Side::Wavenumber => (&axes.wavenumber).into(),
            Side::SignedWavenumber => (&axes.wavenumber_signed).into(),
        }
    }

    pub fn grid(self, axes: &Axes) -> Grid {
        let sampled = |axis: &Axis, count| Grid {
            first: axis.origin,
            step: axis.step,
            count,
        };
        let bins = |bins: &[f64], from_zero: &[f64]| Grid {
            first: bins[0],
            step: from_zero.get(1).copied().unwrap_or(1.0),
            count: bins.len(),
        };
        match self {
            Side::Time => sampled(&axes.time, axes.n_times),
            Side::Space => sampled(&axes.space, axes.n_sites),
            Side::Frequency => bins(&axes.frequency, &axes.frequency),
            Side::Wavenumber => bins(&axes.wavenumber, &axes.wavenumber),
            Side::SignedWavenumber => bins(&axes.wavenumber_signed, &axes.wavenumber),
        }
    }
}
