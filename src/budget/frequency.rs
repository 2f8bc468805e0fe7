//! Power flow by frequency through each contact.
//!
//! `P_j(f) = w Re(conj(F^_j) vbar^_j)`, `vbar_j = (v_j + v_{j+1}) / 2`, with `w = 2` but 1 at `f = 0`
//! and, for an even number of samples, at Nyquist. The end samples of F are halved, so that
//! `sum P_j df` is the trapezoid sum of `F_j vbar_j`. This is `W_j` at the end of the record.
//!
//! Forces open like `t^{3/2}`, so the sum of `P_j(f) df` converges to `W_j` with order 5/2 in the
//! time between samples, for every quadrature rule. Inside the stepping the chain is therefore stepped
//! again with many more samples than the record has, and the energy passed is integrated inside the
//! same steps. The spectrum then extends far above the frequencies of the record, and its sum closes
//! to the stepping's error.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use column_fft::{RealToComplex, rows};
use ndarray::{Array2, Axis, s};
use num_complex::Complex;
use rayon::prelude::*;

use super::Task;
use super::balance::worst_of;
use super::contacts::{ContactState, Contacts};
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::Budget;
use super::wavenumber::dot;
use crate::arrays::LargeArray;
use crate::chain::{NodeState, Simulation};
use crate::diagnostics::{MAP_LIMIT, Map, MapBuilder, edge_of};
use crate::error::Result;
use crate::numeric::{count_at_or_below, sum};
use crate::observer::Observer;
use crate::transform::{fold, frequencies};

/// Largest frequency of the map, in units of the band edge.
const SHOWN: f64 = 5.0;

/// Intervals between samples; a power of two less one, so that records have a fast length.
const INTERVALS: usize = (1 << 19) - 1;

/// Contacts whose records are transformed together.
const BLOCK: usize = 32;

/// Samples per tile of the transposition: one cache line.
const TILE: usize = 8;

/// Energy passed through each contact, in either band.
#[derive(Debug, Clone)]
pub struct FrequencyFlow {
    /// In cycles per unit of time.
    pub frequency: Vec<f64>,
    /// Upper edge of the low band; NaN where nothing moves.
    pub edge: f64,
    /// Energy passed below the edge, and above; one value per contact.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Changes between the requested pairs of contacts.
    pub chosen: Vec<Between>,
    /// Chosen contacts, from records made inside the stepping; empty if the chain was not integrated
    /// again.
    pub refined: Vec<RefinedFlow>,
    /// `P_j(f)` over contacts, up to a few times the edge.
    pub map: Map,
}

/// The power flow of a contact from a finely sampled record made inside the stepping.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RefinedFlow {
    pub contact: usize,
    /// Sums of the spectrum below the edge, and above.
    pub low: f64,
    pub high: f64,
    /// Energy passed, integrated inside the same steps.
    pub passed: f64,
}

/// Change of the energy passed between two contacts; the three numbers sum to 0.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Between {
    pub contacts: [usize; 2],
    /// Change of the low band.
    pub low: f64,
    /// Change of the high band; it may be negative.
    pub high: f64,
    /// Energy that stayed between the contacts or was lost.
    pub behind: f64,
}

impl FrequencyFlow {
    /// From contact `a` to contact `b`.
    ///
    /// # Panics
    /// If there is no such contact.
    pub fn between(&self, a: usize, b: usize) -> Between {
        let (low, high) = (self.low[b] - self.low[a], self.high[b] - self.high[a]);
        Between {
            contacts: [a, b],
            low,
            high,
            behind: -(low + high),
        }
    }

    /// Energy passed through contact j by the end of the record: the sum of its spectrum.
    pub fn passed(&self, j: usize) -> f64 {
        self.low[j] + self.high[j]
    }
}

/// The first, the middle and the last of so many contacts, each once.
fn usual(inner: usize) -> Vec<usize> {
    let is_usual = |j: &usize| [0, inner / 2, inner - 1].contains(j);
    (0..inner).filter(is_usual).collect()
}

/// Default pairs of contacts: first to middle, middle to last, first to last.
pub(crate) fn usual_pairs(budget: &Budget) -> Vec<[usize; 2]> {
    match usual(budget.n_contacts.min(budget.n_sites.saturating_sub(1)))[..] {
        [first, last] => vec![[first, last]],
        [first, middle, last] => vec![[first, middle], [middle, last], [first, last]],
        _ => Vec::new(),
    }
}

/// Computes power-flow spectra of all contacts; the arrays are `(frequency, contact)`.
pub(super) fn power_flow(task: &Task) -> Result<FrequencyFlow> {
    let (motion, contacts, request) = (task.motion, task.contacts, task.request);
    let (sink, observer) = (task.sink, task.observer);
    let (samples, m) = (motion.samples(), motion.chain.n_contacts());
    let dt = motion.step();
    let frequency = frequencies(samples, dt);
    let bins = frequency.len();
    let plan = rows::plan_fft_forward(samples);
    let edge = request.band_edge_frequency;
    let edge = edge.unwrap_or_else(|| default_edge(motion, contacts, &*plan, &frequency));
    let low_bins = count_at_or_below(&frequency, edge);
    for array in [LargeArray::POWER_FLOW, LargeArray::CUMULATIVE_POWER_FLOW] {
        sink.reserve(array, (bins, m))?;
    }
    observer.stage("power flow", m as u64);
    let df = 1.0 / (samples as f64 * dt);
    let shown = frequency
        .partition_point(|f| *f <= SHOWN * edge)
        .max(2)
        .min(bins);
    let map = Mutex::new(MapBuilder::extreme((shown, m.max(1)), MAP_LIMIT));
    let blocks: Vec<usize> = (0..m).step_by(BLOCK).collect();
    let bands: Vec<Vec<[f64; 2]>> = blocks
        .into_par_iter()
        .map(|first| {
            observer.go_on()?;
            let block = first..(first + BLOCK).min(m);
            let width = block.len();
            let [mut forces, mut speeds] = records(motion, contacts, block);
            let mut spectra = PowerSpectra::new(plan.clone(), dt);
            let mut powers = Array2::zeros((width, bins));
            let mut bands = Vec::with_capacity(width);
            let records = forces
                .chunks_exact_mut(samples)
                .zip(speeds.chunks_exact_mut(samples));
            for (power, (force, speed)) in powers.rows_mut().into_iter().zip(records) {
                let power = power.into_slice().unwrap_or_default();
                spectra.find(force, speed, power);
                let (low, high) = power.split_at(low_bins);
                bands.push([low, high].map(|band| df * sum(band)));
            }
            // Transposed to the layout of the whole array.
            let mut block = Array2::from_shape_fn((bins, width), |(bin, j)| powers[[j, bin]]);
            sink.put(LargeArray::POWER_FLOW, 0, first, block.view())?;
            if let Ok(mut map) = map.lock() {
                map.add(0, first, block.slice(s![..shown, ..]));
            }
            block *= df;
            block.accumulate_axis_inplace(Axis(0), |below, here| *here += below);
            sink.put(LargeArray::CUMULATIVE_POWER_FLOW, 0, first, block.view())?;
            observer.advance(width as u64);
            Ok(bands)
        })
        .collect::<Result<_>>()?;
    let bands = bands.into_iter().flatten();
    let (low, high) = bands.map(<(f64, f64)>::from).unzip();
    let map = map.into_inner().unwrap_or_else(PoisonError::into_inner);
    let units = &request.units;
    let (f, x) = (units.frequency(), units.position());
    let x = (&*x, 0.5 * request.pitch, request.pitch);
    let label = units.energy_per_frequency("power flow P(f)");
    let mut flow = FrequencyFlow {
        chosen: Vec::new(),
        refined: Vec::new(),
        map: map.finish(label, (&f, 0.0, df), x),
        low,
        high,
        frequency,
        edge,
    };
    flow.chosen = request
        .between
        .iter()
        .map(|[a, b]| flow.between(*a, *b))
        .collect();
    Ok(flow)
}

/// Power flows of records of one length.
struct PowerSpectra {
    plan: Arc<dyn RealToComplex<f64>>,
    /// `dt^2`, folded.
    weights: Vec<f64>,
    spectra: [Vec<Complex<f64>>; 2],
    work: Vec<Complex<f64>>,
}

impl PowerSpectra {
    fn new(plan: Arc<dyn RealToComplex<f64>>, dt: f64) -> PowerSpectra {
        let spectra = [0, 1].map(|_| plan.make_output_vec());
        let weight = |bin| dt * dt * fold(bin, plan.len());
        PowerSpectra {
            weights: (0..spectra[0].len()).map(weight).collect(),
            spectra,
            work: plan.make_scratch_vec(),
            plan,
        }
    }

    /// That of a force and a mean speed, which are used up.
    fn find(&mut self, force: &mut [f64], speed: &mut [f64], power: &mut [f64]) {
        for end in [0, force.len() - 1] {
            force[end] *= 0.5;
        }
        for (record, spectrum) in [force, speed].into_iter().zip(&mut self.spectra) {
            // The lengths are the plan's own, so this cannot fail.
            let _ = self
                .plan
                .process_with_scratch(record, spectrum, &mut self.work);
        }
        let spectra = self.spectra[0].iter().zip(&self.spectra[1]);
        for ((power, weight), (force, speed)) in power.iter_mut().zip(&self.weights).zip(spectra) {
            *power = weight * dot(*force, *speed);
        }
    }
}

/// Forces and mean speeds of up to [`BLOCK`] contacts; `(contact, time)`, row-major.
fn records(motion: &Motion, contacts: &Contacts, block: Range<usize>) -> [Vec<f64>; 2] {
    let samples = motion.samples();
    let mut records = [0, 1].map(|_| vec![0.0; block.len() * samples]);
    let mut state = ContactState::default();
    // Tiled transposition: direct writes to all records would cause cache-set conflicts.
    let mut tiles = [[[0.0; TILE]; BLOCK]; 2];
    for first in (0..samples).step_by(TILE) {
        let count = TILE.min(samples - first);
        for (i, time) in (first..first + count).enumerate() {
            let at = motion.at(time);
            let row = contacts.forces_and_speeds(block.clone(), at, &mut state);
            for (j, [force, speed]) in row.enumerate() {
                (tiles[0][j][i], tiles[1][j][i]) = (force, speed);
            }
        }
        for (records, tile) in records.iter_mut().zip(&tiles) {
            for (record, column) in records.chunks_exact_mut(samples).zip(tile) {
                record[first..first + count].copy_from_slice(&column[..count]);
            }
        }
    }
    records
}

/// The frequency below which 90 % of the energy of the force lies, in the first contact with a
/// nonzero force. Velocity is unsuitable: most of its energy is that of the drift after the impact.
fn default_edge(
    motion: &Motion,
    contacts: &Contacts,
    plan: &dyn RealToComplex<f64>,
    frequency: &[f64],
) -> f64 {
    let samples = motion.samples();
    let moves = |record: &Vec<f64>| record.iter().any(|force| *force != 0.0);
    let mut forces = (0..motion.chain.n_contacts()).map(|j| {
        let [force, _] = records(motion, contacts, j..j + 1);
        force
    });
    let Some(mut record) = forces.find(moves) else {
        return f64::NAN;
    };
    let mut spectrum = plan.make_output_vec();
    // The lengths are the plan's own, so this cannot fail.
    let _ = plan.process(&mut record, &mut spectrum);
    let spectrum = spectrum.iter().enumerate();
    let power: Vec<f64> = spectrum
        .map(|(m, z)| fold(m, samples) * z.norm_sqr())
        .collect();
    edge_of(&power, frequency).unwrap_or(f64::NAN)
}

/// Of the record whose low band ends at this frequency.
pub(super) fn refine(
    simulation: &Simulation,
    contacts: &Contacts,
    local_error: f64,
    request: &BudgetRequest,
    [edge, duration]: [f64; 2],
    observer: &dyn Observer,
) -> Result<Vec<RefinedFlow>> {
    let chosen = chosen(contacts, request);
    let samples = INTERVALS + 1;
    let mut records: Vec<[Vec<f64>; 2]> = chosen
        .iter()
        .map(|_| [0, 1].map(|_| Vec::with_capacity(samples)))
        .collect();
    let mut passed = vec![0.0; chosen.len()];
    let times: Vec<f64> = (0..samples)
        .map(|i| duration * (i as f64 / INTERVALS as f64))
        .collect();
    let mut state = ContactState::default();
    let mut keep = |place: NodeState, followed: &[f64]| {
        for ((j, [force, speed]), passed) in chosen.iter().zip(&mut records).zip(&mut passed) {
            for [here, mean] in contacts.forces_and_speeds(*j..j + 1, place, &mut state) {
                force.push(here);
                speed.push(mean);
            }
            *passed = followed[*j];
        }
    };
    simulation.sampled(&times, &chosen, local_error, observer, &mut keep)?;
    let dt = duration / INTERVALS as f64;
    let (df, frequency) = (1.0 / (samples as f64 * dt), frequencies(samples, dt));
    let low_bins = count_at_or_below(&frequency, edge);
    let mut spectra = PowerSpectra::new(rows::plan_fft_forward(samples), dt);
    let mut power = vec![0.0; frequency.len()];
    let flows = chosen.into_iter().zip(records).zip(passed);
    let flows = flows.map(|((contact, [mut force, mut speed]), passed)| {
        spectra.find(&mut force, &mut speed, &mut power);
        let (low, high) = power.split_at(low_bins);
        RefinedFlow {
            contact,
            low: df * sum(low),
            high: df * sum(high),
            passed,
        }
    });
    Ok(flows.collect())
}

/// Puts refined flows, and their residual, in place of that of the samples.
pub(super) fn put_into(budget: &mut Budget, flows: Vec<RefinedFlow>) {
    let off = flows.iter().map(|of| (of.low + of.high - of.passed).abs());
    let off: Vec<f64> = off.collect();
    if !off.is_empty() {
        budget.closure.frequency = budget.relative(worst_of(0.0, &off));
    }
    if let Some(flow) = &mut budget.frequency {
        flow.refined = flows;
    }
}

/// The usual contacts between two sites, and the requested ones.
fn chosen(contacts: &Contacts, request: &BudgetRequest) -> Vec<usize> {
    let chain = contacts.chain();
    let joins = |j: &usize| matches!(contacts.sites(j + contacts.offset), [Some(_), Some(_)]);
    let mut chosen = usual(chain.n_contacts().min(chain.n_sites() - 1));
    chosen.extend(request.between.iter().flatten().filter(|j| joins(j)));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
