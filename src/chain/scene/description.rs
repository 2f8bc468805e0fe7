//! What a scene describes, in numbers.

use serde::Serialize;

use super::{Setup, Units};
use crate::chain::{Accuracy, EndTime, Ends, Resonators, Scheme, Work};

/// The resonators of a scene: their number, and the smallest and the largest of each value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResonatorsDescription {
    pub number: usize,
    pub mass: [f64; 2],
    /// While the body is held, in cycles per unit of time.
    pub frequency: [f64; 2],
    pub damping: [f64; 2],
}

impl ResonatorsDescription {
    fn of(all: &Resonators) -> Option<ResonatorsDescription> {
        let of = |value: &dyn Fn(usize) -> f64| range(&all.sites().map(value).collect::<Vec<_>>());
        Some(ResonatorsDescription {
            number: all.sites().count(),
            mass: of(&|j| all.mass[j])?,
            frequency: of(&|j| all.frequency(j))?,
            damping: of(&|j| all.damping[j])?,
        })
    }
}

/// What a scene describes, known without a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Description {
    pub units: Units,
    pub sites: usize,
    pub contacts: usize,
    pub law: String,
    pub ends: &'static str,
    /// Unit of the coefficients, in an SI scene.
    pub coefficient_unit: Option<String>,
    /// Smallest and largest coefficient; absent without contacts.
    pub coefficient: Option<[f64; 2]>,
    /// Largest over smallest coefficient of the contacts between sites, without the striker's;
    /// absent without such contacts.
    pub stiffness_ratio: Option<f64>,
    pub mass: [f64; 2],
    pub total_mass: f64,
    pub striker_mass: f64,
    pub striker_velocity: f64,
    /// Sites that move at the start.
    pub moving_sites: usize,
    /// Largest initial speed and displacement of any site.
    pub largest_velocity: f64,
    pub largest_displacement: f64,
    pub drive: Option<String>,
    pub precompression: f64,
    pub gravity: f64,
    /// Law of springs to the ground, and their smallest and largest coefficient.
    pub ground: Option<(String, [f64; 2])>,
    pub resonators: Option<ResonatorsDescription>,
    pub dashpot: f64,
    pub tangent: f64,
    pub drag: f64,
    pub scheme: Scheme,
    pub tolerance: Option<f64>,
    pub step: Option<f64>,
    /// Absent where the run ends when the front reaches the last site.
    pub end_time: Option<f64>,
    pub samples: usize,
    /// Arrays that are kept.
    pub record: Vec<&'static str>,
    /// Memory of the run, in bytes.
    pub memory: u64,
    /// Steps of the run, estimated, and what limits their length.
    pub work: Work,
}

impl Setup {
    /// What the scene describes.
    pub fn description(&self) -> Description {
        let simulation = &self.simulation;
        let chain = &simulation.chain;
        let n = chain.n_sites();
        let last = n.saturating_sub(1).min(chain.n_contacts());
        let inner = chain.coefficient.get(1..last).unwrap_or_default();
        let record = simulation.record;
        let resonators = chain.resonators().is_some();
        let (tolerance, step) = match simulation.accuracy {
            Accuracy::Tolerance(tolerance) => (Some(tolerance), None),
            Accuracy::Step(step) => (None, Some(step)),
            Accuracy::LocalError(_) => (None, None),
        };
        let kept = [
            ("velocity", true),
            ("displacement", record.displacement),
            ("force", record.force),
            ("energy_passed", record.energy),
            ("energy_lost", record.energy && chain.is_lossy()),
            ("energy_input", record.energy && simulation.drive.is_some()),
            ("resonator_velocity", resonators),
            ("resonator_displacement", resonators && record.displacement),
        ];
        let kept = kept.into_iter().filter(|(_, kept)| *kept);
        let ground = chain.on_site.ground.as_ref();
        Description {
            units: self.units,
            sites: n,
            contacts: chain.n_contacts(),
            law: chain.law.text(),
            ends: match chain.ends {
                Ends::Wall => "wall",
                Ends::Free => "free",
                Ends::Fixed { .. } => "fixed",
                Ends::Periodic => "periodic",
            },
            coefficient_unit: (self.units == Units::Si).then(|| chain.law.coefficient_unit()),
            coefficient: range(&chain.coefficient),
            stiffness_ratio: range(inner).map(|[least, most]| most / least),
            mass: range(&chain.mass).unwrap_or_default(),
            total_mass: chain.mass.iter().sum(),
            striker_mass: chain.mass[0],
            striker_velocity: simulation.velocity[0],
            moving_sites: simulation.velocity.iter().filter(|v| **v != 0.0).count(),
            largest_velocity: largest(&simulation.velocity),
            largest_displacement: largest(&simulation.displacement),
            drive: self.drive.clone(),
            precompression: chain.precompression,
            gravity: chain.on_site.gravity,
            ground: ground.and_then(|all| Some((all.law.text(), range(&all.coefficient)?))),
            resonators: chain.resonators().and_then(ResonatorsDescription::of),
            dashpot: chain.losses.dashpot,
            tangent: chain.losses.tangent,
            drag: chain.losses.drag,
            scheme: simulation.scheme,
            tolerance,
            step,
            end_time: match simulation.end_time {
                EndTime::At(time) => Some(time),
                EndTime::Arrival => None,
            },
            samples: simulation.samples,
            record: kept.map(|(name, _)| name).collect(),
            memory: simulation.bytes(),
            work: simulation.work(),
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

fn range(values: &[f64]) -> Option<[f64; 2]> {
    let first = *values.first()?;
    let widen = |[least, most]: [f64; 2], &v: &f64| [least.min(v), most.max(v)];
    Some(values.iter().fold([first, first], widen))
}
