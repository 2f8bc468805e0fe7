//! One page that opens anywhere: pictures to hover, zoom and pick from, with the numbers.

mod curves;
mod data;
mod summary;
mod words;

use maud::{DOCTYPE, Markup, PreEscaped, html as markup};

use super::Advice;
use crate::analyze::Analysis;
use curves::CurveGroup;
use data::{MapData, Payload};

const PLOTLY: &str = include_str!("../../assets/plotly/plotly-cartesian.min.js");
const SCRIPT: &str = include_str!("../../assets/page.js");
const STYLE: &str = include_str!("../../assets/page.css");

/// Nothing is loaded: the page may only run its own scripts and show its own data.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      img-src data: blob:";

/// The analysis as a self-contained HTML page that needs no network.
///
/// `advice` says what to do about warnings and unresolved numbers. The maps are embedded as
/// little-endian `f32` (NaN where there is no value), so that hovering and the curves beside each
/// map read the same numbers that the colours show.
pub fn html(analysis: &Analysis, advice: Advice) -> String {
    let payload = Payload::of(analysis);
    let page = markup! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="color-scheme" content="light dark";
                title { (analysis.name) " – cascade" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (analysis.name) }
                    p { (summary::sentence(analysis)) }
                }
                (summary::answer(analysis, advice))
                noscript {
                    p class="warning" {
                        "The pictures need JavaScript, which is off; tables and definitions do not."
                    }
                }
                main {
                    (summary::warnings(&analysis.warnings, advice))
                    @for map in &payload.maps { (map_figure(map)) }
                    @for group in &payload.curves { (curve_figure(group)) }
                    (summary::tables(analysis, advice))
                    (words::how_to_read(analysis))
                    (summary::provenance(analysis))
                }
                script type="application/json" id="data" { (PreEscaped(payload.json())) }
                script { (PreEscaped(PLOTLY)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    page.into_string()
}

fn map_figure(map: &MapData) -> Markup {
    let heading = format!("{}-heading", map.id);
    markup! {
        section id=(map.id) class="map" aria-labelledby=(heading) {
            h2 id=(heading) { (map.title) }
            div class="tools" {
                fieldset {
                    legend { "Scale" }
                    button type="button" data-scale="log" { "log" }
                    button type="button" data-scale="linear" { "linear" }
                }
                fieldset {
                    legend { "Curve along" }
                    button type="button" data-along="y" { (map.y.label) }
                    button type="button" data-along="x" { (map.x.label) }
                }
                button type="button" data-reset { "whole picture" }
                (downloads())
            }
            figure {
                div class="picture" tabindex="0" role="img"
                    aria-label={ (map.title) ". Arrow keys move the picked cell, plus and minus zoom, 0 shows all." } {}
                div class="curve" {}
                output class="readout" { "Hover to read values; click to pick; drag to zoom." }
                figcaption { (map.caption) " " span class="note" {} }
            }
        }
    }
}

fn downloads() -> Markup {
    markup! {
        fieldset {
            legend { "Save" }
            button type="button" data-png { "PNG" }
            button type="button" data-csv { "CSV" }
        }
    }
}

fn curve_figure(group: &CurveGroup) -> Markup {
    let heading = format!("{}-heading", group.id);
    markup! {
        section id=(group.id) class="curves" aria-labelledby=(heading) {
            h2 id=(heading) { (group.title) }
            div class="tools" { (downloads()) }
            figure {
                div class="curve" {}
                figcaption { (group.caption) " " span class="note" {} }
            }
        }
    }
}
