//! Error estimates of a localized wave.

/// Error estimates of a localized wave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Convergence {
    /// Relative change of the ratio when the resolution is raised.
    pub resolution_change: f64,
    /// Relative change of the ratio when the period is extended.
    pub period_change: f64,
    /// Largest residual of the integrated equations, relative to the largest overlap.
    pub residual: f64,
    /// Newton steps, all grids together.
    pub iterations: usize,
    /// Largest amplitude in the last tenth of the spectrum, relative to the largest.
    pub spectral_tail: f64,
    /// Largest force in the outer twentieth of the period on each side, relative to the peak.
    pub tail: f64,
    /// Grid points per period.
    pub points: usize,
    pub period: f64,
}

impl Convergence {
    /// Estimated relative error of the ratio.
    pub fn error(&self) -> f64 {
        self.resolution_change
            .max(self.period_change)
            .max(f64::EPSILON)
    }
}
