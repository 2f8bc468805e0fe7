//! The samples of a run, and the arrays that are filled at them.

use ndarray::{Array1, Array2, ArrayView1};

use super::result::{Run, RunReport, RunWarning};
use super::simulation::{Record, Simulation};
use super::stepping::{Cost, FIRST_CONTACT, FIRST_SITE, State, StepControl};
use crate::{Error, Result};

/// Uniform samples from 0 to the end time, or every n-th of them and the last one.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleTimes {
    end: f64,
    last: usize,
    stride: usize,
}

impl SampleTimes {
    pub(super) fn all(end: f64, samples: usize) -> SampleTimes {
        SampleTimes {
            end,
            last: samples - 1,
            stride: 1,
        }
    }

    /// Not more than about this many of them.
    pub(super) fn at_most(self, number: usize) -> SampleTimes {
        SampleTimes {
            stride: self.last.div_ceil(number).max(1),
            ..self
        }
    }

    pub(super) fn number(&self) -> usize {
        self.last.div_ceil(self.stride) + 1
    }

    /// Among all samples.
    pub(super) fn index(&self, sample: usize) -> usize {
        (sample * self.stride).min(self.last)
    }

    pub(super) fn time(&self, sample: usize) -> f64 {
        self.end * (self.index(sample) as f64 / self.last as f64)
    }

    /// The largest difference of a velocity, of a body or a resonator, at each of these samples.
    pub(super) fn of_runs(&self, few: &Run, all: &Run) -> Vec<f64> {
        let mut rows = self.differences(&few.velocity, &all.velocity);
        if let (Some(few), Some(all)) = (&few.resonator_velocity, &all.resonator_velocity) {
            let others = self.differences(few, all);
            rows.iter_mut()
                .zip(others)
                .for_each(|(row, other)| *row = row.max(other));
        }
        rows
    }

    /// The largest difference of each row at these samples from that at all samples.
    pub(super) fn differences(&self, few: &Array2<f64>, all: &Array2<f64>) -> Vec<f64> {
        let rows = few.rows().into_iter().enumerate();
        let largest = |(sample, row): (usize, ArrayView1<f64>)| {
            let pairs = row.into_iter().zip(all.row(self.index(sample)));
            pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
        };
        rows.map(largest).collect()
    }
}

/// Fills the arrays of a run.
pub(super) struct Recorder {
    samples: SampleTimes,
    run: Run,
    lossy: bool,
    /// Largest energy and largest unexplained change of it.
    energy: [f64; 3],
    explained: bool,
    /// The contacts whose laws are known in a range, their static overlaps, and the overlap of each farthest outside.
    ranges: Vec<(usize, [f64; 2], f64, Option<f64>)>,
}

impl Recorder {
    pub(super) fn new(
        simulation: &Simulation,
        record: Record,
        scale: f64,
        samples: SampleTimes,
    ) -> Recorder {
        let chain = simulation.chain.clone();
        let (rows, n, m) = (samples.number(), chain.n_sites(), chain.n_contacts());
        let array = |wanted: bool, columns| wanted.then(|| Array2::zeros((rows, columns)));
        let lossy = chain.is_lossy();
        let resonators = chain.resonators().is_some();
        let driven = simulation.drive.is_some();
        let ranges = chain.contacts().enumerate();
        let ranges = ranges.map(|(j, of)| (j, of.law.range(), of.static_overlap, None));
        let ranges = ranges.filter(|of| of.1.iter().any(|end| end.is_finite()));
        Recorder {
            ranges: ranges.collect(),
            samples,
            lossy,
            energy: [0.0; 3],
            explained: record.energy || !(lossy || driven),
            run: Run {
                time: Array1::zeros(rows),
                velocity: Array2::zeros((rows, n)),
                displacement: array(record.displacement, n),
                force: array(record.force, m),
                energy_passed: array(record.energy, m),
                energy_lost: array(record.energy && lossy, n),
                resonator_displacement: array(resonators && record.displacement, n),
                resonator_velocity: array(resonators, n),
                energy_input: (record.energy && driven).then(|| Array1::zeros(rows)),
                gradient: None,
                chain,
                drive: simulation.drive.clone(),
                report: RunReport {
                    velocity_scale: scale,
                    error: None,
                    energy_drift: None,
                    lyapunov: None,
                    cost: Cost::default(),
                    warnings: Vec::new(),
                },
            },
        }
    }

    pub(super) fn keep(&mut self, sample: usize, state: &State) {
        let run = &mut self.run;
        let (n, m) = (run.chain.n_sites(), run.chain.n_contacts());
        let (x, v) = (&state.x[FIRST_SITE..][..n], &state.v[FIRST_SITE..][..n]);
        let [y, w] = state.resonators(&run.chain);
        let passed = part(&state.passed, FIRST_CONTACT, m);
        run.time[sample] = self.samples.time(sample);
        for (array, values) in [
            (Some(&mut run.velocity), v),
            (run.displacement.as_mut(), x),
            (run.force.as_mut(), part(&state.force, FIRST_CONTACT, m)),
            (run.energy_passed.as_mut(), passed),
            (run.energy_lost.as_mut(), part(&state.lost, FIRST_SITE, n)),
            (run.resonator_displacement.as_mut(), y),
            (run.resonator_velocity.as_mut(), w),
        ] {
            if let Some(all) = array.and_then(|array| array.as_slice_mut()) {
                let row = values.len() * sample..values.len() * (sample + 1);
                all[row].copy_from_slice(values);
            }
        }
        if let Some(array) = &mut run.energy_input {
            array[sample] = state.put_in();
        }
        let chain = &run.chain;
        for (j, [least, most], rest, farthest) in &mut self.ranges {
            let overlap = *rest + chain.overlap(*j, x);
            let beyond = |overlap: f64| (*least - overlap).max(overlap - *most);
            if beyond(overlap) > farthest.map_or(0.0, beyond) {
                *farthest = Some(overlap);
            }
        }
        let last = run.time.len() - 1;
        if !self.explained || !(sample == last || sample.is_multiple_of(last.div_ceil(64))) {
            return;
        }
        let wall = match chain.has_left_wall() {
            true => state.x[0],
            false => 0.0,
        };
        let mut energy = chain.energy(x, v, wall) + chain.resonator_energy(x, [y, w]);
        let [first, largest, drift] = &mut self.energy;
        *largest = largest.max(energy.abs());
        if self.lossy {
            energy += state.lost.iter().sum::<f64>();
        }
        energy -= state.put_in();
        if sample == 0 {
            *first = energy;
        }
        let change = (energy - *first).abs();
        // NaN is worse than any drift and is kept.
        if change > *drift || change.is_nan() {
            *drift = change;
        }
    }

    /// # Errors
    /// [`crate::Error::Request`] where the energy of fixed steps ran away.
    pub(super) fn finish(mut self, control: StepControl, cost: Cost) -> Result<Run> {
        let [_, largest, drift] = self.energy;
        self.run.report.cost = cost;
        let outside = self.ranges.iter();
        let outside = outside.filter_map(|(contact, range, _, overlap)| {
            Some(RunWarning::OutsideLaw {
                contact: *contact,
                overlap: (*overlap)?,
                range: *range,
            })
        });
        // One says it for all.
        self.run.report.warnings.extend(outside.take(1));
        let drift = (self.explained && largest > 0.0).then(|| drift / largest);
        self.run.report.energy_drift = drift;
        match (control, drift) {
            (StepControl::Fixed(step), Some(drift)) if drift.is_nan() || drift > 0.5 => {
                let expected = "a step below the stability limit";
                let found = format!("{step:e}, with which the energy runs away");
                Err(Error::request("step", expected, found))
            }
            _ => Ok(self.run),
        }
    }
}

/// What a state holds of the sites or contacts; nothing where it is not followed.
fn part(row: &[f64], from: usize, number: usize) -> &[f64] {
    row.get(from..from + number).unwrap_or_default()
}
