//! The asymptotic estimate: a fast oscillator, driven by the slow wave, that is at rest behind it.

use super::slow::SlowWave;
use super::wave::Alternation;
use crate::numeric::find_root;

/// The linear oscillator `y'' + s W(t)^2 y = f(t)` of the fast part. The stiffening s is
/// `kappa^{1/p}` or the inverse mass ratio.
///
/// * Stiffness dimer: y is the overlap of the stiff contact minus its slow part `psi`,
///   `psi^p = (F(t+h) + F(t-h))/2`; `W^2 = 2 p psi^{p-1}`, `f = -psi''`, both even.
/// * Mass dimer: y is the difference of the overlaps on both sides of a light site,
///   `W^2 = 2 p psi^{p-1}`, `f = F(t+1) - F(t-1)`, odd.
///
/// A solution at rest ahead of the wave is at rest behind it if it has the symmetry of f. The
/// condition is `integral f u = 0` over the half line, where u is the free oscillation of that
/// symmetry. For the stiffness dimer, integrating `-psi'' u` by parts twice replaces f by `psi^p`.
/// (The condition `y'(inf) = 0` alone has further roots in between, at which y tends to a nonzero
/// constant.)
///
/// Source: K. R. Jayaprakash, Y. Starosvetsky, A. F. Vakakis, Phys. Rev. E 83 (2011) 036606.
pub(super) struct Oscillator {
    alternation: Alternation,
    step: f64,
    /// `W^2` and the drive at the times `j step`.
    square: Vec<f64>,
    drive: Vec<f64>,
}

impl Oscillator {
    pub(super) fn new(alternation: Alternation, slow: &SlowWave) -> Oscillator {
        let p = slow.exponent;
        let steps = (slow.end() * STEPS_PER_TIME).ceil() as usize;
        let step = slow.end() / steps as f64;
        let times = (0..=steps).map(|j| j as f64 * step);
        let (square, drive) = times
            .map(|t| {
                let (force, drive) = match alternation {
                    Alternation::Stiffness => {
                        let force = 0.5 * (slow.force(t + 0.5) + slow.force(t - 0.5));
                        (force, force)
                    }
                    Alternation::Mass => (slow.force(t), slow.force(t + 1.0) - slow.force(t - 1.0)),
                };
                (2.0 * p * force.powf((p - 1.0) / p), drive)
            })
            .unzip();
        Oscillator {
            alternation,
            step,
            square,
            drive,
        }
    }

    /// Largest angular frequency for the stiffening 1.
    pub(super) fn fastest(&self) -> f64 {
        self.square.iter().fold(0.0, |m: f64, w| m.max(*w)).sqrt()
    }

    /// The stiffenings of the first `count` orders; fewer if the mismatch falls below rounding.
    pub(super) fn roots(&self, count: usize) -> Vec<f64> {
        let phase: f64 = 2.0 * self.step * self.square.iter().map(|w| w.sqrt()).sum::<f64>();
        let step = 0.5 / phase;
        let mut roots = Vec::with_capacity(count);
        // Scans the square root of s, in which roots are almost equidistant. Order 1 of the mass
        // dimer (the homogeneous chain) is not a root.
        let mut root_of_s = match self.alternation {
            Alternation::Stiffness => 0.8,
            Alternation::Mass => {
                roots.push(1.0);
                1.15
            }
        };
        let mut mismatch = self.mismatch(root_of_s);
        while roots.len() < count {
            let next = self.mismatch(root_of_s + step);
            if next.abs().max(mismatch.abs()) < LEAST_MISMATCH {
                break;
            }
            if (next < 0.0) != (mismatch < 0.0) {
                let root = find_root(root_of_s, root_of_s + step, |s| self.mismatch(s));
                roots.push(root.powi(2));
            }
            root_of_s += step;
            mismatch = next;
        }
        roots.truncate(count);
        roots
    }

    /// `integral f u / integral |f u|`.
    fn mismatch(&self, root_of_s: f64) -> f64 {
        let s = root_of_s * root_of_s;
        // Numerov's method.
        let h2 = self.step * self.step * s / 12.0;
        let weight = |j: usize| 1.0 + h2 * self.square[j];
        let pull = |j: usize| 2.0 - 10.0 * h2 * self.square[j];
        let (mut before, mut now) = match self.alternation {
            Alternation::Stiffness => (1.0, 0.5 * pull(0) / weight(1)),
            Alternation::Mass => (0.0, self.step / weight(1)),
        };
        let first = 0.5 * self.drive[0] * before;
        let (mut sum, mut size) = (first + self.drive[1] * now, first.abs());
        for j in 2..self.square.len() {
            let next = (pull(j - 1) * now - weight(j - 2) * before) / weight(j);
            (before, now) = (now, next);
            sum += self.drive[j] * now;
            size += (self.drive[j] * now).abs();
        }
        sum / size
    }
}

/// Steps per unit of time: at order 30 the error of a ratio is 1e-8.
const STEPS_PER_TIME: f64 = 1500.0;

/// Rounding error of `integral f u`, relative to `integral |f u|`.
const LEAST_MISMATCH: f64 = 1e-13;
