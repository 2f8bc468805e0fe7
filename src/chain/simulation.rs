//! A simulation as data.

use super::drive::Drive;
use super::lattice::{Chain, Ends, all_are};
use super::run::CHECKED_SAMPLES;
use super::stepping::{Scheme, SteppedSites};
use crate::{Error, Result};

/// Jumps of a prescribed velocity, over the largest, that are rounding.
const STEADY: f64 = 1e-12;

/// What decides the length of the steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy {
    /// The largest error of any site's velocity at any sample, relative to the velocity scale.
    Tolerance(f64),
    /// The largest estimated error of any velocity in one step, relative to the velocity scale.
    LocalError(f64),
    /// The longest step, for the schemes of fixed steps.
    Step(f64),
}

/// When a run ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EndTime {
    At(f64),
    /// When the last site first moves at a thousandth of the velocity scale.
    Arrival,
}

/// Results recorded beside the velocities; others are not computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Record {
    pub displacement: bool,
    pub force: bool,
    /// Energy passed through contacts and lost at sites.
    pub energy: bool,
}

impl Record {
    pub const ALL: Record = Record {
        displacement: true,
        force: true,
        energy: true,
    };
}

/// A chain, its initial state, and the requested results.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    pub chain: Chain,
    /// Initial velocity of each site.
    pub velocity: Vec<f64>,
    /// Initial displacement of each site from the static state.
    pub displacement: Vec<f64>,
    /// Initial displacements and velocities of the resonators, one a site; `None`: those of their bodies.
    pub resonators: Option<[Vec<f64>; 2]>,
    pub drive: Option<Drive>,
    pub scheme: Scheme,
    pub accuracy: Accuracy,
    pub end_time: EndTime,
    /// Uniform samples from 0 to the end time, both included.
    pub samples: usize,
    pub record: Record,
    /// Repeats the run with a smaller tolerance and reports by how much it differs.
    pub estimate_error: bool,
    pub window: SteppedSites,
    /// Bytes that the results may take; `None`: what is available.
    pub memory: Option<u64>,
}

impl Simulation {
    /// The impact of a striker on a chain at rest: site 0 starts with `speed`.
    pub fn impact(chain: Chain, speed: f64, end_time: f64, samples: usize) -> Simulation {
        let mut velocity = vec![0.0; chain.n_sites()];
        if let Some(striker) = velocity.first_mut() {
            *striker = speed;
        }
        Simulation {
            displacement: vec![0.0; chain.n_sites()],
            resonators: None,
            velocity,
            chain,
            drive: None,
            scheme: Scheme::default(),
            accuracy: Accuracy::Tolerance(1e-9),
            end_time: EndTime::At(end_time),
            samples,
            record: Record::ALL,
            estimate_error: true,
            window: SteppedSites::default(),
            memory: None,
        }
    }

    /// # Errors
    /// [`Error::Request`] for values that are unphysical or contradict each other,
    /// [`Error::Memory`] for results that exceed the memory.
    pub fn check(&self) -> Result<()> {
        self.chain.check()?;
        let n = self.chain.n_sites();
        let resonators = self.resonators.iter().flatten();
        let resonators = resonators.zip(["resonator_displacements", "resonator_velocities"]);
        let bodies = [
            ("velocity", &self.velocity),
            ("displacement", &self.displacement),
        ];
        for (name, values) in bodies
            .into_iter()
            .chain(resonators.map(|(values, name)| (name, values)))
        {
            let expected = format!("{n} values");
            Error::require(values.len() == n, name, expected, values.len())?;
            all_are((name, "finite values"), values, f64::is_finite)?;
        }
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let end = match self.end_time {
            EndTime::At(end) => {
                Error::require(positive(end), "end-time", "a positive time", end)?;
                end
            }
            EndTime::Arrival => f64::INFINITY,
        };
        Error::require(self.samples >= 2, "samples", "2 or more", self.samples)?;
        match self.accuracy {
            Accuracy::Tolerance(value) | Accuracy::LocalError(value) => {
                let expected = "a number between 0 and 1";
                Error::require(value > 0.0 && value < 1.0, "tolerance", expected, value)?;
                let expected = "a step for a scheme of fixed steps";
                Error::require(self.scheme.is_adaptive(), "step", expected, "none")?;
            }
            Accuracy::Step(step) => {
                Error::require(positive(step), "step", "a positive step", step)?;
            }
        }
        let ends = match (&self.drive, self.chain.ends) {
            (Some(Drive::Wall(_)), Ends::Wall | Ends::Free | Ends::Periodic) => {
                Some("a chain fixed at both ends for a driven wall")
            }
            (Some(Drive::Force(_)), Ends::Fixed { .. } | Ends::Periodic) => {
                Some("a chain whose first end is free for a driving force")
            }
            _ => None,
        };
        if let Some(expected) = ends {
            return Err(Error::request(
                "drive",
                expected,
                format!("{:?}", self.chain.ends),
            ));
        }
        let site = self.drive.as_ref().map_or(0, Drive::site);
        let expected = format!("a body from 0 to {}", n - 1);
        Error::require(site < n, "drive_site", expected, site)?;
        if let Some((site, wave)) = self.drive.as_ref().and_then(Drive::motion) {
            let own = [
                ("displacement", self.displacement[site], wave.at(0.0)),
                ("velocity", self.velocity[site], wave.rate_at(0.0)),
            ];
            let jump = wave.largest_jump(end);
            let steady = jump <= STEADY * wave.amplitude() * wave.angular_frequency();
            let expected = "the motion of a body whose velocity does not jump before the end: a tone burst, a \
                            half-sine of the velocity, or a longer duration";
            Error::require(steady, "drive", expected, format!("a jump by {jump}"))?;
            if let Some((name, found, told)) = own.into_iter().find(|(_, a, b)| a != b) {
                let expected = format!("that of the drive on site {site}, {told}");
                return Err(Error::request(name, &expected, found));
            }
        }
        Error::beyond_memory("the run", self.bytes(), self.allowed_memory())?;
        self.check_work()
    }

    pub(super) fn allowed_memory(&self) -> u64 {
        self.memory
            .unwrap_or_else(crate::system::memory::available_memory)
    }

    /// Bytes that the results take.
    pub fn bytes(&self) -> u64 {
        let (n, m) = (self.chain.n_sites() as u64, self.chain.n_contacts() as u64);
        let record = self.record;
        let moved = n * (1 + u64::from(record.displacement));
        let mut columns = 1 + moved + m * u64::from(record.force);
        if record.energy {
            columns += m + if self.chain.is_lossy() { n } else { 0 };
        }
        if self.chain.resonators().is_some() {
            columns += moved;
        }
        let checked = if self.estimate_error {
            n.saturating_mul(CHECKED_SAMPLES as u64 + 2)
        } else {
            0
        };
        columns
            .saturating_mul(self.samples as u64)
            .saturating_add(checked)
            .saturating_mul(8)
    }

    /// Energy that resonators have at the start beyond that of following their bodies.
    fn energy_of_resonators(&self) -> f64 {
        let (Some([y, w]), Some(all)) = (&self.resonators, self.chain.resonators()) else {
            return 0.0;
        };
        let of = |j: usize| {
            all.spring_energy(j, y[j] - self.displacement[j]) + all.kinetic_energy(j, w[j])
        };
        all.sites().map(of).sum()
    }

    /// A speed that the motion cannot be much below: the largest initial one, that of the lightest
    /// site with the energy stored at the start, or that which a drive has or gives.
    pub(super) fn velocity_scale(&self, end: f64) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let masses = self.chain.mass.iter().copied();
        let lightest = masses.fold(f64::INFINITY, f64::min);
        let stored = self.chain.stored_energy(&self.displacement) + self.energy_of_resonators();
        let driven = self.drive.as_ref().map_or(0.0, |drive| {
            let amplitude = drive.waveform().amplitude().abs();
            let frequency = drive.waveform().angular_frequency();
            match drive {
                Drive::Wall(_) | Drive::Motion(..) => amplitude * frequency,
                Drive::Force(_) | Drive::Body(..) => {
                    amplitude / lightest * end.min(1.0 / frequency)
                }
            }
        });
        largest(&self.velocity)
            .max((2.0 * stored / lightest).sqrt())
            .max(driven)
    }
}
