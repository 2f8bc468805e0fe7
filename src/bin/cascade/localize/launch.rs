//! `cascade localize --launch N`: a chain that starts with a wave.

use std::io::Write;

use serde::Serialize;
use wavecascade::localized::Journey;
use wavecascade::plot;
use wavecascade::report::{LocalizedSummary, journey_html, write_journey};

use super::Localize;
use crate::failure::Failure;
use crate::terminal::{self, Lines, error_size};

/// Default number of cells that a wave travels.
pub const CELLS: usize = 1000;

#[derive(Debug, Serialize)]
struct LaunchReport<'a> {
    launch: &'a Journey,
}

pub(super) fn run(typed: &Localize, order: usize) -> Result<(), Failure> {
    let drawing = typed.figures.drawing()?;
    let progress = typed.progress();
    progress.begin_writing();
    let directory = typed
        .out
        .as_deref()
        .map(|out| typed.directory(out))
        .transpose()?;
    progress.wait("solving");
    let wave = typed.wave(order)?;
    progress.check()?;
    let journey = wave.journey(typed.cells.unwrap_or(CELLS), &progress)?;
    let found = LaunchReport { launch: &journey };
    let json = LocalizedSummary::new(typed.family(), &found)
        .to_json()
        .map_err(std::io::Error::from)?;
    let published = match directory {
        None => None,
        Some(directory) => {
            directory.write("localized.json", &json)?;
            write_journey(&directory.path().join("launch.npz"), &journey)?;
            if drawing.is_wanted() {
                let figure = plot::journey(&journey, &drawing.style);
                for format in &drawing.formats {
                    figure.save(directory.path(), *format)?;
                }
                directory.write("report.html", journey_html(&journey))?;
            }
            progress.check()?;
            Some(directory.publish()?)
        }
    };
    progress.clear();
    let mut stdout = terminal::stdout();
    if typed.json {
        return Ok(writeln!(stdout, "{json}")?);
    }
    if typed.quiet {
        return Ok(());
    }
    let arrived = &journey.arrived;
    let mut lines = Lines::new(terminal::width());
    let ratio = journey.ratio.value();
    lines.line("order", &format!("{order}, ratio {ratio}"));
    lines.line("travelled", &format!("{} cells", arrived.cells));
    lines.line(
        "shape change",
        &format!(
            "{} of the largest velocity; runs of local errors {} and {} differ by {}",
            error_size(arrived.shape_change),
            error_size(journey.local_error),
            error_size(10.0 * journey.local_error),
            error_size(journey.stepping_error)
        ),
    );
    lines.line(
        "leak",
        &format!("{} of the energy a cell", error_size(arrived.leak)),
    );
    lines.line("energy drift", &error_size(arrived.energy_drift));
    write!(stdout, "{}", lines.text)?;
    if let Some(published) = published {
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "localized.json",
        };
        writeln!(stdout, "open {}", published.join(main).display())?;
    }
    Ok(())
}
