//! `cascade localize`: the table of orders.

use std::io::Write;

use serde::Serialize;
use wavecascade::Error;
use wavecascade::localized::{Comparison, Cylinders, Direct, OrderRow};
use wavecascade::report::{
    LocalizedSummary, localized_html, localized_snippet, table_csv, write_profile,
};

use super::Localize;
use crate::failure::Failure;
use crate::summary::Summary;
use crate::table::Table;
use crate::terminal;

/// Default number of cells of struck chains.
const CELLS: usize = 200;
/// Ratios that the answer names at most.
const SHOWN: usize = 4;
/// Times on each side of a wave's centre.
const HALF: usize = 1000;

#[derive(Debug, Serialize)]
struct TableReport<'a> {
    cells: Option<usize>,
    orders: &'a [OrderRow],
}

/// What is computed.
pub fn comparison(typed: &Localize) -> Result<Comparison, Error> {
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
            return Err(Error::Request {
                option,
                expected: format!("{needed} beside it"),
                found: "it alone".into(),
            });
        }
    }
    let body = match typed.body.material()? {
        Some(material) => typed.body.radius.map(|radius| (radius, material)),
        None => None,
    };
    Ok(Comparison {
        family: typed.family(),
        orders: typed.order.clone(),
        cells: strikes.then(|| typed.cells.unwrap_or(CELLS)),
        cylinders: typed.angles.then(|| Cylinders {
            ellipse: typed.ellipse.into(),
            body,
        }),
    })
}

pub(super) fn run(typed: &Localize) -> Result<(), Failure> {
    let comparison = comparison(typed)?;
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
        directory.write("plot.py", localized_snippet())?;
        for wave in rows.iter().filter_map(|row| row.wave.as_ref()) {
            let path = directory.path().join(format!("wave-{:02}.npz", wave.order));
            write_profile(&path, wave, &wave.profile(HALF))?;
        }
        directory.write("report.html", localized_html(comparison.family, &rows))?;
        progress.check()?;
        directory.publish()?;
    }
    progress.clear();
    if typed.json {
        let text = serde_json::to_string_pretty(&rows).map_err(std::io::Error::from)?;
        writeln!(terminal::stdout(), "{text}")?;
    } else if !typed.quiet {
        let mut summary = tell(typed, &rows);
        if let Some(out) = &typed.out {
            summary.last(&format!("open {}", out.join("report.html").display()));
        }
        summary.print(typed.detail.verbose)?;
    }
    match rows.iter().filter(|row| row.exact.is_none()).count() {
        0 => Ok(()),
        unresolved => Err(Failure::Orders(unresolved)),
    }
}

/// The ratios that carry waves, in words.
fn answer(typed: &Localize, rows: &[OrderRow]) -> String {
    let known = rows.iter().filter_map(|row| row.exact.as_ref());
    let ratios: Vec<String> = known
        .map(|exact| terminal::number(exact.ratio.value()))
        .collect();
    let unresolved = match rows.len() - ratios.len() {
        0 => String::new(),
        count => format!("; {count} not resolved"),
    };
    let orders = match (typed.order.start(), typed.order.end()) {
        (first, last) if first == last => format!("order {first}"),
        (first, last) => format!("orders {first} to {last}"),
    };
    let of = match typed.alternation {
        super::Of::Stiffness => "stiffness",
        super::Of::Mass => "mass",
    };
    let shown = ratios.len().min(SHOWN);
    let more = if ratios.len() > shown { ", ..." } else { "" };
    match ratios.is_empty() {
        true => format!("no localized wave of {orders} is resolved"),
        false => {
            let what = match ratios.len() {
                1 => format!("a localized wave at {of} ratio"),
                _ => format!("localized waves at {of} ratios"),
            };
            format!(
                "{what} {}{more} ({orders}){unresolved}",
                ratios[..shown].join(", ")
            )
        }
    }
}

fn tell(typed: &Localize, rows: &[OrderRow]) -> Summary {
    let mut summary = Summary::new("dimer", &answer(typed, rows));
    let strikes = typed.direct || typed.angles;
    let published = rows.iter().any(|row| row.published.is_some());
    let mut short = Table::new("order")
        .numbers("exact ratio")
        .numbers("error")
        .numbers("estimate");
    if strikes {
        short = short.numbers("struck chain");
    }
    if published {
        short = short.numbers("paper");
    }
    for row in rows {
        let mut cells = vec![row.order.to_string()];
        cells.extend(match &row.exact {
            Some(exact) => [
                format!("{:.12}", exact.ratio.value()),
                format!("{:.1e}", exact.error),
            ],
            None => ["unresolved".into(), "-".into()],
        });
        cells.push(number(row.asymptotic.map(|a| a.exact_profile)));
        if strikes {
            cells.push(number(row.direct.map(|direct| direct.ratio.value())));
        }
        if published {
            cells.push(row.published.map_or("-".into(), |p| p.direct.to_string()));
        }
        let reason: Vec<String> = row.reason.iter().cloned().collect();
        short.noted_row(cells, &reason.join("; "));
    }
    summary.rows(short);
    if strikes {
        summary.rows(leaks(typed, rows));
        if let Some([soft, _]) = rows.iter().find_map(|row| row.angle?.coefficients) {
            summary.sentence(&format!("soft contacts, at 90 degrees: {soft:.6e} N/m^1.5"));
        }
    }
    let mut table = Table::new("order")
        .numbers("exact ratio")
        .numbers("error")
        .in_group("estimate, exact wave", "ratio")
        .in_group("estimate, exact wave", "rel.diff")
        .in_group("estimate, fitted wave", "ratio")
        .in_group("estimate, fitted wave", "rel.diff");
    if strikes {
        for name in ["ratio", "error", "rel.diff"] {
            table = table.in_group("struck chain", name);
        }
    }
    if published {
        for group in ["paper, simulated", "paper, estimate"] {
            table = table.in_group(group, "ratio").in_group(group, "rel.diff");
        }
    }
    for row in rows {
        add(&mut table, row, strikes, published);
    }
    summary.detailed_rows(table);
    let legend = match published {
        true => {
            "rel.diff: relative to the exact ratio; of the paper's estimate, to the estimate on the \
             fitted wave"
        }
        false => "rel.diff: relative to the exact ratio",
    };
    summary.detailed_sentence(legend);
    summary
}

/// Adds a row; deviations are relative to the exact ratio, that of the paper's estimate to ours.
fn add(table: &mut Table, row: &OrderRow, strikes: bool, published: bool) {
    let estimates = row.asymptotic;
    let off = &row.differences;
    let mut cells = vec![row.order.to_string()];
    cells.extend(match &row.exact {
        Some(exact) => [
            format!("{:.12}", exact.ratio.value()),
            format!("{:.1e}", exact.error),
        ],
        None => ["unresolved".into(), "-".into()],
    });
    cells.push(number(estimates.map(|a| a.exact_profile)));
    cells.push(change(off.exact_profile));
    cells.push(number(estimates.and_then(|a| a.fitted_profile)));
    cells.push(change(off.fitted_profile));
    if strikes {
        cells.push(number(row.direct.map(|d| d.ratio.value())));
        cells.push(change(row.direct.map(|d| d.error)));
        cells.push(change(off.direct));
    }
    let mut notes: Vec<String> = row.reason.iter().cloned().collect();
    if published {
        let known = |value: Option<f64>| value.map_or("-".into(), |value| value.to_string());
        cells.push(known(row.published.map(|p| p.direct)));
        cells.push(change(off.published_direct));
        cells.push(known(row.published.map(|p| p.estimate)));
        cells.push(change(off.published_estimate));
        if let Some(paper) = row.published.filter(|p| p.printed_order != row.order) {
            notes.insert(0, format!("printed as order {}", paper.printed_order));
        }
    }
    table.noted_row(cells, &notes.join("; "));
}

/// What pulses lose at the orders and, most, between them.
fn leaks(typed: &Localize, rows: &[OrderRow]) -> Table {
    let mut table = Table::new("wave").numbers("ratio").numbers("leak a cell");
    if typed.angles {
        table = table.numbers("degrees");
    }
    for row in rows {
        let mut add = |name: String, direct: Direct, degrees: Option<f64>| {
            let leak = format!("{:.1e}", direct.leak);
            let mut cells = vec![name, number(Some(direct.ratio.value())), leak];
            if typed.angles {
                cells.push(number(degrees));
            }
            table.row(cells);
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
    table
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.6}"))
}

fn change(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.1e}"))
}
