//! Names of powers, with their units.

use super::Analysis;
use super::axes::{Axes, Side};
use crate::arrays::LargeArray;
use crate::sheet::{Role, Units};
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
            LargeArray::KINETIC_FLUX_SURROGATE => self.flux(),
            _ => self.density(&Side::of(array)),
        }
    }

    /// `Pi_K(k, t)`: half of `v^2 dx` a unit of time, so per unit of mass.
    fn flux(&self) -> String {
        let unit = compose(&[&self.square, &self.units.space], &[&self.units.time]);
        label("kinetic flux surrogate per unit mass", &unit)
    }

    /// Spectral density over those of the axes that count bins.
    pub fn density(&self, sides: &[Side]) -> String {
        let bins = sides.iter().filter_map(|side| self.of_bins(*side));
        let (lengths, bins): (Vec<&str>, Vec<&str>) = bins.unzip();
        let square = &[&self.square[..]];
        match self.scaling {
            Scaling::Energy => {
                let over = [square, &lengths[..]].concat();
                label("energy spectral density", &compose(&over, &bins))
            }
            Scaling::Density => label("power spectral density", &compose(square, &bins)),
            Scaling::Spectrum => label("power spectrum", &self.square),
        }
    }

    /// The integral of a spectrum over the bins of an axis.
    pub fn energy(&self, bins: Side) -> String {
        let length = self.of_bins(bins).map_or("", |(length, _)| length);
        match self.scaling {
            Scaling::Energy => label("energy", &compose(&[&self.square, length], &[])),
            Scaling::Density | Scaling::Spectrum => label("mean square", &self.square),
        }
    }

    /// Units of what is transformed to bins, and of these.
    fn of_bins(&self, side: Side) -> Option<(&str, &str)> {
        let of = &self.units;
        match side.role() {
            Role::Frequency => Some((&of.time, &of.frequency)),
            Role::Wavenumber => Some((&of.space, &of.wavenumber)),
            Role::Time | Role::Position => None,
        }
    }
}
