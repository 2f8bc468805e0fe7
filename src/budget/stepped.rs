//! Integrals of rates inside the stepping: the chain is stepped anew from its first sample.

use rayon::prelude::*;

use super::Task;
use super::balance::{GivenRate, worst_of};
use super::filter::ScaleOf;
use super::frequency::NodeFlows;
use super::motion::Motion;
use super::place::{Balances, Evaluation, PlaceScratch, PlaceTerms};
use super::result::{Budget, Integration};
use super::scale::Scales;
use super::sublattices::Filtered;
use super::waiting::{BATCH, Waiting};
use super::wavenumber::Transfers;
use crate::arrays::LargeArray;
use crate::chain::{Node, NodeState, NodeVisitor, Quintic, Scheme, Simulation, openings};
use crate::error::Result;

/// Error of a velocity a step, relative to the velocity scale.
const LOCAL_ERROR: f64 = 1e-12;

/// Nodes and samples that are evaluated together, on all threads; with many sites fewer, down to the
/// number that a thread takes.
const TOGETHER: usize = 64;
const ALONE: usize = 8;
const SITES_TOGETHER: usize = 1 << 15;

/// Share of the energy from which on a filtered contact's opening counts.
const NOTICED: f64 = 1e-20;

/// Puts integrals along the stepping, and their residuals, in place of those from samples.
pub(super) fn close(task: &Task, budget: &mut Budget) -> Result<()> {
    let (motion, contacts, request) = (task.motion, task.contacts, task.request);
    let (observer, samples) = (task.observer, motion.samples());
    let wavenumbers = budget.wavenumber.as_ref().map(|of| of.wavenumber.len());
    let mut waiting = Waiting::new(task.sink);
    let (passed, count) = (
        LargeArray::INTEGRATED_SPECTRAL_FLUX,
        wavenumbers.unwrap_or(0),
    );
    waiting.reserve(passed, (samples, count), None)?;
    if budget.scale == 0.0 {
        // Nothing moves, and there is no speed to measure errors of steps by.
        waiting.push(passed, &vec![0.0; samples * count]);
        return waiting.hand_on(samples);
    }
    let chain = motion.chain;
    let first = motion.at(0);
    let resonators = chain.resonators();
    let mut simulation = Simulation {
        displacement: first.x.to_vec(),
        velocity: first.v.to_vec(),
        resonators: resonators.map(|_| first.resonators.map(<[f64]>::to_vec)),
        drive: motion.drive.cloned(),
        ..Simulation::impact(chain.clone(), 0.0, motion.duration(), 2)
    };
    if chain.has_pulls() {
        simulation.scheme = Scheme::RungeKutta;
    }
    let transfers = Transfers::new(contacts, None);
    let scales = budget.scales.as_ref();
    let scales = scales.map(|_| Scales::new(contacts, chain, request));
    let scales = scales.transpose()?;
    let evaluation = Evaluation {
        contacts,
        transfers: wavenumbers.map(|_| &transfers),
        scales: scales.as_ref().map(|scales| (scales, scales.mapped())),
    };
    let edge = budget.frequency.as_ref().map(|flow| flow.edge);
    let flows = edge.map(|edge| NodeFlows::new(contacts, request, [edge, motion.duration()]));
    let longest = flows.as_ref().map(NodeFlows::longest_step);
    let longest = longest.unwrap_or(f64::INFINITY);
    let mut followed = Followed {
        motion,
        balances: Balances::new(&evaluation, motion, GivenRate::Transfer, None),
        evaluation,
        flows,
        waiting,
        outcome: Ok(()),
        departure: 0.0,
        noticed: NOTICED * budget.scale,
        places: Vec::new(),
        visited: 0,
        filtered: Filtered::default(),
    };
    let times: Vec<f64> = motion.time.iter().map(|t| t - motion.time[0]).collect();
    observer.stage("integrals inside the stepping", times.len() as u64);
    simulation.along(&times, [LOCAL_ERROR, longest], observer, &mut followed)?;
    followed.evaluate();
    let Followed {
        balances,
        flows,
        outcome,
        departure,
        ..
    } = followed;
    outcome?;
    if let (Some(flows), Some(found)) = (flows, &mut budget.frequency) {
        found.refined = flows.finish(&balances.sites.exchanged.passed);
        budget.closure.frequency = budget.relative(balances.sites.worst());
    }
    if let (Some(passage), Some(found)) = (balances.passage, budget.wavenumber.take()) {
        budget.closure.departure = budget.relative(departure).value();
        passage.finish(found, budget);
    }
    if let Some(balance) = balances.scales.first() {
        let residual = budget.relative(balance.worst());
        if let Some(found) = &mut budget.scales {
            let followed = |of: &ScaleOf| residual.value().filter(|_| of.scale == found.map_scale);
            found.residual = found.scales.iter().map(followed).collect();
        }
        budget.closure.scale = residual;
    }
    budget.closure.integration = Integration::Stepping;
    Ok(())
}

struct Followed<'a, 'm> {
    motion: &'a Motion<'m>,
    evaluation: Evaluation<'a>,
    balances: Balances,
    /// Power flows through chosen contacts.
    flows: Option<NodeFlows>,
    waiting: Waiting<'a>,
    /// What the sink yielded first that is no success.
    outcome: Result<()>,
    /// The largest difference of E(k) from that of the record.
    departure: f64,
    /// Energy of a filtered contact whose opening counts.
    noticed: f64,
    /// Places on the way, of which the first ones wait to be evaluated.
    places: Vec<Visited>,
    visited: usize,
    filtered: Filtered,
}

/// A place on the way, and the terms there.
#[derive(Debug, Default)]
struct Visited {
    visit: Option<Node>,
    t: f64,
    x: Vec<f64>,
    v: Vec<f64>,
    resonators: [Vec<f64>; 2],
    terms: PlaceTerms,
    /// `E(k)` of the record, at a sample.
    recorded: Vec<f64>,
    /// Force and mean speed of the chosen contacts.
    through: Vec<[f64; 2]>,
}

impl Followed<'_, '_> {
    /// Evaluates the places that wait, on all threads, and adds them up in order.
    fn evaluate(&mut self) {
        let (motion, evaluation, flows) = (self.motion, &self.evaluation, &self.flows);
        let mut places = std::mem::take(&mut self.places);
        let visited = &mut places[..std::mem::take(&mut self.visited)];
        let each = visited.par_iter_mut().with_min_len(ALONE);
        each.for_each_init(PlaceScratch::default, |scratch, place| {
            let at = NodeState {
                t: motion.time[0] + place.t,
                x: &place.x,
                v: &place.v,
                resonators: place.resonators.each_ref().map(|row| &row[..]),
            };
            evaluation.evaluate(at, scratch, &mut place.terms);
            if let (Some(transfers), Some(Node::Sample(i))) = (evaluation.transfers, place.visit) {
                place.recorded = transfers.energies(motion.at(i));
            }
            if let Some(flows) = flows {
                place.through = flows.through(evaluation.contacts, at.v, &scratch.contacts);
            }
        });
        visited.iter().for_each(|place| self.add(place));
        self.places = places;
    }

    fn add(&mut self, place: &Visited) {
        match place.visit {
            Some(Node::Node(weight)) => {
                self.balances.add(weight, &place.terms);
                if let Some(flows) = &mut self.flows {
                    flows.add(weight, place.t, &place.through);
                }
            }
            Some(Node::Sample(i)) => {
                self.balances.compare(i, &place.terms);
                let Some(passage) = &self.balances.passage else {
                    return;
                };
                let array = LargeArray::INTEGRATED_SPECTRAL_FLUX;
                self.waiting.push(array, passage.passed());
                let end = i + 1;
                if self.outcome.is_ok() && (end == self.motion.samples() || end % BATCH == 0) {
                    self.outcome = self.waiting.hand_on(end);
                }
                let pairs = place.terms.spectra.energy.iter().zip(&place.recorded);
                let off: Vec<f64> = pairs.map(|(a, b)| (a - b).abs()).collect();
                self.departure = worst_of(self.departure, &off);
            }
            None => {}
        }
    }
}

impl NodeVisitor for Followed<'_, '_> {
    fn visit(&mut self, visit: Node, place: NodeState) {
        if self.visited == self.places.len() {
            self.places.push(Visited::default());
        }
        let next = &mut self.places[self.visited];
        (next.visit, next.t) = (Some(visit), place.t);
        let own = next.resonators.iter_mut().zip(place.resonators);
        let bodies = [(&mut next.x, place.x), (&mut next.v, place.v)];
        for (kept, row) in bodies.into_iter().chain(own) {
            kept.clear();
            kept.extend_from_slice(row);
        }
        self.visited += 1;
        let most = SITES_TOGETHER / place.x.len().max(1);
        if self.visited >= most.clamp(ALONE, TOGETHER) {
            self.evaluate();
        }
    }

    /// Filtered contacts open at other times than the contacts.
    fn cusps(&mut self, from: NodeState, to: NodeState) -> Vec<f64> {
        let Some((scales, [planned])) = self.evaluation.scales else {
            return Vec::new();
        };
        let (h, t0) = (to.t - from.t, self.motion.time[0]);
        let [start, end] = [from, to].map(|place| {
            let t = t0 + place.t;
            scales.overlaps(planned, NodeState { t, ..place }, &mut self.filtered)
        });
        let (contacts, offset) = (scales.contacts, scales.contacts.offset);
        let mut cusps = Vec::new();
        for j in planned.contacts.clone() {
            let Some(opening) = contacts.opens_at(j + offset) else {
                return cusps;
            };
            let of =
                |rows: &[Vec<f64>; 3]| [rows[0][j] - opening, h * rows[1][j], h * h * rows[2][j]];
            let (start, end) = (of(&start), of(&end));
            let [a, b, way] = [start[0].abs(), end[0].abs(), start[1].abs() + end[1].abs()];
            let most = a.max(b).max(way) + opening;
            let energy = contacts.each[j + offset].energy(most);
            let passes = (start[0] > 0.0) != (end[0] > 0.0);
            let turns = a.min(b) < way && start[1] * end[1] < 0.0;
            if energy >= self.noticed && (passes || turns) {
                let path = Quintic::hermite(start, end);
                cusps.extend(openings(&path).map(|share| from.t + h * share));
            }
        }
        cusps
    }
}
