//! `cascade localize`: the table of orders.

use std::io::Write;

use serde::Serialize;
use wavecascade::Error;
use wavecascade::localized::{Comparison, Cylinders, Direct, OrderRow};
use wavecascade::report::{LocalizedSummary, table_csv, write_profile};

use super::Localize;
use crate::failure::Failure;

/// Default number of cells of struck chains.
const CELLS: usize = 200;
/// Times on each side of a wave's centre.
const HALF: usize = 1000;

#[derive(Debug, Serialize)]
struct TableReport<'a> {
    cells: Option<usize>,
    orders: &'a [OrderRow],
}

pub(super) fn run(typed: &Localize) -> Result<(), Failure> {
    let strikes = typed.direct || typed.angles;
    let needless = [
        (
            "cells",
            typed.cells.is_some() && !strikes,
            "--direct or --angles",
        ),
        (
            "radius",
            typed.body.radius.is_some() && !typed.angles,
            "--angles",
        ),
    ];
    for (option, is_needless, needed) in needless {
        if is_needless {
            return Err(Failure::Library(Error::Request {
                option,
                expected: format!("{needed} beside it"),
                found: "it alone".into(),
            }));
        }
    }
    let body = match typed.body.material()? {
        Some(material) => typed.body.radius.map(|radius| (radius, material)),
        None => None,
    };
    let comparison = Comparison {
        family: typed.family(),
        orders: typed.order.clone(),
        cells: strikes.then(|| typed.cells.unwrap_or(CELLS)),
        cylinders: typed.angles.then(|| Cylinders {
            ellipse: typed.ellipse.into(),
            body,
        }),
    };
    let progress = typed.progress();
    progress.begin_writing();
    let directory = typed
        .out
        .as_deref()
        .map(|out| typed.directory(out))
        .transpose()?;
    let rows = comparison.run(&progress)?;
    if let Some(directory) = directory {
        let found = TableReport {
            cells: comparison.cells,
            orders: &rows,
        };
        let json = LocalizedSummary::new(comparison.family, &found)
            .to_json()
            .map_err(std::io::Error::from)?;
        directory.write("localized.json", &json)?;
        directory.write("table.csv", table_csv(&rows))?;
        for wave in rows.iter().filter_map(|row| row.wave.as_ref()) {
            let path = directory.path().join(format!("wave-{:02}.npz", wave.order));
            write_profile(&path, wave, &wave.profile(HALF))?;
        }
        progress.check()?;
        directory.publish()?;
    }
    progress.clear();
    let mut stdout = std::io::stdout().lock();
    if typed.json {
        let text = serde_json::to_string_pretty(&rows).map_err(std::io::Error::from)?;
        writeln!(stdout, "{text}")?;
    } else if !typed.quiet {
        stdout.write_all(lines(typed, &rows).as_bytes())?;
        if let Some(out) = &typed.out {
            writeln!(stdout, "wrote {}", out.display())?;
        }
    }
    match rows.iter().filter(|row| row.exact.is_none()).count() {
        0 => Ok(()),
        unresolved => Err(Failure::Orders(unresolved)),
    }
}

fn lines(typed: &Localize, rows: &[OrderRow]) -> String {
    let strikes = typed.direct || typed.angles;
    let published = rows.iter().any(|row| row.published.is_some());
    let mut groups = format!(
        "{:>5} {:>20} {:>8} {:>22} {:>22}",
        "", "", "", "estimate, exact wave", "estimate, fitted wave"
    );
    let mut text = format!(
        "{:>5} {:>20} {:>8} {:>13} {:>8} {:>13} {:>8}",
        "order", "exact ratio", "error", "ratio", "rel.diff", "ratio", "rel.diff"
    );
    if strikes {
        groups += &format!(" {:>31}", "struck chain");
        text += &format!(" {:>13} {:>8} {:>8}", "ratio", "error", "rel.diff");
    }
    if published {
        groups += &format!(" {:>18} {:>18}", "paper, simulated", "paper, estimate");
        text += &format!(
            " {:>9} {:>8} {:>9} {:>8}",
            "ratio", "rel.diff", "ratio", "rel.diff"
        );
    }
    text = format!("{groups}\n{text}");
    text.push('\n');
    for row in rows {
        text += &line(row, strikes, published);
        text.push('\n');
    }
    text += "rel.diff: relative to the exact ratio";
    text += match published {
        true => "; of the paper's estimate, to the estimate on the fitted wave\n",
        false => "\n",
    };
    if strikes {
        text += &leaks(typed, rows);
    }
    text
}

/// A row of the table; deviations are relative to the exact ratio, that of the paper's estimate to
/// ours.
fn line(row: &OrderRow, strikes: bool, published: bool) -> String {
    let estimates = row.asymptotic;
    let off = &row.differences;
    let mut line = match &row.exact {
        Some(exact) => format!(
            "{:>5} {:>20.12} {:>8.1e}",
            row.order,
            exact.ratio.value(),
            exact.error
        ),
        None => format!("{:>5} {:>20} {:>8}", row.order, "unresolved", "-"),
    };
    line += &number(estimates.map(|a| a.exact_profile));
    line += &change(off.exact_profile);
    line += &number(estimates.and_then(|a| a.fitted_profile));
    line += &change(off.fitted_profile);
    if strikes {
        line += &number(row.direct.map(|d| d.ratio.value()));
        line += &change(row.direct.map(|d| d.error));
        line += &change(off.direct);
    }
    if published {
        let known = |value: Option<f64>| match value {
            Some(value) => format!(" {value:>9}"),
            None => format!(" {:>9}", "-"),
        };
        line += &known(row.published.map(|p| p.direct));
        line += &change(off.published_direct);
        line += &known(row.published.map(|p| p.estimate));
        line += &change(off.published_estimate);
        if let Some(paper) = row.published.filter(|p| p.printed_order != row.order) {
            line += &format!("  printed as order {}", paper.printed_order);
        }
    }
    if let Some(reason) = &row.reason {
        line += &format!("  {reason}");
    }
    line
}

/// What pulses lose at the orders and, most, between them.
fn leaks(typed: &Localize, rows: &[OrderRow]) -> String {
    let mut text = format!(
        "\n{:>16} {:>13} {:>13}{}\n",
        "",
        "ratio",
        "leak a cell",
        if typed.angles { "       degrees" } else { "" }
    );
    let coefficients = rows.iter().find_map(|row| row.angle?.coefficients);
    for row in rows {
        let mut add = |name: String, direct: Direct, degrees: Option<f64>| {
            let ratio = number(Some(direct.ratio.value()));
            text += &format!("{name:>16}{ratio} {:>13.1e}", direct.leak);
            if let Some(degrees) = degrees {
                text += &number(Some(degrees));
            }
            text.push('\n');
        };
        if let Some(direct) = row.direct {
            let degrees = row.angle.map(|angle| angle.degrees);
            add(format!("order {}", row.order), direct, degrees);
        }
        if let Some(direct) = row.most_dispersive {
            let degrees = direct.angle.map(|angle| angle.degrees);
            add("most dispersive".into(), direct, degrees);
        }
    }
    if let Some([soft, _]) = coefficients {
        text += &format!("soft contacts, at 90 degrees: {soft:.6e} N/m^1.5\n");
    }
    text
}

fn number(value: Option<f64>) -> String {
    match value {
        Some(value) => format!(" {value:>13.6}"),
        None => format!(" {:>13}", "-"),
    }
}

fn change(value: Option<f64>) -> String {
    match value {
        Some(value) => format!(" {value:>8.1e}"),
        None => format!(" {:>8}", "-"),
    }
}
