//! The small arrays of `budget.npz`, and those of a measured field.

use ndarray::Array2;

use super::NamedArrays;
use crate::arrays::Arrays;
use crate::budget::measured::MeasuredMotion;
use crate::budget::{Budget, ScaleOf};
use crate::error::Result;

/// Appends the arrays of one dimension, under the names of the manual.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_budget_arrays(budget: &Budget, archive: &dyn NamedArrays) -> Result<()> {
    let line = |name: &str, values: &[f64]| match values.is_empty() {
        true => Ok(()),
        false => archive.append(name, &[values.len()], values),
    };
    let places = |n: usize, first: f64| -> Vec<f64> {
        (0..n).map(|j| budget.pitch * (j as f64 + first)).collect()
    };
    line("time", &budget.time)?;
    line("position", &places(budget.n_sites, 0.0))?;
    line("contact_position", &places(budget.n_contacts, 0.5))?;
    line("kinetic_energy", &budget.kinetic)?;
    line("contact_energy", &budget.contact)?;
    line("lost_energy", &budget.lost)?;
    line("input_energy", &budget.input)?;
    line("left_behind", &budget.left_behind)?;
    if let Some(found) = &budget.wavenumber {
        line("wavenumber", &found.wavenumber)?;
        line("wavenumber_centroid", &found.centroid)?;
        line("low_wavenumber_energy", &found.low_energy)?;
        line("band_edge_flux", &found.edge_flux)?;
        if let Some(branches) = &found.branches {
            line("cell_wavenumber", &branches.wavenumber)?;
            line("optical_energy", &branches.optical_energy)?;
            line("optical_transfer", &branches.optical_transfer)?;
        }
    }
    if let Some(flow) = &budget.frequency {
        line("frequency", &flow.frequency)?;
        line("low_frequency_passed", &flow.low)?;
        line("high_frequency_passed", &flow.high)?;
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
        line("integrated_scale_flux", &found.integrated_flux)?;
    }
    let Some(errors) = &budget.errors else {
        return Ok(());
    };
    for (name, values) in [
        ("kinetic_energy_error", &errors.kinetic),
        ("contact_energy_error", &errors.contact),
        ("lost_energy_error", &errors.lost),
        ("left_behind_error", &errors.left_behind),
        ("wavenumber_centroid_error", &errors.centroid),
        ("low_wavenumber_energy_error", &errors.low_energy),
        ("band_edge_flux_error", &errors.edge_flux),
        ("optical_energy_error", &errors.optical_energy),
        ("optical_transfer_error", &errors.optical_transfer),
        ("low_frequency_passed_error", &errors.low_frequency),
        ("high_frequency_passed_error", &errors.high_frequency),
        ("integrated_scale_flux_error", &errors.integrated_scale_flux),
    ] {
        line(name, values)?;
    }
    Ok(())
}

/// Appends what a measured motion holds beside its budgets, with standard errors, and those of the
/// arrays of its budgets: `transfer_error` of `transfer`.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_measured_arrays(
    measured: &MeasuredMotion,
    of_budgets: &Arrays,
    archive: &dyn NamedArrays,
) -> Result<()> {
    let errors = &measured.errors;
    let named = of_budgets.iter();
    let named: Vec<(String, &Array2<f64>)> = named
        .map(|(array, errors)| (format!("{}_error", array.name()), errors))
        .collect();
    let named = named.iter().map(|(name, errors)| (name.as_str(), *errors));
    for (name, array) in [
        ("velocity", &measured.velocity),
        ("velocity_error", &errors.velocity),
        ("displacement", &measured.displacement),
        ("overlap", &measured.overlap),
        ("overlap_error", &errors.overlap),
        ("force", &measured.force),
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
            archive.append(name, &[rows, columns], &values)?;
        }
    }
    Ok(())
}
