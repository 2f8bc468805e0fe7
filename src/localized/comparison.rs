//! Orders side by side: exact, estimated, measured on chains, published.

use std::ops::RangeInclusive;

use super::convergence::Convergence;
use super::family::Family;
use super::leak::{Leak, LeakScan, minima};
use super::published::{PUBLISHED, Published};
use super::search::Search;
use super::slow::SlowProfile;
use super::wave::{Alternation, Wave};
use crate::analyze::Observer;
use crate::{Error, Result};

/// What is known of one order; ratios are kappa of stiffness dimers, mu of mass dimers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Row {
    pub order: usize,
    pub exact: Exact,
    pub asymptotic: Asymptotic,
    /// Only where chains were asked for.
    pub direct: Option<Direct>,
    /// Only of stiffness dimers of Hertz contacts.
    pub published: Option<Published>,
}

/// The localized wave's numbers, at unit cell time.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Exact {
    pub ratio: f64,
    /// Estimated relative error of the ratio.
    pub error: f64,
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

/// The minimum of the leak of simulated chains that is nearest to the wave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Direct {
    pub ratio: f64,
    /// Least leak per cell that was measured near it.
    pub leak: f64,
}

impl Exact {
    fn of(wave: &Wave) -> Exact {
        Exact {
            ratio: wave.ratio,
            error: wave.convergence.error(),
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

/// The rows of all orders asked for; with `cells`, chains of as many cells are struck too.
///
/// # Errors
/// Those of [`Family::search`], [`Search::wave`] and [`LeakScan::run`]; [`Error::Cancelled`].
pub fn compare(
    family: Family,
    orders: RangeInclusive<usize>,
    cells: Option<usize>,
    observer: &dyn Observer,
) -> Result<Vec<Row>> {
    if orders.is_empty() || *orders.start() == 0 {
        return Err(Error::Request {
            option: "order",
            expected: "orders of 1 or more, the first one first".into(),
            found: format!("{}..{}", orders.start(), orders.end()),
        });
    }
    let search = family.search(*orders.end())?;
    let hertz = family.exponent == 1.5;
    let fitted = match hertz {
        true => Some(family.estimates(&SlowProfile::fitted()?, *orders.end())?),
        false => None,
    };
    observer.stage("orders", orders.clone().count() as u64);
    let mut rows = Vec::new();
    for order in orders {
        if observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let wave = search.wave(order)?;
        let published = (PUBLISHED.iter())
            .find(|row| row.order == order)
            .filter(|_| hertz && family.alternation == Alternation::Stiffness);
        rows.push(Row {
            order,
            exact: Exact::of(&wave),
            asymptotic: Asymptotic {
                exact_profile: search.estimate(order).unwrap_or(f64::NAN),
                fitted_profile: fitted.as_ref().map(|f| f[order - 1]),
            },
            direct: None,
            published: published.copied(),
        });
        observer.advance(1);
    }
    if let Some(cells) = cells {
        add_direct(family, cells, &search, &mut rows, observer)?;
    }
    Ok(rows)
}

/// Scans the leak over the estimates' range, and once more around each of its minima.
fn add_direct(
    family: Family,
    cells: usize,
    search: &Search,
    rows: &mut [Row],
    observer: &dyn Observer,
) -> Result<()> {
    let scan = LeakScan {
        family,
        cells,
        local_error: LOCAL_ERROR,
    };
    // Orders are almost evenly spaced in the root of the stiffening.
    let root = |ratio: f64| match family.alternation {
        Alternation::Stiffness => ratio.powf(0.5 / family.exponent),
        Alternation::Mass => ratio.powf(-0.5),
    };
    let ratio = |root: f64| match family.alternation {
        Alternation::Stiffness => root.powf(2.0 * family.exponent),
        Alternation::Mass => root.powi(-2),
    };
    let estimates: Vec<f64> = (1..)
        .map_while(|order| search.estimate(order))
        .map(root)
        .collect();
    let last = estimates[estimates.len() - 1].max(1.2);
    let spacing = match estimates[..] {
        [.., before, last] => last - before,
        _ => 0.5,
    };
    let step = spacing / 12.0;
    let count = ((last + 0.6 * spacing - 1.0) / step).ceil() as usize;
    let along = |centre: f64, step: f64, count: usize| -> Vec<f64> {
        let mut ratios: Vec<f64> = (0..=count)
            .map(|j| ratio(centre + step * j as f64))
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    };
    // From just below the homogeneous chain, so that it is a minimum among others.
    let coarse = scan.run(&along(1.0 - step, step, count + 1), observer)?;
    for minimum in minima(&coarse) {
        let fine = step / 6.0;
        let around = scan.run(&along(root(minimum) - 3.0 * fine, fine, 6), observer)?;
        let Some(found) = minima(&around).first().copied() else {
            continue;
        };
        let least = |leaks: &[Leak]| {
            leaks
                .iter()
                .map(|l| l.per_cell)
                .fold(f64::INFINITY, f64::min)
        };
        let distance = |row: &Row| (root(row.exact.ratio) - root(found)).abs();
        let nearest = rows
            .iter_mut()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(row) = nearest
            && distance(row) < 0.3 * spacing
        {
            row.direct = Some(Direct {
                ratio: found,
                leak: least(&around),
            });
        }
    }
    Ok(())
}

/// Of the stepping: leaks of 1e-10 a cell are seen with it.
const LOCAL_ERROR: f64 = 1e-11;
