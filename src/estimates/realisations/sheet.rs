//! What all averages say of themselves.

use ndarray::Array2;
use serde_json::{Value, json};

use super::{Independence, SegmentsLeft, interval_factors};
use crate::numeric::sorted;
use crate::sheet::{BLUE, Chart, Series, Sheet, Table, Warning, confidence, number, with_range};

/// What independent realisations are.
pub(crate) const REALISATIONS: [&str; 2] = [
    "Independent realisations",
    "Segments, tapers and records that are averaged, less what overlapping segments share. The segments of a transient \
     are not independent: then the records alone count.",
];

/// What a transient is.
pub(crate) const TRANSIENT: [&str; 2] = [
    "Transient",
    "A record whose energy lies in a few of its parts is one realisation; only several records give it an interval.",
];

/// Sites that a warning names at most.
const NAMED: usize = 8;

impl Independence {
    /// Says what is averaged: numbers, a detail, and a table that ends with these rows.
    pub(crate) fn describe(
        &self,
        sheet: &mut Sheet,
        [segment, overlap]: [usize; 2],
        further: impl IntoIterator<Item = (&'static str, String)>,
    ) {
        sheet.numbers(json!({
            "segment": segment,
            "overlap": overlap,
            "independence": self,
        }));
        let counts = [self.records, self.segments, self.tapers];
        let [records, segments, tapers] = counts.map(|count| count.to_string());
        let effective = number(self.effective);
        let text = format!(
            "records {records}, segments {segments} of {segment} samples, tapers {tapers}: {effective} effective \
             realisations"
        );
        sheet.detail("averages", text);
        let rows = [
            ("records", records),
            ("segments of a record", segments),
            ("tapers", tapers),
            ("samples a segment", segment.to_string()),
            ("effective realisations", effective),
        ];
        let rows = rows.into_iter().chain(further);
        sheet.tables.push(Table::of_values("Averages", rows));
    }

    /// Why no significance is stated of a `what`, where none is.
    pub(crate) fn why_none(&self) -> &'static str {
        match self.is_transient() {
            true => self.why(),
            false => "there are fewer than two independent realisations",
        }
    }

    /// What to say of a `what` that is one realisation by itself.
    pub(crate) fn alone(&self, what: &str) -> Option<Warning> {
        (self.is_transient() && self.records < 2).then(|| self.transient(what))
    }

    /// Why a `what` by itself has no errors.
    pub(crate) fn transient(&self, what: &str) -> Warning {
        let why = self.why();
        let (message, advice) = match self.steadiness.is_nan() {
            _ if self.is_short => (
                format!("{why}: no level of chance and no interval is stated"),
                "record for longer, or name several records of the same sites",
            ),
            true => (
                format!("{why} of the {what}: no level of chance and no interval is stated"),
                "choose records with fewer gaps, or leave out the segments that have them (`--gaps leave-out`), where the \
                 command can",
            ),
            false => {
                let steadiness = number(self.steadiness);
                let message = format!(
                    "the {what} is a transient (steadiness {steadiness}): its segments are not independent"
                );
                (
                    message,
                    "name several records of the same sites, one a shot",
                )
            }
        };
        Warning::new(message, advice)
    }
}

impl SegmentsLeft {
    /// How many segments are left of columns (sites or times) that miss samples.
    pub(crate) fn describe(&self, sheet: &mut Sheet, columns: &str) {
        let (incomplete, all, of) = (self.incomplete(), self.left.len(), self.of);
        if incomplete > 0 {
            let [least, median] = self.least_and_median();
            let text = format!(
                "{incomplete} of {all} {columns} lose segments: {median} of {of} are left at the median, {least} at the least"
            );
            sheet.fact("gaps", text);
        }
        let empty = self.empty();
        if !empty.is_empty() {
            let shown: Vec<String> = empty.iter().take(NAMED).map(usize::to_string).collect();
            let (count, shown) = (empty.len(), shown.join(", "));
            let more = if count > NAMED { ", ..." } else { "" };
            let message = format!(
                "{count} of {all} {columns} miss samples in all {of} segments and are left out: {shown}{more}"
            );
            sheet.warn(message, "shorter segments (`--segment`) lose less to a gap");
        }
    }
}

impl SegmentsLeft {
    pub(crate) fn variables<'a>(&'a self, sheet: &mut Sheet<'a>, columns: &str) {
        let segments: Vec<f64> = self.left.iter().map(|left| *left as f64).collect();
        sheet.line("segments", columns, "", segments);
        sheet.line("effective_realisations", columns, "", &self.effective);
    }
}

/// The least, the median and the largest of the finite ones; `None` where there are none.
pub(crate) fn least_median_most(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let sorted = sorted(values.filter(|v| v.is_finite()));
    let last = sorted.len().checked_sub(1)?;
    Some([sorted[0], sorted[last / 2], sorted[last]])
}

/// The interval by these degrees of freedom (least, median, most), in words.
pub(crate) fn interval_in_words(degrees: Option<[f64; 3]>, alpha: f64) -> String {
    let Some([least, median, most]) = degrees else {
        return "none can be stated".into();
    };
    let [low, high] = interval_factors(median, alpha).map(number);
    let (confidence, degrees) = (confidence(alpha), with_range(least, median, most));
    format!("{confidence} from {low} to {high} of a value, {degrees} degrees of freedom")
}

/// The same as numbers; `null` where none can be stated.
pub(crate) fn degrees_as_numbers(degrees: Option<[f64; 3]>, alpha: f64) -> Value {
    match degrees {
        Some([least, median, largest]) => json!({
            "least": least,
            "median": median,
            "largest": largest,
            "interval_factors": interval_factors(median, alpha),
        }),
        None => Value::Null,
    }
}

/// Decades that a chart of a spectrum shows at most.
const DECADES: f64 = 10.0;

/// A spectrum over its bins on a logarithmic axis, with its interval of this name where it has one.
pub(crate) fn spectrum_chart(
    title: impl Into<String>,
    (x_label, x): (String, &[f64]),
    y_label: String,
    [spectrum, low, high]: [&[f64]; 3],
    interval: String,
) -> Chart {
    let mut line = Series::of("", BLUE, x, spectrum);
    if low.iter().any(|v| v.is_finite()) {
        let ends = low.iter().copied().zip(high.iter().copied());
        line = line.with_band(interval, ends.collect());
    }
    let values = [spectrum, low, high].into_iter().flatten().copied();
    let positive: Vec<f64> = values.filter(|v| v.is_finite() && *v > 0.0).collect();
    let largest = positive.iter().copied().fold(0.0, f64::max);
    let least = positive.iter().copied().fold(f64::INFINITY, f64::min);
    Chart {
        y: match largest > 0.0 {
            true => 0.7 * least.max(largest * 10.0_f64.powf(-DECADES))..1.4 * largest,
            false => 0.1..1.0,
        },
        log_y: true,
        ..Chart::of(title, x_label, y_label, vec![line])
    }
}

/// The values of a map without those at 0, if nothing is estimated there.
pub(crate) fn without_mean(values: &Array2<f64>, is_removed: bool) -> Array2<f64> {
    let mut values = values.clone();
    if is_removed {
        values.row_mut(0).fill(f64::NAN);
    }
    values
}
