//! Power flow by frequency through each contact.
//!
//! `P_j(f) = w Re(conj(F^_j) vbar^_j)`, `vbar_j = (v_j + v_{j+1}) / 2`, with `w = 2` but 1 at `f = 0`
//! and, for an even number of samples, at Nyquist; the end samples of F are halved, so that
//! `sum P_j df` is the trapezoid sum of `F_j vbar_j`, which is `W_j` at the end of the record.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use ndarray::{Array2, ArrayView1, Axis, s};
use num_complex::Complex;
use rayon::prelude::*;

use super::contacts::{Contacts, PowerRow};
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::low_bins;
use super::waiting::MAP_LIMIT;
use super::wavenumber::dot;
use crate::analyze::{LargeArray, Map, Observer, Sink};
use crate::diagnostics::{MapBuilder, edge_of};
use crate::error::{Error, Result};
use crate::transform::vertical::ColumnScratch;
use crate::transform::{ColumnTransform, fold};

/// Frequencies shown, in units of the band edge.
const SHOWN: f64 = 5.0;

/// Contacts that are worked on together.
const BLOCK: usize = 32;

/// What passed each contact in either band.
#[derive(Debug, Clone)]
pub struct FrequencyFlow {
    /// In cycles per unit of time.
    pub frequency: Vec<f64>,
    /// Upper edge of the low band; NaN where nothing moves.
    pub edge: f64,
    /// Energy passed below the edge, and above; a value a contact.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Between the contacts asked for.
    pub chosen: Vec<Between>,
    /// Chosen contacts from records made inside the stepping; empty where it was not stepped anew.
    pub refined: Vec<RefinedFlow>,
    /// `P_j(f)` over contacts, up to a few times the edge.
    pub map: Map,
}

/// The power flow of a contact from a record as fine as the stepping allows.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RefinedFlow {
    pub contact: usize,
    /// Sums of the spectrum below the edge, and above.
    pub low: f64,
    pub high: f64,
    /// Energy passed, followed inside the same steps.
    pub passed: f64,
}

/// What happened to the energy between two contacts: the three numbers sum to 0.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Between {
    pub contacts: [usize; 2],
    /// What the low band changed by.
    pub low: f64,
    /// What the high band changed by; nothing says that it gains.
    pub high: f64,
    /// What stayed behind or was lost.
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

    /// Energy passed through contact j by the end of the record, as the spectrum sums to.
    pub fn passed(&self, j: usize) -> f64 {
        self.low[j] + self.high[j]
    }
}

/// Power-flow spectra of all contacts, handed on as `(frequency, contact)`.
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
    let plan = ColumnTransform::<f64>::new(samples);
    let edge = request.band_edge_frequency;
    let edge = edge.unwrap_or_else(|| default_edge(motion, contacts, &plan, &frequency));
    let low_bins = low_bins(&frequency, edge);
    for array in [LargeArray::PowerFlow, LargeArray::CumulativePowerFlow] {
        sink.reserve(array, (bins, m))?;
    }
    observer.stage("power flow", m as u64);
    let df = 1.0 / (samples as f64 * dt);
    // Above a few times the edge there is hardly anything to see.
    let shown = frequency
        .partition_point(|f| *f <= SHOWN * edge)
        .max(2)
        .min(bins);
    let map = Mutex::new(MapBuilder::extreme((shown, m.max(1)), MAP_LIMIT));
    let weights: Vec<f64> = (0..bins).map(|bin| dt * dt * fold(bin, samples)).collect();
    let blocks: Vec<usize> = (0..m).step_by(BLOCK).collect();
    let sums: Vec<Vec<[f64; 2]>> = blocks
        .into_par_iter()
        .map_init(Working::default, |working, first| {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let contacts_of_block = first..(first + BLOCK).min(m);
            let width = contacts_of_block.len();
            let [mut forces, speeds] = records(motion, contacts, contacts_of_block);
            for end in [0, samples - 1] {
                forces.row_mut(end).mapv_inplace(|force| 0.5 * force);
            }
            let [of_force, of_speed] = working.spectra(&plan, [&forces, &speeds]);
            let mut block = Array2::zeros((bins, width));
            let spectra = of_force.outer_iter().zip(of_speed.outer_iter());
            let rows = block.rows_mut().into_iter().zip(spectra).zip(&weights);
            for ((mut powers, (forces, speeds)), weight) in rows {
                for (power, (force, speed)) in powers.iter_mut().zip(forces.iter().zip(&speeds)) {
                    *power = weight * dot(*force, *speed);
                }
            }
            let band = |band: ArrayView1<f64>| df * crate::sum::sum(&band.to_vec());
            let bands: Vec<[f64; 2]> = block
                .columns()
                .into_iter()
                .map(|powers| {
                    let (low, high) = powers.split_at(Axis(0), low_bins);
                    [band(low), band(high)]
                })
                .collect();
            sink.put(LargeArray::PowerFlow, 0, first, block.view())?;
            if let Ok(mut map) = map.lock() {
                map.add(0, first, block.slice(s![..shown, ..]));
            }
            block *= df;
            block.accumulate_axis_inplace(Axis(0), |below, here| *here += below);
            sink.put(LargeArray::CumulativePowerFlow, 0, first, block.view())?;
            observer.advance(width as u64);
            Ok(bands)
        })
        .collect::<Result<_>>()?;
    let bands: Vec<[f64; 2]> = sums.into_iter().flatten().collect();
    let map = map.into_inner().unwrap_or_else(PoisonError::into_inner);
    let units = &request.units;
    let (f, x) = (units.frequency(), units.position());
    let x = (&*x, 0.5 * request.pitch, request.pitch);
    let label = units.energy("power flow P(f), energy per unit of frequency");
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

/// What one thread keeps from block to block.
#[derive(Default)]
struct Working {
    spectra: [Array2<Complex<f64>>; 2],
    scratch: Option<ColumnScratch<f64>>,
}

impl Working {
    /// The spectra of two arrays `(time, contact)`.
    fn spectra(
        &mut self,
        plan: &ColumnTransform<f64>,
        records: [&Array2<f64>; 2],
    ) -> &[Array2<Complex<f64>>; 2] {
        let width = records[0].ncols();
        let scratch = self.scratch.get_or_insert_with(|| plan.scratch(BLOCK));
        for (spectra, records) in self.spectra.iter_mut().zip(records) {
            if spectra.ncols() != width {
                *spectra = Array2::default((plan.bins(), width));
            }
            plan.transform(records.view(), spectra.view_mut(), scratch);
        }
        &self.spectra
    }
}

/// Forces and mean speeds of neighbouring contacts, `(time, contact)`.
fn records(motion: &Motion, contacts: &Contacts, block: Range<usize>) -> [Array2<f64>; 2] {
    let shape = (motion.samples(), block.len());
    let [mut forces, mut speeds] = [0, 1].map(|_| Array2::zeros(shape));
    let mut row = PowerRow::default();
    for n in 0..motion.samples() {
        contacts.forces_and_speeds(block.clone(), motion.at(n), &mut row);
        forces.row_mut(n).assign(&ArrayView1::from(&row.force));
        speeds.row_mut(n).assign(&ArrayView1::from(&row.speed));
    }
    [forces, speeds]
}

/// The frequency below which 90 % of the energy of the first contact's force lies: that of a site's
/// velocity would be that of its drift after the impact.
fn default_edge(
    motion: &Motion,
    contacts: &Contacts,
    plan: &ColumnTransform<f64>,
    frequency: &[f64],
) -> f64 {
    let samples = motion.samples();
    let mut forces = (0..motion.chain.n_contacts()).map(|j| {
        let [force, _] = records(motion, contacts, j..j + 1);
        force
    });
    let Some(force) = forces.find(|force| force.iter().any(|force| *force != 0.0)) else {
        return f64::NAN;
    };
    let mut spectrum = Array2::default((plan.bins(), 1));
    plan.transform(force.view(), spectrum.view_mut(), &mut plan.scratch(1));
    let power: Vec<f64> = { spectrum.iter().enumerate() }
        .map(|(m, z)| fold(m, samples) * z.norm_sqr())
        .collect();
    edge_of(&power, frequency).unwrap_or(f64::NAN)
}
