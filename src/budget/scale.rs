//! Coarse-grained energy flux: energy transferred from scales larger than l to smaller ones.
//!
//! A bar denotes the filter over unit cells, applied to each sublattice separately:
//! `Pi_j = (bar F_j - F_j(bar delta_j)) (bar v_j - bar v_{j+1})`,
//! `e_j = m bar v_j^2 / 2 + [V_{j-1}(bar delta_{j-1}) + V_j(bar delta_j)] / 2`,
//! `J_j = bar F_j (bar v_j + bar v_{j+1}) / 2`, `de_j/dt = J_{j-1} - J_j - (Pi_{j-1} + Pi_j) / 2 - D_j`.
//! Overlaps are filtered with their sign; the contact law then sets negative ones to 0.

use std::ops::Range;

use super::Task;
use super::balance::add;
use super::contacts::Contacts;
use super::filter::{Filter, ScaleOf};
use super::request::BudgetRequest;
use super::result::{Budget, Residual, ScaleBudget};
use super::scale_terms::ScaleTerms;
use super::sublattices::Sublattices;
use super::waiting::Waiting;
use crate::arrays::LargeArray;
use crate::chain::{Chain, Ends};
use crate::diagnostics::Keep;
use crate::error::{Error, Result};
use crate::numeric::sum;

/// Longest unit cell tried, in sites.
const LONGEST_CELL: usize = 8;

/// The scales of a budget, or why the chain has none.
///
/// # Errors
/// As [`Scales::new`], of scales or a filter that were asked for.
pub(super) fn planned<'a>(task: &Task<'a, '_>, budget: &mut Budget) -> Result<Option<Scales<'a>>> {
    let request = task.request;
    match Scales::new(task.contacts, task.stated, request) {
        Ok(scales) => Ok(Some(scales)),
        Err(Error::Request {
            expected, found, ..
        }) if request.scales.is_empty() && request.filter != Filter::Sharp => {
            let reason = format!("expected {expected}, found {found}");
            budget.closure.scale = Residual::Undefined(reason);
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

impl Scales<'_> {
    /// A budget before its first sample.
    pub(super) fn budget(&self) -> ScaleBudget {
        let of_all = |planned: &PlannedFilter| [planned.contacts.start, planned.contacts.end];
        ScaleBudget {
            scales: self.scales.iter().map(|planned| planned.of).collect(),
            contacts: self.scales.iter().map(of_all).collect(),
            integrated_flux: vec![0.0; self.scales.len()],
            map_scale: self.scales[self.mapped].of.scale,
            flux_map: None,
            residual: Vec::new(),
        }
    }

    /// Announces the arrays of so many samples.
    pub(super) fn reserve(&self, samples: usize, waiting: &mut Waiting) -> Result<()> {
        let (m, count) = (self.contacts.chain.n_contacts(), self.scales.len());
        let shown = Some(Keep::Extreme);
        waiting.reserve(LargeArray::SCALE_FLUX, (samples, m), shown)?;
        waiting.reserve(LargeArray::SCALE_FLUX_IN_TIME, (samples, count), None)
    }

    /// Adds the next sample, of this weight.
    pub(super) fn take_in(
        &self,
        weight: f64,
        terms: &[ScaleTerms],
        budget: &mut ScaleBudget,
        waiting: &mut Waiting,
    ) {
        let sums: Vec<f64> = terms.iter().map(|terms| sum(&terms.flux)).collect();
        add(&mut budget.integrated_flux, weight, &sums);
        // Undefined where the filter reaches an end.
        let mut row = vec![f64::NAN; self.contacts.chain.n_contacts()];
        row[self.scales[self.mapped].contacts.clone()].copy_from_slice(&terms[self.mapped].flux);
        waiting.push(LargeArray::SCALE_FLUX, &row);
        waiting.push(LargeArray::SCALE_FLUX_IN_TIME, &sums);
    }

    /// The one that is mapped.
    pub(super) fn mapped(&self) -> &[PlannedFilter] {
        &self.scales[self.mapped..=self.mapped]
    }
}

/// The scale that is mapped: the nearest to the requested one, else the middle one.
fn mapped(scales: &[PlannedFilter], asked: Option<f64>) -> usize {
    let count = scales.len();
    let nearest = asked.and_then(|asked| {
        let off = |i: &usize| (scales[*i].of.scale / asked).ln().abs();
        (0..count).min_by(|a, b| off(a).total_cmp(&off(b)))
    });
    nearest.unwrap_or((count - 1) / 2)
}

/// The filters of all scales of a chain.
pub(super) struct Scales<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) scales: Vec<PlannedFilter>,
    mapped: usize,
    pub(super) sublattices: Sublattices,
}

/// A filter, and the sites and contacts at which it is inside the chain.
#[derive(Debug, Clone)]
pub(super) struct PlannedFilter {
    pub(super) of: ScaleOf,
    /// Gains from [`Sublattices::gains`].
    pub(super) gains: Vec<f64>,
    /// Contacts at which the flux is defined.
    pub(super) contacts: Range<usize>,
    /// Sites at which the balance is defined.
    pub(super) sites: Range<usize>,
}

impl<'a> Scales<'a> {
    /// Plans the filters; the unit cell is that of the chain `stated`.
    ///
    /// # Errors
    /// [`Error::Request`] for a chain without a unit cell, a filter that does not fit it, and
    /// scales that are not positive lengths within the chain.
    pub(super) fn new(
        contacts: &'a Contacts<'a>,
        stated: &Chain,
        request: &BudgetRequest,
    ) -> Result<Scales<'a>> {
        let (filter, scales, pitch) = (request.filter, &request.scales, request.pitch);
        let chain = contacts.chain;
        let n = chain.n_sites();
        let cell = unit_cell(stated).ok_or_else(|| {
            let expected =
                "bodies and contacts that repeat every eight sites or less, for a filter";
            Error::request("scale", expected, "a chain that does not repeat")
        })?;
        let periodic = chain.ends == Ends::Periodic;
        let ends_inside = filter != Filter::Sharp || periodic;
        let expected = "`gaussian` or `box` on a chain with ends, through which `sharp` reaches";
        Error::require(ends_inside, "filter", expected, "sharp")?;
        let whole = !periodic || n.is_multiple_of(cell);
        let found = format!("{n} sites in cells of {cell}");
        Error::require(whole, "scale", "a ring of whole cells", found)?;
        let cells = n.div_ceil(cell);
        let length = pitch * cell as f64;
        // Checked before weights are computed: a filter longer than the chain does not fit.
        let whole = length * cells as f64;
        let within = 1e-6 * length..=whole;
        if let Some(scale) = scales.iter().find(|scale| !within.contains(*scale)) {
            let expected = format!("lengths between a cell, {length}, and the chain, {whole}");
            return Err(Error::request("scale", expected, scale));
        }
        let chosen = match scales.is_empty() {
            true => default_scales(cells).map(|l| l * length).collect(),
            false => scales.clone(),
        };
        let m = chain.n_contacts();
        let sublattices = Sublattices::new(cell, cells);
        let plan = |scale: f64| {
            let of = ScaleOf::new(filter, scale, length, cells);
            // Sites and contacts next to an end may differ from the unit cell; they are excluded.
            let fitting = |count: usize| {
                let edge = (cell * of.reach + 1).min(count);
                // The filter must also fit at the site right of a contact.
                edge..count.saturating_sub(edge + 1).max(edge)
            };
            let (contacts, sites) = match periodic {
                true => (0..m, 0..n),
                false => {
                    let contacts = fitting(m.min(n));
                    // The balance of a site needs the fluxes of both contacts.
                    let sites = contacts.start + 1..contacts.end.max(contacts.start + 1);
                    (contacts, sites)
                }
            };
            PlannedFilter {
                gains: sublattices.gains(&of.gains(length, cells)),
                of,
                contacts,
                sites,
            }
        };
        let all = chosen.into_iter().map(plan);
        let fits =
            |planned: &PlannedFilter| !planned.contacts.is_empty() && !planned.sites.is_empty();
        let is_default = scales.is_empty();
        let scales: Vec<PlannedFilter> = all.filter(|of| !is_default || fits(of)).collect();
        if let Some(planned) = scales.iter().find(|planned| !fits(planned)) {
            let ScaleOf { scale, reach, .. } = planned.of;
            let expected = format!(
                "scales whose filter fits into the chain: {scale} reaches {reach} cells to either side"
            );
            return Err(Error::request("scale", expected, format!("{cells} cells")));
        }
        let expected = "a chain longer than the reach of the smallest filter";
        let found = format!("{cells} cells");
        Error::require(!scales.is_empty(), "scale", expected, found)?;
        Ok(Scales {
            mapped: mapped(&scales, request.map_scale),
            scales,
            contacts,
            sublattices,
        })
    }
}

/// Number of sites in the unit cell, found away from the ends.
fn unit_cell(chain: &Chain) -> Option<usize> {
    let ground = chain.on_site.ground.as_ref();
    let mut rows = vec![&chain.mass, &chain.coefficient];
    rows.extend(ground.map(|ground| &ground.coefficient));
    if let Some(all) = chain.resonators() {
        rows.extend([&all.mass, &all.stiffness, &all.damping]);
    }
    let laws = [&chain.law].into_iter();
    let laws = laws.chain(ground.map(|ground| &ground.law));
    let laws = laws.map(|laws| laws.only().map_or(laws.each().len(), |_| 1));
    let laws: Vec<usize> = laws.collect();
    (1..=LONGEST_CELL).find(|&cell| {
        rows.iter().all(|row| chain.cell(row, cell, 0.0).is_some())
            && laws.iter().all(|laws| cell.is_multiple_of(*laws))
    })
}

/// Default scales in cells: from 2, in ratios of `sqrt(2)`, up to half the chain.
fn default_scales(cells: usize) -> impl Iterator<Item = f64> {
    let scales = (0..).map(|i: i32| 2.0 * 2f64.powf(0.5 * f64::from(i)));
    scales.take_while(move |l| *l <= 0.5 * cells as f64)
}
