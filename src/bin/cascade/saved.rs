//! Results in the directory of a journal.

use std::path::Path;

use wavecascade::Error;
use wavecascade::plot::Figure;
use wavecascade::report::write_beside;

use crate::figure_args::Drawing;

/// What is saved of a run, besides its picture.
pub struct Saved<'a> {
    pub name: &'a str,
    pub json: &'a str,
    pub csv: &'a str,
    pub page: &'a str,
}

impl Saved<'_> {
    /// Writes `<name>.json` and `curves.csv` and, if wanted, the picture and the page into a directory,
    /// each whole; returns the name of the file to open.
    pub fn keep(&self, out: &Path, drawing: &Drawing, figure: &Figure) -> Result<String, Error> {
        let json = format!("{}.json", self.name);
        write_beside(out, &json, self.json.as_bytes())?;
        write_beside(out, "curves.csv", self.csv.as_bytes())?;
        if !drawing.is_wanted() {
            return Ok(json);
        }
        for format in &drawing.formats {
            let file = format!("{}.{}", self.name, format.extension());
            write_beside(out, &file, &figure.encode(*format)?)?;
        }
        write_beside(out, "report.html", self.page.as_bytes())?;
        Ok("report.html".into())
    }
}
