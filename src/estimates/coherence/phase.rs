//! Wavenumber and phase velocity from the phases along x.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use super::Coherence;
use super::velocity::PLANE;
use crate::numeric::LineFit;

/// Wavenumber of the waves that are coherent with the reference, from their phases along x.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PhaseSpeed {
    pub frequency: f64,
    /// `k` in rad per unit of length; positive for waves towards +x.
    pub wavenumber: f64,
    /// Its standard error: that of the residuals, or that of the phases if it is larger.
    pub wavenumber_error: f64,
    /// `2 pi f / k`.
    pub velocity: f64,
    pub velocity_error: f64,
    /// Sites of the fit.
    pub sites: usize,
}

/// Least sites of a fit: two more than its parameters.
const LEAST_SITES: usize = 4;

/// Half interval within which a phase must be known, or its continuation from site to site, by less than
/// half a cycle, would be chance.
const KNOWN: f64 = FRAC_PI_4;

/// Largest step of the phase from site to site: near half a cycle its sign is chance.
const MOST_STEP: f64 = 0.8 * PI;

/// The coherence above which the half interval of a phase is below [`KNOWN`], where `spread` is
/// `alpha^{-1/(K-1)} - 1`.
pub(super) fn least_coherence(spread: f64) -> f64 {
    spread / (spread + KNOWN.sin().powi(2))
}

/// Phases of one frequency at the sites.
pub(super) struct Phases<'a> {
    /// The frequency whose power the bin has, that of a line which leaks to it, and its error.
    pub at: f64,
    pub at_error: f64,
    /// With the phases of cross-spectra: `-k (x - x_r)` of a plane wave.
    pub found: &'a Coherence,
    pub bin: usize,
    /// Coherence above which the phase of each site is known to [`KNOWN`]; NaN where none is.
    pub least: &'a [f64],
    /// Independent realisations of each site.
    pub independent: &'a [f64],
    /// Inverse phase velocity, where delays tell it.
    pub slowness: Option<f64>,
}

impl Phases<'_> {
    /// The line through the phases of the sites around the reference, up to the first on either side whose
    /// phase is not known: `phase = a - k (x - x_r)`, weighted by the inverse variances
    /// `2 K g / (1 - g)`, with `g` the coherence. Where no slowness is known, neighbours are taken to be less than
    /// half a wavelength apart. `None` for fewer than four sites, and for phases that are not those of a plane wave.
    ///
    /// Source: Bendat and Piersol (2010), eq. 9.52, for the variance of a phase.
    pub fn speed(&self) -> Option<PhaseSpeed> {
        let mut points = Vec::new();
        let (mut apart, reference) = (0.0, self.found.reference);
        self.walk(reference + 1..self.least.len(), &mut points, &mut apart);
        self.walk((0..reference).rev(), &mut points, &mut apart);
        if points.len() < LEAST_SITES {
            return None;
        }
        let line = LineFit::weighted(points.iter().copied())?;
        let freedom = (points.len() - 2) as f64;
        let deviation = (line.squares / line.weight * points.len() as f64 / freedom).sqrt();
        let is_aliased = self.slowness.is_none() && (line.slope * apart).abs() > MOST_STEP;
        if deviation > PLANE || is_aliased {
            return None;
        }
        let wavenumber = -line.slope;
        let wavenumber_error = line.slope_error.max(line.spread.recip().sqrt());
        let velocity = TAU * self.at / wavenumber;
        let relative = (wavenumber_error / wavenumber).hypot(self.at_error / self.at);
        Some(PhaseSpeed {
            frequency: self.at,
            wavenumber,
            wavenumber_error,
            velocity,
            velocity_error: velocity.abs() * relative,
            sites: points.len(),
        })
    }

    /// Adds the sites of one side, with phases that continue one another, and finds the largest step from one to the next.
    fn walk(
        &self,
        sites: impl Iterator<Item = usize>,
        points: &mut Vec<[f64; 3]>,
        apart: &mut f64,
    ) {
        let position = |site: usize| self.found.space.at(site);
        let (mut before, mut site) = (0.0, self.found.reference);
        for j in sites {
            let cell = [self.bin, j];
            let (phase, coherence) = (self.found.phase[cell], self.found.coherence[cell]);
            // Undefined where a site has no energy.
            let is_known = coherence > self.least[j];
            if !is_known {
                return;
            }
            let step = position(j) - position(site);
            let expected = before - TAU * self.at * self.slowness.unwrap_or(0.0) * step;
            let cycles = ((phase - expected) / TAU).round();
            let phase = phase - TAU * cycles;
            debug_assert!((phase - expected).abs() <= PI * (1.0 + 1e-9));
            (before, site) = (phase, j);
            *apart = apart.max(step.abs());
            let noise = (1.0 - coherence).max(f64::EPSILON);
            let weight = 2.0 * self.independent[j] * coherence / noise;
            let x = position(j) - position(self.found.reference);
            points.push([x, phase, weight]);
        }
    }
}
