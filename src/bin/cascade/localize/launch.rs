//! `cascade localize --launch N`: a chain that starts with a wave.

use std::io::Write;

use serde::Serialize;
use wavecascade::localized::Journey;
use wavecascade::plot;
use wavecascade::report::{LocalizedSummary, journey_html, write_journey};

use super::Localize;
use crate::failure::Failure;
use crate::summary::Summary;
use crate::terminal::{self, error_size};

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
    if typed.json {
        return Ok(writeln!(terminal::stdout(), "{json}")?);
    }
    if typed.quiet {
        return Ok(());
    }
    let arrived = &journey.arrived;
    let ratio = journey.ratio.value();
    let answer = format!(
        "the wave travels {} cells at ratio {} and sheds {} of its energy a cell",
        arrived.cells,
        terminal::number(ratio),
        error_size(arrived.leak)
    );
    let mut lines = Summary::new(&format!("order {order}"), &answer);
    lines.fact("ratio", &ratio.to_string());
    lines.fact(
        "shape change",
        &format!(
            "{} of the largest velocity; runs of local errors {} and {} differ by {}",
            error_size(arrived.shape_change),
            error_size(journey.local_error),
            error_size(10.0 * journey.local_error),
            error_size(journey.stepping_error)
        ),
    );
    lines.fact("energy drift", &error_size(arrived.energy_drift));
    if let Some(published) = published {
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "localized.json",
        };
        lines.last(&format!("open {}", published.join(main).display()));
    }
    Ok(lines.print(typed.detail.verbose)?)
}
