//! The wavenumber budget over time: spectra, flux, its integral, and whether it balances.

use super::balance::{Passage, running};
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::{BranchBudget, Budget, Identities, Integration, WavenumberBudget};
use super::waiting::Waiting;
use super::wavenumber::{Terms, Transfers};
use crate::arrays::LargeArray;
use crate::diagnostics::{Keep, edge_of};
use crate::error::Result;
use crate::numeric::{count_at_or_below, sum, sum_of};

pub(super) struct Spectral {
    budget: WavenumberBudget,
    edge_asked: Option<f64>,
    flux: Vec<f64>,
    identities: Identities,
}

impl Spectral {
    pub(super) fn new(
        motion: &Motion,
        transfers: &Transfers,
        request: &BudgetRequest,
        waiting: &mut Waiting,
    ) -> Result<Spectral> {
        let wavenumber = transfers.modes.wavenumbers(request.pitch);
        let (samples, count) = (motion.samples(), wavenumber.len());
        let lossy = motion.chain.is_lossy();
        let branches = transfers.branches.as_ref().map(|branches| BranchBudget {
            wavenumber: wavenumber[..branches.len()].to_vec(),
            optical_energy: Vec::new(),
            optical_transfer: Vec::new(),
        });
        let of_cells = branches.as_ref().map_or(0, |of| of.wavenumber.len());
        let columns = |is_there: bool| if is_there { count } else { 0 };
        let from_samples = columns(request.integration == Integration::Samples);
        for (array, columns, shown) in [
            (LargeArray::ENERGY_SPECTRUM, count, Some(Keep::Largest)),
            (LargeArray::TRANSFER, count, None),
            (LargeArray::SPECTRAL_FLUX, count, Some(Keep::Extreme)),
            (LargeArray::INTEGRATED_SPECTRAL_FLUX, from_samples, None),
            (LargeArray::LOSS_SPECTRUM, columns(lossy), None),
            (
                LargeArray::INPUT_SPECTRUM,
                columns(motion.drive.is_some()),
                None,
            ),
            (LargeArray::ACOUSTIC_SPECTRUM, of_cells, None),
            (LargeArray::OPTICAL_SPECTRUM, of_cells, None),
        ] {
            waiting.reserve(array, (samples, columns), shown)?;
        }
        Ok(Spectral {
            edge_asked: request.band_edge_wavenumber,
            flux: Vec::new(),
            identities: Identities {
                loss_sum: lossy.then_some(0.0),
                ..Identities::default()
            },
            budget: WavenumberBudget {
                basis: transfers.modes.basis(),
                edge: f64::NAN,
                branches,
                wavenumber,
                ..WavenumberBudget::default()
            },
        })
    }

    /// Adds the next sample, by which so much has passed, and whose energy and dissipation are known from its sites.
    pub(super) fn take_in(
        &mut self,
        terms: &Terms,
        passed: &[f64],
        [total, dissipation]: [f64; 2],
        waiting: &mut Waiting,
    ) {
        self.check_identities(terms, total, dissipation);
        let energy = &terms.energy;
        let (budget, flux) = (&mut self.budget, &mut self.flux);
        if budget.edge.is_nan() {
            // The first sample with energy settles it.
            let found = || edge_of(energy, &budget.wavenumber);
            budget.edge = self.edge_asked.or_else(found).unwrap_or(f64::NAN);
        }
        let bins = count_at_or_below(&budget.wavenumber, budget.edge);
        running(flux, terms.transfer.iter().map(|transfer| -transfer));
        budget.low_energy.push(sum(&energy[..bins]));
        let past = bins.checked_sub(1).map_or(0.0, |last| flux[last]);
        budget.edge_flux.push(past);
        // The mean of k over the energy, `k = 0` left out.
        let (waves, wavenumber) = (&energy[1..], &budget.wavenumber[1..]);
        let moments = waves.iter().zip(wavenumber).map(|(e, k)| e * k);
        budget.centroid.push(sum_of(moments) / sum(waves));
        if let (Some(branches), Some(split)) = (&mut budget.branches, &terms.split) {
            branches.optical_energy.push(sum(&split.optical_energy));
            branches.optical_transfer.push(split.optical_transfer);
            waiting.push(LargeArray::ACOUSTIC_SPECTRUM, &split.acoustic_energy);
            waiting.push(LargeArray::OPTICAL_SPECTRUM, &split.optical_energy);
        }
        waiting.push(LargeArray::INTEGRATED_SPECTRAL_FLUX, passed);
        for (array, row) in [
            (LargeArray::ENERGY_SPECTRUM, energy),
            (LargeArray::TRANSFER, &terms.transfer),
            (LargeArray::SPECTRAL_FLUX, flux),
            (LargeArray::LOSS_SPECTRUM, &terms.loss),
            (LargeArray::INPUT_SPECTRUM, &terms.input),
        ] {
            waiting.push(array, row);
        }
    }

    fn check_identities(&mut self, terms: &Terms, total: f64, dissipation: f64) {
        let keep = |worst: &mut f64, off: f64, scale: f64| {
            let off = if off == 0.0 { 0.0 } else { (off / scale).abs() };
            if off > *worst || off.is_nan() {
                *worst = off;
            }
        };
        let largest = terms.transfer.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let found = &mut self.identities;
        keep(&mut found.transfer_rounding, terms.rounding, 1.0);
        keep(&mut found.transfer_sum, sum(&terms.transfer), largest);
        keep(&mut found.energy_sum, sum(&terms.energy) - total, total);
        if let Some(worst) = &mut found.loss_sum {
            keep(worst, sum(&terms.loss) - dissipation, dissipation);
        }
    }

    /// Puts what was found into `into`. `time`: label, first and step of the axis.
    pub(super) fn finish(
        self,
        passage: Passage,
        time: (&str, f64, f64),
        waiting: &mut Waiting,
        into: &mut Budget,
    ) {
        let mut budget = self.budget;
        let k = into.units.wavenumber();
        let k = (&*k, 0.0, budget.wavenumber.get(1).copied().unwrap_or(1.0));
        let label = into.units.energy("E(k), both signs of k");
        budget.energy_map = waiting.map(LargeArray::ENERGY_SPECTRUM, label, time, k);
        let label = into.units.power("flux Π(k)");
        budget.flux_map = waiting.map(LargeArray::SPECTRAL_FLUX, label, time, k);
        into.closure.identities = self.identities;
        passage.finish(budget, into);
    }
}
