//! Power flow by frequency through each contact.
//!
//! `P_j(f) = w Re(conj(F^_j) vbar^_j)`, `vbar_j = (v_j + v_{j+1}) / 2`, with `w = 2` but 1 at `f = 0`
//! and, for an even number of samples, at Nyquist. The end samples of F are halved, so that
//! `sum P_j df` is the trapezoid sum of `F_j vbar_j`. This is `W_j` at the end of the record.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use column_fft::{RealToComplex, rows};
use ndarray::{Array2, Axis, s};
use rayon::prelude::*;

use super::contacts::{Contacts, PowerRow};
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::Budget;
use super::wavenumber::dot;
use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{MAP_LIMIT, Map, MapBuilder, edge_of};
use crate::error::Result;
use crate::numeric::count_at_or_below;
use crate::observer::Observer;
use crate::transform::fold;

/// Largest frequency of the map, in units of the band edge.
const SHOWN: f64 = 5.0;

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

/// Default pairs of contacts: first to middle, middle to last, first to last.
pub(crate) fn usual_pairs(budget: &Budget) -> Vec<[usize; 2]> {
    let inner = budget.n_contacts.min(budget.n_sites.saturating_sub(1));
    match inner {
        0 | 1 => Vec::new(),
        2 => vec![[0, 1]],
        n => vec![[0, n / 2], [n / 2, n - 1], [0, n - 1]],
    }
}

/// Computes power-flow spectra of all contacts; the arrays are `(frequency, contact)`.
pub(super) fn power_flow(
    motion: &Motion,
    contacts: &Contacts,
    request: &BudgetRequest,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<FrequencyFlow> {
    let (samples, m) = (motion.samples(), motion.chain.n_contacts());
    let dt = motion.step();
    let frequency = crate::transform::frequencies(samples, dt);
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
    let weights: Vec<f64> = (0..bins).map(|bin| dt * dt * fold(bin, samples)).collect();
    let blocks: Vec<usize> = (0..m).step_by(BLOCK).collect();
    let sums: Vec<Vec<[f64; 2]>> = blocks
        .into_par_iter()
        .map(|first| {
            observer.go_on()?;
            let block = first..(first + BLOCK).min(m);
            let width = block.len();
            let [mut forces, mut speeds] = records(motion, contacts, block);
            let [mut of_force, mut of_speed] = [0, 1].map(|_| plan.make_output_vec());
            let mut work = plan.make_scratch_vec();
            let mut powers = Array2::zeros((width, bins));
            let mut bands = Vec::with_capacity(width);
            let records = forces
                .chunks_exact_mut(samples)
                .zip(speeds.chunks_exact_mut(samples));
            for (power, (force, speed)) in powers.rows_mut().into_iter().zip(records) {
                force[0] *= 0.5;
                force[samples - 1] *= 0.5;
                // The lengths are the plan's own, so these cannot fail.
                let _ = plan.process_with_scratch(force, &mut of_force, &mut work);
                let _ = plan.process_with_scratch(speed, &mut of_speed, &mut work);
                let power = power.into_slice().unwrap_or_default();
                let spectra = of_force.iter().zip(&of_speed).zip(&weights);
                for (power, ((force, speed), weight)) in power.iter_mut().zip(spectra) {
                    *power = weight * dot(*force, *speed);
                }
                let (low, high) = power.split_at(low_bins);
                bands.push([low, high].map(|band| df * crate::numeric::sum(band)));
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
    let bands: Vec<[f64; 2]> = sums.into_iter().flatten().collect();
    let map = map.into_inner().unwrap_or_else(PoisonError::into_inner);
    let units = &request.units;
    let (f, x) = (units.frequency(), units.position());
    let x = (&*x, 0.5 * request.pitch, request.pitch);
    let label = units.energy_per_frequency("power flow P(f)");
    let mut flow = FrequencyFlow {
        chosen: Vec::new(),
        refined: Vec::new(),
        map: map.finish(label, (&f, 0.0, df), x),
        low: bands.iter().map(|[low, _]| *low).collect(),
        high: bands.iter().map(|[_, high]| *high).collect(),
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

/// Forces and mean speeds of up to [`BLOCK`] contacts; `(contact, time)`, row-major.
fn records(motion: &Motion, contacts: &Contacts, block: Range<usize>) -> [Vec<f64>; 2] {
    let samples = motion.samples();
    let mut records = [0, 1].map(|_| vec![0.0; block.len() * samples]);
    let mut row = PowerRow::default();
    // Tiled transposition: direct writes to all records would cause cache-set conflicts.
    let mut tiles = [[[0.0; TILE]; BLOCK]; 2];
    for first in (0..samples).step_by(TILE) {
        let count = TILE.min(samples - first);
        for i in 0..count {
            contacts.forces_and_speeds(block.clone(), motion.at(first + i), &mut row);
            for (tile, row) in tiles.iter_mut().zip([&row.force, &row.speed]) {
                for (column, value) in tile.iter_mut().zip(row) {
                    column[i] = *value;
                }
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
