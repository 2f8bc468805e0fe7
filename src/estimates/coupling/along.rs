//! Bicoherence of chosen sites along x: of each output frequency its largest and its sum.

use ndarray::Array2;

use super::bicoherence::{Pass, sidak};
use super::spectra::Spectra;
use super::triples::{TripleSums, Triples};
use crate::error::Result;
use crate::estimates::realisations::{
    Independence, Records, SegmentScratch, Shot, TOGETHER, steadiness,
};

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
        let levels = self.largest_level.columns();
        columns
            .zip(levels)
            .map(|(values, levels)| values.iter().zip(levels).filter(|(b, at)| b > at).count())
            .collect()
    }
}

/// The work of a tile of sites.
#[derive(Default, Clone)]
struct TileWork {
    /// Of each chosen site of the tile, while shots are added.
    sums: Vec<TripleSums>,
    steady: Vec<f64>,
    /// Columns of the result.
    found: Vec<Vec<Found>>,
}

/// Of one output frequency.
#[derive(Debug, Clone, Copy)]
struct Found {
    largest: f64,
    cell: usize,
    first: usize,
    biphase: f64,
    summed: f64,
    pairs: usize,
}

/// Sums along x, while shots are added.
pub(super) struct Along<'a> {
    pass: &'a Pass<'a>,
    triples: &'a Triples,
    tiles: Vec<TileWork>,
}

impl<'a> Along<'a> {
    pub fn new(pass: &'a Pass<'a>, triples: &'a Triples) -> Along<'a> {
        let tiles = match pass.request.along.is_empty() {
            true => Vec::new(),
            false => vec![TileWork::default(); pass.shots.tiles()],
        };
        Along {
            pass,
            triples,
            tiles,
        }
    }

    /// Adds a shot.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn add(&mut self, shot: &Shot<'_>, is_last: bool) -> Result<()> {
        if self.tiles.is_empty() {
            return Ok(());
        }
        let (pass, triples) = (self.pass, self.triples);
        let one = TripleSums::zeros(triples);
        let visit = |scratch: &mut SegmentScratch,
                     sites: std::ops::Range<usize>,
                     records: Records<'_>,
                     work: &mut TileWork| {
            let chosen = pass.request.along.iter().copied();
            let chosen: Vec<usize> = chosen.filter(|site| sites.contains(site)).collect();
            if chosen.is_empty() {
                return;
            }
            let of: Vec<Vec<f64>> = chosen
                .iter()
                .map(|site| records.record(site - sites.start))
                .collect();
            let spectra = match chosen.len() == sites.len() {
                true => Spectra::of(pass.realisations, records, shot.scale, scratch),
                false => {
                    let some = of.concat();
                    let some = Records::one_after_another(&some, records.length());
                    Spectra::of(pass.realisations, some, shot.scale, scratch)
                }
            };
            work.steady.resize(chosen.len(), 0.0);
            for (c, (record, spectra)) in of.iter().zip(&spectra).enumerate() {
                work.steady[c] += steadiness(record);
                if work.sums.len() <= c {
                    work.sums.push(one.clone());
                }
                work.sums[c].add(triples, spectra, spectra);
                if is_last {
                    work.found.push(gathered(triples, &work.sums[c]));
                    work.sums[c] = TripleSums::default();
                }
            }
        };
        shot.each_tile("bispectra", &mut self.tiles, visit)
    }

    pub fn finish(self) -> BicoherenceAlong {
        let sites = self.pass.request.along.clone();
        let columns: Vec<(&Vec<Found>, Independence)> = self
            .tiles
            .iter()
            .flat_map(|work| work.found.iter().zip(&work.steady))
            .map(|(found, steady)| {
                let steady = steady / self.pass.shots.count() as f64;
                (found, self.pass.independence(steady))
            })
            .collect();
        let alpha = self.pass.request.alpha;
        let bins = self.pass.realisations.bins();
        let df = 1.0 / (self.pass.realisations.segments.length as f64 * self.pass.step);
        let spread = self.pass.spread_of_pairs();
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
}

impl Pass<'_> {
    /// Sum of the squared correlations of a pair with all others of the same sum: 1 without a taper.
    fn spread_of_pairs(&self) -> f64 {
        let beside = (1..TOGETHER).map(|lag| self.realisations.bin_correlation(lag).powi(2));
        1.0 + 2.0 * beside.sum::<f64>()
    }
}

/// The largest and the sum at each output frequency.
fn gathered(triples: &Triples, sums: &TripleSums) -> Vec<Found> {
    let nothing = Found {
        largest: f64::NAN,
        cell: 0,
        first: 0,
        biphase: f64::NAN,
        summed: 0.0,
        pairs: 0,
    };
    let mut all = vec![nothing; triples.last + 1];
    let powers = sums.largest_powers();
    for (cell, bins) in triples.bins().enumerate() {
        let b = sums.bicoherence(cell, bins, powers);
        let found = &mut all[bins[2] as usize];
        if b.is_nan() {
            continue;
        }
        found.pairs += 1;
        found.summed += b;
        if found.largest.is_nan() || b > found.largest {
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
    mean * gamma_quantile(shape, 1.0 - alpha)
}

/// The quantile of a gamma distribution of mean 1. Source: E. B. Wilson, M. M. Hilferty, PNAS 17, 684 (1931);
/// within 1 % of it for shapes from 1 on and probabilities from 0.5 to 0.999.
fn gamma_quantile(shape: f64, probability: f64) -> f64 {
    let ninth = 1.0 / (9.0 * shape);
    (1.0 - ninth + normal_quantile(probability) * ninth.sqrt()).powi(3)
}

/// The quantile of the normal distribution, within 4.5e-4. Source: M. Abramowitz, I. A. Stegun (1964), 26.2.23.
pub(super) fn normal_quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability).max(f64::MIN_POSITIVE);
    let t = (-2.0 * tail.ln()).sqrt();
    let top = 2.515517 + t * (0.802853 + t * 0.010328);
    let bottom = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    (t - top / bottom) * if probability < 0.5 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the chi-square distribution (2, 4, 10, 40 degrees of freedom) and of the normal one.
    #[test]
    fn val_tables_quantiles() {
        for (shape, probability, expected) in [
            (1.0, 0.95, 5.991 / 2.0),
            (1.0, 0.99, 9.210 / 2.0),
            (2.0, 0.95, 9.488 / 4.0),
            (5.0, 0.99, 23.209 / 10.0),
            (20.0, 0.95, 55.758 / 40.0),
        ] {
            let off = gamma_quantile(shape, probability) / expected - 1.0;
            assert!(off.abs() < 0.01, "{shape} {probability}: {off}");
        }
        for (probability, expected) in [(0.975, 1.959964), (0.5, 0.0), (0.01, -2.326348)] {
            assert!((normal_quantile(probability) - expected).abs() < 5e-4);
        }
    }

    #[test]
    fn val_closed_form_sidak() {
        assert!((sidak(0.05, 1) - 0.05).abs() < 1e-15);
        assert!((1.0 - (1.0 - sidak(0.05, 1000)).powi(1000) - 0.05).abs() < 1e-12);
    }
}
