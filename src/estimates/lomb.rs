//! Spectra by least squares, of records at uneven times or with gaps: nothing is interpolated.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::estimates::realisations::check_squares;
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;

/// Frequencies after which phases are computed anew, so that rounding does not grow.
const RENEWED: usize = 64;
/// Fewest samples of a record: three are fitted at each frequency.
const FEWEST: usize = 8;

/// Along which axis spectra are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LombAxis {
    /// Of each site's record.
    #[default]
    Time,
    /// Of the profile at each time, averaged over all times.
    Space,
}

/// A spectrum by least squares.
#[derive(Debug, Clone, PartialEq)]
pub struct LombRequest {
    pub axis: LombAxis,
    /// Frequencies per `1 / T`, T the length of the axis.
    pub oversampling: f64,
    /// Highest frequency, in cycles per unit of the axis; `None`: half of the inverse mean step.
    pub highest: Option<f64>,
    /// Probability by which noise exceeds the level anywhere in a record's spectrum.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Default for LombRequest {
    fn default() -> Self {
        LombRequest {
            axis: LombAxis::Time,
            oversampling: 5.0,
            highest: None,
            alpha: 0.05,
            threads: None,
            memory: None,
        }
    }
}

/// Spectra of all records; a column a site, or one column of all profiles.
#[derive(Debug, Clone)]
pub struct Lomb {
    pub axis: LombAxis,
    pub time: Axis,
    pub space: Axis,
    /// Unit of the samples.
    pub sample_unit: Option<String>,
    /// Of all sites.
    pub positions: Vec<f64>,
    /// In cycles per unit of time, or of length.
    pub frequency: Vec<f64>,
    /// Share of the variance that a sine of this frequency explains, 0 to 1, `[frequency, column]`.
    pub power: Array2<f64>,
    /// One-sided power spectral density.
    pub density: Array2<f64>,
    /// Samples that are finite, of each column: those of all profiles together.
    pub samples: Vec<usize>,
    /// Samples that are not.
    pub missing: usize,
    /// Profiles that are averaged; 1 along time.
    pub averaged: usize,
    pub alpha: f64,
    /// The power that noise exceeds anywhere in the column with probability alpha; NaN for averages.
    pub level: Vec<f64>,
    /// The largest of each column: frequency, power, and the probability that noise has it anywhere; NaN for
    /// columns without variance.
    pub peaks: Vec<[f64; 3]>,
    /// Longest and shortest step of the axis, and the mean one.
    pub steps: [f64; 3],
}

/// Spectra by least squares at any sampling (Lomb-Scargle, with a floating mean).
///
/// ```text
/// v(t_n) = c + a cos w t_n + b sin w t_n + e_n,  least squares over the finite samples, w = 2 pi f,
/// p(f) = 1 - sum e^2 / sum (v - mean)^2,                       the standard normalisation
/// S(f) = p sum (v - mean)^2 dt,                                one-sided power spectral density
/// P(p > z) = (1 - z)^((N - 3) / 2),                            at one frequency, of white noise
/// P(max p > z) <= 1 - (1 - P) exp(-tau(z)),                    up to the highest frequency
/// ```
///
/// with N finite samples and the mean step dt. For even times without gaps, `S` at multiples of `1 / (N dt)` is the
/// periodogram. Records have 2 degrees of freedom at each frequency. A record is not finite where a sensor dropped
/// out: those samples are left out, of each site its own.
///
/// Units: f in cycles per unit of the axis, also along space.
///
/// # Errors
/// [`Error::Request`] for fewer than 8 samples, frequencies and probabilities that do not fit; [`Error::Memory`];
/// [`Error::Cancelled`].
///
/// # Source
/// N. R. Lomb, Astrophys. Space Sci. 39, 447 (1976); J. D. Scargle, Astrophys. J. 263, 835 (1982); M. Zechmeister,
/// M. Kürster, Astron. Astrophys. 496, 577 (2009), for the mean; R. V. Baluev, Mon. Not. R. Astron. Soc. 385, 1279
/// (2008), eq. 5, 6 and table 1, for the level.
pub fn lomb(field: &Field, request: &LombRequest, observer: &dyn Observer) -> Result<Lomb> {
    let (along_time, n_times, n_sites) = (
        request.axis == LombAxis::Time,
        field.n_times(),
        field.n_sites(),
    );
    let (at, records) = match request.axis {
        LombAxis::Time => (field.times(), n_sites),
        LombAxis::Space => (field.positions(), n_times),
    };
    let n = at.len();
    let refuse = |option, expected: String, found: String| Error::Request {
        option,
        expected,
        found,
    };
    if n < FEWEST {
        return Err(refuse(
            "field",
            format!("at least {FEWEST} samples of a record"),
            n.to_string(),
        ));
    }
    if !(request.alpha > 0.0 && request.alpha < 1.0) {
        let expected = "a probability between 0 and 1".to_owned();
        return Err(refuse("significance", expected, request.alpha.to_string()));
    }
    if !(1.0..=1000.0).contains(&request.oversampling) {
        let expected = "1 to 1000 frequencies for each that the record resolves".to_owned();
        return Err(refuse(
            "oversampling",
            expected,
            request.oversampling.to_string(),
        ));
    }
    let length = at[n - 1] - at[0];
    let mean_step = length / (n - 1) as f64;
    let steps = at.windows(2).map(|pair| pair[1] - pair[0]);
    let (shortest, longest) = steps.fold((f64::INFINITY, 0.0f64), |(s, l), d| (s.min(d), l.max(d)));
    let step = 1.0 / (request.oversampling * length.max(f64::MIN_POSITIVE));
    let highest = request.highest.unwrap_or(0.5 / mean_step);
    let count = (highest / step * (1.0 + 1e-12)).floor();
    if !(count >= 1.0 && highest.is_finite()) {
        let expected = format!("a frequency from {step} on");
        return Err(refuse("highest", expected, highest.to_string()));
    }
    let columns = if along_time { records } else { 1 };
    let threads = request.threads.unwrap_or_else(rayon::current_num_threads) as u64;
    let (allowed, one) = (
        request.memory.unwrap_or_else(half_of_free_memory),
        8 * (9 * n as u64 + 2 * count as u64),
    );
    let needed = 16 * count as u64 * (columns as u64 + 1) + threads * one;
    if count > 1e9 || needed > allowed {
        let what = "the spectra by least squares (fewer frequencies or sites need less),";
        return Err(Error::Memory {
            what,
            needed,
            allowed,
        });
    }
    let frequency: Vec<f64> = (1..=count as usize).map(|m| m as f64 * step).collect();
    observer.stage("least squares", records as u64);
    let one = |index: usize| {
        if observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let mut values = vec![0.0; n];
        match along_time {
            true => field.read_site_major(0..n_times, index..index + 1, &mut values),
            false => field.read_time_major(index..index + 1, 0..n_sites, &mut values),
        }
        let finite = values.iter().filter(|v| v.is_finite());
        let largest = finite.fold(0.0f64, |m, v| m.max(v.abs()));
        if largest > 0.0 {
            check_squares(largest)?;
        }
        let record = Record::new(&at, &values);
        observer.advance(1);
        Ok((record.spectrum(step, count as usize), record))
    };
    in_pool(request.threads, || {
        let mut found = Lomb {
            axis: request.axis,
            time: field.time.clone(),
            space: field.space.clone(),
            sample_unit: field.unit.clone(),
            positions: field.positions(),
            power: Array2::zeros((frequency.len(), columns)),
            density: Array2::zeros((frequency.len(), columns)),
            frequency,
            samples: vec![0; columns],
            missing: 0,
            averaged: if along_time { 1 } else { records },
            alpha: request.alpha,
            level: Vec::new(),
            peaks: Vec::new(),
            steps: [shortest, longest, mean_step],
        };
        // Blocks of records bound the memory; sums are in the order of the records.
        let block = 4 * rayon::current_num_threads();
        let (mut variances, mut counted) = (0.0, 0usize);
        let mut spreads = vec![f64::NAN; columns];
        for from in (0..records).step_by(block) {
            let spectra: Result<Vec<_>> = (from..records.min(from + block))
                .into_par_iter()
                .map(one)
                .collect();
            for (i, (spectrum, record)) in spectra?.into_iter().enumerate() {
                let column = if along_time { from + i } else { 0 };
                let (samples, squares) = (record.values.len(), record.squares);
                spreads[column] = record.spread();
                found.missing += n - samples;
                found.samples[column] += samples;
                let known = squares > 0.0;
                counted += usize::from(known);
                variances += squares;
                for (m, p) in spectrum.iter().enumerate() {
                    let density = p * squares * mean_step;
                    match along_time {
                        true => {
                            found.power[[m, column]] = if known { *p } else { f64::NAN };
                            found.density[[m, column]] = density;
                        }
                        false => {
                            // The share of the variance of all profiles.
                            found.power[[m, 0]] += p * squares;
                            found.density[[m, 0]] += density / records as f64;
                        }
                    }
                }
            }
        }
        if !along_time {
            found
                .power
                .mapv_inplace(|p| if counted > 0 { p / variances } else { f64::NAN });
        }
        found.judge(&spreads, highest);
        Ok(found)
    })
}

/// Frequencies on either side of a line that are its own, and that it is compared with.
const OWN: usize = 12;
const SIDE: usize = 60;

impl Lomb {
    /// Unit of the frequencies.
    pub fn unit(&self) -> String {
        let (axis, counted, stepped) = match self.axis {
            LombAxis::Time => (&self.time, "sample", "unit of time"),
            LombAxis::Space => (&self.space, "site", "unit of length"),
        };
        let is_counted = self.steps.iter().all(|step| *step == 1.0);
        let word = axis
            .unit
            .as_deref()
            .unwrap_or(if is_counted { counted } else { stepped });
        crate::measure::cycles_per(word)
    }

    /// How many records have a power above their level.
    pub fn significant(&self) -> usize {
        let pairs = self.peaks.iter().zip(&self.level);
        pairs.filter(|(peak, level)| peak[1] > **level).count()
    }

    /// Records whose largest power is that of a line: above its level, which is that of white noise, and above what
    /// chance exceeds anywhere in all records over the larger of the medians on either side, if power is exponential.
    pub fn lines(&self) -> Vec<usize> {
        let cells = (self.frequency.len() * self.peaks.len()) as f64;
        let least = (cells / self.alpha).ln() / std::f64::consts::LN_2;
        let is_line = |column: &usize| {
            let [at, power, _] = self.peaks[*column];
            let top = self.frequency.iter().position(|f| *f == at);
            let Some(top) = top.filter(|_| power > self.level[*column]) else {
                return false;
            };
            let of = |range: std::ops::Range<usize>| {
                let mut side: Vec<f64> = range.map(|m| self.power[[m, *column]]).collect();
                side.sort_by(f64::total_cmp);
                (side.len() > SIDE / 4).then(|| side[side.len() / 2])
            };
            let last = self.frequency.len();
            let below = of(top.saturating_sub(OWN + SIDE)..top.saturating_sub(OWN));
            let above = of((top + OWN).min(last)..(top + OWN + SIDE).min(last));
            let beside = below.into_iter().chain(above).fold(f64::NAN, f64::max);
            power > least * beside
        };
        (0..self.peaks.len()).filter(is_line).collect()
    }

    /// Levels and largest powers, with the standard deviation of the times of each record.
    fn judge(&mut self, spreads: &[f64], highest: f64) {
        let along_time = self.axis == LombAxis::Time;
        for (column, (samples, spread)) in self.samples.iter().zip(spreads).enumerate() {
            let width = highest * (4.0 * PI).sqrt() * spread;
            let chance = Chance {
                samples: *samples as f64,
                width,
            };
            let column = self.power.column(column);
            let top = (0..column.len()).max_by(|a, b| column[*a].total_cmp(&column[*b]));
            let top = top
                .filter(|m| column[*m].is_finite())
                .map(|m| (self.frequency[m], column[m]));
            let knows = along_time && *samples >= FEWEST;
            self.level.push(if knows {
                chance.level(self.alpha)
            } else {
                f64::NAN
            });
            self.peaks.push(match top {
                Some((f, p)) => [f, p, if knows { chance.of(p) } else { f64::NAN }],
                None => [f64::NAN; 3],
            });
        }
    }
}

/// The probability that white noise has a power anywhere: Baluev's bound.
struct Chance {
    samples: f64,
    /// `f_max sqrt(4 pi var(t))`.
    width: f64,
}

impl Chance {
    fn of(&self, power: f64) -> f64 {
        let (n, z) = (self.samples, power.clamp(0.0, 1.0));
        let single = (1.0 - z).powf(0.5 * (n - 3.0));
        // Gamma(n/2) / Gamma((n-1)/2) with n - 1 degrees of freedom, by sqrt(2/n).
        let half = 0.5 * (n - 1.0);
        let gamma = (1.0 / half).sqrt() * (ln_gamma(half) - ln_gamma(half - 0.5)).exp();
        let tau = gamma * self.width * (1.0 - z).powf(0.5 * (n - 4.0)) * (half * z).sqrt();
        single * (-tau).exp() - (-tau).exp_m1()
    }

    fn level(&self, alpha: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        // The bound falls from its largest value on, at most at 1 / (n - 3).
        low += 1.0 / self.samples;
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            match self.of(middle) > alpha {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}

/// `ln Gamma(x)` for x > 0, by Stirling's series after shifting x above 12 (Abramowitz and Stegun, 6.1.41).
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 12.0 {
        shift += x.ln();
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series =
        (1.0 / 12.0 - inverse * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + series - shift
}

/// The finite samples of a record, less their mean.
struct Record {
    at: Vec<f64>,
    values: Vec<f64>,
    squares: f64,
}

impl Record {
    fn new(at: &[f64], values: &[f64]) -> Record {
        let finite = at.iter().zip(values).filter(|(_, v)| v.is_finite());
        let (at, mut values): (Vec<f64>, Vec<f64>) = finite.map(|(t, v)| (*t, *v)).unzip();
        // Phases are exact to rounding about the middle of the record.
        let middle = match (at.first(), at.last()) {
            (Some(first), Some(last)) => 0.5 * (first + last),
            _ => 0.0,
        };
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter_mut().for_each(|v| *v -= mean);
        let squares = crate::numeric::sum_of_squares(&values);
        // What is left of a constant is rounding.
        let is_constant = values.windows(2).all(|pair| pair[0] == pair[1]);
        Record {
            at: at.iter().map(|t| t - middle).collect(),
            squares: if is_constant { 0.0 } else { squares },
            values,
        }
    }

    /// The standard deviation of the times.
    fn spread(&self) -> f64 {
        let n = self.at.len() as f64;
        let mean = self.at.iter().sum::<f64>() / n;
        (self.at.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n).sqrt()
    }

    /// The powers at `step`, `2 step`, ... in the standard normalisation; 0 for a record without variance.
    fn spectrum(&self, step: f64, count: usize) -> Vec<f64> {
        let n = self.values.len();
        if n < FEWEST || self.squares <= 0.0 {
            return vec![0.0; count];
        }
        let (mut cosine, mut sine) = (vec![0.0; n], vec![0.0; n]);
        let turn = |f: f64, c: &mut [f64], s: &mut [f64]| {
            for ((t, c), s) in self.at.iter().zip(c).zip(s) {
                (*s, *c) = (TAU * (f * t).fract()).sin_cos();
            }
        };
        let (mut dc, mut ds) = (vec![0.0; n], vec![0.0; n]);
        turn(step, &mut dc, &mut ds);
        (0..count)
            .map(|m| {
                if m % RENEWED == 0 {
                    turn((m + 1) as f64 * step, &mut cosine, &mut sine);
                } else {
                    for ((c, s), (dc, ds)) in
                        cosine.iter_mut().zip(&mut sine).zip(dc.iter().zip(&ds))
                    {
                        (*c, *s) = (*c * dc - *s * ds, *s * dc + *c * ds);
                    }
                }
                self.explained(&cosine, &sine)
            })
            .collect()
    }

    /// The share of the variance that a cosine, a sine and a constant explain.
    fn explained(&self, cosine: &[f64], sine: &[f64]) -> f64 {
        // Four sums of each that are added at last: they run side by side.
        let mut sums = [[0.0; 4]; 6];
        let full = self.values.len() / 4 * 4;
        let mut add = |lane: usize, v: f64, c: f64, s: f64| {
            let terms = [c, s, v * c, v * s, c * c, c * s];
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum[lane] += term;
            }
        };
        for i in (0..full).step_by(4) {
            for lane in 0..4 {
                add(
                    lane,
                    self.values[i + lane],
                    cosine[i + lane],
                    sine[i + lane],
                );
            }
        }
        for i in full..self.values.len() {
            add(0, self.values[i], cosine[i], sine[i]);
        }
        let n = self.values.len() as f64;
        let [c, s, yc, ys, cc, cs] = sums.map(|sum| (sum[0] + sum[1] + sum[2] + sum[3]) / n);
        // Values have no mean.
        let (ss, cs, cc) = (1.0 - cc - s * s, cs - c * s, cc - c * c);
        let determinant = cc * ss - cs * cs;
        let explained = ss * yc * yc + cc * ys * ys - 2.0 * cs * yc * ys;
        let squares = self.squares / n;
        match determinant > 1e-12 {
            true => (explained / (determinant * squares)).clamp(0.0, 1.0),
            // At a frequency at which one of both is constant, as at Nyquist, the other is left.
            false if cc + ss > 1e-12 => {
                ((yc * yc + ys * ys) / ((cc + ss) * squares)).clamp(0.0, 1.0)
            }
            false => 0.0,
        }
    }
}
