//! What a slope says.

use std::ops::Range;

use serde_json::json;

use super::{ExponentBasis, Slope};
use crate::measure::cycles_per;
use crate::sheet::{
    BLACK, BLUE, Chart, Describe, GREEN, Level, Look, Mark, Marker, PlotRow, Series, Sheet, Table,
    Units, VERMILLION, confidence, extent, listed, number, with_half,
};
use crate::unit::{compose, label, square};

const DEFINITIONS: [[&str; 2]; 4] = [
    [
        "Slope",
        "Least squares of ln S against ln k (or ln f) over the stated band, each bin with the same weight.",
    ],
    [
        "Interval of the regression",
        "From the residuals of the line alone: it holds deviations from a power law, but not what another record \
         would give. With several shots, the interval is that of the mean over shots.",
    ],
    [
        "Break",
        "Where a continuous line of two or three pieces changes its slope. It is accepted if the improvement has a \
         small probability without a break, times the number of places tried.",
    ],
    [
        "Shock time",
        "Where the steepest front would become infinitely steep: the distance between two of its levels falls along a \
         straight line in time. It is fitted until the front is three times as steep as at first; the interval holds noise, \
         and the deviation from a cubic front and from a straight line.",
    ],
];

/// Ordinates of a spectrum reach this far below the largest.
const DEEPEST: f64 = 1e-16;
/// Slopes are drawn down to this.
const STEEPEST: f64 = -12.0;

impl Describe for Slope {
    /// Variables: `wavenumber` or `frequency`, `spectrum`, `compensated` (bins); along x `frame_time`, `frame_slope`,
    /// `frame_slope_half`, `frame_gradient` (frames).
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let law = &self.law;
        let interval = format!("{} % interval {}", 100.0 * (1.0 - self.alpha), self.basis());
        let slope = format!("Slope {:.3} ± {:.3}", law.slope, law.half);
        let over = self.axis.of(["wavenumbers", "frequencies"]);
        let mut sheet = Sheet {
            about: format!("spectrum over {over}"),
            answer: self.answer(),
            note: format!("{slope}: {interval}, over {} bins.", law.points),
            ..Sheet::of("slope", "Slope of the spectrum", &DEFINITIONS)
        };
        self.facts(&mut sheet);
        if self.left_out > 0 {
            let left_out = self.left_out;
            sheet.warn(
                format!("{left_out} snapshots with missing samples are left out"),
                "leave out the sites with gaps to keep all snapshots",
            );
        }
        if law.band[1] < 5.0 * law.band[0] {
            sheet.warn(
                "the band is less than a factor of five wide: any smooth spectrum is nearly straight over it",
                "state a wider band",
            );
        }
        let rows = [
            ("shots", self.shots.to_string()),
            ("samples a segment", self.segment[0].to_string()),
            ("snapshots left out", self.left_out.to_string()),
            ("bins of the fit", law.points.to_string()),
            ("scatter of ln S", number(law.scatter)),
        ];
        sheet.tables.push(Table::of_values("Averages", rows));
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
            "axis": self.axis,
            "shots": self.shots,
            "segment": self.segment[0],
            "overlap": self.segment[1],
            "left_out": self.left_out,
            "alpha": self.alpha,
            "law": law,
            "breaks": self.breaks,
            "steepening": self.steepening,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let charts = [self.spectrum_chart(), self.compensated_chart()].into_iter();
        PlotRow::grid(2, charts.chain(self.frame_charts()))
    }
}

impl Slope {
    /// Unit of the wavenumbers or frequencies.
    fn bin_unit(&self) -> String {
        let (time_unit, space_unit) = self.units();
        let units = [format!("rad/{space_unit}"), cycles_per(&time_unit)];
        self.axis.of(units)
    }

    /// The ends of the band of the fit, in words.
    fn band(&self) -> String {
        let [low, high] = self.law.band.map(number);
        format!("{low} to {high} {}", self.bin_unit())
    }

    /// What the interval is one of.
    fn basis(&self) -> String {
        match self.law.basis {
            ExponentBasis::Shots => format!("over {} shots", self.shots),
            _ => "of the regression".into(),
        }
    }

    fn answer(&self) -> String {
        let law = &self.law;
        let breaks = self.breaks.iter().map(|breaks| {
            let at: Vec<String> = breaks.at.iter().map(|at| number(*at)).collect();
            format!(", but it bends at {} {}", listed(&at), self.bin_unit())
        });
        let slope = with_half(law.slope, law.half, "");
        let breaks: String = breaks.collect();
        let band = format!("{} = {}", self.axis.of(["k", "f"]), self.band());
        format!(
            "slope {slope} ({}) over {band}{breaks}",
            confidence(self.alpha)
        )
    }

    fn facts(&self, sheet: &mut Sheet) {
        let law = &self.law;
        let slope = with_half(law.slope, law.half, "");
        let (basis, bins, band) = (self.basis(), law.points, self.band());
        let text = format!("{slope} (interval {basis}) over {bins} bins from {band}");
        sheet.fact("slope", text);
        if let Some(breaks) = &self.breaks {
            let slopes: Vec<String> = breaks.slopes.iter().map(|slope| number(*slope)).collect();
            let unit = self.bin_unit();
            let at = breaks.at.iter().zip(&breaks.intervals);
            let at = at.map(|(at, interval)| {
                let [low, high] = interval.map(number);
                format!("{} ({low} to {high}) {unit}", number(*at))
            });
            let at = listed(&at.collect::<Vec<_>>());
            let text = format!("at {at}; slopes {}", slopes.join(", "));
            sheet.fact("breaks", text);
        }
        if let Some(steep) = &self.steepening {
            let time = with_half(steep.shock_time, steep.half, &self.units().0);
            let frames = steep.frames;
            let mut text = format!("{time} (from the levels of the front over {frames} frames)");
            let there = with_half(steep.slope_at_shock, steep.slope_half, "");
            text += &match steep.slope_at_shock.is_finite() {
                true => format!("; slope there {there}"),
                false => "; the record ends before it".into(),
            };
            if steep.slope_after.is_finite() {
                let mean = number(steep.slope_after);
                let [low, high] = steep.slope_after_range.map(number);
                text += &format!(", from 1.5 shock times on {mean} ({low} to {high})");
            }
            sheet.fact("shock time", text);
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let (name, unit) = self.axis.of([
            ("wavenumber", &units.wavenumber),
            ("frequency", &units.frequency),
        ]);
        sheet.line(name, name, unit, &self.abscissa);
        sheet.line("spectrum", name, &units.density(unit, ""), &self.spectrum);
        sheet.line("compensated", name, "", self.compensated());
        if let Some(frames) = &self.frames {
            let gradient = units.gradient();
            sheet.line("frame_time", "frame_time", &units.time, &frames.time);
            sheet.line("frame_slope", "frame_time", "", &frames.slope);
            sheet.line("frame_slope_half", "frame_time", "", &frames.half);
            sheet.line("frame_gradient", "frame_time", &gradient, &frames.gradient);
        }
    }

    fn positive(&self, values: &[f64]) -> Vec<(f64, f64)> {
        let pairs = self.abscissa.iter().copied().zip(values.iter().copied());
        pairs.filter(|(x, y)| *x > 0.0 && *y > 0.0).collect()
    }

    /// In double logarithmic scales over the bins, with the ends of the band of the fit.
    fn chart(&self, title: &str, y_label: String, y: Range<f64>, series: Vec<Series>) -> Chart {
        let name = self.axis.of(["wavenumber k", "frequency f"]);
        let bins = label(name, &self.bin_unit());
        Chart {
            log_x: true,
            log_y: true,
            y,
            marks: self.law.band.map(|at| Mark::new(at, "")).to_vec(),
            ..Chart::of(title, bins, y_label, series)
        }
    }

    fn spectrum_chart(&self) -> Chart {
        let law = &self.law;
        let on_law = |x: f64| (x, law.prefactor * x.powf(law.slope));
        let name = format!("slope {:.3}", law.slope);
        let fitted = Series::line(name, VERMILLION, law.band.map(on_law).to_vec());
        let mut series = vec![
            Series::line("spectrum", BLUE, self.positive(&self.spectrum)),
            fitted.with(Look::Dashed),
        ];
        if let Some(breaks) = &self.breaks {
            let ends = [&[law.band[0]], &breaks.at[..], &[law.band[1]]].concat();
            let slopes = breaks.slopes.iter().map(|slope| format!("{slope:.2}"));
            let slopes: Vec<String> = slopes.collect();
            let points = ends.iter().map(|x| (*x, breaks.at_logarithm(x.ln()).exp()));
            let name = format!("with breaks: {}", slopes.join(", "));
            series.push(Series::line(name, GREEN, points.collect()));
        }
        let drawn = extent(series[0].points.iter().map(|p| p.1));
        let unit = self.unit.as_deref().unwrap_or_default();
        let density = compose(&[&square(unit)], &[&self.bin_unit()]);
        let density = label("power spectral density", &density);
        let y = drawn.start.max(DEEPEST * drawn.end) / 2.0..3.0 * drawn.end;
        self.chart("spectrum with its power law", density, y, series)
    }

    fn compensated_chart(&self) -> Chart {
        let law = &self.law;
        let points = self.positive(&self.compensated());
        let is_inside = |p: &&(f64, f64)| (law.band[0]..=law.band[1]).contains(&p.0);
        let seen = extent(points.iter().filter(is_inside).map(|p| p.1));
        let y = (seen.start / 10.0).min(0.1)..(seen.end * 10.0).max(10.0);
        let label = format!(
            "spectrum over {}^{:.3}",
            self.axis.of(["k", "f"]),
            law.slope
        );
        let (title, levels) = ("compensated spectrum", vec![Level::new(1.0, "the law")]);
        let series = vec![Series::line(title, BLUE, points)];
        Chart {
            levels,
            ..self.chart(title, label, y, series)
        }
    }

    /// Slope and gradient against time.
    fn frame_charts(&self) -> Vec<Chart> {
        let Some(frames) = self.frames.as_ref().filter(|frames| frames.time.len() > 2) else {
            return Vec::new();
        };
        let marks = self.steepening.iter();
        let marks = marks.map(|steep| Mark::new(steep.shock_time, "shock time"));
        let marks: Vec<Mark> = marks.collect();
        let chart = |title: &str, label_y: &str, series: Vec<Series>| Chart {
            marks: marks.clone(),
            ..Chart::of(title, label("time t", &self.units().0), label_y, series)
        };
        let points = frames.time.iter().zip(&frames.slope).zip(&frames.half);
        let points = points.map(|((time, slope), half)| [*time, *slope, *half]);
        let known = points.filter(|[_, slope, _]| slope.is_finite());
        let series = Series::with_errors("", BLUE, known).marked(Marker::Circle);
        let seen = extent(series.points.iter().map(|p| p.1));
        let slope = Chart {
            y: (seen.start - 0.5).max(STEEPEST)..(seen.end + 0.5).max(0.0),
            levels: vec![Level::new(-2.0, "−2 and −8/3"), Level::new(-8.0 / 3.0, "")],
            ..chart("slope against time", "slope over the band", vec![series])
        };
        let first = frames.gradient.first().copied().unwrap_or(1.0);
        let inverse: Vec<f64> = frames.gradient.iter().map(|g| first / g).collect();
        let mut series = vec![Series::of("", BLUE, &frames.time, &inverse).marked(Marker::Circle)];
        if let Some(steep) = &self.steepening {
            let line = vec![(frames.time[0], 1.0), (steep.shock_time, 0.0)];
            series.push(Series::line("to the shock time", BLACK, line).with(Look::Dashed));
        }
        let gradient = chart("steepening", "first over largest |∂v/∂x|", series);
        vec![slope, gradient]
    }
}
