//! The front of a struck chain: what it loses, and what its content does.

use super::found::{Found, LATE};
use super::profile::{Judged, Profile};
use super::speed::slope;
use super::{Answer, Front, Reason, Tail};

/// Error of the loss per 100 bodies of a front that does not fall evenly: it is one of several pulses, and has no content of its own.
const UNEVEN: f64 = 0.01;
/// Bodies on each side over which the speed of a front is taken.
const BESIDE: usize = 8;
/// Bodies over which its content is followed, of chains of 150 and more the same.
const PER: usize = 75;

/// From groups in windows, and those in windows of half the length, which hold the pulse and little of what it leaves behind.
pub(super) fn along_x(found: &Found, windows: &Profile, pulses: &Profile) -> Answer {
    let options = found.options;
    let place = |rows| options.place(rows);
    let is_whole = |group: &usize| windows.find(pulses.rows(*group)).is_some();
    let whole: Vec<usize> = (0..pulses.len()).filter(is_whole).collect();
    let front = pulses.among(&whole);
    if front.len() < 4 {
        return Answer::untold(Reason::ShortRecord { whole: 0, sites: 0 });
    }
    let (first, last) = (front.len() / 2, front.len() - 1);
    let start = front.rows(first)[0];
    let is_near = |group: &usize| front.rows(*group)[1].abs_diff(start) <= PER;
    let near: Vec<usize> = (first..=last).filter(is_near).collect();
    let travel = front.among(&near);
    let same = near
        .iter()
        .filter_map(|&group| windows.find(front.rows(group)));
    let same: Vec<usize> = same.collect();
    let Judged {
        mut movement,
        group,
    } = travel.judge(options.tolerance, &place);
    if movement.moves() {
        let way = movement.way();
        let whole = found.profile(true).among(&same);
        let left = whole.same(travel.rows(group), way);
        if left.is_some_and(|left| left < LATE * movement.most().share) {
            (movement.transfer, movement.lags) = (None, true);
        }
    }
    let loss = found.loss(&front, first);
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
    let launch = front.among(&[0, first]).judge(options.tolerance, &place);
    Answer {
        front: loss,
        tail: tail(found, windows.find(travel.rows(0)).map(|at| (windows, at))),
        launch: Some(launch.movement),
        along_x: Some(front.evidence([first, first + group], &place)),
        frequency: movement,
        ..Answer::untold(Reason::NoEnergy)
    }
}

impl Found<'_> {
    /// `-100 d ln E / dj` from the group `first` on.
    fn loss(&self, profile: &Profile, first: usize) -> Option<Front> {
        let energy = |group: usize| {
            let [from, to] = profile.rows(group);
            let energies: Vec<f64> = self.of_group([from, to]).map(|seen| seen.energy).collect();
            let mean = energies.iter().sum::<f64>() / energies.len() as f64;
            (0.5 * (from + to) as f64, mean)
        };
        let points = (first..profile.len()).map(energy).map(|(j, e)| (j, e.ln()));
        let points: Vec<(f64, f64)> = points.collect();
        if points.len() < 4 {
            return None;
        }
        let (slope, bound) = slope(&points);
        let last = profile.len() - 1;
        Some(Front {
            loss_per_100_bodies: -100.0 * slope,
            error: 100.0 * bound,
            bodies: [profile.rows(first)[0], profile.rows(last)[1]]
                .map(|row| row + self.options.first_site),
        })
    }
}

/// What follows the window of a group.
fn tail(found: &Found, group: Option<(&Profile, usize)>) -> Option<Tail> {
    let (windows, group) = group?;
    let rest = found.sum(windows.rows(group), |seen| &seen.rest);
    let rows = found.of_group(windows.rows(group)).count() as f64;
    let energy: f64 = rest.iter().sum();
    let upper = found.upper;
    let density = |m: &usize| rest[*m] / (upper[*m] - upper[m - 1]);
    let peak = (1..rest.len()).max_by(|a, b| density(a).total_cmp(&density(b)))?;
    Some(Tail {
        energy_share: energy / (energy + rows * windows.energy(group)),
        peak_frequency: 0.5 * (upper[peak - 1] + upper[peak]),
    })
}

/// By what `v^2` of a body counts, one number a site: `m_j c_j`, c the speed of the front in bodies a sample. A front that keeps
/// its energy while masses and speeds change has the same sum of it over time at all bodies.
pub(super) fn weights(masses: &[f64], sites: &[usize], passes: &dyn Fn(usize) -> f64) -> Vec<f64> {
    if sites.len() < 2 {
        return vec![1.0; masses.len()];
    }
    let mut all = vec![1.0; masses.len()];
    let mut sum = 0.0;
    for (i, &site) in sites.iter().enumerate() {
        let around = [i.saturating_sub(BESIDE), (i + BESIDE).min(sites.len() - 1)];
        let [a, b] = around.map(|i| sites[i]);
        let takes = passes(b) - passes(a);
        let speed = (b - a) as f64 / takes.abs().max(1.0);
        all[site] = masses[site] * speed;
        sum += all[site];
    }
    let mean = sum / sites.len() as f64;
    for &site in sites {
        all[site] /= mean;
    }
    all
}
