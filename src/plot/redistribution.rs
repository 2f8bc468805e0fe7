//! The content along x and along t: two panels of curves each.

use std::ops::Range;

use super::axis::{around, log_around};
use super::labels::Side;
use super::layout::FigureLayout;
use super::style::Style;
use super::{DECADES, Figure, labels};
use crate::analyze::{Analysis, Extent, Moments};
use crate::sheet::PlotRow;
use crate::sheet::{BLUE, Chart, GREEN, PURPLE, Series, VERMILLION, extent};
use crate::unit::power_of_ten;

/// Frequency content along x: centroid, median, 90 % frequency, energy.
pub fn along_x(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let moments = analysis.along_space.as_ref()?;
    let axes = &analysis.axes;
    let sheet = RedistributionFigure {
        title: "Frequency content along x",
        name: &analysis.name,
        moments,
        along: &axes.positions(),
        extent: &analysis.display.space,
        content: &analysis.display.frequency,
        not_shown: labels::not_shown(analysis, &[Side::Space], true),
        along_label: labels::position(axes),
        content_label: labels::frequency(axes),
        second: None,
        row_label: "site",
        energy_label: labels::site_energy(analysis),
    };
    Some(sheet.draw("along-x", style))
}

/// Wavenumber content along t: centroid, median, 90 % wavenumber, energy.
pub fn along_t(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let moments = analysis.along_time.as_ref()?;
    let axes = &analysis.axes;
    let sheet = RedistributionFigure {
        title: "Wavenumber content along t",
        name: &analysis.name,
        moments,
        along: &axes.times(),
        extent: &analysis.display.time,
        content: &analysis.display.wavenumber,
        not_shown: labels::not_shown(analysis, &[Side::Time], true),
        along_label: labels::time(axes),
        content_label: labels::wavenumber(axes),
        second: labels::wavenumber_reading(axes),
        row_label: "time",
        energy_label: labels::time_energy(analysis),
    };
    Some(sheet.draw("along-t", style))
}

struct RedistributionFigure<'a> {
    title: &'static str,
    name: &'a str,
    moments: &'a Moments,
    along: &'a [f64],
    /// The part of `along` that is shown.
    extent: &'a Extent,
    /// The part of the frequencies or wavenumbers that is shown.
    content: &'a Extent,
    not_shown: Option<String>,
    along_label: String,
    content_label: String,
    second: Option<(String, f64)>,
    row_label: &'static str,
    energy_label: String,
}

impl RedistributionFigure<'_> {
    fn draw(self, name: &'static str, style: &Style) -> Figure {
        let sheet = FigureLayout {
            title: self.title.into(),
            data: self.name.into(),
            rows: vec![
                PlotRow::of([self.content()]).high(0.8),
                PlotRow::of([self.energies()]).high(0.5),
            ],
            notes: self.notes(),
            shared_x: true,
        };
        sheet.figure(name, style)
    }

    fn chart(&self, label: &str, y: Range<f64>, series: Vec<Series>) -> Chart {
        Chart {
            x: extent(self.shown(self.along).iter().copied()),
            y,
            ..Chart::of("", &self.along_label, label, series)
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
            second_y: self.second.clone(),
            ..self.chart(&self.content_label, y, curves)
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
        let not_shown = self.not_shown.iter().cloned();
        below.into_iter().chain(not_shown).collect()
    }

    fn curve(&self, label: &str, colour: usize, y: &[f64]) -> Series {
        Series::of(label, colour, self.shown(self.along), self.shown(y))
    }

    /// The values along x or t that are shown.
    fn shown<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[self.extent.bins.clone()]
    }

    /// Frequencies or wavenumbers, without those beyond the display limits: a row of little energy
    /// would stretch the axis.
    fn within_limits(&self, values: &[f64]) -> Vec<f64> {
        let extent = self.content;
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
