//! Ratios by order: exact, estimated, measured on simulated chains, published.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::angle::{Angle, Cylinders};
use super::direct::{LeakCurve, LeakExtremum};
use super::family::Family;
use super::leak::LeakScan;
use super::published::{PUBLISHED, Published};
use super::row::{Asymptotic, Differences, Direct, Exact, OrderRow};
use super::search::Search;
use super::slow::SlowWave;
use super::wave::Wave;
use crate::observer::Observer;
use crate::{Error, Result};

/// Request for a comparison of the orders of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub family: Family,
    /// Both ends included; 1 is the homogeneous chain.
    pub orders: RangeInclusive<usize>,
    /// Cells of the simulated chains that measure leaks; `None` for no simulations.
    pub cells: Option<usize>,
    /// Crossed cylinders whose angles are computed; only for stiffness dimers of Hertz contacts.
    pub cylinders: Option<Cylinders>,
}

impl Comparison {
    /// The rows of all orders, computed in parallel. An order without a wave states the reason.
    ///
    /// # Errors
    /// [`Error::Request`] for an empty range of orders or one outside 1 to [`LARGEST_ORDER`], for
    /// angles of dimers other than stiffness dimers of Hertz contacts, and for chains of too few or
    /// too many cells; those of [`Family::search`] and [`LeakScan::run`]; [`Error::Cancelled`].
    pub fn run(&self, observer: &dyn Observer) -> Result<Vec<OrderRow>> {
        self.check()?;
        let family = self.family;
        let search = family.search(*self.orders.end())?;
        let fitted = (family.exponent == 1.5)
            .then(SlowWave::fitted)
            .transpose()?;
        let fitted = fitted.map(|slow| Search::new(family, slow, *self.orders.end()));
        let row = |order: usize| {
            observer.go_on()?;
            let asymptotic = search.estimate(order).map(|exact_profile| Asymptotic {
                exact_profile,
                fitted_profile: fitted.as_ref().and_then(|f| f.estimate(order)),
            });
            let row = self.row(order, search.wave(order), asymptotic);
            observer.advance(1);
            row
        };
        observer.stage("orders", self.orders.clone().count() as u64);
        let rows = self.orders.clone().into_par_iter().map(row);
        let mut rows = rows.collect::<Result<Vec<OrderRow>>>()?;
        if let Some(cells) = self.cells {
            self.add_direct(cells, &search, &mut rows, observer)?;
        }
        rows.iter_mut().for_each(OrderRow::compare);
        Ok(rows)
    }

    fn check(&self) -> Result<()> {
        let Comparison { family, orders, .. } = self;
        let (first, last) = (*orders.start(), *orders.end());
        Error::require(
            0 < first && first <= last && last <= LARGEST_ORDER,
            "order",
            format!("an ascending range of orders from 1 to {LARGEST_ORDER}"),
            format!("{first}..{last}"),
        )?;
        let (alternation, exponent) = (family.alternation, family.exponent);
        Error::require(
            self.cylinders.is_none() || *family == Family::default(),
            "angles",
            "stiffness dimers of Hertz contacts",
            format!("{alternation:?} dimers of exponent {exponent}"),
        )?;
        self.cells.map_or(Ok(()), |cells| self.scan(cells).check())
    }

    fn row(
        &self,
        order: usize,
        wave: Result<Wave>,
        asymptotic: Option<Asymptotic>,
    ) -> Result<OrderRow> {
        let (wave, reason) = match wave {
            Ok(wave) => (Some(wave), None),
            Err(error @ Error::Unresolved(_)) => (None, Some(error.to_string())),
            Err(error) => return Err(error),
        };
        let exact = wave.as_ref().map(Exact::of);
        let angle = exact.map(|exact| self.angle(exact.ratio.value(), exact.error));
        let is_published =
            |row: &&Published| row.order == order && self.family == Family::default();
        Ok(OrderRow {
            order,
            angle: angle.transpose()?.flatten(),
            exact,
            reason,
            asymptotic,
            direct: None,
            most_dispersive: None,
            published: PUBLISHED.iter().find(is_published).copied(),
            differences: Differences::default(),
            wave,
        })
    }

    fn angle(&self, kappa: f64, error: f64) -> Result<Option<Angle>> {
        let cylinders = self.cylinders.as_ref();
        cylinders.map(|it| it.crossed_for(kappa, error)).transpose()
    }

    fn scan(&self, cells: usize) -> LeakScan {
        LeakScan {
            family: self.family,
            cells,
            local_error: LOCAL_ERROR,
        }
    }

    /// Scans the leak over the range of the orders and refines its extrema.
    fn add_direct(
        &self,
        cells: usize,
        search: &Search,
        rows: &mut [OrderRow],
        observer: &dyn Observer,
    ) -> Result<()> {
        let Some(range) = Range::of(self.family, search, &self.orders) else {
            return Ok(());
        };
        let LeakCurve { minima, maxima, .. } = self.scan(cells).curve(&range.ratios(), observer)?;
        let direct = |extreme: &LeakExtremum| -> Result<Direct> {
            // Ratios just below 1 (the homogeneous chain) have no angle; that of 1 is used.
            let kappa = extreme.ratio.max(1.0);
            Ok(Direct {
                ratio: self.family.alternation.ratio(extreme.ratio),
                error: extreme.error,
                leak: extreme.leak,
                angle: self.angle(kappa, extreme.error)?,
            })
        };
        for minimum in minima.iter().filter(|m| m.leak < LARGEST_LEAK) {
            let distance = |row: &OrderRow| {
                let ratio = row.exact.map(|exact| exact.ratio.value());
                let ratio = ratio.or(row.asymptotic.map(|a| a.exact_profile));
                ratio.map_or(f64::INFINITY, |ratio| range.apart(ratio, minimum.ratio))
            };
            let nearest = (rows.iter_mut())
                .filter(|row| distance(row) < 0.3 * range.spacing)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if let Some(row) = nearest
                && row.direct.is_none_or(|known| minimum.leak < known.leak)
            {
                row.direct = Some(direct(minimum)?);
            }
        }
        for i in 1..rows.len() {
            let found = rows[i - 1].direct.zip(rows[i].direct);
            let Some((a, b)) = found.map(|(a, b)| (a.ratio.value(), b.ratio.value())) else {
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

/// The range of ratios of the simulated chains. They are evenly spaced in the square root of the
/// stiffening, in which orders are almost equidistant.
struct Range {
    family: Family,
    first: f64,
    last: f64,
    spacing: f64,
}

impl Range {
    /// From 0.6 orders below the first order to 0.6 orders above the last.
    fn of(family: Family, search: &Search, orders: &RangeInclusive<usize>) -> Option<Range> {
        let root = |order: usize| match order {
            1 => Some(1.0),
            order => Some(family.stiffening(search.estimate(order)?).sqrt()),
        };
        let last = (orders.clone().rev()).find_map(root)?;
        let first = root(*orders.start())?;
        let apart = |order: usize| Some(root(order)? - root(order - 1)?);
        let spacing = match *orders.end() {
            1 => 0.6,
            end => (2..=end).rev().find_map(apart)?,
        };
        // Starts just below the homogeneous chain, so that this is an interior minimum.
        let first = (first - 0.6 * spacing).max(1.0 - 2.0 * spacing / PER_ORDER);
        let last = last + 0.6 * spacing;
        Some(Range {
            family,
            first,
            last,
            spacing,
        })
    }

    fn ratios(&self) -> Vec<f64> {
        let count = ((self.last - self.first) / self.spacing * PER_ORDER).ceil();
        let step = (self.last - self.first) / count;
        let roots = (0..=count as usize).map(|j| self.first + step * j as f64);
        roots.map(|root| self.family.ratio(root.powi(2))).collect()
    }

    /// Distance of two ratios in the square root of the stiffening.
    fn apart(&self, a: f64, b: f64) -> f64 {
        let [a, b] = [a, b].map(|ratio| self.family.stiffening(ratio).sqrt());
        (a - b).abs()
    }
}

/// The largest order; its ratio is still accurate to seven digits.
pub const LARGEST_ORDER: usize = 60;

/// Local error of the time integration; it resolves leaks of 1e-14 per cell.
const LOCAL_ERROR: f64 = 1e-11;
/// Simulated ratios per order.
const PER_ORDER: f64 = 12.0;
/// A minimum with a larger leak is not a localized wave.
const LARGEST_LEAK: f64 = 1e-9;
