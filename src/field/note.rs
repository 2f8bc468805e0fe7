//! Notes: properties inferred about a file that does not state them.

use super::coordinates::{Coordinates, Jitter};
use super::interpolate::Interpolation;
use super::meaning::of_unit;
use super::storage::Storage;
use super::{Axis, Quantity};
use crate::measure::{Frequency, Length, Time, digits, symbol};
use crate::unit::unknown_word;

/// Change of amplitudes by resampling, at half the Nyquist frequency, above which spectra are doubtful.
const LOSS: f64 = 0.05;

/// A conclusion about a file, with how to state otherwise.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Note {
    /// Stable name, for programs.
    pub code: &'static str,
    /// The conclusion as one sentence.
    pub text: String,
    /// Whether it may be wrong.
    pub is_doubtful: bool,
    /// What the user can do about it.
    pub advice: Option<&'static str>,
}

impl Note {
    /// What was concluded.
    pub(super) fn told(code: &'static str, text: impl Into<String>) -> Note {
        Note {
            code,
            text: text.into(),
            is_doubtful: false,
            advice: None,
        }
    }

    /// What is doubted.
    pub(super) fn doubt(code: &'static str, text: impl Into<String>) -> Note {
        Note {
            is_doubtful: true,
            ..Note::told(code, text)
        }
    }

    /// The same with what to do about it.
    pub(super) fn advising(self, advice: &'static str) -> Note {
        Note {
            advice: Some(advice),
            ..self
        }
    }

    /// The time of the first sample, from which times count.
    pub(super) fn start(time: &str) -> Note {
        Note::told("start", format!("times count from {time}"))
    }

    /// A change of amplitudes by interpolation, doubtful where it is large.
    pub(super) fn interpolated(code: &'static str, text: String, error: f64) -> Note {
        let advice =
            "where high frequencies or wavenumbers count, use `--resample cubic`, or sample evenly";
        match error > LOSS {
            true => Note::doubt(code, text).advising(advice),
            false => Note::told(code, text),
        }
    }

    /// Coordinates that are even but for a jitter, or to the precision of the numbers that hold them.
    pub(super) fn jitter(axis: &str, jitter: Jitter, is_rounding: bool) -> Note {
        let coarse = "even to the precision of their numbers, which is coarse:";
        let (code, how) = match is_rounding {
            true => ("rounded", coarse),
            false => ("jitter", "taken as even;"),
        };
        let (index, share) = (jitter.index, of_step(jitter.share));
        let text = format!(
            "the {axis} coordinates are {how} index {index} deviates by {share} of a step, which is the most"
        );
        Note::told(code, text)
    }

    /// Notes on the units of the samples and of both axes.
    pub(super) fn on_units(
        quantity: Quantity,
        unit: Option<&str>,
        [time, space]: [&Axis; 2],
    ) -> Vec<Note> {
        let is = |symbol: Option<&str>, what| symbol.map(|_| what);
        let is_time = |unit: &str| is(symbol::<Time>(unit), "time");
        let is_length = |unit: &str| is(symbol::<Length>(unit), "length");
        let is_other = |unit: &str| match of_unit(unit) {
            Some(found) => (found != quantity).then(|| found.in_words()),
            None => is_time(unit).or_else(|| is(symbol::<Frequency>(unit), "frequency")),
        };
        let samples = on_unit(quantity.in_words(), unit, is_other);
        let times = on_unit("times", time.unit.as_deref(), is_length);
        let positions = on_unit("positions", space.unit.as_deref(), is_time);
        [samples, times, positions].into_iter().flatten().collect()
    }

    /// A note on an array without a stated layout.
    pub(super) fn on_shape(rows: usize, columns: usize) -> Option<Note> {
        let text = format!(
            "nothing states which axis is time: `--layout time-site` reads {rows} times of {columns} sites, \
             `--layout site-time` {columns} times of {rows} sites"
        );
        let advice = "state one of them, or save the times with the array: `numpy.savez(path, v=array, t=times)`";
        (columns > rows).then(|| Note::doubt("wide-array", text).advising(advice))
    }

    /// A note on samples whose first site rises evenly where the second one does not.
    pub(super) fn on_samples(storage: &Storage, n_times: usize, n_sites: usize) -> Option<Note> {
        // Few samples rise evenly by chance, and more than 64 need no check.
        const LOOKED_AT: std::ops::RangeInclusive<usize> = 8..=64;
        let n = n_times.min(*LOOKED_AT.end());
        if n < *LOOKED_AT.start() || n_sites < 2 {
            return None;
        }
        let fit = |site: usize, rounding: f64| {
            let mut record = vec![0.0; n];
            storage.read(0..n, site..site + 1, false, &mut record);
            let largest = record.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
            Coordinates::fit(&record, largest * rounding).ok()
        };
        let step = fit(0, storage.relative_rounding())?.step?;
        let step = digits(step);
        let text = format!("the first site rises evenly by {step}, as a column of times does");
        let advice = "if it holds times, save the array without it and state `--dt`, or save the times \
                      apart: `numpy.savez(path, v=array, t=times)`";
        let is_alone = fit(1, 1.0).is_none();
        is_alone.then(|| Note::doubt("rising-site", text).advising(advice))
    }
}

/// A note on a unit that is of something else, or that has a word that is no unit.
fn on_unit(
    what: &'static str,
    unit: Option<&str>,
    other: impl Fn(&str) -> Option<&'static str>,
) -> Option<Note> {
    let unit = unit?;
    let note = match other(unit) {
        Some(of) => {
            let text = format!("{unit} is a unit of {of}, and not of {what}");
            Note::doubt("other-unit", text)
        }
        None => {
            let word = unknown_word(unit)?;
            let text = format!("{word:?} in the unit of {what} is no unit that is known");
            Note::doubt("unknown-unit", text)
        }
    };
    Some(note.advising(match what {
        "times" => "state `--time-unit`, such as s, or `--layout` if the axes are exchanged",
        "positions" => "state `--space-unit`, such as m, or `--layout` if the axes are exchanged",
        _ => "state `--unit`, such as m/s, or `--quantity`",
    }))
}

/// A unit behind a number.
pub(super) fn spaced(unit: &Option<String>) -> String {
    unit.as_ref()
        .map_or(String::new(), |unit| format!(" {unit}"))
}

/// Two digits of a share of a step, however small.
fn of_step(share: f64) -> String {
    digits(format!("{share:.1e}").parse().unwrap_or(share))
}

/// Samples at uneven coordinates that were brought to even ones: the largest distance of a sample from the place of its
/// index, and the largest [`Interpolation::error`].
pub(super) fn resampled(axis: &str, method: Interpolation, shift: Jitter, error: f64) -> Note {
    let nyquist = match axis {
        "time" => "frequency",
        _ => "wavenumber",
    };
    let effect = match method {
        Interpolation::Nearest => "are off by up to",
        Interpolation::Linear | Interpolation::Cubic => "lose up to",
    };
    let text = format!(
        "samples are resampled to even {axis} coordinates ({} interpolation); index {} was {} of a step \
         off its place, which is the most; amplitudes at half the Nyquist {nyquist} {effect} {} %",
        method.name(),
        shift.index,
        of_step(shift.share),
        digits((error * 1e3).round() / 10.0)
    );
    Note::interpolated("resampled", text, error)
}
