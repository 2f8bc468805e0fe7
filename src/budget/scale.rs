//! Coarse-grained energy flux: what leaves the scales larger than l.
//!
//! With a bar for the filter over unit cells, each sublattice by itself,
//! `Pi_j = (bar F_j - F_j(bar delta_j)) (bar v_j - bar v_{j+1})`,
//! `e_j = m bar v_j^2 / 2 + [V_{j-1}(bar delta_{j-1}) + V_j(bar delta_j)] / 2`,
//! `J_j = bar F_j (bar v_j + bar v_{j+1}) / 2`, `de_j/dt = J_{j-1} - J_j - (Pi_{j-1} + Pi_j) / 2 - D_j`.
//! Overlaps are filtered with their sign, then cut at 0 by the law.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::contacts::{ContactState, Contacts};
use super::filter::{Filter, ScaleOf};
use super::motion::Instant;
use crate::chain::{Chain, Ends};
use crate::error::{Error, Result};

/// Longest unit cell that is looked for.
const LONGEST_CELL: usize = 8;

/// The scales of a chain, planned.
pub(super) struct Scales<'a> {
    contacts: &'a Contacts<'a>,
    pub(super) scales: Vec<Planned>,
    /// Sites in a unit cell.
    pub(super) cell: usize,
    /// Cells of the ring that each sublattice is filtered over.
    cells: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    lossy: bool,
}

/// A filter and where it lies inside the chain.
#[derive(Debug, Clone)]
pub(super) struct Planned {
    pub(super) of: ScaleOf,
    gains: Vec<f64>,
    /// Contacts at which the flux is defined.
    pub(super) contacts: Range<usize>,
    /// Sites at which the balance is.
    pub(super) sites: Range<usize>,
}

/// Transforms of all filtered rows, before any gain.
#[derive(Debug, Clone)]
pub(super) struct ScaleScratch {
    pub(super) contacts: ContactState,
    input: Vec<f64>,
    work: Vec<Complex<f64>>,
    back: Vec<Complex<f64>>,
    /// Force, overlap, velocity, damping, each of them sublattice by sublattice.
    transformed: Vec<Vec<Complex<f64>>>,
    filtered: [Vec<f64>; 4],
    /// Forces and energies by the law at the filtered overlaps.
    law: [Vec<f64>; 2],
    apart: Vec<f64>,
    passes: Vec<f64>,
}

/// Rates and energies at one scale.
#[derive(Debug, Clone, Default)]
pub(super) struct ScaleTerms {
    /// At the contacts of [`Planned::contacts`].
    pub(super) flux: Vec<f64>,
    /// At the sites of [`Planned::sites`].
    pub(super) energy: Vec<f64>,
    pub(super) energy_rate: Vec<f64>,
}

impl std::fmt::Debug for Scales<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scales")
            .field("scales", &self.scales)
            .field("cell", &self.cell)
            .finish_non_exhaustive()
    }
}

impl<'a> Scales<'a> {
    /// # Errors
    /// [`Error::Request`] for a chain without a unit cell, a filter that does not fit it, and
    /// scales that are no lengths.
    pub(super) fn new(
        contacts: &'a Contacts<'a>,
        filter: Filter,
        scales: &[f64],
        pitch: f64,
    ) -> Result<Scales<'a>> {
        let refuse = |option, expected: &str, found: String| Error::Request {
            option,
            expected: expected.into(),
            found,
        };
        let chain = contacts.chain();
        let n = chain.n_sites();
        let cell = unit_cell(chain).ok_or_else(|| {
            let expected =
                "masses and contacts that repeat every eight sites or less, for a filter";
            refuse("scale", expected, "a chain that does not repeat".into())
        })?;
        let periodic = chain.ends == Ends::Periodic;
        if filter == Filter::Sharp && !periodic {
            let expected =
                "`gaussian` or `box` on a chain with ends, through which `sharp` reaches";
            return Err(refuse("filter", expected, "sharp".into()));
        }
        if periodic && !n.is_multiple_of(cell) {
            let found = format!("{n} sites in cells of {cell}");
            return Err(refuse("scale", "a ring of whole cells", found));
        }
        if let Some(scale) = scales.iter().find(|l| !(l.is_finite() && **l > 0.0)) {
            return Err(refuse("scale", "positive lengths", scale.to_string()));
        }
        let cells = n.div_ceil(cell);
        let length = pitch * cell as f64;
        let chosen = match scales {
            [] => default_scales(cells).map(|l| l * length).collect(),
            given => given.to_vec(),
        };
        let m = chain.n_contacts();
        let plan = |scale: f64| {
            let of = ScaleOf::new(filter, scale, length, cells);
            // Sites and contacts next to an end are not those of the cell, and neither counts.
            let inside = |count: usize| {
                let edge = cell * of.reach + 1;
                // The site on the right of a contact counts too.
                edge..count.saturating_sub(edge + 1).max(edge)
            };
            let (contacts, sites) = match periodic {
                true => (0..m, 0..n),
                false => {
                    let contacts = inside(m.min(n));
                    // A site needs the contacts on both sides.
                    let sites = contacts.start + 1..contacts.end.max(contacts.start + 1);
                    (contacts, sites)
                }
            };
            Planned {
                gains: of.gains(length, cells),
                of,
                contacts,
                sites,
            }
        };
        let all = chosen.into_iter().map(plan);
        let mut planner = RealFftPlanner::new();
        Ok(Scales {
            scales: match scales {
                [] => all.filter(|planned| !planned.contacts.is_empty()).collect(),
                _ => all.collect(),
            },
            contacts,
            cell,
            cells,
            forward: planner.plan_fft_forward(cells),
            inverse: planner.plan_fft_inverse(cells),
            lossy: chain.losses.any(),
        })
    }

    /// The filter of this scale.
    pub(super) fn at(&self, scale: f64) -> Option<&Planned> {
        self.scales.iter().find(|planned| planned.of.scale == scale)
    }

    pub(super) fn scratch(&self) -> ScaleScratch {
        let work = self
            .forward
            .get_scratch_len()
            .max(self.inverse.get_scratch_len());
        ScaleScratch {
            contacts: ContactState::default(),
            input: self.forward.make_input_vec(),
            work: vec![Complex::default(); work],
            back: self.inverse.make_input_vec(),
            transformed: vec![self.forward.make_output_vec(); 4 * self.cell],
            filtered: Default::default(),
            law: Default::default(),
            apart: Vec::new(),
            passes: Vec::new(),
        }
    }

    /// Transforms the rows of one instant, for [`Scales::terms`] at every scale.
    pub(super) fn load(&self, at: Instant, scratch: &mut ScaleScratch) {
        let ScaleScratch {
            contacts: state, ..
        } = scratch;
        self.contacts.evaluate(at.t, at.x, at.v, state);
        let total: Vec<f64> = match self.lossy {
            true => state
                .elastic
                .iter()
                .zip(&state.damping)
                .map(|(a, b)| a + b)
                .collect(),
            false => Vec::new(),
        };
        let offset = self.contacts.offset;
        let force = match self.lossy {
            true => total,
            false => state.elastic.clone(),
        };
        let (overlap, damping) = (state.overlap.clone(), state.damping.clone());
        self.transform(0, &force[offset..], scratch);
        self.transform(1, &overlap[offset..], scratch);
        self.transform(2, at.v, scratch);
        if self.lossy {
            self.transform(3, &damping[offset..], scratch);
        }
    }

    /// Transforms a row, sublattice by sublattice.
    fn transform(&self, kind: usize, row: &[f64], scratch: &mut ScaleScratch) {
        let ScaleScratch {
            input,
            work,
            transformed,
            ..
        } = scratch;
        for sublattice in 0..self.cell {
            input.fill(0.0);
            let values = row.iter().skip(sublattice).step_by(self.cell);
            for (input, value) in input.iter_mut().zip(values) {
                *input = *value;
            }
            let out = &mut transformed[kind * self.cell + sublattice];
            // The lengths are the plan's own, so this cannot fail.
            let _ = self.forward.process_with_scratch(input, out, work);
        }
    }

    /// Filtered overlaps, their rates and curvatures at an instant, at one scale.
    pub(super) fn overlaps(
        &self,
        planned: &Planned,
        at: Instant,
        scratch: &mut ScaleScratch,
    ) -> [Vec<f64>; 3] {
        self.contacts
            .evaluate(at.t, at.x, at.v, &mut scratch.contacts);
        let acceleration = self.contacts.accelerations(at.v, &scratch.contacts);
        let m = self.contacts.chain().n_contacts();
        let offset = self.contacts.offset;
        let apart = |values: &[f64]| -> Vec<f64> {
            (0..m)
                .map(|j| self.contacts.apart(j + offset, values))
                .collect()
        };
        [at.x, at.v, &acceleration].map(|values| {
            self.transform(1, &apart(values), scratch);
            self.filter(1, planned, scratch);
            scratch.filtered[1].clone()
        })
    }

    /// Flux, energies and their rate of change by fluxes and losses at one scale.
    pub(super) fn terms(&self, planned: &Planned, scratch: &mut ScaleScratch) -> ScaleTerms {
        let chain = self.contacts.chain();
        let (n, m) = (chain.n_sites(), chain.n_contacts());
        for kind in 0..if self.lossy { 4 } else { 3 } {
            self.filter(kind, planned, scratch);
        }
        let ScaleScratch {
            filtered: [force, overlap, speed, damping],
            law: [law_force, energy],
            apart,
            passes,
            ..
        } = scratch;
        for row in [&mut *law_force, energy, apart, passes] {
            row.resize(m, 0.0);
        }
        self.contacts
            .forces_and_energies(&overlap[..m], [law_force, energy]);
        // What the contact takes out of the motion, and what it passes on.
        for j in 0..m {
            let right = if j + 1 < n { j + 1 } else { 0 };
            let (before, after) = (speed[j], speed[right]);
            apart[j] = before - after;
            passes[j] = 0.5 * force[j] * (before + after);
        }
        let friction = |j: usize| if self.lossy { damping[j] } else { 0.0 };
        let flux = |j: usize| (force[j] - friction(j) - law_force[j]) * apart[j];
        let left = |j: usize| if j == 0 { n - 1 } else { j - 1 };
        // With the flux, the losses of contacts make up all of the filtered force but the law's.
        let taken = |j: usize| (force[j] - law_force[j]) * apart[j];
        let drag = chain.losses.drag;
        let sites = planned.sites.clone();
        ScaleTerms {
            flux: planned.contacts.clone().map(flux).collect(),
            energy: sites
                .clone()
                .map(|j| 0.5 * (chain.mass[j] * speed[j] * speed[j] + energy[left(j)] + energy[j]))
                .collect(),
            energy_rate: sites
                .map(|j| {
                    let i = left(j);
                    let lost = drag * speed[j] * speed[j];
                    passes[i] - passes[j] - 0.5 * (taken(i) + taken(j)) - lost
                })
                .collect(),
        }
    }

    fn filter(&self, kind: usize, planned: &Planned, scratch: &mut ScaleScratch) {
        let ScaleScratch {
            input,
            work,
            back,
            transformed,
            filtered,
            ..
        } = scratch;
        let out = &mut filtered[kind];
        out.resize(self.cells * self.cell, 0.0);
        let scale = 1.0 / self.cells as f64;
        for sublattice in 0..self.cell {
            let from = &transformed[kind * self.cell + sublattice];
            for ((back, z), gain) in back.iter_mut().zip(from).zip(&planned.gains) {
                *back = z * (gain * scale);
            }
            let _ = self.inverse.process_with_scratch(back, input, work);
            for (out, value) in out
                .iter_mut()
                .skip(sublattice)
                .step_by(self.cell)
                .zip(&*input)
            {
                *out = *value;
            }
        }
    }
}

/// Sites in the unit cell, away from the ends.
fn unit_cell(chain: &Chain) -> Option<usize> {
    let inside = |values: &'_ [f64]| match chain.ends {
        Ends::Periodic => values.to_vec(),
        _ => values[1.min(values.len())..values.len().saturating_sub(1).max(1).min(values.len())]
            .to_vec(),
    };
    let (mass, coefficient) = (inside(&chain.mass), inside(&chain.coefficient));
    let repeats = |values: &[f64], cell: usize| {
        let pairs = values.iter().zip(values.iter().skip(cell));
        pairs
            .into_iter()
            .all(|(a, b)| (a - b).abs() <= 1e-9 * a.abs())
    };
    (1..=LONGEST_CELL).find(|&cell| repeats(&mass, cell) && repeats(&coefficient, cell))
}

/// In cells: from two on, by the square root of two, to half of all.
fn default_scales(cells: usize) -> impl Iterator<Item = f64> {
    let scale = |i: i32| 2.0 * 2f64.powf(0.5 * f64::from(i));
    (0..)
        .map(scale)
        .take_while(move |l| *l <= 0.5 * cells as f64)
}
