//! Chains as periodic lines of contacts.

use std::sync::Arc;

use column_fft::{RealToComplex, rows};
use num_complex::Complex;

use super::QuadraticLaw;
use super::kernel::{Components, Grid};
use crate::budget::contacts::{ContactState, Contacts};
use crate::budget::modes::forward;
use crate::budget::motion::Motion;
use crate::budget::wavenumber::dot;
use crate::chain::{Chain, Ends, Law};
use crate::error::{Error, Result};
use crate::transform::fold;

/// Masses and coefficients that differ by less are equal.
const EQUAL: f64 = 1e-12;

/// What refusals name: the record, of whose chain they are.
const RUN: &str = "record";

/// The motion of a chain of equal masses and contacts with a quadratic force.
pub(super) struct QuadraticChain<'a> {
    pub motion: Motion<'a>,
    contacts: Contacts<'a>,
    pub law: QuadraticLaw,
    pub grid: Grid,
    plan: Arc<dyn RealToComplex<f64>>,
}

impl<'a> QuadraticChain<'a> {
    pub fn of(motion: &Motion<'a>) -> Result<Self> {
        let chain = motion.chain;
        let [mass, coefficient] = [&chain.mass, &chain.coefficient].map(|all| all[0]);
        let left = match &chain.ends {
            Ends::Fixed { left_coefficient } => std::slice::from_ref(left_coefficient),
            _ => &[],
        };
        let coefficients = chain.coefficient.iter().chain(left);
        for (what, mut all, first) in [
            ("masses", chain.mass.iter().chain(&[]), mass),
            ("coefficients", coefficients, coefficient),
        ] {
            if let Some(other) = all.find(|other| (**other - first).abs() > EQUAL * first) {
                let expected = "equal masses and equal contacts, whose waves are sines";
                let found = format!("{what} {first} and {other}");
                return Err(Error::request(RUN, expected, found));
            }
        }
        let (linear, quadratic) = expansion(chain, coefficient)?;
        let sites = chain.n_sites();
        let points = match left.is_empty() {
            true => sites,
            false => 2 * (sites + 1),
        };
        Error::require(points >= 3, RUN, "three or more", sites)?;
        Ok(QuadraticChain {
            contacts: Contacts::of(motion),
            motion: *motion,
            law: QuadraticLaw {
                mass,
                linear,
                quadratic,
            },
            grid: Grid {
                points,
                components: points / 2 + 1,
            },
            plan: rows::plan_fft_forward(points),
        })
    }

    /// Values of contacts over a period; a chain between walls is continued by its mirror image, one with free ends by a
    /// contact without force.
    fn of_contacts(&self, values: &[f64]) -> Vec<f64> {
        let mut row = values.to_vec();
        match self.motion.chain.ends {
            Ends::Fixed { .. } => row.extend(values.iter().rev()),
            _ => row.resize(self.grid.points, 0.0),
        }
        row
    }

    /// Values of sites over a period.
    fn of_sites(&self, values: &[f64]) -> Vec<f64> {
        match self.motion.chain.ends {
            Ends::Fixed { .. } => {
                let mirrored = values.iter().rev().map(|value| -value);
                let wall = std::iter::once(0.0);
                let first = wall.clone().chain(values.iter().copied());
                first.chain(wall).chain(mirrored).collect()
            }
            _ => values.to_vec(),
        }
    }
}

/// The linear and the quadratic coefficient of the force about the static state.
fn expansion(chain: &Chain, coefficient: f64) -> Result<(f64, f64)> {
    let Some(law) = chain.law.only().filter(|_| !chain.on_site.any()) else {
        let expected =
            "one law for all contacts, by which the quadratic term is the same everywhere";
        let found = "several laws, springs to the ground or resonators";
        return Err(Error::request(RUN, expected, found));
    };
    let d0 = law.static_overlap(coefficient, chain.precompression);
    let quadratic = law.quadratic(coefficient, d0);
    let expected = "contacts with a quadratic term about their static state: precompressed ones, or springs with alpha";
    let found = match quadratic {
        None => "contacts that just touch, whose force has no expansion in powers",
        Some(_) => "a force without one, so that no triads exchange energy",
    };
    let quadratic = quadratic.filter(|quadratic| *quadratic != 0.0);
    let quadratic = quadratic.ok_or_else(|| Error::request(RUN, expected, found))?;
    Ok((law.stiffness(coefficient, d0, 0.0), quadratic))
}

impl QuadraticChain<'_> {
    /// Whether the law has terms beyond the quadratic one.
    pub fn has_more(&self) -> bool {
        let law = self.motion.chain.law.only();
        !matches!(law, Some(Law::Spring { beta: 0.0, .. }))
    }

    /// Fourier coefficients of a row over a period, divided by the number of places.
    fn coefficients(&self, row: &[f64]) -> Vec<Complex<f64>> {
        let mut all = forward(&*self.plan, row);
        for value in &mut all {
            *value /= row.len() as f64;
        }
        all
    }

    pub fn components(&self, sample: usize) -> Components {
        let at = self.motion.at(sample);
        let mut state = ContactState::default();
        self.contacts.evaluate(at, &mut state);
        let (r, closing) = (&state.overlap, &state.closing);
        let law = self.law;
        let product: Vec<f64> = r.iter().map(|r| law.quadratic * r * r).collect();
        let rates = r.iter().zip(closing);
        let rates = rates.map(|(r, rate)| 2.0 * law.quadratic * r * rate);
        let product_rate: Vec<f64> = rates.collect();
        let forces = state.elastic.iter().zip(r).zip(&product);
        let rest = forces.map(|((force, r), product)| force - law.linear * r - product);
        let rest: Vec<f64> = rest.collect();
        let [value, rate, product, product_rate, rest] =
            [r, closing, &product, &product_rate, &rest]
                .map(|row| self.coefficients(&self.of_contacts(row)));
        let velocity = self.coefficients(&self.of_sites(at.v));
        // A chain between walls is half of its period.
        let half = if self.contacts.offset == 1 { 0.5 } else { 1.0 };
        let places = half * self.grid.points as f64;
        let weight = |k: usize| places * fold(k, self.grid.points);
        let energy = |k: usize| {
            let kinetic = 0.5 * law.mass * velocity[k].norm_sqr();
            let linear = 0.5 * law.linear * value[k].norm_sqr();
            weight(k) * (kinetic + linear + dot(value[k], product[k]) / 3.0)
        };
        let transfer = |k: usize| {
            let gain = dot(value[k], product_rate[k]) - 2.0 * dot(rate[k], product[k]);
            weight(k) * gain / 3.0
        };
        let beyond = |k: usize| -weight(k) * dot(rate[k], rest[k]);
        let all = 0..self.grid.components;
        let parts = |of: &[Complex<f64>]| {
            let (re, im) = of.iter().map(|z| (z.re, z.im)).unzip();
            [re, im]
        };
        Components {
            energy: all.clone().map(energy).collect(),
            transfer: all.clone().map(transfer).collect(),
            beyond: all.filter(|_| self.has_more()).map(beyond).collect(),
            value: parts(&value),
            rate: parts(&rate),
            scale: places * law.quadratic,
        }
    }
}
