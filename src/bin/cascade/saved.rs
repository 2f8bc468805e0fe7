//! Described results in the directory of a journal, which keeps the runs that they are made of.

use std::path::{Path, PathBuf};

use wavecascade::plot::figure_of;
use wavecascade::report::{Provenance, sheet_html, write_beside};
use wavecascade::sheet::{Describe, Sheet};

use crate::failure::Failure;
use crate::figure_args::Drawing;

/// Writes `summary.json` and `curves.csv` and, if wanted, the picture and the page into a directory, each whole; returns
/// the file to open.
pub fn keep(
    (found, sheet): (&dyn Describe, &Sheet),
    subject: &str,
    out: &Path,
    drawing: &Drawing,
    provenance: &Provenance,
) -> Result<PathBuf, Failure> {
    let json = sheet.summary(provenance).map_err(std::io::Error::from)?;
    let summary = write_beside(out, "summary.json", json.as_bytes())?;
    let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
    write_beside(out, "curves.csv", csv.as_bytes())?;
    if !drawing.is_wanted() {
        return Ok(summary);
    }
    let figure = figure_of(found, sheet, subject, sheet.name, &drawing.style);
    for format in &drawing.formats {
        let file = format!("{}.{}", sheet.name, format.extension());
        write_beside(out, &file, &figure.encode(*format)?)?;
    }
    let page = sheet_html(found, sheet, subject, provenance, &drawing.style);
    let page = page.map_err(std::io::Error::from)?;
    Ok(write_beside(out, "report.html", page.as_bytes())?)
}
