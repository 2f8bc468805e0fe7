//! What a step of high order misses where a contact opens or closes inside it.
//!
//! The force `c max(delta, 0)^p` has an unbounded derivative where delta passes 0, which holds any
//! quadrature to a low order. The overlap itself is smooth: over one step its quintic Hermite
//! interpolant follows it closely. The integral of the force along that interpolant, by
//! Gauss-Jacobi with the root as an end, less what the method's own quadrature makes of the same
//! interpolant, is the correction of the step; the same applied to the error estimate keeps the
//! step size from shrinking at every contact.

use super::super::law::Kernel;
use super::quadrature::{Rule, gauss_jacobi};
use super::tableau::{MOST_STAGES, Tableau, Weights};
use crate::numeric::root;

const NODES: usize = 6;

/// Distance, in steps, of an opening outside a step that is felt in it.
pub(super) const NEAR: f64 = 3.0;

/// Farther openings are quite smooth.
const CLOSE: f64 = 0.7;
const SMOOTH_NODES: usize = 10;

/// A polynomial of degree five on 0..1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quintic([f64; 6]);

impl Quintic {
    /// From value, h times the first and h^2 times the second derivative at both ends.
    #[inline]
    pub(crate) fn hermite(start: [f64; 3], end: [f64; 3]) -> Quintic {
        let [y, d, a] = [start[0], start[1], 0.5 * start[2]];
        let rise = end[0] - (y + d + a);
        let slope = end[1] - (d + 2.0 * a);
        let bend = 0.5 * end[2] - a;
        Quintic([
            y,
            d,
            a,
            10.0 * rise - 4.0 * slope + bend,
            -15.0 * rise + 7.0 * slope - 2.0 * bend,
            6.0 * rise - 3.0 * slope + bend,
        ])
    }

    #[inline]
    pub(crate) fn at(&self, s: f64) -> f64 {
        self.0.iter().rfold(0.0, |sum, c| sum * s + c)
    }

    /// Where it passes zero from below, if it begins as a free flight, which has no curvature.
    pub(super) fn first_touch(&self) -> Option<f64> {
        let [y, d, a, ..] = self.0;
        let flies = y < 0.0 && d > 0.0 && a == 0.0;
        flies.then_some(-y / d).filter(|touch| *touch < 1.0)
    }

    #[inline]
    pub(crate) fn slope_at(&self, s: f64) -> f64 {
        let [_, a, b, c, d, e] = self.0;
        a + s * (2.0 * b + s * (3.0 * c + s * (4.0 * d + s * 5.0 * e)))
    }
}

/// A part of the step in which the contact presses, with the ends at which it opens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pressing {
    /// Between an opening and an end of the step.
    Beside { opening: f64, end: f64 },
    /// Between two openings.
    Between { from: f64, to: f64 },
    /// All through the step, shortly behind or before an opening outside it.
    Near { opening: f64 },
}

/// Quadratures along an opening contact, for one power of the overlap.
#[derive(Debug, Clone)]
pub(super) struct Correction {
    pub(super) power: f64,
    one_end: Rule,
    both_ends: Rule,
    smooth: Rule,
}

/// Integrals over the step, in units of it, for unit coefficient: what the method missed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Missed {
    /// Of the force.
    pub(super) impulse: f64,
    /// Of the force times `1 - s`.
    pub(super) moment: f64,
    /// Of the force times the given speed.
    pub(super) work: f64,
    /// What the error estimate holds of this force, to be taken out.
    pub(super) estimate: f64,
}

impl Correction {
    pub(super) fn new(power: f64) -> Correction {
        Correction {
            power,
            one_end: gauss_jacobi(NODES, power, 0.0),
            both_ends: gauss_jacobi(NODES, power, power),
            smooth: gauss_jacobi(SMOOTH_NODES, 0.0, 0.0),
        }
    }

    /// What the method missed along `overlap`, which presses in these parts of the step.
    #[inline]
    pub(super) fn along<K: Kernel>(
        &self,
        (kernel, contact): (&K, usize),
        tableau: &Tableau,
        (overlap, spans): (&Quintic, &[Option<Pressing>; 2]),
        speed: impl Fn(f64) -> f64,
    ) -> Missed {
        let mut missed = Missed::default();
        let mut add = |s: f64, weight: f64| {
            missed.impulse += weight;
            missed.moment += weight * (1.0 - s);
            missed.work += weight * speed(s);
        };
        for span in spans.iter().flatten() {
            match *span {
                Pressing::Beside { opening, end } => {
                    let length = end - opening;
                    for &(node, weight) in &self.one_end {
                        let s = opening + length * node;
                        let force = kernel.onset(contact, overlap.at(s), node);
                        add(s, length.abs() * weight * force);
                    }
                }
                Pressing::Between { from, to } => {
                    let length = to - from;
                    for &(node, weight) in &self.both_ends {
                        let s = from + length * node;
                        let force = kernel.onset(contact, overlap.at(s), node * (1.0 - node));
                        add(s, length * weight * force);
                    }
                }
                Pressing::Near { opening } if !is_close(opening) => {
                    for &(node, weight) in &self.smooth {
                        add(node, weight * kernel.onset(contact, overlap.at(node), 1.0));
                    }
                }
                Pressing::Near { opening } => {
                    let (far, close) = if opening < 0.0 {
                        (1.0, 0.0)
                    } else {
                        (0.0, 1.0)
                    };
                    for (end, sign) in [(far, 1.0), (close, -1.0)] {
                        let length: f64 = end - opening;
                        for &(node, weight) in &self.one_end {
                            let s = opening + length * node;
                            let force = kernel.onset(contact, overlap.at(s), node);
                            add(s, sign * length.abs() * weight * force);
                        }
                    }
                }
            }
        }
        let force = |stage: usize| kernel.onset(contact, overlap.at(tableau.c[stage]), 1.0);
        for &(stage, weight) in &tableau.bp {
            let weighted = weight * force(stage);
            missed.impulse -= weighted;
            missed.work -= weighted * speed(tableau.c[stage]);
        }
        for &(stage, weight) in &tableau.b {
            missed.moment -= weight * force(stage);
        }
        for &(stage, weight) in &tableau.error {
            missed.estimate += weight * force(stage);
        }
        missed
    }

    /// What the method misses up to each stage that it weighs.
    pub(super) fn up_to_stages<K: Kernel>(
        &self,
        (kernel, contact): (&K, usize),
        tableau: &Tableau,
        (overlap, spans): (&Quintic, &[Option<Pressing>; 2]),
    ) -> MissedByStages {
        let mut forces = [0.0; MOST_STAGES];
        for (force, &c) in forces.iter_mut().zip(&tableau.c) {
            *force = kernel.onset(contact, overlap.at(c), 1.0);
        }
        let own = |weights: &Weights| -> f64 { weights.iter().map(|&(j, w)| w * forces[j]).sum() };
        let force = PressingForce {
            correction: self,
            kernel,
            contact,
            overlap,
        };
        let mut missed = MissedByStages::default();
        let wholes = spans.map(|span| span.map_or([0.0; 2], |span| force.fixed_part(span)));
        for &(stage, _) in tableau.bp.iter().filter(|(stage, _)| *stage > 0) {
            let c = tableau.c[stage];
            let (mut impulse, mut first) = (0.0, 0.0);
            for (span, whole) in spans.iter().zip(wholes) {
                if let Some(span) = *span {
                    let [i, m] = force.up_to(span, whole, c);
                    (impulse, first) = (impulse + i, first + m);
                }
            }
            missed.impulse[stage] = impulse - own(&tableau.velocity[stage]);
            missed.displacement[stage] = c * impulse - first - own(&tableau.a[stage]);
        }
        missed
    }
}

/// Integrals up to each stage, in units of the step, for unit coefficient: what the method missed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MissedByStages {
    /// Of the force, in the velocity there.
    pub(super) impulse: [f64; MOST_STAGES],
    /// Of the force times `c - s`, in the position there.
    pub(super) displacement: [f64; MOST_STAGES],
}

/// The force along an overlap, for integrals of it and of its product with `s`.
struct PressingForce<'a, K> {
    correction: &'a Correction,
    kernel: &'a K,
    contact: usize,
    overlap: &'a Quintic,
}

impl<K: Kernel> PressingForce<'_, K> {
    /// Between an opening and another place.
    fn beside(&self, opening: f64, end: f64) -> [f64; 2] {
        let length = end - opening;
        let mut sums = [0.0; 2];
        for &(node, weight) in &self.correction.one_end {
            let s = opening + length * node;
            let force = weight * self.kernel.onset(self.contact, self.overlap.at(s), node);
            sums = [sums[0] + force, sums[1] + force * s];
        }
        sums.map(|sum| length.abs() * sum)
    }

    /// What does not depend on the place up to which is integrated.
    fn fixed_part(&self, span: Pressing) -> [f64; 2] {
        match span {
            Pressing::Beside { opening, end } if end < opening => self.beside(opening, end),
            Pressing::Near { opening } if is_close(opening) => self.beside(opening, 0.0),
            _ => [0.0; 2],
        }
    }

    /// From 0 to c.
    fn up_to(&self, span: Pressing, fixed: [f64; 2], c: f64) -> [f64; 2] {
        let less = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        match span {
            Pressing::Beside { opening, end } if end > opening => match c > opening {
                true => self.beside(opening, c),
                false => [0.0; 2],
            },
            Pressing::Beside { opening, .. } => match c < opening {
                true => less(fixed, self.beside(opening, c)),
                false => fixed,
            },
            Pressing::Between { from, .. } if c <= from => [0.0; 2],
            Pressing::Between { from, to } if c <= to => self.beside(from, c.min(to)),
            Pressing::Between { from, to } => {
                let middle = 0.5 * (from + to);
                let (a, b) = (self.beside(from, middle), self.beside(to, middle));
                [a[0] + b[0], a[1] + b[1]]
            }
            Pressing::Near { opening } if is_close(opening) => {
                let to = self.beside(opening, c);
                if opening < 0.0 {
                    less(to, fixed)
                } else {
                    less(fixed, to)
                }
            }
            Pressing::Near { .. } => {
                let mut sums = [0.0; 2];
                for &(node, weight) in &self.correction.smooth {
                    let s = c * node;
                    let force =
                        c * weight * self.kernel.onset(self.contact, self.overlap.at(s), 1.0);
                    sums = [sums[0] + force, sums[1] + force * s];
                }
                sums
            }
        }
    }
}

/// Whether an opening outside the step is so close that the rule must know it.
fn is_close(opening: f64) -> bool {
    (-CLOSE..1.0 + CLOSE).contains(&opening)
}

/// The places on 0..1 at which a contact of this overlap opens or closes, in order.
pub(crate) fn openings(overlap: &Quintic) -> impl Iterator<Item = f64> {
    let spans = pressing_spans(overlap).unwrap_or_default();
    spans
        .into_iter()
        .flatten()
        .flat_map(|span| match span {
            Pressing::Beside { opening, .. } => [Some(opening), None],
            Pressing::Between { from, to } => [Some(from), Some(to)],
            Pressing::Near { .. } => [None, None],
        })
        .flatten()
}

/// Where the overlap is positive inside the step, if its sign changes there.
pub(super) fn pressing_spans(overlap: &Quintic) -> Option<[Option<Pressing>; 2]> {
    let (start, end) = (overlap.at(0.0), overlap.at(1.0));
    let root = |a: f64, b: f64| root::between(a, b, |s| overlap.at(s));
    let beside = |opening: f64, end: f64| Some(Pressing::Beside { opening, end });
    match (start > 0.0, end > 0.0) {
        (false, true) => Some([beside(root(0.0, 1.0), 1.0), None]),
        (true, false) => Some([beside(root(0.0, 1.0), 0.0), None]),
        (pressing, _) => {
            let turn = turning_point(overlap, pressing)?;
            if (overlap.at(turn) > 0.0) == pressing {
                return None;
            }
            let (from, to) = (root(0.0, turn), root(turn, 1.0));
            Some(if pressing {
                [beside(from, 0.0), beside(to, 1.0)]
            } else {
                [Some(Pressing::Between { from, to }), None]
            })
        }
    }
}

/// An opening about [`NEAR`] steps or less before or after a step in which the contact presses.
pub(super) fn opening_nearby(overlap: &Quintic) -> Option<f64> {
    let [start, closing, ..] = overlap.0;
    let (end, closing_end) = (overlap.at(1.0), overlap.slope_at(1.0));
    if !(start > 0.0 && end > 0.0) {
        return None;
    }
    let near = |distance: f64| (distance > 0.0 && distance < NEAR).then_some(distance);
    let outside = |distance: f64, edge: f64, sign: f64| {
        if distance > CLOSE {
            return Some(distance);
        }
        let at = |d: f64| overlap.at(edge + sign * d);
        (at(CLOSE) < 0.0).then(|| root::between(0.0, CLOSE, at))
    };
    let before = near(start / closing)
        .and_then(|d| outside(d, 0.0, -1.0))
        .map(|d| -d);
    let after = near(-end / closing_end)
        .and_then(|d| outside(d, 1.0, 1.0))
        .map(|d| 1.0 + d);
    match (before, after) {
        (Some(before), Some(after)) if -before > after - 1.0 => Some(after),
        (Some(before), _) => Some(before),
        (None, after) => after,
    }
}

/// Where the overlap comes closest to zero, if it has an extremum inside the step.
fn turning_point(overlap: &Quintic, pressing: bool) -> Option<f64> {
    let (first, last) = (overlap.slope_at(0.0), overlap.slope_at(1.0));
    let towards = if pressing {
        first < 0.0 && last > 0.0
    } else {
        first > 0.0 && last < 0.0
    };
    towards.then(|| root::between(0.0, 1.0, |s| overlap.slope_at(s)))
}
