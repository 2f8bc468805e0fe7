//! The curves of a budget in one place, or their standard errors.

use super::frequency::Between;
use super::result::Budget;

/// Curves of a [`Budget`], or their standard errors. Curves that were not requested are empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// Total energy, its parts, and what losses took, at each sample.
    pub energy: Vec<f64>,
    pub kinetic: Vec<f64>,
    pub contact: Vec<f64>,
    pub lost: Vec<f64>,
    /// Energy that passed through each contact by the end, and the energy left on its left side.
    pub passed: Vec<f64>,
    pub left_behind: Vec<f64>,
    /// Over wavenumbers, of the whole record and of its second half.
    pub integrated_flux: Vec<f64>,
    pub late_flux: Vec<f64>,
    /// At each sample.
    pub low_energy: Vec<f64>,
    pub edge_flux: Vec<f64>,
    pub centroid: Vec<f64>,
    pub optical_energy: Vec<f64>,
    pub optical_transfer: Vec<f64>,
    /// Through each contact, below the edge of frequency and above.
    pub low_frequency: Vec<f64>,
    pub high_frequency: Vec<f64>,
    /// `low`, `high` and `behind` of every requested pair of contacts, one after the other.
    pub between: Vec<f64>,
    /// Over scales.
    pub integrated_scale_flux: Vec<f64>,
}

impl Curves {
    /// Those of a budget.
    pub fn of(budget: &Budget) -> Curves {
        let mut curves = Curves {
            energy: budget.energies(),
            kinetic: budget.kinetic.clone(),
            contact: budget.contact.clone(),
            lost: budget.lost.clone(),
            passed: budget.passed.clone(),
            left_behind: budget.left_behind.clone(),
            ..Curves::default()
        };
        if let Some(found) = &budget.wavenumber {
            curves.integrated_flux = found.integrated_flux.clone();
            curves.late_flux = found.late_flux.clone();
            curves.low_energy = found.low_energy.clone();
            curves.edge_flux = found.edge_flux.clone();
            curves.centroid = found.centroid.clone();
            if let Some(branches) = &found.branches {
                curves.optical_energy = branches.optical_energy.clone();
                curves.optical_transfer = branches.optical_transfer.clone();
            }
        }
        if let Some(flow) = &budget.frequency {
            curves.low_frequency = flow.low.clone();
            curves.high_frequency = flow.high.clone();
            let of_pair = |pair: &Between| [pair.low, pair.high, pair.behind];
            curves.between = flow.chosen.iter().flat_map(of_pair).collect();
        }
        if let Some(found) = &budget.scales {
            curves.integrated_scale_flux = found.integrated_flux.clone();
        }
        curves
    }

    /// Puts `of` this value, that of `again` and that of `here` in place of each value.
    pub(super) fn combine(
        &mut self,
        again: &mut Curves,
        here: &mut Curves,
        of: impl Fn(f64, f64, f64) -> f64,
    ) {
        for ((sums, again), here) in self.each().into_iter().zip(again.each()).zip(here.each()) {
            for ((sum, again), here) in sums.iter_mut().zip(again).zip(here) {
                *sum = of(*sum, *again, *here);
            }
        }
    }

    pub(super) fn each(&mut self) -> [&mut Vec<f64>; 17] {
        [
            &mut self.energy,
            &mut self.kinetic,
            &mut self.contact,
            &mut self.lost,
            &mut self.passed,
            &mut self.left_behind,
            &mut self.integrated_flux,
            &mut self.late_flux,
            &mut self.low_energy,
            &mut self.edge_flux,
            &mut self.centroid,
            &mut self.optical_energy,
            &mut self.optical_transfer,
            &mut self.low_frequency,
            &mut self.high_frequency,
            &mut self.between,
            &mut self.integrated_scale_flux,
        ]
    }
}
