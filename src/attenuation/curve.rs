//! Attenuation curves: their points, their end, and the length that reaches a target.

use serde::Serialize;

use super::chains::{ContactKind, Pattern};
use super::fit::{AttenuationLaw, Fits};
use super::members::{FollowedChain, PulseMeasures};
use super::pulse::{Pulse, Sense};
use crate::chain::Simulation;
use crate::chain::scene::Units;

/// The attenuation curves of a request.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attenuation {
    pub length: usize,
    pub kind: ContactKind,
    pub target: Option<f64>,
    pub curves: Vec<AttenuationCurve>,
    /// Members whose run failed, with the reason.
    pub failed: Vec<(String, String)>,
    /// Number of chains simulated in this run; the others were already known.
    #[serde(skip)]
    pub computed: usize,
}

/// The curve of one chain in one sense.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AttenuationCurve {
    pub name: String,
    pub sense: Sense,
    pub units: Units,
    /// Largest over smallest coefficient between bodies.
    pub stiffness_ratio: f64,
    pub band_edge_frequency: Option<f64>,
    pub rows: Vec<CurveRow>,
    /// Where and why it ends before the requested length.
    pub stop: Option<Stop>,
    pub fits: Option<Fits>,
    pub reach: Option<Reach>,
}

/// The first number of bodies missing from a curve, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Stop {
    pub bodies: usize,
    pub cause: StopCause,
}

/// Why a curve ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopCause {
    /// A reflection from the wall would arrive before the pulse is complete.
    Reflection,
    /// The pulse faded before it reached the end of the chain.
    Faded,
    /// Its run failed.
    Failed,
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurveRow {
    /// Bodies before the contact, the striker not counted.
    pub bodies: usize,
    pub kind: ContactKind,
    pub pulse: Pulse,
    /// Fraction of the energy passed that lies above the band edge.
    pub high_share: Option<f64>,
    /// Peak force relative to the same contact of the homogeneous chain.
    pub relative_force: Option<f64>,
    pub relative_velocity: Option<f64>,
    pub relative_energy: Option<f64>,
}

/// The length that reaches the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "found")]
pub enum Reach {
    /// From this number of bodies on, the curve is at or below the target; the one before is above it.
    Within { bodies: usize },
    /// No length up to this one, of those computed.
    Beyond { bodies: usize },
    /// The chosen law, which holds for the last third of the curve, settles above the target.
    Never {
        law: AttenuationLaw,
        settles_at: f64,
    },
}

/// Lengths and relative forces of the contacts that are compared: those of the kind, and all others than soft and stiff
/// ones.
pub(super) fn compared(kind: ContactKind, rows: &[CurveRow]) -> Vec<(f64, f64)> {
    let like =
        |row: &&CurveRow| row.bodies > 0 && (row.kind == kind || row.kind == ContactKind::Other);
    let pairs = rows.iter().filter(like);
    pairs
        .filter_map(|row| Some((row.bodies as f64, row.relative_force?)))
        .collect()
}

/// The rows of a simulated chain, relative to the homogeneous chain.
pub(super) fn rows_of(
    member: &FollowedChain,
    seen: &PulseMeasures,
    reference: Option<&PulseMeasures>,
    pattern: &Pattern,
) -> Vec<CurveRow> {
    let of_size = |s: &&Simulation| s.chain.n_sites() == seen.sites;
    let chain = member.attempts.iter().find(of_size).map(|s| &s.chain);
    let others = reference.map_or(&[][..], |reference| &reference.pulses.pulses);
    let pulses = seen.pulses.pulses.iter().enumerate();
    let rows = pulses.map(|(i, pulse)| {
        let other = others.iter().find(|other| other.contact == pulse.contact);
        let relative = |of: fn(&Pulse) -> f64| other.map(|other| of(pulse) / of(other));
        let kind = chain.map(|chain| pattern.kind(chain.coefficient[pulse.contact]));
        CurveRow {
            bodies: pulse.contact,
            kind: kind.unwrap_or(ContactKind::Other),
            pulse: *pulse,
            high_share: seen.high.as_ref().map(|high| high[i]),
            relative_force: relative(|p| p.peak_force.value),
            relative_velocity: relative(|p| p.peak_velocity.value),
            relative_energy: relative(|p| p.energy_passed.value),
        }
    });
    rows.collect()
}

/// The length from which on a curve is at or below the target.
pub(super) fn reach(target: f64, points: &[(f64, f64)], fits: Option<&Fits>) -> Reach {
    let above = points.iter().rposition(|(_, y)| *y > target);
    if let Some((n, _)) = points.get(above.map_or(0, |at| at + 1)) {
        return Reach::Within {
            bodies: *n as usize,
        };
    }
    let settled = || {
        let fit = fits?.chosen();
        let (law, settles_at) = (fit.law, fit.settles_at());
        let holds = settles_at > target * (1.0 + fit.missed_beyond(2.0 / 3.0, points)?);
        holds.then_some(Reach::Never { law, settles_at })
    };
    let bodies = points.last().map_or(0, |(n, _)| *n as usize);
    settled().unwrap_or(Reach::Beyond { bodies })
}
