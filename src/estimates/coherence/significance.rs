//! Which sites are coherent with the reference, and at which frequencies.

use ndarray::ArrayView1;

use crate::numeric::chi_square_level;

/// Share of the largest power of a record below which its bins hold what leaks from others.
const FLOOR: f64 = 1e-6;
/// The same of the largest power among so many bins on either side: the sidelobes of a Hann window are below it.
const NEAR: (usize, f64) = (8, 5e-3);

/// Whether the power at each frequency of a record is its own; what leaks from other frequencies is coherent with
/// them, but has their phase. False at 0.
pub(super) fn is_own(spectrum: ArrayView1<f64>) -> Vec<bool> {
    let inside = |n: &usize| *n > 0;
    let power = |n: usize| spectrum[n];
    let strongest = (1..spectrum.len()).map(power).fold(0.0, f64::max);
    let own = |n: usize| {
        let near = n.saturating_sub(NEAR.0)..(n + NEAR.0 + 1).min(spectrum.len());
        let near = near.filter(inside).map(power).fold(0.0, f64::max);
        n > 0 && power(n) > (FLOOR * strongest).max(NEAR.1 * near)
    };
    (0..spectrum.len()).map(own).collect()
}

/// Tests whether the coherence of a site is above chance over all frequencies.
///
/// Without a common part, a coherence g of K realisations is exceeded with probability `p = (1 - g)^(K - 1)`. Two
/// tests share the probability of an error: the smallest `p_(n) M / n` of the M sorted ones (R. J. Simes, Biometrika
/// 73, 751, 1986) sees a few frequencies, the sum of `-ln p` (R. A. Fisher) sees a weak coherence at many. Frequencies
/// are then chosen by the rate of false ones (Y. Benjamini, Y. Hochberg, J. R. Stat. Soc. B 57, 289, 1995).
pub(super) struct Significance {
    alpha: f64,
    /// Of a site and of one test.
    each: f64,
    /// Bins that a taper makes one of.
    shared_bins: f64,
    /// Bins and the sum that is exceeded by chance, of the last site.
    sum: Option<(usize, f64)>,
    sorted: Vec<f64>,
}

impl Significance {
    /// Of so many sites beside the reference, of which none is coherent by chance with probability `1 - alpha`.
    pub fn new(alpha: f64, sites: usize, shared_bins: f64) -> Self {
        Significance {
            alpha,
            each: alpha / (2 * sites.max(1)) as f64,
            shared_bins,
            sum: None,
            sorted: Vec::new(),
        }
    }

    /// From which `-ln p` on a frequency is coherent, of a site with these; `None` where the site is not. Numbers
    /// that are NaN do not count.
    pub fn threshold(&mut self, surprises: &[f64]) -> Option<f64> {
        self.sorted.clear();
        let known = surprises.iter().filter(|surprise| !surprise.is_nan());
        self.sorted.extend(known);
        self.sorted.sort_unstable_by(|a, b| b.total_cmp(a));
        let bins = self.sorted.len();
        if bins == 0 {
            return None;
        }
        let share = |n: usize| (n + 1) as f64 / bins as f64;
        let is_below = |alpha: f64| {
            let mut ranked = self.sorted.iter().enumerate();
            let last = ranked.rfind(|(n, surprise)| (-**surprise).exp() <= alpha * share(*n));
            last.map(|(n, _)| n)
        };
        let least = match self.sum {
            Some((of, least)) if of == bins => least,
            _ => {
                let degrees = 2.0 * bins as f64 / self.shared_bins;
                0.5 * self.shared_bins * chi_square_level(self.each, degrees)
            }
        };
        let is_coherent = is_below(self.each).is_some() || self.sorted.iter().sum::<f64>() > least;
        let chosen = is_below(self.alpha).filter(|n| *n > 0);
        self.sum = Some((bins, least));
        is_coherent.then(|| match chosen {
            Some(last) => self.sorted[last],
            None => -self.alpha.ln(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    /// `-ln p` of chance is exponential: one site in twenty is coherent by chance, of many together.
    #[test]
    fn val_chance_is_coherent_as_often_as_stated() {
        for sites in [1, 10] {
            let mut random = Random::new(5);
            let mut test = Significance::new(0.05, sites, 1.0);
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

    #[test]
    fn val_a_tone_and_a_weak_broad_band_are_coherent() {
        let mut test = Significance::new(0.05, 1, 1.0);
        let mut tone = vec![0.7; 200];
        (tone[20], tone[21]) = (30.0, 25.0);
        assert_eq!(test.threshold(&tone), Some(25.0));
        assert!(test.threshold(&[1.4; 200]).is_some());
        assert!(test.threshold(&[0.9; 200]).is_none());
        assert!(test.threshold(&[f64::NAN; 200]).is_none());
    }
}
