//! How late a record is against that of a run, and how large its front is.
//!
//! With `y` a record, `p` that of the run and D the samples up to the end of the front and of the latest delay,
//!
//! ```text
//! delay = arg min over tau, g of  sum_D (y(t) - g p(t - tau))^2, located by the samples of the front,
//! size  = sum_W y(t) p(t - delay) / sum_W p(t - delay)^2,   W the front
//! ```
//!
//! Errors are those of the linearized problem with the covariance of the noise. A delay is told if it lowers the squares by
//! more than the largest of as many delays of noise does.

use super::super::noise::{Linear, Noise};
use super::super::solver::{cholesky, dot, gram, scaled};
use super::TOLD;
use crate::numeric::golden_section;

/// Shares of the largest value at which a front starts and has arrived.
const START: f64 = 0.02;
const ARRIVED: f64 = 0.5;

/// Delays of a front's length that are tried, and fronts that are searched for before all of the record is.
const DELAYS: f64 = 8.0;
const FRONTS: f64 = 2.0;

/// Decrease of the squares, in variances of the noise, that no delay of noise reaches.
const LOWER: f64 = 30.0;

/// Error of a delay by interpolation, in steps of the samples, and of a size.
const DELAY_RESOLUTION: f64 = 0.05;
const SIZE_RESOLUTION: f64 = 0.01;

/// Fewest samples of a front.
const LEAST: usize = 4;

/// Samples as a function of time: cubic between them, constant beyond.
///
/// Source: E. Catmull, R. Rom, in Computer Aided Geometric Design (1974) 317.
pub(super) struct Curve<'a> {
    pub times: &'a [f64],
    pub values: &'a [f64],
}

impl Curve<'_> {
    fn slope(&self, i: usize) -> f64 {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(self.times.len() - 1));
        (self.values[b] - self.values[a]) / (self.times[b] - self.times[a])
    }

    /// The value at a time, and its rate.
    pub fn at(&self, time: f64) -> [f64; 2] {
        let b = self.times.partition_point(|t| *t <= time);
        if b == 0 || b == self.times.len() {
            return [self.values[b.saturating_sub(1)], 0.0];
        }
        let a = b - 1;
        let step = self.times[b] - self.times[a];
        let s = (time - self.times[a]) / step;
        let [v0, v1] = [a, b].map(|i| self.values[i]);
        let [d0, d1] = [a, b].map(|i| step * self.slope(i));
        let (square, cube) = (3.0 * (v1 - v0) - 2.0 * d0 - d1, 2.0 * (v0 - v1) + d0 + d1);
        [
            v0 + s * (d0 + s * (square + s * cube)),
            (d0 + s * (2.0 * square + 3.0 * s * cube)) / step,
        ]
    }
}

/// The front of a run's record in that of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Front {
    /// First and last time in the run, and when half of the largest value is reached.
    window: [f64; 2],
    pub arrival: f64,
    pub delay: f64,
    /// Measured over that of the run.
    pub size: f64,
    /// By how much the delay lowers the squares.
    lower: f64,
}

/// What is told of a front beside noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Told {
    pub delay_error: f64,
    pub size_error: f64,
    /// Whether it is there at all, late, and of another size.
    pub is_there: bool,
    pub is_late: bool,
    pub is_other: bool,
}

impl Front {
    /// `None` where the run's record has no front: it begins inside one, or has too few samples of it.
    pub fn of(run: &Curve, measured: &[f64], known: &[bool]) -> Option<Front> {
        let (times, values) = (run.times, run.values);
        let last = times.len() - 1;
        let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let reaches = |share: f64| values.iter().position(|v| v.abs() > share * largest);
        let start = reaches(START).filter(|start| *start > 0)? - 1;
        let half = reaches(ARRIVED)?;
        let peak = (half..last).find(|i| values[i + 1].abs() < values[*i].abs());
        let end = (2.0 * times[peak.unwrap_or(last)] - times[start]).min(times[last]);
        let long = end - times[start];
        let inside = times.iter().filter(|t| (times[start]..=end).contains(t));
        if inside.count() < LEAST {
            return None;
        }
        let fit = |delay: f64, upto: f64| -> f64 {
            let (mut both, mut squares) = (0.0, 0.0);
            let samples = times.iter().zip(measured).zip(known);
            for ((t, y), known) in samples.take_while(|((t, _), _)| **t <= upto) {
                let p = run.at(t - delay)[0];
                if *known {
                    both += y * p;
                    squares += p * p;
                }
            }
            // Of no use is a front that hardly enters the record, or one upside down.
            match both > 0.0 && squares > 1e-3 * largest * largest {
                true => both * both / squares,
                false => 0.0,
            }
        };
        let search = |most: f64| {
            let upto = end + most;
            let step = long / DELAYS;
            let count = (most / step).ceil() as i64;
            let tried = (-count..=count).map(|k| {
                let delay = k as f64 * step;
                (fit(delay, upto), delay)
            });
            // Of delays that do as well the shortest.
            let order = |a: &(f64, f64), b: &(f64, f64)| {
                a.0.total_cmp(&b.0).then(b.1.abs().total_cmp(&a.1.abs()))
            };
            let best = tried.max_by(order).unwrap_or((0.0, 0.0)).1;
            // Of the front alone, not of what comes behind it.
            let of = |delay: f64| Ok::<f64, std::convert::Infallible>(fit(delay, end + best));
            let ends = [best - step, best + step];
            let enough = 1e-3 * DELAY_RESOLUTION * long;
            let Ok((_, (delay, _))) = golden_section(ends, enough, usize::MAX, of);
            let is_at_end = count as f64 * step - best.abs() < 0.5 * step;
            (delay, fit(delay, upto) - fit(0.0, upto), is_at_end)
        };
        let (delay, lower, _) = match search(FRONTS * long) {
            (.., true) => search(0.5 * (times[last] - times[0])),
            near => near,
        };
        let front = Front {
            window: [times[start], end],
            arrival: times[half],
            delay,
            size: 0.0,
            lower,
        };
        Some(front.at(delay, run, measured, known))
    }

    /// Until when neither record has begun.
    pub fn until(&self) -> f64 {
        self.window[0] + self.delay.min(0.0)
    }

    /// The front at another delay.
    pub fn at(self, delay: f64, run: &Curve, measured: &[f64], known: &[bool]) -> Front {
        let front = Front { delay, ..self };
        let [column, _] = front.columns(run, known);
        Front {
            size: dot(&column, measured) / dot(&column, &column).max(f64::MIN_POSITIVE),
            ..front
        }
    }

    /// The run's front as late as the measured one, and its rate, where samples are known.
    fn columns(&self, run: &Curve, known: &[bool]) -> [Vec<f64>; 2] {
        let column = |which: usize| -> Vec<f64> {
            let samples = run.times.iter().zip(known);
            let at = samples.map(|(t, known)| {
                let own = t - self.delay;
                let is_in = *known && (self.window[0]..=self.window[1]).contains(&own);
                if is_in { run.at(own)[which] } else { 0.0 }
            });
            at.collect()
        };
        [column(0), column(1)]
    }

    /// What is told of a record beside noise of one site; `None` where no sample of the front is known.
    pub fn told(
        &self,
        run: &Curve,
        (measured, known): (&[f64], &[bool]),
        noise: &Noise,
        step: f64,
    ) -> Option<Told> {
        let columns = self.columns(run, known);
        let (scaled, sizes) = scaled(&columns);
        let error = |columns: &[Vec<f64>], lower: &[Vec<f64>], k: usize| {
            let linear = Linear {
                columns,
                lower,
                sites: 1,
                times: known.len(),
            };
            linear.covariance(noise)[k][k].max(0.0).sqrt() / sizes[k]
        };
        let own = error(&scaled[..1], &[vec![1.0]], 0);
        let lower = cholesky(&gram(&scaled))?;
        // A front of another shape may lie best at a delay, and at a size, that are none of its own: by as much as what is left of it
        // beyond noise would change them.
        let inside = measured.iter().zip(&columns[0]).filter(|(_, p)| **p != 0.0);
        let squares = inside.map(|(y, p)| (y - self.size * p).powi(2) - noise.sigma.powi(2));
        let shape = squares.sum::<f64>().max(0.0).sqrt() / TOLD;
        let size_error = error(&scaled, &lower, 0).hypot(shape / sizes[0]);
        // The derivative along the delay is the rate times the size.
        let size = self.size.abs().max(f64::MIN_POSITIVE);
        let delay_error = error(&scaled, &lower, 1).hypot(shape / sizes[1]) / size;
        let delay_error = delay_error.hypot(DELAY_RESOLUTION * step);
        // What a share of one variance of the noise lowers the squares by.
        let variance = (own * sizes[0]).powi(2);
        let is_there = self.size > TOLD * size_error;
        Some(Told {
            delay_error,
            size_error,
            is_there,
            is_late: is_there
                && self.delay.abs() > TOLD * delay_error
                && self.lower > LOWER * variance,
            is_other: (self.size - 1.0).abs() > TOLD * size_error + SIZE_RESOLUTION,
        })
    }
}
