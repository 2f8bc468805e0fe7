//! The page that lists several fields.

use maud::{Markup, Render, html as markup};

use super::Page;
use crate::report::{FieldOutcome, FieldRow, fields_tables, verdicts_in_words};
use crate::sheet::Table;

/// The list of several fields with their headlines; each links to its page or its summary.
pub fn fields_html(rows: &[FieldRow]) -> String {
    let failed = rows.iter().filter_map(|row| match &row.outcome {
        FieldOutcome::Headlines(_) => None,
        FieldOutcome::Failed(why) => Some(vec![row.field.as_str().render(), super::prose(why)]),
    });
    let failed: Vec<Vec<Markup>> = failed.collect();
    let head = ["field", "reason"].map(str::to_owned);
    let (fields, verdicts) = verdicts_in_words(rows);
    let page = Page {
        title: "Fields".into(),
        sentence: "what moves in frequency along x".into(),
        rest: super::numbers(markup! {
            @for one in fields_tables(rows) { (table(&one, rows)) }
            @if !failed.is_empty() {
                (super::table("Fields without a result", &head, &failed))
            }
        }),
        ..Page::default()
    };
    page.html(
        &format!("{fields}: {verdicts}"),
        "all numbers are in headlines.csv",
    )
}

/// A table whose first column links to the results.
fn table(table: &Table, rows: &[FieldRow]) -> Markup {
    let linked = |cells: &Vec<String>| -> Vec<Markup> {
        let named = |row: &&FieldRow| cells.first() == Some(&row.name);
        let opens = rows.iter().find(named).and_then(|row| row.opens.as_ref());
        let mut cells: Vec<Markup> = cells.iter().map(Render::render).collect();
        if let Some(target) = opens {
            cells[0] = markup! { a href=(encoded(target)) { (cells[0]) } };
        }
        cells
    };
    let rows: Vec<Vec<Markup>> = table.rows.iter().map(linked).collect();
    super::table(&table.title, &table.head, &rows)
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
