//! Energies of a measurement and of a run in bands of frequency, and what bounds their ratio.

use serde::Serialize;

use super::super::plan::cosines;
use super::{Pair, TOLD};

/// Fewest periods of the longest wave in the record that bound the lowest band, and most bands.
const PERIODS: f64 = 4.0;
const BANDS: i32 = 8;

/// Share of all energy, measured or of the run, below which a band says nothing; the largest ratio of ends that does.
const SHARE: f64 = 1e-3;
const WIDE: f64 = 1.25;

/// By how much the noise of a band may exceed that of the samples before the fronts.
const MARGIN: f64 = 2.0;

/// A band of frequency, all records together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InBand {
    pub from: f64,
    pub to: f64,
    /// Energies, of the measurement with its noise.
    pub measured: f64,
    pub run: f64,
    /// What noise has at most: the energy of what a run that is as late and as large leaves, or twice that before the fronts.
    pub noise: f64,
    /// The run's energy over that measured without noise: its least and its largest value. NaN where noise hides it.
    pub ratio: [f64; 2],
    /// `(sum Y P)^2 / (sum Y^2 sum P^2)` over records and frequencies.
    pub correlation: f64,
    /// Energy of the difference over that of the measurement, with the noise.
    pub residual: f64,
}

/// Octaves below the highest frequency, the lowest down to 0; none of records at uneven times.
pub(super) fn bands(pair: &Pair) -> Vec<InBand> {
    let (n, step) = (pair.times().len(), pair.records.step());
    let is_even = |at: &[f64]| ((at[1] - at[0]) / step - 1.0).abs() < 1e-6;
    if !pair.times().windows(2).all(is_even) {
        return Vec::new();
    }
    let nyquist = 0.5 / step;
    let count = ((0.5 * n as f64 / PERIODS).log2() as i32).clamp(1, BANDS);
    let edge = |k: i32| match k {
        0 => 0.0,
        k => nyquist * 0.5f64.powi(count - k),
    };
    let ends: Vec<[f64; 2]> = (0..count).map(|k| [edge(k), edge(k + 1)]).collect();
    // Of measurement, run, what is left, measurement times run, difference, and noise before the fronts; and their number.
    let mut sums = vec![[0.0; 7]; ends.len()];
    for site in 0..pair.sites() {
        // Of a late record what both have, so that its ends are no difference.
        let front = pair.differs(site);
        let late = front.filter(|(_, told)| told.is_late);
        let delay = late.map_or(0.0, |(front, _)| front.delay);
        let late = ((delay / step).round() as isize).clamp(1 - n as isize, n as isize - 1);
        let own = late.max(0) as usize..(n as isize + late.min(0)) as usize;
        let of_run = (own.start as isize - late) as usize..(own.end as isize - late) as usize;
        let left = pair.left(site, front.map(|(front, _)| front));
        let [y, p, left, aligned] = [
            &pair.measured(site)[own.clone()],
            &pair.run(site)[of_run],
            &left[own.clone()],
            &pair.run(site)[own.clone()],
        ]
        .map(cosines);
        let variance = pair.noise.sigmas[site].powi(2);
        for k in 0..own.len() {
            let share = k as f64 / own.len() as f64;
            let at = ends.partition_point(|[_, to]| *to <= share * nyquist);
            let Some(sums) = sums.get_mut(at) else {
                continue;
            };
            let quiet = variance * pair.noise.density(0.5 * share);
            let (both, off) = (y[k] * aligned[k], y[k] - aligned[k]);
            let [y, p, left] = [y[k], p[k], left[k]].map(|v| v * v);
            let each = [y, p, left, both, off * off, quiet, 1.0];
            let pairs = sums.iter_mut().zip(each);
            pairs.for_each(|(sum, value)| *sum += value);
        }
    }
    let least = [0, 1].map(|of: usize| SHARE * sums.iter().map(|sums| sums[of]).sum::<f64>());
    let band = |([from, to], sums): ([f64; 2], [f64; 7])| {
        let [measured, run, left, both, residual, quiet, count] = sums;
        let noise = match pair.is_quiet {
            true => left.min(MARGIN * quiet),
            false => left,
        };
        let error = TOLD * 2.0 * (noise / count.max(1.0) * run).sqrt();
        let ratio = [measured + error, measured - noise - error].map(|end| match end > 0.0 {
            true => run / end,
            false => f64::INFINITY,
        });
        let is_seen = measured - noise > least[0] || run > least[1];
        let is_told = ratio[1] < WIDE * ratio[0] || ratio[0] > 1.0 || ratio[1] < 1.0;
        InBand {
            from,
            to,
            measured: step * measured,
            run: step * run,
            noise: step * noise,
            ratio: ratio.map(|end| if is_seen && is_told { end } else { f64::NAN }),
            correlation: both.powi(2) / (measured * run).max(f64::MIN_POSITIVE),
            residual: residual / measured.max(f64::MIN_POSITIVE),
        }
    };
    ends.into_iter().zip(sums).map(band).collect()
}
