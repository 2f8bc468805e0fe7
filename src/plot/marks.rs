//! Vertical lines over a chart, and the positions of the labels at their upper ends.

use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;

use super::canvas::{CanvasSurface, px, sans};
use super::font;
use crate::Result;

/// Size of the labels in pixels, the distance of their rows, and their margin.
const SIZE: f64 = 13.0;
const ROW: f64 = 17.0;
const GAP: f64 = 3.0;

/// An upright line at an abscissa, with a word at its upper end.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    pub at: f64,
    pub label: String,
}

/// Draws marks from the lower to the upper end of a chart's vertical axis.
pub(super) fn draw_marks<X, Y>(
    chart: &mut ChartContext<'_, CanvasSurface, Cartesian2d<X, Y>>,
    marks: &[Mark],
    (bottom, top): (f64, f64),
    colour: RGBColor,
) -> Result<()>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let words: Vec<(i32, i32)> = marks
        .iter()
        .map(|mark| {
            let (line, _) = chart.backend_coord(&(mark.at, top));
            (line, px(font::width(&mark.label, SIZE)) as i32)
        })
        .collect();
    let (across, _) = chart.plotting_area().get_pixel_range();
    let places = places(&words, across.end, px(GAP) as i32);
    for ((mark, (line, _)), (left, row)) in marks.iter().zip(words).zip(places) {
        let upright = [(mark.at, bottom), (mark.at, top)];
        let style = colour.stroke_width(px(1.0));
        chart.draw_series(DashedLineSeries::new(upright, px(4.0), px(4.0), style))?;
        let off = (left - line, px(GAP + ROW * row as f64) as i32);
        let word = Text::new(mark.label.clone(), off, sans(SIZE).color(&colour));
        chart.draw_series([EmptyElement::at((mark.at, top)) + word])?;
    }
    Ok(())
}

/// Left end and row of each word, given its line and its width: to the right of its line, or to the
/// left where the chart ends before the word; in the first row where it touches no word before it.
fn places(words: &[(i32, i32)], end: i32, gap: i32) -> Vec<(i32, usize)> {
    let mut places: Vec<(i32, usize)> = Vec::new();
    for (i, &(line, width)) in words.iter().enumerate() {
        let left = match line + gap + width <= end {
            true => line + gap,
            false => line - gap - width,
        };
        let touched = |row: usize| {
            let before = places.iter().zip(&words[..i]);
            before
                .filter(|((_, r), _)| *r == row)
                .any(|((l, _), (_, w))| left < l + w + gap && *l < left + width + gap)
        };
        let row = (0..i).find(|row| !touched(*row)).unwrap_or(i);
        places.push((left, row));
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_inside_and_touch_no_other() {
        // Far apart; crowded, where every other one is lower; at the end; and out of order.
        let words = [
            (0, 20),
            (100, 20),
            (110, 20),
            (123, 20),
            (195, 20),
            (60, 45),
        ];
        assert_eq!(
            places(&words, 200, 3),
            [(3, 0), (103, 0), (113, 1), (126, 0), (172, 0), (63, 1)]
        );
    }
}
