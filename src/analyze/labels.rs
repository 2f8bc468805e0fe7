//! Names of axes and quantities, with their units.

use super::Axes;
use crate::field::Quantity;
use crate::transform::Scaling;

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
    format!("frequency ({})", axes.frequency_unit())
}

/// `wavenumber (rad/m)`: always in rad.
pub(crate) fn wavenumber(axes: &Axes) -> String {
    format!("wavenumber ({})", axes.wavenumber_unit())
}

/// How powers are scaled and what their amplitudes are measured in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Power<'a> {
    pub scaling: Scaling,
    /// Unit of the samples, where known.
    pub unit: Option<&'a str>,
}

impl Power<'_> {
    /// S(f, x), or a short-time spectrum: over frequency.
    pub fn over_frequency(self, axes: &Axes) -> String {
        self.density(axes.time_unit(), &axes.frequency_unit())
    }

    /// S(k, t), or a short-space spectrum: over wavenumber.
    pub fn over_wavenumber(self, axes: &Axes) -> String {
        self.density(axes.space_unit(), &axes.wavenumber_unit())
    }

    /// S(k, f): over both.
    pub fn over_both(self, axes: &Axes) -> String {
        let length = format!("{} {}", factor(axes.time_unit()), axes.space_unit());
        let bin = format!(
            "{} {}",
            factor(&axes.frequency_unit()),
            factor(&axes.wavenumber_unit())
        );
        self.density(&length, &bin)
    }

    /// `Pi_K(k, t)`: half of `v^2 dx` a unit of time, so per unit of mass.
    pub fn flux(self, axes: &Axes) -> String {
        format!(
            "kinetic flux surrogate per unit mass ({} {} / {})",
            self.square(),
            axes.space_unit(),
            factor(axes.time_unit())
        )
    }

    fn density(self, length: &str, bin: &str) -> String {
        let (square, bin) = (self.square(), factor(bin));
        match self.scaling {
            Scaling::Energy => format!("energy spectral density ({square} {length} / {bin})"),
            Scaling::Density => format!("power spectral density ({square} / {bin})"),
            Scaling::Spectrum => format!("power spectrum ({square})"),
        }
    }

    pub fn square(self) -> String {
        match self.unit {
            Some(unit) => format!("{}²", factor(unit)),
            None => "field unit²".into(),
        }
    }
}

/// A unit as a factor of a product: composed units in brackets.
fn factor(unit: &str) -> String {
    if unit.contains(['/', ' ', '*', '·', '^']) {
        format!("({unit})")
    } else {
        unit.into()
    }
}
