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
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
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

#[derive(Clone, Default)]
struct Sums {
    both: f64,
    residual: f64,
    count: f64,
    /// As before the fronts.
    quiet: f64,
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
    let edge = |k: i32| {
        if k == 0 {
            0.0
        } else {
            nyquist * 0.5f64.powi(count - k)
        }
    };
    let mut bands: Vec<(InBand, Sums)> = (0..count)
        .map(|k| {
            let band = InBand {
                from: edge(k),
                to: edge(k + 1),
                ..InBand::default()
            };
            (band, Sums::default())
        })
        .collect();
    for site in 0..pair.sites() {
        // Of a late record what both have, so that its ends are no difference.
        let front = pair.differs(site);
        let delay = front.map_or(
            0.0,
            |(front, told)| if told.is_late { front.delay } else { 0.0 },
        );
        let late = ((delay / step).round() as isize).clamp(1 - n as isize, n as isize - 1);
        let own = late.max(0) as usize..(n as isize + late.min(0)) as usize;
        let of_run = (own.start as isize - late) as usize..(own.end as isize - late) as usize;
        let left = pair.left(site, front.map(|(front, _)| front));
        let spectra = [
            &pair.measured(site)[own.clone()],
            &pair.run(site)[of_run],
            &left[own.clone()],
        ]
        .map(cosines);
        let aligned = cosines(&pair.run(site)[own.clone()]);
        let length = own.len() as f64;
        for k in 0..own.len() {
            let frequency = k as f64 / length * nyquist;
            let at = bands.partition_point(|(band, _)| band.to <= frequency);
            let Some((band, sums)) = bands.get_mut(at) else {
                continue;
            };
            let [y, p, left] = [0, 1, 2].map(|i: usize| spectra[i][k]);
            band.measured += y * y;
            band.run += p * p;
            band.noise += left * left;
            sums.both += y * aligned[k];
            sums.residual += (y - aligned[k]).powi(2);
            sums.count += 1.0;
            sums.quiet +=
                pair.noise.sigmas[site].powi(2) * pair.noise.density(0.5 * k as f64 / length);
        }
    }
    for (band, sums) in bands.iter_mut().filter(|_| pair.is_quiet) {
        band.noise = band.noise.min(MARGIN * sums.quiet);
    }
    let most = |of: fn(&InBand) -> f64| bands.iter().map(|(band, _)| of(band)).sum::<f64>();
    let least = [
        SHARE * most(|band| band.measured),
        SHARE * most(|band| band.run),
    ];
    let whole = bands.into_iter().map(|(band, sums)| {
        let error = TOLD * 2.0 * (band.noise / sums.count.max(1.0) * band.run).sqrt();
        let ends = [band.measured + error, band.measured - band.noise - error];
        let is_seen = band.measured - band.noise > least[0] || band.run > least[1];
        let ratio = ends.map(|end| {
            if end > 0.0 {
                band.run / end
            } else {
                f64::INFINITY
            }
        });
        let is_told = ratio[1] < WIDE * ratio[0] || ratio[0] > 1.0 || ratio[1] < 1.0;
        InBand {
            measured: step * band.measured,
            run: step * band.run,
            noise: step * band.noise,
            ratio: if is_seen && is_told {
                ratio
            } else {
                [f64::NAN; 2]
            },
            correlation: sums.both.powi(2) / (band.measured * band.run).max(f64::MIN_POSITIVE),
            residual: sums.residual / band.measured.max(f64::MIN_POSITIVE),
            ..band
        }
    });
    whole.collect()
}
