//! Chains as periodic lines of contacts.

use num_complex::Complex;

use super::kernel::{Components, Grid};
use super::source::{Coefficients, Source, parts};
use super::{QuadraticLaw, refuse};
use crate::budget::contacts::{ContactState, Contacts};
use crate::budget::motion::Motion;
use crate::chain::{Chain, Ends, Law};
use crate::error::Result;

/// Masses and coefficients that differ by less are equal.
const EQUAL: f64 = 1e-12;

/// What refusals name: the record, of whose chain they are.
const RUN: &str = "record";

/// The motion of a chain of equal masses and contacts with a quadratic force.
pub(super) struct QuadraticChain<'a> {
    motion: Motion<'a>,
    contacts: Contacts<'a>,
    mass: f64,
    /// Force `linear r + quadratic r^2`.
    linear: f64,
    quadratic: f64,
    /// Places of a period.
    points: usize,
    coefficients: Coefficients,
}

impl<'a> QuadraticChain<'a> {
    pub fn of(motion: &Motion<'a>) -> Result<Self> {
        let chain = motion.chain;
        let [mass, coefficient] = [&chain.mass, &chain.coefficient].map(|all| all[0]);
        let left = match chain.ends {
            Ends::Fixed { left_coefficient } => Some(left_coefficient),
            _ => None,
        };
        let differs = |value: f64, from: f64| (value - from).abs() > EQUAL * from;
        if let Some(other) = chain.mass.iter().find(|m| differs(**m, mass)) {
            let found = format!("masses {mass} and {other}");
            return refuse(RUN, "equal masses, whose waves are sines", found);
        }
        let mut all = chain.coefficient.iter().chain(&left);
        if let Some(other) = all.find(|c| differs(**c, coefficient)) {
            let found = format!("coefficients {coefficient} and {other}");
            return refuse(RUN, "equal contacts, whose waves are sines", found);
        }
        let (linear, quadratic) = expansion(chain, coefficient)?;
        let sites = chain.n_sites();
        let points = if left.is_some() {
            2 * (sites + 1)
        } else {
            sites
        };
        if points < 3 {
            return refuse(RUN, "three or more", sites);
        }
        Ok(QuadraticChain {
            contacts: Contacts::of(motion),
            motion: *motion,
            mass,
            linear,
            quadratic,
            points,
            coefficients: Coefficients::new(points),
        })
    }

    /// Values of contacts over a period; a chain between walls is continued by its mirror image, one with free ends by a
    /// contact without force.
    fn of_contacts(&self, values: &[f64]) -> Vec<f64> {
        let mut row = values.to_vec();
        match self.motion.chain.ends {
            Ends::Fixed { .. } => row.extend(values.iter().rev()),
            _ => row.resize(self.points, 0.0),
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
    if chain.on_site.ground.is_some() {
        let expected = "a chain without springs to the ground";
        return refuse(RUN, expected, "springs to the ground");
    }
    if chain.resonators().is_some() {
        let expected = "a chain without resonators";
        return refuse(RUN, expected, "resonators");
    }
    let Some(law) = chain.law.only() else {
        let expected =
            "one law for all contacts, by which the quadratic term is the same everywhere";
        return refuse(RUN, expected, "several");
    };
    let d0 = law.static_overlap(coefficient, chain.precompression);
    let stiffness = law.stiffness(coefficient, d0, 0.0);
    let Some(quadratic) = law.quadratic(coefficient, d0) else {
        return refuse(
            RUN,
            "contacts with a quadratic term about their static state: precompressed ones, or springs with alpha",
            "contacts that just touch, whose force has no expansion in powers",
        );
    };
    if quadratic == 0.0 {
        let expected = "a force with a quadratic term, such as springs with alpha";
        return refuse(
            RUN,
            expected,
            "one without, so that no triads exchange energy",
        );
    }
    Ok((stiffness, quadratic))
}

/// `Re(conj(a) b)`.
fn dot(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}

impl Source for QuadraticChain<'_> {
    fn samples(&self) -> usize {
        self.motion.samples()
    }

    fn time(&self) -> [f64; 2] {
        [self.motion.time[0], self.motion.step()]
    }

    fn grid(&self) -> Grid {
        Grid {
            points: self.points,
            components: self.points / 2 + 1,
            wraps: true,
        }
    }

    fn law(&self) -> QuadraticLaw {
        QuadraticLaw {
            mass: self.mass,
            linear: self.linear,
            quadratic: self.quadratic,
        }
    }

    fn has_more(&self) -> bool {
        !matches!(
            self.motion.chain.law.only(),
            Some(Law::Spring { beta: 0.0, .. })
        )
    }

    fn components(&self, sample: usize) -> Components {
        let at = self.motion.at(sample);
        let mut state = ContactState::default();
        self.contacts.evaluate(at, &mut state);
        let (r, closing) = (&state.overlap, &state.closing);
        let b = self.quadratic;
        let product: Vec<f64> = r.iter().map(|r| b * r * r).collect();
        let product_rate: Vec<f64> = r
            .iter()
            .zip(closing)
            .map(|(r, rate)| 2.0 * b * r * rate)
            .collect();
        let forces = state.elastic.iter().zip(r).zip(&product);
        let rest: Vec<f64> = forces
            .map(|((force, r), product)| force - self.linear * r - product)
            .collect();
        let line = |values: &[f64]| self.coefficients.of(&self.of_contacts(values));
        let [value, rate] = [&r[..], closing].map(line);
        let [product, product_rate, rest] = [&product, &product_rate, &rest].map(|row| line(row));
        let velocity = self.coefficients.of(&self.of_sites(at.v));
        let grid = self.grid();
        // A chain between walls is half of its period.
        let half = if self.contacts.offset == 1 { 0.5 } else { 1.0 };
        let places = half * self.points as f64;
        let weight = |k: usize| places * grid.weight(k);
        let energy = |k: usize| {
            let kinetic = 0.5 * self.mass * velocity[k].norm_sqr();
            let linear = 0.5 * self.linear * value[k].norm_sqr();
            weight(k) * (kinetic + linear + dot(value[k], product[k]) / 3.0)
        };
        let transfer = |k: usize| {
            let gain = dot(value[k], product_rate[k]) - 2.0 * dot(rate[k], product[k]);
            weight(k) * gain / 3.0
        };
        let all = 0..grid.components;
        Components {
            energy: all.clone().map(energy).collect(),
            transfer: all.clone().map(transfer).collect(),
            beyond: match self.has_more() {
                true => all.map(|k| -weight(k) * dot(rate[k], rest[k])).collect(),
                false => Vec::new(),
            },
            value: parts(&value),
            rate: parts(&rate),
            scale: places * b,
        }
    }
}
