//! The page of a described result: its answer, pictures, facts and tables.

use maud::{Markup, html as markup};

use super::{Page, Picture, sentence_case};
use crate::plot::Style;
use crate::report::Provenance;
use crate::sheet::{Chart, Describe, FigureLayout, Sheet, Table};

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
    let of = |is_detail: bool| -> Vec<(&str, String)> {
        let facts = sheet
            .facts
            .iter()
            .filter(|fact| fact.is_detail == is_detail);
        facts.map(|fact| (&*fact.name, fact.text.clone())).collect()
    };
    let details = of(true).into_iter();
    let details = details.map(|(name, text)| vec![name.to_owned(), text]);
    let details = Table::of("Details", &[], details);
    let json = sheet.summary(provenance)?;
    let page = Page {
        title: format!("{}: {data}", sheet.title),
        sentence: sheet.about.clone(),
        answers: super::facts(&of(false)),
        warnings: super::warnings(&sheet.warnings),
        rows: rows(&found.figures()),
        rest: markup! {
            (super::numbers(markup! {
                div class="tables" {
                    @for one in sheet.tables.iter().filter(|table| table.is_fact) { (table(one)) }
                    @if !details.rows.is_empty() { (table(&details)) }
                    @for one in sheet.tables.iter().filter(|table| !table.is_fact) { (table(one)) }
                }
            }))
            @if !sheet.definitions.is_empty() { (super::how_to_read(&sheet.definitions)) }
            (super::folded("json", "summary.json", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html(&sentence_case(&sheet.answer), ""))
}

/// A picture for each plot, or for charts that share their x. Plots of figures that have names stand in their rows.
fn rows(figures: &[FigureLayout]) -> Vec<Vec<Picture>> {
    let mut rows = Vec::new();
    let mut count = 0;
    for figure in figures {
        let plots = figure.rows.iter().flat_map(|row| &row.plots);
        if figure.shared_x {
            let charts: Vec<&Chart> = plots.filter(|plot| !plot.is_map()).collect();
            let group = super::curves(figure.name.into(), figure.title.clone(), &charts);
            rows.push(Vec::from_iter(group));
            continue;
        }
        let mut n = 0;
        for row in &figure.rows {
            let mut pictures = Vec::new();
            for plot in &row.plots {
                let id = match (figure.name, plot.is_map()) {
                    ("", false) => format!("chart-{count}"),
                    ("", true) => format!("map-{count}"),
                    (name, _) if n == 0 => name.to_owned(),
                    (name, _) => format!("{name}-{}", n + 1),
                };
                (n, count) = (n + 1, count + 1);
                let title = title(figure, &plot.title);
                pictures.extend(match plot.is_map() {
                    // One whose axes count nothing known is drawn in figures alone.
                    true => super::map(id, title, plot),
                    false => super::curves(id, title, &[plot]),
                });
            }
            match figure.name {
                "" => rows.extend(pictures.into_iter().map(|picture| vec![picture])),
                _ => rows.push(pictures),
            }
        }
    }
    rows.retain(|row| !row.is_empty());
    rows
}

/// Of a plot with this title.
fn title(figure: &FigureLayout, plot: &str) -> String {
    match (&*figure.title, plot) {
        (title, "") => title.to_owned(),
        ("", plot) => sentence_case(plot),
        (title, plot) => format!("{title}: {plot}"),
    }
}

fn table(table: &Table) -> Markup {
    let rows = table.rows.iter();
    let rows = rows.map(|row| row.iter().map(|cell| super::prose(cell)).collect());
    super::table(
        &table.title,
        &table.head,
        &rows.collect::<Vec<Vec<Markup>>>(),
    )
}
