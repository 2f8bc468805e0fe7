//! What all averages say of themselves.

use ndarray::Array2;
use serde_json::{Value, json};

use super::{Independence, SegmentsLeft, interval_factors};
use crate::numeric::sorted;
use crate::sheet::{Sheet, Table, Warning, confidence, listed, number, percent, terms, with_range};

const DEFINITIONS: &str = "\
    Independent realisations: Segments, tapers and records that are averaged, less what overlapping segments share. The \
        segments of a transient are not independent: then the records alone count.
    Transient: A record whose energy lies in a few of its parts is one realisation; only several records give it an interval.";

/// Sites that a warning names at most.
const NAMED: usize = 8;

impl Independence {
    /// Says what is averaged: numbers, a warning where it is one realisation, and a table.
    pub(crate) fn describe(&self, sheet: &mut Sheet, [segment, overlap]: [usize; 2]) {
        sheet.numbers(json!({
            "segment": segment,
            "overlap": overlap,
            "independence": self,
        }));
        let rows = [
            ("records", self.records.to_string()),
            ("segments of a record", self.segments.to_string()),
            ("tapers", self.tapers.to_string()),
            ("samples a segment", segment.to_string()),
            ("effective realisations", number(self.effective)),
        ];
        sheet.tables.push(Table::of_values("Averages", rows));
        let is_one = self.is_transient() && self.records < 2;
        sheet.warnings.extend(is_one.then(|| self.warning()));
        sheet.definitions.extend(terms(DEFINITIONS));
    }

    /// Why no significance is stated, where none is.
    pub(crate) fn why_none(&self) -> &'static str {
        match self.is_transient() {
            true => self.why(),
            false => "there are fewer than two independent realisations",
        }
    }

    /// A level that chance exceeds with probability `alpha`, or why there is none.
    pub(crate) fn level_in_words(&self, level: Option<f64>, alpha: f64) -> String {
        match level {
            Some(level) => format!("{} at {}", number(level), percent(alpha)),
            None => format!("not stated: {}", self.why_none()),
        }
    }

    /// What to say of one realisation.
    pub(crate) fn warning(&self) -> Warning {
        let why = self.why();
        let advice = match self.steadiness.is_nan() && !self.is_short {
            true => "leave out segments with gaps (`--gaps leave-out`, where the command can)",
            false => "name several records of the same sites, one a shot",
        };
        let message = format!("{why}: no level of chance and no interval is stated");
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
            let named: Vec<String> = empty.iter().take(NAMED).map(usize::to_string).collect();
            let (count, named) = (empty.len(), listed(&named));
            let message =
                format!("{count} {columns} miss samples in all segments, such as {named}");
            sheet.warn(message, "shorter segments (`--segment`) lose less to a gap");
        }
    }

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

impl Sheet<'_> {
    /// The interval by these degrees of freedom (least, median, most): a fact, the note, and numbers.
    pub(crate) fn degrees_of_freedom(&mut self, degrees: Option<[f64; 3]>, alpha: f64) {
        let (text, numbers) = match degrees {
            None => ("none can be stated".into(), Value::Null),
            Some([least, median, largest]) => {
                let factors = interval_factors(median, alpha);
                let ([low, high], share) = (factors.map(number), confidence(alpha));
                let degrees = with_range(least, median, largest);
                let text = format!(
                    "{share} from {low} to {high} of a value, {degrees} degrees of freedom"
                );
                let numbers = json!({
                    "least": least,
                    "median": median,
                    "largest": largest,
                    "interval_factors": factors,
                });
                (text, numbers)
            }
        };
        self.note = format!("Interval: {text}.");
        self.fact("interval", text);
        self.numbers(json!({ "alpha": alpha, "degrees_of_freedom": numbers }));
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
