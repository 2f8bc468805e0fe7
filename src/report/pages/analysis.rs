//! The page of an analysis.

mod curves;
mod evidence;
mod maps;
mod words;

use super::sheet::page_of;
use crate::analyze::Analysis;
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
    // Moves along the profile beside the spectra that they are read off.
    let moved = evidence::of(analysis).into_iter();
    let moved = moved.map(|row| row.into_iter().map(Picture::from).collect());
    let maps = maps::of(analysis).into_iter().map(Picture::from);
    let curves = curves::of(analysis).into_iter().map(Picture::from);
    let rows = moved
        .chain(maps.chain(curves).map(|picture| vec![picture]))
        .collect();
    page_of(sheet, rows, &analysis.name, provenance, style)
}
