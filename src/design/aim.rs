//! What a design is judged by: a measure of its run.

use crate::chain::scene::Units;
use crate::chain::{Record, Run};
use crate::measure::{Frequency, Measure};
use crate::sheet::name_of;
use crate::sweep::Measures;
use crate::transform::{RecordScratch, RecordTransform, fold};
use crate::{Error, Result};

/// A measure of a chain or its run, in the units of its scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Aim {
    /// Largest force of the first contact, or of the last one, the wall's where there is one.
    PeakForceFirst,
    PeakForceLast,
    /// `int F dt` of the last contact over the run.
    ImpulseLast,
    /// Energy passed through the last contact that joins two sites, or its share of the energy put in.
    EnergyPassedLast,
    EnergyPassedShare,
    /// Energy taken out by losses.
    EnergyLost,
    /// Share of the energy of the last contact's force above a frequency, in cycles per unit of time.
    ForceAbove(f64),
    /// When the force of the last contact is largest.
    PeakForceLastTime,
    TotalMass,
}

/// Those without a value of their own.
const NAMED: [Aim; 8] = [
    Aim::PeakForceFirst,
    Aim::PeakForceLast,
    Aim::ImpulseLast,
    Aim::EnergyPassedLast,
    Aim::EnergyPassedShare,
    Aim::EnergyLost,
    Aim::PeakForceLastTime,
    Aim::TotalMass,
];

const ABOVE: &str = "force_above:";

impl Aim {
    /// From its name: a column of `sweep`, `impulse_last`, `energy_passed_share`, `total_mass`, or `force_above:2kHz`.
    ///
    /// # Errors
    /// The names there are.
    pub fn parse(text: &str) -> std::result::Result<Aim, String> {
        let text = text.trim();
        let name = text.replace('-', "_");
        if let Some(aim) = NAMED.into_iter().find(|aim| aim.name() == name) {
            return Ok(aim);
        }
        let above = text.strip_prefix(ABOVE).map(Measure::<Frequency>::read);
        match above {
            Some(Ok(edge)) if edge.value > 0.0 => Ok(Aim::ForceAbove(edge.value)),
            _ => {
                let names = NAMED.map(Aim::name).join(", ");
                Err(format!("expected {names}, or {ABOVE}FREQUENCY"))
            }
        }
    }

    /// Its name, as it is typed.
    pub fn name(self) -> String {
        match self {
            Aim::ForceAbove(edge) => format!("{ABOVE}{edge}"),
            aim => name_of(&aim),
        }
    }

    /// In words.
    pub(super) fn words(self) -> String {
        let words = match self {
            Aim::PeakForceFirst => "the largest force of the first contact",
            Aim::PeakForceLast => "the largest force of the last contact",
            Aim::ImpulseLast => "the impulse of the last contact",
            Aim::EnergyPassedLast => "the energy past the last contact",
            Aim::EnergyPassedShare => "the share of the energy past the last contact",
            Aim::EnergyLost => "the energy lost",
            Aim::ForceAbove(edge) => {
                return format!("the share of the last contact's force above {edge}");
            }
            Aim::PeakForceLastTime => "the time of the largest force of the last contact",
            Aim::TotalMass => "the mass of all bodies",
        };
        words.to_owned()
    }

    /// Its unit in a scene of these units; empty for none.
    pub fn unit(self, units: Units) -> &'static str {
        match self {
            _ if units == Units::None => "",
            Aim::PeakForceFirst | Aim::PeakForceLast => "N",
            Aim::ImpulseLast => "N s",
            Aim::EnergyPassedLast | Aim::EnergyLost => "J",
            Aim::EnergyPassedShare | Aim::ForceAbove(_) => "",
            Aim::PeakForceLastTime => "s",
            Aim::TotalMass => "kg",
        }
    }

    /// What a run must record.
    pub(super) fn needs(self) -> Record {
        let energies = [
            Aim::EnergyPassedLast,
            Aim::EnergyPassedShare,
            Aim::EnergyLost,
        ];
        Record {
            displacement: true,
            force: true,
            energy: energies.contains(&self),
        }
    }

    /// Its value; `None` where the run does not tell, such as a force that still rises.
    pub(super) fn of_run(self, run: &Run) -> Option<f64> {
        let measures = || Measures::of(run);
        let step = run.time[1] - run.time[0];
        match self {
            Aim::PeakForceFirst => measures().peak_force_first,
            Aim::PeakForceLast => measures().peak_force_last,
            Aim::ImpulseLast => Some(impulse(&force_of(run)?, step)),
            Aim::EnergyPassedLast => measures().energy_passed_last,
            Aim::EnergyPassedShare => {
                let found = measures();
                Some(found.energy_passed_last? / found.energy_input?)
            }
            Aim::EnergyLost => measures().energy_lost,
            Aim::ForceAbove(edge) => share_above(&force_of(run)?, step, edge),
            Aim::PeakForceLastTime => measures().peak_force_last_time,
            Aim::TotalMass => Some(run.chain.mass.iter().sum()),
        }
    }
}

/// The force of the last contact at each sample.
pub(super) fn force_of(run: &Run) -> Option<Vec<f64>> {
    let force = run.force.as_ref()?;
    let last = force.ncols().checked_sub(1)?;
    Some(force.column(last).to_vec())
}

/// By the trapezoid rule.
fn impulse(force: &[f64], dt: f64) -> f64 {
    let ends = 0.5 * (force[0] + force[force.len() - 1]);
    dt * (force.iter().sum::<f64>() - ends)
}

fn share_above(force: &[f64], dt: f64, edge: f64) -> Option<f64> {
    let n = force.len();
    let transform = RecordTransform::<f64>::new(&vec![1.0; n], n);
    let mut scratch = RecordScratch::default();
    let spectrum = transform.spectra_of_rows(force, 1, &mut scratch);
    let energy = |m: usize| spectrum[m].norm_sqr() * fold(m, n);
    let (mut above, mut all) = (0.0, 0.0);
    for m in 0..=n / 2 {
        all += energy(m);
        if m as f64 > edge * n as f64 * dt {
            above += energy(m);
        }
    }
    (all > 0.0).then(|| above / all)
}

/// A measure that must not exceed a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    pub aim: Aim,
    pub most: f64,
}

impl Limit {
    /// From `total_mass=0.5`, in the units of the scene.
    ///
    /// # Errors
    /// [`Error::Request`] for another form.
    pub fn parse(text: &str) -> Result<Limit> {
        let refuse = |expected: String| Error::request("at-most", expected, text);
        let form = || "MEASURE=VALUE, such as total_mass=0.5".to_owned();
        let (name, value) = text.split_once('=').ok_or_else(|| refuse(form()))?;
        let most = value.trim().parse().ok().filter(|v: &f64| v.is_finite());
        let most = most.ok_or_else(|| refuse(form()))?;
        let aim = Aim::parse(name).map_err(refuse)?;
        Ok(Limit { aim, most })
    }
}
