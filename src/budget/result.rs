//! Results of a budget other than its large arrays.

use std::collections::BTreeMap;

use super::equipartition::ModeBudget;
use super::filter::ScaleOf;
use super::frequency::FrequencyFlow;
use super::modes::Basis;
use super::units::BudgetUnits;
use crate::diagnostics::Map;
use crate::numeric::count_at_or_below;

/// A budget: curves, numbers and maps; the arrays over time go to a [`crate::arrays::Sink`].
#[derive(Debug, Clone, Default)]
pub struct Budget {
    pub n_sites: usize,
    pub n_contacts: usize,
    /// Distance of neighbouring sites.
    pub pitch: f64,
    pub units: BudgetUnits,
    pub time: Vec<f64>,
    /// At each sample: kinetic energy, energy of contacts, and energies lost and put in since the
    /// first sample.
    pub kinetic: Vec<f64>,
    pub contact: Vec<f64>,
    pub lost: Vec<f64>,
    pub input: Vec<f64>,
    /// Reference energy of shares and residuals: the largest energy that the chain held or received.
    /// For shares of a measured motion: the energy that it received, without the bias of noise.
    pub scale: f64,
    /// Energy passed through each contact by the end.
    pub passed: Vec<f64>,
    /// Energy of all sites left of each contact at the end.
    pub left_behind: Vec<f64>,
    /// Whether energies passed and lost were integrated inside the time steps.
    pub followed: bool,
    pub flux_map: Map,
    pub wavenumber: Option<WavenumberBudget>,
    pub frequency: Option<FrequencyFlow>,
    pub scales: Option<ScaleBudget>,
    /// Energy by normal mode, where it is requested.
    pub modes: Option<ModeBudget>,
    pub closure: Closure,
    /// Standard errors of [`Budget::curves`]; measured motions only.
    pub errors: Option<Curves>,
}

impl Budget {
    /// Energy of the chain at each sample.
    pub fn energies(&self) -> Vec<f64> {
        let parts = self.kinetic.iter().zip(&self.contact);
        parts.map(|(kinetic, contact)| kinetic + contact).collect()
    }

    /// A residual relative to [`Budget::scale`].
    pub(super) fn relative(&self, worst: f64) -> Residual {
        match worst / self.scale {
            _ if worst == 0.0 => Residual::Closed(0.0),
            relative if relative.is_finite() => Residual::Closed(relative),
            _ => Residual::Undefined("it is not finite".into()),
        }
    }

    /// Curves over time, contacts, wavenumbers or scales, under their names in files: those of all views that were
    /// requested. `passed` is by the end, `between` has `low`, `high` and `behind` of each requested pair of contacts.
    pub fn curves(&self) -> Curves {
        let mut curves = BTreeMap::from([
            ("total_energy", self.energies()),
            ("kinetic_energy", self.kinetic.clone()),
            ("contact_energy", self.contact.clone()),
            ("lost_energy", self.lost.clone()),
            ("passed", self.passed.clone()),
            ("left_behind", self.left_behind.clone()),
        ]);
        if let Some(found) = &self.wavenumber {
            curves.extend([
                ("integrated_flux", found.integrated_flux.clone()),
                ("late_flux", found.late_flux.clone()),
                ("low_wavenumber_energy", found.low_energy.clone()),
                ("band_edge_flux", found.edge_flux.clone()),
                ("wavenumber_centroid", found.centroid.clone()),
            ]);
            if let Some(branches) = &found.branches {
                curves.insert("optical_energy", branches.optical_energy.clone());
                curves.insert("optical_transfer", branches.optical_transfer.clone());
            }
        }
        if let Some(flow) = &self.frequency {
            curves.insert("low_frequency_passed", flow.low.clone());
            curves.insert("high_frequency_passed", flow.high.clone());
            let pairs = flow.chosen.iter();
            let between = pairs.flat_map(|pair| [pair.low, pair.high, pair.behind]);
            curves.insert("between", between.collect());
        }
        if let Some(found) = &self.scales {
            curves.insert("integrated_scale_flux", found.integrated_flux.clone());
        }
        curves
    }

    /// Standard error of a curve's i-th value; `None` where it has none.
    pub(super) fn error(&self, curve: &str, i: usize) -> Option<f64> {
        self.errors.as_ref()?.get(curve)?.get(i).copied()
    }

    /// Direction of the net energy passed over the record; `None` for a chain without energy.
    pub fn direction(&self) -> Option<Direction> {
        let found = self.wavenumber.as_ref()?;
        let passed = found.passed_edge()?;
        let (least, undecided) = match &self.errors {
            None => (found.passed_error, Direction::None),
            Some(_) => (SIGNIFICANT * found.passed_error, Direction::Unresolved),
        };
        Some(match passed.abs() <= least {
            true => undecided,
            false if passed > 0.0 => Direction::TowardsHighK,
            false => Direction::TowardsLowK,
        })
    }
}

/// Curves under their names, see [`Budget::curves`].
pub type Curves = BTreeMap<&'static str, Vec<f64>>;

/// The budget over wavenumbers.
#[derive(Debug, Clone, Default)]
pub struct WavenumberBudget {
    pub basis: Basis,
    /// In rad per length; k and -k are combined.
    pub wavenumber: Vec<f64>,
    /// Upper edge of the low band; NaN for a chain without energy.
    pub edge: f64,
    /// `Pi(k) = - sum_{|k'| <= k} T(k')` integrated over the record: energy that has passed from
    /// below each k to above. Inside the stepping it is the integral of `T`. From samples it is
    /// minus the gain of the wavenumbers up to k, less their losses, plus their input; losses and
    /// inputs are integrated by the trapezoid rule.
    pub integrated_flux: Vec<f64>,
    /// The same over the second half of the record, after an impact is over.
    pub late_flux: Vec<f64>,
    /// Error of the integrated flux at the edge: the deviation of its checks, at least the rounding error; of a measured
    /// motion the standard error.
    pub passed_error: f64,
    /// Energy below the edge at each sample.
    pub low_energy: Vec<f64>,
    /// `Pi` through the edge at each sample.
    pub edge_flux: Vec<f64>,
    /// Energy-weighted mean wavenumber, without `k = 0`, at each sample.
    pub centroid: Vec<f64>,
    pub energy_map: Map,
    pub flux_map: Map,
    pub branches: Option<BranchBudget>,
}

impl WavenumberBudget {
    /// Net energy passed from the low band to the high one over the record; `None` for a chain
    /// without energy.
    pub fn passed_edge(&self) -> Option<f64> {
        self.integrated_flux.get(self.passed_bin()?).copied()
    }

    /// The last bin of the low band.
    pub(super) fn passed_bin(&self) -> Option<usize> {
        let bins = count_at_or_below(&self.wavenumber, self.edge);
        bins.checked_sub(1).filter(|_| self.edge.is_finite())
    }
}

/// Wavenumber past which most energy has gone, net.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestPassage {
    pub wavenumber: f64,
    /// Of the largest energy; positive towards higher wavenumbers.
    pub share: f64,
    /// Numerical error of the share; of a measured field its standard error.
    pub error: f64,
    /// What of the share has passed in the second half of the record: of a struck chain, behind its launch.
    pub late: f64,
}

impl Budget {
    /// Where most energy has passed, either way; `None` without wavenumbers or without energy.
    pub fn largest_passage(&self) -> Option<LargestPassage> {
        let found = self.wavenumber.as_ref()?;
        let flux = found.integrated_flux.iter().zip(&found.wavenumber);
        let (bin, (flux, wavenumber)) = flux
            .enumerate()
            .max_by(|(_, a), (_, b)| a.0.abs().total_cmp(&b.0.abs()))?;
        let error = self.error("integrated_flux", bin);
        (self.scale > 0.0 && found.passed_bin().is_some()).then(|| LargestPassage {
            wavenumber: *wavenumber,
            share: flux / self.scale,
            error: error.unwrap_or(found.passed_error) / self.scale,
            late: found.late_flux[bin] / self.scale,
        })
    }
}

/// Number of standard errors above which a direction is reported.
const SIGNIFICANT: f64 = 2.0;

/// Direction of the net energy transfer between low and high wavenumbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Direction {
    #[serde(rename = "towards high k")]
    TowardsHighK,
    #[serde(rename = "towards low k")]
    TowardsLowK,
    /// The energy passed does not exceed its numerical error.
    #[serde(rename = "none")]
    None,
    /// The energy passed does not exceed twice its standard error.
    #[serde(rename = "unresolved")]
    Unresolved,
}

/// Acoustic and optical energy.
#[derive(Debug, Clone)]
pub struct BranchBudget {
    /// Wavenumbers of the cell, in rad per length.
    pub wavenumber: Vec<f64>,
    /// Energy of the optical branch at each sample.
    pub optical_energy: Vec<f64>,
    /// Rate of energy transfer from the acoustic to the optical branch, at each sample.
    pub optical_transfer: Vec<f64>,
}

/// The budget over scales.
#[derive(Debug, Clone)]
pub struct ScaleBudget {
    pub scales: Vec<ScaleOf>,
    /// Contacts at which the flux of each scale is defined: `[first, end]`, `end` exclusive.
    pub contacts: Vec<[usize; 2]>,
    /// Flux summed over contacts and integrated over the record, for each scale.
    pub integrated_flux: Vec<f64>,
    /// The scale of the map.
    pub map_scale: f64,
    pub flux_map: Option<Map>,
    /// Residual of each scale's balance, relative to the largest energy of the chain; `None` for
    /// scales that were not integrated inside the stepping.
    pub residual: Vec<Option<f64>>,
}

/// Residuals of the balances, relative to the largest energy unless stated otherwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Closure {
    /// Site energies against energy passed in and out, and lost.
    pub real_space: Residual,
    /// `E(k)` against the integral of `T - L` (and of the input).
    pub wavenumber: Residual,
    /// Power-flow spectra against energy passed by the end, from samples; inside the stepping energies passed, which are
    /// split between the bands, against those of the sites.
    pub frequency: Residual,
    /// Coarse-grained energies against the integral of their rates: the mapped scale inside the
    /// stepping, or all scales from samples.
    pub scale: Residual,
    /// How the integrals were computed; in real space they are those recorded by the run.
    pub integration: Integration,
    /// If the chain was integrated again: the largest deviation of its E(k) from that of the record
    /// at any sample, relative to the largest energy.
    pub departure: Option<f64>,
    /// Identities that hold for any state.
    pub identities: Identities,
    /// Checks of the integrated spectral flux; `None` without wavenumbers or energy.
    pub integrated_flux: Option<IntegratedFluxCheck>,
}

/// Independent checks of the integrated spectral flux: the largest deviations over all samples,
/// relative to the largest energy.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct IntegratedFluxCheck {
    /// Its magnitude at the largest wavenumber, where it should be 0.
    pub at_largest_wavenumber: f64,
    /// The integral of `- sum_{|k'| <= k} T(k')` against gain, losses and input of the wavenumbers
    /// up to k. The first does not use the energies, the second does not use the transfer.
    pub two_ways: f64,
}

/// A residual, or the reason why it is undefined.
#[derive(Debug, Clone, PartialEq)]
pub enum Residual {
    Closed(f64),
    Undefined(String),
}

impl Default for Residual {
    fn default() -> Self {
        Residual::Undefined("not asked for".into())
    }
}

impl Residual {
    pub fn value(&self) -> Option<f64> {
        match self {
            Residual::Closed(value) => Some(*value),
            Residual::Undefined(_) => None,
        }
    }
}

/// How integrals over time are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Integration {
    /// The trapezoid rule over the samples; it converges slowly if contacts open.
    #[default]
    Samples,
    /// Gauss quadrature between contact-opening events, integrating the chain again.
    Stepping,
}

/// Largest relative violation, over all samples, of identities that hold for any state.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Identities {
    /// `sum_k T` over the largest |T(k)| of the sample, after the correction of rounding errors.
    pub transfer_sum: f64,
    /// That correction, over the root of the sum of squares of `|q^||f^|` and `2 |phi^||phi'^|`.
    pub transfer_rounding: f64,
    /// `sum_k E` against the energy of the sample.
    pub energy_sum: f64,
    /// `sum_k L` against the dissipation of the sample.
    pub loss_sum: Option<f64>,
}
