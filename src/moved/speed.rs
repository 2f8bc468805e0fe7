//! How fast fronts travel.

use super::Speed;
use super::windows::Spectrum;
use crate::estimates::SIGNIFICANCE;
use crate::numeric::LineFit;

/// Sites that a speed is found from, at least, and the error of a passage, in samples, that is not told.
const SITES: usize = 4;
const UNSEEN: f64 = 0.3;
/// Standard errors by which energy exceeds the noise where it has a group delay.
const SURE: f64 = 2.0;
/// Bands of equal weight whose speeds are compared.
const BANDS: usize = 4;

/// A front at a site: its window begins at the sample `start`.
pub(super) struct Passage<'a> {
    pub site: usize,
    pub start: usize,
    pub spectrum: &'a Spectrum,
}

/// The speed of fronts by the group delays in their windows, averaged over frequencies; `scale` is a site a sample.
///
/// The weights are the same at all sites, the harmonic mean of their shares. So the times do not move where energy does: the
/// centroid of a burst shifts where its harmonics grow. Bands that say another speed, by dispersion or since they
/// interfere, widen the interval.
pub(super) fn of_windows(passages: &[Passage], scale: f64) -> Option<Speed> {
    let mut sums = vec![0.0; passages.first()?.spectrum.energy.len()];
    for Passage { spectrum, .. } in passages {
        let all: f64 = spectrum.energy.iter().sum();
        for (m, sum) in sums.iter_mut().enumerate() {
            // What noise may be has no delay.
            let (e, error) = (spectrum.energy[m], spectrum.noise[m].sqrt());
            *sum += all / (e - SURE * error).max(0.0);
        }
    }
    let weights: Vec<f64> = sums.iter().map(|sum| 1.0 / sum).collect();
    // The time of passage in some of the intervals.
    let points = |of: &dyn Fn(usize) -> bool| -> Vec<(f64, f64)> {
        let band = (0..weights.len()).filter(|&m| weights[m] > 0.0 && of(m));
        let share: f64 = band.clone().map(|m| weights[m]).sum();
        let time = |of: &Passage| {
            let Spectrum { energy, delay, .. } = of.spectrum;
            let parts = band.clone().map(|m| weights[m] * delay[m] / energy[m]);
            (of.site as f64, of.start as f64 + parts.sum::<f64>() / share)
        };
        passages.iter().map(time).collect()
    };
    let speed = speed(&points(&|_| true), scale)?;
    let all: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let bands = weights.iter().map(|weight| {
        sum += weight / all * BANDS as f64;
        (sum - 1e-9) as usize
    });
    let bands: Vec<usize> = bands.collect();
    let off = (0..BANDS).filter_map(|band| {
        let [slowness, bound] = slope(&points(&|m| bands[m] == band))?;
        // What noise does to a band does not count.
        let off = (slowness - scale / speed.value).powi(2) - (0.5 * bound).powi(2);
        off.is_finite().then_some(off.max(0.0))
    });
    let off: Vec<f64> = off.collect();
    let spread = 1.96 * (off.iter().sum::<f64>() / off.len().max(1) as f64).sqrt();
    let error = speed
        .error
        .hypot(speed.value * speed.value / scale.abs() * spread);
    (speed.value.abs() > 2.0 * error).then_some(Speed { error, ..speed })
}

/// Slope of values over x by least squares, and half its 95 % interval. What is left of a value follows its neighbours: points
/// count by its correlation.
pub(super) fn slope(points: &[(f64, f64)]) -> Option<[f64; 2]> {
    let fit = LineFit::through(points)?;
    let left = |(x, y): &(f64, f64)| y - fit.intercept - fit.slope * x;
    let left: Vec<f64> = points.iter().map(left).collect();
    let products: f64 = left.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let follows = match fit.squares > 0.0 {
        true => (products / fit.squares).clamp(0.0, 0.95),
        false => 0.0,
    };
    let shared = (1.0 + follows) / (1.0 - follows);
    Some([fit.slope, fit.half_interval(SIGNIFICANCE) * shared.sqrt()])
}

/// Of what passes at these `(site, sample)`.
pub(super) fn speed(points: &[(f64, f64)], scale: f64) -> Option<Speed> {
    let [slowness, error] = slope(points).filter(|_| points.len() >= SITES)?;
    let far = points[points.len() - 1].0 - points[0].0;
    let error = error.max(UNSEEN / (far.abs() * points.len() as f64));
    (slowness.abs() > 2.0 * error).then(|| Speed {
        value: scale / slowness,
        error: scale.abs() * error / (slowness * slowness),
    })
}
