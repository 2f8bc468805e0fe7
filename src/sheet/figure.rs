//! Figures as data: plots in rows.

use super::Chart;

/// Plots beside each other.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotRow {
    pub plots: Vec<Chart>,
    /// Cells that the row is divided into.
    pub columns: usize,
    /// Height of its frames over the usual one, where they are wide enough: no frame is higher than 0.62 of its width.
    pub height: f64,
}

impl PlotRow {
    /// A row that its plots fill.
    pub fn of(plots: impl IntoIterator<Item = Chart>) -> PlotRow {
        let plots: Vec<Chart> = plots.into_iter().collect();
        PlotRow {
            columns: plots.len().max(1),
            plots,
            height: 1.0,
        }
    }

    pub fn high(self, height: f64) -> PlotRow {
        PlotRow { height, ..self }
    }

    /// Rows of so many plots.
    pub fn grid(columns: usize, plots: impl IntoIterator<Item = Chart>) -> Vec<PlotRow> {
        let plots: Vec<Chart> = plots.into_iter().collect();
        let rows = plots.chunks(columns.max(1)).map(|plots| PlotRow {
            columns: columns.max(1),
            ..PlotRow::of(plots.to_vec())
        });
        rows.collect()
    }
}

/// Rows of plots under a heading. Frames in rows of as many cells are aligned; names that all charts
/// have in common are given once, above. A page has a part for each plot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FigureLayout {
    /// Of its file and of its part of a page; empty for those of the result.
    pub name: &'static str,
    /// Empty for that of the result.
    pub title: String,
    /// Name of the data, beside the title; may be empty.
    pub data: String,
    pub rows: Vec<PlotRow>,
    /// Paragraphs below the plots.
    pub notes: Vec<String>,
    /// Whether only the lowest row names the horizontal axis.
    pub shared_x: bool,
    /// Whether it has no file of its own.
    pub is_on_page_only: bool,
}

impl FigureLayout {
    /// A row of plots without a file of its own.
    pub(crate) fn on_page(
        name: &'static str,
        plots: impl IntoIterator<Item = Chart>,
    ) -> FigureLayout {
        FigureLayout {
            name,
            rows: vec![PlotRow::of(plots)],
            is_on_page_only: true,
            ..FigureLayout::default()
        }
    }

    /// Plots in rows of `columns`.
    pub fn grid(
        title: impl Into<String>,
        columns: usize,
        plots: impl IntoIterator<Item = Chart>,
    ) -> FigureLayout {
        FigureLayout {
            title: title.into(),
            rows: PlotRow::grid(columns, plots),
            ..FigureLayout::default()
        }
    }
}
