//! Notes: properties inferred about a file that does not state them.

use super::coordinates::{Coordinates, Jitter};
use super::interpolate::Interpolation;
use super::labelled::of_unit;
use super::storage::Storage;
use super::{Axis, Layout, Quantity};
use crate::measure::{Frequency, Length, Time, digits, symbol};
use crate::unit::unknown_word;

/// Change of amplitudes by resampling, at half the Nyquist frequency, above which spectra are doubtful.
const LOSS: f64 = 0.05;

/// A conclusion about a file, with how to state otherwise.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Members of an archive that were taken for the field and its coordinates.
    Members {
        field: String,
        time: Option<String>,
        space: Option<String>,
    },
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
    /// A step, an origin or a unit that is stated beside the field, and where.
    Stated {
        place: String,
        text: String,
        what: &'static str,
    },
    /// A step that an option states in place of that of the file.
    Replaced {
        axis: &'static str,
        step: f64,
        of_file: f64,
        unit: Option<String>,
    },
    /// A doubt of the reader of a format.
    Remark { text: String },
    /// A dimension that is taken at a coordinate near the stated one.
    Nearest {
        dimension: String,
        index: u64,
        value: f64,
        unit: Option<String>,
        /// What was stated.
        stated: String,
    },
    /// A column of a table that counts its rows, which is no site.
    CountedRows { column: String },
    /// Rows before the names of the columns of a table, and before its numbers.
    Preamble { lines: usize },
    /// Commas in the numbers of a table are decimal signs.
    DecimalCommas,
    /// Samples at uneven coordinates that were brought to even ones.
    Resampled {
        axis: &'static str,
        method: Interpolation,
        /// The largest distance of a sample from the place of its index on the even axis.
        shift: Jitter,
        /// The largest [`Interpolation::error`].
        error: f64,
    },
    /// Files that became one field.
    Scan {
        files: usize,
        sites: usize,
        positions_from: String,
        /// First and last position.
        range: [f64; 2],
        unit: Option<String>,
    },
    /// Records of several files that were brought to common times.
    Aligned {
        /// The channel by which; `None` for the times of the files.
        reference: Option<String>,
        /// Smallest and largest delay against the first record, in samples.
        delays: [f64; 2],
        /// Smallest correlation coefficient of the references.
        correlation: Option<f64>,
        /// Samples of the shortest and of the longest record.
        lengths: [usize; 2],
        /// Samples in common.
        kept: usize,
        /// The largest share of a sample that is left.
        left: Jitter,
        /// By what fractions of a sample were taken out.
        resampled: Option<Interpolation>,
        /// The largest [`Interpolation::error`] of these.
        error: f64,
    },
    /// The layout that the lengths of the coordinates leave.
    Layout { layout: Layout },
    /// The first column of a table was taken for times (or positions) since it rises evenly.
    FirstColumn { layout: Layout, step: f64 },
    /// An array of at least eight times as many columns as rows was taken for `(time, site)`.
    Wide { rows: usize, columns: usize },
    /// The first site of an array rises evenly, as times do.
    RisingSite { step: f64 },
    /// A word in the unit of `what` that is no unit.
    UnknownUnit { what: &'static str, word: String },
    /// A unit of samples, times or positions that is one of something else.
    OtherUnit {
        what: &'static str,
        unit: String,
        of: &'static str,
    },
}

impl Note {
    /// What the user can do about it.
    pub fn advice(&self) -> Option<&'static str> {
        match self {
            Note::Delays => Some("take the times that all have in common with `--delays align`"),
            Note::Resampled { .. } | Note::Aligned { .. } if self.is_doubtful() => Some(
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
            Note::UnknownUnit { what, .. } | Note::OtherUnit { what, .. } => Some(match *what {
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
        match self {
            Note::Members { .. } => "members",
            Note::Variable { .. } => "variable",
            Note::Start { .. } => "start",
            Note::Delays => "delays",
            Note::Jitter { .. } => "jitter",
            Note::Rounded { .. } => "rounded",
            Note::Stated { .. } => "stated",
            Note::Replaced { .. } => "replaced",
            Note::Remark { .. } => "remark",
            Note::Nearest { .. } => "nearest",
            Note::CountedRows { .. } => "counted-rows",
            Note::Preamble { .. } => "preamble",
            Note::DecimalCommas => "decimal-commas",
            Note::Resampled { .. } => "resampled",
            Note::Scan { .. } => "scan",
            Note::Aligned { .. } => "aligned",
            Note::Layout { .. } => "layout",
            Note::FirstColumn { .. } => "first-column",
            Note::Wide { .. } => "wide-array",
            Note::RisingSite { .. } => "rising-site",
            Note::UnknownUnit { .. } => "unknown-unit",
            Note::OtherUnit { .. } => "other-unit",
        }
    }

    /// The inference as one sentence.
    pub fn message(&self) -> String {
        match self {
            Note::Members { field, time, space } => named(
                &format!("member `{field}`"),
                [(time, "times"), (space, "positions")],
            ),
            Note::Variable { path, time, space } => named(
                &format!("variable `{path}`"),
                [(time, "times"), (space, "sites")],
            ),
            Note::Start { time } => format!("times count from {time}"),
            Note::Delays => {
                "the traces begin at different times and are read as if they began at one".into()
            }
            Note::Jitter { axis, jitter } => format!(
                "the {axis} coordinates are taken as even; index {} deviates by {} of a step, which is \
                 the most",
                jitter.index,
                of_step(jitter.share)
            ),
            Note::Rounded { axis, jitter } => format!(
                "the {axis} coordinates are even to the precision of their numbers, which is coarse: index {} \
                 deviates by {} of a step, which is the most",
                jitter.index,
                of_step(jitter.share)
            ),
            Note::Stated { place, text, what } => format!("`{place}` = {text} is the {what}"),
            Note::Replaced {
                axis,
                step,
                of_file,
                unit,
            } => {
                let unit = spaced(unit);
                format!(
                    "the stated step of {axis}, {}{unit}, takes the place of that of the file, {}{unit}",
                    digits(*step),
                    digits(*of_file)
                )
            }
            Note::Remark { text } => text.clone(),
            Note::Nearest {
                dimension,
                index,
                value,
                unit,
                stated,
            } => {
                let unit = spaced(unit);
                let value = digits(*value);
                format!(
                    "`{dimension}` is taken at {value}{unit} (index {index}), the nearest to {stated}"
                )
            }
            Note::CountedRows { column } => {
                let column = match column.as_str() {
                    "" => "a column without a name".to_owned(),
                    name => format!("the column {name:?}"),
                };
                format!("{column} counts the rows and is left out")
            }
            Note::Preamble { lines: 1 } => {
                "the first row is read as a setting, not as names or samples".into()
            }
            Note::Preamble { lines } => {
                format!("the first {lines} rows are read as settings, not as names or samples")
            }
            Note::DecimalCommas => "commas in the numbers are decimal signs".into(),
            Note::Resampled {
                axis,
                method,
                shift,
                error,
            } => resampled(axis, *method, shift, *error),
            Note::Scan {
                files,
                sites,
                positions_from,
                range: [first, last],
                unit,
            } => {
                let (first, last) = (digits(*first), digits(*last));
                let unit = spaced(unit);
                let sites = match files == sites {
                    true => "one site a file".into(),
                    false => format!("{sites} sites, equal positions averaged"),
                };
                format!(
                    "{files} files are one field, {sites}; positions from {positions_from}, {first} to {last}{unit}"
                )
            }
            Note::Aligned { .. } => self.aligned(),
            Note::Layout { layout } => {
                let (rows, name) = match layout {
                    Layout::TimeSite => ("times", "time-site"),
                    Layout::SiteTime => ("sites", "site-time"),
                };
                format!("rows are {rows} by the lengths of the coordinates (layout {name})")
            }
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
            Note::UnknownUnit { what, word } => {
                format!("{word:?} in the unit of {what} is no unit that is known")
            }
            Note::OtherUnit { what, unit, of } => {
                format!("{unit} is a unit of {of}, and not of {what}")
            }
        }
    }

    /// What aligning records has done.
    fn aligned(&self) -> String {
        let Note::Aligned {
            reference,
            delays: [least, most],
            correlation,
            lengths: [shortest, longest],
            kept,
            left,
            resampled,
            error,
        } = self
        else {
            return String::new();
        };
        let rounded = |value: f64| digits((value * 1e4).round() / 1e4);
        let by = match (reference, correlation) {
            (Some(reference), Some(least)) => format!(
                "the delay of {reference:?} (correlation coefficients from {})",
                rounded(*least)
            ),
            _ => "their times".into(),
        };
        let lengths = match shortest == longest {
            true => shortest.to_string(),
            false => format!("{shortest} to {longest}"),
        };
        let mut text = format!(
            "records are aligned by {by}; an event comes {} to {} samples later in a record than in the first \
             one, and {kept} of {lengths} times are in common",
            rounded(*least),
            rounded(*most)
        );
        if let Some(method) = resampled {
            text += &format!(
                "; fractions of a sample are taken out by {} interpolation (amplitudes at half the Nyquist \
                 frequency change by up to {} %)",
                method.name(),
                digits((error * 1e3).round() / 10.0)
            );
        } else if left.share.abs() > 1e-4 {
            text += &format!("; up to {} of a sample is left", rounded(left.share.abs()));
        }
        text
    }

    /// Whether the conclusion may be wrong.
    pub fn is_doubtful(&self) -> bool {
        matches!(
            self,
            Note::Delays
                | Note::Remark { .. }
                | Note::Wide { .. }
                | Note::RisingSite { .. }
                | Note::UnknownUnit { .. }
                | Note::OtherUnit { .. }
        ) || matches!(self, Note::Resampled { error, .. } | Note::Aligned { error, .. } if *error > LOSS)
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
    if let Some(of) = other(unit) {
        let unit = unit.to_owned();
        return Some(Note::OtherUnit { what, unit, of });
    }
    let word = unknown_word(unit)?.to_owned();
    Some(Note::UnknownUnit { what, word })
}

/// What was taken for the field, and for its axes.
fn named(field: &str, axes: [(&Option<String>, &str); 2]) -> String {
    let mut text = format!("{field} is the field");
    for (name, what) in axes {
        if let Some(name) = name {
            text += &format!(", `{name}` its {what}");
        }
    }
    text
}

/// A unit behind a number.
fn spaced(unit: &Option<String>) -> String {
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
