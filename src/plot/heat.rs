//! Heat maps and their colour bars.

use ndarray::ArrayView2;

use super::font;
use super::panel::{LABEL_SIZE, Panel, TICK_SIZE, vertical_text};
use super::scale::{NO_VALUE, Scale};
use super::scene::{Anchor, INK, Image, Mark, Rect, Scene};

/// Draws `values` (row 0 at the bottom) over the whole panel.
pub(super) fn draw<T>(scene: &mut Scene, panel: &Panel, values: ArrayView2<T>, scale: &Scale)
where
    T: Copy + Into<f64>,
{
    let most_rows = panel.rect.height() as usize;
    let most_columns = panel.rect.width() as usize;
    let blocks = block_extremes(values, most_rows, most_columns);
    let (rows, columns) = blocks.dim();
    if rows == 0 || columns == 0 {
        return;
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
}

/// The value of largest magnitude of each block, at most `most_rows` by `most_columns` of them.
///
/// A block is NaN only where all its values are.
pub fn block_extremes<T>(
    values: ArrayView2<T>,
    most_rows: usize,
    most_columns: usize,
) -> ndarray::Array2<f64>
where
    T: Copy + Into<f64>,
{
    let (rows, columns) = values.dim();
    let tall = rows.div_ceil(most_rows.max(1)).max(1);
    let wide = columns.div_ceil(most_columns.max(1)).max(1);
    let shape = (rows.div_ceil(tall), columns.div_ceil(wide));
    ndarray::Array2::from_shape_fn(shape, |(i, j)| {
        let (bottom, left) = (i * tall, j * wide);
        let block = values.slice(ndarray::s![
            bottom..(bottom + tall).min(rows),
            left..(left + wide).min(columns)
        ]);
        block
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
    scale: &Scale,
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
    let size = font::fit(&label, LABEL_SIZE, rect.height() + 20.0);
    vertical_text(scene, &label, (rect.right + 32.0 + widest, middle), size);
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
