//! Follows a chain step by step and locates events between steps.
//!
//! Over a step each overlap is close to the quintic through its value, rate and acceleration at
//! both ends, which is accurate enough to find where an event occurs. The step is then repeated
//! from its start to just before and just after that time. The quintic between these two is as
//! accurate as the integration itself.

use super::lattice::Chain;
use super::peak::largest;
use super::run::{CHECK_FACTOR, LEAST_LOCAL_ERROR};
use super::simulation::{Accuracy, Simulation};
use super::stepping::{
    self, FIRST_CONTACT, FIRST_SITE, Mark, Quintic, State, StepControl, Stepping,
};
use crate::Result;
use crate::numeric::root;
use crate::observer::Observer;

/// Half the length of the refined interval around an event, in steps.
const CLOSE: f64 = 1.0 / 32.0;

/// Share of the local error of a run: relative errors of single pulses are wanted, and of the energies
/// that they pass on, which can be small.
const SHARE: f64 = 0.5;

/// Distance from a maximum at which slopes are evaluated, as a share of an interpolant.
const ASIDE: f64 = 0.05;

/// Subintervals of an interpolant at whose ends it is sampled before an event is located.
pub(crate) const SAMPLES_PER_STEP: usize = 4;

/// The followed quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Signal {
    /// Force of a contact beyond the static one, damping included.
    Force(usize),
    /// Velocity of a site.
    Velocity(usize),
}

/// How fine the steps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Resolution {
    /// As required by the tolerance.
    Asked,
    /// Finer by [`CHECK_FACTOR`] in the error of a step, or by half in its length.
    Finer,
}

/// A running simulation and its last step.
pub(crate) struct ObservedRun<'a> {
    simulation: &'a Simulation,
    stepping: Box<dyn Stepping>,
    observer: &'a dyn Observer,
    start: Mark,
    end: Mark,
    /// Whether the integration is not at the end of the last step.
    astray: bool,
}

impl Simulation {
    /// # Errors
    /// As [`Simulation::check`].
    pub(crate) fn watch<'a>(
        &'a self,
        resolution: Resolution,
        observer: &'a dyn Observer,
    ) -> Result<ObservedRun<'a>> {
        self.check()?;
        let scale = self.speed();
        let (fraction, part) = match resolution {
            Resolution::Asked => (1.0, 1.0),
            Resolution::Finer => (CHECK_FACTOR, 0.5),
        };
        let control = match self.accuracy {
            Accuracy::Step(step) => StepControl::Fixed(part * step),
            Accuracy::LocalError(local) => StepControl::LocalError(fraction * local * scale),
            Accuracy::Tolerance(tolerance) => {
                let local = SHARE * fraction * self.local_error_for(tolerance);
                StepControl::LocalError(local.max(LEAST_LOCAL_ERROR) * scale)
            }
        };
        let stepping = stepping::prepare(self, control, scale, true)?;
        let mark = stepping.mark();
        Ok(ObservedRun {
            simulation: self,
            stepping,
            observer,
            start: mark.clone(),
            end: mark,
            astray: false,
        })
    }

    /// The speed that velocities are compared with.
    pub(crate) fn speed(&self) -> f64 {
        self.velocity_scale(f64::INFINITY)
    }
}

impl<'a> ObservedRun<'a> {
    /// Makes a step. Its length does not depend on events located in earlier steps.
    pub(crate) fn step(&mut self) -> Result<()> {
        if self.astray {
            self.stepping.reset(&self.end);
            self.astray = false;
        }
        let to = self.end.time + self.stepping.step();
        if self.simulation.chain.losses.any() {
            // Steps around the jump of a damper are too short to separate events.
            self.stepping.advance_to(to, self.observer)?;
        } else {
            self.stepping.step_towards(to, self.observer)?;
        }
        std::mem::swap(&mut self.start, &mut self.end);
        self.end = self.stepping.mark();
        Ok(())
    }

    /// Begins and ends of the last step.
    pub(crate) fn times(&self) -> [f64; 2] {
        [self.start.time, self.end.time]
    }

    /// The state at the end of the last step.
    pub(crate) fn now(&self) -> StateView<'_> {
        self.instant(&self.end.state)
    }

    /// Force of a contact at the end of the last step.
    pub(crate) fn force(&self, contact: usize) -> f64 {
        self.end.state.force[FIRST_CONTACT + contact]
    }

    /// Whether a contact is closed at either end of the last step.
    pub(crate) fn presses(&self, contact: usize) -> bool {
        let s = FIRST_CONTACT + contact;
        self.start.state.force[s] != 0.0 || self.end.state.force[s] != 0.0
    }

    /// A signal over the last step, interpolated.
    pub(crate) fn interpolant(&self, signal: Signal) -> Interpolant<'a> {
        self.between(signal, &self.start, &self.end)
    }

    /// The same around an instant inside the step, made again.
    pub(crate) fn near(&mut self, signal: Signal, t: f64) -> Result<Interpolant<'a>> {
        let [from, to] = self.times();
        let close = CLOSE * (to - from);
        self.go_to((t - close).max(from))?;
        let before = self.stepping.mark();
        self.stepping
            .advance_to((t + close).min(to), self.observer)?;
        let after = self.stepping.mark();
        Ok(self.between(signal, &before, &after))
    }

    /// The state at an instant inside the step, made again.
    pub(crate) fn at(&mut self, t: f64) -> Result<StateView<'_>> {
        self.go_to(t)?;
        Ok(self.instant(self.stepping.state()))
    }

    fn go_to(&mut self, t: f64) -> Result<()> {
        self.astray = true;
        self.stepping.reset(&self.start);
        self.stepping.advance_to(t, self.observer)
    }

    fn instant<'s>(&self, state: &'s State) -> StateView<'s> {
        let chain = &self.simulation.chain;
        let (n, m) = (chain.n_sites(), chain.n_contacts());
        StateView {
            x: &state.x[FIRST_SITE..][..n],
            v: &state.v[FIRST_SITE..][..n],
            resonators: state.resonators(chain),
            passed: &state.passed[FIRST_CONTACT..][..m],
            lost: &state.lost[FIRST_SITE..][..n],
            input: state.put_in(),
            wall: state.x[0],
        }
    }

    fn between(&self, signal: Signal, from: &Mark, to: &Mark) -> Interpolant<'a> {
        let h = to.time - from.time;
        let place = |s: usize, t: f64, state: &State| {
            let [x, v, a] = self.stepping.motion(s, t, state);
            [x, h * v, h * h * a]
        };
        let ends = [from, to].map(|Mark { time: t, state, .. }| match signal {
            Signal::Velocity(site) => place(FIRST_SITE + site, *t, state),
            Signal::Force(contact) => {
                let s = FIRST_CONTACT + contact;
                let (left, right) = (place(s - 1, *t, state), place(s, *t, state));
                std::array::from_fn(|i| left[i] - right[i])
            }
        });
        Interpolant {
            from: from.time,
            h,
            path: Quintic::hermite(ends[0], ends[1]),
            signal,
            chain: &self.simulation.chain,
        }
    }
}

/// What a chain is like at an instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StateView<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) v: &'a [f64],
    /// Those of resonators; empty without.
    pub(crate) resonators: [&'a [f64]; 2],
    /// Energy passed through each contact so far, and lost at each site.
    pub(crate) passed: &'a [f64],
    pub(crate) lost: &'a [f64],
    /// Energy put in by a drive.
    pub(crate) input: f64,
    /// Displacement of a wall before site 0.
    pub(crate) wall: f64,
}

/// A signal over a piece of time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interpolant<'a> {
    from: f64,
    h: f64,
    /// Of the overlap or the displacement.
    path: Quintic,
    signal: Signal,
    chain: &'a Chain,
}

impl Interpolant<'_> {
    /// The time of a share of the piece.
    pub(crate) fn time(&self, share: f64) -> f64 {
        self.from + share * self.h
    }

    /// The signal there.
    pub(crate) fn value(&self, share: f64) -> f64 {
        let rate = self.path.slope_at(share) / self.h;
        match self.signal {
            Signal::Force(contact) => {
                let contact = self.chain.contact(contact);
                self.chain.total_force(contact, self.path.at(share), rate)
            }
            Signal::Velocity(_) => rate,
        }
    }

    /// Values at the ends of [`SAMPLES_PER_STEP`] equal parts.
    pub(crate) fn samples(&self) -> [f64; SAMPLES_PER_STEP + 1] {
        std::array::from_fn(|look| self.value(look as f64 / SAMPLES_PER_STEP as f64))
    }

    /// Share and value of the largest value between two shares between which there is one hump.
    pub(crate) fn largest(&self, from: f64, to: f64) -> (f64, f64) {
        let (share, value) = largest(from, to, |share| self.value(share));
        // Values near a maximum determine its place to half the digits; the zero of the slope gives
        // all digits.
        let (before, after) = ((share - ASIDE).max(from), (share + ASIDE).min(to));
        if self.slope(before) > 0.0 && self.slope(after) < 0.0 {
            let share = root::between(before, after, |share| self.slope(share));
            return (share, self.value(share).max(value));
        }
        (share, value)
    }

    /// By differences of fourth order, which are exact to rounding over pieces of a step.
    fn slope(&self, share: f64) -> f64 {
        let h = 0.2 * ASIDE;
        let pair = |by: f64| self.value(share + by) - self.value(share - by);
        (8.0 * pair(h) - pair(2.0 * h)) / (12.0 * h)
    }

    /// The share at which the signal passes `level` between two shares on either side of it; the
    /// nearer one of them if they are on one side.
    pub(crate) fn passes(&self, level: f64, from: f64, to: f64) -> f64 {
        let off = |share: f64| self.value(share) - level;
        let (a, b) = (off(from), off(to));
        if (a > 0.0) == (b > 0.0) {
            return if a.abs() < b.abs() { from } else { to };
        }
        root::between(from, to, off)
    }
}
