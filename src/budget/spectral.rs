//! The wavenumber budget over time: spectra, flux, its integral, and whether it balances.

use super::balance::{RunningBalance, energy_rates};
use super::motion::Motion;
use super::passage::{GivenRate, Passage, PassageRates, running};
use super::request::BudgetRequest;
use super::result::{
    BranchBudget, Identities, IntegratedFluxCheck, Integration, PassedError, WavenumberBudget,
    empty_map,
};
use super::units::BudgetUnits;
use super::waiting::{ShownArray, Waiting};
use super::wavenumber::{Terms, Transfers};
use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::edge_of;
use crate::error::Result;
use crate::numeric::{count_at_or_below, sum};

#[derive(Default)]
struct Rates {
    energy: Vec<f64>,
    passage: PassageRates,
}

pub(super) struct Spectral {
    budget: WavenumberBudget,
    edge_asked: Option<f64>,
    /// Bins of the low band; `None` until there is energy.
    low_bins: Option<usize>,
    balance: RunningBalance,
    passage: Passage,
    /// Rates at this sample, and at the one before.
    now: Rates,
    before: Rates,
    flux: Vec<f64>,
    moments: Vec<f64>,
    identities: Identities,
}

impl Spectral {
    pub(super) fn new(
        motion: &Motion,
        transfers: &Transfers,
        request: &BudgetRequest,
        sink: &dyn Sink,
        waiting: &mut Waiting,
    ) -> Result<Spectral> {
        let wavenumber = transfers.modes.wavenumbers(request.pitch);
        let shape = (motion.samples(), wavenumber.len());
        for (array, shown) in [
            (LargeArray::ENERGY_SPECTRUM, ShownArray::Largest),
            (LargeArray::TRANSFER, ShownArray::Not),
            (LargeArray::SPECTRAL_FLUX, ShownArray::Extreme),
        ] {
            waiting.reserve(sink, array, shape, shown)?;
        }
        if request.integration == Integration::Samples {
            let array = LargeArray::INTEGRATED_SPECTRAL_FLUX;
            waiting.reserve(sink, array, shape, ShownArray::Not)?;
        }
        let lossy = motion.chain.is_lossy();
        if lossy {
            waiting.reserve(sink, LargeArray::LOSS_SPECTRUM, shape, ShownArray::Not)?;
        }
        if motion.drive.is_some() {
            waiting.reserve(sink, LargeArray::INPUT_SPECTRUM, shape, ShownArray::Not)?;
        }
        let branches = transfers.branches().map(|branches| BranchBudget {
            wavenumber: branches.wavenumbers(request.pitch),
            optical_energy: Vec::new(),
            optical_transfer: Vec::new(),
        });
        if let Some(branches) = &branches {
            let shape = (shape.0, branches.wavenumber.len());
            waiting.reserve(sink, LargeArray::ACOUSTIC_SPECTRUM, shape, ShownArray::Not)?;
            waiting.reserve(sink, LargeArray::OPTICAL_SPECTRUM, shape, ShownArray::Not)?;
        }
        Ok(Spectral {
            edge_asked: request.band_edge_wavenumber,
            low_bins: None,
            balance: RunningBalance::default(),
            passage: Passage::new(GivenRate::Balance, shape.0, shape.1),
            now: Rates::default(),
            before: Rates::default(),
            flux: Vec::new(),
            moments: Vec::new(),
            identities: Identities {
                loss_sum: lossy.then_some(0.0),
                ..Identities::default()
            },
            budget: WavenumberBudget {
                basis: transfers.modes.basis(),
                edge: f64::NAN,
                integrated_flux: Vec::new(),
                late_flux: Vec::new(),
                passed_error: PassedError::Numerical(0.0),
                low_energy: Vec::new(),
                edge_flux: Vec::new(),
                centroid: Vec::new(),
                energy_map: empty_map(),
                flux_map: empty_map(),
                branches,
                wavenumber,
            },
        })
    }

    /// Adds sample i, whose energy and dissipation are known from its sites.
    pub(super) fn take_in(
        &mut self,
        i: usize,
        dt: f64,
        terms: &Terms,
        [total, dissipation]: [f64; 2],
        waiting: &mut Waiting,
    ) {
        self.check_identities(terms, total, dissipation);
        self.integrate(i, dt, terms);
        let energy = &terms.energy;
        let bins = self.low_bins(energy);
        let (budget, flux) = (&mut self.budget, &mut self.flux);
        running(flux, terms.transfer.iter().map(|transfer| -transfer));
        let integrated = self.passage.sample(i, energy);
        budget.low_energy.push(sum(&energy[..bins]));
        budget
            .edge_flux
            .push(bins.checked_sub(1).map_or(0.0, |last| flux[last]));
        let centroid = centroid(energy, &budget.wavenumber, &mut self.moments);
        budget.centroid.push(centroid);
        if let (Some(branches), Some(split)) = (&mut budget.branches, &terms.split) {
            branches.keep(split);
            waiting.push(LargeArray::ACOUSTIC_SPECTRUM, &split.acoustic_energy);
            waiting.push(LargeArray::OPTICAL_SPECTRUM, &split.optical_energy);
        }
        for (array, row) in [
            (LargeArray::ENERGY_SPECTRUM, energy),
            (LargeArray::TRANSFER, &terms.transfer),
            (LargeArray::SPECTRAL_FLUX, flux),
            (LargeArray::LOSS_SPECTRUM, &terms.loss),
            (LargeArray::INPUT_SPECTRUM, &terms.input),
        ] {
            waiting.push(array, row);
        }
        waiting.push(LargeArray::INTEGRATED_SPECTRAL_FLUX, integrated);
    }

    fn check_identities(&mut self, terms: &Terms, total: f64, dissipation: f64) {
        let keep = |worst: &mut f64, off: f64, scale: f64| {
            let off = if off == 0.0 { 0.0 } else { (off / scale).abs() };
            if off > *worst || off.is_nan() {
                *worst = off;
            }
        };
        let largest = terms.transfer.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let identities = &mut self.identities;
        keep(&mut identities.transfer_rounding, terms.rounding, 1.0);
        keep(&mut identities.transfer_sum, sum(&terms.transfer), largest);
        keep(
            &mut identities.energy_sum,
            sum(&terms.energy) - total,
            total,
        );
        if let Some(worst) = &mut identities.loss_sum {
            keep(worst, sum(&terms.loss) - dissipation, dissipation);
        }
    }

    /// The trapezoid rule over the samples.
    fn integrate(&mut self, i: usize, dt: f64, terms: &Terms) {
        std::mem::swap(&mut self.now, &mut self.before);
        let Rates { energy, passage } = &mut self.now;
        energy_rates(terms, energy);
        passage.load(terms);
        if i > 0 {
            self.passage.trapezoid(dt, &self.before.passage, passage);
            self.balance.trapezoid(dt, &self.before.energy, energy);
        }
        self.balance.compare(&terms.energy);
    }

    /// Bins at or below the edge, which the first sample with energy settles.
    fn low_bins(&mut self, energy: &[f64]) -> usize {
        if let Some(bins) = self.low_bins {
            return bins;
        }
        let wavenumber = &self.budget.wavenumber;
        let Some(edge) = self.edge_asked.or_else(|| edge_of(energy, wavenumber)) else {
            return 0;
        };
        self.budget.edge = edge;
        let bins = count_at_or_below(wavenumber, edge);
        self.low_bins = Some(bins);
        bins
    }

    pub(super) fn worst(&self) -> f64 {
        self.balance.worst()
    }

    /// The error of the integrated flux, in units of energy.
    pub(super) fn check(&self) -> IntegratedFluxCheck {
        IntegratedFluxCheck {
            at_largest_wavenumber: self.passage.top(),
            two_ways: self.passage.apart(),
        }
    }

    pub(super) fn identities(&self) -> Identities {
        self.identities
    }

    /// `time`: label, first and step of the axis.
    pub(super) fn finish(
        self,
        time: (&str, f64, f64),
        units: &BudgetUnits,
        waiting: &mut Waiting,
    ) -> WavenumberBudget {
        let mut budget = self.budget;
        [budget.integrated_flux, budget.late_flux] = self.passage.whole_and_late();
        let step = budget.wavenumber.get(1).copied().unwrap_or(1.0);
        let k = units.wavenumber();
        let k = (&*k, 0.0, step);
        let label = units.energy("E(k), both signs of k");
        let map = waiting.map(LargeArray::ENERGY_SPECTRUM, label, time, k);
        budget.energy_map = map.unwrap_or_else(empty_map);
        let map = waiting.map(LargeArray::SPECTRAL_FLUX, units.power("flux Π(k)"), time, k);
        budget.flux_map = map.unwrap_or_else(empty_map);
        budget
    }
}

/// Mean of k over the energy, `k = 0` left out; NaN without energy.
fn centroid(energy: &[f64], wavenumber: &[f64], moments: &mut Vec<f64>) -> f64 {
    let (energy, wavenumber) = (&energy[1..], &wavenumber[1..]);
    moments.clear();
    moments.extend(energy.iter().zip(wavenumber).map(|(e, k)| e * k));
    sum(moments) / sum(energy)
}
