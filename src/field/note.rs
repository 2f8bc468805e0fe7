//! Notes: properties inferred about a file that does not state them.

use super::coordinates::{Coordinates, Jitter};
use super::interpolate::Interpolation;
use super::meaning::of_unit;
use super::storage::Storage;
use super::{Axis, Layout, Quantity};
use crate::measure::{Frequency, Length, Time, digits, symbol};
use crate::unit::unknown_word;

/// Change of amplitudes by resampling, at half the Nyquist frequency, above which spectra are doubtful.
pub(super) const LOSS: f64 = 0.05;

/// A conclusion about a file, with how to state otherwise.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// A variable of a file that was taken for the field, and the names of its times and positions.
    Variable {
        path: String,
        time: Option<String>,
        space: Option<String>,
    },
    /// The time of the first sample, from which times count.
    Start { time: String },
    /// Traces that begin at different times, which were read as beginning at one.
    Delays,
    /// Coordinates that are even but for a jitter.
    Jitter { axis: &'static str, jitter: Jitter },
    /// Coordinates that are even to the precision of the numbers that hold them, which is coarse.
    Rounded { axis: &'static str, jitter: Jitter },
    /// What else was concluded, or is doubted.
    Told {
        code: &'static str,
        text: String,
        is_doubtful: bool,
    },
    /// Samples at uneven coordinates that were brought to even ones.
    Resampled {
        axis: &'static str,
        method: Interpolation,
        /// The largest distance of a sample from the place of its index on the even axis.
        shift: Jitter,
        /// The largest [`Interpolation::error`].
        error: f64,
    },
    /// The first column of a table was taken for times (or positions) since it rises evenly.
    FirstColumn { layout: Layout, step: f64 },
    /// An array of at least eight times as many columns as rows was taken for `(time, site)`.
    Wide { rows: usize, columns: usize },
    /// The first site of an array rises evenly, as times do.
    RisingSite { step: f64 },
    /// A unit of samples, times or positions (`what`) that is none, or one of something else.
    Unit {
        code: &'static str,
        what: &'static str,
        text: String,
    },
}

impl Note {
    /// What the user can do about it.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            Note::Delays => Some("take the times that all have in common with `--delays align`"),
            Note::Resampled { .. }
            | Note::Told {
                code: "aligned", ..
            } if self.is_doubtful() => Some(
                "where high frequencies or wavenumbers count, use `--resample cubic`, or sample evenly",
            ),
            Note::FirstColumn { .. } => Some("where it holds samples, state `--time-column none`"),
            Note::Wide { .. } => Some(
                "state one of them, or save the times with the array: `numpy.savez(path, v=array, t=times)`",
            ),
            Note::RisingSite { .. } => Some(
                "if it holds times, save the array without it and state `--dt`, or save the times \
                 apart: `numpy.savez(path, v=array, t=times)`",
            ),
            Note::Unit { what, .. } => Some(match *what {
                "times" => {
                    "state `--time-unit`, such as s, or `--layout` if the axes are exchanged"
                }
                "positions" => {
                    "state `--space-unit`, such as m, or `--layout` if the axes are exchanged"
                }
                _ => "state `--unit`, such as m/s, or `--quantity`",
            }),
            _ => None,
        }
    }

    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        self.kind().0
    }

    /// Whether the conclusion may be wrong.
    pub fn is_doubtful(&self) -> bool {
        self.kind().1
    }

    /// Its name, and whether it may be wrong.
    fn kind(&self) -> (&'static str, bool) {
        match self {
            Note::Variable { .. } => ("variable", false),
            Note::Start { .. } => ("start", false),
            Note::Delays => ("delays", true),
            Note::Jitter { .. } => ("jitter", false),
            Note::Rounded { .. } => ("rounded", false),
            Note::Told {
                code, is_doubtful, ..
            } => (*code, *is_doubtful),
            Note::Resampled { error, .. } => ("resampled", *error > LOSS),
            Note::FirstColumn { .. } => ("first-column", false),
            Note::Wide { .. } => ("wide-array", true),
            Note::RisingSite { .. } => ("rising-site", true),
            Note::Unit { code, .. } => (*code, true),
        }
    }

    /// The inference as one sentence.
    pub fn message(&self) -> String {
        match self {
            Note::Variable { path, time, space } => {
                let of = |name: &Option<String>, what| {
                    let name = name.as_ref();
                    name.map_or(String::new(), |name| format!(", `{name}` its {what}"))
                };
                let (times, sites) = (of(time, "times"), of(space, "sites"));
                format!("variable `{path}` is the field{times}{sites}")
            }
            Note::Start { time } => format!("times count from {time}"),
            Note::Delays => {
                "the traces begin at different times and are read as if they began at one".into()
            }
            Note::Jitter { axis, jitter } | Note::Rounded { axis, jitter } => {
                let how = match self {
                    Note::Jitter { .. } => "taken as even;",
                    _ => "even to the precision of their numbers, which is coarse:",
                };
                let (index, share) = (jitter.index, of_step(jitter.share));
                format!(
                    "the {axis} coordinates are {how} index {index} deviates by {share} of a step, which is \
                     the most"
                )
            }
            Note::Told { text, .. } | Note::Unit { text, .. } => text.clone(),
            Note::Resampled {
                axis,
                method,
                shift,
                error,
            } => resampled(axis, *method, shift, *error),
            Note::FirstColumn { layout, step } => {
                let what = match layout {
                    Layout::TimeSite => "times",
                    Layout::SiteTime => "positions",
                };
                let step = digits(*step);
                format!("the first column holds the {what}, since it rises evenly by {step}")
            }
            Note::Wide { rows, columns } => format!(
                "nothing states which axis is time: `--layout time-site` reads {rows} times of {columns} sites, \
                 `--layout site-time` {columns} times of {rows} sites"
            ),
            Note::RisingSite { step } => format!(
                "the first site rises evenly by {}, as a column of times does",
                digits(*step)
            ),
        }
    }

    /// What was concluded.
    pub(super) fn told(code: &'static str, text: impl Into<String>) -> Note {
        Note::Told {
            code,
            text: text.into(),
            is_doubtful: false,
        }
    }

    /// What is doubted.
    pub(super) fn doubt(code: &'static str, text: impl Into<String>) -> Note {
        Note::Told {
            code,
            text: text.into(),
            is_doubtful: true,
        }
    }

    /// Notes on the units of the samples and of both axes.
    pub(super) fn on_units(
        quantity: Quantity,
        unit: Option<&str>,
        [time, space]: [&Axis; 2],
    ) -> Vec<Note> {
        let is = |symbol: Option<&str>, what| symbol.map(|_| what);
        let samples = on_unit(quantity.in_words(), unit, |unit| match of_unit(unit) {
            Some(found) => (found != quantity).then(|| found.in_words()),
            None => is(symbol::<Time>(unit), "time")
                .or_else(|| is(symbol::<Frequency>(unit), "frequency")),
        });
        let times = on_unit("times", time.unit.as_deref(), |unit| {
            is(symbol::<Length>(unit), "length")
        });
        let positions = on_unit("positions", space.unit.as_deref(), |unit| {
            is(symbol::<Time>(unit), "time")
        });
        [samples, times, positions].into_iter().flatten().collect()
    }

    /// A note on an array without a stated layout.
    pub(super) fn on_shape(rows: usize, columns: usize) -> Option<Note> {
        (columns > rows).then_some(Note::Wide { rows, columns })
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
        match fit(1, 1.0) {
            None => Some(Note::RisingSite { step }),
            Some(_) => None,
        }
    }
}

/// A note on a unit that is of something else, or that has a word that is no unit.
fn on_unit(
    what: &'static str,
    unit: Option<&str>,
    other: impl Fn(&str) -> Option<&'static str>,
) -> Option<Note> {
    let unit = unit?;
    let (code, text) = match other(unit) {
        Some(of) => (
            "other-unit",
            format!("{unit} is a unit of {of}, and not of {what}"),
        ),
        None => {
            let word = unknown_word(unit)?;
            (
                "unknown-unit",
                format!("{word:?} in the unit of {what} is no unit that is known"),
            )
        }
    };
    Some(Note::Unit { code, what, text })
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

/// What resampling has done.
fn resampled(axis: &str, method: Interpolation, shift: &Jitter, error: f64) -> String {
    let nyquist = match axis {
        "time" => "frequency",
        _ => "wavenumber",
    };
    let effect = match method {
        Interpolation::Nearest => "are off by up to",
        Interpolation::Linear | Interpolation::Cubic => "lose up to",
    };
    format!(
        "samples are resampled to even {axis} coordinates ({} interpolation); index {} was {} of a step \
         off its place, which is the most; amplitudes at half the Nyquist {nyquist} {effect} {} %",
        method.name(),
        shift.index,
        of_step(shift.share),
        digits((error * 1e3).round() / 10.0)
    )
}
