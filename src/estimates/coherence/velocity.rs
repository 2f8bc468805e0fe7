//! One phase velocity of the waves that pass the sites.

use std::f64::consts::TAU;

use super::{Coherence, Delay, PhaseSpeed};
use crate::numeric::{chi_square_level, student_two_sided};

/// Velocity of the waves that are coherent with the reference.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct WaveVelocity {
    /// In units of length over time; positive towards +x.
    pub velocity: f64,
    /// Ends of its interval at `1 - alpha`.
    pub low: f64,
    pub high: f64,
    /// Sites of the line through the delays; `None` where it is a mean over frequencies.
    pub sites: Option<usize>,
    /// Frequencies of the mean; `None` of a line.
    pub frequencies: Option<usize>,
    /// Whether velocities at single frequencies differ by more than their errors; the interval is then that of their
    /// spread.
    pub is_dispersive: bool,
}

/// Least sites of a line, beside the reference.
const LEAST_SITES: usize = 3;
/// Largest deviation from a plane wave, root mean square in rad: a standing wave has 0.9.
pub(super) const PLANE: f64 = 0.5;
/// Reduced chi-square from which on velocities differ.
const DIFFERENT: f64 = 4.0;

/// Inverse velocity with half of its interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slowness {
    pub slowness: f64,
    half: f64,
    points: usize,
}

impl Slowness {
    /// The line through the delays of sites against their positions, weighted by their inverse variances; the
    /// reference and ambiguous delays are left out, a common error of all stays out of the slope. `None` for fewer
    /// than three sites, and for delays that are not those of a plane wave.
    pub fn of_delays(found: &Coherence) -> Option<Slowness> {
        let (alpha, known) = (found.alpha, found.delays.iter().enumerate());
        let known = known.filter(|(j, _)| *j != found.reference);
        let known = known.filter_map(|(j, delay)| Some((found.space.at(j), (*delay)?)));
        let known: Vec<(f64, Delay)> = known.filter(|(_, d)| d.ambiguity.is_none()).collect();
        if known.len() < LEAST_SITES {
            return None;
        }
        let point = |(x, delay): &(f64, Delay)| [*x, delay.delay, delay.error.powi(-2)];
        let points: Vec<[f64; 3]> = known.iter().map(point).collect();
        let line = Line::through(&points);
        let (slope, spread) = (line.slope, line.spread);
        if !(spread > 0.0 && slope.is_finite()) {
            return None;
        }
        let freedom = (points.len() - 2) as f64;
        let intercept = line.y - slope * line.x;
        let residual = |p: &[f64; 3]| p[1] - intercept - slope * p[0];
        let rms = known.iter().map(|(_, delay)| delay.rms_frequency);
        let turns = rms.zip(&points).map(|(f, p)| TAU * f * residual(p));
        let squares: f64 = turns.map(|turn| turn.powi(2)).sum();
        if (squares / freedom).sqrt() > PLANE {
            return None;
        }
        let stated = chi_square_level(alpha, 1.0).sqrt();
        let left: f64 = points.iter().map(|p| p[2] * residual(p).powi(2)).sum();
        let scattered = student_two_sided(alpha, freedom) * (left / freedom).sqrt();
        Some(Slowness {
            slowness: slope,
            half: stated.max(scattered) / spread.sqrt(),
            points: points.len(),
        })
    }

    /// Its inverse; `None` where the interval of the slowness is wider than the slowness.
    pub fn velocity(self) -> Option<WaveVelocity> {
        let [low, high] = inverse(self.slowness, self.half)?;
        Some(WaveVelocity {
            velocity: self.slowness.recip(),
            low,
            high,
            sites: Some(self.points),
            frequencies: None,
            is_dispersive: false,
        })
    }
}

/// The weighted line through points `(x, y, weight)`.
pub(super) struct Line {
    /// Sum of the weights.
    pub all: f64,
    /// Weighted means, and the spread of x.
    pub x: f64,
    y: f64,
    pub spread: f64,
    pub slope: f64,
    /// Sum of the squared weighted residuals.
    pub left: f64,
}

impl Line {
    pub fn through(points: &[[f64; 3]]) -> Line {
        let sum = |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(|p| p[2] * of(p)).sum::<f64>();
        let all = sum(&|_| 1.0);
        let [x, y] = [sum(&|p| p[0]) / all, sum(&|p| p[1]) / all];
        let spread = sum(&|p| (p[0] - x).powi(2));
        let slope = sum(&|p| (p[0] - x) * (p[1] - y)) / spread;
        Line {
            all,
            x,
            y,
            spread,
            slope,
            left: sum(&|p| (p[1] - y - slope * (p[0] - x)).powi(2)),
        }
    }
}

fn inverse(slowness: f64, half: f64) -> Option<[f64; 2]> {
    let ends = [slowness - half, slowness + half].map(f64::recip);
    let is_known = half < 0.5 * slowness.abs();
    is_known.then(|| [ends[0].min(ends[1]), ends[0].max(ends[1])])
}

/// The mean over frequencies of the inverse of velocities, weighted by their inverse variances. `shared_bins`: bins
/// that a taper makes one of.
pub(super) fn of_frequencies(
    speeds: &[PhaseSpeed],
    shared_bins: f64,
    alpha: f64,
) -> Option<WaveVelocity> {
    let point = |speed: &PhaseSpeed| {
        let relative = speed.velocity_error / speed.velocity;
        let slowness = speed.velocity.recip();
        [slowness, (relative * slowness).powi(-2)]
    };
    let points: Vec<[f64; 2]> = speeds.iter().map(point).collect();
    let all: f64 = points.iter().map(|p| p[1]).sum();
    let mean = points.iter().map(|[s, w]| s * w).sum::<f64>() / all;
    let squares = points.iter().map(|[s, w]| w * (s - mean).powi(2));
    let squares: f64 = squares.sum();
    let count = points.len() as f64;
    let shared = shared_bins.min(count);
    let normal = chi_square_level(alpha, 1.0).sqrt();
    let reduced = match points.len() {
        0 => return None,
        1 => 0.0,
        _ => squares / (count - 1.0),
    };
    let is_dispersive = reduced > DIFFERENT;
    let half = match is_dispersive {
        true => normal * (squares / all).sqrt(),
        false => normal * (reduced.max(1.0) * shared / all).sqrt(),
    };
    let [low, high] = inverse(mean, half)?;
    Some(WaveVelocity {
        velocity: mean.recip(),
        low,
        high,
        sites: None,
        frequencies: Some(points.len()),
        is_dispersive,
    })
}
