//! The content along x and along t: two panels of curves each.

use std::ops::Range;

use super::axis::{around, log_around};
use super::labels::Side;
use super::layout::FigureLayout;
use super::style::Style;
use super::{DECADES, Figure, labels};
use crate::analyze::labels::Power;
use crate::analyze::{Analysis, Moments};
use crate::sheet::{BLUE, Chart, GREEN, PURPLE, PlotRow, Series, VERMILLION, extent};
use crate::unit::power_of_ten;

/// Frequency content along x: centroid, median, 90 % frequency, energy.
pub fn along_x(analysis: &Analysis, style: &Style) -> Option<Figure> {
    Some(Content::along_x(analysis)?.draw(style))
}

/// Wavenumber content along t: centroid, median, 90 % wavenumber, energy.
pub fn along_t(analysis: &Analysis, style: &Style) -> Option<Figure> {
    Some(Content::along_t(analysis)?.draw(style))
}

/// Where the energy lies in frequency or wavenumber, along x or t.
pub(crate) struct Content<'a> {
    analysis: &'a Analysis,
    /// Of the figure, and on pages.
    pub id: &'static str,
    pub title: &'static str,
    pub moments: &'a Moments,
    pub along: Vec<f64>,
    /// What it is along, and of which content.
    pub sides: [Side; 2],
    row_label: &'static str,
    pub energy_label: String,
}

impl<'a> Content<'a> {
    pub fn along_x(analysis: &'a Analysis) -> Option<Self> {
        Some(Content {
            analysis,
            id: "along-x",
            title: "Frequency content along x",
            moments: analysis.along_space.as_ref()?,
            along: analysis.axes.positions(),
            sides: [Side::Space, Side::Frequency],
            row_label: "site",
            energy_label: Power::of(analysis).of_site(),
        })
    }

    pub fn along_t(analysis: &'a Analysis) -> Option<Self> {
        Some(Content {
            analysis,
            id: "along-t",
            title: "Wavenumber content along t",
            moments: analysis.along_time.as_ref()?,
            along: analysis.axes.times(),
            sides: [Side::Time, Side::Wavenumber],
            row_label: "time",
            energy_label: Power::of(analysis).of_time(),
        })
    }

    fn draw(self, style: &Style) -> Figure {
        let sheet = FigureLayout {
            title: self.title.into(),
            data: self.analysis.name.clone(),
            rows: vec![
                PlotRow::of([self.content()]).high(0.8),
                PlotRow::of([self.energies()]).high(0.5),
            ],
            notes: self.notes(),
            shared_x: true,
        };
        sheet.figure(self.id, style)
    }

    fn chart(&self, label: &str, y: Range<f64>, series: Vec<Series>) -> Chart {
        Chart {
            x: extent(self.shown(&self.along).iter().copied()),
            y,
            ..Chart::of("", self.sides[0].label(&self.analysis.axes), label, series)
        }
    }

    fn content(&self) -> Chart {
        let Moments {
            centroid,
            median,
            quantile_90,
            ..
        } = self.moments;
        let [centroid, median, quantile_90] =
            [centroid, median, quantile_90].map(|values| self.within_limits(values));
        let all = [&centroid, &median, &quantile_90].map(|values| self.shown(values));
        let y = around(all.into_iter().flatten().copied());
        let curves = vec![
            self.curve("90 % of the energy lies below", VERMILLION, &quantile_90),
            self.curve("centroid", BLUE, &centroid),
            self.curve("median", GREEN, &median),
        ];
        Chart {
            second_y: self.sides[1].second_reading(&self.analysis.axes),
            ..self.chart(&self.sides[1].label(&self.analysis.axes), y, curves)
        }
    }

    fn energies(&self) -> Chart {
        let (y, log_y) = self.energy_range();
        let scale = if log_y { ", log scale" } else { "" };
        let label = format!(
            "energy of each {} (integral of its spectrum){scale}",
            self.row_label
        );
        let energy = self.moments.energy.iter();
        let shown: Vec<f64> = energy
            .map(|e| if *e < y.start { y.start } else { *e })
            .collect();
        let curves = vec![self.curve(&label, PURPLE, &shown)];
        Chart {
            log_y,
            ..self.chart(&self.energy_label, y, curves)
        }
    }

    /// The range of the axis of energies, and whether it is logarithmic: energies within a factor of
    /// ten are compared on a linear axis.
    fn energy_range(&self) -> (Range<f64>, bool) {
        let energy = || self.shown(&self.moments.energy).iter().copied();
        let most = energy().fold(0.0, f64::max);
        match energy().any(|e| 10.0 * e < most) {
            true => (log_around(energy(), DECADES), true),
            false => (around(energy()), false),
        }
    }

    /// What the curves do not say of themselves.
    fn notes(&self) -> Vec<String> {
        let (range, _) = self.energy_range();
        let is_below = self
            .shown(&self.moments.energy)
            .iter()
            .any(|e| *e < range.start);
        let below = is_below.then(|| {
            let floor = power_of_ten(-DECADES as i32);
            format!("Energies below {floor} of the largest are drawn at the lower edge.")
        });
        let not_shown = labels::not_shown(self.analysis, &self.sides[..1], true);
        below.into_iter().chain(not_shown).collect()
    }

    fn curve(&self, label: &str, colour: usize, y: &[f64]) -> Series {
        Series::of(label, colour, self.shown(&self.along), self.shown(y))
    }

    /// The values along x or t that are shown.
    fn shown<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[self.sides[0].extent(self.analysis).bins.clone()]
    }

    /// Frequencies or wavenumbers, without those beyond the display limits: a row of little energy
    /// would stretch the axis.
    fn within_limits(&self, values: &[f64]) -> Vec<f64> {
        let extent = self.sides[1].extent(self.analysis);
        let half = 0.5 * (extent.high - extent.low) / (extent.bins.len() as f64 - 1.0).max(1.0);
        let limits = match extent.is_whole() {
            true => (f64::NEG_INFINITY, f64::INFINITY),
            false => (extent.low - half, extent.high + half),
        };
        let is_shown = |value: f64| value >= limits.0 && value <= limits.1;
        let values = values.iter();
        values
            .map(|&value| if is_shown(value) { value } else { f64::NAN })
            .collect()
    }
}
