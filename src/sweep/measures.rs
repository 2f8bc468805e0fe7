//! The measures of a sweep's member.

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::chain::{EndTime, Peak, Run, Simulation};
use crate::observer::Observer;

/// Peaks whose relative error may be larger are not reported.
const KNOWN: f64 = 0.01;

/// The key of the scene that has to grow for a force to be known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Needs {
    /// The force still rises, or is not there yet, when the run ends.
    EndTime,
    /// Samples are too far apart.
    Samples,
    /// The error of the velocities is too large.
    Tolerance,
}

/// Measures of a run, in the units of its scene; `None` where the scene does not record what a
/// measure needs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measures {
    pub run_end_time: f64,
    /// Largest force of the first contact, located between samples; `None` also where it is not known to
    /// 1 %, and where there is none yet or it still rises at the end.
    pub peak_force_first: Option<f64>,
    /// An upper bound of its error, from every second sample and from the error of the velocities.
    pub peak_force_first_error: Option<f64>,
    /// The same of the last contact, the wall's where there is one.
    pub peak_force_last: Option<f64>,
    pub peak_force_last_error: Option<f64>,
    /// When that was.
    pub peak_force_last_time: Option<f64>,
    /// What has to grow for it to be known; `None` where it is, and where the scene does not record forces.
    #[serde(default)]
    pub peak_force_last_needs: Option<Needs>,
    /// Energy at the start and put in by a drive.
    pub energy_input: Option<f64>,
    /// Energy passed through the last contact that joins two sites.
    pub energy_passed_last: Option<f64>,
    /// Energy taken out by losses.
    pub energy_lost: Option<f64>,
    /// Estimated error of the velocities, relative to the velocity scale.
    pub error: Option<f64>,
    pub energy_drift: Option<f64>,
    pub velocity_scale: f64,
    pub steps: u64,
    /// Whether the run ended with a warning: its tolerance is not assured.
    pub warned: bool,
}

impl Measures {
    /// Of a run. One that ends by itself goes on until the force at the wall has peaked.
    ///
    /// Energies are not followed along the steps where what has passed the last contact is the energy of the site
    /// behind it. That halves the work of a step, and energies, whose quadrature converges more slowly than
    /// velocities, no longer shorten it.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(super) fn of_run(mut simulation: Simulation, observer: &dyn Observer) -> Result<Measures> {
        if simulation.record.displacement && simulation.chain.is_closed(simulation.drive.is_some())
        {
            simulation.record.energy = false;
        }
        if simulation.end_time == EndTime::Arrival && simulation.record.force {
            let pilot = Simulation {
                estimate_error: false,
                ..simulation.clone()
            };
            if let Some(end) = pilot.run(observer)?.end_behind_wall_peak() {
                simulation.end_time = EndTime::At(end);
            }
        }
        Ok(Measures::of(&simulation.run(observer)?))
    }

    pub fn of(run: &Run) -> Measures {
        let contacts = run.chain.n_contacts();
        let last_sample = run.time.len() - 1;
        let spacing = run.time[last_sample] - run.time[last_sample - 1];
        let speed = 2.0 * run.report.error.unwrap_or(0.0) * run.report.velocity_scale;
        // The peak where it is known, or what has to grow for it.
        let peak = |contact: usize| {
            let sampled = run.peak_force(contact)?;
            let error = sampled.error + speed * run.impedance(contact).unwrap_or(0.0);
            let is_past = sampled.time <= run.time[last_sample] - 1e-6 * spacing;
            let known = KNOWN * sampled.value;
            Some(match sampled.value > 0.0 && is_past {
                false => Err(Needs::EndTime),
                true if sampled.error > known => Err(Needs::Samples),
                true if error > known => Err(Needs::Tolerance),
                true => Ok(Peak { error, ..sampled }),
            })
        };
        let first = (contacts > 0).then(|| peak(0)?.ok()).flatten();
        let (last, last_needs) = match contacts.checked_sub(1).and_then(peak) {
            Some(Ok(peak)) => (Some(peak), None),
            Some(Err(needs)) => (None, Some(needs)),
            None => (None, None),
        };
        let joint = run.chain.n_sites().checked_sub(2);
        let start = run.displacement.as_ref().map(|x| {
            let (x, v) = (x.row(0).to_vec(), run.velocity.row(0).to_vec());
            let input = run.energy_input.as_ref().map_or(0.0, |e| e[last_sample]);
            let own = run.resonators_at(0);
            run.chain.energy(&x, &v, 0.0)
                + run
                    .chain
                    .resonator_energy(&x, own.each_ref().map(|v| &v[..]))
                + input
        });
        let last_site = |x: &Array2<f64>, sample: usize| {
            let (x, v) = (x.row(sample).to_vec(), run.velocity.row(sample).to_vec());
            let mut energies = vec![0.0; v.len()];
            run.chain.site_energies(&x, &v, 0.0, &mut energies);
            let own = run.resonators_at(sample);
            run.chain
                .add_resonator_energies(&x, own.each_ref().map(|v| &v[..]), &mut energies);
            energies[v.len() - 1]
        };
        let passed = match (&run.energy_passed, &run.displacement) {
            (Some(passed), _) => joint.map(|j| passed[[last_sample, j]]),
            (None, Some(x)) if run.chain.is_closed(run.drive.is_some()) => {
                joint.map(|_| last_site(x, last_sample) - last_site(x, 0))
            }
            _ => None,
        };
        let report = &run.report;
        Measures {
            run_end_time: run.time[last_sample],
            peak_force_first: first.map(|peak| peak.value),
            peak_force_first_error: first.map(|peak| peak.error),
            peak_force_last: last.map(|peak| peak.value),
            peak_force_last_error: last.map(|peak| peak.error),
            peak_force_last_time: last.map(|peak| peak.time),
            peak_force_last_needs: last_needs,
            energy_input: start.filter(|_| run.drive.is_none() || run.energy_input.is_some()),
            energy_passed_last: passed,
            energy_lost: run
                .energy_lost
                .as_ref()
                .map(|lost| lost.row(last_sample).sum()),
            error: report.error,
            energy_drift: report.energy_drift,
            velocity_scale: report.velocity_scale,
            steps: report.cost.steps,
            warned: !report.warnings.is_empty(),
        }
    }
}
