//! The delay of a site behind the reference.

use std::f64::consts::{PI, TAU};

use column_fft::{Columns, ColumnsMut, ComplexToRealColumns};
use ndarray::{Array2, s};
use num_complex::Complex;
use rayon::prelude::*;

use crate::estimates::realisations::TOGETHER;
use crate::numeric::lanes::{LaneBlock, on_lines};

/// The delay of a site behind the reference.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Delay {
    /// In units of time; positive where the site follows the reference.
    pub delay: f64,
    /// Standard error, if the records differ by a delay and independent noise.
    pub error: f64,
    /// Frequencies that are coherent.
    pub frequencies: usize,
}

/// Points of the search for each one of a transform, which has at least as many as a segment has samples.
const FINER: usize = 4;
/// Bytes of a point of a plan.
const PLAN: usize = 32;
/// Least coherent frequencies.
const LEAST: usize = 2;

/// Finds delays, by the maximum of
///
/// ```text
/// C(tau) = sum_f W(f) cos(phase(f) + 2 pi f tau),    W = g / (1 - g),
/// ```
///
/// over coherent frequencies between 0 and the Nyquist frequency, `g` the magnitude-squared coherence:
/// the maximum-likelihood estimate. Its variance is `B / (2 K sum (2 pi f)^2 W)`, with the `B` bins that the
/// taper spreads a frequency over.
///
/// Source: C. H. Knapp, G. C. Carter, IEEE Trans. Acoust. Speech Signal Process. 24, 320 (1976).
///
/// The points of the search are those of [`FINER`] transforms, of which each is a part of a point behind the one
/// before: a transform of all of them would take as many times the memory.
pub(super) struct DelaySearch {
    transform: ComplexToRealColumns<f64>,
    /// `exp(2 pi i f tau)` of each bin, with tau the distance of two points.
    next: Vec<Complex<f64>>,
    length: usize,
    dt: f64,
    shared_bins: f64,
}

/// Working space of one thread.
#[derive(Default)]
struct Scratch {
    /// Of each site.
    coherent: [Vec<Coherent>; TOGETHER],
    sums: Vec<Complex<f64>>,
    found: Vec<f64>,
    columns: Vec<Complex<f64>>,
}

/// A coherent frequency: its bin, weight and phase.
#[derive(Debug, Clone, Copy)]
struct Coherent {
    bin: f64,
    weight: f64,
    phase: f64,
}

impl DelaySearch {
    pub fn new(length: usize, dt: f64, shared_bins: f64) -> Self {
        let points = length.next_power_of_two();
        let angle = TAU / (FINER * points) as f64;
        let next = |m: usize| Complex::from_polar(1.0, angle * m as f64);
        DelaySearch {
            transform: ComplexToRealColumns::new(points).expect("at least four samples"),
            next: (0..length.div_ceil(2)).map(next).collect(),
            length,
            dt,
            shared_bins,
        }
    }

    /// Bytes of the search in segments of `length` samples, by so many threads.
    pub fn working_bytes(length: usize, threads: u64) -> u64 {
        let points = length.next_power_of_two();
        let bins = length.div_ceil(2);
        let lines = size_of::<LaneBlock>();
        let sums = 16 * (points / 2 + 1) * TOGETHER + 8 * points * TOGETHER + 2 * lines;
        let columns = 16 * ComplexToRealColumns::<f64>::scratch_len_of(points);
        let coherent = size_of::<Coherent>() * bins * TOGETHER;
        (16 * bins + PLAN * points) as u64 + threads * (sums + columns + coherent) as u64
    }

    /// The delay of each site, from the coherence and the phase of its cross-spectrum, `(frequency, site)`; `None`
    /// with fewer than two coherent frequencies, those above the level. `known`: the level and the number of
    /// independent realisations of each site, NaN where there are none.
    pub fn find(
        &self,
        coherence: &Array2<f64>,
        phase: &Array2<f64>,
        known: &[[f64; 2]],
    ) -> Vec<Option<Delay>> {
        let tiles = known.par_chunks(TOGETHER).enumerate();
        let found = tiles.map_init(Scratch::default, |scratch, (tile, known)| {
            let sites = tile * TOGETHER..tile * TOGETHER + known.len();
            let inside = 1..self.length.div_ceil(2);
            let cells = s![inside.clone(), sites];
            let (coherence, phase) = (coherence.slice(cells), phase.slice(cells));
            for site in &mut scratch.coherent {
                site.clear();
                site.reserve_exact(inside.len());
            }
            let rows = coherence.outer_iter().zip(phase.outer_iter());
            for (m, (coherence, phase)) in inside.zip(rows) {
                let cells = coherence.iter().zip(phase).zip(known);
                let sites = scratch.coherent.iter_mut().zip(cells);
                for (site, ((g, phase), [level, _])) in sites {
                    if g > level {
                        site.push(Coherent {
                            bin: m as f64,
                            weight: g / (1.0 - g).max(f64::EPSILON),
                            phase: *phase,
                        });
                    }
                }
            }
            self.of_tile(known, scratch)
        });
        let found: Vec<Vec<Option<Delay>>> = found.collect();
        found.concat()
    }

    /// The same of a few sites, whose coherent frequencies are in `scratch`.
    fn of_tile(&self, known: &[[f64; 2]], scratch: &mut Scratch) -> Vec<Option<Delay>> {
        if scratch.coherent.iter().all(|site| site.len() < LEAST) {
            return vec![None; known.len()];
        }
        let largest = self.largest(scratch);
        let sites = scratch.coherent.iter().zip(known).zip(largest);
        sites
            .map(|((site, [_, independent]), largest)| {
                (site.len() >= LEAST).then(|| self.refined(site, largest, *independent))
            })
            .collect()
    }

    /// The points of the search with the largest sums.
    fn largest(&self, scratch: &mut Scratch) -> [usize; TOGETHER] {
        let (points, bins) = (self.transform.len(), self.transform.bins());
        let Scratch {
            coherent,
            sums,
            found,
            columns,
        } = scratch;
        let sums = on_lines(sums, bins * TOGETHER);
        sums.fill(Complex::default());
        for (lane, site) in coherent.iter().enumerate() {
            for one in site {
                let place = one.bin as usize * TOGETHER + lane;
                sums[place] = Complex::from_polar(one.weight, one.phase);
            }
        }
        let found = on_lines(found, points * TOGETHER);
        columns.resize(self.transform.scratch_len(), Complex::default());
        let (mut most, mut at) = ([f64::NEG_INFINITY; TOGETHER], [0; TOGETHER]);
        for behind in 0..FINER {
            if behind > 0 {
                let rows = sums.chunks_exact_mut(TOGETHER).zip(&self.next);
                rows.for_each(|(row, next)| row.iter_mut().for_each(|sum| *sum *= next));
            }
            let input = Columns::new(&*sums, bins, TOGETHER, TOGETHER);
            let output = ColumnsMut::new(&mut *found, points, TOGETHER, TOGETHER);
            let (input, output) = (input.expect("as long"), output.expect("as long"));
            let transformed = self.transform.process_with_scratch(input, output, columns);
            transformed.expect("shapes of the plan");
            let (rows, _) = found.as_chunks::<TOGETHER>();
            for (n, row) in rows.iter().enumerate() {
                let point = FINER * n + behind;
                for ((most, at), v) in most.iter_mut().zip(&mut at).zip(row) {
                    // Of equal sums the first one.
                    let is_larger = v > most || (v == most && point < *at);
                    *most = if is_larger { *v } else { *most };
                    *at = if is_larger { point } else { *at };
                }
            }
        }
        at
    }

    /// The maximum next to a point of the search.
    fn refined(&self, coherent: &[Coherent], largest: usize, independent: f64) -> Delay {
        let points = FINER * self.transform.len();
        let signed = match 2 * largest > points {
            true => largest as f64 - points as f64,
            false => largest as f64,
        };
        // In cycles of the lowest frequency.
        let mut tau = signed / points as f64;
        for _ in 0..8 {
            let (mut slope, mut bend) = (0.0, 0.0);
            for one in coherent {
                let (sin, cos) = (one.phase + TAU * one.bin * tau).sin_cos();
                slope -= one.weight * one.bin * sin;
                bend -= one.weight * one.bin * one.bin * cos;
            }
            // Within the lobe that the search found.
            let step = slope / bend / TAU;
            if bend >= 0.0 || step.abs() > 1.0 / points as f64 {
                break;
            }
            tau -= step;
            if step.abs() <= f64::EPSILON * tau.abs() {
                break;
            }
        }
        let information: f64 = coherent
            .iter()
            .map(|one| one.weight * one.bin * one.bin)
            .sum();
        let period = self.length as f64 * self.dt;
        let variance = self.shared_bins / (2.0 * independent * information);
        Delay {
            delay: tau * period,
            error: variance.sqrt() / (2.0 * PI) * period,
            frequencies: coherent.len(),
        }
    }
}
