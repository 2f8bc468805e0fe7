//! The samples of a run, and the arrays that are filled at them.

use ndarray::{Array1, Array2};

use super::lattice::refuse;
use super::result::{Run, RunReport};
use super::simulation::{Record, Simulation};
use super::stepping::{Cost, FIRST_CONTACT, FIRST_SITE, State, StepControl};
use crate::Result;

/// Uniform samples from 0 to the end time.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleTimes {
    end: f64,
    last: usize,
}

impl SampleTimes {
    pub(super) fn all(end: f64, samples: usize) -> SampleTimes {
        let last = samples - 1;
        SampleTimes { end, last }
    }

    /// The first and the last of them.
    pub(super) fn ends(self) -> SampleTimes {
        SampleTimes::all(self.end, 2)
    }

    pub(super) fn number(&self) -> usize {
        self.last + 1
    }

    pub(super) fn time(&self, sample: usize) -> f64 {
        self.end * (sample as f64 / self.last as f64)
    }

    pub(super) fn times(self) -> impl Iterator<Item = f64> {
        (0..self.number()).map(move |sample| self.time(sample))
    }

    /// These times and those of checks, rising, and which sample and which check each is.
    pub(super) fn with(self, checks: &Checks) -> (Vec<f64>, Vec<[Option<usize>; 2]>) {
        let checked = checks.velocity.nrows();
        let parts = SampleTimes::all(self.end, checked + 1);
        let (mut sample, mut check) = (0, 0);
        let (mut times, mut which) = (Vec::new(), Vec::new());
        while sample <= self.last || check < checked {
            let at = |wanted: bool, time: f64| if wanted { time } else { f64::INFINITY };
            let [next, next_check] = [
                at(sample <= self.last, self.time(sample)),
                // The state at the start is nobody's error.
                at(check < checked, parts.time(check + 1)),
            ];
            let time = next.min(next_check);
            let is = [next == time, next_check == time];
            times.push(time);
            which.push([is[0].then_some(sample), is[1].then_some(check)]);
            sample += usize::from(is[0]);
            check += usize::from(is[1]);
        }
        (times, which)
    }
}

/// Velocities at equally distant times, by which runs are compared.
#[derive(Debug)]
pub(super) struct Checks {
    velocity: Array2<f64>,
}

impl Checks {
    pub(super) fn new(checks: usize, sites: usize) -> Checks {
        Checks {
            velocity: Array2::zeros((checks, sites)),
        }
    }

    pub(super) fn none() -> Checks {
        Checks::new(0, 0)
    }

    pub(super) fn keep(&mut self, check: usize, state: &State) {
        let mut row = self.velocity.row_mut(check);
        let sites = &state.v[FIRST_SITE..];
        row.iter_mut().zip(sites).for_each(|(to, from)| *to = *from);
    }

    pub(super) fn largest(&self) -> f64 {
        self.velocity
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()))
    }

    /// The largest difference over the largest in the first eighth of the time, which is no less than
    /// `least`.
    pub(super) fn growth(&self, other: &Checks, least: f64) -> f64 {
        let early = self.velocity.len() / 8;
        let pairs = self.velocity.iter().zip(&other.velocity).take(early);
        let early = pairs.fold(least, |worst: f64, (a, b)| worst.max((a - b).abs()));
        self.largest_difference(other) / early
    }

    pub(super) fn largest_difference(&self, other: &Checks) -> f64 {
        let pairs = self.velocity.iter().zip(&other.velocity);
        pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
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
        let lossy = chain.losses.any();
        let driven = simulation.drive.is_some();
        Recorder {
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
                energy_input: (record.energy && driven).then(|| Array1::zeros(rows)),
                chain,
                drive: simulation.drive,
                report: RunReport {
                    velocity_scale: scale,
                    error: None,
                    energy_drift: None,
                    cost: Cost::default(),
                    warnings: Vec::new(),
                },
            },
        }
    }

    pub(super) fn keep(&mut self, sample: usize, state: &State) {
        let Run {
            chain,
            time: times,
            velocity,
            displacement,
            force,
            energy_passed,
            energy_lost,
            energy_input,
            ..
        } = &mut self.run;
        let (n, m) = (chain.n_sites(), chain.n_contacts());
        let (x, v) = (&state.x[FIRST_SITE..][..n], &state.v[FIRST_SITE..][..n]);
        times[sample] = self.samples.time(sample);
        let copy = |array: &mut Array2<f64>, values: &[f64]| {
            let row = array.ncols() * sample..array.ncols() * (sample + 1);
            if let Some(all) = array.as_slice_mut() {
                all[row].copy_from_slice(values);
            }
        };
        copy(velocity, v);
        if let Some(array) = displacement {
            copy(array, x);
        }
        if let Some(array) = force {
            copy(array, &state.force[FIRST_CONTACT..][..m]);
        }
        if let Some(array) = energy_passed {
            copy(array, &state.passed[FIRST_CONTACT..][..m]);
        }
        if let Some(array) = energy_lost {
            copy(array, &state.lost[FIRST_SITE..][..n]);
        }
        if let Some(array) = energy_input {
            array[sample] = state.passed[1];
        }
        let last = times.len() - 1;
        if !self.explained || !(sample == last || sample.is_multiple_of(last.div_ceil(64))) {
            return;
        }
        let wall = if chain.has_left_wall() {
            state.x[0]
        } else {
            0.0
        };
        let mut energy = chain.energy(x, v, wall);
        let [first, largest, drift] = &mut self.energy;
        *largest = largest.max(energy.abs());
        if self.lossy {
            energy += state.lost.iter().sum::<f64>();
        }
        energy -= state.passed.get(1).copied().unwrap_or(0.0);
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
        let drift = (self.explained && largest > 0.0).then(|| drift / largest);
        self.run.report.energy_drift = drift;
        match (control, drift) {
            (StepControl::Fixed(step), Some(drift)) if drift.is_nan() || drift > 0.5 => {
                let expected = "a step below the stability limit";
                let found = format!("{step:e}, with which the energy runs away");
                Err(refuse("step", expected, found))
            }
            _ => Ok(self.run),
        }
    }
}
