//! Integrals of rates inside the stepping: the chain is stepped anew from its first sample.

use rayon::prelude::*;

use super::Task;
use super::balance::{GivenRate, Passage, RunningBalance, worst_of};
use super::contacts::{ContactState, Contacts};
use super::filter::ScaleOf;
use super::frequency::NodeFlows;
use super::modes::{Basis, Modes};
use super::motion::Motion;
use super::real_space::{Exchanged, SiteBalance, SiteTerms};
use super::result::{Budget, Integration};
use super::scale::{PlannedFilter, Scales};
use super::scale_terms::{ScaleScratch, ScaleTerms};
use super::waiting::{BATCH, Waiting};
use super::wavenumber::{Terms, Transfers};
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
    let observer = task.observer;
    let wavenumbers = budget.wavenumber.as_ref().map(|of| of.wavenumber.len());
    let mut waiting = Waiting::new(task.sink);
    if let Some(count) = wavenumbers {
        let shape = (motion.samples(), count);
        waiting.reserve(LargeArray::INTEGRATED_SPECTRAL_FLUX, shape, None)?;
    }
    if budget.scale == 0.0 {
        // Nothing moves, and there is no speed to measure errors of steps by.
        let all = vec![0.0; motion.samples() * wavenumbers.unwrap_or(0)];
        waiting.push(LargeArray::INTEGRATED_SPECTRAL_FLUX, &all);
        return waiting.hand_on(motion.samples());
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
    let modes = Modes::new(Basis::of(chain.ends), chain.n_sites());
    let transfers = Transfers::new(contacts, modes, None, motion.drive.is_some());
    let scales = budget.scales.as_ref();
    let scales = scales.map(|_| Scales::new(contacts, chain, request));
    let scales = scales.transpose()?;
    let flow = budget.frequency.as_ref().map(|flow| PowerFlux {
        contacts,
        flows: NodeFlows::new(contacts, request, flow.edge, motion.duration()),
        exchanged: Exchanged::none(chain),
        balance: SiteBalance::new(0..motion.samples(), 0..chain.n_sites(), contacts),
    });
    let longest = flow
        .as_ref()
        .map_or(f64::INFINITY, |flow| flow.flows.longest_step());
    let mut followed = Followed {
        motion,
        flow,
        spectral: wavenumbers.map(|count| SpectralFlux {
            transfers: &transfers,
            passage: Passage::new(GivenRate::Transfer, motion.samples(), count),
            waiting,
            outcome: Ok(()),
            departure: 0.0,
        }),
        scale: match (&scales, &budget.scales) {
            (Some(scales), Some(found)) => {
                let mut all = scales.scales.iter();
                let planned = all.find(|planned| planned.of.scale == found.map_scale);
                planned.map(|planned| ScaleFlux {
                    scratch: ScaleScratch::default(),
                    scales,
                    planned,
                    balance: RunningBalance::default(),
                    noticed: NOTICED * budget.scale,
                })
            }
            _ => None,
        },
        places: Vec::new(),
        waiting: 0,
    };
    let times: Vec<f64> = motion.time.iter().map(|t| t - motion.time[0]).collect();
    observer.stage("integrals inside the stepping", times.len() as u64);
    simulation.along(&times, [LOCAL_ERROR, longest], observer, &mut followed)?;
    followed.evaluate();
    let Followed {
        spectral,
        scale,
        flow,
        ..
    } = followed;
    if let Some(flow) = flow {
        budget.closure.frequency = budget.relative(flow.balance.worst());
        if let Some(found) = &mut budget.frequency {
            found.refined = flow.flows.finish(&flow.exchanged.passed);
        }
    }
    if let Some(spectral) = spectral {
        spectral.put_into(budget)?;
    }
    if let Some(scale) = scale {
        let residual = budget.relative(scale.balance.worst());
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
    spectral: Option<SpectralFlux<'a>>,
    scale: Option<ScaleFlux<'a>>,
    flow: Option<PowerFlux<'a>>,
    /// Places on the way, of which the first ones wait to be evaluated.
    places: Vec<Visited>,
    waiting: usize,
}

/// A place on the way, and the terms there.
#[derive(Debug, Default)]
struct Visited {
    visit: Option<Node>,
    t: f64,
    x: Vec<f64>,
    v: Vec<f64>,
    resonators: [Vec<f64>; 2],
    spectral: Terms,
    /// `E(k)` of the record, at a sample.
    recorded: Vec<f64>,
    scale: ScaleTerms,
    sites: SiteTerms,
    /// Force and mean speed of the chosen contacts.
    through: Vec<[f64; 2]>,
}

struct SpectralFlux<'a> {
    transfers: &'a Transfers<'a>,
    passage: Passage,
    waiting: Waiting<'a>,
    /// What the sink yielded first that is no success.
    outcome: Result<()>,
    /// The largest difference of E(k) from that of the record.
    departure: f64,
}

impl SpectralFlux<'_> {
    fn add(&mut self, place: &Visited, samples: usize) {
        let terms = &place.spectral;
        match place.visit {
            Some(Node::Node(weight)) => self.passage.add(weight, terms),
            Some(Node::Sample(i)) => {
                let row = self.passage.sample(i, &terms.energy);
                self.waiting.push(LargeArray::INTEGRATED_SPECTRAL_FLUX, row);
                let end = i + 1;
                if self.outcome.is_ok() && (end == samples || end % BATCH == 0) {
                    self.outcome = self.waiting.hand_on(end);
                }
                let pairs = terms.energy.iter().zip(&place.recorded);
                let off: Vec<f64> = pairs.map(|(a, b)| (a - b).abs()).collect();
                self.departure = worst_of(self.departure, &off);
            }
            None => {}
        }
    }

    fn put_into(self, budget: &mut Budget) -> Result<()> {
        self.outcome?;
        budget.closure.departure = budget.relative(self.departure).value();
        if let Some(found) = budget.wavenumber.take() {
            self.passage.finish(found, budget);
        }
        Ok(())
    }
}

struct ScaleFlux<'a> {
    scales: &'a Scales<'a>,
    planned: &'a PlannedFilter,
    scratch: ScaleScratch,
    balance: RunningBalance,
    /// Energy of a filtered contact whose opening counts.
    noticed: f64,
}

/// What passes contacts, and whether the energies of the sites change by it.
struct PowerFlux<'a> {
    contacts: &'a Contacts<'a>,
    flows: NodeFlows,
    exchanged: Exchanged,
    balance: SiteBalance,
}

impl PowerFlux<'_> {
    fn add(&mut self, place: &Visited) {
        match place.visit {
            Some(Node::Node(weight)) => {
                self.exchanged.add(weight, &place.sites);
                self.flows.add(weight, place.t, &place.through);
            }
            Some(Node::Sample(i)) => self.balance.follow(i, &place.sites.energy, &self.exchanged),
            None => {}
        }
    }
}

impl Followed<'_, '_> {
    /// Evaluates the places that wait, on all threads, and adds them up in order.
    fn evaluate(&mut self) {
        let (motion, spectral, scale) = (self.motion, &mut self.spectral, &mut self.scale);
        let places = &mut self.places[..std::mem::take(&mut self.waiting)];
        let transfers = spectral.as_ref().map(|flux| flux.transfers);
        let scales = scale.as_ref().map(|flux| (flux.scales, flux.planned));
        let flow = &mut self.flow;
        let flows = flow.as_ref().map(|flux| (flux.contacts, &flux.flows));
        let scratch = || {
            let of_spectra = transfers.map(Transfers::scratch);
            (of_spectra, ScaleScratch::default(), ContactState::default())
        };
        places.par_iter_mut().with_min_len(ALONE).for_each_init(
            scratch,
            |(of_spectra, of_scales, of_sites), place| {
                let at = NodeState {
                    t: motion.time[0] + place.t,
                    x: &place.x,
                    v: &place.v,
                    resonators: place.resonators.each_ref().map(|row| &row[..]),
                };
                if let (Some(transfers), Some(scratch)) = (transfers, of_spectra.as_mut()) {
                    transfers.evaluate(at, scratch, &mut place.spectral);
                    if let Some(Node::Sample(i)) = place.visit {
                        place.recorded = transfers.energies(motion.at(i));
                    }
                }
                if let Some((contacts, flows)) = flows {
                    let state = match of_spectra.as_ref() {
                        Some(scratch) => &scratch.contacts,
                        None => {
                            contacts.evaluate(at, of_sites);
                            &*of_sites
                        }
                    };
                    place.sites.evaluate(contacts, at, state);
                    place.through = flows.through(contacts, at.v, state);
                }
                if let Some((scales, planned)) = scales {
                    scales.load(at, of_scales);
                    scales.terms(planned, of_scales, &mut place.scale);
                }
            },
        );
        for place in places {
            if let Some(flow) = flow {
                flow.add(place);
            }
            if let Some(flux) = spectral {
                flux.add(place, motion.samples());
            }
            if let Some(flux) = scale {
                match place.visit {
                    Some(Node::Node(weight)) => flux.balance.add(weight, &place.scale.energy_rate),
                    _ => flux.balance.compare(&place.scale.energy),
                }
            }
        }
    }
}

impl NodeVisitor for Followed<'_, '_> {
    fn visit(&mut self, visit: Node, place: NodeState) {
        if self.waiting == self.places.len() {
            self.places.push(Visited::default());
        }
        let next = &mut self.places[self.waiting];
        (next.visit, next.t) = (Some(visit), place.t);
        let own = next.resonators.iter_mut().zip(place.resonators);
        let bodies = [(&mut next.x, place.x), (&mut next.v, place.v)];
        for (kept, row) in bodies.into_iter().chain(own) {
            kept.clear();
            kept.extend_from_slice(row);
        }
        self.waiting += 1;
        let most = SITES_TOGETHER / place.x.len().max(1);
        if self.waiting >= most.clamp(ALONE, TOGETHER) {
            self.evaluate();
        }
    }

    /// Filtered contacts open at other times than the contacts.
    fn cusps(&mut self, from: NodeState, to: NodeState) -> Vec<f64> {
        let Some(scale) = &mut self.scale else {
            return Vec::new();
        };
        let (scales, planned) = (scale.scales, scale.planned);
        let (h, t0) = (to.t - from.t, self.motion.time[0]);
        let [start, end] = [from, to]
            .map(|place| NodeState {
                t: t0 + place.t,
                ..place
            })
            .map(|place| scales.overlaps(planned, place, &mut scale.scratch));
        let (contacts, offset) = (scales.contacts, scales.contacts.offset);
        let mut cusps = Vec::new();
        for j in planned.contacts.clone() {
            let Some(opening) = contacts.opens_at(j + offset) else {
                return cusps;
            };
            let of =
                |rows: &[Vec<f64>; 3]| [rows[0][j] - opening, h * rows[1][j], h * h * rows[2][j]];
            let (start, end) = (of(&start), of(&end));
            let most = start[0]
                .abs()
                .max(end[0].abs())
                .max(start[1].abs() + end[1].abs());
            if contacts.contact(j + offset).energy(most + opening) < scale.noticed {
                continue;
            }
            let near = start[0].abs().min(end[0].abs()) < start[1].abs() + end[1].abs();
            if (start[0] > 0.0) != (end[0] > 0.0) || (near && start[1] * end[1] < 0.0) {
                let path = Quintic::hermite(start, end);
                cusps.extend(openings(&path).map(|share| from.t + h * share));
            }
        }
        cusps
    }
}
