//! Power flow by frequency through each contact.
//!
//! `P_j(f) = w Re(conj(F^_j) vbar^_j)`, `vbar_j = (v_j + v_{j+1}) / 2`, with `w = 2` but 1 at `f = 0`
//! and, for an even number of samples, at Nyquist. The end samples of F are halved, so that
//! `sum P_j df` is the trapezoid sum of `F_j vbar_j`. This is `W_j` at the end of the record.
//!
//! Forces open like `t^{3/2}`, so the sum of `P_j(f) df` converges to `W_j` with order 5/2 in the
//! time between samples, for every quadrature rule. Inside the stepping the integrals of F and vbar are
//! those of Gauss's rule between contact openings: exact to the stepping's error, without an upper end of the spectrum, whose
//! sum is the integral of `F_j vbar_j`.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use column_fft::{RealToComplex, rows};
use ndarray::{Array2, ArrayView1, Axis, s};
use rayon::prelude::*;

use super::Task;
use super::contacts::{ContactState, Contacts};
use super::modes::forward;
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::Budget;
use super::wavenumber::dot;
use crate::arrays::LargeArray;
use crate::diagnostics::{Keep, MAP_LIMIT, Map, MapBuilder, edge_of};
use crate::error::Result;
use crate::numeric::{at_or_below, count_at_or_below, sum};
use crate::transform::{fold, frequencies};

/// Largest frequency of the map, in units of the band edge.
const SHOWN: f64 = 5.0;

/// Bins of a low band at most: beyond, next to nothing passes.
const MOST_BINS: usize = 1 << 18;

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
    /// Chosen contacts, integrated inside the stepping; empty if the chain was not integrated again.
    pub refined: Vec<RefinedFlow>,
    /// `P_j(f)` over contacts, up to a few times the edge.
    pub map: Map,
}

/// The power flow of a contact, integrated inside the stepping.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RefinedFlow {
    pub contact: usize,
    /// Sums of the spectrum below the edge, and above.
    pub low: f64,
    pub high: f64,
    /// Energy passed: the sum of both.
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
    let shown = frequency.partition_point(|f| *f <= SHOWN * edge);
    let shown = shown.max(2).min(bins);
    let map = Mutex::new(MapBuilder::new((shown, m.max(1)), MAP_LIMIT, Keep::Extreme));
    let blocks: Vec<usize> = (0..m).step_by(BLOCK).collect();
    let bands: Vec<Vec<[f64; 2]>> = blocks
        .into_par_iter()
        .map(|first| {
            observer.go_on()?;
            let block = first..(first + BLOCK).min(m);
            let width = block.len();
            let [mut forces, speeds] = records(motion, contacts, block);
            let mut block = Array2::zeros((bins, width));
            let mut bands = Vec::with_capacity(width);
            let forces = forces.chunks_exact_mut(samples);
            let records = forces.zip(speeds.chunks_exact(samples));
            for (mut column, (force, speed)) in block.columns_mut().into_iter().zip(records) {
                for end in [0, samples - 1] {
                    force[end] *= 0.5;
                }
                let [force, speed] = [&*force, speed].map(|record| forward(&*plan, record));
                let power = |bin: usize| dt * dt * fold(bin, samples) * dot(force[bin], speed[bin]);
                let power: Vec<f64> = (0..bins).map(power).collect();
                let (low, high) = power.split_at(low_bins);
                bands.push([low, high].map(|band| df * sum(band)));
                column.assign(&ArrayView1::from(&power));
            }
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
        map: map.finish(None, label, (&f, 0.0, df), x),
        low,
        high,
        frequency,
        edge,
    };
    let pairs = request.between.iter();
    flow.chosen = pairs.map(|[a, b]| flow.between(*a, *b)).collect();
    Ok(flow)
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
    let Some(record) = forces.find(moves) else {
        return f64::NAN;
    };
    let spectrum = forward(plan, &record).into_iter().enumerate();
    let power = spectrum.map(|(m, z)| fold(m, samples) * z.norm_sqr());
    let power: Vec<f64> = power.collect();
    edge_of(&power, frequency).unwrap_or(f64::NAN)
}

/// Points of the grid on either side over which a value is spread: integrals are then right to 1e-12.
const SPREAD: usize = 12;

/// Power flows through chosen contacts, from Fourier integrals of forces and mean speeds over a record that are known at
/// the nodes of a quadrature: each node is spread over a few points of a grid, which is transformed.
///
/// Source: L. Greengard, J.-Y. Lee, SIAM Review 46 (2004) 443-454, Gaussian gridding.
pub(super) struct NodeFlows {
    chosen: Vec<usize>,
    duration: f64,
    /// Of the low band, at `m / duration`.
    bins: usize,
    /// Of the force and the mean speed of each contact.
    grids: Vec<[Vec<f64>; 2]>,
}

impl NodeFlows {
    /// Of a record whose low band ends at the frequency `edge`.
    pub(super) fn new(
        contacts: &Contacts,
        request: &BudgetRequest,
        [edge, duration]: [f64; 2],
    ) -> NodeFlows {
        let chosen = chosen(contacts, request);
        let is_low = |m: &usize| at_or_below(*m as f64 / duration, edge);
        let bins = (0..MOST_BINS).take_while(is_low).count();
        let points = (4 * bins).next_power_of_two().max(4 * SPREAD);
        let grids = |_| [0, 1].map(|_| vec![0.0; points]);
        NodeFlows {
            grids: chosen.iter().map(grids).collect(),
            chosen,
            duration,
            bins,
        }
    }

    /// The longest step that resolves the low band.
    pub(super) fn longest_step(&self) -> f64 {
        0.5 * self.duration / self.bins as f64
    }

    /// Force and mean speed of the chosen contacts.
    pub(super) fn through(
        &self,
        contacts: &Contacts,
        v: &[f64],
        state: &ContactState,
    ) -> Vec<[f64; 2]> {
        let of = |j: &usize| contacts.force_and_speed([j + contacts.offset; 2], v, state);
        self.chosen.iter().map(of).collect()
    }

    /// Adds a node of this weight, at this time of the record.
    pub(super) fn add(&mut self, weight: f64, t: f64, through: &[[f64; 2]]) {
        for (grids, values) in self.grids.iter_mut().zip(through) {
            let points = grids[0].len();
            let at = t / self.duration * points as f64;
            for k in (0..2 * SPREAD).map(|i| at.floor() + i as f64 - (SPREAD - 1) as f64) {
                let share = weight * (-0.75 * PI / SPREAD as f64 * (k - at).powi(2)).exp();
                let place = k.rem_euclid(points as f64) as usize;
                for (grid, value) in grids.iter_mut().zip(values) {
                    grid[place] += share * value;
                }
            }
        }
    }

    /// The flows, of which the high band is what is left of the energy passed through each contact.
    pub(super) fn finish(self, passed: &[f64]) -> Vec<RefinedFlow> {
        let (bins, duration) = (self.bins, self.duration);
        let flows = self.chosen.into_iter().zip(self.grids);
        let flows = flows.map(|(contact, grids)| {
            let points = grids[0].len();
            let plan = rows::plan_fft_forward(points);
            let [force, speed] = grids.map(|grid| forward(&*plan, &grid));
            // What spreading takes off a component, squared.
            let width = 8.0 * PI * SPREAD as f64 / (3.0 * (points * points) as f64);
            let narrowed = |m: usize| 0.75 / SPREAD as f64 * (width * (m * m) as f64).exp();
            let power = |m: usize| narrowed(m) * fold(m, points) * dot(force[m], speed[m]);
            let low = (0..bins).map(power).sum::<f64>() / duration;
            RefinedFlow {
                contact,
                low,
                high: passed[contact] - low,
                passed: passed[contact],
            }
        });
        flows.collect()
    }
}

/// The usual contacts between two sites, and the requested ones.
fn chosen(contacts: &Contacts, request: &BudgetRequest) -> Vec<usize> {
    let chain = contacts.chain;
    let joins = |j: &usize| matches!(contacts.each[j + contacts.offset].sites, [Some(_), Some(_)]);
    let mut chosen = usual(chain.n_contacts().min(chain.n_sites() - 1));
    chosen.extend(request.between.iter().flatten().filter(|j| joins(j)));
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
