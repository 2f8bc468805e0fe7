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

/// How many times as many steps as the others the stiffest contact may call for: beyond, their number depends on how long it is
/// pressed, which is not known.
const UNCERTAIN: f64 = 5.0;

/// A run of a tolerance below this ends all the same: its warning says what rounding leaves.
const WARNED: f64 = 1e-12;

/// The longest wait for a front, over the time in which one usually arrives.
const PATIENCE: f64 = 20.0;

/// Steps beyond which a run is refused whose damping, not whose motion, determines them.
const MOST_DAMPED: f64 = 1e7;

/// Steps beyond which any run is refused.
const MOST: f64 = 1e11;

/// Estimated work of a run.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Work {
    /// Steps of one integration, to a factor of ten; where the run ends with the arrival of a front, to the time at which one
    /// usually arrives. `None` where they cannot be told.
    pub steps: Option<f64>,
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
        let time = self.latest_end(PATIENCE);
        let ([least, most], limit) = self.steps(time, &self.contact_rates(time));
        Work {
            steps: (most <= UNCERTAIN * least).then_some((least * most).sqrt()),
            limit,
        }
    }

    /// The end time, or this part of the longest wait for a front.
    fn latest_end(&self, patience: f64) -> f64 {
        match self.end_time {
            EndTime::At(time) => time,
            EndTime::Arrival => self.latest_arrival(self.velocity_scale(0.0)) / patience,
        }
    }

    /// The steps without and with those of a contact that is stiffer than others, and what determines their length.
    fn steps(&self, time: f64, contacts: &[ContactRates]) -> ([f64; 2], &'static str) {
        if let Accuracy::Step(step) = self.accuracy {
            return ([time / step; 2], "step");
        }
        let (limit, rate) = self.damping_rate(contacts);
        let moved = self.steps_of_motion(time, rate, contacts);
        let damped = rate / STABLE * time;
        let limit = if damped > moved[1] { limit } else { "motion" };
        (moved.map(|moved| moved + damped), limit)
    }

    /// Of each contact what decides the steps there.
    fn contact_rates(&self, time: f64) -> Vec<ContactRates> {
        let chain = &self.chain;
        let (speed, losses) = (self.velocity_scale(time), chain.losses);
        let of_contact = |(mass, contact): (f64, Contact)| {
            let stop = stopping_time(mass, contact, speed);
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
        self.reduced_masses().map(of_contact).collect()
    }

    /// The contacts, that with a wall before site 0 last, with the mass with which their bodies move against each other.
    fn reduced_masses(&self) -> impl Iterator<Item = (f64, Contact<'_>)> {
        let contacts = self.chain.contacts().chain(self.chain.left_contact());
        contacts.map(|contact| (contact.reduced_mass(&self.chain.mass), contact))
    }

    /// The time in which each contact stops two bodies that meet at this speed.
    pub(super) fn stopping_times(&self, speed: f64) -> impl Iterator<Item = f64> {
        let each = self.reduced_masses().take(self.chain.n_contacts());
        each.map(move |(mass, contact)| stopping_time(mass, contact, speed))
    }

    /// Steps that the motion needs, where contacts relax at `rate` or more slowly. Calibrated at 300 random scenes, of which
    /// it found all to a factor of eight with those of [`Work::steps`]. Without and with those of the stiffest contact.
    fn steps_of_motion(&self, time: f64, rate: f64, contacts: &[ContactRates]) -> [f64; 2] {
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
        let mut a_time = (each * usual).max(STEPS_OF_THE_STIFFEST * chain.fastest_resonator());
        let mut at_most = a_time.max(STEPS_OF_THE_STIFFEST * most);
        let mut lasts = time;
        if chain.losses.drag > 0.0 {
            let heaviest = chain.mass.iter().copied().fold(0.0, f64::max);
            lasts = lasts.min(UNTIL_STOPPED * heaviest / chain.losses.drag);
        } else if rate > 0.0 {
            lasts = lasts.min(SPREAD * (time / rate).sqrt());
        }
        if chain.law.all_open() && !chain.is_pressed() {
            let collisions = 1.0 + chain.n_sites() as f64 / BODIES_A_COLLISION;
            (a_time, at_most) = (collisions * a_time, collisions * at_most);
            let is_open = matches!(chain.ends, Ends::Wall | Ends::Free) && self.drive.is_none();
            if is_open {
                lasts = lasts.min(UNTIL_APART * (chain.n_sites() + 2) as f64 / least);
            }
        }
        [a_time * lasts, at_most * lasts]
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
        let time = self.latest_end(1.0);
        let contacts = self.contact_rates(time);
        if let Accuracy::Tolerance(tolerance) | Accuracy::LocalError(tolerance) = self.accuracy {
            let least = contacts
                .iter()
                .fold(0.0, |most: f64, of| most.max(of.rounding));
            let expected = format!(
                "a law less steep, or a tolerance above {least:.1e}, by which rounding of an overlap changes the force there"
            );
            let found = format!("the tolerance {tolerance:e}");
            Error::require(least <= tolerance.max(WARNED), "law", expected, found)?;
        }
        let ([steps, _], limit) = self.steps(time, &contacts);
        let is_damped = !matches!(limit, "motion" | "step");
        let most = if is_damped { MOST_DAMPED } else { MOST };
        let option = if limit == "motion" { "end-time" } else { limit };
        let expected = format!("a run of at most {most:e} steps, as `{limit}` determines them");
        let found = format!("about {steps:.1e} steps to the time {time}");
        Error::require(steps.is_nan() || steps <= most, option, expected, found)
    }
}

/// The time in which a contact stops a mass of this speed.
fn stopping_time(mass: f64, contact: Contact, speed: f64) -> f64 {
    let c = contact.coefficient;
    let power = contact.law.exponent();
    match power.filter(|_| contact.static_overlap == 0.0 && c > 0.0 && speed > 0.0) {
        // `c (v t)^p t = m v`
        Some(p) => ((mass.ln() + (1.0 - p) * speed.ln() - c.ln()) / (p + 1.0)).exp(),
        None => stepping::stopping_time(contact, mass, speed),
    }
}
