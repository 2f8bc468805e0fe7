//! Names of axes and quantities, with their units.

use super::{Analysis, Axes};
use crate::field::Axis;
use crate::sheet::Units;
use crate::transform::Scaling;
use crate::unit::{self, compose, label};

/// `time (s)`, `time (samples)` where times are counted, `time` where a step has no unit.
pub(crate) fn time(axes: &Axes) -> String {
    of_axis(&axes.time, ["time (samples)", "time"])
}

/// `position (m)`, `site` where sites are counted, `position` where a step has no unit.
pub(crate) fn position(axes: &Axes) -> String {
    of_axis(&axes.space, ["site", "position"])
}

fn of_axis(axis: &Axis, [counted, name]: [&str; 2]) -> String {
    match &axis.unit {
        Some(unit) => format!("{name} ({unit})"),
        None if axis.step == 1.0 => counted.into(),
        None => name.into(),
    }
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

/// How powers are scaled and what they are measured in.
pub(crate) struct Power {
    scaling: Scaling,
    units: Units,
    /// Of the square of stored amplitudes.
    square: String,
}

impl Power {
    pub fn of(analysis: &Analysis) -> Power {
        let (unit, amplitude) = (&analysis.unit, analysis.accuracy.amplitude_unit);
        let scaling = analysis.conventions.scaling;
        Power::new(&analysis.axes, scaling, unit.as_deref(), amplitude)
    }

    /// `amplitude`, in `unit` where that is known, is that whose square counts as 1.
    pub fn new(axes: &Axes, scaling: Scaling, unit: Option<&str>, amplitude: f64) -> Power {
        let unit = unit.unwrap_or_default();
        Power {
            scaling,
            units: Units::of(&axes.time, &axes.space, None),
            square: match amplitude == 1.0 {
                true => unit::square(unit),
                false => unit::square(&unit::times(&unit::scientific(amplitude, 3), unit)),
            },
        }
    }

    /// S(f, x), or a short-time spectrum: over frequency.
    pub fn over_frequency(&self) -> String {
        self.density(&[&self.square, &self.units.time], &[&self.units.frequency])
    }

    /// S(k, t), or a short-space spectrum: over wavenumber.
    pub fn over_wavenumber(&self) -> String {
        self.density(
            &[&self.square, &self.units.space],
            &[&self.units.wavenumber],
        )
    }

    /// S(k, f): over both.
    pub fn over_both(&self) -> String {
        let of = &self.units;
        let over = [&self.square, &of.time, &of.space];
        self.density(&over.map(|unit| &**unit), &[&of.frequency, &of.wavenumber])
    }

    /// `Pi_K(k, t)`: half of `v^2 dx` a unit of time, so per unit of mass.
    pub fn flux(&self) -> String {
        let unit = compose(&[&self.square, &self.units.space], &[&self.units.time]);
        label("kinetic flux surrogate per unit mass", &unit)
    }

    /// The integral of a site's spectrum over frequency.
    pub fn of_site(&self) -> String {
        self.energy(&self.units.time)
    }

    /// The integral of a time's spectrum over wavenumber.
    pub fn of_time(&self) -> String {
        self.energy(&self.units.space)
    }

    /// Spectral density over bins, of the square times lengths.
    fn density(&self, over: &[&str], bins: &[&str]) -> String {
        match self.scaling {
            Scaling::Energy => label("energy spectral density", &compose(over, bins)),
            Scaling::Density => label("power spectral density", &compose(&over[..1], bins)),
            Scaling::Spectrum => label("power spectrum", &self.square),
        }
    }

    fn energy(&self, length: &str) -> String {
        match self.scaling {
            Scaling::Energy => label("energy", &compose(&[&self.square, length], &[])),
            Scaling::Density | Scaling::Spectrum => label("mean square", &self.square),
        }
    }
}
