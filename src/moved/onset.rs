//! When a wave arrives at a site, how long it is, and what noise lies under it.

use std::ops::Range;

use super::along_x::Options;

/// Pieces that a record is cut into to find its quiet parts, at most, and samples of one at least.
const PIECES: usize = 32;
const LEAST_PIECE: usize = 8;
/// Part of the pieces that must be alike and quietest for their noise to be that of the record.
const QUIET_PART: f64 = 3.0 / 32.0;
/// Pieces count as quiet whose root mean square is below this many times the least, but for chance.
const ALIKE: f64 = 1.3;
/// Magnitude from the baseline, as a part of it, up to which a record is constant.
const ROUNDING: f64 = 1e-13;
/// Amplitudes, as a part of the record's largest, that are quiet whatever the noise.
const SILENT: f64 = 1e-3;
/// Times the noise that an arrival exceeds, and that the largest amplitude of a site reached does.
const ARRIVES: f64 = 5.0;
pub(super) const REACHED: f64 = 8.0;
/// Part of the largest amplitude that an arrival exceeds for the first time.
const ONSET: f64 = 0.03;
/// Part of the energy of a long stretch that a short one holds where the pulse is as long as this: that of a Gaussian within the half
/// maximum of its squared envelope is 0.76.
const HELD: f64 = 0.75;

/// What a record says about a site.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Onset {
    /// Whether it has energy to speak of, beside other sites.
    pub is_live: bool,
    /// Largest magnitude, from the baseline.
    pub peak: f64,
    pub mean: f64,
    /// Mean of the quiet parts, of the whole record where none is quiet.
    pub baseline: f64,
    /// Standard deviation of the quiet parts from the baseline; `None` where there are none.
    pub noise: Option<f64>,
    /// Quiet samples: those before the peak, if there are some.
    pub quiet: Vec<Range<usize>>,
    /// Logarithms of the mean squares of the pieces, each from its mean.
    pub levels: Vec<f32>,
    /// Logarithm of the root mean square of the record, from its mean.
    pub size: f64,
    /// `(sum e)^2 / (n sum e^2)` of the energies of n pieces: 1 for a record that is steady.
    pub steadiness: f64,
    pub arrival: Option<usize>,
    /// Of the pulse, in samples, where it was looked for.
    pub width: Option<f64>,
}

/// Samples of a piece of a record of `samples`.
pub(crate) fn piece(samples: usize) -> usize {
    samples.div_ceil(PIECES).max(LEAST_PIECE).min(samples)
}

/// Mean, and mean square from it.
fn moments(samples: &[f64]) -> [f64; 2] {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    [
        mean,
        samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n,
    ]
}

impl Onset {
    pub(super) fn of(record: &[f64], how: &Options) -> Onset {
        let length = piece(record.len());
        let pieces: Vec<[f64; 2]> = record.chunks_exact(length).map(moments).collect();
        let least = pieces
            .iter()
            .fold(f64::INFINITY, |least, of| least.min(of[1]));
        let [whole, motion] = moments(record);
        let largest = record.iter().fold(0.0f64, |m, v| m.max((v - whole).abs()));
        let by_chance = 1.0 + 4.0 / (length as f64).sqrt();
        let limit = (ALIKE * ALIKE * by_chance * least).max((SILENT * largest).powi(2));
        let is_quiet = |i: &usize| pieces[*i][1] <= limit;
        let quiet: Vec<usize> = (0..pieces.len()).filter(is_quiet).collect();
        let is_known = quiet.len() as f64 >= QUIET_PART * pieces.len() as f64 && quiet.len() >= 2;
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| {
            quiet.iter().map(|&i| of(&pieces[i])).sum::<f64>() / quiet.len() as f64
        };
        let baseline = match (how.is_simulated(), is_known) {
            (true, _) => 0.0,
            (false, true) => mean(&|[mean, _]| *mean),
            (false, false) => whole,
        };
        let from_baseline = |[mean, square]: &[f64; 2]| square + (mean - baseline).powi(2);
        let noise = match how.is_simulated() {
            true => Some(0.0),
            false => is_known.then(|| mean(&from_baseline).sqrt()),
        };
        let size = |n: &usize| (record[*n] - baseline).abs();
        let at = (0..record.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let at = at.unwrap_or(0);
        let is_motion = |peak: &f64| *peak > ROUNDING * baseline.abs();
        let before = quiet.partition_point(|&i| i < at / length);
        let parts = match (is_known, before) {
            (false, _) => &[],
            (true, 0) => &quiet[..],
            (true, before) => &quiet[..before],
        };
        let energies = pieces.iter().map(from_baseline);
        let (sum, squares) = energies.fold((0.0, 0.0), |(s, q), e| (s + e, q + e * e));
        let mut onset = Onset {
            levels: pieces.iter().map(|of| of[1].ln() as f32).collect(),
            size: 0.5 * motion.ln(),
            // What the mean of a constant record differs by from it is rounding.
            peak: Some(size(&at)).filter(is_motion).unwrap_or(0.0),
            mean: whole,
            baseline,
            noise: how.noise.or(noise),
            quiet: parts
                .chunk_by(|a, b| a + 1 == *b)
                .map(|run| run[0] * length..(run[run.len() - 1] + 1) * length)
                .collect(),
            steadiness: sum * sum / squares / pieces.len() as f64,
            ..Onset::default()
        };
        onset.arrival = onset.noise.and_then(|noise| onset.arrives(record, noise));
        onset
    }

    /// The first sample above five times the noise and a part of the largest magnitude; `None` where nothing rises far above
    /// the noise.
    pub fn arrives(&self, record: &[f64], noise: f64) -> Option<usize> {
        let threshold = (ARRIVES * noise).max(ONSET * self.peak);
        let is_above = |v: &f64| (v - self.baseline).abs() > threshold;
        let is_reached = self.peak > REACHED * noise && self.peak > 0.0;
        record.iter().position(is_above).filter(|_| is_reached)
    }

    /// `sum_{i < n} (v_i - baseline)^2 - noise^2` for each n.
    pub fn energies(&self, record: &[f64]) -> Vec<f64> {
        let floor = self.noise.unwrap_or(0.0).powi(2);
        let squares = record.iter().map(|v| (v - self.baseline).powi(2) - floor);
        let sums = squares.scan(0.0, |sum, square| {
            *sum += square;
            Some(*sum)
        });
        std::iter::once(0.0).chain(sums).collect()
    }

    /// The length of the shortest stretch that holds three quarters of the energy of a stretch so many `times` as long.
    pub fn width_of(&self, record: &[f64], times: usize) -> f64 {
        let sums = self.energies(record);
        let most = |samples: usize| {
            let samples = samples.min(record.len());
            let stretches = sums.iter().zip(&sums[samples..]);
            stretches.map(|(a, b)| b - a).fold(0.0, f64::max)
        };
        let grows = |samples: &usize| Some((samples + 1 + samples / 32).min(record.len()));
        let mut lengths = std::iter::successors(Some(1), grows).take_while(|n| *n < record.len());
        let found = lengths.find(|&n| most(n) >= HELD * most(times * n));
        found.unwrap_or(record.len()) as f64
    }

    /// The first sample of what comes after the first pulse of `width` samples and after quiet behind it: `None` where
    /// nothing does. Small reflections count from a fiftieth of the energy on.
    pub fn second(&self, record: &[f64], arrival: usize, width: f64) -> Option<usize> {
        let w = (width.round() as usize).clamp(1, record.len());
        let sums = self.energies(record);
        let last = record.len() - w;
        let energy = |n: usize| sums[n + w] - sums[n];
        let near = arrival.min(last)..(arrival + 3 * w).min(last) + 1;
        let first = near.max_by(|&a, &b| energy(a).total_cmp(&energy(b)))?;
        let floor = self.noise.unwrap_or(0.0).powi(2) * w as f64;
        let low = (0.01 * energy(first)).max(floor);
        let high = (0.02 * energy(first)).max(3.0 * floor);
        let quiet = (first..=last).find(|&n| energy(n) < low)?;
        let second = (quiet..=last).find(|&n| energy(n) > high);
        second.map(|n| n + w / 2)
    }
}
