//! Sites whose channel is dead, from the motion of their neighbours.
//!
//! A missing site moves by its own equation of motion, `m x'' = F_left - F_right`, from rest at t0,
//! between neighbours whose positions are measured: contacts and mass replace the channel. Nothing
//! is differentiated, so the noise of the neighbours is not amplified. Several missing sites in a
//! row move together.

use std::ops::Range;

use ndarray::{Array1, Array2, s};

use super::derive::motion;
use crate::budget::contacts::Contacts;
use crate::chain::Chain;
use crate::error::{Error, Result};

/// Phase, in rad, by which the fastest oscillation may turn in a step.
const STEP: f64 = 0.2;

/// Steps between two samples at most.
const MOST_STEPS: usize = 2000;

/// # Errors
/// [`Error::Request`] for a site that nothing holds on the left, whose velocity at t0 is unknown,
/// and for more than half of all sites missing.
pub(super) fn check(chain: &Chain, missing: &[bool]) -> Result<()> {
    let is_held = missing.first() != Some(&true) || chain.has_left_wall();
    let expected = "sites with neighbours or walls on both sides, at rest at the start";
    let found = "site 0, which has none on its left";
    Error::require(is_held, "missing", expected, found)?;
    let count = missing.iter().filter(|m| **m).count();
    let found = format!("{count} of {} missing", missing.len());
    let expected = "half of the sites or more with a record";
    Error::require(2 * count <= missing.len(), "missing", expected, found)
}

/// Fills in columns of missing sites.
pub(super) fn fill(
    chain: &Chain,
    dt: f64,
    missing: &[bool],
    displacement: &mut Array2<f64>,
    velocity: &mut Array2<f64>,
) {
    let mut from = 0;
    for run in missing.chunk_by(|a, b| a == b) {
        let sites = from..from + run.len();
        from = sites.end;
        if run[0] {
            let (x, v) = moved(chain, &sites, dt, [displacement, velocity]);
            displacement.slice_mut(s![.., sites.clone()]).assign(&x);
            velocity.slice_mut(s![.., sites]).assign(&v);
        }
    }
}

/// Position and velocity of a site.
type Place = [f64; 2];

/// How missing sites in a row move.
fn moved(
    chain: &Chain,
    sites: &Range<usize>,
    dt: f64,
    [displacement, velocity]: [&Array2<f64>; 2],
) -> (Array2<f64>, Array2<f64>) {
    let (samples, count) = (displacement.nrows(), sites.len());
    let time = Array1::zeros(samples);
    let of = motion(chain, time.view(), displacement, velocity);
    let contacts = Contacts::of(&of);
    // Contact i of these is left of the site i of the gap.
    let first = sites.start + contacts.offset;
    let id = |i: usize| {
        (first + i)
            .checked_sub(1)
            .filter(|id| *id < contacts.each.len())
    };
    let ids: Vec<Option<usize>> = (0..=count).map(id).collect();
    let left = ids[0].and_then(|id| contacts.each[id].sites[0]);
    let right = ids[count].and_then(|id| contacts.each[id].sites[1]);
    let at = |site: Option<usize>, i: usize| match site {
        Some(j) => [displacement[[i, j]], velocity[[i, j]]],
        None => [0.0; 2],
    };

    let squeezed = (0..samples).map(|i| at(left, i)[0] - at(right, i)[0]);
    let most = squeezed.fold(0.0, |m: f64, r| m.max(r.abs()));
    let stiffest = |i: usize| ids[i].map_or(0.0, |id| contacts.each[id].stiffness(most));
    let fastest = (0..count)
        .map(|i| ((stiffest(i) + stiffest(i + 1)) * 2.0 / chain.mass[sites.start + i]).sqrt());
    let fastest = fastest.fold(0.0, f64::max);
    let steps = ((dt * fastest / STEP).ceil() as usize).clamp(1, MOST_STEPS);
    let h = dt / steps as f64;

    let acceleration = |ends: [Place; 2], state: &[Place], out: &mut [f64]| {
        let place = |i: usize| match i {
            0 => ends[0],
            i if i > count => ends[1],
            i => state[i - 1],
        };
        let force = |i: usize| {
            let (a, b) = (place(i), place(i + 1));
            ids[i].map_or(0.0, |id| {
                let contact = contacts.each[id];
                chain.total_force(contact, a[0] - b[0], a[1] - b[1])
            })
        };
        let mut before = force(0);
        for (i, out) in out.iter_mut().enumerate() {
            let after = force(i + 1);
            let site = sites.start + i;
            let pull = chain.pull(site, state[i], None);
            *out = (before - after - pull) / chain.mass[site];
            before = after;
        }
    };

    let [mut x, mut v] = [0, 1].map(|_| Array2::zeros((samples, count)));
    let mut state = vec![[0.0; 2]; count];
    for i in 0..samples.saturating_sub(1) {
        let ends = [left, right].map(|site| [at(site, i), at(site, i + 1)]);
        for step in 0..steps {
            let between = |part: f64| {
                let u = (step as f64 + part) / steps as f64;
                ends.map(|[a, b]| hermite(a, b, dt, u))
            };
            runge_kutta(h, between, &acceleration, &mut state);
        }
        for (k, place) in state.iter().enumerate() {
            [x[[i + 1, k]], v[[i + 1, k]]] = *place;
        }
    }
    (x, v)
}

/// Value and slope at the share u of an interval, of the cubic with these values and slopes at its
/// ends.
fn hermite([x0, v0]: Place, [x1, v1]: Place, dt: f64, u: f64) -> Place {
    let rise = x1 - x0;
    let (a, b) = (dt * v0 - rise, rise - dt * v1);
    let w = 1.0 - u;
    let x = x0 * w + x1 * u + u * w * (a * w + b * u);
    let slope = rise + (w - u) * (a * w + b * u) + u * w * (b - a);
    [x, slope / dt]
}

/// A step of the classical method of fourth order.
fn runge_kutta(
    h: f64,
    ends: impl Fn(f64) -> [Place; 2],
    acceleration: &impl Fn([Place; 2], &[Place], &mut [f64]),
    state: &mut [Place],
) {
    let start = state.to_vec();
    let (mut a, mut now) = (vec![0.0; state.len()], start.clone());
    for (part, next, weight) in [
        (0.0, 0.5, 1.0),
        (0.5, 0.5, 2.0),
        (0.5, 1.0, 2.0),
        (1.0, 0.0, 1.0),
    ] {
        acceleration(ends(part), &now, &mut a);
        for (k, a) in a.iter().enumerate() {
            for (of, rate) in [now[k][1], *a].into_iter().enumerate() {
                state[k][of] += h * weight / 6.0 * rate;
                now[k][of] = start[k][of] + h * next * rate;
            }
        }
    }
}
