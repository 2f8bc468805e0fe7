//! A simulation as data, and what it yields.

use ndarray::{Array1, Array2};

use super::drive::Drive;
use super::lattice::{Chain, Ends, refuse};
use super::stepping::{self, Cost, Scheme, State, StepControl, Stepping, Task, Window};
use crate::analyze::Observer;
use crate::field::{Axis, Field, Quantity};
use crate::{Error, Result};

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

/// What is kept beside the velocities; nothing else is computed.
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

/// A chain, how it starts, and what is asked of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    pub chain: Chain,
    /// Initial velocity of each site.
    pub velocity: Vec<f64>,
    /// Initial displacement of each site from the static state.
    pub displacement: Vec<f64>,
    pub drive: Option<Drive>,
    pub scheme: Scheme,
    pub accuracy: Accuracy,
    pub end_time: EndTime,
    /// Uniform samples from 0 to the end time, both included.
    pub samples: usize,
    pub record: Record,
    /// Repeats the run with a smaller tolerance and reports by how much it differs.
    pub estimate_error: bool,
    pub window: Window,
    /// Bytes that the results may take; `None`: what is available.
    pub memory: Option<u64>,
}

/// The results of a run; arrays are `(time, site)` or `(time, contact)`.
#[derive(Debug, Clone)]
pub struct Run {
    pub chain: Chain,
    pub drive: Option<Drive>,
    pub time: Array1<f64>,
    pub velocity: Array2<f64>,
    pub displacement: Option<Array2<f64>>,
    /// Force in each contact beyond the static one, damping included, positive in compression.
    pub force: Option<Array2<f64>>,
    /// `W_j(t)`: energy passed through contact j towards +x since 0; 0 at a wall.
    pub energy_passed: Option<Array2<f64>>,
    /// Energy lost at each site since 0; only where the chain has losses.
    pub energy_lost: Option<Array2<f64>>,
    /// Energy put in at a driven end since 0.
    pub energy_input: Option<Array1<f64>>,
    pub report: RunReport,
}

/// How well a run went.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RunReport {
    /// The speed that errors are relative to: the largest initial one; from rest, that of the
    /// lightest site with the energy of the start; driven, that of the drive.
    pub velocity_scale: f64,
    /// Largest difference of a velocity, relative to the scale, between this run and one of
    /// [`CHECK_FACTOR`] times its local error; `None` where it was not asked for.
    pub error: Option<f64>,
    /// Largest change of the energy that neither input nor losses explain, relative to the largest
    /// energy. Small drift says nothing of the error of velocities.
    pub energy_drift: Option<f64>,
    pub cost: Cost,
    pub warnings: Vec<RunWarning>,
}

/// A finding that its user should know.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case", tag = "code")]
#[non_exhaustive]
pub enum RunWarning {
    /// The velocities could not be had to the tolerance: smaller steps no longer bring two runs
    /// together, since the chain amplifies differences of the last digit.
    Sensitive {
        tolerance: f64,
        reached: f64,
        /// Largest change of a velocity, relative to the scale, over the relative change of the
        /// masses that caused it.
        amplification: f64,
    },
}

/// By what the local error shrinks in the run that a run is checked with.
pub const CHECK_FACTOR: f64 = 0.1;

/// Below this the estimate of a step's error is rounding.
const LEAST_LOCAL_ERROR: f64 = 1e-15;

/// Runs until the tolerance is reached or known to be out of reach.
const MOST_RUNS: usize = 6;

impl Simulation {
    /// The impact of a striker on a chain at rest: site 0 starts with `speed`.
    pub fn impact(chain: Chain, speed: f64, end_time: f64, samples: usize) -> Simulation {
        let mut velocity = vec![0.0; chain.n_sites()];
        if let Some(striker) = velocity.first_mut() {
            *striker = speed;
        }
        Simulation {
            displacement: vec![0.0; chain.n_sites()],
            velocity,
            chain,
            drive: None,
            scheme: Scheme::default(),
            accuracy: Accuracy::Tolerance(1e-9),
            end_time: EndTime::At(end_time),
            samples,
            record: Record::ALL,
            estimate_error: true,
            window: Window::default(),
            memory: None,
        }
    }

    /// # Errors
    /// [`Error::Request`] naming what is not physical or does not fit, [`Error::Memory`] for
    /// results that do not fit the memory.
    pub fn check(&self) -> Result<()> {
        self.chain.check()?;
        let n = self.chain.n_sites();
        for (name, values) in [
            ("velocity", &self.velocity),
            ("displacement", &self.displacement),
        ] {
            if values.len() != n {
                return Err(refuse(name, &format!("{n} values"), values.len()));
            }
            if let Some(value) = values.iter().find(|v| !v.is_finite()) {
                return Err(refuse(name, "finite values", value));
            }
        }
        if let EndTime::At(end) = self.end_time
            && !(end > 0.0 && end.is_finite())
        {
            return Err(refuse("end-time", "a positive time", end));
        }
        if self.samples < 2 {
            return Err(refuse("samples", "2 or more", self.samples));
        }
        match self.accuracy {
            Accuracy::Tolerance(value) | Accuracy::LocalError(value) => {
                if !(value > 0.0 && value < 1.0) {
                    return Err(refuse("tolerance", "a number between 0 and 1", value));
                }
                if !self.scheme.is_adaptive() {
                    return Err(refuse("step", "a step for a scheme of fixed steps", "none"));
                }
            }
            Accuracy::Step(step) if !(step > 0.0 && step.is_finite()) => {
                return Err(refuse("step", "a positive step", step));
            }
            Accuracy::Step(_) => {}
        }
        if matches!(self.drive, Some(Drive::Wall(_)))
            && !matches!(self.chain.ends, Ends::Fixed { .. })
        {
            let expected = "a chain fixed at both ends for a driven wall";
            return Err(refuse("drive", expected, format!("{:?}", self.chain.ends)));
        }
        if matches!(self.drive, Some(Drive::Force(_)))
            && matches!(self.chain.ends, Ends::Fixed { .. } | Ends::Periodic)
        {
            let expected = "a chain whose first end is free for a driving force";
            return Err(refuse("drive", expected, format!("{:?}", self.chain.ends)));
        }
        let (needed, allowed) = (self.bytes(), self.memory.unwrap_or_else(available_memory));
        if needed > allowed {
            return Err(Error::Memory {
                what: "the run",
                needed,
                allowed,
            });
        }
        Ok(())
    }

    /// Bytes that the results take.
    pub fn bytes(&self) -> u64 {
        let (n, m) = (self.chain.n_sites() as u64, self.chain.n_contacts() as u64);
        let Record {
            displacement,
            force,
            energy,
        } = self.record;
        let mut columns = 1 + n * (1 + u64::from(displacement)) + m * u64::from(force);
        if energy {
            columns += m + if self.chain.losses.any() { n } else { 0 };
        }
        if self.estimate_error {
            columns += n;
        }
        columns
            .saturating_mul(8)
            .saturating_mul(self.samples as u64)
    }

    /// Runs the simulation.
    ///
    /// A tolerance is checked by a second run of smaller steps, whose results are returned; while
    /// the two differ by more than the tolerance, the steps are made smaller still.
    ///
    /// # Errors
    /// As [`Simulation::check`]; [`Error::Request`] for a step that is unstable;
    /// [`Error::Cancelled`] when the observer asks to stop.
    pub fn run(&self, observer: &dyn Observer) -> Result<Run> {
        self.check()?;
        let scale = self.velocity_scale();
        let end = match self.end_time {
            EndTime::At(end) => end,
            EndTime::Arrival => self.arrival_time(scale, observer)?,
        };
        let (local, tolerance) = match self.accuracy {
            Accuracy::Step(step) => {
                return self.once(StepControl::Fixed(step), scale, end, self.record, observer);
            }
            Accuracy::LocalError(local) => (local, None),
            Accuracy::Tolerance(tolerance) => (self.local_error_for(tolerance), Some(tolerance)),
        };
        let with = |local: f64, record| {
            let control = StepControl::LocalError(local * scale);
            self.once(control, scale, end, record, observer)
        };
        if !self.estimate_error {
            return with(local, self.record);
        }
        let mut local = local;
        let mut coarse = with(local, Record::default())?;
        let mut best = f64::INFINITY;
        for _ in 0..MOST_RUNS {
            local = (local * CHECK_FACTOR).max(LEAST_LOCAL_ERROR);
            let mut fine = with(local, self.record)?;
            let error = largest_difference(&fine.velocity, &coarse.velocity) / scale;
            fine.report.error = Some(error);
            let reached = tolerance.is_none_or(|tolerance| error <= tolerance);
            let stuck = error > 0.5 * best;
            if reached {
                return Ok(fine);
            }
            best = best.min(error);
            coarse = fine;
            if stuck || local <= LEAST_LOCAL_ERROR {
                break;
            }
        }
        coarse.report.warnings.push(RunWarning::Sensitive {
            tolerance: tolerance.unwrap_or(local),
            reached: coarse.report.error.unwrap_or(f64::INFINITY),
            amplification: self.amplification(&coarse, local, scale, end, observer)?,
        });
        Ok(coarse)
    }

    /// The local error at which a run keeps the tolerance, from impacts on dimers of 100 sites
    /// (kappa 1 to 10^6): their errors were 0.1 to 6 times the local one. Energies passed, whose
    /// quadrature converges more slowly, are followed with steps shorter than velocities need.
    fn local_error_for(&self, tolerance: f64) -> f64 {
        let share = if self.record.energy {
            1.0 / 256.0
        } else {
            1.0 / 8.0
        };
        (tolerance * share).max(1e-13)
    }

    /// How much a relative change of 1e-9 of the masses, up and down in the order of Thue and
    /// Morse, changes the velocities. A change of the impact alone would only scale the motion.
    fn amplification(
        &self,
        run: &Run,
        local: f64,
        scale: f64,
        end: f64,
        observer: &dyn Observer,
    ) -> Result<f64> {
        let change = 1e-9;
        let mut other = self.clone();
        for (j, mass) in other.chain.mass.iter_mut().enumerate() {
            let up = j.count_ones() % 2 == 0;
            *mass *= 1.0 + if up { change } else { -change };
        }
        let control = StepControl::LocalError(local * scale);
        let other = other.once(control, scale, end, Record::default(), observer)?;
        Ok(largest_difference(&other.velocity, &run.velocity) / (change * scale))
    }

    fn velocity_scale(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let initial = largest(&self.velocity);
        if initial > 0.0 {
            return initial;
        }
        let lightest = self
            .chain
            .mass
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let stored = self.chain.energy(&self.displacement, &self.velocity, 0.0);
        if stored > 0.0 {
            return (2.0 * stored / lightest).sqrt();
        }
        match &self.drive {
            Some(Drive::Wall(wave)) => wave.amplitude().abs() * wave.angular_frequency(),
            Some(Drive::Force(wave)) => {
                wave.amplitude().abs() / (lightest * wave.angular_frequency())
            }
            None => 0.0,
        }
    }

    fn arrival_time(&self, scale: f64, observer: &dyn Observer) -> Result<f64> {
        let n = self.chain.n_sites();
        let still = |state: &State| state.v[n].abs() < 1e-3 * scale;
        let control = match self.accuracy {
            Accuracy::Step(step) => StepControl::Fixed(step),
            _ => StepControl::LocalError(1e-7 * scale),
        };
        let mut stepping = self.prepare(control, scale, false)?;
        let mut unit = self.contact_time(scale);
        let mut time = 0.0;
        // Twice the time a front needs that passes a site in ten contact times.
        let latest = 20.0 * (n + 10) as f64 * unit;
        while still(stepping.state()) {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            if time > latest {
                let expected = "a front that reaches the last site for `auto`";
                return Err(refuse("end-time", expected, format!("none until {time:e}")));
            }
            time += unit;
            stepping.advance_to(time)?;
        }
        if time == 0.0 {
            return Err(refuse(
                "end-time",
                "a last site at rest for `auto`",
                "a moving one",
            ));
        }
        // Located to a thousandth of a contact time by running the last stretch again.
        let mut stepping = self.prepare(control, scale, false)?;
        time -= unit;
        stepping.advance_to(time.max(0.0))?;
        unit *= 1e-3;
        while still(stepping.state()) {
            time += unit;
            stepping.advance_to(time)?;
        }
        Ok(time)
    }

    /// The time in which the softest contact stops the heaviest site.
    fn contact_time(&self, scale: f64) -> f64 {
        stepping::contact_time(&self.chain, scale, stepping::Extreme::Slowest)
    }

    fn prepare(&self, control: StepControl, scale: f64, energy: bool) -> Result<Box<dyn Stepping>> {
        stepping::prepare(&Task {
            chain: &self.chain,
            drive: self.drive,
            velocity: &self.velocity,
            displacement: &self.displacement,
            scheme: self.scheme,
            control,
            window: self.window,
            energy,
            velocity_scale: scale,
        })
    }

    fn once(
        &self,
        control: StepControl,
        scale: f64,
        end: f64,
        record: Record,
        observer: &dyn Observer,
    ) -> Result<Run> {
        observer.stage("stepping", self.samples as u64);
        let mut stepping = self.prepare(control, scale, record.energy)?;
        let mut recorder = Recorder::new(self, record, scale);
        let last = self.samples - 1;
        for sample in 0..self.samples {
            let time = end * (sample as f64 / last as f64);
            stepping.advance_to(time)?;
            recorder.keep(sample, time, stepping.state());
            observer.advance(1);
            if sample % 64 == 0 && observer.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        let run = recorder.finish(stepping.cost());
        match (control, run.report.energy_drift) {
            (StepControl::Fixed(step), Some(drift)) if drift > 0.5 => {
                let expected = "a step below the stability limit";
                let found = format!("{step:e}, with which the energy runs away");
                Err(refuse("step", expected, found))
            }
            _ => Ok(run),
        }
    }
}

impl Run {
    /// The velocities as a field, its time axis that of the samples, its sites counted.
    pub fn to_field(&self) -> Field {
        let mut field = Field::from_array(self.velocity.clone());
        field.quantity = Quantity::Velocity;
        field.name = "run".into();
        let last = self.time.len() - 1;
        field.time = Axis {
            origin: 0.0,
            step: self.time[last] / last as f64,
            unit: None,
        };
        field
    }
}

/// Fills the arrays of a run.
struct Recorder {
    run: Run,
    lossy: bool,
    /// Largest energy and largest unexplained change of it.
    energy: [f64; 3],
    explained: bool,
}

impl Recorder {
    fn new(simulation: &Simulation, record: Record, scale: f64) -> Recorder {
        let chain = simulation.chain.clone();
        let (samples, n, m) = (simulation.samples, chain.n_sites(), chain.n_contacts());
        let array = |wanted: bool, columns| wanted.then(|| Array2::zeros((samples, columns)));
        let lossy = chain.losses.any();
        let driven = simulation.drive.is_some();
        Recorder {
            lossy,
            energy: [0.0; 3],
            explained: record.energy || !(lossy || driven),
            run: Run {
                time: Array1::zeros(samples),
                velocity: Array2::zeros((samples, n)),
                displacement: array(record.displacement, n),
                force: array(record.force, m),
                energy_passed: array(record.energy, m),
                energy_lost: array(record.energy && lossy, n),
                energy_input: (record.energy && driven).then(|| Array1::zeros(samples)),
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

    fn keep(&mut self, sample: usize, time: f64, state: &State) {
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
        let (x, v) = (&state.x[1..=n], &state.v[1..=n]);
        times[sample] = time;
        let copy = |array: &mut Array2<f64>, values: &[f64]| {
            for (to, from) in array.row_mut(sample).iter_mut().zip(values) {
                *to = *from;
            }
        };
        copy(velocity, v);
        if let Some(array) = displacement {
            copy(array, x);
        }
        if let Some(array) = force {
            let mut row = array.row_mut(sample);
            for j in 0..m {
                row[j] = chain.force(j, x, v);
            }
        }
        if let Some(array) = energy_passed {
            copy(array, &state.passed[1..=m]);
        }
        if let Some(array) = energy_lost {
            copy(array, &state.lost[1..=n]);
        }
        if let Some(array) = energy_input {
            array[sample] = state.passed[0];
        }
        if !self.explained {
            return;
        }
        let wall = if chain.has_left_wall() {
            state.x[0]
        } else {
            0.0
        };
        let mut energy = chain.energy(x, v, wall);
        let [first, largest, drift] = &mut self.energy;
        *largest = largest.max(energy);
        if self.lossy {
            energy += state.lost.iter().sum::<f64>();
        }
        energy -= state.passed.first().copied().unwrap_or(0.0);
        if sample == 0 {
            *first = energy;
        }
        *drift = drift.max((energy - *first).abs());
    }

    fn finish(mut self, cost: Cost) -> Run {
        let [_, largest, drift] = self.energy;
        self.run.report.cost = cost;
        self.run.report.energy_drift = (self.explained && largest > 0.0).then(|| drift / largest);
        self.run
    }
}

fn largest_difference(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

/// Bytes of memory that the system would give now, all that can be addressed if it does not say.
pub(crate) fn available_memory() -> u64 {
    let unknown = u64::MAX;
    let Ok(text) = std::fs::read_to_string("/proc/meminfo") else {
        return unknown;
    };
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"));
    let kibibytes = line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.map_or(unknown, |k| k.saturating_mul(1024))
}
