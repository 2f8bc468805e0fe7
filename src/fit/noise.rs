//! The noise of the records, estimated from what the best chain leaves of them, and what it makes of the parameters.
//!
//! The residual is taken as stationary autoregressive noise of one correlation and of one variance a site. What the fit
//! has taken from it is given back: with `P = J H^-1 J^T` the residual of noise of covariance S has the covariance
//! `(1 - P) S (1 - P)`.

use num_complex::Complex;

use super::solver::{dot, solved};

/// Highest order of the autoregression, and fewest samples a site for each order.
const MOST_ORDER: usize = 16;
const SAMPLES_AN_ORDER: usize = 12;

/// Correlations below this end the correlation, once an order of them is.
const NO_MORE: f64 = 1e-3;

/// Largest reflection coefficient; 1 is no noise.
const MOST_REFLECTION: f64 = 0.9995;

/// Derivatives of the samples along the unknowns, and the inverse of their normal equations.
pub(super) struct Linear<'a> {
    /// One column an unknown, site after site; rows of standard errors of gains may follow.
    pub columns: &'a [Vec<f64>],
    /// Lower triangle of `J^T J`.
    pub lower: &'a [Vec<f64>],
    pub sites: usize,
    pub times: usize,
}

/// Autoregressive noise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Noise {
    /// `r_i = sum_k a_k r_(i-k) + white`.
    pub coefficients: Vec<f64>,
    /// Correlation of samples by how many steps they are apart, from 0 on.
    pub correlation: Vec<f64>,
    /// Standard deviation of each site, and of all.
    pub sigmas: Vec<f64>,
    pub sigma: f64,
    /// Samples that are known.
    pub samples: usize,
}

impl Noise {
    /// The noise of a residual, 0 where it is missing.
    pub fn of(residual: &[f64], known: &[bool], linear: &Linear) -> Noise {
        let Linear { sites, times, .. } = *linear;
        let samples = known.iter().filter(|known| **known).count();
        let longest = MOST_ORDER.min(samples / sites.max(1) / SAMPLES_AN_ORDER);
        let raw = covariances(residual, times, longest + 1, samples);
        let first = Noise::through(&raw, samples, longest);
        let taken = linear.taken(&first, raw[0], longest + 1, samples);
        let pairs = raw.iter().zip(&taken);
        let whole: Vec<f64> = pairs.map(|(raw, taken)| raw + taken).collect();
        let mut noise = Noise::through(&whole, samples, longest);
        let back = (whole[0] / raw[0].max(f64::MIN_POSITIVE)).sqrt();
        let of_site = |site: usize| {
            let range = times * site..times * (site + 1);
            let count = known[range.clone()].iter().filter(|known| **known).count();
            let record = &residual[range];
            back * (dot(record, record) / count.max(1) as f64).sqrt()
        };
        noise.sigmas = (0..sites).map(of_site).collect();
        noise.sigma = whole[0].sqrt();
        noise
    }

    /// Of autocovariances, the order by Schwarz's criterion.
    fn through(covariances: &[f64], samples: usize, longest: usize) -> Noise {
        let mut best = (f64::INFINITY, Vec::new());
        let (mut a, mut variance) = (Vec::new(), covariances[0]);
        for order in 0..=longest {
            if order > 0 {
                if variance <= 0.0 {
                    break;
                }
                let sum: f64 = (1..order).map(|k| a[k - 1] * covariances[order - k]).sum();
                let reflection = ((covariances[order] - sum) / variance)
                    .clamp(-MOST_REFLECTION, MOST_REFLECTION);
                let next = (1..order).map(|k| a[k - 1] - reflection * a[order - k - 1]);
                a = next.chain([reflection]).collect();
                variance *= 1.0 - reflection * reflection;
            }
            let n = samples as f64;
            let criterion = n * variance.max(f64::MIN_POSITIVE).ln() + order as f64 * n.ln();
            if criterion < best.0 {
                best = (criterion, a.clone());
            }
        }
        let coefficients = best.1;
        let order = coefficients.len();
        let head = covariances[0].max(f64::MIN_POSITIVE);
        let mut correlation: Vec<f64> = covariances[..=order].iter().map(|c| c / head).collect();
        let goes_on = |known: &[f64]| known.iter().rev().take(order).any(|c| c.abs() > NO_MORE);
        while correlation.len() < samples / 2 && goes_on(&correlation) {
            let last = correlation.iter().rev();
            let next = coefficients.iter().zip(last).map(|(a, c)| a * c).sum();
            correlation.push(next);
        }
        Noise {
            coefficients,
            correlation,
            sigmas: Vec::new(),
            sigma: head.sqrt(),
            samples,
        }
    }

    /// By how much the variance of a slow average is larger than that of as many independent samples.
    pub fn inflation(&self) -> f64 {
        (1.0 + 2.0 * self.correlation[1..].iter().sum::<f64>()).max(1.0 / self.samples as f64)
    }

    /// The number of independent samples that tell the variance as well.
    pub fn independent(&self) -> f64 {
        let squares: f64 = self.correlation[1..].iter().map(|c| c * c).sum();
        self.samples as f64 / (1.0 + 2.0 * squares)
    }

    /// The power spectral density over that of white noise, at cycles a sample.
    pub fn density(&self, frequency: f64) -> f64 {
        let lags = self.coefficients.iter().zip(&self.correlation[1..]);
        let white = 1.0 - lags.map(|(a, c)| a * c).sum::<f64>();
        let angle = -std::f64::consts::TAU * frequency;
        let turn = |k: usize| Complex::from_polar(1.0, angle * k as f64);
        let each = self.coefficients.iter().enumerate();
        let gain = Complex::from(1.0) - each.map(|(k, a)| a * turn(k + 1)).sum::<Complex<f64>>();
        white / gain.norm_sqr().max(f64::MIN_POSITIVE)
    }

    /// A column times the correlation, site by site.
    fn correlated(&self, column: &[f64], times: usize) -> Vec<f64> {
        let mut out = vec![0.0; column.len()];
        for (record, out) in column.chunks_exact(times).zip(out.chunks_exact_mut(times)) {
            for (lag, c) in self.correlation.iter().enumerate().take(times) {
                for i in lag..times {
                    out[i] += c * record[i - lag];
                    if lag > 0 {
                        out[i - lag] += c * record[i];
                    }
                }
            }
        }
        out
    }

    /// White noise of unit variance, of what is noise of this kind in a record after record; `None` where one of the
    /// samples that it takes is missing.
    pub fn whitened(&self, grid: &[f64], known: &[bool], times: usize) -> Vec<Option<f64>> {
        let order = self.coefficients.len();
        let white = |at: usize| {
            let is_whole = at % times >= order && known[at - order..=at].iter().all(|known| *known);
            let past = |k: usize| self.coefficients[k - 1] * grid[at - k];
            let sigma = self.sigmas[at / times].max(f64::MIN_POSITIVE);
            is_whole.then(|| (grid[at] - (1..=order).map(past).sum::<f64>()) / sigma)
        };
        (0..grid.len()).map(white).collect()
    }
}

/// Sums of products of samples that are so many steps apart, over the number of samples.
fn covariances(residual: &[f64], times: usize, lags: usize, samples: usize) -> Vec<f64> {
    let of = |lag: usize| {
        let lag = lag.min(times);
        let records = residual.chunks_exact(times);
        let sums = records.map(|record| dot(&record[..times - lag], &record[lag..]));
        sums.sum::<f64>() / samples.max(1) as f64
    };
    (0..lags).map(of).collect()
}

impl Linear<'_> {
    fn inverse(&self, right: &[f64]) -> Vec<f64> {
        solved(self.lower, right)
    }

    fn samples(&self) -> usize {
        self.sites * self.times
    }

    /// `J^T S J` for the noise, with the variance of each site.
    fn score(&self, noise: &Noise, sigmas: &[f64]) -> Vec<Vec<f64>> {
        let n = self.samples();
        let of = |column: &Vec<f64>| {
            let mut all = noise.correlated(&column[..n], self.times);
            for (record, sigma) in all.chunks_exact_mut(self.times).zip(sigmas) {
                record.iter_mut().for_each(|v| *v *= sigma * sigma);
            }
            all
        };
        let correlated: Vec<Vec<f64>> = self.columns.iter().map(of).collect();
        let row = |a: &Vec<f64>| correlated.iter().map(|b| dot(&a[..n], b)).collect();
        self.columns.iter().map(row).collect()
    }

    /// `H^-1 M H^-1`.
    fn between(&self, middle: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let once: Vec<Vec<f64>> = middle.iter().map(|row| self.inverse(row)).collect();
        let count = middle.len();
        let column = |j: usize| -> Vec<f64> { once.iter().map(|row| row[j]).collect() };
        (0..count).map(|j| self.inverse(&column(j))).collect()
    }

    /// The covariance of the unknowns: `H^-1 (J^T S J) H^-1`, with what standard errors of gains add.
    pub fn covariance(&self, noise: &Noise) -> Vec<Vec<f64>> {
        let mut score = self.score(noise, &noise.sigmas);
        let n = self.samples();
        let own = noise.sigma * noise.sigma * noise.inflation();
        for (i, a) in self.columns.iter().enumerate() {
            for (j, b) in self.columns.iter().enumerate() {
                score[i][j] += own * dot(&a[n..], &b[n..]);
            }
        }
        self.between(&score)
    }

    /// What the fit has taken from the autocovariances of noise of this correlation and variance.
    fn taken(&self, noise: &Noise, variance: f64, lags: usize, samples: usize) -> Vec<f64> {
        let (n, times) = (self.samples(), self.times);
        let ones = vec![1.0; self.sites];
        let middle = self.between(&self.score(noise, &ones));
        let correlated = |column: &Vec<f64>| noise.correlated(&column[..n], times);
        let correlated: Vec<Vec<f64>> = self.columns.iter().map(correlated).collect();
        let transposed = |columns: &[Vec<f64>], at: usize| -> Vec<f64> {
            columns.iter().map(|c| c[at]).collect()
        };
        let mut taken = vec![0.0; lags];
        for at in 0..n {
            let here = transposed(self.columns, at);
            let there = transposed(&correlated, at);
            let (solved_here, solved_there) = (self.inverse(&here), self.inverse(&there));
            let both: Vec<f64> = middle.iter().map(|row| dot(row, &here)).collect();
            for (lag, taken) in taken.iter_mut().enumerate().take(times - at % times) {
                for k in 0..self.columns.len() {
                    let (j, g) = (self.columns[k][at + lag], correlated[k][at + lag]);
                    *taken += solved_here[k] * g + solved_there[k] * j - both[k] * j;
                }
            }
        }
        let mean = |sum: &f64| sum * variance / samples.max(1) as f64;
        taken.iter().map(mean).collect()
    }
}
