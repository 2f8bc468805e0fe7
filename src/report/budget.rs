//! `summary.json` of a budget.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::Provenance;
use crate::budget::measured::MeasuredReport;
use crate::budget::{
    Between, Budget, BudgetUnits, Closure, Direction, FrequencyFlow, Identities,
    IntegratedFluxCheck, Integration, RefinedFlow, ScaleBudget, ScaleOf, WavenumberBudget,
    usual_pairs,
};

/// Version of the layout of a budget's `summary.json` and `budget.npz`.
pub const BUDGET_SCHEMA: &str = "cascade.budget/1";

/// The summary of a budget; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct BudgetSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    sites: usize,
    contacts: usize,
    samples: usize,
    duration: f64,
    units: &'a BudgetUnits,
    conventions: Conventions,
    energy: Energies,
    wavenumber: Option<WavenumberSummary>,
    frequency: Option<FrequencySummary>,
    scale: Option<Vec<ScaleSummary>>,
    closure: ClosureSummary,
    /// Of a measured field: its noise, errors, momenta, warnings.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<&'a MeasuredReport>,
}

#[derive(Debug, Serialize)]
struct Conventions {
    flux: &'static str,
    wavenumber: &'static str,
    integrated_flux: &'static str,
    power_flow: &'static str,
    residuals: &'static str,
}

#[derive(Debug, Serialize)]
struct Energies {
    start: f64,
    end: f64,
    kinetic_end: f64,
    contact_end: f64,
    lost: f64,
    put_in: f64,
    /// Through the last contact between two sites.
    passed: Option<f64>,
    followed_inside_the_steps: bool,
    /// Standard errors, of a measured field.
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<EnergyErrors>,
}

/// Standard errors of the energies of the same names.
#[derive(Debug, Serialize)]
struct EnergyErrors {
    start: f64,
    end: f64,
    kinetic_end: f64,
    contact_end: f64,
    lost: f64,
    passed: Option<f64>,
}

#[derive(Debug, Serialize)]
struct WavenumberSummary {
    basis: crate::budget::Basis,
    band_edge: Option<f64>,
    /// Energy that has passed from below the edge to above, net, over the largest energy.
    share_passed: Option<f64>,
    /// Its numerical error; of a measured field its standard error.
    share_passed_error: Option<f64>,
    direction: Option<Direction>,
    /// Mean flux through the edge.
    rate: Option<f64>,
    /// Wavenumber through which most has passed, either way, and how much; none where that is no
    /// more than its error.
    largest_passage: Option<PassageSummary>,
    centroid_start: Option<f64>,
    centroid_end: Option<f64>,
    optical_share_start: Option<f64>,
    optical_share_end: Option<f64>,
    /// Standard errors, of a measured field.
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<WavenumberErrors>,
}

/// Standard errors of the numbers of the same names.
#[derive(Debug, Serialize)]
struct WavenumberErrors {
    rate: Option<f64>,
    /// Of the share at the wavenumber of `largest_passage`.
    largest_passage: Option<f64>,
    centroid_start: Option<f64>,
    centroid_end: Option<f64>,
    optical_share_start: Option<f64>,
    optical_share_end: Option<f64>,
}

#[derive(Debug, Serialize)]
struct PassageSummary {
    wavenumber: f64,
    share: f64,
}

#[derive(Debug, Serialize)]
struct FrequencySummary {
    band_edge: Option<f64>,
    /// From the first contact to the middle one and to the last that joins two sites, and the
    /// requested pairs.
    between: Vec<BetweenSummary>,
    /// Of chosen contacts, from records made inside the stepping.
    refined: Vec<RefinedFlow>,
}

#[derive(Debug, Serialize)]
struct BetweenSummary {
    #[serde(flatten)]
    of: Between,
    /// Standard errors, of a measured field.
    #[serde(skip_serializing_if = "Option::is_none")]
    low_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    high_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    behind_error: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ScaleSummary {
    #[serde(flatten)]
    of: ScaleOf,
    contacts: [usize; 2],
    integrated_flux: f64,
    /// Standard error, of a measured field.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrated_flux_error: Option<f64>,
    residual: Option<f64>,
}

/// Residuals; where one is `null`, `reasons` says why.
#[derive(Debug, Clone, Serialize)]
struct ClosureSummary {
    real_space: Option<f64>,
    wavenumber: Option<f64>,
    frequency: Option<f64>,
    scale: Option<f64>,
    integration: Integration,
    departure: Option<f64>,
    integrated_flux: Option<IntegratedFluxCheck>,
    identities: Identities,
    #[serde(skip_serializing_if = "Map::is_empty")]
    reasons: Map<String, Value>,
}

impl ClosureSummary {
    /// Of a budget.
    fn of(closure: &Closure) -> ClosureSummary {
        let named = [
            ("real_space", &closure.real_space),
            ("wavenumber", &closure.wavenumber),
            ("frequency", &closure.frequency),
            ("scale", &closure.scale),
        ];
        let reasons = named
            .iter()
            .filter_map(|(name, residual)| Some(((*name).into(), json!(residual.reason()?))));
        ClosureSummary {
            real_space: closure.real_space.value(),
            wavenumber: closure.wavenumber.value(),
            frequency: closure.frequency.value(),
            scale: closure.scale.value(),
            integration: closure.integration,
            departure: closure.departure,
            integrated_flux: closure.integrated_flux,
            identities: closure.identities,
            reasons: reasons.collect(),
        }
    }
}

impl<'a> BudgetSummary<'a> {
    /// Gathers the summary of `budget`; computes nothing new.
    pub fn new(budget: &'a Budget, provenance: &'a Provenance) -> Self {
        let last = budget.time.len() - 1;
        let total = |i: usize| budget.kinetic[i] + budget.contact[i];
        BudgetSummary {
            schema: BUDGET_SCHEMA,
            provenance,
            sites: budget.n_sites,
            contacts: budget.n_contacts,
            samples: budget.time.len(),
            duration: budget.time[last] - budget.time[0],
            units: &budget.units,
            conventions: Conventions {
                flux: "J positive towards +x; spectral and scale fluxes positive towards high k \
                       and small scales",
                wavenumber: "rad per unit of length; E and T hold both signs of k and sum to the \
                             energy and to 0",
                integrated_flux: match budget.closure.integration {
                    Integration::Stepping => {
                        "the integral of - sum T up to k inside the stepping; checked by what the \
                         wavenumbers gained, lost to damping and were given"
                    }
                    Integration::Samples => {
                        "minus what the wavenumbers up to k gained, lost to damping and were given; \
                         losses and inputs by the trapezoid rule over the samples"
                    }
                },
                power_flow: "one-sided; its sum times df is the energy passed by the trapezoid rule",
                residuals: "largest over all samples, relative to the largest energy of the chain",
            },
            energy: Energies {
                start: total(0),
                end: total(last),
                kinetic_end: budget.kinetic[last],
                contact_end: budget.contact[last],
                lost: budget.lost[last],
                put_in: budget.input[last],
                passed: inner_contacts(budget).last().map(|j| budget.passed[j]),
                followed_inside_the_steps: budget.followed,
                errors: budget.errors.as_deref().map(|errors| EnergyErrors {
                    start: errors.energy[0],
                    end: errors.energy[last],
                    kinetic_end: errors.kinetic[last],
                    contact_end: errors.contact[last],
                    lost: errors.lost[last],
                    passed: inner_contacts(budget).last().map(|j| errors.passed[j]),
                }),
            },
            wavenumber: budget
                .wavenumber
                .as_ref()
                .map(|found| wavenumber(budget, found)),
            frequency: budget
                .frequency
                .as_ref()
                .map(|flow| frequency(budget, flow)),
            scale: budget.scales.as_ref().map(|found| scales(budget, found)),
            closure: ClosureSummary::of(&budget.closure),
            measured: None,
        }
    }

    /// The same with what a measurement of the motion yields.
    pub fn with_measurement(self, measured: Option<&'a MeasuredReport>) -> Self {
        BudgetSummary { measured, ..self }
    }

    /// The summary as indented JSON.
    ///
    /// # Errors
    /// None in practice: every part is plain data.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Contacts between two sites.
fn inner_contacts(budget: &Budget) -> std::ops::Range<usize> {
    0..budget.n_contacts.min(budget.n_sites.saturating_sub(1))
}

fn defined(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn wavenumber(budget: &Budget, found: &WavenumberBudget) -> WavenumberSummary {
    let passed = found.passed_edge().filter(|_| budget.scale > 0.0);
    let duration = budget.time[budget.time.len() - 1] - budget.time[0];
    let most = budget.largest_passage();
    let optical = |last: bool| {
        let energy = &found.branches.as_ref()?.optical_energy;
        let i = if last { energy.len() - 1 } else { 0 };
        defined(energy[i] / (budget.kinetic[i] + budget.contact[i]))
    };
    WavenumberSummary {
        basis: found.basis,
        band_edge: defined(found.edge),
        share_passed: passed.map(|passed| passed / budget.scale),
        share_passed_error: passed.map(|_| found.passed_error.value() / budget.scale),
        direction: passed.and_then(|_| found.direction()),
        rate: passed.map(|passed| passed / duration),
        largest_passage: most
            .filter(|most| most.share.abs() > most.error)
            .map(|most| PassageSummary {
                wavenumber: most.wavenumber,
                share: most.share,
            }),
        centroid_start: found.centroid.first().copied().and_then(defined),
        centroid_end: found.centroid.last().copied().and_then(defined),
        optical_share_start: optical(false),
        optical_share_end: optical(true),
        errors: budget.errors.as_deref().map(|errors| {
            let optical = |i: usize| {
                let error = errors.optical_energy.get(i)?;
                defined(error / (budget.kinetic[i] + budget.contact[i]))
            };
            let last = budget.time.len() - 1;
            WavenumberErrors {
                rate: passed.map(|_| found.passed_error.value() / duration),
                largest_passage: most.map(|most| most.error),
                centroid_start: errors.centroid.first().copied().and_then(defined),
                centroid_end: errors.centroid.last().copied().and_then(defined),
                optical_share_start: optical(0),
                optical_share_end: optical(last),
            }
        }),
    }
}

fn frequency(budget: &Budget, flow: &FrequencyFlow) -> FrequencySummary {
    let usual = usual_pairs(budget);
    let between = usual.iter().map(|[a, b]| flow.between(*a, *b));
    let errors = budget.errors.as_deref().map(|errors| &errors.between);
    let between = between.chain(flow.chosen.iter().copied()).enumerate();
    let between = between.map(|(i, of)| {
        let error = |part: usize| errors?.get(3 * i + part).copied();
        BetweenSummary {
            of,
            low_error: error(0),
            high_error: error(1),
            behind_error: error(2),
        }
    });
    FrequencySummary {
        band_edge: defined(flow.edge),
        between: between.collect(),
        refined: flow.refined.clone(),
    }
}

fn scales(budget: &Budget, found: &ScaleBudget) -> Vec<ScaleSummary> {
    let rows = found.scales.iter().enumerate();
    rows.map(|(i, of)| ScaleSummary {
        of: *of,
        contacts: found.contacts[i],
        integrated_flux: found.integrated_flux[i],
        integrated_flux_error: (budget.errors.as_deref())
            .and_then(|errors| errors.integrated_scale_flux.get(i).copied()),
        residual: found.residual[i].and_then(defined),
    })
    .collect()
}
