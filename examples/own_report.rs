//! The files of `cascade analyze` from a program of one's own.

use std::path::Path;

use wavecascade::Field;
use wavecascade::analyze::{Request, plan, run};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::plot::{Format, Style, figures_of, save_all};
use wavecascade::report::{Archive, ArrayFile, Provenance, ResultDirectory, sheet_html};
use wavecascade::sheet::Describe;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let place = tempfile::tempdir()?;
    let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data/lattice_impact.npy");
    let field = Field::open(&input, &OpenOptions::default())?;
    let request = Request::default();

    // Nothing of it is seen under its name before it is whole.
    let directory = ResultDirectory::create(&place.path().join("impact"), false)?;
    let archive = Archive::create(&directory.path().join("spectra.npz"), request.precision)?;
    let analysis = run(&field, &plan(&field, &request)?, &archive, &Silent)?;
    let sheet = analysis.describe();
    sheet.write_to(&archive)?;
    archive.finish()?;
    let command = vec!["own_report".to_owned()];
    let provenance = Provenance::new(
        command,
        Some(input.display().to_string()),
        analysis.content_hash.clone(),
    );
    directory.write("summary.json", sheet.summary(&provenance)?)?;
    let (name, style) = (&analysis.name, Style::default());
    let page = sheet_html(&analysis, &sheet, name, &provenance, &style)?;
    directory.write("report.html", page)?;
    let figures = figures_of(&analysis, &sheet, name, "analyze", &style);
    save_all(&figures, &directory.path().join("figures"), &[Format::Png])?;
    let published = directory.publish()?;

    for entry in std::fs::read_dir(&published)? {
        println!("{}", entry?.file_name().to_string_lossy());
    }
    Ok(())
}
