//! Names of powers, with their units.

use super::{Analysis, Axes};
use crate::arrays::LargeArray;
use crate::sheet::Units;
use crate::transform::Scaling;
use crate::unit::{self, compose, label};

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

    /// Of a large array of an analysis.
    pub fn of_array(&self, array: LargeArray) -> String {
        match array {
            LargeArray::TEMPORAL_SPECTRUM => self.over_frequency(),
            LargeArray::SPATIAL_SPECTRUM => self.over_wavenumber(),
            LargeArray::SPACETIME_SPECTRUM => self.over_both(),
            _ => self.flux(),
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
    fn over_both(&self) -> String {
        let of = &self.units;
        let over = [&self.square, &of.time, &of.space];
        self.density(&over.map(|unit| &**unit), &[&of.frequency, &of.wavenumber])
    }

    /// `Pi_K(k, t)`: half of `v^2 dx` a unit of time, so per unit of mass.
    fn flux(&self) -> String {
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
