//! The page of an analysis.

mod curves;
mod evidence;
mod maps;
mod summary;
mod words;

use maud::{Markup, html as markup};

use crate::analyze::{Analysis, BandEdge};
use crate::plot::Style;
use crate::report::page::{Page, Picture, sentence_case};
use crate::report::{Advice, AnswerWords};

/// The analysis as a self-contained HTML page that needs no network.
///
/// `advice` says what to do about warnings and unresolved numbers. Maps have the colours of
/// `style`.
pub fn analysis_html(analysis: &Analysis, advice: Advice, style: &Style) -> String {
    let moved = evidence::of(analysis).into_iter().map(Picture::from);
    let maps = maps::of(analysis).into_iter().map(Picture::from);
    let curves = curves::of(analysis).into_iter().map(Picture::from);
    let pictures = moved.chain(maps).chain(curves);
    let words = AnswerWords::of(analysis);
    let page = Page {
        title: analysis.name.clone(),
        sentence: summary::sentence(analysis),
        answers: words.as_ref().map_or(Markup::default(), summary::answer),
        warnings: summary::warnings(analysis, advice),
        rows: pictures.map(|picture| vec![picture]).collect(),
        rest: markup! {
            (summary::tables(analysis, advice))
            (words::how_to_read(analysis))
            (summary::provenance(analysis))
        },
        style: *style,
    };
    match words {
        Some(words) => page.html_headed(&sentence_case(&words.verdict), &words.numbers),
        // Nothing is said of a field without energy.
        None if analysis.headline_space.last.is_none() && analysis.headline_time.last.is_none() => {
            page.html_headed("What moves cannot be told: nothing moves", "")
        }
        None => page.html(),
    }
}

/// Where a band edge is marked.
fn value(edge: Option<BandEdge>) -> Option<f64> {
    edge.map(|edge| edge.value())
        .filter(|value| value.is_finite())
}
