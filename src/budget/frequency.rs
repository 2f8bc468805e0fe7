//! Power flow by frequency through each contact.
//!
//! `P_j(f) = w Re(conj(F^_j) vbar^_j)`, `vbar_j = (v_j + v_{j+1}) / 2`, with `w = 2` but 1 at `f = 0`
//! and, for an even number of samples, at Nyquist; the end samples of F are halved, so that
//! `sum P_j df` is the trapezoid sum of `F_j vbar_j`, which is `W_j` at the end of the record.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use ndarray::{Array2, s};
use num_complex::Complex;

use super::contacts::Contacts;
use super::motion::Motion;
use super::request::BudgetRequest;
use super::waiting::MAP_LIMIT;
use super::wavenumber::dot;
use crate::analyze::{LargeArray, Map, Observer, Sink};
use crate::diagnostics::{MapBuilder, edge_of};
use crate::error::{Error, Result};
use crate::transform::{RealTransform, Scratch, fold};

/// Frequencies shown, in units of the band edge.
const SHOWN: f64 = 5.0;

/// Contacts whose records are transformed together.
const BLOCK: usize = 16;

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
    /// `P_j(f)` over contacts, up to a few times the edge.
    pub map: Map,
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
    let plan = RealTransform::<f64>::new(&vec![1.0; samples], samples);
    let edge = request.band_edge_frequency;
    let edge = edge.unwrap_or_else(|| default_edge(motion, contacts, &plan, &frequency));
    let low_bins = frequency.partition_point(|f| *f <= edge * (1.0 + 1e-9));
    sink.reserve(LargeArray::PowerFlow, (frequency.len(), m))?;
    observer.stage("power flow", m as u64);
    let df = 1.0 / (samples as f64 * dt);
    // Above a few times the edge there is hardly anything to see.
    let shown = frequency
        .partition_point(|f| *f <= SHOWN * edge)
        .max(2)
        .min(frequency.len());
    let map = Mutex::new(MapBuilder::extreme((shown, m.max(1)), MAP_LIMIT));
    let blocks: Vec<usize> = (0..m).step_by(BLOCK).collect();
    let sums: Vec<Vec<[f64; 2]>> = blocks
        .into_par_iter()
        .map(|first| {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let width = BLOCK.min(m - first);
            let mut block = Array2::zeros((frequency.len(), width));
            let [mut forces, mut speeds] = [0, 1].map(|_| vec![vec![0.0; samples]; width]);
            for i in 0..samples {
                let at = motion.at(i);
                for (j, (force, speed)) in forces.iter_mut().zip(&mut speeds).enumerate() {
                    (force[i], speed[i]) = contacts.force_and_speed(first + j, at);
                }
            }
            let (mut of_force, mut of_speed) = (Scratch::default(), Scratch::default());
            for (j, (force, speed)) in forces.iter_mut().zip(&speeds).enumerate() {
                force[0] *= 0.5;
                force[samples - 1] *= 0.5;
                let (force, _) = plan.transform(force, &mut of_force);
                let (speed, _) = plan.transform(speed, &mut of_speed);
                let mut column = block.column_mut(j);
                let pairs = column.iter_mut().zip(force.iter().zip(speed)).enumerate();
                for (bin, (out, (force, speed))) in pairs {
                    let power = dot(*force, *speed);
                    *out = dt * dt * fold(bin, samples) * power;
                }
            }
            sink.put(LargeArray::PowerFlow, 0, first, block.view())?;
            if let Ok(mut map) = map.lock() {
                map.add(0, first, block.slice(s![..shown, ..]));
            }
            observer.advance(width as u64);
            let sum = |bins: std::ops::Range<usize>, j: usize| {
                df * crate::sum::sum(&block.slice(s![bins, j]).to_vec())
            };
            let bands = |j| [sum(0..low_bins, j), sum(low_bins..frequency.len(), j)];
            Ok((0..width).map(bands).collect())
        })
        .collect::<Result<_>>()?;
    let bands: Vec<[f64; 2]> = sums.into_iter().flatten().collect();
    let map = map.into_inner().unwrap_or_else(PoisonError::into_inner);
    let units = &request.units;
    let (f, x) = (units.frequency(), units.position());
    let x = (&*x, 0.5 * request.pitch, request.pitch);
    let label = units.energy("power flow P(f), energy per unit of frequency");
    Ok(FrequencyFlow {
        map: map.finish(label, (&f, 0.0, df), x),
        low: bands.iter().map(|[low, _]| *low).collect(),
        high: bands.iter().map(|[_, high]| *high).collect(),
        frequency,
        edge,
    })
}

/// The frequency below which 90 % of the energy of the first contact's force lies: that of a site's
/// velocity would be that of its drift after the impact.
fn default_edge(
    motion: &Motion,
    contacts: &Contacts,
    plan: &RealTransform<f64>,
    frequency: &[f64],
) -> f64 {
    let samples = motion.samples();
    let record = |j: usize| -> Vec<f64> {
        (0..samples)
            .map(|i| contacts.force_and_speed(j, motion.at(i)).0)
            .collect()
    };
    let mut records = (0..motion.chain.n_contacts()).map(record);
    let Some(record) = records.find(|record| record.iter().any(|force| *force != 0.0)) else {
        return f64::NAN;
    };
    let mut scratch = Scratch::default();
    let (spectrum, _) = plan.transform(&record, &mut scratch);
    let fold = |m: usize, z: &Complex<f64>| fold(m, samples) * z.norm_sqr();
    let power: Vec<f64> = spectrum
        .iter()
        .enumerate()
        .map(|(m, z)| fold(m, z))
        .collect();
    edge_of(&power, frequency).unwrap_or(f64::NAN)
}
