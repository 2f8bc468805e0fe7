//! The passage of the front: shares of each site over a window that begins at its arrival.
//!
//! Shares over a whole record depend on its length, since the motion behind the front differs from
//! the front.

use super::along::Headline;
use super::plan::Plan;
use super::quality::{FLAT_PART, flat_part};
use super::result::{Front, FrontLength};
use super::worker::Worker;
use crate::diagnostics::{Bins, SpectrumMoments, interleaved_moments};
use crate::moved::Answer;
use crate::numeric::lanes::WIDTH;
use crate::transform::{Real, RecordTransform, fold, frequencies, quick};

/// The part of a site's largest magnitude that its arrival exceeds for the first time.
const ARRIVAL: f64 = 0.01;

/// Widths at half maximum of the pulse at the reference that a window is long.
const WIDTHS: f64 = 10.0;

/// The first sample whose magnitude exceeds a hundredth of the record's largest.
pub(super) fn arrival(record: &[f64]) -> Option<usize> {
    let largest = record.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    record.iter().position(|v| v.abs() > ARRIVAL * largest)
}

/// Width at half of the largest magnitude of `record`, in samples: between the crossings beside the
/// peak, linear between samples; from the record's end where it is above half there. `None` where it
/// is so at both ends, and without a peak.
fn pulse_width(record: &[f64]) -> Option<f64> {
    let peak = record.iter().enumerate().fold((0, 0.0), |best, (n, v)| {
        if v.abs() > best.1 { (n, v.abs()) } else { best }
    });
    let half = 0.5 * peak.1;
    if half == 0.0 {
        return None;
    }
    // Samples from the peak to where the line between two of them meets half.
    let crossing = |side: &mut dyn Iterator<Item = &f64>| {
        let mut last = peak.1;
        for (n, v) in side.map(|v| v.abs()).enumerate() {
            if v < half {
                return Some(n as f64 + (last - half) / (last - v));
            }
            last = v;
        }
        None
    };
    let before = crossing(&mut record[..peak.0].iter().rev());
    let after = crossing(&mut record[peak.0 + 1..].iter());
    let [to_start, to_end] = [peak.0, record.len() - 1 - peak.0].map(|n| n as f64);
    let crosses = before.is_some() || after.is_some();
    crosses.then(|| before.unwrap_or(to_start) + after.unwrap_or(to_end))
}

/// How long windows are: as given, in units of time, or by the pulse in `reference`.
pub(super) fn window_of(plan: &Plan, reference: Option<&[f64]>) -> FrontLength {
    let dt = plan.axes.time.step;
    let (length, pulse_width) = match (plan.request.front_window, reference) {
        (Some(length), _) => (length, None),
        (None, None) => return FrontLength::NoReference,
        (None, Some(record)) => match pulse_width(record) {
            None => return FrontLength::NoPulse,
            Some(width) => (WIDTHS * width * dt, Some(width * dt)),
        },
    };
    let samples = (length / dt).round().max(1.0) as usize;
    let window = samples as f64 * dt;
    match samples <= plan.axes.n_times {
        true => FrontLength::Window {
            window,
            samples,
            pulse_width,
        },
        false => FrontLength::TooLong { window },
    }
}

/// Results at one site.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    pub arrival: Option<usize>,
    pub low_share: f64,
    pub high_share: f64,
}

/// Transforms of windows, planned.
pub(super) struct WindowTransforms<T: Real> {
    samples: usize,
    transform: RecordTransform<T>,
    frequency: Vec<f64>,
    dt: f64,
    edge: f64,
}

impl<T: Real> WindowTransforms<T> {
    /// Transforms of untapered windows of `samples` samples; energy below `edge` is low.
    pub fn new(plan: &Plan, samples: usize, edge: f64) -> Self {
        let dt = plan.axes.time.step;
        // Padded with zeros to a fast length, at most that of whole records.
        let padded = quick(samples).min(plan.conventions.padded_time.max(samples));
        WindowTransforms {
            samples,
            transform: RecordTransform::new(&vec![1.0; samples], padded),
            frequency: frequencies(padded, dt),
            dt,
            edge,
        }
    }

    /// Of `width` interleaved records, which are overwritten.
    pub fn of_columns(
        &self,
        columns: &mut [f64],
        width: usize,
        worker: &mut Worker<T>,
    ) -> Vec<Passed> {
        let length = columns.len() / width;
        let arrivals = arrivals_across(columns, width);
        // Windows move to the front, where they start together; no sample is written over before it
        // was read, since none moves back.
        for (lane, arrival) in arrivals.iter().enumerate() {
            let start = self.start(*arrival, length).unwrap_or(0);
            if start > 0 {
                for n in 0..self.samples {
                    columns[n * width + lane] = columns[(start + n) * width + lane];
                }
            }
        }
        let windows = &columns[..self.samples * width];
        let (transform, padded) = (&self.transform, self.transform.padded());
        let shape = (transform.bins(), width);
        worker.add(
            shape,
            None,
            (true, |m| fold(m, padded)),
            |spectra, scratch| transform.transform_columns(windows, spectra, scratch),
        );
        let bins = Bins::new(&self.frequency, padded, 1.0 / (padded as f64 * self.dt));
        let rows = interleaved_moments(&worker.power, &bins, self.edge);
        let found = arrivals.iter().zip(rows).map(|(&arrival, row)| {
            let fits = self.start(arrival, length).is_some();
            let or_nan = |share| if fits { share } else { f64::NAN };
            Passed {
                arrival,
                low_share: or_nan(row.low_share),
                high_share: or_nan(row.high_share),
            }
        });
        found.collect()
    }

    /// Where the window starts, if it fits into a record of `length`.
    fn start(&self, arrival: Option<usize>, length: usize) -> Option<usize> {
        arrival.filter(|start| start + self.samples <= length)
    }
}

/// [`arrival`] of each of `width` interleaved records, at most eight.
fn arrivals_across(columns: &[f64], width: usize) -> Vec<Option<usize>> {
    let mut largest = [0.0f64; WIDTH];
    for row in columns.chunks_exact(width) {
        for (m, v) in largest.iter_mut().zip(row) {
            *m = m.max(v.abs());
        }
    }
    let mut found = vec![None; width];
    let mut open = largest[..width].iter().filter(|m| **m > 0.0).count();
    for (n, row) in columns.chunks_exact(width).enumerate() {
        if open == 0 {
            break;
        }
        for ((found, m), v) in found.iter_mut().zip(&largest).zip(row) {
            if found.is_none() && v.abs() > ARRIVAL * m {
                *found = Some(n);
                open -= 1;
            }
        }
    }
    found
}

/// The front's shares as a result. `defined` marks the sites with energy.
pub(super) fn gather(
    plan: &Plan,
    length: FrontLength,
    (rows, passed): (&[SpectrumMoments], &[Passed]),
    defined: &[bool],
    reference: Option<usize>,
) -> Front {
    let FrontLength::Window { samples, .. } = length else {
        return Front::untold(length, plan);
    };
    let defined = || passed.iter().zip(defined);
    let moves = defined().filter(|(_, defined)| **defined);
    let (mut at_once, mut sites) = (0, 0);
    for (passed, _) in moves {
        sites += 1;
        at_once += usize::from(passed.arrival == Some(0));
    }
    if 2 * at_once > sites {
        let length = FrontLength::NoArrival {
            at_once,
            sites,
            // As flat as those of white noise.
            noise: flat_part(rows, &plan.frequency_bins()) > FLAT_PART,
        };
        return Front::untold(length, plan);
    }
    let column = |of: fn(&Passed) -> f64| -> Vec<f64> {
        let or_nan = |(passed, defined): (_, &bool)| if *defined { of(passed) } else { f64::NAN };
        defined().map(or_nan).collect()
    };
    let arrivals = defined().map(|(p, defined)| p.arrival.filter(|_| *defined));
    let arrivals: Vec<Option<usize>> = arrivals.collect();
    let fits = |arrival: &Option<usize>| arrival.is_some_and(|n| n + samples <= plan.axes.n_times);
    let fits: Vec<bool> = arrivals.iter().map(fits).collect();
    let high_share = column(|p| p.high_share);
    let at = |arrival: &Option<usize>| arrival.map_or(f64::NAN, |n| plan.axes.time.at(n));
    Front {
        length,
        arrival: arrivals.iter().map(at).collect(),
        headline: Headline::of(&high_share, &fits, &fits, reference, |row| plan.place(row)),
        fits,
        low_share: column(|p| p.low_share),
        high_share,
    }
}

impl Front {
    /// No arrivals and no shares, for the reason that `length` states.
    fn untold(length: FrontLength, plan: &Plan) -> Front {
        let nowhere = vec![f64::NAN; plan.axes.n_sites];
        Front {
            length,
            fits: vec![false; nowhere.len()],
            headline: Headline::default(),
            arrival: nowhere.clone(),
            low_share: nowhere.clone(),
            high_share: nowhere,
        }
    }

    /// None where noise exceeds a hundredth of the largest value before the wave arrives, by the arrivals of the answer, at most sites:
    /// its windows hold that noise.
    pub(super) fn unless_noise(self, answer: &Answer, plan: &Plan) -> Front {
        let time = &plan.axes.time;
        let Some(windows) = &answer.windows else {
            return self;
        };
        let both = self.arrival.iter().zip(&windows.arrivals);
        let later = both.filter_map(|(first, arrival)| Some(time.at((*arrival)?) - first));
        let later: Vec<f64> = later.filter(|later| later.is_finite()).collect();
        let early = later.iter().filter(|t| **t > windows.width * time.step);
        let (at_once, sites) = (early.count(), later.len());
        if 2 * at_once <= sites {
            return self;
        }
        let length = FrontLength::NoArrival {
            at_once,
            sites,
            noise: false,
        };
        Front::untold(length, plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: a triangle of height 4 and base 8 is half as high over 4 samples.
    #[test]
    fn val_width_of_a_triangle() {
        let triangle = |from: usize, n: usize| -> Vec<f64> {
            let height = |n: usize| (4.0 - (n as f64 - from as f64 - 4.0).abs()).max(0.0);
            (0..n).map(height).collect()
        };
        assert_eq!(pulse_width(&triangle(10, 40)), Some(4.0));
        let negative: Vec<f64> = triangle(3, 40).iter().map(|v| -v).collect();
        assert_eq!(pulse_width(&negative), Some(4.0));
        // Cut at its peak: the width of the rest.
        assert_eq!(pulse_width(&triangle(10, 40)[14..]), Some(2.0));
        assert_eq!(pulse_width(&triangle(10, 15)), Some(2.0));
        assert_eq!(pulse_width(&[1.0; 9]), None);
        assert_eq!(pulse_width(&[0.0; 9]), None);
        assert_eq!(arrival(&triangle(10, 40)), Some(11));
        assert_eq!(arrival(&[0.0; 4]), None);
    }

    #[test]
    fn quick_lengths_are_the_next_without_large_factors() {
        assert_eq!([1, 7, 11, 24, 121].map(quick), [1, 8, 12, 24, 125]);
    }

    #[test]
    fn columns_arrive_when_each_alone_does() {
        let records: Vec<Vec<f64>> = (0..5)
            .map(|j| {
                (0..50)
                    .map(|n| (n as f64 - 9.0 * j as f64).max(0.0))
                    .collect()
            })
            .collect();
        let columns: Vec<f64> = (0..50)
            .flat_map(|n| records.iter().map(move |r| r[n]))
            .collect();
        let alone: Vec<Option<usize>> = records.iter().map(|r| arrival(r)).collect();
        assert_eq!(arrivals_across(&columns, 5), alone);
    }
}
