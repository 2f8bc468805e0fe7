//! What a slope says.

use serde_json::json;

use super::Slope;
use crate::estimates::IntervalBasis;
use crate::sheet::{
    BLACK, BLUE, Chart, Describe, GREEN, Level, Look, Mark, Marker, PlotRow, Role, Series, Sheet,
    Units, VERMILLION, confidence, extent, listed, number, with_half,
};

const DEFINITIONS: &str = "\
    Slope: Least squares of ln S against ln k (or ln f) over the stated band, each bin with the same weight.
    Interval of the regression: From the residuals of the line alone: not what another record would give. Of several shots it is \
        that of the mean over shots.
    Break: Where a continuous line of two or three pieces changes its slope, if a straight one has a small probability.
    Shock time: Where the steepest front would become infinitely steep: the distance between two of its levels falls along a \
        straight line in time. The interval holds noise, and the deviation from a cubic front and from a straight line.";

/// Slopes are drawn down to this.
const STEEPEST: f64 = -12.0;

impl Describe for Slope {
    /// Variables: `wavenumber` or `frequency`, `spectrum`, `compensated` (bins); along x `frame_time`, `frame_slope`,
    /// `frame_slope_half`, `frame_gradient` (frames).
    fn describe(&self) -> Sheet<'_> {
        let (words, law) = (self.words(), &self.law);
        let over = self.axis.of(["wavenumbers", "frequencies"]);
        let basis = match law.basis {
            IntervalBasis::Shots => format!("over {} shots", self.shots),
            _ => "of the regression".into(),
        };
        let (share, bins) = (confidence(self.alpha), law.points);
        let mut sheet = Sheet {
            about: format!("spectrum over {over}"),
            answer: self.answer(),
            note: format!("{share} interval {basis}, over {bins} bins."),
            ..Sheet::of("slope", "Slope of the spectrum", DEFINITIONS)
        };
        self.facts(&mut sheet);
        if law.band[1] < 5.0 * law.band[0] {
            sheet.warn(
                "the band is less than a factor of five wide: any smooth spectrum is nearly straight over it",
                "state a wider band",
            );
        }
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
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
        let frames = self.frame_charts();
        PlotRow::grid(2, [self.spectrum_chart()].into_iter().chain(frames))
    }
}

impl Slope {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }

    /// What bins count.
    fn role(&self) -> Role {
        self.axis.of([Role::Wavenumber, Role::Frequency])
    }

    fn answer(&self) -> String {
        let (law, words) = (&self.law, self.words());
        let unit = words.unit(self.role());
        let breaks = self.breaks.iter().map(|breaks| {
            let at = breaks.at.iter().zip(&breaks.intervals);
            let at = at.map(|(at, ends)| {
                let [at, low, high] = [*at, ends[0], ends[1]].map(number);
                format!("{at} ({low} to {high}) {unit}")
            });
            format!(", but it bends at {}", listed(&at.collect::<Vec<_>>()))
        });
        let breaks: String = breaks.collect();
        let (slope, share) = (with_half(law.slope, law.half, ""), confidence(self.alpha));
        let ([low, high], [_, symbol]) = (law.band.map(number), self.role().words());
        format!("slope {slope} ({share}) over {symbol} = {low} to {high} {unit}{breaks}")
    }

    fn facts(&self, sheet: &mut Sheet) {
        if let Some(steep) = &self.steepening {
            let time = with_half(steep.shock_time, steep.half, &self.words().time);
            let there = match steep.slope_at_shock.is_finite() {
                true => with_half(steep.slope_at_shock, steep.slope_half, ""),
                false => "not recorded".into(),
            };
            let frames = steep.frames;
            let text = format!("{time}, from {frames} frames; slope there {there}");
            sheet.fact("shock time", text);
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let [name, _] = self.role().words();
        let density = units.density(&[units.unit(self.role())], "");
        sheet.axis(self.role(), &units, &self.abscissa);
        sheet.line("spectrum", name, &density, &self.spectrum);
        sheet.line("compensated", name, "", self.compensated());
        if let Some(frames) = &self.frames {
            let gradient = units.gradient();
            sheet.line("frame_time", "frame_time", &units.time, &frames.time);
            sheet.line("frame_slope", "frame_time", "", &frames.slope);
            sheet.line("frame_slope_half", "frame_time", "", &frames.half);
            sheet.line("frame_gradient", "frame_time", &gradient, &frames.gradient);
        }
    }

    /// In double logarithmic scales over the bins, with the ends of the band of the fit.
    fn spectrum_chart(&self) -> Chart {
        let law = &self.law;
        let on_law = |x: f64| (x, law.prefactor * x.powf(law.slope));
        let name = format!("slope {:.3}", law.slope);
        let fitted = Series::line(name, VERMILLION, law.band.map(on_law).to_vec());
        // The mean has no place on a logarithmic axis.
        let [bins, spectrum] = [&self.abscissa, &self.spectrum].map(|all| &all[1..]);
        let mut series = vec![
            Series::of("spectrum", BLUE, bins, spectrum),
            fitted.with(Look::Dashed),
        ];
        if let Some(breaks) = &self.breaks {
            let ends = [&[law.band[0]], &breaks.at[..], &[law.band[1]]].concat();
            let points = ends.iter().map(|x| (*x, breaks.at_logarithm(x.ln()).exp()));
            series.push(Series::line("with breaks", GREEN, points.collect()));
        }
        let (words, role, title) = (self.words(), self.role(), "spectrum with its power law");
        let (bins, density) = (words.label(role), words.density_label(&[role]));
        Chart {
            log_x: true,
            marks: law.band.map(|at| Mark::new(at, "")).to_vec(),
            ..Chart::of(title, bins, density, series).logarithmic()
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
        let chart = |title: &str, y_label: &str, series: Vec<Series>| Chart {
            marks: marks.clone(),
            ..Chart::of(title, self.words().label(Role::Time), y_label, series)
        };
        let points = frames.time.iter().zip(&frames.slope).zip(&frames.half);
        let points = points.map(|((time, slope), half)| [*time, *slope, *half]);
        let series = Series::with_errors("", BLUE, points).marked(Marker::Circle);
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
