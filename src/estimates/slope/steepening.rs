//! The time at which a steepening field forms a shock.

use super::frames::SlopeFrames;
use crate::numeric::least_squares::LineFit;
use crate::numeric::student_two_sided;

/// The gradient has to grow by this factor.
const LEAST_GROWTH: f64 = 4.0;
/// Gradients up to this multiple of the first are used.
const FITTED: f64 = 3.0;
/// Frames of the fit, at least.
const LEAST_FRAMES: usize = 5;
/// Largest root mean square of the residuals, over the first `1 / G`.
const STRAIGHT: f64 = 0.05;

/// Where the slope of a front would become infinite.
///
/// With `G(t)` the largest `|dv/dx|` of a field that steepens like Burgers' equation without viscosity,
/// `1 / G = (t_s - t) |c'|` falls along a straight line to 0 at the shock time `t_s`. The line is fitted over
/// the frames from the first on whose G is at most three times the first; `v = sin x` with `dv/dt = -v dv/dx` has
/// `t_s = 1 / max |dv/dx| = 1`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Steepening {
    pub shock_time: f64,
    /// Half of its interval, of the regression.
    pub half: f64,
    /// Frames of the fit.
    pub frames: usize,
    /// Largest over first gradient.
    pub growth: f64,
    /// Slope in the frame that holds the shock time, with half of the interval of its regression; NaN where the record
    /// ends before.
    pub slope_at_shock: f64,
    pub slope_half: f64,
    /// Mean of the slopes of the frames from 1.5 shock times after the first on, and their extremes; NaN where
    /// there are none.
    pub slope_after: f64,
    pub slope_after_range: [f64; 2],
}

impl Steepening {
    /// `None` for a field whose largest gradient does not grow fourfold along such a line.
    pub(super) fn of(frames: &SlopeFrames, alpha: f64) -> Option<Steepening> {
        let first = *frames.gradient.first()?;
        if first.is_nan() || first <= 0.0 {
            return None;
        }
        let largest = frames.gradient.iter().copied().fold(0.0, f64::max);
        let growth = largest / first;
        let used = frames
            .gradient
            .iter()
            .take_while(|g| **g <= FITTED * first && **g > 0.0);
        let count = used.count();
        if growth < LEAST_GROWTH || count < LEAST_FRAMES {
            return None;
        }
        let points: Vec<(f64, f64)> = frames.time[..count]
            .iter()
            .zip(&frames.gradient)
            .map(|(t, g)| (*t, first / g))
            .collect();
        let line = LineFit::through(&points)?;
        let n = count as f64;
        let scatter = (line.squares / n).sqrt();
        if line.slope >= 0.0 || scatter > STRAIGHT {
            return None;
        }
        let shock_time = -line.intercept / line.slope;
        // The error of the zero of a line: of its height there, over its slope.
        let mean = points.iter().map(|p| p.0).sum::<f64>() / n;
        let variance = line.squares / (n - 2.0);
        let height = (variance / n + (line.slope_error * (shock_time - mean)).powi(2)).sqrt();
        let half = student_two_sided(alpha, n - 2.0) * height / line.slope.abs();
        let nearest = (0..frames.time.len()).min_by(|a, b| {
            let off = |i: &usize| (frames.time[*i] - shock_time).abs();
            off(a).total_cmp(&off(b))
        })?;
        // Of a record that ends before the shock there is none.
        let spacing = frames.time[1] - frames.time[0];
        let has_shock = shock_time < frames.time[frames.time.len() - 1] + spacing;
        let at_shock = |of: &[f64]| if has_shock { of[nearest] } else { f64::NAN };
        let from = frames.time[0] + 1.5 * (shock_time - frames.time[0]);
        let after = frames
            .time
            .iter()
            .zip(&frames.slope)
            .filter(|(t, s)| **t >= from && s.is_finite());
        let after: Vec<f64> = after.map(|(_, s)| *s).collect();
        let ends = |of: fn(f64, f64) -> f64| after.iter().copied().fold(f64::NAN, of);
        Some(Steepening {
            shock_time,
            half,
            frames: count,
            growth,
            slope_at_shock: at_shock(&frames.slope),
            slope_half: at_shock(&frames.half),
            slope_after: after.iter().sum::<f64>() / after.len() as f64,
            slope_after_range: [ends(f64::min), ends(f64::max)],
        })
    }
}
