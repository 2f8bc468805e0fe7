//! The page of an analysis.

mod curves;
mod evidence;
mod maps;
mod words;

use super::sheet::page_of;
use crate::analyze::{Analysis, BandEdge};
use crate::plot::Style;
use crate::report::Provenance;
use crate::report::page::Picture;
use crate::sheet::Sheet;

/// The page of an analysis with its sheet. Maps have the colours of `style`.
///
/// # Errors
/// None for results of this library.
pub fn analysis_html(
    analysis: &Analysis,
    sheet: &Sheet,
    provenance: &Provenance,
    style: &Style,
) -> serde_json::Result<String> {
    let moved = evidence::of(analysis).into_iter().map(Picture::from);
    let maps = maps::of(analysis).into_iter().map(Picture::from);
    let curves = curves::of(analysis).into_iter().map(Picture::from);
    let pictures = moved.chain(maps).chain(curves);
    let rows = pictures.map(|picture| vec![picture]).collect();
    page_of(sheet, rows, &analysis.name, provenance, style)
}

/// Where a band edge is marked.
fn value(edge: Option<BandEdge>) -> Option<f64> {
    edge.map(|edge| edge.value())
        .filter(|value| value.is_finite())
}
