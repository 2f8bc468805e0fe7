//! How the difference of two runs grows: what of it rounding alone would leave.
//!
//! A chain that amplifies differences does so with those of two runs and with rounding alike. Of 64
//! struck dimers of 300 sites (stiffness ratio 1 to 1585, to time 250) 36 amplify rounding. The
//! errors of their finest runs were 0.02 to 30 times [`ROUNDING`] times the factor by which the
//! difference of their first two runs grew; of the others none was above the tolerance of 1e-6, or
//! 1e-9, by this estimate.

use super::recorder::SampleTimes;
use super::stepping::{FIRST_SITE, State};

/// Parts of the time at whose ends runs of fewer samples are compared.
const PARTS: usize = 32;

/// Fewer times show no growth.
const LEAST_PARTS: usize = 8;

/// What amplification makes of rounding, over the factor by which differences grow.
const ROUNDING: f64 = 1e-13;

/// Differences this large, over the velocity scale, grow no more.
const SATURATED: f64 = 1e-2;

/// Velocities of a run at equally distant times after the start, up to the last body that moves.
#[derive(Debug, Default)]
pub(super) struct Checks {
    sites: usize,
    velocity: Vec<Vec<f64>>,
    /// The estimated errors of all steps, added up.
    pub(super) estimated: f64,
}

impl Checks {
    /// Of a run whose samples are too few to show growth.
    pub(super) fn of(samples: SampleTimes, sites: usize) -> Checks {
        let is_wanted = samples.number() <= PARTS;
        Checks {
            sites: if is_wanted { sites } else { 0 },
            velocity: Vec::new(),
            estimated: 0.0,
        }
    }

    /// The time of the next one, in a run to `end`.
    pub(super) fn next_time(&self, end: f64) -> Option<f64> {
        let next = self.velocity.len() + 1;
        (self.sites > 0 && next <= PARTS).then(|| end * (next as f64 / PARTS as f64))
    }

    pub(super) fn keep(&mut self, state: &State) {
        let all = &state.v[FIRST_SITE..][..self.sites];
        let moved = all.iter().rposition(|v| *v != 0.0);
        let moved = moved.map_or(0, |last| last + 1);
        self.velocity.push(all[..moved].to_vec());
    }

    /// The largest difference from another run at each time, the start included; none unless both kept the same times.
    pub(super) fn differences(&self, other: &Checks) -> Option<Vec<f64>> {
        let are_alike = self.sites == other.sites && self.velocity.len() == other.velocity.len();
        let largest = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            let at = |row: &Vec<f64>, s: usize| row.get(s).copied().unwrap_or(0.0);
            let sites = 0..a.len().max(b.len());
            sites.fold(0.0, |worst: f64, s| worst.max((at(a, s) - at(b, s)).abs()))
        };
        let rows = self.velocity.iter().zip(&other.velocity).map(largest);
        (are_alike && !self.velocity.is_empty()).then(|| std::iter::once(0.0).chain(rows).collect())
    }
}

/// The error that rounding alone leaves at the end, relative to the velocity scale, where two runs
/// differ by `differences` at equally distant times, and the rate of their growth from one to the next. Early differences count as
/// `least` or more: before a first contact there are none.
pub(super) fn grown_rounding(differences: &[f64], least: f64, scale: f64) -> [f64; 2] {
    let last = differences.len().checked_sub(1);
    let Some(last) = last.filter(|n| *n >= LEAST_PARTS) else {
        return [0.0; 2];
    };
    let mut largest = 0.0f64;
    let so_far = differences.iter().map(|difference| {
        largest = largest.max(*difference);
        largest
    });
    let so_far: Vec<f64> = so_far.collect();
    let early = last / 8;
    let saturated = so_far.iter().position(|d| *d >= SATURATED * scale);
    // A rate is read off no less than a quarter of the time.
    let grown = saturated.unwrap_or(last).max(early + last / 4);
    let factor = so_far[grown] / so_far[early].max(least);
    let rate = factor.ln() / (grown - early) as f64;
    [ROUNDING * (rate * (last - early) as f64).exp(), rate]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_closed_form_growth() {
        let differences = |rate: f64, most: f64| -> Vec<f64> {
            let at = |i: usize| (1e-7 * (rate * i as f64).exp()).min(most);
            (0..=32).map(at).collect()
        };
        // Over 28 parts, also where it ends before.
        for most in [1.0, 2e-2] {
            let [found, rate] = grown_rounding(&differences(0.5, most), 1e-12, 1.0);
            assert!((rate - 0.5).abs() < 0.01, "{rate}");
            assert!(
                (found / (1e-13 * 14f64.exp()) - 1.0).abs() < 0.05,
                "{found:e}"
            );
        }
        assert!(grown_rounding(&differences(0.0, 1.0), 1e-12, 1.0)[0] < 2e-13);
        // A difference that jumps does not go on to do so.
        let mut jump = vec![1e-9; 33];
        jump[5..].fill(2e-2);
        let [found, _] = grown_rounding(&jump, 1e-12, 1.0);
        assert!(found < 1.01e-13 * 2e7f64.powf(3.5), "{found:e}");
        assert_eq!(grown_rounding(&[0.0, 1.0], 1e-12, 1.0), [0.0; 2]);
    }
}
