//! The measures of a sweep's member.

use std::cell::Cell;

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::chain::{Accuracy, Checked, EndTime, Peak, Run, Simulation};
use crate::observer::Observer;

/// Peaks whose relative error may be larger are not reported.
const KNOWN: f64 = 0.01;

/// Local error of the run that finds when a run ends.
const PILOT: f64 = 1e-7;

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
    /// An upper bound of its error, from every second sample and from the errors of the velocities beside the contact
    /// until then.
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
    /// Where what has passed the last contact is the energy of the site behind it, energies are not followed along the
    /// steps. That halves the work of a step, and energies, whose quadrature converges more slowly than velocities, no
    /// longer shorten it. Then a tolerance is kept by the two forces, as far as samples show them, and not by velocities
    /// that have no part in them, which a chain may amplify.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(super) fn of_run(mut simulation: Simulation, observer: &dyn Observer) -> Result<Measures> {
        if simulation.record.displacement && simulation.chain.is_closed(simulation.drive.is_some())
        {
            simulation.record.energy = false;
        }
        if simulation.end_time == EndTime::Arrival && simulation.record.force {
            let mut pilot = Simulation {
                estimate_error: false,
                ..simulation.clone()
            };
            if let Accuracy::Tolerance(tolerance) = pilot.accuracy {
                pilot.accuracy = Accuracy::LocalError(tolerance.max(PILOT));
            }
            if let Some(end) = pilot.run(observer)?.end_behind_wall_peak() {
                simulation.end_time = EndTime::At(end);
            }
        }
        let tolerance = match simulation.accuracy {
            Accuracy::Tolerance(tolerance) => tolerance,
            _ => 0.0,
        };
        let has_forces_alone = simulation.record.force && !simulation.record.energy;
        let errors = Cell::new([None; 2]);
        let is_enough = |checked: &Checked| {
            let found = ends(checked.run).map(|contact| {
                let peak = checked.run.peak_force(contact?)?;
                Some((peak, checked.force_error(contact?, peak.time)?))
            });
            errors.set(found.map(|found| found.map(|(_, error)| error)));
            let mut known = found.iter().flatten();
            has_forces_alone
                && known.all(|(peak, error)| *error <= peak.error.max(tolerance * peak.value))
        };
        let run = simulation.run_until(&is_enough, observer)?;
        Ok(Measures::with(&run, errors.get()))
    }

    pub fn of(run: &Run) -> Measures {
        Measures::with(run, [None; 2])
    }

    /// With what errors of the velocities change the two forces by; `None`: as much as the largest one can.
    fn with(run: &Run, errors: [Option<f64>; 2]) -> Measures {
        let last_sample = run.time.len() - 1;
        let spacing = run.time[last_sample] - run.time[last_sample - 1];
        let speed = 2.0 * run.report.error.unwrap_or(0.0) * run.report.velocity_scale;
        // The peak where it is known, or what has to grow for it.
        let peak = |contact: usize, error: Option<f64>| {
            let sampled = run.peak_force(contact)?;
            let error = error.or_else(|| run.force_error(contact, speed));
            let error = sampled.error + error.unwrap_or(0.0);
            let is_past = sampled.time <= run.time[last_sample] - 1e-6 * spacing;
            let known = KNOWN * sampled.value;
            Some(match sampled.value > 0.0 && is_past {
                false => Err(Needs::EndTime),
                true if sampled.error > known => Err(Needs::Samples),
                true if error > known => Err(Needs::Tolerance),
                true => Ok(Peak { error, ..sampled }),
            })
        };
        let [first, last] = ends(run);
        let first = first.and_then(|contact| peak(contact, errors[0])?.ok());
        let last = last.and_then(|contact| peak(contact, errors[1]));
        let last_needs = last.and_then(|last| last.err());
        let last = last.and_then(|last| last.ok());
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

/// The first contact and the last one.
fn ends(run: &Run) -> [Option<usize>; 2] {
    let last = run.chain.n_contacts().checked_sub(1);
    [last.map(|_| 0), last]
}
