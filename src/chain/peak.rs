//! The largest force of a contact, between samples too.

use std::convert::Infallible;

use super::drive::Drive;
use super::lattice::Ends;
use super::result::Run;
use super::stepping::Quintic;
use crate::numeric::golden_section;

/// A largest value and when it was reached.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Peak {
    pub value: f64,
    pub time: f64,
    /// By how much the value from every second sample differs, many times the error of this one
    /// where samples are close enough for it to be small; infinite for less than three samples.
    pub error: f64,
}

/// Subintervals of a sampling interval at whose ends the force is evaluated before its peak is
/// located.
const SAMPLES_PER_STEP: usize = 4;

/// Share of its peak from which on the force of a contact rises.
const BEGINS: f64 = 1e-3;

/// How long the force at a wall takes to peak from when the front reaches the last body, over the rise of a contact
/// before it: at most 2.2 in uniform chains, dimers, tapers and compressed chains.
const WALL_RISES: f64 = 3.0;

/// Largest rise of a peak between evaluations, as a share of the largest force so far.
const NEAR: f64 = 0.1;

impl Run {
    /// The largest force `F_j` of contact j beyond the static one, damping included; `None` where
    /// displacements or forces were not recorded.
    ///
    /// Between two samples the overlap is the polynomial of degree five with its value, rate and
    /// acceleration at both, so that the error falls with the sixth power of the time between
    /// samples; a sampled maximum would be low by an error of second order.
    ///
    /// # Panics
    /// Where the chain has no such contact.
    pub fn peak_force(&self, contact: usize) -> Option<Peak> {
        let x = self.displacement.as_ref()?;
        self.force.as_ref()?;
        let chain = &self.chain;
        let motion = |sample: usize, site: usize| {
            [
                x[[sample, site]],
                self.velocity[[sample, site]],
                self.acceleration(sample, site),
            ]
        };
        let of = chain.contact(contact);
        let overlap = |sample: usize| {
            let other = of.sites[1].map_or([0.0; 3], |right| motion(sample, right));
            let own = motion(sample, contact);
            std::array::from_fn(|i| own[i] - other[i])
        };
        let last = self.time.len() - 1;
        let nodes = |stride: usize| -> Vec<(f64, [f64; 3])> {
            let samples = (0..last).step_by(stride).chain([last]);
            samples.map(|n| (self.time[n], overlap(n))).collect()
        };
        let force = |r: f64, closing: f64| chain.total_force(of, r, closing);
        let (value, time) = highest(&nodes(1), force)?;
        let error = match last {
            0 | 1 => f64::INFINITY,
            _ => (highest(&nodes(2), force)?.0 - value).abs(),
        };
        Some(Peak { value, time, error })
    }

    /// Of a run that ends when the front reaches the last site: an end by which the force at the wall behind it
    /// has peaked, with two digits. `None` where no pulse has passed a contact, or forces were not recorded.
    ///
    /// The last contact that the pulse has passed says how long it rises. The wall holds the last body until it
    /// has stopped, which takes longer.
    pub fn end_behind_wall_peak(&self) -> Option<f64> {
        let force = self.force.as_ref()?;
        let last = self.time.len() - 1;
        let rise =
            (0..self.chain.n_contacts()).rev().find_map(|contact| {
                let of = force.column(contact);
                let (at, most) = of.iter().enumerate().fold((0, 0.0), |(at, most), (n, f)| {
                    if *f > most { (n, *f) } else { (at, most) }
                });
                let has_passed = most > 0.0 && of[last] < 0.5 * most;
                let begin = of.iter().position(|f| *f > BEGINS * most)?;
                has_passed.then(|| self.time[at] - self.time[begin])
            })?;
        let end = self.time[last] + WALL_RISES * rise;
        let digit = 10f64.powf(end.log10().floor() - 1.0);
        Some((end / digit).ceil() * digit)
    }

    /// By how much this error of the velocities can change the largest force of contact j: an error of the
    /// speed v of a mass m becomes one of the overlap by the same energy, `k x^2 = m v^2`, which changes the
    /// force by `sqrt(k m) v`, with the largest stiffness k sampled and the heavier mass.
    pub(crate) fn force_error(&self, contact: usize, speed: f64) -> Option<f64> {
        let x = self.displacement.as_ref()?;
        let chain = &self.chain;
        let law = chain.contact(contact);
        let right = law.sites[1];
        let overlaps = x
            .rows()
            .into_iter()
            .map(|row| row[contact] - right.map_or(0.0, |right| row[right]));
        let stiffest = overlaps.map(|r| law.stiffness(r).abs()).fold(0.0, f64::max);
        let heavier = right.map_or(0.0, |right| chain.mass[right]);
        Some((stiffest * heavier.max(chain.mass[contact])).sqrt() * speed)
    }

    /// Acceleration of a site at a sample, from the forces recorded there.
    fn acceleration(&self, sample: usize, site: usize) -> f64 {
        let Run {
            chain,
            time,
            velocity,
            displacement: Some(x),
            force: Some(force),
            ..
        } = self
        else {
            return 0.0;
        };
        if let Some((moved, wave)) = self.drive.as_ref().and_then(Drive::motion)
            && moved == site
        {
            return wave.acceleration_at(time[sample]);
        }
        let (t, v) = (time[sample], velocity[[sample, site]]);
        let right = force.row(sample).get(site).copied().unwrap_or(0.0);
        let left = match (site.checked_sub(1), chain.ends) {
            (Some(contact), _) => force[[sample, contact]],
            (None, Ends::Periodic) => force[[sample, chain.n_contacts() - 1]],
            (None, _) => chain.left_contact().map_or(0.0, |contact| {
                let [wall, speed] = match &self.drive {
                    Some(Drive::Wall(wave)) => [wave.at(t), wave.rate_at(t)],
                    _ => [0.0; 2],
                };
                chain.total_force(contact, wall - x[[sample, 0]], speed - v)
            }),
        };
        let push = match &self.drive {
            Some(Drive::Force(wave)) if site == 0 => wave.at(t),
            Some(Drive::Body(driven, wave)) if *driven == site => wave.at(t),
            _ => 0.0,
        };
        let own = (self.resonator_displacement.as_ref()).zip(self.resonator_velocity.as_ref());
        let own = own.map(|(y, w)| [y[[sample, site]], w[[sample, site]]]);
        let pull = chain.pull(site, [x[[sample, site]], v], own);
        (left - right + push - pull) / chain.mass[site]
    }
}

/// The largest force and its time along overlaps of these times, values, rates and accelerations.
fn highest(nodes: &[(f64, [f64; 3])], force: impl Fn(f64, f64) -> f64) -> Option<(f64, f64)> {
    let interval = |i: usize| {
        let ((from, start), (to, end)) = (nodes[i], nodes[i + 1]);
        let h = to - from;
        let scaled = |[r, rate, bend]: [f64; 3]| [r, h * rate, h * h * bend];
        let path = Quintic::hermite(scaled(start), scaled(end));
        let force = &force;
        (from, h, move |s: f64| {
            force(path.at(s), path.slope_at(s) / h)
        })
    };
    let step = 1.0 / SAMPLES_PER_STEP as f64;
    let most = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 { b } else { a };
    let looked: Vec<(f64, f64)> = (0..nodes.len() - 1)
        .map(|i| {
            let (_, _, force) = interval(i);
            let looks = (0..=SAMPLES_PER_STEP).map(|look| step * look as f64);
            let forces = looks.map(|s| (force(s), s));
            forces.fold((f64::NEG_INFINITY, 0.0), most)
        })
        .collect();
    let (seen, _) = looked.iter().copied().fold((f64::NEG_INFINITY, 0.0), most);
    let near = looked
        .iter()
        .enumerate()
        .filter(|(_, (value, _))| *value >= seen - NEAR * seen.abs());
    near.map(|(i, (_, s))| {
        let (from, h, force) = interval(i);
        let (s, value) = largest((s - step).max(0.0), (s + step).min(1.0), force);
        (value, from + s * h)
    })
    .reduce(most)
}

/// Where a function of one hump is largest, by golden sections down to half the digits, at which
/// its value has them all.
pub(crate) fn largest(a: f64, b: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    let value = |x: f64| Ok::<f64, Infallible>(f(x));
    let Ok(([a, b], best)) = golden_section([a, b], 1e-9, usize::MAX, value);
    let middle = 0.5 * (a + b);
    (middle, f(middle).max(best.1))
}
