//! `cascade localize`: stiffness or mass ratios that carry localized waves.

use std::io::Write;
use std::ops::RangeInclusive;

use cascade::localized::{Alternation, Family, Row, compare};
use clap::{Args, ValueEnum};

use crate::failure::Failure;

/// What `cascade localize` takes.
#[derive(Debug, Args)]
pub struct Localize {
    /// Orders, both ends included; 1 is the homogeneous chain.
    #[arg(long, value_name = "N|FIRST..LAST", default_value = "1..8", value_parser = orders)]
    pub order: RangeInclusive<usize>,
    /// What alternates along the dimer.
    #[arg(long, value_enum, default_value_t = Of::Stiffness)]
    pub alternation: Of,
    /// p of the contact law `F = c delta^p`.
    #[arg(long, default_value_t = 1.5)]
    pub exponent: f64,
    /// Strike chains too, and find where their pulses lose least.
    #[arg(long)]
    pub direct: bool,
    /// Cells of the chains that are struck.
    #[arg(long, default_value_t = 200, requires = "direct")]
    pub cells: usize,
    /// Print all that was found as JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Of {
    Stiffness,
    Mass,
}

fn orders(text: &str) -> Result<RangeInclusive<usize>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let number = |part: &str| {
        part.parse::<usize>()
            .ok()
            .filter(|n| *n > 0)
            .ok_or_else(|| format!("expected N or FIRST..LAST, from 1 on, found {text}"))
    };
    let (first, last) = (number(first)?, number(last)?);
    if first > last {
        return Err(format!("expected the first order first, found {text}"));
    }
    Ok(first..=last)
}

/// Runs the command.
pub fn run(typed: Localize) -> Result<(), Failure> {
    let family = Family {
        alternation: match typed.alternation {
            Of::Stiffness => Alternation::Stiffness,
            Of::Mass => Alternation::Mass,
        },
        exponent: typed.exponent,
    };
    let cells = typed.direct.then_some(typed.cells);
    let rows = compare(family, typed.order, cells, &cascade::analyze::Silent)?;
    let mut out = std::io::stdout().lock();
    if typed.json {
        let text = serde_json::to_string_pretty(&rows).map_err(std::io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    writeln!(
        out,
        "{:>5} {:>20} {:>8} {:>14} {:>14} {:>14} {:>9} {:>10} {:>10}",
        "order", "exact", "error", "estimate", "fitted", "direct", "leak", "paper", "estimate"
    )?;
    for row in &rows {
        writeln!(out, "{}", line(row))?;
    }
    Ok(())
}

/// A row of the table, the paper's numbers beside ours.
fn line(row: &Row) -> String {
    let number = |value: Option<f64>, width: usize| match value {
        Some(value) => format!(" {value:>width$.6}"),
        None => format!(" {:>width$}", "-"),
    };
    let exact = &row.exact;
    let mut line = format!(
        "{:>5} {:>20.12} {:>8.1e}",
        row.order, exact.ratio, exact.error
    );
    line += &number(Some(row.asymptotic.exact_profile), 14);
    line += &number(row.asymptotic.fitted_profile, 14);
    line += &number(row.direct.map(|d| d.ratio), 14);
    line += &match row.direct {
        Some(direct) => format!(" {:>9.1e}", direct.leak),
        None => format!(" {:>9}", "-"),
    };
    if let Some(paper) = row.published {
        line += &format!(" {:>10} {:>10}", paper.direct, paper.estimate);
        if paper.printed_order != row.order {
            line += &format!("  printed as order {}", paper.printed_order);
        }
    } else {
        line += &format!(" {:>10} {:>10}", "-", "-");
    }
    line
}
