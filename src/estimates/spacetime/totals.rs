//! Sums over all realisations of [`super::spacetime()`], and their averages.

use rayon::prelude::*;

use super::pass::{Pass, ROWS};
use crate::estimates::realisations::{Average, Sums, TOGETHER, Weights, steadiness_of_sites};
use crate::numeric::lanes::{LaneBlock, WIDTH, widest};
use crate::transform::fold;

impl Pass<'_> {
    /// Averages over the pairs of tapers, of which each has `count` realisations, by adaptive weights.
    pub(super) fn weighted(&self, groups: &[Vec<LaneBlock>], count: f64) -> Weighted {
        // Concentrations that round to 1 would leave nothing to weigh cells without energy by.
        let [time, space] = [
            &self.realisations.concentrations,
            &self.space.concentrations,
        ];
        let products = time.iter().flat_map(|a| space.iter().map(move |b| a * b));
        let concentrations: Vec<f64> = products.map(|l| l.min(1.0 - f64::EPSILON)).collect();
        let weights = Weights::new(&concentrations, true);
        let (length, sites) = (self.realisations.segments.length, self.grid.sites);
        let of_row = sites.div_ceil(WIDTH) * self.pairs;
        let rows = groups.iter().flat_map(|group| group.chunks_exact(of_row));
        let cells = rows.enumerate().flat_map(|(m, row)| {
            let cells = row.chunks_exact(self.pairs);
            cells.map(move |cell| (fold(m, length), cell))
        });
        // Mean square of the samples; 1 of still fields.
        let energy: f64 = weights.energy(cells).iter().sum();
        let variance = match energy > 0.0 {
            true => energy / ((length * sites) as f64 * count),
            false => 1.0,
        };
        let of_group = |energies: &Vec<LaneBlock>| {
            let cells = energies.len() / self.pairs;
            let mut spectrum = vec![LaneBlock::default(); cells];
            let mut shape = vec![LaneBlock::default(); cells];
            widest(Average {
                weights: &weights,
                energies,
                count: [count; WIDTH],
                variance: [variance; WIDTH],
                spectrum: &mut spectrum,
                shape: &mut shape,
            });
            [spectrum, shape]
        };
        groups.par_iter().map(of_group).collect()
    }
}

/// Averages by adaptive weights, and half of the degrees of freedom of one realisation of each pair of tapers;
/// of each group of rows, `[row * blocks + block]`.
pub(super) type Weighted = Vec<[Vec<LaneBlock>; 2]>;

/// Sums over all realisations.
pub(super) struct Totals {
    /// `[(row * blocks + block) * pairs + pair]`.
    pub groups: Vec<Vec<LaneBlock>>,
    pub weighted: Option<Weighted>,
    pub tiles: Vec<Sums>,
    pub pairs: usize,
    /// Of all pairs.
    pub realisations: f64,
    /// Mean of the squares of the tapers along space, a number a site.
    pub space: Vec<f64>,
}

impl Totals {
    fn cell(&self, row: usize, column: usize) -> usize {
        row % ROWS * self.space.len().div_ceil(WIDTH) + column / WIDTH
    }

    /// The mean of `|X|^2` of a cell, by adaptive weights if there are any.
    pub fn mean(&self, row: usize, column: usize) -> f64 {
        let mean = self.weighted(0, row, column);
        mean.unwrap_or_else(|| self.equal(row, column))
    }

    fn weighted(&self, kind: usize, row: usize, column: usize) -> Option<f64> {
        let group = &self.weighted.as_ref()?[row / ROWS];
        Some(group[kind][self.cell(row, column)].0[column % WIDTH])
    }

    /// The mean of `|X|^2` of a cell, by equal weights.
    pub fn equal(&self, row: usize, column: usize) -> f64 {
        let pairs = &self.groups[row / ROWS][self.cell(row, column) * self.pairs..][..self.pairs];
        pairs.iter().map(|sum| sum.0[column % WIDTH]).sum::<f64>() / self.realisations
    }

    /// Degrees of freedom of a cell over those with equal weights.
    pub fn share(&self, row: usize, column: usize) -> f64 {
        let shape = self.weighted(1, row, column);
        shape.map_or(1.0, |shape| shape / self.pairs as f64)
    }

    fn of_site(&self, what: usize) -> impl Iterator<Item = f64> + '_ {
        let lane = move |j: usize| self.tiles[j / TOGETHER].plain[what].0[j % TOGETHER];
        (0..self.space.len()).map(lane)
    }

    /// Energy under the squares of the tapers, of all segments.
    pub fn tapered(&self) -> f64 {
        let weighted = self.of_site(0).zip(&self.space).map(|(e, w)| e * w);
        crate::numeric::sum(&weighted.collect::<Vec<f64>>())
    }

    /// Squares of the samples of all segments.
    pub fn square(&self) -> f64 {
        crate::numeric::sum(&self.of_site(1).collect::<Vec<f64>>())
    }

    /// Roots of the energies of the sites.
    pub fn site_amplitudes(&self) -> Vec<f64> {
        self.of_site(1).map(f64::sqrt).collect()
    }

    /// The steadiness of the site at which half of the energy lies at sites that are less steady.
    pub fn steadiness(&self, records: usize) -> f64 {
        let of = |j: usize| self.tiles[j / TOGETHER].steadiness(j) / records as f64;
        let energies = self.of_site(1).enumerate();
        steadiness_of_sites(energies.map(|(j, energy)| (of(j), energy)).collect())
    }
}
