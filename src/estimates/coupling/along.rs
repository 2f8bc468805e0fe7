//! Bicoherence of chosen sites along x: of each output frequency its largest and its sum.

use ndarray::Array2;

use super::bicoherence::sidak;
use super::pass::Pass;
use super::products::{TripleSums, add_products};
use super::spectra::Spectra;
use super::triples::Triples;
use crate::estimates::realisations::{
    Independence, Realisations, Records, SegmentScratch, Shot, Sums, TOGETHER, Tile,
};
use crate::numeric::chi_square_level;

/// Own bicoherence of sites, gathered at `f3 = f1 + f2`. Arrays are `(frequency f3, site)`, NaN where there is
/// no power or no pair.
#[derive(Debug, Clone)]
pub struct BicoherenceAlong {
    /// Indices of the sites.
    pub sites: Vec<usize>,
    /// The largest bicoherence of all pairs with this sum.
    pub largest: Array2<f64>,
    /// The higher frequency of that pair.
    pub first: Array2<f64>,
    /// Its biphase in rad.
    pub biphase: Array2<f64>,
    /// The sum of the bicoherence over all pairs.
    pub summed: Array2<f64>,
    /// What `largest` exceeds by chance with probability `alpha`, corrected for the number of pairs (Sidak);
    /// NaN where no significance can be stated.
    pub largest_level: Array2<f64>,
    /// The same of `summed`: its distribution without coupling is taken for a gamma distribution of the same
    /// mean and variance.
    pub summed_level: Array2<f64>,
}

impl BicoherenceAlong {
    /// Output frequencies at each site whose largest bicoherence is above its level.
    pub fn coupled_outputs(&self) -> Vec<usize> {
        let columns = self.largest.columns().into_iter();
        let columns = columns.zip(self.largest_level.columns());
        let above = columns.map(|(b, at)| b.iter().zip(at).filter(|(b, at)| b > at).count());
        above.collect()
    }
}

/// Sums of some records: of the map, or of the chosen sites of a tile.
pub(super) struct TileSums {
    /// What all of them are like.
    pub like: Sums,
    /// Of each pair.
    pub products: Vec<TripleSums>,
    /// Of each chosen site, once all its records are summed, and how evenly realisations share its products.
    found: Vec<(f64, Vec<Found>)>,
}

/// Of one output frequency; without pairs it means nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    largest: f64,
    cell: usize,
    first: usize,
    biphase: f64,
    summed: f64,
    pairs: usize,
}

impl TileSums {
    pub fn zeros(realisations: &Realisations) -> TileSums {
        TileSums {
            like: Sums::zeros(realisations.shape(0)),
            products: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Adds what the records of a shot are like, and the products of pairs of them, in parallel where that is wished.
    pub fn add(
        &mut self,
        realisations: &Realisations,
        shot: &Shot<'_>,
        (sites, records): (impl Iterator<Item = usize> + Clone, Records<'_>),
        scratch: &mut SegmentScratch,
        (triples, pairs, is_parallel): (&Triples, impl ExactSizeIterator<Item = [usize; 2]>, bool),
    ) {
        shot.look_at((sites, records), &mut scratch.numbers, &mut self.like);
        let spectra = Spectra::of(realisations, records, scratch);
        let zeros = || TripleSums::zeros(triples);
        self.products.resize_with(pairs.len(), zeros);
        for (sums, pair) in self.products.iter_mut().zip(pairs) {
            add_products(triples, pair.map(|r| &spectra[r]), sums, is_parallel);
        }
    }
}

impl Pass<'_> {
    /// Adds a shot to the sums of a tile; behind the last one, what is found takes their place.
    pub fn add_tile(
        &self,
        scratch: &mut SegmentScratch,
        shot: &Shot<'_>,
        (sites, records): Tile<'_>,
        tile: &mut TileSums,
    ) {
        let along = &self.request.along;
        let [from, to] = [sites.start, sites.end].map(|end| along.partition_point(|j| *j < end));
        if from == to {
            return;
        }
        let chosen = &along[from..to];
        // Of the others no spectra are needed.
        let some: Vec<f64>;
        let records = match chosen.len() == sites.len() {
            true => records,
            false => {
                let rows = records.rows(0..records.length());
                let rows = rows.chunks_exact(sites.len());
                let of = |site: &usize| site - sites.start;
                some = rows
                    .flat_map(|row| chosen.iter().map(move |site| row[of(site)]))
                    .collect();
                Records::interleaved(&some, chosen.len())
            }
        };
        let own = (0..chosen.len()).map(|lane| [lane; 2]);
        // Tiles are in parallel where there are several.
        let how = (&self.own, own, self.chosen_by_tile().nth(1).is_none());
        tile.add(
            self.realisations,
            shot,
            (chosen.iter().copied(), records),
            scratch,
            how,
        );
        if shot.portion.record + 1 == self.records {
            let shared = self.realisations.shared_bins();
            let found = |sums: TripleSums| {
                let evenness = sums.evenness.least(shared);
                (evenness, gathered(&self.own, &sums))
            };
            tile.found = tile.products.drain(..).map(found).collect();
        }
    }

    /// What was found along x.
    pub fn along(&self, tiles: &[TileSums]) -> BicoherenceAlong {
        let sites = self.request.along.clone();
        let found = tiles.iter().flat_map(|tile| {
            let of_tile = tile.found.iter().enumerate();
            of_tile.map(|(lane, (evenness, found))| {
                let steadiness = tile.like.steadiness(lane);
                (found, self.independence(steadiness, *evenness))
            })
        });
        let columns: Vec<(&Vec<Found>, Independence)> = found.collect();
        let alpha = self.request.alpha;
        let bins = self.realisations.bins();
        let df = 1.0 / (self.realisations.segments.length as f64 * self.grid.time.step);
        let spread = self.spread_of_pairs();
        let array = |of: &dyn Fn(&Found, &Independence) -> f64| {
            Array2::from_shape_fn((bins, sites.len()), |(m, j)| {
                let (found, independence) = &columns[j];
                match found.get(m).filter(|found| found.pairs > 0) {
                    Some(found) => of(found, independence),
                    None => f64::NAN,
                }
            })
        };
        BicoherenceAlong {
            largest: array(&|found, _| found.largest),
            first: array(&|found, _| found.first as f64 * df),
            biphase: array(&|found, _| found.biphase),
            summed: array(&|found, _| found.summed),
            largest_level: array(&|found, independence| {
                let level = independence.level(sidak(alpha, found.pairs));
                level.unwrap_or(f64::NAN)
            }),
            summed_level: array(&|found, independence| match independence.independent {
                Some(k) => summed_level(found.pairs as f64, k, spread, alpha),
                None => f64::NAN,
            }),
            sites,
        }
    }

    /// Sum of the squared correlations of a pair with all others of the same sum: 1 without a taper.
    fn spread_of_pairs(&self) -> f64 {
        let beside = (1..TOGETHER).map(|lag| self.realisations.bin_correlation(lag).powi(2));
        1.0 + 2.0 * beside.sum::<f64>()
    }
}

/// The largest and the sum at each output frequency.
fn gathered(triples: &Triples, sums: &TripleSums) -> Vec<Found> {
    let mut all = vec![Found::default(); triples.last + 1];
    let least = sums.least();
    for (cell, bins) in triples.bins().enumerate() {
        let b = sums.bicoherence(cell, bins, least);
        let found = &mut all[bins[2] as usize];
        if b.is_nan() {
            continue;
        }
        found.pairs += 1;
        found.summed += b;
        if found.pairs == 1 || b > found.largest {
            (found.largest, found.cell) = (b, cell);
            found.first = bins[0] as usize;
        }
    }
    for found in all.iter_mut().filter(|found| found.pairs > 0) {
        found.biphase = sums.biphase(found.cell);
    }
    all
}

/// What the sum over `pairs` cells without coupling exceeds with probability `alpha`: of mean `pairs / K` and
/// the variance of as many Beta(1, K - 1), `spread` times for pairs that share a taper's bins.
fn summed_level(pairs: f64, independent: f64, spread: f64, alpha: f64) -> f64 {
    let mean = pairs / independent;
    let shape = pairs * (independent + 1.0) / (independent - 1.0) / spread.min(pairs.max(1.0));
    // Of a gamma distribution of mean 1.
    mean * chi_square_level(alpha, 2.0 * shape) / (2.0 * shape)
}
