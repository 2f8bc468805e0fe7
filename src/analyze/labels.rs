//! Names of axes and quantities, with their units.

use super::{Analysis, Axes};
use crate::field::Quantity;
use crate::transform::Scaling;
use crate::unit::{self, compose, label};

/// What the samples measure, in words.
pub(crate) fn quantity(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Velocity => "velocity",
        Quantity::Displacement => "displacement",
        Quantity::Acceleration => "acceleration",
        Quantity::StrainRate => "strain rate",
        Quantity::Force => "force",
    }
}

/// `time (s)`.
pub(crate) fn time(axes: &Axes) -> String {
    axes.time_label()
}

/// `position (m)`.
pub(crate) fn position(axes: &Axes) -> String {
    axes.position_label()
}

/// `frequency (Hz)`: always in cycles.
pub(crate) fn frequency(axes: &Axes) -> String {
    in_words("frequency", &axes.frequency_unit())
}

/// `wavenumber (rad/m)`: always in rad.
pub(crate) fn wavenumber(axes: &Axes) -> String {
    in_words("wavenumber", &axes.wavenumber_unit())
}

fn in_words(name: &str, unit: &str) -> String {
    label(name, &unit.replace("/unit of", " per unit of"))
}

/// How powers are scaled and what their amplitudes are measured in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Power<'a> {
    pub scaling: Scaling,
    /// Unit of the samples, where known.
    pub unit: Option<&'a str>,
    /// Amplitude whose square counts as 1, in that unit.
    pub amplitude: f64,
}

impl<'a> Power<'a> {
    pub fn of(analysis: &'a Analysis) -> Power<'a> {
        Power {
            scaling: analysis.conventions.scaling,
            unit: analysis.unit.as_deref(),
            amplitude: analysis.accuracy.amplitude_unit,
        }
    }
}

impl Power<'_> {
    /// S(f, x), or a short-time spectrum: over frequency.
    pub fn over_frequency(self, axes: &Axes) -> String {
        let [time, _] = steps(axes);
        self.density(&[time.0], &[&time.1])
    }

    /// S(k, t), or a short-space spectrum: over wavenumber.
    pub fn over_wavenumber(self, axes: &Axes) -> String {
        let [_, space] = steps(axes);
        self.density(&[space.0], &[&space.1])
    }

    /// S(k, f): over both.
    pub fn over_both(self, axes: &Axes) -> String {
        let [time, space] = steps(axes);
        self.density(&[time.0, space.0], &[&time.1, &space.1])
    }

    /// `Pi_K(k, t)`: half of `v^2 dx` a unit of time, so per unit of mass.
    pub fn flux(self, axes: &Axes) -> String {
        let [time, space] = steps(axes);
        let unit = compose(&[&self.square(), space.0], &[time.0]);
        label("kinetic flux surrogate per unit mass", &unit)
    }

    /// Spectral density over bins of units `bins`, of axes of units `lengths`.
    fn density(self, lengths: &[&str], bins: &[&str]) -> String {
        let square = self.square();
        let over: Vec<&str> = [&square[..]].into_iter().chain(lengths.to_vec()).collect();
        match self.scaling {
            Scaling::Energy => label("energy spectral density", &compose(&over, bins)),
            Scaling::Density => label("power spectral density", &compose(&over[..1], bins)),
            Scaling::Spectrum => label("power spectrum", &square),
        }
    }

    fn square(self) -> String {
        let unit = self.unit.unwrap_or_default();
        if self.amplitude == 1.0 {
            return unit::square(unit);
        }
        let amplitude = unit::scientific(self.amplitude, 3);
        unit::square(&unit::times(&amplitude, unit))
    }

    /// The integral of a site's spectrum over frequency.
    pub fn of_site(self, axes: &Axes) -> String {
        let [time, _] = steps(axes);
        self.energy(time.0)
    }

    /// The integral of a time's spectrum over wavenumber.
    pub fn of_time(self, axes: &Axes) -> String {
        let [_, space] = steps(axes);
        self.energy(space.0)
    }

    fn energy(self, length: &str) -> String {
        let square = self.square();
        match self.scaling {
            Scaling::Energy => label("energy", &compose(&[&square, length], &[])),
            Scaling::Density | Scaling::Spectrum => label("mean square", &square),
        }
    }
}

/// Units of time and length, each with that of its frequency; empty for an axis without one, whose
/// steps are numbers.
fn steps(axes: &Axes) -> [(&str, String); 2] {
    fn of(unit: &Option<String>, bin: String) -> (&str, String) {
        let known = unit.as_deref().map(|unit| (unit, bin));
        known.unwrap_or_default()
    }
    let (time, space) = (&axes.time.unit, &axes.space.unit);
    let [f, k] = [axes.frequency_unit(), axes.wavenumber_unit()];
    [of(time, f), of(space, k)]
}
