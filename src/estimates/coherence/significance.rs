//! Which sites are coherent with the reference, and at which frequencies.

use std::ops::Range;

use ndarray::ArrayView1;

use crate::numeric::{chi_square_level, sorted};

/// Share of the largest power of a record below which its bins hold what leaks from others.
const FLOOR: f64 = 1e-6;
/// The same of the largest power among so many bins on either side: the sidelobes of a Hann window are below it.
const NEAR: (usize, f64) = (8, 5e-3);

/// Whether the power at each frequency of a record is its own; what leaks from other frequencies is coherent with
/// them, but has their phase. False at 0.
pub(super) fn is_own(spectrum: ArrayView1<f64>) -> Vec<bool> {
    let end = spectrum.len();
    let most = |bins: Range<usize>| bins.map(|n| spectrum[n]).fold(0.0, f64::max);
    let strongest = most(1..end);
    let own = |n: usize| {
        let near = n.saturating_sub(NEAR.0).max(1)..(n + NEAR.0 + 1).min(end);
        n > 0 && spectrum[n] > (FLOOR * strongest).max(NEAR.1 * most(near))
    };
    (0..end).map(own).collect()
}

/// Tests whether the coherence of a site is above chance over all frequencies.
///
/// Without a common part, a coherence g of K realisations is exceeded with probability `p = (1 - g)^(K - 1)`. Two
/// tests share the probability of an error: the smallest `p_(n) M / n` of the M sorted ones (R. J. Simes, Biometrika
/// 73, 751, 1986) sees a few frequencies, the sum of `-ln p` (R. A. Fisher) sees a weak coherence at many. Frequencies
/// are then chosen by the rate of false ones (Y. Benjamini, Y. Hochberg, J. R. Stat. Soc. B 57, 289, 1995).
pub(super) struct Significance {
    pub alpha: f64,
    /// Sites beside the reference, of which none is coherent by chance with probability `1 - alpha`.
    pub sites: usize,
    /// Bins that a taper makes one of.
    pub shared_bins: f64,
}

impl Significance {
    /// From which `-ln p` on a frequency is coherent, of a site with these; `None` where the site is not. Numbers
    /// that are NaN do not count.
    pub fn threshold(&self, surprises: &[f64]) -> Option<f64> {
        let sorted = sorted(surprises.iter().copied().filter(|s| !s.is_nan()));
        let bins = sorted.len();
        if bins == 0 {
            return None;
        }
        // The last of those from the largest on that is below its share.
        let below = |alpha: f64| {
            let share = |n: usize| alpha * (bins - n) as f64 / bins as f64;
            (0..bins).find(|n| (-sorted[*n]).exp() <= share(*n))
        };
        // Of a site and of one of two tests.
        let each = 0.5 * self.alpha / self.sites.max(1) as f64;
        let degrees = 2.0 * bins as f64 / self.shared_bins;
        let least = 0.5 * self.shared_bins * chi_square_level(each, degrees);
        let is_coherent = below(each).is_some() || sorted.iter().sum::<f64>() > least;
        let chosen = below(self.alpha).filter(|n| n + 1 < bins);
        is_coherent.then(|| chosen.map_or(-self.alpha.ln(), |n| sorted[n]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    fn of_sites(sites: usize) -> Significance {
        let [alpha, shared_bins] = [0.05, 1.0];
        Significance {
            alpha,
            sites,
            shared_bins,
        }
    }

    /// `-ln p` of chance is exponential: one site in twenty is coherent by chance, of many together.
    #[test]
    fn val_chance_is_coherent_as_often_as_stated() {
        for sites in [1, 10] {
            let mut random = Random::new(5);
            let test = of_sites(sites);
            let mut found = 0;
            for _ in 0..2000 {
                let mut of_any = false;
                for _ in 0..sites {
                    let surprises: Vec<f64> = (0..60)
                        .map(|_| 0.5 * (random.normal().powi(2) + random.normal().powi(2)))
                        .collect();
                    of_any |= test.threshold(&surprises).is_some();
                }
                found += usize::from(of_any);
            }
            let share = found as f64 / 2000.0;
            assert!((0.03..0.065).contains(&share), "{sites}: {share}");
        }
    }
}
