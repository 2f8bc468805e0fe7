//! The front of a struck chain: what it loses, and what its content does.

use super::found::{Found, LATE};
use super::profile::Profile;
use super::speed::slope;
use super::{Answer, Front, Reason};

/// Error of the loss per 100 bodies of a front that does not fall evenly: it is one of several pulses, and has no content of its own.
const UNEVEN: f64 = 0.01;
/// Bodies on each side over which the speed of a front is taken.
const BESIDE: usize = 8;
/// Groups that a front is followed over, at least.
const LEAST: usize = 4;
/// Bodies over which its content is followed, of chains of 150 and more the same.
const PER: usize = 75;

/// From groups in windows, which hold the pulse and little of what it leaves behind.
pub(super) fn along_x(found: &Found, front: &Profile) -> Answer {
    let options = found.options;
    let place = |rows| options.place(rows);
    if front.len() < LEAST {
        return Answer::untold(Reason::ShortRecord);
    }
    let (first, last) = (front.len() / 2, front.len() - 1);
    let start = front.rows(first)[0];
    let is_near = |group: &usize| front.rows(*group)[1].abs_diff(start) <= PER;
    let near: Vec<usize> = (first..=last).filter(is_near).collect();
    let travel = front.among(&near);
    let (mut movement, group) = travel.judge(options.tolerance, &place);
    let whole = found.profile(true).among(&near);
    let left = whole.same(travel.rows(group), movement.way());
    if movement.moves() && left.is_some_and(|left| left < LATE * movement.most().share) {
        (movement.transfer, movement.lags) = (None, true);
    }
    let loss = found.loss(front, first);
    if movement.moves() {
        match loss.filter(|loss| loss.error < UNEVEN) {
            None => movement = movement.but_untold(Reason::Mixed),
            Some(_) if movement.lags => {}
            // A front that keeps its energy has moved it.
            Some(loss) => {
                let bodies = travel.rows(group)[0].abs_diff(start) as f64;
                let left = (-0.01 * bodies * loss.loss_per_100_bodies).exp();
                let keeps = 1.0 - left < LATE * movement.most().share;
                (movement.energy_ratio, movement.transfer) = (left, Some(keeps));
            }
        }
    }
    let (launch, _) = front.among(&[0, first]).judge(options.tolerance, &place);
    Answer {
        front: loss,
        launch: Some(launch),
        along_x: Some(front.evidence([first, first + group], &place)),
        frequency: movement,
        ..Answer::untold(Reason::NoEnergy)
    }
}

impl Found<'_> {
    /// `-100 d ln E / dj` from the group `first` on.
    fn loss(&self, profile: &Profile, first: usize) -> Option<Front> {
        // Groups have as many bodies.
        let energy = |group: usize| {
            let [from, to] = profile.rows(group);
            let bodies = self.of_group([from, to]);
            let sum: f64 = bodies.map(|seen| seen.energy * seen.weight).sum();
            (0.5 * (from + to) as f64, sum.ln())
        };
        let points: Vec<(f64, f64)> = (first..profile.len()).map(energy).collect();
        let [slope, bound] = slope(&points).filter(|_| points.len() >= LEAST)?;
        let last = profile.len() - 1;
        Some(Front {
            loss_per_100_bodies: -100.0 * slope,
            error: 100.0 * bound,
            bodies: [profile.rows(first)[0], profile.rows(last)[1]]
                .map(|row| row + self.options.first_site),
        })
    }
}

/// By what `v^2` of each of `sites` counts: `m_j c_j`, c the speed of the front in bodies a sample. A front that keeps its energy while
/// masses and speeds change has the same sum of it over time at all bodies.
pub(super) fn weights(
    masses: Option<&[f64]>,
    sites: &[usize],
    passes: &dyn Fn(usize) -> f64,
) -> Vec<f64> {
    let last = sites.len().saturating_sub(1);
    let weight = |i: usize| {
        let [a, b] = [i.saturating_sub(BESIDE), (i + BESIDE).min(last)].map(|i| sites[i]);
        let speed = (b - a).max(1) as f64 / (passes(b) - passes(a)).abs().max(1.0);
        masses.map_or(1.0, |masses| masses[sites[i]]) * speed
    };
    let weights: Vec<f64> = (0..sites.len()).map(weight).collect();
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    weights.iter().map(|weight| weight / mean).collect()
}
