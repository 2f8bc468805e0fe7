//! Warnings about a measurement.

use super::{ContactEstimate, Factor, MissingSite, Momentum, SiteNoise};

/// A finding that its user should know.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case", tag = "code")]
#[non_exhaustive]
pub enum MeasuredWarning {
    /// Momenta do not balance: the site at which the residual is largest against what noise
    /// explains.
    MomentumOpen {
        site: usize,
        residual: f64,
        expected: f64,
    },
    /// A coefficient that the momenta contradict.
    Coefficient { contact: usize, factor: Factor },
    /// All coefficients together, likewise.
    Coefficients { factor: Factor },
    /// Contacts whose force is not twice its error.
    BelowNoise { contacts: Vec<usize> },
    /// Sites whose motion follows from their neighbours.
    Missing { sites: Vec<usize> },
    /// Sites with no quiet part of their own, or too short a one.
    NoQuietPart { sites: Vec<usize> },
    /// Noise that is correlated over `samples` samples.
    CorrelatedNoise { samples: f64 },
}

pub(super) fn find(
    sites: &[SiteNoise],
    correlation: f64,
    missing: &[MissingSite],
    contacts: &[ContactEstimate],
    momentum: &Momentum,
) -> Vec<MeasuredWarning> {
    let mut warnings = Vec::new();
    let ratio = |j: &usize| momentum.sites[*j].residual / momentum.sites[*j].expected;
    let open = (0..momentum.sites.len()).filter(|j| !momentum.sites[*j].is_closed());
    if let Some(site) = open.max_by(|a, b| ratio(a).total_cmp(&ratio(b))) {
        warnings.push(MeasuredWarning::MomentumOpen {
            site,
            residual: momentum.sites[site].residual,
            expected: momentum.sites[site].expected,
        });
    }
    if momentum.common.is_off() {
        let factor = momentum.common;
        warnings.push(MeasuredWarning::Coefficients { factor });
    }
    for (contact, factor) in momentum.factors.iter().enumerate() {
        if let Some(factor) = factor.filter(Factor::is_off) {
            warnings.push(MeasuredWarning::Coefficient { contact, factor });
        }
    }
    let mut list = |found: Vec<usize>, warning: fn(Vec<usize>) -> MeasuredWarning| {
        if !found.is_empty() {
            warnings.push(warning(found));
        }
    };
    let drowned = |j: &usize| contacts[*j].force.value != 0.0 && !contacts[*j].force.is_resolved();
    list((0..contacts.len()).filter(drowned).collect(), |contacts| {
        MeasuredWarning::BelowNoise { contacts }
    });
    list(missing.iter().map(|m| m.site).collect(), |sites| {
        MeasuredWarning::Missing { sites }
    });
    let dead = |j: &usize| missing.iter().any(|m| m.site == *j);
    let quiet = |j: &usize| !sites[*j].borrowed || dead(j);
    list((0..sites.len()).filter(|j| !quiet(j)).collect(), |sites| {
        MeasuredWarning::NoQuietPart { sites }
    });
    if correlation > 1.0 {
        warnings.push(MeasuredWarning::CorrelatedNoise {
            samples: correlation,
        });
    }
    warnings
}

impl MeasuredWarning {
    /// One sentence with the numbers.
    pub fn message(&self) -> String {
        match self {
            MeasuredWarning::MomentumOpen {
                site,
                residual,
                expected,
            } => format!(
                "the momentum of site {site} does not balance: forces leave {residual:.2e} \
                 unexplained, noise explains {expected:.2e}"
            ),
            MeasuredWarning::Coefficient { contact, factor } => format!(
                "the coefficient of contact {contact} fits best times {:.4}, give or take {:.4}",
                factor.factor, factor.error
            ),
            MeasuredWarning::Coefficients { factor } => format!(
                "all coefficients together fit best times {:.4}, give or take {:.4}",
                factor.factor, factor.error
            ),
            MeasuredWarning::BelowNoise { contacts } => format!(
                "the force is less than twice its error in {}",
                listed("contact", contacts)
            ),
            MeasuredWarning::Missing { sites } => format!(
                "{} recorded nothing: the motion follows from the neighbours",
                listed("site", sites)
            ),
            MeasuredWarning::NoQuietPart { sites } => format!(
                "{} had too little time at rest: noise and drift are taken to be as in the others",
                listed("site", sites)
            ),
            MeasuredWarning::CorrelatedNoise { samples } => {
                format!("the noise is correlated over {samples:.1} samples, which errors allow for")
            }
        }
    }
}

/// `contact 3` or `contacts 3, 5 and 2 more`.
fn listed(what: &str, which: &[usize]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = which.iter().take(SHOWN).map(usize::to_string).collect();
    let plural = if which.len() == 1 { "" } else { "s" };
    let more = match which.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{what}{plural} {}{more}", shown.join(", "))
}
