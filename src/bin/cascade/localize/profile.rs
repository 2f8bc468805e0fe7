//! `cascade localize --profile N`: a wave as arrays and as a picture.

use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;
use wavecascade::localized::Exact;
use wavecascade::plot;
use wavecascade::report::{LocalizedSummary, wave_html, write_profile};

use super::Localize;
use crate::failure::Failure;
use crate::summary::Summary;
use crate::terminal::{self, error_size, number};

/// Times on each side of the centre.
pub const HALF: usize = 2000;

#[derive(Debug, Serialize)]
struct ProfileReport {
    order: usize,
    exact: Exact,
}

pub(super) fn run(typed: &Localize, order: usize) -> Result<(), Failure> {
    let drawing = typed.figures.drawing()?;
    let default = PathBuf::from(format!("localized-{order}"));
    let out = typed.out.as_ref().unwrap_or(&default);
    let progress = typed.progress();
    progress.begin_writing();
    // Before any work: could the result be written?
    let directory = typed.directory(out)?;
    progress.wait("solving");
    let wave = typed.wave(order)?;
    progress.check()?;
    let found = ProfileReport {
        order,
        exact: Exact::of(&wave),
    };
    let json = LocalizedSummary::new(typed.family(), &found)
        .to_json()
        .map_err(std::io::Error::from)?;
    directory.write("localized.json", &json)?;
    let profile = wave.profile(HALF);
    write_profile(&directory.path().join("wave.npz"), &wave, &profile)?;
    if drawing.is_wanted() {
        let figure = plot::wave(&wave, &profile, &drawing.style);
        for format in &drawing.formats {
            figure.save(directory.path(), *format)?;
        }
        directory.write("report.html", wave_html(&wave, &profile))?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if typed.json {
        return Ok(writeln!(terminal::stdout(), "{json}")?);
    }
    if typed.quiet {
        return Ok(());
    }
    let exact = &found.exact;
    let answer = format!(
        "a localized wave at ratio {}, {} sites wide",
        number(exact.ratio.value()),
        number(exact.width)
    );
    let mut lines = Summary::new(&format!("order {order}"), &answer);
    lines.fact(
        "ratio",
        &format!(
            "{}, error {} of it",
            exact.ratio.value(),
            error_size(exact.error)
        ),
    );
    lines.fact(
        "speed",
        &format!(
            "{} F^{:.4} sites per unit of time, F the peak force in the first contact",
            number(exact.speed_coefficient),
            (wave.exponent - 1.0) / (2.0 * wave.exponent)
        ),
    );
    lines.fact("width", &format!("{} sites", number(exact.width)));
    lines.fact("energy", &number(exact.energy));
    lines.fact("momentum", &number(exact.momentum));
    lines.detail(
        "residual",
        &format!(
            "{} of the largest overlap, after {} iterations; tail {}",
            error_size(exact.convergence.residual),
            exact.convergence.iterations,
            error_size(exact.convergence.tail)
        ),
    );
    let page = published.join("report.html");
    let open = match drawing.is_wanted() {
        true => format!("; open {}", page.display()),
        false => String::new(),
    };
    lines.last(&format!("wrote {}{open}", published.display()));
    Ok(lines.print(typed.detail.verbose)?)
}
