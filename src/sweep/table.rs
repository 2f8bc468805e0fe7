//! The table of a sweep: one row for each member, in the order of the product.

use super::axis;
use super::measures::Measures;
use super::request::{Outcome, Outcomes, Request};

/// The columns after those of the varied keys.
fn measures() -> Result<Vec<String>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.serialize(Measures::default())?;
    let text = writer.into_inner().map_err(|error| error.into_error())?;
    let mut reader = csv::Reader::from_reader(&text[..]);
    Ok(reader.headers()?.iter().map(str::to_owned).collect())
}

/// The table as CSV: the varied keys, the [`Measures`], and why a member failed. Numbers have all
/// their digits; unknown values are empty.
pub(super) fn csv(request: &Request, outcomes: &Outcomes) -> Result<String, csv::Error> {
    let columns = measures()?;
    let keys = request.vary.iter().map(|axis| axis.key.clone());
    let header = keys
        .chain(columns.iter().cloned())
        .chain(["failure".to_owned()]);
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer.write_record(header)?;
    for (&member, outcome) in outcomes {
        let values = axis::member(&request.vary, member);
        match outcome {
            Outcome::Done(measures) => writer.serialize((values, measures, ""))?,
            Outcome::Failed(reason) => {
                let unknown = columns.iter().map(|_| "");
                writer.write_record(values.into_iter().chain(unknown).chain([reason.as_str()]))?;
            }
        }
    }
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
