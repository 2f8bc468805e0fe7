//! What a measured field lacks.

use super::MeasuredReport;

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
pub(super) fn find(report: &MeasuredReport) -> Vec<MeasuredWarning> {
    let MeasuredReport {
        momentum, contacts, ..
    } = report;
    let (n, m) = (report.sites.len(), contacts.len());
    let is_missing = |site: usize| report.missing.iter().any(|missing| missing.site == site);
    let is_borrowed = |site: usize| report.sites[site].borrowed && !is_missing(site);
    let is_off = |i: usize| momentum.factors[i].is_some_and(|factor| factor.is_off());
    let is_drowned = |i: usize| {
        let force = contacts[i].force;
        force.value != 0.0 && !force.is_resolved()
    };
    let all: [(Lack, usize, &dyn Fn(usize) -> bool); 7] = [
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
    let found = all.map(|(code, count, is_one)| MeasuredWarning {
        code,
        at: (0..count).filter(|i| is_one(*i)).collect(),
    });
    found
        .into_iter()
        .filter(|found| !found.at.is_empty())
        .collect()
}

impl MeasuredWarning {
    /// One sentence, and what to do about it.
    pub fn words(&self) -> (String, &'static str) {
        const CHAIN: &str = "check masses, contact law and coefficients of the chain and the gains of the channels, or \
                             state how uncertain they are, and that the contacts just touched at the start";
        let (said, what, advice) = match self.code {
            Lack::MomentumOpen => ("forces do not explain the momentum of", "site", CHAIN),
            Lack::Coefficients | Lack::Coefficient => (
                "the momenta contradict the coefficient of",
                "contact",
                CHAIN,
            ),
            Lack::BelowNoise => (
                "the force is less than twice its error in",
                "contact",
                "leave these contacts out of what is concluded",
            ),
            Lack::Missing => (
                "the motion follows from the neighbours at",
                "site",
                "none is needed where the stated error is small enough",
            ),
            Lack::NoQuietPart => (
                "noise and drift are taken to be those of the other channels at",
                "site",
                "record some time before the impact, and state the sample at which it begins",
            ),
            Lack::CorrelatedNoise => (
                "noise is correlated from sample to sample, which errors allow for, at",
                "site",
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
        (format!("{said} {what}{plural} {places}{more}"), advice)
    }
}
