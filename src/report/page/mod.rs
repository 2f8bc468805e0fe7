//! Pages of results, and of several fields: a self-contained HTML page whose pictures are drawn by its
//! own script, and the tables and paragraphs around them.

mod curves;
mod fields;
mod map;
mod sheet;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, Render, html as markup};
use serde_json::{Value, json};

use crate::plot::{self, Depth, Style};
use crate::sheet::Warning;
use curves::curves;
pub use fields::fields_html;
use map::{map, page_opens};
pub use sheet::sheet_html;

const PLOTLY: &str = include_str!("../../../assets/plotly/plotly-cartesian.min.js");
const SCRIPT: &str = include_str!("../../../assets/page.js");
const STYLE: &str = include_str!("../../../assets/page.css");

/// Nothing is loaded: the page may only run its own scripts and show its own data.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      img-src data: blob:";

/// A picture that the script draws, and what stands around it.
struct Picture {
    id: String,
    title: String,
    caption: String,
    /// Labels of x and y of a map.
    axes: Option<[String; 2]>,
    /// Whether the page shows a part of it at first.
    opens_on_part: bool,
    /// What the script takes.
    data: Value,
}

/// A page from top to bottom.
#[derive(Default)]
struct Page {
    pub title: String,
    /// What was computed, in one sentence.
    pub sentence: String,
    /// The questions with their answers.
    pub answers: Markup,
    pub warnings: Markup,
    /// Pictures that compare stand in one row.
    pub rows: Vec<Vec<Picture>>,
    /// Numbers, definitions, provenance.
    pub rest: Markup,
    /// Colours of the maps; the rest of a style is for figures.
    pub style: Style,
}

impl Page {
    /// The page as HTML that needs no network, under a verdict and its numbers. What the verdict rests on, the first
    /// pictures, follows at once, with the answers beside it; then come warnings.
    ///
    /// Maps are embedded as little-endian `f32` (NaN where there is no value), curves as `f64`, so that hovering and the
    /// curves beside each map read the same numbers that the colours show.
    pub fn html(&self, verdict: &str, numbers: &str) -> String {
        let (first, others) = match self.rows.split_first() {
            Some((first, others)) => (&first[..], others),
            None => (&[][..], &[][..]),
        };
        let page = markup! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="color-scheme" content="light dark";
                    title { (self.title) " – cascade" }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        p { b { (self.title) } ": " (self.sentence) }
                        h1 { (prose(verdict)) }
                        @if !numbers.is_empty() { p class="numbers" { (prose(numbers)) } }
                    }
                    @if !self.rows.is_empty() {
                        noscript {
                            p class="warning" {
                                "The pictures need JavaScript, which is off; tables and definitions do not."
                            }
                        }
                    }
                    main {
                        @if self.answers.0.is_empty() { (row(first)) } @else {
                            div class="lead" {
                                (row(first))
                                section id="answer" { (self.answers) }
                            }
                        }
                        (self.warnings)
                        @for pictures in others { (row(pictures)) }
                        (self.rest)
                    }
                    @if !self.rows.is_empty() {
                        script type="application/json" id="data" { (PreEscaped(self.payload())) }
                        script { (PreEscaped(PLOTLY)) }
                        script { (PreEscaped(SCRIPT)) }
                    }
                }
            }
        };
        page.into_string()
    }

    /// JSON that cannot end the script element around it.
    fn payload(&self) -> String {
        let Style {
            colormap, depth, ..
        } = self.style;
        let (decades, fixed) = match depth {
            Depth::Fitted => (plot::DECADES, false),
            Depth::Decades(decades) => (decades, true),
            Depth::Decibels(db) => (db / 10.0, true),
        };
        // 256 colours, the last for cells without a value.
        let palette =
            |is_signed| BASE64_STANDARD.encode(plot::palette(is_signed, colormap).concat());
        let pictures = self.rows.iter().flatten().map(|picture| &picture.data);
        let payload = json!({
            "sequential": palette(false),
            "diverging": palette(true),
            // Of logarithmic colours: at most, or exactly if fixed.
            "decades": decades,
            "fixed": fixed,
            "pictures": pictures.collect::<Vec<_>>(),
        });
        payload.to_string().replace('<', "\\u003c")
    }
}

fn doubles(values: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<[u8; 8]> = values.into_iter().map(f64::to_le_bytes).collect();
    BASE64_STANDARD.encode(bytes.as_flattened())
}

fn singles(values: impl Iterator<Item = f32>) -> String {
    let bytes: Vec<[u8; 4]> = values.map(f32::to_le_bytes).collect();
    BASE64_STANDARD.encode(bytes.as_flattened())
}

fn row(pictures: &[Picture]) -> Markup {
    markup! {
        @if let [picture] = pictures {
            (section(picture))
        } @else if !pictures.is_empty() {
            div class="row" { @for picture in pictures { (section(picture)) } }
        }
    }
}

fn section(picture: &Picture) -> Markup {
    let (id, title) = (&picture.id, &picture.title);
    let heading = format!("{id}-heading");
    let kind = match picture.axes {
        Some(_) => "map",
        None => "curves",
    };
    markup! {
        section id=(id) class=(kind) aria-labelledby=(heading) {
            h2 id=(heading) { (title) }
            div class="tools" {
                @if let Some([x, y]) = &picture.axes {
                    fieldset {
                        legend { "Scale" }
                        button type="button" data-scale="log" { "log" }
                        button type="button" data-scale="linear" { "linear" }
                    }
                    fieldset {
                        legend { "Curve along" }
                        button type="button" data-along="y" { (without_unit(y)) }
                        button type="button" data-along="x" { (without_unit(x)) }
                    }
                }
                fieldset {
                    legend { "Zoom" }
                    button type="button" data-zoom="0.5" aria-label="zoom in" { "+" }
                    button type="button" data-zoom="2" aria-label="zoom out" { "−" }
                    button type="button" data-reset { "all" }
                    @if picture.opens_on_part { button type="button" data-home { "limits" } }
                }
                fieldset {
                    legend { "Save" }
                    button type="button" data-png { "PNG" }
                    button type="button" data-csv { "CSV" }
                }
            }
            figure {
                @if picture.axes.is_some() {
                    div class="picture" tabindex="0" role="img"
                        aria-label={ (title) ". Arrow keys move the picked cell, plus and minus zoom, 0 resets." } {}
                }
                div class="curve" {}
                @if picture.axes.is_some() {
                    output class="readout" { "Hover to read values; click to pick; drag to zoom." }
                }
                (caption(&picture.caption))
            }
        }
    }
}

/// The first sentence; others are folded below it.
fn caption(text: &str) -> Markup {
    markup! {
        figcaption {
            @match text.split_once(". ") {
                Some((first, others)) => details {
                    summary { (prose(first)) "." }
                    p { (prose(others)) }
                },
                None => (prose(text)),
            }
            " "
            span class="note" {}
        }
    }
}

fn without_unit(label: &str) -> &str {
    label.split(['(', '[']).next().unwrap_or(label).trim_end()
}

/// Answers by their names, close together.
fn facts(named: &[(&str, String)]) -> Markup {
    markup! {
        dl class="facts" {
            @for (name, text) in named { div { dt { (name) } dd { (prose(text)) } } }
        }
    }
}

/// Each warning with what to do about it, if that is known. Without warnings, nothing.
fn warnings(warnings: &[Warning]) -> Markup {
    markup! {
        @if !warnings.is_empty() {
            section id="warnings" aria-labelledby="warnings-heading" {
                h2 id="warnings-heading" { "Warnings" }
                ul {
                    @for Warning { message, advice, .. } in warnings {
                        li class="warning" {
                            strong { (sentence_case(message)) "." }
                            @if !advice.is_empty() { " " (prose(&sentence_case(advice))) "." }
                        }
                    }
                }
            }
        }
    }
}

/// Tables under one heading.
fn numbers(tables: Markup) -> Markup {
    markup! {
        section id="summary" aria-labelledby="summary-heading" {
            h2 id="summary-heading" { "Summary" }
            (tables)
        }
    }
}

/// A table, without a head of names and values; one of several columns scrolls by itself where it is wide.
fn table<C: Render>(title: &str, head: &[String], rows: &[Vec<C>]) -> Markup {
    let whole = markup! {
        table {
            caption { (title) }
            @if !head.is_empty() {
                thead { tr { @for name in head { th scope="col" { (name) } } } }
            }
            tbody {
                @for row in rows {
                    tr {
                        @for (index, cell) in row.iter().enumerate() {
                            @if index == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                        }
                    }
                }
            }
        }
    };
    match head.is_empty() {
        true => whole,
        false => markup! { div class="scroll" { (whole) } },
    }
}

/// A part that is folded until it is asked for.
fn folded(id: &str, title: &str, content: Markup) -> Markup {
    markup! {
        section id=(id) {
            details {
                summary { h2 { (title) } }
                (content)
            }
        }
    }
}

/// How the pictures are used, and what words mean.
fn how_to_read(definitions: &[[&str; 2]]) -> Markup {
    let content = markup! {
        p {
            "Hover a picture to read it, drag to zoom, double-click to reset; with a finger, tap to \
             read and zoom by the buttons. A picture may open on the part of its axes that holds \
             nearly all of the energy; “all” shows the rest. A click \
             in a map picks a cell: the curve beside it runs through it, and the other pictures \
             follow to the same site, time, frequency or wavenumber. With the keyboard: arrows \
             move the pick, + and − zoom, 0 resets."
        }
        dl {
            @for [term, meaning] in definitions { dt { (term) } dd { (meaning) } }
        }
    };
    folded("how-to-read", "How to read this", content)
}

fn sentence_case(text: &str) -> String {
    let mut rest = text.chars();
    match rest.next() {
        Some(first) => first.to_uppercase().chain(rest).collect(),
        None => String::new(),
    }
}

/// Text whose parts between backticks are code. A number and its % stay in one line.
fn prose(text: &str) -> Markup {
    let text = text.replace(" %", "\u{a0}%");
    markup! {
        @for (index, part) in text.split('`').enumerate() {
            @if index % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}
