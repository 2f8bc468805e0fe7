//! A wave sampled into arrays, for output and plots.

use super::wave::Wave;

/// A wave sampled at uniform times about its centre, at its two contacts and two sites.
///
/// Contact 0 is soft in a stiffness dimer and before the light site in a mass dimer. Time 0 is the
/// centre of the pulse at each contact; for both sites it is that of contact 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// In units of the time that the wave takes over a cell.
    pub time: Vec<f64>,
    pub overlap: [Vec<f64>; 2],
    /// `psi = F^{1/p}`.
    pub psi: [Vec<f64>; 2],
    pub force: [Vec<f64>; 2],
    pub velocity: [Vec<f64>; 2],
    /// As [`Wave::slow_part`].
    pub slow: Vec<f64>,
    /// As [`Wave::fast_part`].
    pub fast: Vec<f64>,
}

impl Wave {
    /// The wave at `2 half + 1` times over its period; it is zero outside.
    pub fn profile(&self, half: usize) -> Snapshot {
        let end = 0.5 * self.overlap[0].period();
        let time: Vec<f64> = (0..=2 * half)
            .map(|j| end * (j as f64 / half as f64 - 1.0))
            .collect();
        let values = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let force = |i: usize, t: f64| self.force[i].value(t).max(0.0);
        Snapshot {
            overlap: [0, 1].map(|i| values(&|t| self.overlap[i].value(t))),
            psi: [0, 1].map(|i| values(&|t| force(i, t).powf(1.0 / self.exponent))),
            force: [0, 1].map(|i| values(&|t| force(i, t))),
            velocity: [0, 1].map(|i| values(&|t| self.velocity[i].value(t))),
            slow: values(&|t| self.slow_part(t)),
            fast: values(&|t| self.fast_part(t)),
            time,
        }
    }
}
