//! Whether momenta balance, and which contact coefficients would make them.
//!
//! `m_j (v_j(t) - v_j(t0))` is the integral of the forces on site j. Displacements do not depend on
//! the coefficients, so with factors `s_i` of them the momentum that no force explains is linear in
//! `s_i - 1`: `rho_j - (s_{j-1} - 1) P_{j-1} + (s_j - 1) P_j`, P the integrals of the elastic
//! forces. Its squares over all sites and times, each weighted with its own error, are least at the
//! factors reported. Their errors are those of the repetitions, and
//! what half of the samples find another factor by.

use ndarray::{Array1, Array2, ArrayView1, s};

use super::derive::{Derived, MotionArrays};
use super::estimate::raised;
use crate::budget::contacts::Contacts;
use crate::numeric::median;

/// Standard errors beyond which a deviation is none of chance.
const SIGNIFICANT: f64 = 4.0;

/// Factors of the coefficients, less 1.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// One for each contact; `None` where nothing depends on it.
    pub(super) each: Vec<Option<f64>>,
    /// The same for all.
    pub(super) all: f64,
}

/// What fits yield, also when the measurement is repeated, and with half of its samples.
pub(super) struct Fits {
    pub(super) here: Fit,
    pub(super) repeated: Vec<Fit>,
    pub(super) halved: Fit,
}

/// The balance of momentum of one site.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SiteMomentum {
    /// Root mean square over time of the momentum that no force explains.
    pub residual: f64,
    /// What noise, drift and sampling explain of it.
    pub expected: f64,
}

impl SiteMomentum {
    /// Whether noise explains the residual.
    pub fn is_closed(&self) -> bool {
        self.residual <= SIGNIFICANT * self.expected
    }
}

/// A factor of a coefficient with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Factor {
    pub factor: f64,
    pub error: f64,
}

impl Factor {
    /// Whether chance does not explain that it differs from 1.
    pub fn is_off(&self) -> bool {
        (self.factor - 1.0).abs() > SIGNIFICANT * self.error
    }
}

/// The balance of momentum along the chain.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Momentum {
    pub sites: Vec<SiteMomentum>,
    /// Factor by which the coefficient of each contact would fit best; `None` for contacts whose
    /// factor is not known to better than 1.
    pub factors: Vec<Option<Factor>>,
    /// The best common factor of all coefficients.
    pub common: Factor,
}

/// Which contacts push each site, and the weights of its momentum.
pub(super) struct Fitter {
    /// Contacts and the signs of their forces, for each site.
    pushes: Vec<Vec<(usize, f64)>>,
    contacts: usize,
    offset: usize,
    /// `(time, site)`.
    weight: Array2<f64>,
}

impl Fitter {
    /// `open`: variance of the momentum that noise leaves open, `(time, site)`.
    pub(super) fn new(contacts: &Contacts, open: &Array2<f64>) -> Fitter {
        let mut pushes = vec![Vec::new(); open.ncols()];
        for i in 0..contacts.each.len() {
            let [left, right] = contacts.each[i].sites;
            for (site, sign) in [(left, -1.0), (right, 1.0)] {
                if let Some(site) = site {
                    pushes[site].push((i, sign));
                }
            }
        }
        // Momenta known to rounding must not outweigh all others together.
        let most = open.iter().fold(0.0, |m: f64, e| m.max(*e));
        let weight = |open: f64| match most > 0.0 {
            true => most / open.max(1e-9 * most),
            false => 1.0,
        };
        Fitter {
            pushes,
            contacts: contacts.each.len(),
            offset: contacts.offset,
            weight: open.mapv(weight),
        }
    }

    /// The best-fitting factors, from every `every`-th sample.
    pub(super) fn fit(&self, derived: &Derived, every: usize) -> Fit {
        let mut normal: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.contacts];
        let mut right = vec![0.0; self.contacts];
        let (mut common_right, mut common_left) = (0.0, 0.0);
        for (site, list) in self.pushes.iter().enumerate() {
            let weight = self.weight.slice(s![..;every, site]);
            let residual = derived.values.unbalanced.column(site);
            let pushed = list.iter();
            let pushed = pushed.map(|(i, sign)| *sign * &derived.impulse.column(*i));
            let pushed: Vec<Array1<f64>> = pushed.collect();
            let mut all = Array1::zeros(residual.len());
            for ((i, _), pushed_by) in list.iter().zip(&pushed) {
                let weighted = pushed_by * &weight;
                right[*i] += weighted.dot(&residual);
                for ((k, _), other) in list.iter().zip(&pushed) {
                    normal[*i].push((*k, weighted.dot(other)));
                }
                all += pushed_by;
            }
            let weighted = &all * &weight;
            common_left += weighted.dot(&all);
            common_right += weighted.dot(&residual);
        }
        let each = solve(&normal, &right);
        Fit {
            each: each.into_iter().skip(self.offset).collect(),
            all: match common_left > 0.0 {
                true => common_right / common_left,
                false => 0.0,
            },
        }
    }
}

/// Solves the normal equations by conjugate gradients; `None` for unknowns that do not occur.
fn solve(rows: &[Vec<(usize, f64)>], right: &[f64]) -> Vec<Option<f64>> {
    // Unknowns are scaled so that the diagonal is 1.
    let own = |(i, row): (usize, &Vec<(usize, f64)>)| -> f64 {
        row.iter().filter(|(k, _)| *k == i).map(|(_, a)| a).sum()
    };
    let diagonal: Vec<f64> = rows.iter().enumerate().map(own).collect();
    let inverse = |d: &f64| if *d > 0.0 { d.sqrt().recip() } else { 0.0 };
    let scale: Array1<f64> = diagonal.iter().map(inverse).collect();
    let apply = |x: &Array1<f64>| -> Array1<f64> {
        let x = x * &scale;
        let sum = |row: &Vec<(usize, f64)>| row.iter().map(|(k, a)| a * x[*k]).sum::<f64>();
        rows.iter().map(sum).collect::<Array1<f64>>() * &scale
    };
    let mut x = Array1::zeros(right.len());
    let mut rest = &ArrayView1::from(right) * &scale;
    let mut direction = rest.clone();
    let mut squares = rest.dot(&rest);
    let enough = 1e-24 * squares;
    for _ in 0..4 * right.len() {
        let applied = apply(&direction);
        let step = squares / direction.dot(&applied);
        if squares <= enough || !step.is_finite() {
            break;
        }
        x.scaled_add(step, &direction);
        rest.scaled_add(-step, &applied);
        let next = rest.dot(&rest);
        direction = direction * (next / squares) + &rest;
        squares = next;
    }
    let solved = x.iter().zip(&scale).zip(diagonal);
    solved
        .map(|((x, scale), d)| (d > 0.0).then_some(x * scale))
        .collect()
}

impl Momentum {
    pub(super) fn of(derived: &Derived, errors: &MotionArrays, fits: &Fits) -> Momentum {
        let Fits {
            here: fit,
            halved,
            repeated: fits,
        } = fits;
        let rms = |array: &Array2<f64>, j: usize| {
            let column = array.column(j);
            (column.dot(&column) / column.len() as f64).sqrt()
        };
        let raised = raised(fits.len());
        let factor = |here: f64, again: &mut dyn Iterator<Item = f64>, sampling: f64| {
            let squares: f64 = again.map(|again| (again - here).powi(2)).sum();
            let error = raised * (squares / fits.len() as f64).sqrt();
            Factor {
                factor: 1.0 + here,
                error: error.hypot(sampling),
            }
        };
        let sampling = fit.each.iter().zip(&halved.each);
        let sampling = sampling.map(|(a, b)| (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs());
        let sampling: Vec<f64> = sampling.collect();
        // One difference may be small by chance.
        let typical = median(sampling.iter().copied()).unwrap_or(0.0);
        let factors = fit.each.iter().enumerate().map(|(i, here)| {
            let mut again = fits.iter().filter_map(|fit| fit.each[i]);
            Some(factor((*here)?, &mut again, sampling[i].max(typical)))
                .filter(|factor| factor.error < 1.0)
        });
        let unbalanced = &derived.values.unbalanced;
        let sites = (0..unbalanced.ncols()).map(|j| SiteMomentum {
            residual: rms(unbalanced, j),
            expected: rms(&errors.unbalanced, j),
        });
        let mut again = fits.iter().map(|fit| fit.all);
        Momentum {
            sites: sites.collect(),
            factors: factors.collect(),
            common: factor(fit.all, &mut again, (halved.all - fit.all).abs()),
        }
    }
}
