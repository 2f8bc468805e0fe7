//! Names of what figures show, with units; those of axes are the analysis' own.

use std::f64::consts::PI;

use crate::analyze::labels::Power;
pub(crate) use crate::analyze::labels::{frequency, position, time, wavenumber};
use crate::analyze::{Analysis, Axes, Scaling};

/// The second reading of a wavenumber axis: `k a / π` with the site spacing a.
pub(crate) fn wavenumber_reading(axes: &Axes) -> Option<(String, f64)> {
    let factor = axes.space.step / PI;
    (factor.is_finite() && factor > 0.0).then(|| ("k a / π  (a: site spacing)".into(), factor))
}

/// What short-time spectra show, with unit.
pub(crate) fn short_time_density(analysis: &Analysis) -> String {
    power(analysis).over_frequency(&analysis.axes)
}

/// What short-space spectra show, with unit.
pub(crate) fn short_space_density(analysis: &Analysis) -> String {
    power(analysis).over_wavenumber(&analysis.axes)
}

/// The integral of a site's spectrum over frequency, with unit.
pub(crate) fn site_energy(analysis: &Analysis) -> String {
    energy(analysis, analysis.axes.time_unit())
}

/// The integral of a time's spectrum over wavenumber, with unit.
pub(crate) fn time_energy(analysis: &Analysis) -> String {
    energy(analysis, analysis.axes.space_unit())
}

fn power(analysis: &Analysis) -> Power<'_> {
    Power {
        scaling: analysis.conventions.scaling,
        unit: analysis.unit.as_deref(),
    }
}

fn energy(analysis: &Analysis, length: &str) -> String {
    let square = power(analysis).square();
    match analysis.conventions.scaling {
        Scaling::Energy => format!("energy ({square} {length})"),
        Scaling::Density | Scaling::Spectrum => format!("mean square ({square})"),
    }
}
