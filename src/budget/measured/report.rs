//! What a measurement yields beside its arrays.

use ndarray::Array2;

use super::derive::{Derived, MotionArrays};
use super::momentum::Momentum;
use super::noise::SiteNoise;
use super::repetitions::Measurement;
use crate::error::{Error, Fault, Result};

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
/// [`Error::Unresolved`] where nothing is left of the energy or of all forces.
pub(super) fn of(
    derived: &Derived,
    errors: &MotionArrays,
    measurement: &Measurement,
    momentum: Momentum,
    given: Estimate,
) -> Result<MeasuredReport> {
    let (values, missing) = (&derived.values, &measurement.missing);
    let last = values.velocity.nrows() - 1;
    let largest = |array: &Array2<f64>, j: usize| {
        let column = array.column(j);
        let is_larger = |i: usize, than: usize| column[i].abs() > column[than].abs();
        (0..column.len()).fold(0, |best, i| if is_larger(i, best) { i } else { best })
    };
    let estimate = |values: &Array2<f64>, errors: &Array2<f64>, at: (usize, usize)| Estimate {
        value: values[at],
        error: errors[at],
    };
    let strongest_at = |j: usize| (largest(&values.force, j), j);
    let contacts = (0..values.force.ncols()).map(|j| ContactEstimate {
        force: estimate(&values.force, &errors.force, strongest_at(j)),
        passed: estimate(&values.passed, &errors.passed, (last, j)),
    });
    let contacts: Vec<ContactEstimate> = contacts.collect();
    // Of the whole record: at its end, too, energy is to be left.
    let worst = Estimate {
        value: values.energy[[largest(&values.energy, 0), 0]],
        error: errors.energy[[largest(&errors.energy, 0), 0]],
    };
    let forces = contacts.iter().map(|contact| contact.force);
    let share = |e: &Estimate| e.value.abs() / e.error;
    let reached = forces.filter(|force| force.value != 0.0);
    let strongest = reached.max_by(|a, b| share(a).total_cmp(&share(b)));
    let energies = [worst, given].map(|it| ("the total energy", Some(it)));
    let force = ("the force in every contact, at best", strongest);
    for (what, found) in energies.into_iter().chain([force]) {
        if !found.is_some_and(|found| found.is_resolved()) {
            let [signal, error] = found.map_or([0.0; 2], |found| [found.value.abs(), found.error]);
            let twice = "expected more than twice its standard error";
            let said = format!("{what}: {twice} {error:.3e}, found {signal:.3e}");
            let advice = "average repeated records, record longer before the impact, or state which channels are too \
                noisy to use as missing; an offset of the velocity grows with time, so a shorter record may do";
            return Err(Error::Unresolved(Fault::new(said, advice)));
        }
    }
    let missing = (0..missing.len()).filter(|j| missing[*j]).map(|site| {
        let error = errors.velocity.column(site);
        MissingSite {
            site,
            velocity: Estimate {
                value: values.velocity[[largest(&values.velocity, site), site]],
                error: (error.dot(&error) / error.len() as f64).sqrt(),
            },
        }
    });
    let mut report = MeasuredReport {
        noise_correlation: measurement.channels.correlation,
        sites: measurement.channels.sites.clone(),
        missing: missing.collect(),
        contacts,
        energy: given,
        momentum,
        warnings: Vec::new(),
    };
    report.warnings = warnings_of(&report);
    Ok(report)
}

/// What a measured field, or the chain stated for it, lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Lack {
    /// Sites whose momentum does not balance: forces leave more of it unexplained than noise explains.
    MomentumOpen,
    /// All coefficients together contradict the momenta.
    Coefficients,
    /// Contacts whose coefficient the momenta contradict.
    Coefficient,
    /// Contacts whose force is not twice its error.
    BelowNoise,
    /// Sites whose motion follows from their neighbours.
    Missing,
    /// Sites with no quiet part of their own, or too short a one.
    NoQuietPart,
    /// Noise that is correlated from sample to sample, at all sites.
    CorrelatedNoise,
}

/// A finding that its user should know; its numbers are those of the [`MeasuredReport`].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredWarning {
    pub code: Lack,
    /// The sites or contacts it is about.
    pub at: Vec<usize>,
}

/// Those of a report.
fn warnings_of(report: &MeasuredReport) -> Vec<MeasuredWarning> {
    let (momentum, contacts) = (&report.momentum, &report.contacts);
    let (n, m) = (report.sites.len(), contacts.len());
    let is_missing = |site: usize| report.missing.iter().any(|missing| missing.site == site);
    let is_borrowed = |site: usize| report.sites[site].borrowed && !is_missing(site);
    let is_off = |i: usize| momentum.factors[i].is_some_and(|factor| factor.is_off());
    let is_drowned = |i: usize| {
        let force = contacts[i].force;
        force.value != 0.0 && !force.is_resolved()
    };
    type IsOne<'a> = &'a dyn Fn(usize) -> bool;
    let all: [(Lack, usize, IsOne); 7] = [
        (Lack::MomentumOpen, n, &|j| !momentum.sites[j].is_closed()),
        (Lack::Coefficients, m, &|_| momentum.common.is_off()),
        (Lack::Coefficient, m, &is_off),
        (Lack::BelowNoise, m, &is_drowned),
        (Lack::Missing, n, &is_missing),
        (Lack::NoQuietPart, n, &is_borrowed),
        (Lack::CorrelatedNoise, n, &|_| {
            report.noise_correlation > 1.0
        }),
    ];
    let found = all.into_iter().map(|(code, count, is_one)| {
        let at = (0..count).filter(|i| is_one(*i)).collect();
        MeasuredWarning { code, at }
    });
    found.filter(|found| !found.at.is_empty()).collect()
}

impl MeasuredWarning {
    /// One sentence, and what to do about it.
    pub fn words(&self) -> (String, &'static str) {
        const CHAIN: &str = "check masses, contact law and coefficients of the chain and the gains of the channels, or \
                             state how uncertain they are, and that the contacts just touched at the start";
        let (said, advice) = match self.code {
            Lack::MomentumOpen => ("forces do not explain the momentum of site", CHAIN),
            Lack::Coefficients | Lack::Coefficient => {
                ("the momenta contradict the coefficient of contact", CHAIN)
            }
            Lack::BelowNoise => (
                "the force is less than twice its error in contact",
                "leave these contacts out of what is concluded",
            ),
            Lack::Missing => (
                "the motion follows from the neighbours at site",
                "none is needed where the stated error is small enough",
            ),
            Lack::NoQuietPart => (
                "noise and drift are taken to be those of the other channels at site",
                "record some time before the impact, and state the sample at which it begins",
            ),
            Lack::CorrelatedNoise => (
                "noise is correlated from sample to sample, which errors allow for, at site",
                "look for hum or a filter in the measuring chain",
            ),
        };
        const SHOWN: usize = 8;
        let shown = self.at.iter().take(SHOWN).map(usize::to_string);
        let plural = if self.at.len() == 1 { "" } else { "s" };
        let more = match self.at.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let places = shown.collect::<Vec<String>>().join(", ");
        (format!("{said}{plural} {places}{more}"), advice)
    }
}
