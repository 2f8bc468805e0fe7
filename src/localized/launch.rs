//! Chains that start with a localized wave, and how well they preserve it.

use ndarray::ArrayView1;

use super::series::largest;
use super::wave::{Ratio, Wave};
use crate::chain::{Accuracy, Record, Run, Simulation};
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
        Error::require(cells > 0, "cells", "at least one cell", cells)?;
        // A velocity and a displacement (16 bytes) per site and sample.
        let sites = (cells as u64).saturating_add(2 * self.reach() as u64);
        let needed = sites.saturating_mul(32).saturating_mul(cells as u64);
        Error::beyond_memory("the launched wave", needed, available_memory())?;
        let run = self.launch(cells, LOCAL_ERROR).run(observer)?;
        let coarser = Simulation {
            samples: 2,
            record: Record::default(),
            ..self.launch(cells, 10.0 * LOCAL_ERROR)
        };
        let coarser = coarser.run(observer)?;
        let travels = (1..=cells).filter_map(|cell| self.travelled(&run, cell));
        let travels: Vec<Travel> = travels.collect();
        let (start, end) = (run.velocity.row(0), run.velocity.row(cells));
        let difference = (&end - &coarser.velocity.row(1)).to_vec();
        Ok(Journey {
            order: self.order,
            ratio: self.ratio(),
            local_error: LOCAL_ERROR,
            arrived: travels[travels.len() - 1],
            stepping_error: largest(&difference) / largest(&start.to_vec()),
            travels,
            velocity: [start.to_vec(), end.to_vec()],
        })
    }

    /// Half width of the wave in cells; it is zero outside.
    fn reach(&self) -> usize {
        (0.5 * self.overlap[0].period()).ceil() as usize + 1
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
        let chain = self.family().chain(self.ratio, total);
        Simulation {
            velocity,
            displacement,
            accuracy: Accuracy::LocalError(local_error),
            record: Record {
                displacement: true,
                ..Record::default()
            },
            estimate_error: false,
            ..Simulation::impact(chain, 0.0, cells as f64, cells + 1)
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
        let shifted = 2 * cells;
        let mut change = now.to_vec();
        let moved = change.iter_mut().skip(shifted).zip(start);
        moved.for_each(|(now, before)| *now -= before);
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
            shape_change: largest(&change) / largest(&start.to_vec()),
            leak: behind / first / cells as f64,
            energy_drift: total / first - 1.0,
        })
    }
}

/// Local error of the time integration of a journey.
const LOCAL_ERROR: f64 = 1e-13;
