//! Chains that start with a localized wave, and how well they preserve it.

use ndarray::ArrayView1;

use super::wave::{Ratio, Wave};
use crate::chain::{
    Accuracy, Chain, EndTime, Ends, Law, Laws, Losses, OnSite, Record, Run, Scheme, Simulation,
    SteppedSites,
};
use crate::observer::Observer;
use crate::system::memory::available_memory;
use crate::{Error, Result};

/// State of a wave after some cells.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Travel {
    /// Cells travelled, of unit time each.
    pub cells: usize,
    /// Largest difference between the velocities and the initial ones shifted by `cells` cells,
    /// relative to the largest initial velocity.
    pub shape_change: f64,
    /// Fraction of the energy left behind, per cell.
    pub leak: f64,
    /// Drift of the total energy, relative.
    pub energy_drift: f64,
}

/// Propagation of a wave along a chain that starts with it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Journey {
    pub order: usize,
    #[serde(flatten)]
    pub ratio: Ratio,
    /// Local error of the time integration, relative to the largest velocity.
    pub local_error: f64,
    /// After the last cell.
    #[serde(flatten)]
    pub arrived: Travel,
    /// Largest difference of the final velocities from a run with ten times the local error,
    /// relative to the largest velocity. It overestimates the integration error about tenfold.
    pub stepping_error: f64,
    /// After each cell.
    #[serde(skip)]
    pub travels: Vec<Travel>,
    /// Velocities of all sites at the start and at the end.
    #[serde(skip)]
    pub velocity: [Vec<f64>; 2],
}

impl Wave {
    /// Starts a chain with the wave, at a local error of 1e-13 per step, and compares it with the
    /// initial wave after every cell.
    ///
    /// # Errors
    /// [`Error::Request`] for no cells, [`Error::Memory`] for too many; [`Error::Cancelled`].
    pub fn journey(&self, cells: usize, observer: &dyn Observer) -> Result<Journey> {
        if cells == 0 {
            return Err(Error::Request {
                option: "cells",
                expected: "at least one cell".into(),
                found: "0".into(),
            });
        }
        // A velocity and a displacement (16 bytes) per site and sample.
        let sites = (cells as u64)
            .saturating_add(2 * self.reach() as u64)
            .saturating_mul(2);
        let needed = sites.saturating_mul(16).saturating_mul(cells as u64);
        let allowed = available_memory();
        if needed > allowed {
            return Err(Error::Memory {
                what: "the launched wave",
                needed,
                allowed,
            });
        }
        let run = self.launch(cells, LOCAL_ERROR).run(observer)?;
        let mut coarser = self.launch(cells, 10.0 * LOCAL_ERROR);
        coarser.samples = 2;
        coarser.record = Record::default();
        let coarser = coarser.run(observer)?;
        let travels: Vec<Travel> = (1..=cells)
            .filter_map(|cell| self.travelled(&run, cell))
            .collect();
        let (start, end) = (run.velocity.row(0), run.velocity.row(cells));
        let largest = start.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let difference = (end.iter().zip(coarser.velocity.row(1)))
            .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        let arrived = travels.last().copied().ok_or_else(|| Error::Unresolved {
            what: "the launched wave".into(),
            expected: "a run with displacements".into(),
            found: "one without".into(),
        })?;
        Ok(Journey {
            order: self.order,
            ratio: self.ratio(),
            local_error: LOCAL_ERROR,
            arrived,
            stepping_error: difference / largest,
            travels,
            velocity: [start.to_vec(), end.to_vec()],
        })
    }

    /// Half width of the wave in cells; it is zero outside.
    fn reach(&self) -> usize {
        (0.5 * self.overlap[0].period()).ceil() as usize + 1
    }

    /// The dimer chain that carries the wave: `cells` cells, a free first site, a wall behind the
    /// last site.
    pub fn chain(&self, cells: usize) -> Chain {
        let pair = |[a, b]: [f64; 2]| (0..2 * cells).map(move |j| if j % 2 == 0 { a } else { b });
        Chain {
            mass: pair(self.masses()).collect(),
            coefficient: pair(self.coefficients()).collect(),
            law: Laws::from(match self.exponent == 1.5 {
                true => Law::Hertz,
                false => Law::Power {
                    exponent: self.exponent,
                },
            }),
            ends: Ends::Wall,
            precompression: 0.0,
            losses: Losses::default(),
            on_site: OnSite::default(),
        }
    }

    /// A run that starts with the wave on the first cells and lasts `cells` units of time, in which
    /// the wave travels `cells` cells. One sample per unit of time.
    pub fn launch(&self, cells: usize, local_error: f64) -> Simulation {
        let reach = self.reach();
        let total = cells + 2 * reach;
        let mut displacement = vec![0.0; 2 * total];
        let mut velocity = vec![0.0; 2 * total];
        let mut ahead = 0.0;
        for cell in (0..total).rev() {
            let time = reach as f64 - cell as f64;
            for i in [1, 0] {
                ahead += self.overlap[i].value(time - 0.5 * i as f64);
                displacement[2 * cell + i] = ahead;
                velocity[2 * cell + i] = self.velocity[i].value(time);
            }
        }
        Simulation {
            chain: self.chain(total),
            velocity,
            displacement,
            resonators: None,
            drive: None,
            scheme: Scheme::default(),
            accuracy: Accuracy::LocalError(local_error),
            end_time: EndTime::At(cells as f64),
            samples: cells + 1,
            record: Record {
                displacement: true,
                ..Record::default()
            },
            estimate_error: false,
            window: SteppedSites::default(),
            memory: None,
        }
    }

    /// Compares sample `cells` of a run of [`Wave::launch`] with the initial wave; `None` if the
    /// sample does not exist or displacements were not recorded.
    pub fn travelled(&self, run: &Run, cells: usize) -> Option<Travel> {
        let displacement = run.displacement.as_ref()?;
        if cells == 0 || cells >= run.time.len() {
            return None;
        }
        let (start, now) = (run.velocity.row(0), run.velocity.row(cells));
        let largest = start.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let shifted = 2 * cells;
        let before = |j: usize| if j < shifted { 0.0 } else { start[j - shifted] };
        let change = (0..now.len())
            .map(|j| (now[j] - before(j)).abs())
            .fold(0.0, f64::max);
        let energies = |x: ArrayView1<f64>, v: ArrayView1<f64>| {
            let mut energies = vec![0.0; v.len()];
            let (x, v) = (x.to_vec(), v.to_vec());
            run.chain.site_energies(&x, &v, 0.0, &mut energies);
            energies
        };
        let first: f64 = energies(displacement.row(0), start).iter().sum();
        let last = energies(displacement.row(cells), now);
        let total: f64 = last.iter().sum();
        // The initial wave begins at the first site, so the sites before `shifted` are behind it.
        let behind: f64 = last[..shifted].iter().sum();
        Some(Travel {
            cells,
            shape_change: change / largest,
            leak: behind / first / cells as f64,
            energy_drift: total / first - 1.0,
        })
    }
}

/// Local error of the time integration of a journey.
const LOCAL_ERROR: f64 = 1e-13;
