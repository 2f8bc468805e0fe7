//! Running a simulation to the requested accuracy.

use ndarray::ArrayView1;

use super::growth::{Checks, grown_rounding};
use super::recorder::{Recorder, SampleTimes};
use super::result::{Run, RunWarning};
use super::simulation::{Accuracy, EndTime, Record, Simulation};
use super::stepping::{self, Cost, FIRST_SITE, State, StepControl, Stepping};
use crate::observer::{CancelOnly, Observer};
use crate::{Error, Result};

/// The local error of a run over that of the coarser run that it is checked with. Where openings
/// limit the steps, runs with local errors closer to each other have nearly the same steps and share
/// their error.
pub const CHECK_FACTOR: f64 = 1.0 / 32.0;

/// The number of steps of two runs, over one another, below which what they differ by says little of their errors. With local
/// errors that differ by 32 it is 1.5 to 1.7 where these determine the steps.
const APART: f64 = 1.1;

/// The local error of the first coarser run, over that at which most runs keep the tolerance.
const FIRST_CHECK: f64 = 2.0;

/// Below this the estimate of a step's error is rounding.
pub(super) const LEAST_LOCAL_ERROR: f64 = 1e-14;

/// The local error of the coarser run that the finest one is checked with, over the least one: such
/// short steps follow their local error wherever contacts open.
const LEAST_CHECK: f64 = 10.0;

/// Where smaller steps bring two runs no closer, from here on it is the chain that amplifies
/// rounding.
const ROUNDING: f64 = 1e-12;

/// A pair of runs that misses the tolerance by less is no sign of growth.
const EXCESS: f64 = 30.0;

/// The power of the error as which the local error is to fall: amplified errors of struck dimers of 300
/// sites fell as the local one to the power of 0.3 to 0.8.
const FALL: f64 = 1.25;

/// Below this, rounding is no matter of growth: it is what chains that amplify 1e4 times make of 1e-13.
const LEAST_GROWN: f64 = 1e-9;

/// The least early difference of two runs, over the coarser local error.
const LEAST_EARLY: f64 = 0.01;

/// Samples at which a run is checked. The steps of the checking run end on no other samples, so
/// that the two runs differ even if every step of the checked run ends on a sample.
pub(super) const CHECKED_SAMPLES: usize = 128;

/// Parts of a contact time to one of which an arrival is located.
const ARRIVAL_PARTS: u32 = 1000;

/// Runs by which the speeds of a driven chain are found, and their local error.
const MOST_PILOTS: usize = 4;
const PILOT_ERROR: f64 = 1e-6;

/// The stated error is this multiple of the difference of two runs: near rounding, two runs agree
/// up to twice better than either is accurate. Over struck dimers of 100 sites (kappa 1 to 10^6, local
/// errors 1e-13 to 1e-4) the true error was 0.06 times the difference in the median, and 1.94 times at
/// most.
const SURE: f64 = 2.0;

/// Standard deviations of a sum of rounded numbers that are stated. Over 900 random Hertz chains of 2 to 30 bodies,
/// with errors down to 1e-15, those of 12 were above twice the difference of two runs, now those of 6 are above what is stated, by 1.5
/// times at most: chains that amplify differences.
const DEVIATIONS: f64 = 3.0;

/// Relative changes of the energy that rounding explains.
const ROUNDING_OF_ENERGY: f64 = 1e-12;

/// Relative change of the energy above which unchecked fixed steps are reported as too long.
const FIXED_STEP_DRIFT: f64 = 1e-2;

/// Relative change of the energy with which a result means nothing.
const LARGEST_DRIFT: f64 = 0.1;

impl Simulation {
    /// Runs the simulation.
    ///
    /// A tolerance is checked by a second run of larger steps; while twice the difference of the two
    /// is more than the tolerance, the steps are made smaller, unless the difference grows so fast
    /// that rounding would, too. A change of the energy that neither
    /// work nor losses explain, beyond what errors within the tolerance can make, is warned of, and
    /// is an error where it is more than a tenth of the energy.
    ///
    /// # Errors
    /// As [`Simulation::check`]; [`Error::Request`] for a step that is unstable and for energy that
    /// does not balance; [`Error::Cancelled`] when the observer asks to stop.
    pub fn run(&self, observer: &dyn Observer) -> Result<Run> {
        self.finished(self.run_to_accuracy(None, observer)?)
    }

    /// As [`Simulation::run`], but where `is_enough` says that a run tells what is wanted of it, its velocities may miss
    /// the tolerance elsewhere.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(crate) fn run_until(
        &self,
        is_enough: &dyn Fn(&Checked) -> bool,
        observer: &dyn Observer,
    ) -> Result<Run> {
        self.finished(self.run_to_accuracy(Some(is_enough), observer)?)
    }

    fn finished(&self, mut run: Run) -> Result<Run> {
        self.state_rounding(&mut run);
        self.check_energy(&mut run)?;
        Ok(run)
    }

    /// States no smaller error than rounding leaves of flights, and warns if that is above the tolerance.
    fn state_rounding(&self, run: &mut Run) {
        let rounding = self.rounding_of_flights(run);
        let report = &mut run.report;
        let Some(error) = report.error.filter(|error| *error < rounding) else {
            return;
        };
        report.error = Some(rounding);
        if let Accuracy::Tolerance(tolerance) = self.accuracy
            && (error..rounding).contains(&tolerance)
        {
            report.warnings.push(RunWarning::Rounding {
                tolerance,
                reached: rounding,
            });
        }
    }

    /// The time and the positions of two bodies are sums over n steps, each rounded by up to half a unit: `eps t (3 n / 12)^{1/2}`
    /// after the time t. By so much bodies meet early or late that have flown for so long, a part of the contact time, and as
    /// large a part of the velocity that they pass on is not known. Two runs may share it by chance.
    fn rounding_of_flights(&self, run: &Run) -> f64 {
        let flies = self.chain.law.all_open() && !self.chain.is_pressed();
        let scale = run.report.velocity_scale;
        let (Some(end), true) = (run.time.last(), flies && scale > 0.0) else {
            return 0.0;
        };
        let contacts = self.stopping_times(scale);
        let contact = contacts.sum::<f64>() / self.chain.n_contacts().max(1) as f64;
        let rounded = f64::EPSILON * end * (run.report.cost.steps as f64 / 4.0).sqrt();
        match contact > 0.0 {
            true => DEVIATIONS * rounded / contact,
            false => 0.0,
        }
    }

    /// Compares the unexplained change of the energy with the change that errors of the velocities
    /// allow: to first order in an error `eps` of each velocity, and the same for the contacts,
    ///
    /// ```text
    /// |dE| <= 2 eps sum_j m_j |v_j|
    /// ```
    pub(super) fn check_energy(&self, run: &mut Run) -> Result<()> {
        let (scale, error) = (run.report.velocity_scale, run.report.error);
        let Some(drift) = run.report.energy_drift else {
            return Ok(());
        };
        let stated = error.unwrap_or(0.0);
        let relative = match self.accuracy {
            Accuracy::Step(_) => None,
            Accuracy::Tolerance(tolerance) => Some(tolerance.max(stated)),
            // Errors of steps accumulate; only a second run shows by how much.
            Accuracy::LocalError(_) => error,
        };
        let (mut momentum, mut kinetic) = (0.0f64, 0.0f64);
        for row in run.velocity.rows() {
            let sites = || row.iter().zip(&self.chain.mass);
            momentum = momentum.max(sites().map(|(v, m)| m * v.abs()).sum());
            kinetic = kinetic.max(sites().map(|(v, m)| 0.5 * m * v * v).sum());
        }
        if let (Some(all), Some(w)) = (self.chain.resonators(), &run.resonator_velocity) {
            let of =
                |row: ArrayView1<f64>| row.iter().zip(&all.mass).map(|(w, m)| m * w.abs()).sum();
            momentum += w.rows().into_iter().map(of).fold(0.0, f64::max);
        }
        let allowed = relative.map_or(FIXED_STEP_DRIFT, |relative| {
            let explained = 2.0 * relative * scale * momentum / kinetic;
            explained.max(ROUNDING_OF_ENERGY)
        });
        if kinetic == 0.0 || drift <= allowed {
            return Ok(());
        }
        if relative.is_some() && (drift.is_nan() || drift > LARGEST_DRIFT) {
            let expected = "steps that keep the energy";
            let found =
                format!("a change by {drift:.1e} of it that neither work nor losses explain");
            return Err(Error::request("tolerance", expected, found));
        }
        let warning = RunWarning::EnergyBalance { drift, allowed };
        run.report.warnings.push(warning);
        Ok(())
    }

    fn run_to_accuracy(
        &self,
        is_enough: Option<&dyn Fn(&Checked) -> bool>,
        observer: &dyn Observer,
    ) -> Result<Run> {
        self.check()?;
        let end = match self.end_time {
            EndTime::At(end) => end,
            EndTime::Arrival => {
                self.arrival_time(self.velocity_scale(f64::INFINITY), observer)?
                    .0
            }
        };
        let scale = self.velocity_scale(end);
        let (local, tolerance) = match self.accuracy {
            Accuracy::Step(step) => {
                let samples = SampleTimes::all(end, self.samples);
                let (fixed, wanted) = (StepControl::Fixed(step), (samples, &mut Checks::default()));
                return self.once(fixed, scale, wanted, self.record, observer);
            }
            Accuracy::LocalError(local) => (local, None),
            Accuracy::Tolerance(tolerance) => (self.local_error_for(tolerance), Some(tolerance)),
        };
        let all = SampleTimes::all(end, self.samples);
        let few = match is_enough {
            // A pulse shows in a few samples.
            Some(_) => all.at_most(CHECKED_SAMPLES.max(self.samples / 2)),
            None => all.at_most(CHECKED_SAMPLES),
        };
        let scale = match self.drive {
            Some(_) => self.driven_scale(scale, few, observer)?,
            None => scale,
        };
        let with = |local: f64, record, samples, checks: &mut Checks, observer: &dyn Observer| {
            let control = StepControl::LocalError(local * scale);
            self.once(control, scale, (samples, checks), record, observer)
        };
        if !self.estimate_error {
            return with(local, self.record, all, &mut Checks::default(), observer);
        }
        let check = |local: f64| -> Result<Other> {
            let mut checks = Checks::of(few, self.chain.n_sites());
            let observer = &CancelOnly(observer);
            let run = with(local, Record::default(), few, &mut checks, observer)?;
            Ok((few, run, checks))
        };
        let mut coarse = FIRST_CHECK * local;
        let mut best = (f64::INFINITY, local);
        let mut finest: Option<(f64, Run, Checks)> = None;
        loop {
            let mut local = (coarse * CHECK_FACTOR).max(LEAST_LOCAL_ERROR);
            let mut checks = Checks::of(all, self.chain.n_sites());
            // The finer run of the last pair may be the coarser one of this.
            let known = finest.take().filter(|(at, ..)| *at == coarse);
            let (run, other) = rayon::join(
                || with(local, self.record, all, &mut checks, observer),
                || match known {
                    Some((_, run, checks)) => Ok((all, run, checks)),
                    None => check(coarse),
                },
            );
            let mut run = run?;
            let other = other?;
            let (difference, differences) = difference((&run, &checks), &other);
            let shared = match share_steps(&run, &other.1) {
                true => checks.estimated,
                false => 0.0,
            };
            let error = SURE * (difference + shared) / scale;
            run.report.error = Some(error);
            let checked = Checked {
                run: &run,
                coarser: &other.1,
                samples: other.0,
                shared: shared + self.rounding_of_flights(&run) * scale,
            };
            let is_enough = is_enough.is_some_and(|is_enough| is_enough(&checked));
            let Some(tolerance) = tolerance.filter(|limit| error > *limit && !is_enough) else {
                return Ok(run);
            };
            let least = LEAST_EARLY * coarse * scale;
            let [rounding, rate] = grown_rounding(&differences, least, scale);
            if error > EXCESS * tolerance && rounding > tolerance.max(LEAST_GROWN) {
                let part = end / (differences.len() - 1) as f64;
                let stands = differences
                    .iter()
                    .take_while(|off| SURE * **off <= tolerance * scale);
                let until = part * stands.count().saturating_sub(1) as f64;
                run.report.warnings.push(RunWarning::Amplifies {
                    tolerance,
                    reached: error,
                    rounding,
                    growth: Some([rate / part, until]),
                });
                return Ok(run);
            }
            let stuck = error > 0.5 * best.0 && coarse < ROUNDING;
            if !stuck && local > LEAST_LOCAL_ERROR {
                if error < best.0 {
                    best = (error, local);
                }
                // The error falls about as the local one does, or more slowly where it is amplified.
                let shorter = (0.5 * tolerance / error).powf(FALL).min(CHECK_FACTOR);
                coarse = (coarse * shorter).max(LEAST_CHECK * LEAST_LOCAL_ERROR);
                // Where samples are many, they dictate the steps of the finer run.
                finest = (few.number() == all.number()).then_some((local, run, checks));
                continue;
            }
            let mut reached = error;
            if best.0 < error {
                // Shorter steps only gather more rounding.
                (reached, local) = best;
                drop(run);
                // The steps whose error is stated end where those did.
                let mut checks = Checks::of(all, self.chain.n_sites());
                run = with(local, self.record, all, &mut checks, observer)?;
                run.report.error = Some(reached);
            }
            let warning = RunWarning::Rounding { tolerance, reached };
            run.report.warnings.push(warning);
            return Ok(run);
        }
    }

    /// The largest speed that a drive brings about, which the scale it was guessed by may be far
    /// above: it is the scale once it is not much below it.
    fn driven_scale(
        &self,
        guess: f64,
        samples: SampleTimes,
        observer: &dyn Observer,
    ) -> Result<f64> {
        let mut scale = guess;
        for _ in 0..MOST_PILOTS {
            let control = StepControl::LocalError(PILOT_ERROR * scale);
            let wanted = (samples, &mut Checks::default());
            let pilot = self.once(control, scale, wanted, Record::default(), observer)?;
            let speeds = pilot.velocity.iter();
            let seen = speeds.fold(0.0, |most: f64, v| most.max(v.abs()));
            if seen == 0.0 {
                break;
            }
            let settled = seen > 0.1 * scale;
            scale = seen;
            if settled {
                break;
            }
        }
        Ok(scale)
    }

    /// The local error at which a run keeps the tolerance, from impacts on dimers of 100 sites
    /// (kappa 1 to 10^6): their errors were 0.1 to 6 times the local one. Energies passed, whose
    /// quadrature converges more slowly, are followed with steps shorter than velocities need.
    pub(super) fn local_error_for(&self, tolerance: f64) -> f64 {
        let share = if self.record.energy {
            1.0 / 256.0
        } else {
            1.0 / 8.0
        };
        (tolerance * share).max(LEAST_CHECK * LEAST_LOCAL_ERROR)
    }

    /// When the last site first moves at a thousandth of the velocity scale, as [`EndTime::Arrival`] finds it,
    /// and what finding it cost.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub(crate) fn arrival(&self, observer: &dyn Observer) -> Result<(f64, Cost)> {
        self.check()?;
        self.arrival_time(self.velocity_scale(f64::INFINITY), observer)
    }

    fn arrival_time(&self, scale: f64, observer: &dyn Observer) -> Result<(f64, Cost)> {
        let n = self.chain.n_sites();
        let still = |state: &State| state.v[FIRST_SITE + n - 1].abs() < 1e-3 * scale;
        let control = match self.accuracy {
            Accuracy::Step(step) => StepControl::Fixed(step),
            _ => StepControl::LocalError(1e-7 * scale),
        };
        let mut stepping = stepping::prepare(self, control, scale, false)?;
        let unit = self.contact_time(scale);
        let mut time = 0.0;
        let latest = self.latest_arrival(scale);
        let mut before = stepping.mark();
        while still(stepping.state()) {
            observer.go_on()?;
            let expected = "a front that reaches the last site for `auto`";
            let found = format!("none until {time:e}");
            Error::require(time <= latest, "end-time", expected, found)?;
            before = stepping.mark();
            time += unit;
            stepping.advance_to(time, observer)?;
        }
        let expected = "a last site at rest for `auto`";
        Error::require(time > 0.0, "end-time", expected, "a moving one")?;
        // Located to a thousandth of a contact time by halving the last stretch, on which the site starts
        // from rest.
        let start = before.time;
        let at = |part: u32| start + unit * (f64::from(part) / f64::from(ARRIVAL_PARTS));
        let (mut resting, mut moving) = (0, ARRIVAL_PARTS);
        while moving - resting > 1 {
            let part = (resting + moving) / 2;
            stepping.reset(&before);
            stepping.advance_to(at(part), observer)?;
            if still(stepping.state()) {
                resting = part;
                before = stepping.mark();
            } else {
                moving = part;
            }
        }
        Ok((at(moving), stepping.cost()))
    }

    /// Until when the arrival of a front is waited for: twice the time that one needs which passes a
    /// site in ten contact times.
    pub(super) fn latest_arrival(&self, scale: f64) -> f64 {
        20.0 * (self.chain.n_sites() + 10) as f64 * self.contact_time(scale)
    }

    /// The time in which the softest contact stops the heaviest site.
    pub(crate) fn contact_time(&self, scale: f64) -> f64 {
        stepping::contact_time(&self.chain, scale, stepping::Extreme::Slowest)
    }

    /// The stepping to the last of these times, with this error of a velocity a step over the velocity scale, and that.
    pub(super) fn stepping(
        &self,
        times: &[f64],
        local_error: f64,
        energy: bool,
    ) -> Result<(Box<dyn Stepping>, f64)> {
        let scale = self.velocity_scale(times.last().copied().unwrap_or(0.0));
        let control = StepControl::LocalError(local_error * scale);
        Ok((stepping::prepare(self, control, scale, energy)?, scale))
    }

    fn once(
        &self,
        control: StepControl,
        scale: f64,
        (samples, checks): (SampleTimes, &mut Checks),
        record: Record,
        observer: &dyn Observer,
    ) -> Result<Run> {
        observer.stage("stepping", samples.number() as u64);
        let mut stepping = stepping::prepare(self, control, scale, record.energy)?;
        let mut recorder = Recorder::new(self, record, scale, samples);
        let end = samples.time(samples.number() - 1);
        for sample in 0..samples.number() {
            let time = samples.time(sample);
            while let Some(at) = checks.next_time(end).filter(|at| *at <= time) {
                stepping.advance_to(at, observer)?;
                checks.keep(stepping.state());
            }
            stepping.advance_to(time, observer)?;
            recorder.keep(sample, stepping.state());
            observer.advance(1);
            if sample % 64 == 0 && observer.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        checks.estimated = stepping.estimated();
        recorder.finish(control, stepping.cost())
    }
}

/// A run beside one of coarser steps.
pub(crate) struct Checked<'r> {
    pub(crate) run: &'r Run,
    coarser: &'r Run,
    samples: SampleTimes,
    /// An error that both have.
    shared: f64,
}

impl Checked<'_> {
    /// By how much errors of the velocities on its two sides change the largest force of a contact, which it has at
    /// this time: as [`Run::force_error`], of what the two runs differ by until then.
    pub(crate) fn force_error(&self, contact: usize, time: f64) -> Option<f64> {
        let sides = [Some(contact), self.run.chain.contact(contact).sites[1]];
        let later = self.coarser.time.iter().position(|at| *at >= time);
        let samples = 0..=later.unwrap_or(self.coarser.time.len() - 1);
        let difference = samples.fold(0.0, |most: f64, sample| {
            let off = |site: usize| {
                let own = self.run.velocity[[self.samples.index(sample), site]];
                (own - self.coarser.velocity[[sample, site]]).abs()
            };
            sides
                .iter()
                .flatten()
                .fold(most, |most, site| most.max(off(*site)))
        });
        self.run
            .force_error(contact, SURE * (difference + self.shared))
    }
}

/// A run of other steps, the samples at which it is compared, and what was kept of it for that.
type Other = (SampleTimes, Run, Checks);

/// The largest difference of a velocity between a run and another, and the largest at each of equally distant times.
fn difference((run, checks): (&Run, &Checks), (samples, other, others): &Other) -> (f64, Vec<f64>) {
    let rows = samples.of_runs(other, run);
    let largest = rows.iter().fold(0.0, |a: f64, b| a.max(*b));
    (largest, others.differences(checks).unwrap_or(rows))
}

/// Whether two runs share their steps, and with them their errors: those of a short run from rest, of a drive, or beside many
/// samples do not follow the local error.
fn share_steps(a: &Run, b: &Run) -> bool {
    let [a, b] = [a, b].map(|run| run.report.cost.steps as f64);
    a.max(b) < APART * a.min(b)
}

#[cfg(test)]
mod tests {
    use super::super::lattice::Chain;
    use super::*;
    use crate::observer::Silent;

    /// The last site passes the level within the last part of a contact time, and the search costs less
    /// than two runs to there.
    #[test]
    fn val_definition_arrivals() {
        let mut s = Simulation::impact(Chain::dimer(30, 1.0), 1.0, 1.0, 2);
        s.estimate_error = false;
        let (time, cost) = s.arrival(&Silent).unwrap();
        let part = s.contact_time(1.0) / f64::from(ARRIVAL_PARTS);
        s.accuracy = Accuracy::LocalError(1e-9);
        s.record = Record::default();
        let [before, after] = [time - part, time].map(|end| {
            s.end_time = EndTime::At(end);
            let run = s.run(&Silent).unwrap();
            run.velocity[[1, s.chain.n_sites() - 1]]
        });
        assert!(before < 1e-3 && after >= 1e-3, "{before} {after}");
        s.accuracy = Accuracy::LocalError(1e-7);
        let once = s.run(&Silent).unwrap().report.cost.forces;
        let share = cost.forces as f64 / once as f64;
        assert!((1.8..2.0).contains(&share), "{share}");
    }
}
