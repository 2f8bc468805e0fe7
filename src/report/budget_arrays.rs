//! The small arrays of the file of a budget, those of a measured field, and what all of them are.

use std::borrow::Cow;
use std::f64::consts::PI;

use super::ArrayFile;
use crate::arrays::Arrays;
use crate::budget::measured::{MeasuredMotion, MeasuredReport};
use crate::budget::{Budget, BudgetUnits, ScaleOf};
use crate::error::Result;
use crate::sheet::{Describe, FigureLayout, Sheet, Variable, flat};
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

/// What an array is: its entry, and whether it holds the standard errors of that.
fn known(name: &str) -> Option<(&'static Entry, bool)> {
    let find = |name: &str| ENTRIES.iter().find(|entry| entry.name == name);
    let of_errors = || Some((find(name.strip_suffix("_error")?)?, true));
    find(name).map(|entry| (entry, false)).or_else(of_errors)
}

/// Adds an array of a budget under its name, with the axes and the unit that it has; not one that is not listed, which is
/// in the large arrays or in the numbers, or has no values. Without a shape its samples have come in blocks.
fn add<'a>(
    sheet: &mut Sheet<'a>,
    units: &BudgetUnits,
    name: &str,
    shape: &[usize],
    values: impl Into<Cow<'a, [f64]>>,
) {
    let values = values.into();
    let Some((entry, is_error)) = known(name) else {
        return;
    };
    if values.is_empty() && !shape.is_empty() {
        return;
    }
    let axes = entry.axes.iter().zip(shape);
    sheet.variables.push(Variable {
        name: name.into(),
        dimensions: axes.map(|(axis, len)| ((*axis).into(), *len)).collect(),
        unit: entry.kind.unit(units),
        about: match is_error {
            true => format!("standard error of: {}", entry.about),
            false => entry.about.into(),
        },
        values,
    });
}

/// A budget with what is known of its measurement, described with its arrays.
#[derive(Debug, Clone)]
pub struct DescribedBudget {
    pub budget: Budget,
    pub report: Option<MeasuredReport>,
}

impl Describe for DescribedBudget {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.budget.describe(self.report.as_ref());
        sheet.attributes = &ATTRIBUTES;
        add_arrays(&self.budget, &mut sheet);
        sheet
    }

    fn figures(&self) -> Vec<FigureLayout> {
        self.budget.figures()
    }
}

/// Parts of the numbers that are attributes of the file, and what their names begin with there.
const ATTRIBUTES: [(&str, &str); 7] = [
    ("provenance", ""),
    ("conventions", "convention_"),
    ("energy", "energy_"),
    ("wavenumber", "wavenumber_"),
    ("frequency", "frequency_"),
    ("modes", "modes_"),
    ("closure", "closure_"),
];

/// Adds the arrays of one dimension, under the names of the manual, and what the large ones are.
fn add_arrays<'a>(budget: &'a Budget, sheet: &mut Sheet<'a>) {
    let mut line = |name: &str, values: Cow<'a, [f64]>| {
        add(sheet, &budget.units, name, &[values.len()], values);
    };
    let places = |n: usize, first: f64| -> Cow<'a, [f64]> {
        (0..n).map(|j| budget.pitch * (j as f64 + first)).collect()
    };
    line("time", budget.time.as_slice().into());
    line("position", places(budget.n_sites, 0.0));
    line("contact_position", places(budget.n_contacts, 0.5));
    line("input_energy", budget.input.as_slice().into());
    for (name, values) in budget.curves() {
        line(name, values.into());
        if let Some(errors) = budget.errors.as_ref().and_then(|all| all.get(name)) {
            line(&format!("{name}_error"), errors.into());
        }
    }
    if let Some(found) = &budget.wavenumber {
        line("wavenumber", found.wavenumber.as_slice().into());
        if let Some(branches) = &found.branches {
            line("cell_wavenumber", branches.wavenumber.as_slice().into());
        }
    }
    if let Some(flow) = &budget.frequency {
        line("frequency", flow.frequency.as_slice().into());
    }
    if let Some(found) = &budget.scales {
        let of = |value: fn(&ScaleOf) -> f64| -> Cow<'a, [f64]> {
            found.scales.iter().map(value).collect()
        };
        line("scale", of(|scale| scale.scale));
        line("scale_sigma", of(|scale| scale.sigma.unwrap_or(f64::NAN)));
        line(
            "scale_cutoff_wavenumber",
            of(|scale| scale.cutoff_wavenumber),
        );
    }
    if let Some(found) = &budget.modes {
        line(
            "mode_frequency",
            found.frequency.iter().map(|w| w / (2.0 * PI)).collect(),
        );
        line("modes_energy", found.energy.as_slice().into());
        line("mode_entropy", found.entropy.as_slice().into());
        line(
            "normalized_mode_entropy",
            found.normalized_entropy.as_slice().into(),
        );
    }
    for entry in ENTRIES.iter().filter(|entry| entry.axes.len() > 1) {
        add(sheet, &budget.units, entry.name, &[], &[][..]);
    }
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
    file: &dyn ArrayFile,
) -> Result<()> {
    let errors = &measured.errors;
    let own = [
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
    ];
    let own = own
        .into_iter()
        .map(|(name, array)| (name.to_owned(), array));
    let of_budgets = of_budgets.iter();
    let of_budgets = of_budgets.map(|(array, errors)| (format!("{}_error", array.name()), errors));
    let mut sheet = Sheet::default();
    for (name, array) in own.chain(of_budgets) {
        add(&mut sheet, units, &name, array.shape(), flat(array));
    }
    sheet.write_to(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_the_unit_of_what_they_are_of() {
        let unit = |name: &str| known(name).unwrap().0.kind.unit(&BudgetUnits::si());
        for (name, expected) in [
            ("transfer_error", "J/s"),
            ("force", "N"),
            ("velocity_error", "m/s"),
            ("power_flow", "J/Hz"),
        ] {
            assert_eq!(unit(name), expected);
        }
    }
}
