//! Records that begin at different times, on one axis of time.

use super::Note;
use super::interpolate::{Interpolant, Interpolation};
use crate::measure::digits;

/// Where a record begins against the first one, in steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Shift {
    pub(super) whole: i64,
    /// What is resampled beyond it.
    pub(super) fraction: f64,
    /// What is neither.
    pub(super) left: f64,
}

impl Shift {
    /// `shift` in parts; without a method, one that is not within `jitter` of a whole number has none.
    pub(super) fn of(shift: f64, jitter: f64, method: Option<Interpolation>) -> Option<Shift> {
        let whole = shift.round();
        let rest = shift - whole;
        let whole = (whole.abs() < 1e15).then_some(whole as i64)?;
        let is_whole = rest.abs() <= jitter.max(1e-6);
        let (fraction, left) = match (is_whole, method) {
            (true, _) => (0.0, rest),
            (false, Some(_)) => (rest, 0.0),
            (false, None) => return None,
        };
        Some(Shift {
            whole,
            fraction,
            left,
        })
    }

    pub(super) fn total(self) -> f64 {
        self.whole as f64 + self.fraction + self.left
    }
}

/// The shifts of all records, and the times that they have in common.
#[derive(Debug)]
pub(super) struct Alignment {
    pub(super) shifts: Vec<Shift>,
    lengths: Vec<usize>,
    /// First common time, in steps from the start of the first record.
    pub(super) start: i64,
    pub(super) n_times: usize,
    method: Option<Interpolation>,
}

/// Two records without two times in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Apart {
    /// The one that ends first.
    pub(super) early: usize,
    /// The one that begins last.
    pub(super) late: usize,
}

impl Alignment {
    /// Of records with these shifts and lengths; `method` interpolates fractions of a step.
    pub(super) fn new(
        shifts: Vec<Shift>,
        lengths: Vec<usize>,
        method: Option<Interpolation>,
    ) -> Result<Alignment, Apart> {
        let begin = |n: usize| shifts[n].whole + i64::from(shifts[n].fraction > 0.0);
        let end =
            |n: usize| shifts[n].whole + lengths[n] as i64 - i64::from(shifts[n].fraction < 0.0);
        let all = 0..lengths.len();
        let late = all.clone().max_by_key(|&n| begin(n)).unwrap_or(0);
        let early = all.min_by_key(|&n| end(n)).unwrap_or(0);
        let (start, end) = (begin(late), end(early));
        if end - start < 2 {
            return Err(Apart { early, late });
        }
        Ok(Alignment {
            shifts,
            lengths,
            start,
            n_times: (end - start) as usize,
            method,
        })
    }

    /// The common part of record `n`, of which `read` copies samples from an index on.
    pub(super) fn record(&self, n: usize, read: impl FnOnce(usize, &mut [f64]), out: &mut [f64]) {
        let shift = self.shifts[n];
        let from = self.start - shift.whole;
        let Some(method) = self.method.filter(|_| shift.fraction != 0.0) else {
            return read(from as usize, out);
        };
        let all = self.lengths[n];
        let mut samples = vec![0.0; all];
        read(0, &mut samples);
        let from = from as f64 - shift.fraction;
        let places = (0..self.n_times).map(|i| from + i as f64);
        let nodes = (0..all).map(|i| i as f64).collect();
        Interpolant::new(method, nodes, places).apply(&samples, out, &mut Vec::new());
    }

    /// What was done, if anything was: by `reference`, whose correlation coefficients are at least
    /// `correlation`, or by the times of the records.
    pub(super) fn note(&self, reference: Option<(&str, f64)>) -> Option<Note> {
        let (shortest, longest) = (self.lengths.iter().min()?, self.lengths.iter().max()?);
        let delays = || self.shifts.iter().map(|shift| 0.0 - shift.total());
        let range = [delays().reduce(f64::min)?, delays().reduce(f64::max)?];
        if *longest == self.n_times && range == [0.0, 0.0] && reference.is_none() {
            return None;
        }
        let rounded = |value: f64| digits((value * 1e4).round() / 1e4);
        let by = reference.map(|(name, least)| {
            let least = rounded(least);
            format!("the delay of {name:?} (correlation coefficients from {least})")
        });
        let by = by.unwrap_or("their times".into());
        let lengths = match shortest == longest {
            true => shortest.to_string(),
            false => format!("{shortest} to {longest}"),
        };
        let [least, most] = range.map(rounded);
        let mut text = format!(
            "records are aligned by {by}; an event comes {least} to {most} samples later in a record than in the \
             first one, and {} of {lengths} times are in common",
            self.n_times
        );
        let largest = |of: fn(&Shift) -> f64| self.shifts.iter().map(of).fold(0.0, f64::max);
        let left = largest(|shift| shift.left.abs());
        let errors = |method: Interpolation| {
            let errors = self
                .shifts
                .iter()
                .map(|shift| method.error(shift.fraction.abs()));
            errors.fold(0.0, f64::max)
        };
        let error = self.method.map_or(0.0, errors);
        let is_resampled = largest(|shift| shift.fraction.abs()) > 0.0;
        if let Some(method) = self.method.filter(|_| is_resampled) {
            text += &format!(
                "; fractions of a sample are taken out by {} interpolation (amplitudes at half the Nyquist \
                 frequency change by up to {} %)",
                method.name(),
                digits((error * 1e3).round() / 10.0)
            );
        } else if left > 1e-4 {
            text += &format!("; up to {} of a sample is left", rounded(left));
        }
        Some(Note::interpolated("aligned", text, error))
    }
}
