//! What a measurement yields beside its arrays.

use ndarray::Array2;

use super::derive::Derived;
use super::estimate::Errors;
use super::momentum::Momentum;
use super::noise::{Channels, SiteNoise};
use super::warning::MeasuredWarning;
use crate::error::{Error, Result};

/// What a measurement yields beside its arrays.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredReport {
    /// Correlation time of the noise in samples; 1 if white.
    pub noise_correlation: f64,
    pub sites: Vec<SiteNoise>,
    pub missing: Vec<MissingSite>,
    pub contacts: Vec<ContactEstimate>,
    /// The energy that the chain was given: the median over the record of total energy and losses,
    /// less the bias that noise gives them; see [`super`].
    pub energy: Estimate,
    pub momentum: Momentum,
    pub warnings: Vec<MeasuredWarning>,
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    pub value: f64,
    pub error: f64,
}

impl Estimate {
    /// Whether the value is more than twice its error. What noise alone adds to a force or an energy
    /// is about its own error, since neither is linear.
    pub fn is_resolved(&self) -> bool {
        self.value.abs() > 2.0 * self.error
    }
}

/// A site whose motion follows from its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct MissingSite {
    pub site: usize,
    /// Its largest velocity, and the root mean square of the standard error over time.
    pub velocity: Estimate,
}

/// Results for a contact.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ContactEstimate {
    /// Largest force, with its error at that time.
    pub force: Estimate,
    /// Energy passed by the end.
    pub passed: Estimate,
}

/// # Errors
/// [`Error::BelowNoise`] where nothing is left of the energy or of all forces.
pub(super) fn of(
    derived: &Derived,
    errors: &Errors,
    missing: &[bool],
    channels: &Channels,
    momentum: Momentum,
    given: Estimate,
) -> Result<MeasuredReport> {
    let last = derived.velocity.nrows() - 1;
    let largest = |array: &Array2<f64>, j: usize| {
        let column = array.column(j);
        let better = |best, i: usize| {
            if column[i].abs() > column[best].abs() {
                i
            } else {
                best
            }
        };
        (0..column.len()).fold(0, better)
    };
    let estimate = |values: &Array2<f64>, errors: &Array2<f64>, at: (usize, usize)| Estimate {
        value: values[at],
        error: errors[at],
    };
    let contacts = (0..derived.force.ncols()).map(|j| ContactEstimate {
        force: estimate(
            &derived.force,
            &errors.force,
            (largest(&derived.force, j), j),
        ),
        passed: estimate(&derived.passed, &errors.passed, (last, j)),
    });
    let contacts: Vec<ContactEstimate> = contacts.collect();
    // Of the whole record: at its end, too, energy is to be left.
    let worst = Estimate {
        value: derived.energy[[largest(&derived.energy, 0), 0]],
        error: errors.energy[[largest(&errors.energy, 0), 0]],
    };
    let forces = contacts.iter().map(|contact| contact.force);
    let share = |e: &Estimate| e.value.abs() / e.error;
    let reached = forces.filter(|force| force.value != 0.0);
    let strongest = reached.max_by(|a, b| share(a).total_cmp(&share(b)));
    for (what, found) in [
        ("the total energy", Some(worst)),
        ("the total energy", Some(given)),
        ("the force in every contact, at best", strongest),
    ] {
        if !found.is_some_and(|found| found.is_resolved()) {
            return Err(Error::BelowNoise {
                what: what.into(),
                signal: found.map_or(0.0, |found| found.value.abs()),
                error: found.map_or(0.0, |found| found.error),
            });
        }
    }
    let missing = (0..missing.len()).filter(|j| missing[*j]).map(|site| {
        let error = errors.velocity.column(site);
        MissingSite {
            site,
            velocity: Estimate {
                value: derived.velocity[[largest(&derived.velocity, site), site]],
                error: (error.dot(&error) / error.len() as f64).sqrt(),
            },
        }
    });
    let mut report = MeasuredReport {
        noise_correlation: channels.correlation,
        sites: channels.sites.clone(),
        missing: missing.collect(),
        contacts,
        energy: given,
        momentum,
        warnings: Vec::new(),
    };
    report.warnings = super::warning::find(&report);
    Ok(report)
}
