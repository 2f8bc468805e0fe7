//! The page of a described result: its answer, pictures, facts and tables.

use maud::{Markup, html as markup};

use crate::plot::Style;
use crate::report::Provenance;
use crate::report::page::{self, CurveGroup, MapData, Page, Picture, sentence_case};
use crate::sheet::{Describe, Plot, Sheet, Table};

/// The page of a result with the name `data`.
///
/// # Errors
/// None for results of this library.
pub fn sheet_html(
    found: &dyn Describe,
    sheet: &Sheet,
    data: &str,
    provenance: &Provenance,
    style: &Style,
) -> serde_json::Result<String> {
    let plots = found.pictures().into_iter().flat_map(|row| row.plots);
    let rows = plots.enumerate().filter_map(|(n, plot)| picture(n, &plot));
    let rows = rows.map(|picture| vec![picture]).collect();
    page_of(sheet, rows, data, provenance, style)
}

/// The page of a described result with these pictures.
///
/// # Errors
/// None for results of this library.
pub(super) fn page_of(
    sheet: &Sheet,
    rows: Vec<Vec<Picture>>,
    data: &str,
    provenance: &Provenance,
    style: &Style,
) -> serde_json::Result<String> {
    let of = |is_detail: bool| -> Vec<(&str, String)> {
        let facts = sheet
            .facts
            .iter()
            .filter(|fact| fact.is_detail == is_detail);
        facts.map(|fact| (&*fact.name, fact.text.clone())).collect()
    };
    let warnings = sheet.warnings.iter().map(|warning| {
        let advice = (!warning.advice.is_empty()).then(|| warning.advice.clone());
        (warning.message.clone(), advice)
    });
    let definitions: Vec<(&str, &str)> = sheet
        .definitions
        .iter()
        .map(|[term, meaning]| (*term, *meaning))
        .collect();
    let json = sheet.summary(provenance)?;
    let page = Page {
        title: format!("{}: {data}", sheet.title),
        sentence: sheet.about.clone(),
        answers: page::facts(&of(false)),
        warnings: page::warnings(&warnings.collect::<Vec<_>>()),
        rows,
        rest: markup! {
            (page::numbers(markup! {
                div class="tables" {
                    @for one in sheet.tables.iter().filter(|table| table.is_fact) { (table(one)) }
                    @if !of(true).is_empty() { (page::table("Details", &of(true))) }
                    @for one in sheet.tables.iter().filter(|table| !table.is_fact) { (table(one)) }
                }
            }))
            @if !definitions.is_empty() { (page::how_to_read(&definitions)) }
            (page::folded("json", "summary.json", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html(&sentence_case(&sheet.answer), ""))
}

/// The n-th plot; a map whose axes count nothing known is drawn in figures alone.
fn picture(n: usize, plot: &Plot) -> Option<Picture> {
    match plot {
        Plot::Chart(chart) => Some(CurveGroup::of_chart(&format!("chart-{n}"), "", chart).into()),
        Plot::Map(map) => MapData::of_chart(&format!("map-{n}"), map).map(Picture::from),
    }
}

fn table(table: &Table) -> Markup {
    match table.head.is_empty() {
        true => {
            let rows = table.rows.iter();
            let rows: Vec<(&str, String)> = rows
                .filter_map(|row| Some((&**row.first()?, row.get(1)?.clone())))
                .collect();
            page::table(&table.title, &rows)
        }
        false => {
            let head: Vec<&str> = table.head.iter().map(String::as_str).collect();
            page::grid(&table.title, &head, &table.rows)
        }
    }
}
