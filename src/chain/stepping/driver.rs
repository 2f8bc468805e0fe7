//! From sample to sample: islands, steps, and the choice of their length.

use super::correction::{Correction, openings};
use super::events::{Crosses, StepEnds};
use super::islands::Islands;
use super::pair::press_placed;
use super::pair::{PairStep, Span, StepOutcome, StepScratch};
use super::system::{FIRST_CONTACT, FIRST_SITE, State, System};
use super::tableau::Tableau;
use super::{Cost, Mark, StepControl, Stepping, Task};
use crate::chain::drive::Drive;
use crate::chain::lattice::{Chain, Contact};
use crate::chain::law::Kernel;
use crate::chain::simulation::Simulation;
use crate::numeric::root;
use crate::observer::Observer;
use crate::{Error, Result};

/// Longest step of a driven chain, over the inverse angular frequency: no turn of a wall is stepped
/// over while nothing touches it.
const DRIVE_STEP: f64 = 0.5;

/// Repetitions of a step that should end where a contact is resolved, before it is halved: far
/// behind a collision that was stepped over, interpolants locate its beginning poorly.
const MOST_LANDINGS: usize = 4;

/// Steps for which a survey of the islands should hold.
const HORIZON_STEPS: f64 = 6.0;

/// The length of the next step, in units of the one that would just meet the tolerance.
const SAFETY: f64 = 0.8;

/// By what steps grow. Openings make the error of equally long steps vary by factors of ten to a
/// hundred: steps that grow no faster than this are seldom repeated.
const GROWTH: f64 = 1.04;

/// The same where the error is below this share of the tolerance: after a flight, and at the start.
const FAST_GROWTH: f64 = 4.0;
const HARDLY_ANY: f64 = 1e-3;

/// Rounding of the largest velocity, over the tolerance, from which on no step can meet that: the motion runs away.
const ROUNDING: f64 = 1e3;

/// How a step is made again.
#[derive(Debug, Clone, Copy)]
enum Shorter {
    /// As one step of this length, which ends where a contact that closes or opens is resolved.
    Land(f64),
    /// As steps of this length at most.
    Steps(f64),
}

#[derive(Debug)]
pub(super) struct Driver<K> {
    system: System<K>,
    tableau: Tableau,
    /// Of what contacts that open and close add to the error.
    corrections: Vec<Correction>,
    islands: Islands,
    control: StepControl,
    energy: bool,
    time: f64,
    step: f64,
    /// Until when the islands hold.
    surveyed: f64,
    /// By how much more than the horizon the next survey looks ahead.
    caution: f64,
    state: State,
    next: State,
    scratch: StepScratch,
    cost: Cost,
    estimated: f64,
    /// Until when the drive is smooth, 0 once it is over, and the longest step until then. Steps end there, and see
    /// their own side of it.
    drive_ends: f64,
    drive_step: f64,
    drive: Option<Drive>,
}

impl<K: Kernel> Driver<K> {
    pub(super) fn new(
        task: &Task,
        system: System<K>,
        tableau: Tableau,
        corrections: Vec<Correction>,
        state: State,
    ) -> Self {
        let Simulation { chain, drive, .. } = task.simulation;
        let stages = tableau.stages();
        let fading = chain.law.all_open() && !chain.is_pressed();
        // Forces of an open power law die out within a few sites ahead of the front.
        let ahead = if fading { 12 } else { 4 * stages - 3 };
        let period = drive.as_ref().map_or(f64::INFINITY, |drive| {
            1.0 / drive.waveform().angular_frequency()
        });
        let step = match task.control {
            StepControl::Fixed(step) => step,
            StepControl::LocalError(_) => {
                let contact = contact_time(chain, task.velocity_scale, Extreme::Fastest);
                1e-3 * contact.min(period).min(1.0 / chain.fastest_resonator())
            }
        };
        let lossy_or_pushed = system.has_pulls();
        let mut driver = Driver {
            drive: drive.clone(),
            drive_ends: 0.0,
            drive_step: DRIVE_STEP * period,
            islands: Islands::new(task.simulation.window, ahead),
            control: task.control,
            energy: task.energy,
            time: 0.0,
            step,
            surveyed: f64::NEG_INFINITY,
            caution: 1.0,
            next: state.clone(),
            scratch: StepScratch::new(system.places(), stages, lossy_or_pushed),
            state,
            cost: Cost::default(),
            estimated: 0.0,
            system,
            tableau,
            corrections,
        };
        driver.set_drive();
        driver
    }

    fn survey(&mut self, h: f64) {
        let horizon = HORIZON_STEPS * h;
        let moved = self.islands.at_rest.min(self.state.force.len());
        self.islands
            .survey(&self.system, &self.state, horizon, self.caution);
        self.surveyed = self.time + horizon;
        let moved = moved.max(self.islands.at_rest.min(self.state.force.len()));
        for shut in self.islands.shut(moved) {
            self.state.force[shut.clone()].fill(0.0);
            self.next.force[shut].fill(0.0);
        }
    }

    /// Sets what drives the chain from now on.
    fn set_drive(&mut self) {
        let Some(drive) = &self.drive else { return };
        let (waveform, until) = drive.waveform().onward(self.time);
        self.drive_ends = until.unwrap_or(0.0);
        self.system.drive = Some(drive.with(waveform));
    }

    /// The velocity of what is moved may jump where the drive begins or ends.
    fn end_drive(&mut self) {
        if self.drive.is_none() || self.time != self.drive_ends {
            return;
        }
        self.set_drive();
        let State { x, v, force, .. } = &mut self.state;
        self.system.place(self.time, x, v);
        press_placed(&self.system, self.time, [x, v], force);
    }

    fn attempt(&mut self, h: f64) -> StepOutcome {
        let step = PairStep {
            system: &self.system,
            tableau: &self.tableau,
            corrections: &self.corrections,
            tolerance: self.tolerance(),
            span: Span { t: self.time, h },
        };
        let mut all = StepOutcome::default();
        for island in &self.islands.active {
            let states = (&self.state, &mut self.next);
            step.advance(island, states, &mut self.scratch, &mut all);
        }
        all
    }

    /// Free flight of the sites in no island.
    fn fly(&mut self, h: f64) {
        for gap in &self.islands.gaps {
            let (x, v) = (&self.state.x[gap.clone()], &self.state.v[gap.clone()]);
            let x1 = &mut self.next.x[gap.clone()];
            for ((x1, x), v) in x1.iter_mut().zip(x).zip(v) {
                *x1 = x + h * v;
            }
            self.next.v[gap.clone()].copy_from_slice(v);
        }
    }

    /// The energy passed on by contacts outside all islands is unchanged.
    fn carry_energies(&mut self) {
        let moved = self.islands.at_rest.min(self.state.passed.len());
        for shut in self.islands.shut(moved) {
            self.next.passed[shut.clone()].copy_from_slice(&self.state.passed[shut]);
        }
        for gap in &self.islands.gaps {
            self.next.lost[gap.clone()].copy_from_slice(&self.state.lost[gap.clone()]);
        }
    }

    /// The factor by which the next step may be longer, and whether this one was good enough.
    fn judge(&self, error: f64) -> (f64, bool) {
        let StepControl::LocalError(tolerance) = self.control else {
            return (1.0, true);
        };
        let exponent = -1.0 / f64::from(self.tableau.embedded_order + 1);
        let factor = SAFETY * (error / tolerance).powf(exponent);
        let most = match error > HARDLY_ANY * tolerance {
            true => GROWTH,
            false => FAST_GROWTH,
        };
        (factor.clamp(0.2, most), error <= tolerance)
    }

    /// How a step must be made again, if it was not good enough.
    fn shorter(&self, h: f64, outcome: &StepOutcome) -> Result<Option<Shorter>> {
        if let StepControl::Fixed(step) = self.control {
            if outcome.error.is_finite() {
                return Ok(None);
            }
            let expected = "a step below the stability limit";
            let found = format!("{step:e}, which overflowed at time {:e}", self.time);
            return Err(Error::request("step", expected, found));
        }
        // Contact events inside the step limit its length before the error estimate is meaningful.
        if outcome.longest < h {
            return Ok(Some(Shorter::Land(outcome.longest)));
        }
        if !outcome.error.is_finite() {
            return Ok(Some(Shorter::Steps(0.1 * h)));
        }
        let (factor, accepted) = self.judge(outcome.error);
        Ok((!accepted).then_some(Shorter::Steps(h * factor.min(0.9))))
    }

    /// Of the error of a velocity in a step; 0 for fixed steps.
    fn tolerance(&self) -> f64 {
        match self.control {
            StepControl::LocalError(tolerance) => tolerance,
            StepControl::Fixed(_) => 0.0,
        }
    }

    /// Whether velocities have grown so large that their rounding alone exceeds the tolerance by far.
    fn runs_away(&self) -> bool {
        let speeds = self.state.v.iter();
        let fastest = speeds.fold(0.0, |most: f64, v| most.max(v.abs()));
        let tolerance = self.tolerance();
        tolerance > 0.0 && f64::EPSILON * fastest > ROUNDING * tolerance
    }

    /// The error of a motion that no step follows any more, with the contact that is farthest from rest.
    fn lost(&self) -> Error {
        let overlap = |s: usize| self.system.overlap(s, &self.state.x);
        let by = |a: &usize, b: &usize| overlap(*a).abs().total_cmp(&overlap(*b).abs());
        let farthest = self.system.contacts.clone().max_by(by).unwrap_or(0);
        let found = format!(
            "the contact before body {} at the overlap {:e} at time {:e}",
            farthest.saturating_sub(FIRST_SITE),
            overlap(farthest.max(1)),
            self.time
        );
        Error::request(
            "tolerance",
            "motion that steps of finite length can follow",
            found,
        )
    }

    /// Accepts a step, and chooses the length of the next one.
    fn accept(&mut self, h: f64, end: f64, outcome: &StepOutcome) {
        self.caution = 1.0;
        if self.energy {
            self.carry_energies();
        }
        std::mem::swap(&mut self.state, &mut self.next);
        self.time = end;
        self.cost.steps += 1;
        self.cost.corrected_contacts += outcome.corrected;
        self.estimated += outcome.error;
        if let StepControl::Fixed(_) = self.control {
            return;
        }
        let (factor, _) = self.judge(outcome.error);
        // A step shortened to end on a sample hardly limits the next one.
        let longest = h * factor;
        let held_back = h < self.step && factor >= GROWTH;
        let least = if held_back { self.step } else { 0.0 };
        self.step = longest.max(least).min(outcome.onward);
    }
}

impl<K: Kernel> Stepping for Driver<K> {
    fn step_towards(&mut self, target: f64, observer: &dyn Observer) -> Result<f64> {
        let (mut landing, mut landings) = (None, 0);
        self.end_drive();
        loop {
            if self.cost.steps.is_multiple_of(256) && observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let (allowed, target) = match self.time < self.drive_ends {
                true => (self.step.min(self.drive_step), target.min(self.drive_ends)),
                false => (self.step, target),
            };
            let next = landing.map(|h| (h, self.time + h));
            let Some((h, end)) = next.or_else(|| next_step(self.time, target, allowed)) else {
                return Ok(self.time);
            };
            if end <= self.time || h.is_nan() {
                return Err(self.lost());
            }
            if self.time + h > self.surveyed {
                self.survey(h);
            }
            let outcome = self.attempt(h);
            self.fly(h);
            self.cost.forces += self.islands.contacts() * (self.tableau.stages() - 1) as u64;
            if outcome.leaked {
                self.survey(h);
                self.caution *= 2.0;
                continue;
            }
            match self.shorter(h, &outcome)? {
                Some(Shorter::Land(h)) if landings < MOST_LANDINGS => {
                    (landing, landings) = (Some(h), landings + 1);
                }
                Some(Shorter::Land(_)) => {
                    (self.step, landing, landings) = (0.5 * h, None, 0);
                }
                Some(Shorter::Steps(h)) => (self.step, landing) = (h, None),
                None => {
                    self.accept(h, end, &outcome);
                    return Ok(self.time);
                }
            }
            self.cost.rejected_steps += 1;
            if self.runs_away() {
                return Err(self.lost());
            }
        }
    }

    fn advance_to(&mut self, target: f64, observer: &dyn Observer) -> Result<()> {
        while self.time < target {
            self.step_towards(target, observer)?;
        }
        Ok(())
    }

    fn state(&self) -> &State {
        &self.state
    }

    fn motion(&self, s: usize, t: f64, state: &State) -> [f64; 3] {
        self.system.motion(self.drive.as_ref(), s, t, state)
    }

    fn openings(
        &self,
        [(t, start), (to, end)]: [(f64, &State); 2],
        matters: &dyn Fn(usize, f64) -> bool,
    ) -> Vec<(f64, usize)> {
        let h = to - t;
        let ends = StepEnds {
            system: &self.system,
            drive: self.drive.as_ref(),
            span: Span { t, h },
            states: [start, end],
        };
        let first = match self.system.periodic {
            true => FIRST_CONTACT,
            false => self.system.contacts.start,
        };
        let mut found = Vec::new();
        for s in first..self.system.contacts.end {
            let crosses = |at: Crosses| (at.passes || at.grazes) && matters(s, at.most.max(at.way));
            if self.system.opens[s] > 0.0
                && let Some(overlap) = ends.crossing(s, crosses)
            {
                found.extend(openings(&overlap).map(|share| (t + h * share, s)));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    fn step(&self) -> f64 {
        self.step
    }

    fn set_step(&mut self, step: f64) {
        self.step = step;
    }

    fn mark(&self) -> Mark {
        Mark {
            time: self.time,
            step: self.step,
            state: self.state.clone(),
        }
    }

    fn reset(&mut self, mark: &Mark) {
        (self.time, self.step) = (mark.time, mark.step);
        self.set_drive();
        self.state.clone_from(&mark.state);
        self.next.clone_from(&mark.state);
        self.surveyed = f64::NEG_INFINITY;
        self.islands.forget();
    }

    fn cost(&self) -> Cost {
        self.cost
    }

    fn estimated(&self) -> f64 {
        self.estimated
    }
}

/// Length and end of the next of the equally long steps, none longer than `longest`, that end at `target`.
fn next_step(time: f64, target: f64, longest: f64) -> Option<(f64, f64)> {
    let left = target - time;
    let steps = (left / longest * (1.0 - 1e-12)).ceil().max(1.0);
    let h = left / steps;
    let end = if steps == 1.0 { target } else { time + h };
    (time < target).then_some((h, end))
}

/// Which of a chain's contacts and sites.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extreme {
    /// The stiffest contact on the lightest site.
    Fastest,
    /// The softest contact on the heaviest site.
    Slowest,
}

/// The time in which a contact stops a site of this speed.
pub(crate) fn contact_time(chain: &Chain, speed: f64, which: Extreme) -> f64 {
    let contacts = 0..chain.n_contacts();
    let by = |i: &usize, j: &usize| chain.coefficient[*i].total_cmp(&chain.coefficient[*j]);
    let masses = chain.mass.iter().copied();
    let (mass, contact) = match which {
        Extreme::Fastest => (masses.fold(f64::INFINITY, f64::min), contacts.max_by(by)),
        Extreme::Slowest => (masses.fold(0.0, f64::max), contacts.min_by(by)),
    };
    contact.map_or(1.0, |j| stopping_time(chain.contact(j), mass, speed))
}

/// The time in which a contact stops a body of this mass and speed.
pub(crate) fn stopping_time(contact: Contact, mass: f64, speed: f64) -> f64 {
    if speed <= 0.0 {
        return 1.0;
    }
    let excess = |ln_time: f64| {
        let time = ln_time.exp();
        (contact.force(speed * time).abs() * time / (mass * speed)).ln()
    };
    root::between(-230.0, 230.0, excess).exp()
}
