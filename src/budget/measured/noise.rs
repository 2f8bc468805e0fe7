//! Noise and drift of each channel, from its record before the wave arrives.
//!
//! A channel is taken as `v + b + s t + noise`, t from the start of the motion, with white noise of
//! deviation sigma. sigma, b and s come from a straight line through the quiet part. A short quiet
//! part determines b poorly and s worse, so the other channels serve as prior: b and s are normal
//! with the variance over all channels (less the part due to noise, plus its standard error). The
//! posterior covariance of b and s is propagated. Noise that is correlated from sample to sample
//! integrates to more than white noise of the same deviation, so sigma is then multiplied by the
//! root of the correlation time.

use ndarray::ArrayView2;

use super::drift::{Drifting, line_through, spread_of, variance};
use super::quiet::{QuietPart, quiet_part};
use super::{Drift, MeasuredOptions, Noise};
use crate::error::{Error, Result};
use crate::numeric::LineFit;

/// Fewest quiet samples from which a channel's own noise is estimated.
pub(super) const LEAST_QUIET: usize = 32;

/// Lags over which noise may be correlated.
const LAGS: usize = 8;

/// Share of the largest velocity below which samples are no noise.
const ROUNDING: f64 = 1e-12;

/// Share of the largest velocity below which noise is negligible. A site is then not taken to be at
/// rest, which would cut the foot of the wave for nothing.
const CLEAN: f64 = 1e-6;

/// Share of the largest velocity above which a steady level is a site in flight, not an offset.
const FLIGHT: f64 = 0.2;

/// Noise and drift of a channel.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct SiteNoise {
    /// Sample of the record at which the wave arrives; `None` where it does not.
    pub arrival: Option<usize>,
    /// Samples before that, up to the foot of the wave.
    pub quiet_samples: usize,
    /// Samples from the first during which the site is taken to be at rest.
    pub rest_samples: usize,
    /// Standard deviation of the noise.
    pub deviation: f64,
    /// Whether it is that of the other channels, for want of a quiet part.
    pub borrowed: bool,
    /// Offset and slope that were taken off, and the standard errors of what remains of them.
    pub offset: f64,
    pub offset_error: f64,
    pub slope: f64,
    pub slope_error: f64,
    #[serde(skip)]
    pub(super) covariance: f64,
}

/// Noise and drift of all channels.
#[derive(Debug, Clone)]
pub(super) struct Channels {
    pub(super) sites: Vec<SiteNoise>,
    /// Correlation time of the noise in samples; 1 if white.
    pub(super) correlation: f64,
}

impl Channels {
    /// From a record `(time, site)`; `missing` channels have nothing.
    ///
    /// # Errors
    /// [`Error::Request`] where no channel has a quiet part.
    pub(super) fn of(
        record: ArrayView2<f64>,
        missing: &[bool],
        options: &MeasuredOptions,
    ) -> Result<Channels> {
        if let Noise::Stated { deviation, offset } = options.noise {
            let site = SiteNoise {
                deviation,
                offset_error: offset,
                ..SiteNoise::default()
            };
            return Ok(Channels {
                sites: vec![site; record.ncols()],
                correlation: 1.0,
            });
        }
        let columns: Vec<Vec<f64>> = record.columns().into_iter().map(|c| c.to_vec()).collect();
        let scale = record.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let quiet = columns.iter().map(|column| {
            let quiet = quiet_part(column);
            let level = column[..quiet.samples].iter().sum::<f64>().abs();
            match level > FLIGHT * scale * quiet.samples as f64 {
                true => QuietPart::NONE,
                false => quiet,
            }
        });
        let quiet: Vec<QuietPart> = quiet.collect();
        let part = |j: usize| &columns[j][..quiet[j].samples];
        let all = 0..columns.len();
        let line = |j| line_through(part(j), options.start);
        let lines: Vec<Option<LineFit>> = all.clone().map(line).collect();
        let live = |j: &usize| !missing[*j];
        let own = |j: &usize| live(j) && quiet[*j].samples >= LEAST_QUIET;
        let known = all.clone().filter(own);
        let known: Vec<(usize, LineFit)> = known.filter_map(|j| Some((j, lines[j]?))).collect();
        let longest = all.clone().filter(live).map(|j| quiet[j].samples).max();
        let expected = format!(
            "a channel with {LEAST_QUIET} samples or more before the wave arrives, or stated noise"
        );
        let found = format!("at most {} of {}", longest.unwrap_or(0), record.nrows());
        Error::require(!known.is_empty(), "noise", expected, found)?;
        let parts = known.iter();
        let parts = parts.map(|(j, line)| (part(*j), *line, options.start));
        let correlation = correlation_time(parts, scale);
        let sum = |of: fn(&LineFit) -> f64| known.iter().map(|(_, line)| of(line)).sum::<f64>();
        let pooled = sum(|line| line.squares) / sum(|line| line.points as f64 - 2.0);
        // Of values with the squares of their errors, in units of the variance of the noise.
        let spread = |of: &dyn Fn(&LineFit) -> [f64; 2]| {
            let values = known.iter().map(|(_, line)| {
                let [value, share] = of(line);
                (value, correlation * variance(line) * share)
            });
            spread_of(values.collect())
        };
        let offset_share = |l: &LineFit| 1.0 / l.points as f64 + l.middle * l.middle / l.spread;
        let offsets = || spread(&|line| [line.intercept, offset_share(line)]);
        let slopes = || spread(&|line| [line.slope, 1.0 / line.spread]);
        let prior = match options.drift {
            Drift::None => [0.0; 2],
            Drift::Constant => [offsets(), 0.0],
            Drift::Linear => [offsets(), slopes()],
        };
        let sites = all.map(|j| {
            let line = lines[j].filter(|_| live(&j));
            let own_line = line.as_ref().filter(|_| own(&j));
            let variance = own_line.map_or(pooled, variance);
            let drift = Drifting::of(line, correlation * variance, prior);
            let [offset_variance, covariance, slope_variance] = drift.covariance;
            SiteNoise {
                arrival: quiet[j].arrival.filter(|_| live(&j)),
                quiet_samples: if live(&j) { quiet[j].samples } else { 0 },
                rest_samples: match variance.sqrt() > CLEAN * scale {
                    true => rest(&quiet, missing, j),
                    false => 0,
                },
                deviation: variance.sqrt(),
                borrowed: !own(&j),
                offset: drift.offset,
                offset_error: offset_variance.max(0.0).sqrt(),
                slope: drift.slope,
                slope_error: slope_variance.max(0.0).sqrt(),
                covariance,
            }
        });
        Ok(Channels {
            sites: sites.collect(),
            correlation,
        })
    }
}

/// The sample until which site j is at rest. If no wave is detected there, until one may arrive
/// from a neighbour; 0 if the quiet part is too short.
fn rest(quiet: &[QuietPart], missing: &[bool], j: usize) -> usize {
    let seen = |j: usize| {
        let samples = quiet[j].samples;
        let found = !missing[j] && quiet[j].arrival.is_some();
        found.then_some(if samples < LEAST_QUIET { 0 } else { samples })
    };
    seen(j).unwrap_or_else(|| {
        let (before, after) = (
            (0..j).rev().find_map(seen),
            (j + 1..quiet.len()).find_map(seen),
        );
        let first = before.into_iter().chain(after).min();
        first.unwrap_or(quiet[j].samples)
    })
}

/// `1 + 2 sum_l rho_l` over the first lags with Bartlett's weights; 1 where that is no more than
/// chance.
fn correlation_time<'a>(
    parts: impl Iterator<Item = (&'a [f64], LineFit, usize)>,
    scale: f64,
) -> f64 {
    let mut sums = [0.0; LAGS + 1];
    let mut count = 0.0;
    for (part, line, start) in parts {
        // What rounding leaves is no noise.
        let variance = variance(&line);
        if variance.sqrt() <= ROUNDING * scale {
            continue;
        }
        let residual = |i: usize| part[i] - line.intercept - line.slope * (i as f64 - start as f64);
        for (lag, sum) in sums.iter_mut().enumerate() {
            let products = (lag..part.len()).map(|i| residual(i) * residual(i - lag));
            *sum += products.sum::<f64>() / variance;
        }
        count += part.len() as f64;
    }
    if sums[0] == 0.0 {
        return 1.0;
    }
    let weight = |lag: usize| 1.0 - lag as f64 / (LAGS + 1) as f64;
    let share = |lag: usize| 2.0 * weight(lag) * sums[lag] / sums[0];
    let excess: f64 = (1..=LAGS).map(share).sum();
    let squares: f64 = (1..=LAGS).map(|lag| 4.0 * weight(lag).powi(2)).sum();
    match excess > 4.0 * (squares / count).sqrt() {
        true => 1.0 + excess,
        false => 1.0,
    }
}
