//! The small arrays of the file of a budget, those of a measured field, and what all of them are.

use std::f64::consts::PI;

use ndarray::Array2;
use serde_json::Value;

use super::arrays::{describe_file, text_attributes};
use super::{ArrayLabels, LabelledArrays};
use crate::arrays::{Arrays, LargeArray};
use crate::budget::measured::MeasuredMotion;
use crate::budget::{Budget, BudgetUnits, ScaleOf};
use crate::error::Result;
use crate::unit;

/// What the numbers of an array are.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Time,
    Length,
    Wavenumber,
    Frequency,
    Energy,
    Power,
    EnergyPerFrequency,
    Velocity,
    Force,
    Number,
}

impl Kind {
    /// As in the figures; empty for none.
    fn unit(self, units: &BudgetUnits) -> String {
        let label = match self {
            Kind::Time => units.time(),
            Kind::Length => units.position(),
            Kind::Wavenumber => units.wavenumber(),
            Kind::Frequency => units.frequency(),
            Kind::Energy => units.energy(""),
            Kind::Power => units.power(""),
            Kind::EnergyPerFrequency => units.energy_per_frequency(""),
            Kind::Velocity => units.velocity(""),
            Kind::Force => units.force(""),
            Kind::Number => String::new(),
        };
        unit::split(&label).1.to_owned()
    }
}

/// An array of a budget.
struct Entry {
    name: &'static str,
    /// The arrays that hold the coordinates of its axes.
    axes: &'static [&'static str],
    kind: Kind,
    about: &'static str,
}

const fn entry(
    name: &'static str,
    axes: &'static [&'static str],
    kind: Kind,
    about: &'static str,
) -> Entry {
    Entry {
        name,
        axes,
        kind,
        about,
    }
}

const TIME: &[&str] = &["time"];
const SITE: &[&str] = &["position"];
const CONTACT: &[&str] = &["contact_position"];
const SCALE: &[&str] = &["scale"];
const TIME_SITE: &[&str] = &["time", "position"];
const TIME_CONTACT: &[&str] = &["time", "contact_position"];
const TIME_WAVENUMBER: &[&str] = &["time", "wavenumber"];
const MODE: &[&str] = &["mode_frequency"];
const TIME_MODE: &[&str] = &["time", "mode_frequency"];
const TIME_CELL: &[&str] = &["time", "cell_wavenumber"];
const FREQUENCY_CONTACT: &[&str] = &["frequency", "contact_position"];

/// All arrays of a budget, the large ones too.
#[rustfmt::skip]
const ENTRIES: [Entry; 48] = [
    entry("time", TIME, Kind::Time, "time"),
    entry("position", SITE, Kind::Length, "position of the sites"),
    entry("contact_position", CONTACT, Kind::Length, "position of the contacts"),
    entry("wavenumber", &["wavenumber"], Kind::Wavenumber, "wavenumber k"),
    entry("cell_wavenumber", &["cell_wavenumber"], Kind::Wavenumber, "wavenumber of the cell"),
    entry("frequency", &["frequency"], Kind::Frequency, "frequency"),
    entry("scale", SCALE, Kind::Length, "coarse-graining scale l"),
    entry("energy", TIME, Kind::Energy, "energy of the chain"),
    entry("kinetic_energy", TIME, Kind::Energy, "kinetic energy"),
    entry("contact_energy", TIME, Kind::Energy, "energy of the contacts"),
    entry("lost_energy", TIME, Kind::Energy, "energy lost since the first sample"),
    entry("input_energy", TIME, Kind::Energy, "energy put in since the first sample"),
    entry("left_behind", CONTACT, Kind::Energy, "energy left of each contact at the end"),
    entry("wavenumber_centroid", TIME, Kind::Wavenumber, "centroid of E(k)"),
    entry("low_wavenumber_energy", TIME, Kind::Energy, "energy of the low band"),
    entry("band_edge_flux", TIME, Kind::Power, "spectral flux through the band edge, towards high k"),
    entry("optical_energy", TIME, Kind::Energy, "energy of the optical branch"),
    entry("optical_transfer", TIME, Kind::Power, "transfer from the acoustic to the optical branch"),
    entry("low_frequency_passed", CONTACT, Kind::Energy, "energy passed in the low band of frequency"),
    entry("high_frequency_passed", CONTACT, Kind::Energy, "energy passed in the high band of frequency"),
    entry("scale_sigma", SCALE, Kind::Length, "width of the filter"),
    entry("scale_cutoff_wavenumber", SCALE, Kind::Wavenumber, "wavenumber at which the gain of the filter is 1/2"),
    entry("integrated_scale_flux", SCALE, Kind::Energy, "flux to scales below l, summed over contacts and integrated over time"),
    entry("site_energy", TIME_SITE, Kind::Energy, "energy of each site"),
    entry("energy_flux", TIME_CONTACT, Kind::Power, "energy flux J, towards +x"),
    entry("energy_passed", TIME_CONTACT, Kind::Energy, "energy passed since the first sample, towards +x"),
    entry("energy_lost", TIME_SITE, Kind::Energy, "energy lost at each site since the first sample"),
    entry("energy_spectrum", TIME_WAVENUMBER, Kind::Energy, "energy spectrum E(k)"),
    entry("transfer", TIME_WAVENUMBER, Kind::Power, "transfer T(k)"),
    entry("loss_spectrum", TIME_WAVENUMBER, Kind::Power, "dissipation over k"),
    entry("input_spectrum", TIME_WAVENUMBER, Kind::Power, "input power over k"),
    entry("spectral_flux", TIME_WAVENUMBER, Kind::Power, "spectral flux \u{3a0}(k), towards high k"),
    entry("integrated_spectral_flux", TIME_WAVENUMBER, Kind::Energy, "spectral flux integrated since the first sample"),
    entry("acoustic_spectrum", TIME_CELL, Kind::Energy, "acoustic part of E(k)"),
    entry("optical_spectrum", TIME_CELL, Kind::Energy, "optical part of E(k)"),
    entry("mode_frequency", MODE, Kind::Frequency, "frequency of the normal modes"),
    entry("mode_energy", TIME_MODE, Kind::Energy, "energy of the normal modes of the linearized chain"),
    entry("modes_energy", TIME, Kind::Energy, "energy of all normal modes"),
    entry("mode_entropy", TIME, Kind::Number, "spectral entropy of the energy by mode"),
    entry("normalized_mode_entropy", TIME, Kind::Number, "(ln N - S) / (ln N - S(0)): 1 at the start, 0 where all modes have as much"),
    entry("power_flow", FREQUENCY_CONTACT, Kind::EnergyPerFrequency, "power flow P(f)"),
    entry("cumulative_power_flow", FREQUENCY_CONTACT, Kind::Energy, "energy passed up to each frequency"),
    entry("scale_flux", TIME_CONTACT, Kind::Power, "flux to scales below that of the map"),
    entry("scale_flux_in_time", &["time", "scale"], Kind::Power, "flux to scales below l, summed over contacts"),
    entry("velocity", TIME_SITE, Kind::Velocity, "velocity"),
    entry("displacement", TIME_SITE, Kind::Length, "displacement"),
    entry("overlap", TIME_CONTACT, Kind::Length, "overlap of the contacts"),
    entry("force", TIME_CONTACT, Kind::Force, "force of the contacts"),
];

/// Those that come in blocks.
const LARGE: [LargeArray; 17] = [
    LargeArray::SITE_ENERGY,
    LargeArray::ENERGY_FLUX,
    LargeArray::ENERGY_PASSED,
    LargeArray::ENERGY_LOST,
    LargeArray::ENERGY_SPECTRUM,
    LargeArray::TRANSFER,
    LargeArray::LOSS_SPECTRUM,
    LargeArray::INPUT_SPECTRUM,
    LargeArray::SPECTRAL_FLUX,
    LargeArray::INTEGRATED_SPECTRAL_FLUX,
    LargeArray::ACOUSTIC_SPECTRUM,
    LargeArray::OPTICAL_SPECTRUM,
    LargeArray::MODE_ENERGY,
    LargeArray::POWER_FLOW,
    LargeArray::CUMULATIVE_POWER_FLOW,
    LargeArray::SCALE_FLUX,
    LargeArray::SCALE_FLUX_IN_TIME,
];

/// What an array is: its entry, and whether it holds the standard errors of that.
fn known(name: &str) -> Option<(&'static Entry, bool)> {
    let find = |name: &str| ENTRIES.iter().find(|entry| entry.name == name);
    let of_errors = || Some((find(name.strip_suffix("_error")?)?, true));
    find(name).map(|entry| (entry, false)).or_else(of_errors)
}

fn about(entry: &Entry, is_error: bool) -> String {
    match is_error {
        true => format!("standard error of: {}", entry.about),
        false => entry.about.to_owned(),
    }
}

/// Adds an array of a budget under its name, with the axes and the unit that it has.
fn add(
    file: &dyn LabelledArrays,
    units: &BudgetUnits,
    name: &str,
    shape: &[usize],
    values: &[f64],
) -> Result<()> {
    let (unit, about, axes) = match known(name) {
        Some((entry, is_error)) => (
            entry.kind.unit(units),
            about(entry, is_error),
            entry.axes.to_vec(),
        ),
        None => (String::new(), String::new(), vec!["row", "column"]),
    };
    let axes: Vec<(&str, usize)> = axes.into_iter().zip(shape.iter().copied()).collect();
    let labels = ArrayLabels {
        name,
        axes: &axes,
        unit: &unit,
        about: &about,
    };
    file.append(&labels, values)
}

/// Adds the arrays of one dimension, under the names of the manual.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_budget_arrays(budget: &Budget, file: &dyn LabelledArrays) -> Result<()> {
    let line = |name: &str, values: &[f64]| match values.is_empty() {
        true => Ok(()),
        false => add(file, &budget.units, name, &[values.len()], values),
    };
    let places = |n: usize, first: f64| -> Vec<f64> {
        (0..n).map(|j| budget.pitch * (j as f64 + first)).collect()
    };
    line("time", &budget.time)?;
    line("position", &places(budget.n_sites, 0.0))?;
    line("contact_position", &places(budget.n_contacts, 0.5))?;
    line("input_energy", &budget.input)?;
    for (name, values) in &budget.curves() {
        // Others are in the large arrays, or in the numbers.
        if known(name).is_some() {
            line(name, values)?;
            if let Some(errors) = &budget.errors {
                line(&format!("{name}_error"), &errors[name])?;
            }
        }
    }
    if let Some(found) = &budget.wavenumber {
        line("wavenumber", &found.wavenumber)?;
        if let Some(branches) = &found.branches {
            line("cell_wavenumber", &branches.wavenumber)?;
        }
    }
    if let Some(flow) = &budget.frequency {
        line("frequency", &flow.frequency)?;
    }
    if let Some(found) = &budget.scales {
        let of =
            |value: fn(&ScaleOf) -> f64| -> Vec<f64> { found.scales.iter().map(value).collect() };
        line("scale", &of(|scale| scale.scale))?;
        line("scale_sigma", &of(|scale| scale.sigma.unwrap_or(f64::NAN)))?;
        line(
            "scale_cutoff_wavenumber",
            &of(|scale| scale.cutoff_wavenumber),
        )?;
    }
    if let Some(found) = &budget.modes {
        let cycles = found.frequency.iter().map(|w| w / (2.0 * PI));
        line("mode_frequency", &cycles.collect::<Vec<f64>>())?;
        line("modes_energy", &found.energy)?;
        line("mode_entropy", &found.entropy)?;
        line("normalized_mode_entropy", &found.normalized_entropy)?;
    }
    Ok(())
}

/// Adds what a measured motion holds beside its budgets, with standard errors, and those of the
/// arrays of its budgets: `transfer_error` of `transfer`.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_measured_arrays(
    measured: &MeasuredMotion,
    of_budgets: &Arrays,
    units: &BudgetUnits,
    file: &dyn LabelledArrays,
) -> Result<()> {
    let errors = &measured.errors;
    let named = of_budgets.iter();
    let named: Vec<(String, &Array2<f64>)> = named
        .map(|(array, errors)| (format!("{}_error", array.name()), errors))
        .collect();
    let named = named.iter().map(|(name, errors)| (name.as_str(), *errors));
    for (name, array) in [
        ("velocity", &measured.values.velocity),
        ("velocity_error", &errors.velocity),
        ("displacement", &measured.displacement),
        ("overlap", &measured.values.overlap),
        ("overlap_error", &errors.overlap),
        ("force", &measured.values.force),
        ("force_error", &errors.force),
        ("energy_flux_error", &errors.flux),
        ("energy_passed_error", &errors.passed),
        ("energy_error", &errors.energy),
    ]
    .into_iter()
    .chain(named)
    {
        let (rows, columns) = array.dim();
        if columns > 0 {
            let values: Vec<f64> = array.iter().copied().collect();
            add(file, units, name, &[rows, columns], &values)?;
        }
    }
    Ok(())
}

/// Adds units and names to the arrays that the [`Sink`] has taken, and the numbers and texts of the summary to
/// the file: provenance, conventions, energies, bands, residuals. What `summary.json` nests is a text in JSON.
///
/// [`Sink`]: crate::arrays::Sink
pub fn describe_budget(budget: &Budget, summary: &Value, file: &dyn LabelledArrays) {
    for array in LARGE {
        if let Some((entry, is_error)) = known(array.name()) {
            let unit = entry.kind.unit(&budget.units);
            let attributes = text_attributes(&unit, &about(entry, is_error));
            file.describe(array.name(), attributes);
        }
    }
    let parts = [
        ("provenance", ""),
        ("conventions", "convention_"),
        ("energy", "energy_"),
        ("wavenumber", "wavenumber_"),
        ("frequency", "frequency_"),
        ("modes", "modes_"),
        ("closure", "closure_"),
    ];
    describe_file(summary, &parts, file);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_arrays_have_the_axes_that_are_listed() {
        for array in LARGE {
            let (entry, _) = known(array.name()).unwrap_or_else(|| panic!("{}", array.name()));
            assert_eq!(entry.axes, array.axes(), "{}", array.name());
        }
        let unit = |name: &str| known(name).unwrap().0.kind.unit(&BudgetUnits::si());
        assert_eq!(unit("transfer_error"), "J/s");
        assert_eq!(unit("force"), "N");
        assert_eq!(unit("velocity_error"), "m/s");
        assert_eq!(unit("power_flow"), "J/Hz");
    }
}
