//! The tables of a sweep as CSV: numbers have all their digits, unknown values are empty.

use super::ensemble::Ensemble;
use super::measures::Measures;
use super::request::{Outcome, Outcomes, Request};

type Writer = csv::Writer<Vec<u8>>;

/// One row for each member, in the order of the product: the varied keys, the [`Measures`], and why it failed.
pub(super) fn of_members(request: &Request, outcomes: &Outcomes) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.serialize(Measures::default())?;
    let text = writer.into_inner().map_err(|error| error.into_error())?;
    let mut reader = csv::Reader::from_reader(&text[..]);
    let measures = reader.headers()?;
    let keys = request.vary.iter().map(|axis| axis.key.as_str());
    written(keys.chain(measures).chain(["failure"]), |writer| {
        for (&member, outcome) in outcomes {
            let values = request.values(member);
            match outcome {
                Outcome::Done(measures) => writer.serialize((values, measures, ""))?,
                Outcome::Failed(reason) => {
                    writer.serialize((values, vec![""; measures.len()], reason))?;
                }
            }
        }
        Ok(())
    })
}

/// A row for each column of each ensemble, behind the keys but the seed.
pub(super) fn of_ensembles(
    request: &Request,
    ensembles: &[Ensemble],
) -> Result<String, csv::Error> {
    let keys = request.axes().into_iter().map(|axis| axis.key.as_str());
    let columns = "column members p05 median p95 mean deviation".split(' ');
    written(keys.chain(columns), |writer| {
        let all = ensembles.iter();
        let mut rows = all.flat_map(|of| of.columns.iter().map(|spread| (&of.values, spread)));
        rows.try_for_each(|row| writer.serialize(row))
    })
}

fn written<'a>(
    head: impl Iterator<Item = &'a str>,
    rows: impl FnOnce(&mut Writer) -> Result<(), csv::Error>,
) -> Result<String, csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer.write_record(head)?;
    rows(&mut writer)?;
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
