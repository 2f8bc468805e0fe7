//! One phase velocity of the waves that pass the sites.

use std::f64::consts::TAU;

use super::{Coherence, Delay, PhaseSpeed};
use crate::numeric::{LineFit, chi_square_level};

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
    /// The slope of the weighted line through the delays of all sites but the reference, where they are those of a plane
    /// wave. The interval is the larger of that of the delays and that of the residuals.
    pub fn of_delays(found: &Coherence) -> Option<Slowness> {
        let known = found.delays.iter().enumerate().filter_map(|(j, delay)| {
            let delay = delay.filter(|d| j != found.reference && d.ambiguity.is_none())?;
            Some((found.space.at(j), delay))
        });
        let known: Vec<(f64, Delay)> = known.collect();
        let points = known.iter();
        let points = points.map(|(x, delay)| [*x, delay.delay, delay.error.powi(-2)]);
        let line = LineFit::weighted(points)?;
        let turn = |(x, delay): &(f64, Delay)| {
            let left = delay.delay - line.intercept - line.slope * x;
            (TAU * delay.rms_frequency * left).powi(2)
        };
        let squares: f64 = known.iter().map(turn).sum();
        let stated = (chi_square_level(found.alpha, 1.0) / line.spread).sqrt();
        let is_plane = (squares / (line.points - 2) as f64).sqrt() <= PLANE;
        is_plane.then(|| Slowness {
            slowness: line.slope,
            half: stated.max(line.half_interval(found.alpha)),
            points: line.points,
        })
    }

    /// Its inverse, of a line; `None` where the interval of the slowness is wider than the slowness.
    pub fn velocity(self) -> Option<WaveVelocity> {
        let ends = [self.slowness - self.half, self.slowness + self.half].map(f64::recip);
        (self.half < 0.5 * self.slowness.abs()).then(|| WaveVelocity {
            velocity: self.slowness.recip(),
            low: ends[0].min(ends[1]),
            high: ends[0].max(ends[1]),
            sites: Some(self.points),
            frequencies: None,
            is_dispersive: false,
        })
    }
}

/// The mean over frequencies of the inverse of velocities, weighted by their inverse variances. `shared_bins`: bins
/// that a taper makes one of.
pub(super) fn of_frequencies(
    speeds: &[PhaseSpeed],
    shared_bins: f64,
    alpha: f64,
) -> Option<WaveVelocity> {
    let point = |speed: &PhaseSpeed| {
        let slowness = speed.velocity.recip();
        [
            slowness,
            (speed.velocity_error * slowness * slowness).powi(-2),
        ]
    };
    let points: Vec<[f64; 2]> = speeds.iter().map(point).collect();
    let count = points.len() as f64;
    let all: f64 = points.iter().map(|p| p[1]).sum();
    let mean = points.iter().map(|[s, w]| s * w).sum::<f64>() / all;
    let squares: f64 = points.iter().map(|[s, w]| w * (s - mean).powi(2)).sum();
    let reduced = squares / (count - 1.0).max(1.0);
    let is_dispersive = reduced > DIFFERENT;
    let variance = match is_dispersive {
        true => squares,
        false => reduced.max(1.0) * shared_bins.min(count),
    };
    let mean = Slowness {
        slowness: mean,
        half: (chi_square_level(alpha, 1.0) * variance / all).sqrt(),
        points: points.len(),
    };
    Some(WaveVelocity {
        sites: None,
        frequencies: Some(points.len()),
        is_dispersive,
        ..mean.velocity()?
    })
}
