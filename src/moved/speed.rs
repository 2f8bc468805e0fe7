//! How fast fronts travel.

use super::Speed;
use super::windows::Spectrum;
use crate::estimates::SIGNIFICANCE;
use crate::numeric::student_two_sided;

/// Sites that a speed is found from, at least.
const SITES: usize = 4;

/// Share of the energy below which an interval of frequencies has no group delay.
const LEAST: f64 = 1e-6;
/// Standard deviations of the noise by which energy exceeds it.
const SURE: f64 = 2.0;

/// Bands of equal weight whose speeds are compared.
const BANDS: usize = 4;

/// A front at a site: its window begins at the sample `start`.
pub(super) struct Passage<'a> {
    pub site: usize,
    pub start: usize,
    pub spectrum: &'a Spectrum,
    /// Bins that count as one.
    pub padding: f64,
}

/// The speed of fronts by the group delays in their windows, averaged over frequencies.
///
/// The weights are the same at all sites, the harmonic mean of their shares. So the times do not move where energy does: the
/// centroid of a burst shifts where its harmonics grow. Bands that say another speed, by dispersion or since they
/// interfere, widen the interval.
pub(super) fn of_windows(passages: &[Passage], scale: f64) -> Option<Speed> {
    let mut sums = vec![0.0; passages.first()?.spectrum.energy.len()];
    for passage in passages {
        let Spectrum { energy, noise, .. } = passage.spectrum;
        let all: f64 = energy.iter().sum();
        // What noise may be has no delay.
        let sure = energy.iter().zip(noise).map(|(e, n)| {
            let variance = (2.0 * n * e.max(0.0) + n * n) * passage.padding;
            e - SURE * variance.sqrt()
        });
        for (sum, e) in sums.iter_mut().zip(sure) {
            *sum += match e > LEAST * all {
                true => all / e,
                false => f64::INFINITY,
            };
        }
    }
    let weights: Vec<f64> = sums.iter().map(|sum| 1.0 / sum).collect();
    let all: f64 = weights.iter().sum();
    // The time of passage in the intervals of a band.
    let points = |band: std::ops::Range<usize>| -> Vec<(f64, f64)> {
        let share: f64 = weights[band.clone()].iter().sum();
        let time = |passage: &Passage| {
            let Spectrum { energy, delay, .. } = passage.spectrum;
            let parts = band.clone().filter(|&m| weights[m] > 0.0);
            let sum: f64 = parts.map(|m| weights[m] * delay[m] / energy[m]).sum();
            (passage.site as f64, passage.start as f64 + sum / share)
        };
        passages.iter().map(time).collect()
    };
    let mut speed = speed(&points(0..weights.len()), scale)?;
    let mut ends = vec![0];
    let mut sum = 0.0;
    for (m, weight) in weights.iter().enumerate() {
        sum += weight / all;
        if sum * BANDS as f64 >= ends.len() as f64 - 1e-9 {
            ends.push(m + 1);
        }
    }
    let bands = ends.windows(2).filter(|ends| ends[0] < ends[1]);
    let off = bands.map(|ends| {
        let (slowness, bound) = slope(&points(ends[0]..ends[1]));
        // What noise does to a band does not count.
        ((slowness - scale / speed.value).powi(2) - (0.5 * bound).powi(2)).max(0.0)
    });
    let off: Vec<f64> = off.filter(|off| off.is_finite()).collect();
    let spread = 1.96 * (off.iter().sum::<f64>() / off.len().max(1) as f64).sqrt();
    let spread = speed.value * speed.value / scale.abs() * spread;
    speed.error = speed.error.hypot(spread);
    (speed.value.abs() > 2.0 * speed.error).then_some(speed)
}

/// The slope of values over x by least squares, and half its 95 % interval. What is left of a value follows its neighbours: it
/// counts by its correlation from site to site.
pub(super) fn slope(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (sx, st) = points
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, t)| (a + x, b + t));
    let (mx, mt) = (sx / n, st / n);
    let (xx, xt) = points.iter().fold((0.0, 0.0), |(a, b), (x, t)| {
        (a + (x - mx).powi(2), b + (x - mx) * (t - mt))
    });
    let slowness = xt / xx;
    let left: Vec<f64> = points
        .iter()
        .map(|(x, t)| t - mt - slowness * (x - mx))
        .collect();
    let squares: f64 = left.iter().map(|r| r * r).sum();
    let products: f64 = left.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let follows = match squares > 0.0 {
        true => (products / squares).clamp(0.0, 0.95),
        false => 0.0,
    };
    let error = (squares / (n - 2.0) / xx * (1.0 + follows) / (1.0 - follows)).sqrt();
    (slowness, student_two_sided(SIGNIFICANCE, n - 2.0) * error)
}

/// The speed of what passes at these `(site, sample)`, with its 95 % interval, in units of length over units of time; `scale` is
/// a site a sample.
pub(super) fn speed(points: &[(f64, f64)], scale: f64) -> Option<Speed> {
    if points.len() < SITES {
        return None;
    }
    let (slowness, bound) = slope(points);
    // A tenth of a sample over the array is not told.
    let far = points[points.len() - 1].0 - points[0].0;
    let bound = bound.max(0.1 / (0.3 * far.abs() * points.len() as f64));
    if slowness.abs() <= 2.0 * bound || !slowness.is_finite() {
        return None;
    }
    Some(Speed {
        value: scale / slowness,
        error: scale.abs() * bound / (slowness * slowness),
    })
}
