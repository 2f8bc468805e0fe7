//! When a wave arrives at a site, how long it is, and what noise lies under it.

use std::ops::Range;
use std::sync::Arc;

use column_fft::{Columns, ColumnsMut, Complex, ComplexToRealColumns, RealToComplexColumns};

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
/// Gaps between beats of one pulse, over the width of its largest.
const BEATS: f64 = 3.0;

/// What a record says about a site.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Onset {
    /// Whether it has energy to speak of, beside other sites.
    pub is_live: bool,
    /// Largest magnitude, from the baseline.
    pub peak: f64,
    /// Mean of the quiet parts, of the whole record where none is quiet.
    pub baseline: f64,
    /// Standard deviation of the quiet parts; `None` where there are none.
    pub noise: Option<f64>,
    /// Standard deviation of the means of the quiet parts: drift, and hum that is slower than they are long.
    pub drift: f64,
    /// Whether some of the quiet parts lie before the peak. Else what is quiet may be the end of the wave.
    pub has_lead: bool,
    /// Quiet samples: those before the peak, if there are some.
    pub quiet: Vec<Range<usize>>,
    /// Logarithms of the mean squares of the pieces, each from its mean.
    pub levels: Vec<f32>,
    /// Logarithms of the root mean squares of the record, from its mean, and of its fourth differences, which noise dominates.
    pub sizes: [f64; 2],
    /// `(sum e)^2 / (n sum e^2)` of the energies of n pieces: 1 for a record that is steady.
    pub steadiness: f64,
    pub arrival: Option<usize>,
    /// Full width at half maximum of the squared envelope, in samples, where it was looked for.
    pub width: Option<f64>,
}

/// How records are read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    /// Samples of a simulation: without noise, from a baseline of 0.
    pub simulated: bool,
    /// Noise that is known, as a standard deviation.
    pub noise: Option<f64>,
}

/// Samples of a piece of a record of `samples`.
pub(crate) fn piece(samples: usize) -> usize {
    samples.div_ceil(PIECES).max(LEAST_PIECE).min(samples)
}

/// Whether each piece of the record is quiet; mean squares of pieces from their means.
fn quiet_pieces(record: &[f64]) -> (Vec<bool>, Vec<f64>) {
    let length = piece(record.len());
    let of_piece = |piece: &[f64]| {
        let n = piece.len() as f64;
        let mean = piece.iter().sum::<f64>() / n;
        piece.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)
    };
    let squares: Vec<f64> = record.chunks_exact(length).map(of_piece).collect();
    let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = record.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let by_chance = 1.0 + 4.0 / (length as f64).sqrt();
    let limit = (ALIKE * ALIKE * by_chance * least).max((SILENT * largest).powi(2));
    (squares.iter().map(|s| *s <= limit).collect(), squares)
}

/// Samples of pieces that are quiet one after the other.
fn runs(quiet: &[bool], length: usize) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (i, _) in quiet.iter().enumerate().filter(|(_, quiet)| **quiet) {
        match found.last_mut().filter(|part| part.end == i * length) {
            Some(part) => part.end += length,
            None => found.push(i * length..(i + 1) * length),
        }
    }
    found
}

fn sizes(record: &[f64]) -> [f64; 2] {
    let n = record.len() as f64;
    let mean = record.iter().sum::<f64>() / n;
    let motion: f64 = record.iter().map(|v| (v - mean).powi(2)).sum();
    let fast = record
        .windows(5)
        .map(|v| v[0] - 4.0 * v[1] + 6.0 * v[2] - 4.0 * v[3] + v[4]);
    let fast: f64 = fast.map(|d| d * d).sum();
    [motion, fast].map(|squares| 0.5 * (squares / n).ln())
}

impl Onset {
    pub(super) fn of(record: &[f64], how: Reading) -> Onset {
        let length = piece(record.len());
        let (quiet, squares) = quiet_pieces(record);
        let many = quiet.iter().filter(|q| **q).count();
        let is_known = many as f64 >= QUIET_PART * quiet.len() as f64 && many >= 2;
        let pieces = record.chunks_exact(length).zip(&quiet);
        let mean = |samples: &mut dyn Iterator<Item = &f64>| {
            let (sum, count) = samples.fold((0.0, 0usize), |(s, n), v| (s + v, n + 1));
            sum / count.max(1) as f64
        };
        let baseline = match (how.simulated, is_known) {
            (true, _) => 0.0,
            (false, true) => mean(&mut pieces.filter(|(_, q)| **q).flat_map(|(p, _)| p)),
            (false, false) => mean(&mut record.iter()),
        };
        let noise = match how {
            Reading {
                noise: Some(known), ..
            } => Some(known),
            Reading {
                simulated: true, ..
            } => Some(0.0),
            _ => is_known.then(|| {
                let squares = squares.iter().zip(&quiet).filter(|(_, q)| **q);
                (squares.map(|(s, _)| s).sum::<f64>() / many as f64).sqrt()
            }),
        };
        let drift = match how.simulated || !is_known {
            true => 0.0,
            false => {
                let quiet = record.chunks_exact(length).zip(&quiet).filter(|(_, q)| **q);
                let off = quiet.map(|(p, _)| (mean(&mut p.iter()) - baseline).powi(2));
                (off.sum::<f64>() / many as f64).sqrt()
            }
        };
        let (at, peak) = record
            .iter()
            .enumerate()
            .fold((0, 0.0), |(at, most), (n, v)| {
                let v = (v - baseline).abs();
                if v > most { (n, v) } else { (at, most) }
            });
        // What the mean of a constant record differs by from it is rounding.
        let peak = if peak > ROUNDING * baseline.abs() {
            peak
        } else {
            0.0
        };
        let levels = squares.iter().map(|s| s.ln() as f32).collect();
        let before = (at / length).min(quiet.len());
        let has_lead = quiet[..before].contains(&true);
        let parts = if has_lead {
            &quiet[..before]
        } else {
            &quiet[..]
        };
        let energies = record.chunks_exact(length);
        let energies = energies.map(|p| p.iter().map(|v| (v - baseline).powi(2)).sum::<f64>());
        let (sum, squares) = energies.fold((0.0, 0.0), |(s, q), e| (s + e, q + e * e));
        let mut onset = Onset {
            levels,
            sizes: sizes(record),
            peak,
            baseline,
            noise,
            drift,
            has_lead,
            quiet: if is_known {
                runs(parts, length)
            } else {
                Vec::new()
            },
            steadiness: match squares > 0.0 {
                true => sum * sum / squares / quiet.len() as f64,
                false => f64::NAN,
            },
            ..Onset::default()
        };
        onset.arrival = onset.noise.and_then(|noise| onset.arrives(record, noise));
        onset
    }

    /// The first sample above five times the noise and a part of the largest magnitude; `None` where nothing rises far above
    /// the noise.
    pub fn arrives(&self, record: &[f64], noise: f64) -> Option<usize> {
        let rest = noise.hypot(self.drift);
        if self.peak <= REACHED * rest || self.peak == 0.0 {
            return None;
        }
        let threshold = (ARRIVES * rest).max(ONSET * self.peak);
        record
            .iter()
            .position(|v| (v - self.baseline).abs() > threshold)
    }

    /// The first sample of what comes after the first pulse of `width` samples and after quiet behind it: `None` where
    /// nothing does. Small reflections count from a fiftieth of the energy on.
    pub fn second(&self, record: &[f64], arrival: usize, width: f64) -> Option<usize> {
        let noise = self.noise.unwrap_or(0.0);
        let w = (width.round() as usize).clamp(1, record.len());
        let mut sums = Vec::with_capacity(record.len() + 1);
        sums.push(0.0);
        for v in record {
            sums.push(sums[sums.len() - 1] + (v - self.baseline).powi(2));
        }
        let last = record.len() - w;
        let energy = |n: usize| (sums[n + w] - sums[n]) / w as f64;
        let near = arrival.min(last)..(arrival + 3 * w).min(last) + 1;
        let first = near.max_by(|&a, &b| energy(a).total_cmp(&energy(b)))?;
        let floor = noise * noise;
        let low = (0.01 * energy(first)).max(2.0 * floor);
        let high = (0.02 * energy(first)).max(4.0 * floor);
        let quiet = (first..=last).find(|&n| energy(n) < low)?;
        (quiet..=last)
            .find(|&n| energy(n) > high)
            .map(|n| n + w / 2)
    }
}

/// Squared envelopes of records of one length: `|v + i H v|^2` with the Hilbert transform H.
pub(super) struct Envelopes {
    length: usize,
    forward: Arc<RealToComplexColumns<f64>>,
    inverse: ComplexToRealColumns<f64>,
}

impl Envelopes {
    pub fn new(length: usize) -> Envelopes {
        let padded = super::quick(length);
        let forward = Arc::new(RealToComplexColumns::new(padded).expect("at least one sample"));
        Envelopes {
            length,
            inverse: ComplexToRealColumns::of(Arc::clone(&forward)).normalized(),
            forward,
        }
    }

    /// Full width at half maximum of the squared envelope around its peak, in samples; if it beats, to where it is that
    /// high for the last time.
    pub fn width(&self, record: &[f64], baseline: f64, beats: bool) -> f64 {
        let n = self.forward.len();
        let mut values: Vec<f64> = record.iter().map(|v| v - baseline).collect();
        values.resize(n, 0.0);
        let mut spectrum = vec![Complex::default(); self.inverse.bins()];
        let input = Columns::new(&values, n, 1, 1).expect("one column");
        let output = ColumnsMut::new(&mut spectrum, self.inverse.bins(), 1, 1).expect("one column");
        self.forward.process(input, output).expect("as planned");
        for x in &mut spectrum {
            *x *= Complex::new(0.0, -1.0);
        }
        let mut quadrature = vec![0.0; n];
        let input = Columns::new(&spectrum, self.inverse.bins(), 1, 1).expect("one column");
        let output = ColumnsMut::new(&mut quadrature, n, 1, 1).expect("one column");
        self.inverse.process(input, output).expect("as planned");
        let pairs = values.iter().zip(&quadrature).take(self.length);
        let squared: Vec<f64> = pairs.map(|(v, h)| v * v + h * h).collect();
        let peak = (0..squared.len()).max_by(|&a, &b| squared[a].total_cmp(&squared[b]));
        let Some(peak) = peak else { return 0.0 };
        let half = 0.5 * squared[peak];
        let near = |side: &mut dyn Iterator<Item = &f64>| side.take_while(|e| **e > half).count();
        let (after, before) = (
            near(&mut squared[peak..].iter()),
            near(&mut squared[..peak].iter().rev()),
        );
        let width = before + after;
        if !beats {
            return width as f64;
        }
        let gap = (BEATS * width as f64) as usize;
        let far = |side: &mut dyn Iterator<Item = &f64>| {
            // The envelope of a burst of noise is one of spikes: it goes on over gaps as long as what it has held so far.
            let (mut last, mut held) = (0, 0);
            for (n, e) in side.enumerate() {
                if *e > half {
                    last = n + 1;
                }
                if *e > 0.5 * half {
                    held = n + 1;
                } else if n > held + gap.max(held) {
                    break;
                }
            }
            last
        };
        let (after, before) = (
            far(&mut squared[peak..].iter()),
            far(&mut squared[..peak].iter().rev()),
        );
        (before + after) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    const MEASURED: Reading = Reading {
        simulated: false,
        noise: None,
    };

    fn noise(level: f64, samples: usize, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        (0..samples).map(|_| level * random.normal()).collect()
    }

    /// A Gaussian of width s in noise of a hundredth: it arrives where exp(-x^2 / 2) = 0.05, the squared envelope is half as
    /// high over 2 s sqrt(ln 2).
    #[test]
    fn val_a_pulse_in_noise() {
        let (samples, at, s) = (4000, 2000.0, 40.0);
        let pulse =
            |n: usize| (-0.5 * ((n as f64 - at) / s).powi(2)).exp() * (n as f64 * 0.7).cos();
        let mut record = noise(0.01, samples, 7);
        for (n, v) in record.iter_mut().enumerate() {
            *v += 3.0 + pulse(n);
        }
        let onset = Onset::of(&record, MEASURED);
        assert!((onset.baseline - 3.0).abs() < 1e-3, "{onset:?}");
        assert!(
            (onset.noise.unwrap() / 0.01 - 1.0).abs() < 0.05,
            "{onset:?}"
        );
        let early = at - s * (2.0 * (1.0f64 / 0.05).ln()).sqrt();
        let arrival = onset.arrival.unwrap() as f64;
        assert!((arrival - early).abs() < 12.0, "{arrival} {early}");
        let width = Envelopes::new(samples).width(&record, onset.baseline, true);
        let exact = 2.0 * s * 2f64.ln().sqrt();
        assert!((width / exact - 1.0).abs() < 0.05, "{width} {exact}");
        assert!(onset.steadiness < 0.15);
    }

    #[test]
    fn val_noise_has_no_arrival_and_is_steady() {
        for seed in 0..50 {
            let onset = Onset::of(&noise(2.0, 4096, seed), MEASURED);
            assert_eq!(onset.arrival, None, "{onset:?}");
            assert!(onset.steadiness > 0.9, "{onset:?}");
        }
    }
}
