//! The page that lists several fields.

use maud::{Markup, Render, html as markup};

use crate::plot::Style;
use crate::report::page::{self, Page};
use crate::report::{FieldOutcome, FieldRow, Headlines, MovedShares, verdicts_in_words};

/// The list of several fields with their headlines; each links to its page or its summary.
pub fn fields_html(rows: &[FieldRow]) -> String {
    let mut analyzed: Vec<(&FieldRow, &Headlines)> = Vec::new();
    let mut failed = Vec::new();
    for row in rows {
        match &row.outcome {
            FieldOutcome::Headlines(found) => analyzed.push((row, found)),
            FieldOutcome::Failed(why) => {
                failed.push(vec![row.field.as_str().render(), page::prose(why)])
            }
        }
    }
    let (fields, verdicts) = verdicts_in_words(rows);
    let page = Page {
        title: "Fields".into(),
        sentence: "what moves in frequency along x".into(),
        answers: Markup::default(),
        warnings: page::warnings(&[]),
        rows: Vec::new(),
        rest: page::numbers(markup! {
            @if !analyzed.is_empty() { (table(&analyzed)) }
            @if !failed.is_empty() {
                (page::grid("Fields without a result", &["field", "reason"], &failed))
            }
        }),
        style: Style::default(),
    };
    page.html(
        &format!("{fields}: {verdicts}"),
        "all numbers are in headlines.csv",
    )
}

fn table(analyzed: &[(&FieldRow, &Headlines)]) -> Markup {
    let head = [
        "field",
        "frequency along x",
        "up",
        "down",
        "energy ratio",
        "from, to site",
        "wavenumber in time",
        "up",
        "down",
        "towards +x",
        "towards −x",
        "times × sites",
        "warnings",
        "cannot be told",
    ];
    let rows: Vec<Vec<Markup>> = analyzed
        .iter()
        .map(|(row, found)| cells(row, found))
        .collect();
    let title = "Verdicts, the shares of energy that moved up and down, and where";
    page::grid(title, &head, &rows)
}

fn cells(row: &FieldRow, found: &Headlines) -> Vec<Markup> {
    const NONE: &str = "–";
    let text = |text: String| text.render();
    let known = |value: Option<String>| value.unwrap_or_else(|| NONE.into()).render();
    let mut cells = vec![match &row.opens {
        Some(target) => markup! { a href=(encoded(target)) { (row.name) } },
        None => text(row.name.clone()),
    }];
    cells.extend(moved(found.frequency.as_ref()));
    cells.push(known(found.energy_ratio.map(number)));
    cells.push(known(
        found
            .from
            .zip(found.to)
            .map(|(from, to)| format!("{from}, {to}")),
    ));
    cells.extend(moved(found.wavenumber.as_ref()));
    cells.push(known(found.toward_plus_x.map(percent)));
    cells.push(known(found.toward_minus_x.map(percent)));
    cells.push(text(format!("{} × {}", found.times, found.sites)));
    cells.push(text(found.warnings.to_string()));
    let reasons = [
        ("frequency", &found.frequency),
        ("wavenumber", &found.wavenumber),
    ];
    let reasons = reasons.iter().filter_map(|(name, of)| {
        let reason = of.as_ref()?.reason.as_ref()?;
        Some(format!("{name}: {reason}"))
    });
    cells.push(text(reasons.collect::<Vec<_>>().join("; ")));
    cells
}

/// The verdict, up and down.
fn moved(of: Option<&MovedShares>) -> [Markup; 3] {
    let Some(of) = of else {
        return ["–"; 3].map(|dash| dash.render());
    };
    let share = |share: Option<f64>, word: &str, at: Option<f64>| match (share, at) {
        (Some(share), Some(at)) => {
            let unit = match of.unit.starts_with("cycles/unit") {
                true => "",
                false => of.unit.as_str(),
            };
            let text = format!("{} {word} {} {unit}", percent(share), number(at));
            text.trim_end().render()
        }
        (Some(share), None) => percent(share).render(),
        (None, _) => "–".render(),
    };
    let verdict = match &of.reason {
        None => of.word(),
        Some(_) => "cannot be told".into(),
    };
    [
        verdict.render(),
        share(of.up, "past", of.up_at),
        share(of.down, "below", of.down_at),
    ]
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Three digits.
fn number(value: f64) -> String {
    page::number(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A relative path as a link.
fn encoded(name: &str) -> String {
    let bytes = name.bytes().map(|byte| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' => {
            char::from(byte).to_string()
        }
        _ => format!("%{byte:02X}"),
    });
    bytes.collect()
}
