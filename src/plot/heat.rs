//! Heat maps and their colour bars.

use ndarray::{Array2, ArrayView2, s};

use super::font;
use super::panel::{LabelSide, Panel, TICK_SIZE, label_upright};
use super::scale::{ColorScale, NO_VALUE};
use super::scene::{Anchor, FAINT, INK, Image, Mark, Rect, Scene, Text};

/// Most rows and columns of cells in a picture, so that an SVG of noise stays below 500 kB.
const MOST_CELLS: (usize, usize) = (400, 600);

/// Draws `values` (row 0 at the bottom) over the whole panel.
///
/// Returns how many rows and columns of values a cell of the picture stands for, at most.
pub(super) fn draw<T>(
    scene: &mut Scene,
    panel: &Panel,
    values: ArrayView2<T>,
    scale: &ColorScale,
) -> (usize, usize)
where
    T: Copy + Into<f64>,
{
    let most_rows = (panel.rect.height() as usize).min(MOST_CELLS.0);
    let most_columns = (panel.rect.width() as usize).min(MOST_CELLS.1);
    let blocks = block_extremes(values, most_rows, most_columns);
    let (rows, columns) = blocks.dim();
    if rows == 0 || columns == 0 {
        return (1, 1);
    }
    scene.marks.push(Mark::Image(Image {
        at: panel.rect,
        columns,
        rows,
        palette: scale.palette(),
        cells: blocks
            .rows()
            .into_iter()
            .rev()
            .flat_map(|row| row.to_vec())
            .map(|value| scale.index(value))
            .collect(),
    }));
    (
        values.nrows().div_ceil(rows),
        values.ncols().div_ceil(columns),
    )
}

/// At the lower right of the figure, `what` of how many samples each cell shows, if of several.
pub(super) fn reduction_note(scene: &mut Scene, what: &str, (rows, columns): (usize, usize)) {
    if rows * columns <= 1 {
        return;
    }
    scene.marks.push(Mark::Text(Text {
        text: format!(
            "each cell: {what} among up to {rows} (vertical) × {columns} (horizontal) samples"
        ),
        at: (
            f64::from(scene.width) - 30.0,
            f64::from(scene.height) - 18.0,
        ),
        size: 13.0,
        color: FAINT,
        anchor: Anchor::End,
        vertical: false,
    }));
}

/// The value of largest magnitude of each block, at most `most_rows` by `most_columns` of them.
///
/// Blocks are as even as whole samples allow; one is NaN only where all its values are.
pub(crate) fn block_extremes<T>(
    values: ArrayView2<T>,
    most_rows: usize,
    most_columns: usize,
) -> Array2<f64>
where
    T: Copy + Into<f64>,
{
    let (rows, columns) = values.dim();
    let shape = (rows.min(most_rows), columns.min(most_columns));
    Array2::from_shape_fn(shape, |(i, j)| {
        let rows = i * rows / shape.0..(i + 1) * rows / shape.0;
        let columns = j * columns / shape.1..(j + 1) * columns / shape.1;
        values
            .slice(s![rows, columns])
            .iter()
            .map(|&value| value.into())
            .fold(f64::NAN, |most: f64, value: f64| {
                if most.is_nan() || value.abs() > most.abs() {
                    value
                } else {
                    most
                }
            })
    })
}

/// The colour scale at the right of a panel, `width` 24 pixels, with its label.
pub(super) fn colour_bar(
    scene: &mut Scene,
    rect: Rect,
    scale: &ColorScale,
    quantity: &str,
    some_missing: bool,
) {
    let levels = scale.palette().len() - 1;
    scene.marks.push(Mark::Image(Image {
        at: rect,
        columns: 1,
        rows: levels,
        palette: scale.palette(),
        cells: (0..levels).rev().map(|level| level as u8).collect(),
    }));
    scene.outline(rect, INK);
    let mut widest = 0.0f64;
    let mut tick = |scene: &mut Scene, share: f64, text: String| {
        let y = rect.bottom - share * rect.height();
        scene.line(vec![(rect.right, y), (rect.right + 6.0, y)], INK, 1.0);
        widest = widest.max(font::width(&text, TICK_SIZE));
        scene.text(text, (rect.right + 11.0, y), TICK_SIZE, Anchor::Start);
    };
    let nearest = 1.3 * TICK_SIZE / rect.height();
    for mark in scale.ticks((rect.height() / 55.0) as usize) {
        match scale.share(mark.value) {
            Some(share) if !scale.holds_smaller() || share > nearest => {
                tick(scene, share, mark.text);
            }
            _ => {}
        }
    }
    if let Some(text) = scale.lowest_text() {
        tick(scene, 0.0, text);
    }
    let label = scale.label(quantity);
    let middle = (rect.top + rect.bottom) / 2.0;
    let at = (rect.right + 32.0 + widest, middle);
    label_upright(scene, &label, at, rect.height() + 20.0, LabelSide::Right);
    if some_missing {
        explain_missing(scene, rect);
    }
}

fn explain_missing(scene: &mut Scene, bar: Rect) {
    let swatch = Rect {
        top: bar.bottom + 18.0,
        bottom: bar.bottom + 36.0,
        ..bar
    };
    scene.fill(swatch, NO_VALUE);
    scene.outline(swatch, INK);
    let at = (swatch.right + 11.0, bar.bottom + 27.0);
    scene.text("no value", at, TICK_SIZE, Anchor::Start);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_keep_the_extremes() {
        let values = ndarray::array![[1.0, -5.0, f64::NAN], [2.0, 3.0, f64::NAN]];
        assert_eq!(
            block_extremes(values.view(), 1, 2),
            ndarray::array![[2.0, -5.0]]
        );
        assert!(block_extremes(values.view(), 2, 3)[[1, 2]].is_nan());
    }
}
