//! Notes: properties inferred about a file that does not state them.

use super::Layout;
use super::coordinates::{Coordinates, Jitter};
use super::storage::Storage;
use crate::measure::digits;

/// Ratio of columns to rows above which it is doubtful that rows are times.
pub(super) const WIDE: usize = 8;

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
    /// The layout that the lengths of the coordinates leave.
    Layout { layout: Layout },
    /// The first column of a table was taken for times (or positions) since it rises evenly.
    FirstColumn { layout: Layout, step: f64 },
    /// An array of at least eight times as many columns as rows was taken for `(time, site)`.
    Wide { rows: usize, columns: usize },
    /// The first site of an array rises evenly, as times do.
    RisingSite { step: f64 },
}

impl Note {
    /// Stable name, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Note::Members { .. } => "members",
            Note::Variable { .. } => "variable",
            Note::Start { .. } => "start",
            Note::Delays => "delays",
            Note::Jitter { .. } => "jitter",
            Note::Layout { .. } => "layout",
            Note::FirstColumn { .. } => "first-column",
            Note::Wide { .. } => "wide-array",
            Note::RisingSite { .. } => "rising-site",
        }
    }

    /// The inference as one sentence.
    pub fn message(&self) -> String {
        match self {
            Note::Members { field, time, space } => {
                let mut text = format!("member `{field}` is the field");
                for (member, what) in [(time, "times"), (space, "positions")] {
                    if let Some(member) = member {
                        text += &format!(", `{member}` its {what}");
                    }
                }
                text
            }
            Note::Variable { path, time, space } => {
                let mut text = format!("variable `{path}` is the field");
                for (name, what) in [(time, "times"), (space, "sites")] {
                    if let Some(name) = name {
                        text += &format!(", `{name}` its {what}");
                    }
                }
                text
            }
            Note::Start { time } => format!("times count from {time}"),
            Note::Delays => {
                "the traces begin at different times and are read as if they began at one".into()
            }
            Note::Jitter { axis, jitter } => format!(
                "the {axis} coordinates are taken as even; index {} deviates by {} of a step, which is \
                 the most",
                jitter.index,
                digits((jitter.share * 1e4).round() / 1e4)
            ),
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
                "the {rows} rows of the array are read as times and its {columns} columns as sites, \
                 which nothing states"
            ),
            Note::RisingSite { step } => format!(
                "the first site rises evenly by {}, as a column of times does",
                digits(*step)
            ),
        }
    }

    /// Whether the conclusion may be wrong.
    pub fn is_doubtful(&self) -> bool {
        matches!(
            self,
            Note::Delays | Note::Wide { .. } | Note::RisingSite { .. }
        )
    }

    /// A note on an array without a stated layout.
    pub(super) fn on_shape(rows: usize, columns: usize) -> Option<Note> {
        (columns >= WIDE * rows).then_some(Note::Wide { rows, columns })
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
