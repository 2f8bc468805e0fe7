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
use crate::numeric::lanes::{LaneBlock, Lanes, Number, SimdKernel, widest};
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

    #[inline(always)]
    pub(crate) fn at<N: Number>(&self, s: N) -> N {
        let coefficients = self.0.iter().map(|c| N::splat(*c));
        coefficients.rfold(N::splat(0.0), |sum, c| sum * s + c)
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
        forces: &[f64; MOST_STAGES],
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
        for &(stage, weight) in &tableau.bp {
            let weighted = weight * forces[stage];
            missed.impulse -= weighted;
            missed.work -= weighted * speed(tableau.c[stage]);
        }
        for &(stage, weight) in &tableau.b {
            missed.moment -= weight * forces[stage];
        }
        for &(stage, weight) in &tableau.error {
            missed.estimate += weight * forces[stage];
        }
        missed
    }

    /// What the method misses up to each stage that it weighs.
    pub(super) fn up_to_stages<K: Kernel>(
        &self,
        (kernel, contact): (&K, usize),
        tableau: &Tableau,
        (overlap, spans): (&Quintic, &[Option<Pressing>; 2]),
        forces: &[f64; MOST_STAGES],
    ) -> MissedByStages {
        let own = |weights: &Weights| -> f64 { weights.iter().map(|&(j, w)| w * forces[j]).sum() };
        let force = PressingForce {
            correction: self,
            kernel,
            contact,
            overlap,
        };
        let [impulses, firsts] = widest(UpToStages {
            force,
            spans,
            nodes: &tableau.nodes,
        });
        let mut missed = MissedByStages::default();
        let integrals = impulses.0.into_iter().zip(firsts.0);
        for (&(stage, _), (impulse, first)) in tableau.bp.iter().zip(integrals) {
            if stage > 0 {
                let c = tableau.c[stage];
                missed.impulse[stage] = impulse - own(&tableau.velocity[stage]);
                missed.displacement[stage] = c * impulse - first - own(&tableau.a[stage]);
            }
        }
        missed
    }
}

/// Forces at all stages of a contact of unit coefficient with this overlap.
pub(super) fn stage_forces<K: Kernel>(
    (kernel, contact): (&K, usize),
    tableau: &Tableau,
    overlap: &Quintic,
) -> [f64; MOST_STAGES] {
    let mut forces = [0.0; MOST_STAGES];
    for (force, &c) in forces.iter_mut().zip(&tableau.c) {
        *force = kernel.onset(contact, overlap.at(c), 1.0);
    }
    forces
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

/// Integrals of a force, and of its product with s, from 0 to each of the nodes, a node a lane.
struct UpToStages<'a, K> {
    force: PressingForce<'a, K>,
    spans: &'a [Option<Pressing>; 2],
    nodes: &'a LaneBlock,
}

impl<K: Kernel> SimdKernel for UpToStages<'_, K> {
    type Output = [LaneBlock; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [LaneBlock; 2] {
        let mut sums = [L::splat(0.0); 2];
        for span in self.spans.iter().flatten() {
            sums = plus(sums, self.force.up_to(*span, L::load(self.nodes)));
        }
        let mut out = [LaneBlock::default(); 2];
        for (sum, out) in sums.into_iter().zip(&mut out) {
            sum.store(out);
        }
        out
    }
}

#[inline(always)]
fn plus<N: Number>(a: [N; 2], b: [N; 2]) -> [N; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn less<N: Number>(a: [N; 2], b: [N; 2]) -> [N; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

impl<K: Kernel> PressingForce<'_, K> {
    /// Between an opening and another place.
    #[inline(always)]
    fn beside<N: Number>(&self, opening: f64, end: N) -> [N; 2] {
        let opening = N::splat(opening);
        let length = end - opening;
        let mut sums = [N::splat(0.0); 2];
        for &(node, weight) in &self.correction.one_end {
            let (node, weight) = (N::splat(node), N::splat(weight));
            let s = opening + length * node;
            let force = weight * self.kernel.onset(self.contact, self.overlap.at(s), node);
            sums = plus(sums, [force, force * s]);
        }
        sums.map(|sum| length.abs() * sum)
    }

    /// From 0 to c.
    #[inline(always)]
    fn up_to<N: Number>(&self, span: Pressing, c: N) -> [N; 2] {
        let later = |t: f64| (c - N::splat(t)).choose(c, N::splat(t));
        let earlier = |t: f64| (N::splat(t) - c).choose(c, N::splat(t));
        match span {
            Pressing::Beside { opening, end } if end > opening => {
                self.beside(opening, later(opening))
            }
            Pressing::Beside { opening, end } => {
                let whole = self.beside(opening, N::splat(end));
                less(whole, self.beside(opening, earlier(opening)))
            }
            Pressing::Between { from, to } => {
                let middle = N::splat(0.5 * (from + to));
                let whole = plus(self.beside(from, middle), self.beside(to, middle));
                let part = self.beside(from, later(from));
                let is_past = c - N::splat(to);
                [0, 1].map(|i| is_past.choose(whole[i], part[i]))
            }
            Pressing::Near { opening } if is_close(opening) => {
                let (to, start) = (self.beside(opening, c), self.beside(opening, N::splat(0.0)));
                match opening < 0.0 {
                    true => less(to, start),
                    false => less(start, to),
                }
            }
            Pressing::Near { .. } => {
                let mut sums = [N::splat(0.0); 2];
                for &(node, weight) in &self.correction.smooth {
                    let s = c * N::splat(node);
                    let onset = self
                        .kernel
                        .onset(self.contact, self.overlap.at(s), N::splat(1.0));
                    let force = c * N::splat(weight) * onset;
                    sums = plus(sums, [force, force * s]);
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
