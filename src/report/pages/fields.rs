//! The page that lists several fields.

use maud::{Markup, Render, html as markup};

use crate::plot::Style;
use crate::report::page::{self, Page, number};
use crate::report::{Content, FieldOutcome, FieldRow, Headlines, Movement, percent};

/// The list of several fields with their headlines; each links to its page or its summary.
pub fn fields_html(rows: &[FieldRow]) -> String {
    let mut analyzed: Vec<(&FieldRow, &Headlines)> = Vec::new();
    let mut failed = Vec::new();
    for row in rows {
        match &row.outcome {
            FieldOutcome::Headlines(found) => analyzed.push((row, found)),
            FieldOutcome::Failed(why) => failed.push(vec![row.field.clone(), why.clone()]),
        }
    }
    let count = match (rows.len(), failed.len()) {
        (1, 0) => "one field".to_owned(),
        (fields, 0) => format!("{fields} fields"),
        (fields, failures) => format!("{fields} fields, {failures} of them without a result"),
    };
    let page = Page {
        title: "Fields".into(),
        sentence: format!("{count}; all numbers are in headlines.csv"),
        answers: most_rise(&analyzed),
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
    page.html()
}

/// The field whose centroid rises most along each axis.
fn most_rise(analyzed: &[(&FieldRow, &Headlines)]) -> Markup {
    let most = |of: fn(&Headlines) -> Option<&Movement>| {
        let risen = analyzed.iter();
        let risen = risen.filter_map(|(row, found)| Some((of(found)?.rise()?, &row.name)));
        let (rise, name) = risen.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(match rise > 1.0 {
            true => format!("In {name}, to {} times the reference.", number(rise)),
            false => "In none of them.".into(),
        })
    };
    let of_each = [
        (
            "Where does the centroid of frequency rise most along x?",
            most(|f| f.along_x.as_ref()),
        ),
        (
            "Where does the centroid of wavenumber rise most in time?",
            most(|f| f.along_t.as_ref()),
        ),
    ];
    markup! {
        @for (question, answer) in of_each {
            @if let Some(answer) = answer { (page::answer(question, answer)) }
        }
    }
}

fn table(analyzed: &[(&FieldRow, &Headlines)]) -> Markup {
    let head = [
        "field",
        "times × sites",
        "centroid along x",
        "rise",
        "high band along x",
        "centroid in time",
        "rise",
        "high band in time",
        "towards +x",
        "warnings",
    ];
    let rows: Vec<Vec<Markup>> = analyzed
        .iter()
        .map(|(row, found)| cells(row, found))
        .collect();
    page::grid(
        "Headlines: at the reference → at the last site or time with energy",
        &head,
        &rows,
    )
}

fn cells(row: &FieldRow, found: &Headlines) -> Vec<Markup> {
    let text = |text: String| text.render();
    let mut cells = vec![
        match &row.opens {
            Some(target) => markup! { a href=(encoded(target)) { (row.name) } },
            None => text(row.name.clone()),
        },
        text(format!("{} × {}", found.times, found.sites)),
    ];
    for movement in [&found.along_x, &found.along_t] {
        let Some(movement) = movement else {
            cells.extend(["–", "–", "–"].map(|dash| dash.render()));
            continue;
        };
        let both = |of: &dyn Fn(&Content) -> Option<String>| {
            let one =
                |content: &Option<Content>| content.as_ref().and_then(of).unwrap_or("–".into());
            format!("{} → {}", one(&movement.reference), one(&movement.last))
        };
        let centroids = both(&|content| content.centroid.map(number));
        cells.push(text(format!("{centroids} {}", movement.unit)));
        cells.push(text(movement.rise().map_or("–".into(), number)));
        cells.push(text(both(&|content| content.high_share.map(percent))));
    }
    cells.push(text(found.toward_plus_x.map_or("–".into(), percent)));
    cells.push(text(found.warnings.to_string()));
    cells
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
