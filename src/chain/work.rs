//! The work of a run, estimated before it begins.

use super::lattice::{Contact, Ends};
use super::simulation::{Accuracy, EndTime, Simulation};
use super::stepping;
use crate::error::{Error, Result};
use crate::numeric::root;

/// Steps within the time in which a contact stops a body, at the tolerance [`AT`]. Fewer are made at larger ones, by the
/// order of the pairs.
const STEPS_A_CONTACT: f64 = 20.0;
const AT: f64 = 1e-9;
const ORDER: i32 = 8;

/// The same of the stiffest contact, where others are softer and move its bodies slowly.
const STEPS_OF_THE_STIFFEST: f64 = 4.0;

/// Bodies that fly apart and collide again within a contact time: each begins and ends with a step.
const BODIES_A_COLLISION: f64 = 10.0;

/// Contact times a body, until those that fly apart meet no more.
const UNTIL_APART: f64 = 6.0;

/// Relaxation times in which drag stops all motion.
const UNTIL_STOPPED: f64 = 20.0;

/// Contacts that are damped spread an impact: at the time t it is as wide as `(t / tau)^{1/2}` bodies, and as slow. That is as
/// many steps as for this times `(t tau)^{1/2}` without.
const SPREAD: f64 = 4.0;

/// The rate of damping times the longest stable step of explicit schemes of high order.
const STABLE: f64 = 6.0;

/// Steps beyond which a run is refused whose damping, not whose motion, determines them.
const MOST_DAMPED: f64 = 1e7;

/// Steps beyond which any run is refused.
const MOST: f64 = 1e11;

/// Estimated work of a run.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Work {
    /// Steps of one integration, to a factor of ten; to the latest time at which a front is waited
    /// for, where the run ends with its arrival.
    pub steps: f64,
    /// What determines their length: `motion`, `step`, or the loss `dashpot`, `tangent`, `drag` or `resonator_damping`.
    pub limit: &'static str,
}

/// How fast a contact stops its bodies, and relaxes their opposite motion.
struct ContactRates {
    stops: f64,
    dashpot: f64,
    tangent: f64,
    /// By how much rounding of the overlap there changes its force.
    rounding: f64,
}

impl Simulation {
    /// The work of a run.
    pub fn work(&self) -> Work {
        let time = self.latest_end();
        self.work_of(time, &self.contact_rates(time))
    }

    fn latest_end(&self) -> f64 {
        match self.end_time {
            EndTime::At(time) => time,
            EndTime::Arrival => self.latest_arrival(self.velocity_scale(0.0)),
        }
    }

    fn work_of(&self, time: f64, contacts: &[ContactRates]) -> Work {
        if let Accuracy::Step(step) = self.accuracy {
            return Work {
                steps: time / step,
                limit: "step",
            };
        }
        let (limit, rate) = self.damping_rate(contacts);
        let moved = self.steps_of_motion(time, rate, contacts);
        let damped = rate / STABLE * time;
        Work {
            steps: moved + damped,
            limit: if damped > moved { limit } else { "motion" },
        }
    }

    /// Of each contact what decides the steps there.
    fn contact_rates(&self, time: f64) -> Vec<ContactRates> {
        let chain = &self.chain;
        let (speed, losses) = (self.velocity_scale(time), chain.losses);
        let of_contact = |(j, (stop, contact)): (usize, (f64, Contact))| {
            let mass = chain.reduced_mass(j);
            let mut compressed = speed * stop;
            if losses.tangent > 0.0 && speed > 0.0 {
                // Its damping alone takes the momentum `tangent F`.
                let taken = |r: f64| losses.tangent * contact.force(r).abs();
                let excess = |ln: f64| (taken(ln.exp()) / (mass * speed)).ln();
                compressed = compressed.min(root::between(-230.0, 230.0, excess).exp());
            }
            let stiffness = contact.stiffness(compressed).abs();
            let steepness = || compressed * stiffness / contact.force(compressed).abs();
            let rounding = f64::EPSILON * contact.law.exponent().unwrap_or_else(steepness);
            ContactRates {
                stops: 1.0 / stop,
                dashpot: 2.0 * losses.dashpot / mass,
                tangent: 2.0 * losses.tangent * stiffness / mass,
                rounding,
            }
        };
        let stops = self.stopping_times(speed).zip(chain.contacts());
        stops.enumerate().map(of_contact).collect()
    }

    /// The time in which each contact stops two bodies that meet at this speed.
    pub(super) fn stopping_times(&self, speed: f64) -> impl Iterator<Item = f64> {
        let chain = &self.chain;
        let stops = move |(j, contact): (usize, Contact)| {
            let (c, mass) = (contact.coefficient, chain.reduced_mass(j));
            let power = contact.law.exponent();
            match power.filter(|_| contact.static_overlap == 0.0 && c > 0.0 && speed > 0.0) {
                // `c (v t)^p t = m v`
                Some(p) => ((mass.ln() + (1.0 - p) * speed.ln() - c.ln()) / (p + 1.0)).exp(),
                None => stepping::stopping_time(contact, mass, speed),
            }
        };
        chain.contacts().enumerate().map(stops)
    }

    /// Steps that the motion needs, where contacts relax at `rate` or more slowly. Calibrated at 300 random scenes, of which
    /// it found all to a factor of eight with those of [`Work::steps`].
    fn steps_of_motion(&self, time: f64, rate: f64, contacts: &[ContactRates]) -> f64 {
        let chain = &self.chain;
        let tolerance = match self.accuracy {
            Accuracy::Tolerance(tolerance) => tolerance,
            Accuracy::LocalError(local) => 256.0 * local,
            Accuracy::Step(_) => AT,
        };
        let each = STEPS_A_CONTACT * (AT / tolerance).powf(1.0 / f64::from(ORDER));
        let rates = || contacts.iter().map(|contact| contact.stops);
        let n = contacts.len().max(1) as f64;
        let usual = (rates().map(f64::ln).sum::<f64>() / n).exp();
        let [least, most] = rates().fold([f64::INFINITY, 0.0f64], |[least, most], rate| {
            [least.min(rate), most.max(rate)]
        });
        let mut a_time =
            (each * usual).max(STEPS_OF_THE_STIFFEST * most.max(chain.fastest_resonator()));
        let mut lasts = time;
        if chain.losses.drag > 0.0 {
            let heaviest = chain.mass.iter().copied().fold(0.0, f64::max);
            lasts = lasts.min(UNTIL_STOPPED * heaviest / chain.losses.drag);
        } else if rate > 0.0 {
            lasts = lasts.min(SPREAD * (time / rate).sqrt());
        }
        if chain.law.all_open() && !chain.is_pressed() {
            a_time *= 1.0 + chain.n_sites() as f64 / BODIES_A_COLLISION;
            let is_open = matches!(chain.ends, Ends::Wall | Ends::Free) && self.drive.is_none();
            if is_open {
                lasts = lasts.min(UNTIL_APART * (chain.n_sites() + 2) as f64 / least);
            }
        }
        a_time * lasts
    }

    /// The loss that relaxes velocities fastest, and its rate: a dashpot between two bodies relaxes their opposite motion, and a
    /// contact of stiffness K that damps by its tangent as a dashpot of `tangent K`.
    fn damping_rate(&self, contacts: &[ContactRates]) -> (&'static str, f64) {
        let lightest = self
            .chain
            .mass
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let fastest =
            |rate: fn(&ContactRates) -> f64| contacts.iter().map(rate).fold(0.0, f64::max);
        let rates = [
            ("dashpot", fastest(|contact| contact.dashpot)),
            ("tangent", fastest(|contact| contact.tangent)),
            ("drag", self.chain.losses.drag / lightest),
            ("resonator_damping", self.chain.resonator_relaxation()),
        ];
        let faster = |a: (&'static str, f64), b: (&'static str, f64)| if b.1 > a.1 { b } else { a };
        rates.into_iter().fold(rates[0], faster)
    }

    /// Refuses a run that would not end in any time worth waiting for, and a tolerance below what rounding leaves of forces.
    pub(super) fn check_work(&self) -> Result<()> {
        let time = self.latest_end();
        let contacts = self.contact_rates(time);
        if let Accuracy::Tolerance(tolerance) | Accuracy::LocalError(tolerance) = self.accuracy {
            let least = contacts
                .iter()
                .fold(0.0, |most: f64, of| most.max(of.rounding));
            let expected = format!(
                "a law less steep, or a tolerance above {least:.1e}, by which rounding of an overlap changes the force there"
            );
            let found = format!("the tolerance {tolerance:e}");
            Error::require(least <= tolerance, "law", expected, found)?;
        }
        let Work { steps, limit } = self.work_of(time, &contacts);
        let is_damped = !matches!(limit, "motion" | "step");
        let most = if is_damped { MOST_DAMPED } else { MOST };
        let option = if limit == "motion" { "end-time" } else { limit };
        let expected = format!("a run of at most {most:e} steps, as `{limit}` determines them");
        let found = format!("about {steps:.1e} steps to the time {time}");
        Error::require(steps.is_nan() || steps <= most, option, expected, found)
    }
}
