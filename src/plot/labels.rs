//! Names of axes and quantities, with their units.

use std::f64::consts::PI;

use crate::analyze::{Analysis, Axes, Scaling};

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

/// The second reading of a wavenumber axis: `k a / π` with the site spacing a.
pub(crate) fn wavenumber_reading(axes: &Axes) -> Option<(String, f64)> {
    let factor = axes.space.step / PI;
    (factor.is_finite() && factor > 0.0).then(|| ("k a / π  (a: site spacing)".into(), factor))
}

/// What short-time spectra show, with unit.
pub(crate) fn short_time_density(analysis: &Analysis) -> String {
    density(
        analysis,
        analysis.axes.time_unit(),
        &analysis.axes.frequency_unit(),
    )
}

/// What short-space spectra show, with unit.
pub(crate) fn short_space_density(analysis: &Analysis) -> String {
    density(
        analysis,
        analysis.axes.space_unit(),
        &analysis.axes.wavenumber_unit(),
    )
}

/// The integral of a site's spectrum over frequency, with unit.
pub(crate) fn site_energy(analysis: &Analysis) -> String {
    energy(analysis, analysis.axes.time_unit())
}

/// The integral of a time's spectrum over wavenumber, with unit.
pub(crate) fn time_energy(analysis: &Analysis) -> String {
    energy(analysis, analysis.axes.space_unit())
}

fn density(analysis: &Analysis, length: &str, bin: &str) -> String {
    let (square, bin) = (square(analysis), factor(bin));
    match analysis.conventions.scaling {
        Scaling::Energy => format!("energy spectral density ({square} {length} / {bin})"),
        Scaling::Density => format!("power spectral density ({square} / {bin})"),
        Scaling::Spectrum => format!("power spectrum ({square})"),
    }
}

fn energy(analysis: &Analysis, length: &str) -> String {
    let square = square(analysis);
    match analysis.conventions.scaling {
        Scaling::Energy => format!("energy ({square} {length})"),
        Scaling::Density | Scaling::Spectrum => format!("mean square ({square})"),
    }
}

fn square(analysis: &Analysis) -> String {
    match analysis.unit.as_deref() {
        Some(unit) => format!("{}²", factor(unit)),
        None => "field unit²".into(),
    }
}

/// A unit that can stand in a product: composed ones in brackets.
fn factor(unit: &str) -> String {
    if unit.contains(['/', ' ', '*', '·', '^']) {
        format!("({unit})")
    } else {
        unit.into()
    }
}
