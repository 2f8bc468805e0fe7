//! Whether a step resolves the contacts that close or open inside it.
//!
//! The stages of a step evaluate a contact only at their nodes. A contact that closes after a free
//! flight may press only between the last node and the end of the step. The error estimate is then
//! zero, however deep the overlap. The step is therefore bounded by the contact itself. With
//! reduced mass `1/mu = m_l m_r / (m_l + m_r)`, stiffness K at the depth `v t` that free flight
//! reaches in the time t of contact,
//!
//! ```text
//! kappa(t) = mu K(v t) t^2,     rho(t) = mu (dashpot + tangent K(v t)) t
//! ```
//!
//! are the relative changes of the overlap and of the closing speed in that time. The correction
//! integrates the impulse along an interpolant with a relative error of order kappa, which is added
//! to the error estimate. A step in which kappa or rho is large is repeated with a shorter length.
//! Forces of dampers are not corrected; they stay in the error estimate, which includes the first
//! and last node if forces depend on velocities.

use super::super::law::Kernel;
use super::correction::{Missed, Pressing, Quintic};
use super::system::System;

/// Largest kappa + rho of one step: about a tenth of a collision.
const LARGEST_CHANGE: f64 = 0.1;

/// Error of the impulse along the interpolant, in units of `kappa` and of what the stages missed,
/// for a contact that closes a share phi of the step before its end: `0.2 (1 - phi)^3`. Computed
/// for `delta'' = -delta^{3/2}` and small kappa it is 0.19, 0.15, 0.10 and 0.06 at phi = 0.02, 0.1,
/// 0.2 and 0.3, and below 0.005 from 0.5 on.
const INTERPOLATION_ERROR: f64 = 0.2;

/// The same for a contact that closes before the step or opens after it, and presses all the time.
const NEARBY_ERROR: f64 = 0.005;

/// What a step makes of one contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Resolved {
    /// Unseen error of the impulse, a force times a time.
    pub(super) error: f64,
    /// The longest step after which the contact is resolved, in shares of this one: 1 and above
    /// where this one resolves it.
    pub(super) longest: f64,
    /// How long a next step may be, behind a contact that has closed, in units of this one.
    pub(super) onward: f64,
}

/// A contact that closes or opens inside a step of length h.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing<'a> {
    pub(super) contact: usize,
    pub(super) h: f64,
    pub(super) overlap: &'a Quintic,
    pub(super) spans: &'a [Option<Pressing>; 2],
}

impl Crossing<'_> {
    /// Judges the step; `tolerance` is the error of a velocity that it may make.
    pub(super) fn resolved<K: Kernel>(
        &self,
        system: &System<K>,
        missed: &Missed,
        tolerance: f64,
    ) -> Resolved {
        let power = system.opens[self.contact];
        let places = [self.contact - 1, self.contact];
        let [left, right] = places.map(|s| system.mobility[s]);
        let mobility = left + right;
        let coefficient = system.coefficient[self.contact];
        let mut all = Resolved {
            error: 0.0,
            longest: f64::INFINITY,
            onward: f64::INFINITY,
        };
        let damps = system.losses.dashpot > 0.0 || system.losses.tangent > 0.0;
        if damps && self.overlap.first_touch().is_none() {
            // Without a preceding flight the error estimate includes the dampers at both ends of
            // the step.
            return all;
        }
        for span in self.spans.iter().flatten() {
            let (mut opening, mut length, closes) = match *span {
                Pressing::Beside { opening, end } => {
                    (opening, (end - opening).abs(), end > opening)
                }
                Pressing::Between { from, to } => (from, to - from, true),
                Pressing::Near { opening } => {
                    let speed = self.speed_at(opening.clamp(0.0, 1.0));
                    let [kappa, _] = self.changes(system, mobility, speed, 1.0);
                    let impulse = self.h * coefficient * missed.impulse.abs();
                    all.error += NEARBY_ERROR * kappa * impulse;
                    continue;
                }
            };
            // The end of a flight is known from its interpolant, whatever the state at the end of
            // the step.
            if let Some(touch) = self.overlap.first_touch().filter(|_| closes) {
                (opening, length) = (touch, 1.0 - touch);
            }
            if length == 0.0 {
                continue;
            }
            let speed = self.speed_at(opening);
            let [kappa, rho] = self.changes(system, mobility, speed, length);
            let impulse = self.h * coefficient * missed.impulse.abs();
            let shape = INTERPOLATION_ERROR * (1.0 - length).powi(3);
            // Dampers are covered by the error estimate, which includes both ends of the step.
            let error = if rho > 0.0 {
                0.0
            } else {
                shape * kappa * impulse
            };
            all.error += error;
            // kappa grows as t^{p+1}, the error as t^{2p+2}.
            let change = kappa + rho;
            let by_change = (0.2 * LARGEST_CHANGE / change).powf(1.0 / (power + 1.0));
            let by_error = 0.8 * (tolerance / (mobility * error)).powf(0.5 / (power + 1.0));
            let unresolved = change.is_nan() || change > LARGEST_CHANGE;
            let wrong = mobility * error > tolerance;
            if unresolved || wrong {
                let mut shorter: f64 = 0.5;
                if unresolved {
                    shorter = shorter.min(by_change);
                }
                if wrong {
                    shorter = shorter.min(by_error);
                }
                let part = shorter.max(0.01) * length;
                all.longest = all.longest.min(if closes {
                    opening + part
                } else {
                    0.5 * opening
                });
            }
            if closes {
                let onward = (LARGEST_CHANGE / change).powf(1.0 / (power + 1.0));
                all.onward = all.onward.min(length * onward);
            }
        }
        all
    }

    /// Speed, per step, with which the overlap passes zero; that of the flight where the end of the
    /// step has bent the interpolant.
    fn speed_at(&self, opening: f64) -> f64 {
        let here = self.overlap.slope_at(opening).abs();
        let start = self.overlap.slope_at(0.0);
        if self.overlap.at(0.0) <= 0.0 {
            here.max(start)
        } else {
            here
        }
    }

    /// `kappa` and `rho` of a contact that presses for this share of the step.
    fn changes<K: Kernel>(
        &self,
        system: &System<K>,
        mobility: f64,
        speed: f64,
        length: f64,
    ) -> [f64; 2] {
        let s = self.contact;
        let d0 = system.static_overlap[s];
        let time = self.h * length;
        let stiffness = system
            .kernel
            .stiffness(s, system.coefficient[s], d0, speed * length - d0);
        let damping = system.losses.dashpot + system.losses.tangent * stiffness;
        [
            mobility * stiffness * time * time,
            mobility * damping * time,
        ]
    }
}
