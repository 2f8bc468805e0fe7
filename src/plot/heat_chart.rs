//! The cells of a map, their scale and its colour bar.

use super::heat::{self, ColorBar, Greys};
use super::scale::Scale;
use super::scene::{Image, Rect};
use super::style::{Colormap, Style};
use crate::sheet::{Chart, Colors, Map, Reduction};

/// The colour bar of a map, or of maps that share the scale of the first; the greys are those of all.
pub(super) fn color_bar<'a>(maps: &[&'a Chart], style: &Style) -> Option<ColorBar<'a>> {
    let first = maps.first().filter(|map| map.is_map())?;
    let misses = |map: &&Chart| map.shown_values().any(|value| !value.is_finite());
    Some(ColorBar {
        scale: first.scale(style),
        quantity: &first.label,
        greys: Greys {
            missing: maps.iter().any(misses),
            both_signs: maps.iter().any(|map| map.holds_both_signs()),
        },
    })
}

impl Chart {
    fn shown(&self) -> Option<&Map> {
        self.reduced.as_deref().map(Map::shown)
    }

    fn shown_values(&self) -> impl Iterator<Item = f64> {
        let reduced = self.shown().into_iter();
        let reduced = reduced.flat_map(|map| map.values.iter().map(|value| f64::from(*value)));
        reduced.chain(self.values.iter().copied())
    }

    fn holds_both_signs(&self) -> bool {
        self.shown().is_some_and(heat::holds_both_signs)
    }

    /// Of its colours.
    pub(super) fn scale(&self, style: &Style) -> Scale {
        match (&self.colors, self.shared) {
            (Colors::Between(range), _) => Scale::linear(range.start, range.end),
            (Colors::Signed { limit, decades }, _) => Scale::signed(*limit, *decades),
            (Colors::Powers, Some(ends)) => Scale::fitted(ends.into_iter(), style.depth),
            (Colors::Powers, None) => Scale::fitted(self.shown_values(), style.depth),
        }
    }

    /// What a cell of a frame of this size shows, and of how many samples.
    pub(super) fn cell(&self, rect: &Rect) -> (&'static str, [usize; 2]) {
        let (reduction, shape) = match self.shown() {
            None => (
                Reduction::Max {
                    rows: 1,
                    columns: 1,
                },
                self.values.dim(),
            ),
            Some(map) => (map.reduction, map.values.dim()),
        };
        let ((rows, columns), cell) = (reduction.samples(), heat::cell_of(rect, shape));
        (reduction.shows(), [rows * cell.0, columns * cell.1])
    }

    /// Its cells over a frame.
    pub(super) fn image(&self, rect: Rect, scale: &Scale, colormap: Colormap) -> Image {
        match self.shown() {
            Some(map) if self.holds_both_signs() => heat::signed_image(rect, map, scale, colormap),
            Some(map) => heat::image(rect, map.values.view(), scale, colormap),
            None => heat::image(rect, self.values.view(), scale, colormap),
        }
    }
}
