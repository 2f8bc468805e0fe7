//! What a design is judged by: a measure of its run.

use crate::chain::scene::Units;
use crate::chain::{Record, Run};
use crate::measure::{Frequency, Measure};
use crate::sweep::Measures;
use crate::transform::{RecordScratch, RecordTransform, fold};
use crate::{Error, Result};

/// A measure of a chain or its run, in the units of its scene.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Aim {
    /// Largest force of the first contact, or of the last one, the wall's where there is one.
    PeakForceFirst,
    PeakForceLast,
    /// `int F dt` of the last contact over the run.
    ImpulseLast,
    /// Energy passed through the last contact that joins two sites, or its share of the energy put in.
    EnergyPassed,
    EnergyPassedShare,
    /// Energy taken out by losses.
    EnergyLost,
    /// Share of the energy of the last contact's force above a frequency, in cycles per unit of time.
    ForceAbove(f64),
    /// When the force of the last contact is largest.
    PeakTime,
    TotalMass,
}

/// Measures without a value of their own: names, words and units.
const NAMED: [(Aim, &str, &str, &str); 8] = [
    (
        Aim::PeakForceFirst,
        "peak_force_first",
        "the largest force of the first contact",
        "N",
    ),
    (
        Aim::PeakForceLast,
        "peak_force_last",
        "the largest force of the last contact",
        "N",
    ),
    (
        Aim::ImpulseLast,
        "impulse_last",
        "the impulse of the last contact",
        "N s",
    ),
    (
        Aim::EnergyPassed,
        "energy_passed_last",
        "the energy past the last contact",
        "J",
    ),
    (
        Aim::EnergyPassedShare,
        "energy_passed_share",
        "the share of the energy past the last contact",
        "",
    ),
    (Aim::EnergyLost, "energy_lost", "the energy lost", "J"),
    (
        Aim::PeakTime,
        "peak_force_last_time",
        "the time of the largest force of the last contact",
        "s",
    ),
    (Aim::TotalMass, "total_mass", "the mass of all bodies", "kg"),
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
        if let Some((aim, ..)) = NAMED.iter().find(|(_, own, ..)| *own == name) {
            return Ok(*aim);
        }
        let above = text.strip_prefix(ABOVE).map(Measure::<Frequency>::read);
        match above {
            Some(Ok(edge)) if edge.value > 0.0 => Ok(Aim::ForceAbove(edge.value)),
            _ => {
                let names = NAMED.map(|(_, name, ..)| name).join(", ");
                Err(format!("expected {names}, or {ABOVE}FREQUENCY"))
            }
        }
    }

    /// Name, words and unit.
    fn said(self) -> [String; 3] {
        match (NAMED.iter().find(|(aim, ..)| *aim == self), self) {
            (Some((_, name, words, unit)), _) => [*name, *words, *unit].map(str::to_owned),
            (None, Aim::ForceAbove(edge)) => [
                format!("{ABOVE}{edge}"),
                format!("the share of the last contact's force above {edge}"),
                String::new(),
            ],
            _ => Default::default(),
        }
    }

    /// Its name, as it is typed.
    pub fn name(self) -> String {
        let [name, ..] = self.said();
        name
    }

    /// In words.
    pub(super) fn words(self) -> String {
        let [_, words, _] = self.said();
        words
    }

    /// Its unit in a scene of these units; empty for none.
    pub fn unit(self, units: Units) -> String {
        let [.., unit] = self.said();
        match units {
            Units::Si => unit,
            Units::None => String::new(),
        }
    }

    /// What a run must record.
    pub(super) fn needs(self) -> Record {
        let energies = [Aim::EnergyPassed, Aim::EnergyPassedShare, Aim::EnergyLost];
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
            Aim::EnergyPassed => measures().energy_passed_last,
            Aim::EnergyPassedShare => {
                let found = measures();
                Some(found.energy_passed_last? / found.energy_input?)
            }
            Aim::EnergyLost => measures().energy_lost,
            Aim::ForceAbove(edge) => share_above(&force_of(run)?, step, edge),
            Aim::PeakTime => measures().peak_force_last_time,
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
    let (spectrum, _) = transform.transform(std::iter::once(force), &mut scratch);
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
        let most: f64 = value.trim().parse().map_err(|_| refuse(form()))?;
        if !most.is_finite() {
            return Err(refuse(form()));
        }
        let aim = Aim::parse(name).map_err(refuse)?;
        Ok(Limit { aim, most })
    }
}
