//! Orders side by side: exact, estimated, measured on chains, published.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::angle::{Angle, Cylinders};
use super::convergence::Convergence;
use super::direct::{Extreme, LeakCurve};
use super::family::Family;
use super::leak::LeakScan;
use super::published::{PUBLISHED, Published};
use super::search::Search;
use super::slow::SlowProfile;
use super::wave::{Ratio, Wave};
use crate::analyze::Observer;
use crate::{Error, Result};

/// What is to be known of the orders of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub family: Family,
    /// Both ends included; 1 is the homogeneous chain.
    pub orders: RangeInclusive<usize>,
    /// Cells of chains that are struck to measure leaks; `None`: none are.
    pub cells: Option<usize>,
    /// Crossed cylinders whose angles are looked for; only of stiffness dimers of Hertz contacts.
    pub cylinders: Option<Cylinders>,
}

/// What is known of one order; all numbers at unit cell time.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    pub order: usize,
    pub exact: Option<Exact>,
    /// Why there is no exact one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub asymptotic: Option<Asymptotic>,
    /// The least leak near this order; only where chains were struck, and found it.
    pub direct: Option<Direct>,
    /// The largest leak between this order and the next; only where chains were struck, and found
    /// both.
    pub most_dispersive: Option<Direct>,
    /// Only where cylinders were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
    /// Only of stiffness dimers of Hertz contacts.
    pub published: Option<Published>,
    pub differences: Differences,
    #[serde(skip)]
    pub wave: Option<Wave>,
}

/// The localized wave's numbers.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Exact {
    #[serde(flatten)]
    pub ratio: Ratio,
    /// Estimated relative error of the ratio.
    pub error: f64,
    /// Significant digits of the ratio that stand.
    pub digits: u32,
    #[serde(flatten)]
    pub convergence: Convergence,
    /// C of `V = C F^{(p-1)/(2p)}`, sites per unit of time against the peak force in contact 0.
    pub speed_coefficient: f64,
    /// Full width at half height of the force in contact 0, in sites.
    pub width: f64,
    pub energy: f64,
    pub momentum: f64,
    /// Largest difference of the velocity of site 0 from its mirror image, relative to its peak.
    pub velocity_asymmetry: f64,
    /// The same of the force in contact 0.
    pub force_asymmetry: f64,
}

/// Ratios from the asymptotic condition.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Asymptotic {
    pub exact_profile: f64,
    /// Only for Hertz contacts, which it was fitted for.
    pub fitted_profile: Option<f64>,
}

/// An extreme of the leak of simulated chains.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Direct {
    #[serde(flatten)]
    pub ratio: Ratio,
    /// Relative error of the ratio.
    pub error: f64,
    /// Relative loss of energy per cell there.
    pub leak: f64,
    /// Only where cylinders were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Angle>,
}

/// Relative differences of ratios from the exact one; of the published estimate, from ours on the
/// same fitted profile.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Differences {
    pub exact_profile: Option<f64>,
    pub fitted_profile: Option<f64>,
    pub direct: Option<f64>,
    pub published_direct: Option<f64>,
    pub published_estimate: Option<f64>,
}

impl Exact {
    /// Reads them off a wave.
    pub fn of(wave: &Wave) -> Exact {
        let error = wave.convergence.error();
        Exact {
            ratio: wave.ratio(),
            error,
            digits: (-error.log10()).floor().max(0.0) as u32,
            convergence: wave.convergence,
            speed_coefficient: wave.speed_coefficient(),
            width: wave.width(),
            energy: wave.energy(),
            momentum: wave.momentum(),
            velocity_asymmetry: Wave::asymmetry(&wave.velocity[0]),
            force_asymmetry: Wave::asymmetry(&wave.force[0]),
        }
    }
}

impl Comparison {
    /// The rows of all orders asked for, computed side by side. An order without a wave has a
    /// reason in its place.
    ///
    /// # Errors
    /// [`Error::Request`] for orders that are no range from 1 on, angles of dimers that are no
    /// crossed cylinders, and chains too short; those of [`Family::search`] and [`LeakScan::run`];
    /// [`Error::Cancelled`].
    pub fn run(&self, observer: &dyn Observer) -> Result<Vec<Row>> {
        self.check()?;
        let family = self.family;
        let search = family.search(*self.orders.end())?;
        let fitted = match family.exponent == 1.5 {
            true => Some(family.search_on(SlowProfile::fitted()?, *self.orders.end())),
            false => None,
        };
        let estimate = |order: usize| {
            Some(Asymptotic {
                exact_profile: search.estimate(order)?,
                fitted_profile: fitted.as_ref().and_then(|f| f.estimate(order)),
            })
        };
        let orders: Vec<usize> = self.orders.clone().collect();
        observer.stage("orders", orders.len() as u64);
        let rows: Result<Vec<Row>> = orders
            .into_par_iter()
            .map(|order| {
                if observer.cancelled() {
                    return Err(Error::Cancelled);
                }
                let row = self.row(order, search.wave(order), estimate(order));
                observer.advance(1);
                row
            })
            .collect();
        let mut rows = rows?;
        if let Some(cells) = self.cells {
            self.add_direct(cells, &search, &mut rows, observer)?;
        }
        rows.iter_mut().for_each(Row::compare);
        Ok(rows)
    }

    fn check(&self) -> Result<()> {
        let Comparison { family, orders, .. } = self;
        if orders.is_empty() || *orders.start() == 0 || *orders.end() > LARGEST_ORDER {
            return Err(Error::Request {
                option: "order",
                expected: format!("orders from 1 to {LARGEST_ORDER}, the first one first"),
                found: format!("{}..{}", orders.start(), orders.end()),
            });
        }
        let dimer = *family == Family::default();
        if self.cylinders.is_some() && !dimer {
            return Err(Error::Request {
                option: "angles",
                expected: "stiffness dimers of Hertz contacts".into(),
                found: format!(
                    "{:?} dimers of exponent {}",
                    family.alternation, family.exponent
                ),
            });
        }
        self.cells.map_or(Ok(()), |cells| self.scan(cells).check())
    }

    fn row(&self, order: usize, wave: Result<Wave>, asymptotic: Option<Asymptotic>) -> Result<Row> {
        let (wave, reason) = match wave {
            Ok(wave) => (Some(wave), None),
            Err(error @ Error::Unresolved { .. }) => (None, Some(error.to_string())),
            Err(error) => return Err(error),
        };
        let exact = wave.as_ref().map(Exact::of);
        let published = (PUBLISHED.iter()).find(|row| row.order == order);
        Ok(Row {
            order,
            angle: self.angle(exact.map(|exact| exact.ratio.value()))?,
            exact,
            reason,
            asymptotic,
            direct: None,
            most_dispersive: None,
            published: published
                .filter(|_| self.family == Family::default())
                .copied(),
            differences: Differences::default(),
            wave,
        })
    }

    fn angle(&self, kappa: Option<f64>) -> Result<Option<Angle>> {
        match (&self.cylinders, kappa) {
            (Some(cylinders), Some(kappa)) => cylinders.crossed_for(kappa).map(Some),
            _ => Ok(None),
        }
    }

    fn scan(&self, cells: usize) -> LeakScan {
        LeakScan {
            family: self.family,
            cells,
            local_error: LOCAL_ERROR,
        }
    }

    /// Scans the leak over the range of the orders, and narrows its extremes down.
    fn add_direct(
        &self,
        cells: usize,
        search: &Search,
        rows: &mut [Row],
        observer: &dyn Observer,
    ) -> Result<()> {
        let Some(range) = Range::of(&self.family, search, &self.orders) else {
            return Ok(());
        };
        let LeakCurve { minima, maxima, .. } = self.scan(cells).curve(&range.ratios(), observer)?;
        let direct = |extreme: &Extreme| -> Result<Direct> {
            // Just below the homogeneous chain there is no angle, and none is needed.
            let kappa = extreme.ratio.max(1.0);
            Ok(Direct {
                ratio: self.family.alternation.ratio(extreme.ratio),
                error: extreme.error,
                leak: extreme.leak,
                angle: self.angle(Some(kappa))?,
            })
        };
        let localized = minima.iter().filter(|m| m.leak < LARGEST_LEAK);
        let mut found: Vec<Option<f64>> = vec![None; rows.len()];
        for minimum in localized {
            let distance = |row: &Row| {
                let ratio = row.exact.map(|exact| exact.ratio.value());
                let ratio = ratio.or(row.asymptotic.map(|a| a.exact_profile));
                ratio.map_or(f64::INFINITY, |ratio| range.apart(ratio, minimum.ratio))
            };
            let nearest =
                (0..rows.len()).min_by(|a, b| distance(&rows[*a]).total_cmp(&distance(&rows[*b])));
            if let Some(nearest) = nearest
                && distance(&rows[nearest]) < 0.3 * range.spacing
                && (rows[nearest].direct).is_none_or(|direct| minimum.leak < direct.leak)
            {
                rows[nearest].direct = Some(direct(minimum)?);
                found[nearest] = Some(minimum.ratio);
            }
        }
        for i in 1..rows.len() {
            let (Some(a), Some(b)) = (found[i - 1], found[i]) else {
                continue;
            };
            let between = (maxima.iter())
                .filter(|m| m.ratio > a.min(b) && m.ratio < a.max(b))
                .max_by(|a, b| a.leak.total_cmp(&b.leak));
            rows[i - 1].most_dispersive = between.map(direct).transpose()?;
        }
        Ok(())
    }
}

impl Row {
    fn compare(&mut self) {
        let exact = self.exact.map(|exact| exact.ratio.value());
        let off = |value: Option<f64>| Some(value? / exact? - 1.0);
        let estimates = self.asymptotic;
        let fitted = estimates.and_then(|a| a.fitted_profile);
        self.differences = Differences {
            exact_profile: off(estimates.map(|a| a.exact_profile)),
            fitted_profile: off(fitted),
            direct: off(self.direct.map(|direct| direct.ratio.value())),
            published_direct: off(self.published.map(|paper| paper.direct)),
            published_estimate: self
                .published
                .zip(fitted)
                .map(|(paper, fitted)| paper.estimate / fitted - 1.0),
        };
    }
}

/// Where chains are looked at, evenly in the root of the stiffening, in which orders are almost
/// equally far apart.
struct Range {
    family: Family,
    first: f64,
    last: f64,
    spacing: f64,
}

impl Range {
    /// From half an order below the first one asked for to half an order above the last.
    fn of(family: &Family, search: &Search, orders: &RangeInclusive<usize>) -> Option<Range> {
        let root = |order: usize| match order {
            1 => Some(1.0),
            order => Some(family.stiffening(search.estimate(order)?).sqrt()),
        };
        let last = (orders.clone().rev()).find_map(root)?;
        let first = root(*orders.start())?;
        let spacing = match *orders.end() {
            1 => 0.6,
            end => (2..=end)
                .filter_map(|order| Some(root(order)? - root(order - 1)?))
                .next_back()?,
        };
        // From just below the homogeneous chain, so that it is a minimum among others.
        let first = (first - 0.6 * spacing).max(1.0 - 2.0 * spacing / PER_ORDER);
        Some(Range {
            family: *family,
            first,
            last: last + 0.6 * spacing,
            spacing,
        })
    }

    fn ratios(&self) -> Vec<f64> {
        let count = ((self.last - self.first) / self.spacing * PER_ORDER).ceil();
        let step = (self.last - self.first) / count;
        (0..=count as usize)
            .map(|j| self.family.ratio((self.first + step * j as f64).powi(2)))
            .collect()
    }

    /// How far two ratios are apart, in the root of the stiffening.
    fn apart(&self, a: f64, b: f64) -> f64 {
        let [a, b] = [a, b].map(|ratio| self.family.stiffening(ratio).sqrt());
        (a - b).abs()
    }
}

/// The largest order that is looked for; its ratio still stands to seven digits.
pub const LARGEST_ORDER: usize = 60;

/// Of the stepping: leaks of 1e-14 a cell are seen with it.
const LOCAL_ERROR: f64 = 1e-11;
/// Ratios looked at from one order to the next.
const PER_ORDER: f64 = 12.0;
/// A larger least leak is no localized wave's.
const LARGEST_LEAK: f64 = 1e-9;
