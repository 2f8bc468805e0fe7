//! What a slope says.

use serde_json::json;

use super::{ExponentBasis, FieldAxis, Slope};
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
        let mut sheet = Sheet {
            name: "slope",
            version: 1,
            title: "Slope of the spectrum".into(),
            about: match self.axis {
                FieldAxis::Space => "spectrum over wavenumbers".into(),
                FieldAxis::Time => "spectrum over frequencies".into(),
            },
            answer: self.answer(),
            note: format!(
                "Slope {:.3} ± {:.3}: {} % interval {}, over {} bins.",
                law.slope,
                law.half,
                100.0 * (1.0 - self.alpha),
                self.basis(),
                law.points
            ),
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.facts(&mut sheet);
        if self.left_out > 0 {
            sheet.warn(
                format!(
                    "{} snapshots with missing samples are left out",
                    self.left_out
                ),
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
        match self.axis {
            FieldAxis::Space => format!("rad/{space_unit}"),
            FieldAxis::Time => cycles_per(&time_unit),
        }
    }

    fn symbol(&self) -> &'static str {
        match self.axis {
            FieldAxis::Space => "k",
            FieldAxis::Time => "f",
        }
    }

    /// What the interval is one of.
    fn basis(&self) -> String {
        match self.law.basis {
            ExponentBasis::Shots => format!("over {} shots", self.shots),
            _ => "of the regression".into(),
        }
    }

    fn answer(&self) -> String {
        let (law, unit) = (&self.law, self.bin_unit());
        let breaks = match &self.breaks {
            Some(breaks) => {
                let at: Vec<String> = breaks.at.iter().map(|at| number(*at)).collect();
                format!(", but it bends at {} {unit}", listed(&at))
            }
            None => String::new(),
        };
        format!(
            "slope {} ({}) over {} = {} to {} {unit}{breaks}",
            with_half(law.slope, law.half, ""),
            confidence(self.alpha),
            self.symbol(),
            number(law.band[0]),
            number(law.band[1])
        )
    }

    fn facts(&self, sheet: &mut Sheet) {
        let (law, unit) = (&self.law, self.bin_unit());
        sheet.fact(
            "slope",
            format!(
                "{} (interval {}) over {} bins from {} to {} {unit}",
                with_half(law.slope, law.half, ""),
                self.basis(),
                law.points,
                number(law.band[0]),
                number(law.band[1])
            ),
        );
        if let Some(breaks) = &self.breaks {
            let slopes: Vec<String> = breaks.slopes.iter().map(|slope| number(*slope)).collect();
            let at = breaks.at.iter().zip(&breaks.intervals);
            let at = at.map(|(at, [low, high])| {
                let [at, low, high] = [*at, *low, *high].map(number);
                format!("{at} ({low} to {high}) {unit}")
            });
            let at: Vec<String> = at.collect();
            sheet.fact(
                "breaks",
                format!("at {}; slopes {}", listed(&at), slopes.join(", ")),
            );
        }
        if let Some(steep) = &self.steepening {
            let mut text = format!(
                "{} (from the levels of the front over {} frames)",
                with_half(steep.shock_time, steep.half, &self.units().0),
                steep.frames
            );
            text += &match steep.slope_at_shock.is_finite() {
                true => format!(
                    "; slope there {}",
                    with_half(steep.slope_at_shock, steep.slope_half, "")
                ),
                false => "; the record ends before it".into(),
            };
            if steep.slope_after.is_finite() {
                text += &format!(
                    ", from 1.5 shock times on {} ({} to {})",
                    number(steep.slope_after),
                    number(steep.slope_after_range[0]),
                    number(steep.slope_after_range[1])
                );
            }
            sheet.fact("shock time", text);
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let (name, unit) = match self.axis {
            FieldAxis::Space => ("wavenumber", &units.wavenumber),
            FieldAxis::Time => ("frequency", &units.frequency),
        };
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

    fn bin_label(&self) -> String {
        let name = match self.axis {
            FieldAxis::Space => "wavenumber k",
            FieldAxis::Time => "frequency f",
        };
        label(name, &self.bin_unit())
    }

    fn positive(&self, values: &[f64]) -> Vec<(f64, f64)> {
        let pairs = self.abscissa.iter().copied().zip(values.iter().copied());
        pairs.filter(|(x, y)| *x > 0.0 && *y > 0.0).collect()
    }

    /// The ends of the band of the fit.
    fn bands(&self) -> Vec<Mark> {
        let end = |at: f64| Mark {
            at,
            label: String::new(),
        };
        self.law.band.map(end).to_vec()
    }

    fn spectrum_chart(&self) -> Chart {
        let law = &self.law;
        let on_law = |x: f64| (x, law.prefactor * x.powf(law.slope));
        let fitted = Series::line(
            format!("slope {:.3}", law.slope),
            VERMILLION,
            law.band.map(on_law).to_vec(),
        );
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
        Chart {
            log_x: true,
            log_y: true,
            y: drawn.start.max(DEEPEST * drawn.end) / 2.0..3.0 * drawn.end,
            marks: self.bands(),
            ..Chart::of(
                "spectrum with its power law",
                self.bin_label(),
                label("power spectral density", &density),
                series,
            )
        }
    }

    fn compensated_chart(&self) -> Chart {
        let law = &self.law;
        let points = self.positive(&self.compensated());
        let is_inside = |p: &&(f64, f64)| (law.band[0]..=law.band[1]).contains(&p.0);
        let seen = extent(points.iter().filter(is_inside).map(|p| p.1));
        Chart {
            log_x: true,
            log_y: true,
            y: (seen.start / 10.0).min(0.1)..(seen.end * 10.0).max(10.0),
            levels: vec![Level {
                at: 1.0,
                label: "the law".into(),
            }],
            marks: self.bands(),
            ..Chart::of(
                "compensated spectrum",
                self.bin_label(),
                format!("spectrum over {}^{:.3}", self.symbol(), law.slope),
                vec![Series::line("compensated spectrum", BLUE, points)],
            )
        }
    }

    /// Slope and gradient against time.
    fn frame_charts(&self) -> Vec<Chart> {
        let time_label = label("time t", &self.units().0);
        let Some(frames) = self.frames.as_ref().filter(|frames| frames.time.len() > 2) else {
            return Vec::new();
        };
        let known = (0..frames.time.len()).filter(|n| frames.slope[*n].is_finite());
        let (points, errors): (Vec<_>, Vec<f64>) = known
            .map(|n| {
                let half = frames.half[n];
                let error = if half.is_finite() { half } else { 0.0 };
                ((frames.time[n], frames.slope[n]), error)
            })
            .unzip();
        let series = Series {
            errors,
            ..Series::line("", BLUE, points).marked(Marker::Circle)
        };
        let marks: Vec<Mark> = self
            .steepening
            .iter()
            .map(|steep| Mark {
                at: steep.shock_time,
                label: "shock time".into(),
            })
            .collect();
        let seen = extent(series.points.iter().map(|p| p.1));
        let level = |(at, words): (f64, &str)| Level {
            at,
            label: words.into(),
        };
        let slope = Chart {
            y: (seen.start - 0.5).max(STEEPEST)..(seen.end + 0.5).max(0.0),
            marks: marks.clone(),
            levels: [(-2.0, "−2 and −8/3"), (-8.0 / 3.0, "")]
                .map(level)
                .to_vec(),
            ..Chart::of(
                "slope against time",
                &time_label,
                "slope over the band",
                vec![series],
            )
        };
        let first = frames.gradient.first().copied().unwrap_or(1.0);
        let inverse: Vec<f64> = frames.gradient.iter().map(|g| first / g).collect();
        let mut series = vec![Series::of("", BLUE, &frames.time, &inverse).marked(Marker::Circle)];
        if let Some(steep) = &self.steepening {
            let line = vec![(frames.time[0], 1.0), (steep.shock_time, 0.0)];
            series.push(Series::line("to the shock time", BLACK, line).with(Look::Dashed));
        }
        let gradient = Chart {
            marks,
            ..Chart::of(
                "steepening",
                &time_label,
                "first over largest |∂v/∂x|",
                series,
            )
        };
        vec![slope, gradient]
    }
}
