//! Results in the directory of a journal.

use std::path::Path;

use wavecascade::Error;
use wavecascade::plot::Format;
use wavecascade::report::write_beside;

/// Writes `<name>.json`, `curves.csv` and the picture in both formats into a directory, each whole.
pub fn keep(
    out: &Path,
    name: &str,
    json: &str,
    csv: &str,
    picture: impl Fn(Format) -> Result<Vec<u8>, Error>,
) -> Result<(), Error> {
    write_beside(out, &format!("{name}.json"), json.as_bytes())?;
    write_beside(out, "curves.csv", csv.as_bytes())?;
    for format in [Format::Png, Format::Svg] {
        let file = format!("{name}.{}", format.extension());
        write_beside(out, &file, &picture(format)?)?;
    }
    Ok(())
}
