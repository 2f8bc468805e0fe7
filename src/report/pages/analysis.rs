//! The page of an analysis.

mod curves;
mod maps;
mod summary;
mod words;

use maud::html as markup;

use crate::analyze::{Analysis, BandEdge};
use crate::plot::Style;
use crate::report::Advice;
use crate::report::page::{Page, Picture};

/// The analysis as a self-contained HTML page that needs no network.
///
/// `advice` says what to do about warnings and unresolved numbers. Maps have the colours of
/// `style`.
pub fn analysis_html(analysis: &Analysis, advice: Advice, style: &Style) -> String {
    let maps = maps::of(analysis).into_iter().map(Picture::from);
    let curves = curves::of(analysis).into_iter().map(Picture::from);
    let page = Page {
        title: analysis.name.clone(),
        sentence: summary::sentence(analysis),
        answers: summary::answer(analysis, advice),
        warnings: summary::warnings(analysis, advice),
        rows: maps.chain(curves).map(|picture| vec![picture]).collect(),
        rest: markup! {
            (summary::tables(analysis, advice))
            (words::how_to_read(analysis))
            (summary::provenance(analysis))
        },
        style: *style,
    };
    page.html()
}

/// Where a band edge is marked.
fn value(edge: Option<BandEdge>) -> Option<f64> {
    edge.map(|edge| edge.value())
        .filter(|value| value.is_finite())
}
