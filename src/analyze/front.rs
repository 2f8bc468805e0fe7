//! The passage of the front: shares of each site over a window that begins at its arrival.
//!
//! Shares over a whole record depend on its length, since the motion behind the front differs from
//! the front.

use super::along::Headline;
use super::plan::Plan;
use super::result::{Front, FrontWindow};
use super::worker::Worker;
use crate::diagnostics::Bins;
use crate::moved::ArrivalWindows;
use crate::transform::{Real, RecordTransform, fold, frequencies, quick};

/// The part of a site's largest magnitude that its arrival exceeds for the first time.
const ARRIVAL: f64 = 0.01;

/// Widths at half maximum of the pulse at the reference that a window is long.
const WIDTHS: f64 = 10.0;

/// The first sample of each of `width` interleaved records whose magnitude exceeds a hundredth of the record's largest.
pub(super) fn arrivals(columns: &[f64], width: usize) -> Vec<Option<usize>> {
    let mut largest = vec![0.0f64; width];
    for row in columns.chunks_exact(width) {
        for (m, v) in largest.iter_mut().zip(row) {
            *m = m.max(v.abs());
        }
    }
    let arrival = |(lane, largest): (usize, &f64)| {
        let mut record = columns.iter().skip(lane).step_by(width);
        record.position(|v| v.abs() > ARRIVAL * largest)
    };
    largest.iter().enumerate().map(arrival).collect()
}

/// Width at half of the largest magnitude of `record`, in samples: between the crossings beside the
/// peak, linear between samples; from the record's end where it is above half there. `None` where it
/// is so at both ends, and without a peak.
fn pulse_width(record: &[f64]) -> Option<f64> {
    let size = |n: usize| record[n].abs();
    let larger = |peak, n| if size(n) > size(peak) { n } else { peak };
    let peak = (0..record.len()).fold(0, larger);
    let half = 0.5 * size(peak);
    // Samples from the peak to where the line between two of them meets half.
    let crossing = |at: &dyn Fn(usize) -> usize, count: usize| {
        let n = (1..=count).find(|n| size(at(*n)) < half)?;
        let [inner, outer] = [n - 1, n].map(|n| size(at(n)));
        Some((n - 1) as f64 + (inner - half) / (inner - outer))
    };
    let [before, after] = [peak, record.len() - 1 - peak];
    let to_start = crossing(&|n| peak - n, before);
    let to_end = crossing(&|n| peak + n, after);
    let crosses = to_start.or(to_end).is_some();
    crosses.then(|| to_start.unwrap_or(before as f64) + to_end.unwrap_or(after as f64))
}

/// How long windows are: as given, in units of time, or by the pulse in `reference`; `None` without one, and where they are longer
/// than the record.
pub(super) fn window_of(plan: &Plan, reference: Option<&[f64]>) -> Option<FrontWindow> {
    let dt = plan.axes.time.step;
    let (length, pulse_width) = match plan.request.front_window {
        Some(length) => (length, None),
        None => {
            let width = pulse_width(reference?)?;
            (WIDTHS * width * dt, Some(width * dt))
        }
    };
    let samples = (length / dt).round().max(1.0) as usize;
    (samples <= plan.axes.n_times).then_some(FrontWindow {
        window: samples as f64 * dt,
        samples,
        pulse_width,
    })
}

/// Results at one site.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    pub arrival: Option<usize>,
    /// Without a meaning where the window does not fit into the record.
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
        let arrivals = arrivals(columns, width);
        let last = (columns.len() / width).checked_sub(self.samples);
        let fits = |start: &usize| last.is_some_and(|last| *start <= last);
        // Windows move to the front, where they start together; no sample is written over before it
        // was read, since none moves back.
        for (lane, arrival) in arrivals.iter().enumerate() {
            if let Some(start) = arrival.filter(fits).filter(|start| *start > 0) {
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
        let rows = worker.measured(&bins, self.edge).into_iter();
        let shares = rows.map(|(row, _)| row.high_share);
        let passed = arrivals.into_iter().zip(shares);
        let passed = passed.map(|(arrival, high_share)| Passed {
            arrival,
            high_share,
        });
        passed.collect()
    }
}

/// The front's shares as a result. `defined` marks the sites with energy. None where most sites move from the first sample on, or
/// before the wave arrives: windows there hold noise.
pub(super) fn gather(
    plan: &Plan,
    length: Option<FrontWindow>,
    passed: &[Passed],
    defined: &[bool],
    reference: Option<usize>,
    windows: Option<&ArrivalWindows>,
) -> Front {
    let time = &plan.axes.time;
    let arrival = |(passed, defined): (&Passed, &bool)| passed.arrival.filter(|_| *defined);
    let mut arrivals: Vec<Option<usize>> = passed.iter().zip(defined).map(arrival).collect();
    let is_early = |(site, first): (usize, &Option<usize>)| {
        let comes = windows.and_then(|of| Some((of.arrivals[site]? as f64, of.width)));
        let is_before = |first: f64| comes.is_some_and(|(at, width)| at - first > width);
        first.is_some_and(|first| first == 0 || is_before(first as f64))
    };
    let at_once = arrivals.iter().enumerate();
    let at_once = at_once.filter(|of| is_early(*of)).count();
    let sites = defined.iter().filter(|defined| **defined).count();
    let length = length.filter(|_| 2 * at_once <= sites);
    if length.is_none() {
        arrivals = vec![None; plan.axes.n_sites];
    }
    let fits = |n: usize| length.is_some_and(|of| n + of.samples <= plan.axes.n_times);
    let fits = arrivals.iter().map(|arrival| arrival.is_some_and(fits));
    let fits: Vec<bool> = fits.collect();
    let share = |(site, fits): (usize, &bool)| match fits {
        true => passed[site].high_share,
        false => f64::NAN,
    };
    let high_share: Vec<f64> = fits.iter().enumerate().map(share).collect();
    let at = |of: &Option<usize>| of.map_or(f64::NAN, |n| time.at(n));
    Front {
        length,
        arrival: arrivals.iter().map(at).collect(),
        headline: Headline::of(&high_share, &fits, &fits, reference, |row| plan.place(row)),
        high_share,
        fits,
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
        let records = triangle(10, 40).into_iter().zip(negative);
        let interleaved: Vec<f64> = records.flat_map(|(a, b)| [a, b, 0.0]).collect();
        assert_eq!(arrivals(&interleaved, 3), [Some(11), Some(4), None]);
    }

    #[test]
    fn quick_lengths_are_the_next_without_large_factors() {
        assert_eq!([1, 7, 11, 24, 121].map(quick), [1, 8, 12, 24, 125]);
    }
}
