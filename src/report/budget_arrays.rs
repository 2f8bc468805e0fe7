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

/// A label of a unit, as in the figures.
type Unit = fn(&BudgetUnits) -> String;

const TIMES: Unit = BudgetUnits::time;
const LENGTH: Unit = BudgetUnits::position;
const WAVENUMBER: Unit = BudgetUnits::wavenumber;
const FREQUENCY: Unit = BudgetUnits::frequency;
const ENERGY: Unit = |units| units.energy("");
const POWER: Unit = |units| units.power("");
const ENERGY_PER_FREQUENCY: Unit = |units| units.energy_per_frequency("");
const VELOCITY: Unit = |units| units.velocity("");
const FORCE: Unit = |units| units.force("");
const NUMBER: Unit = |_| String::new();

/// An array of a budget: its name, the arrays that hold the coordinates of its axes, its unit, and what it is.
type Entry = (&'static str, &'static [&'static str], Unit, &'static str);

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
    ("time", TIME, TIMES, "time"),
    ("position", SITE, LENGTH, "position of the sites"),
    ("contact_position", CONTACT, LENGTH, "position of the contacts"),
    ("wavenumber", &["wavenumber"], WAVENUMBER, "wavenumber k"),
    ("cell_wavenumber", &["cell_wavenumber"], WAVENUMBER, "wavenumber of the cell"),
    ("frequency", &["frequency"], FREQUENCY, "frequency"),
    ("scale", SCALE, LENGTH, "coarse-graining scale l"),
    ("energy", TIME, ENERGY, "energy of the chain"),
    ("kinetic_energy", TIME, ENERGY, "kinetic energy"),
    ("contact_energy", TIME, ENERGY, "energy of the contacts"),
    ("lost_energy", TIME, ENERGY, "energy lost since the first sample"),
    ("input_energy", TIME, ENERGY, "energy put in since the first sample"),
    ("left_behind", CONTACT, ENERGY, "energy left of each contact at the end"),
    ("wavenumber_centroid", TIME, WAVENUMBER, "centroid of E(k)"),
    ("low_wavenumber_energy", TIME, ENERGY, "energy of the low band"),
    ("band_edge_flux", TIME, POWER, "spectral flux through the band edge, towards high k"),
    ("optical_energy", TIME, ENERGY, "energy of the optical branch"),
    ("optical_transfer", TIME, POWER, "transfer from the acoustic to the optical branch"),
    ("low_frequency_passed", CONTACT, ENERGY, "energy passed in the low band of frequency"),
    ("high_frequency_passed", CONTACT, ENERGY, "energy passed in the high band of frequency"),
    ("scale_sigma", SCALE, LENGTH, "width of the filter"),
    ("scale_cutoff_wavenumber", SCALE, WAVENUMBER, "wavenumber at which the gain of the filter is 1/2"),
    ("integrated_scale_flux", SCALE, ENERGY, "flux to scales below l, summed over contacts and integrated over time"),
    ("site_energy", TIME_SITE, ENERGY, "energy of each site"),
    ("energy_flux", TIME_CONTACT, POWER, "energy flux J, towards +x"),
    ("energy_passed", TIME_CONTACT, ENERGY, "energy passed since the first sample, towards +x"),
    ("energy_lost", TIME_SITE, ENERGY, "energy lost at each site since the first sample"),
    ("energy_spectrum", TIME_WAVENUMBER, ENERGY, "energy spectrum E(k)"),
    ("transfer", TIME_WAVENUMBER, POWER, "transfer T(k)"),
    ("loss_spectrum", TIME_WAVENUMBER, POWER, "dissipation over k"),
    ("input_spectrum", TIME_WAVENUMBER, POWER, "input power over k"),
    ("spectral_flux", TIME_WAVENUMBER, POWER, "spectral flux \u{3a0}(k), towards high k"),
    ("integrated_spectral_flux", TIME_WAVENUMBER, ENERGY, "spectral flux integrated since the first sample"),
    ("acoustic_spectrum", TIME_CELL, ENERGY, "acoustic part of E(k)"),
    ("optical_spectrum", TIME_CELL, ENERGY, "optical part of E(k)"),
    ("mode_frequency", MODE, FREQUENCY, "frequency of the normal modes"),
    ("mode_energy", TIME_MODE, ENERGY, "energy of the normal modes of the linearized chain"),
    ("modes_energy", TIME, ENERGY, "energy of all normal modes"),
    ("mode_entropy", TIME, NUMBER, "spectral entropy of the energy by mode"),
    ("normalized_mode_entropy", TIME, NUMBER, "(ln N - S) / (ln N - S(0)): 1 at the start, 0 where all modes have as much"),
    ("power_flow", FREQUENCY_CONTACT, ENERGY_PER_FREQUENCY, "power flow P(f)"),
    ("cumulative_power_flow", FREQUENCY_CONTACT, ENERGY, "energy passed up to each frequency"),
    ("scale_flux", TIME_CONTACT, POWER, "flux to scales below that of the map"),
    ("scale_flux_in_time", &["time", "scale"], POWER, "flux to scales below l, summed over contacts"),
    ("velocity", TIME_SITE, VELOCITY, "velocity"),
    ("displacement", TIME_SITE, LENGTH, "displacement"),
    ("overlap", TIME_CONTACT, LENGTH, "overlap of the contacts"),
    ("force", TIME_CONTACT, FORCE, "force of the contacts"),
];

/// What an array is: its entry, and whether it holds the standard errors of that.
fn known(name: &str) -> Option<(&'static Entry, bool)> {
    let find = |name: &str| ENTRIES.iter().find(|(known, ..)| *known == name);
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
    let Some(((_, axes, unit, about), is_error)) = known(name) else {
        return;
    };
    if values.is_empty() && !shape.is_empty() {
        return;
    }
    let axes = axes.iter().zip(shape);
    sheet.variables.push(Variable {
        name: name.into(),
        dimensions: axes.map(|(axis, len)| ((*axis).into(), *len)).collect(),
        unit: unit::split(&unit(units)).1.to_owned(),
        about: match is_error {
            true => format!("standard error of: {about}"),
            false => (*about).into(),
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
        let mut each = |name: &'static str, value: fn(&ScaleOf) -> f64| {
            line(name, found.scales.iter().map(value).collect());
        };
        each("scale", |scale| scale.scale);
        each("scale_sigma", |scale| scale.sigma.unwrap_or(f64::NAN));
        each("scale_cutoff_wavenumber", |scale| scale.cutoff_wavenumber);
    }
    if let Some(found) = &budget.modes {
        let frequency = found.frequency.iter().map(|w| w / (2.0 * PI));
        line("mode_frequency", frequency.collect());
        for (name, values) in [
            ("modes_energy", &found.energy),
            ("mode_entropy", &found.entropy),
            ("normalized_mode_entropy", &found.normalized_entropy),
        ] {
            line(name, values.as_slice().into());
        }
    }
    for (name, ..) in ENTRIES.iter().filter(|(_, axes, ..)| axes.len() > 1) {
        add(sheet, &budget.units, name, &[], &[][..]);
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
        let unit = |name: &str| {
            let ((_, _, unit, _), _) = known(name).unwrap();
            unit::split(&unit(&BudgetUnits::si())).1.to_owned()
        };
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
