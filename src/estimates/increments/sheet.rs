//! What structure functions say.

use serde_json::json;

use super::moments::ORDERS;
use super::{AxisIncrements, Increments, IntervalBasis, ScaleMoments, ScalingExponents};
use crate::numeric::LineFit;
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Units,
    VERMILLION, confidence, name_of, number, with_half,
};
use crate::unit::label;

const DEFINITIONS: &str = "\
    Increment: Difference of two samples a separation r apart along x, towards +x, or a lag τ apart in time.
    Structure function: Mean of |increment| to the power p, over all pairs of samples. Charts show its p-th root.
    Flatness: ⟨d⁴⟩/⟨d²⟩²: 3 for normal increments of one level, more where levels of sites or times differ.
    Local flatness: That of increments in units of their level at each site, or pair of sites, and in each of 16 parts of the \
        times: 3 for normal increments of any levels. Where it is above 3 and grows towards small scales, the field is intermittent.
    Third moment: ⟨d³⟩ with its sign. Negative along x where fronts steepen towards +x.
    Exponent: Slope of ln S_p against the logarithm of the scale over the stated band. The interval of the regression holds \
        deviations from a power law alone, not what another record would give.";

impl Describe for Increments {
    /// Variables of each axis, `space_` and `time_`: `scale`, `pairs` (n); `structure`, `structure_half` (n, 6), orders 1
    /// to 6; `third`, `flatness`, `local_flatness`, `skewness` (n) with their `_half`, half of the interval, NaN where none can be stated;
    /// `histogram_scale` (h), `histogram_edges` (cells + 1), `histogram_density` (h, cells).
    fn describe(&self) -> Sheet<'_> {
        let words = self.words();
        let basis = match self.basis {
            IntervalBasis::Shots => format!("over {} shots", self.shots),
            IntervalBasis::Parts => "over 16 parts of the record, taken as stationary".into(),
            _ => "none: one transient is one realisation".into(),
        };
        let answers = self.axes.iter().map(|axis| axis.answer(self));
        let mut sheet = Sheet {
            about: "differences of samples apart along x and in time".into(),
            answer: answers.collect::<Vec<_>>().join("; "),
            note: format!("Intervals ({}): {basis}.", confidence(self.alpha)),
            ..Sheet::of("increments", "Increments against scale", DEFINITIONS)
        };
        for axis in &self.axes {
            let along = axis.along();
            sheet.fact(format!("third moment {along}"), axis.third(self.alpha));
            if let Some(fit) = &axis.exponents {
                let words = AxisIncrements::exponents_in_words(fit);
                sheet.fact(format!("exponents {along}"), words);
            }
        }
        if self.basis == IntervalBasis::None {
            sheet.warn(
                "one transient is one realisation: no interval is stated",
                "name several records of the same sites, one a shot",
            );
        }
        let axes: Vec<_> = self.axes.iter().map(AxisIncrements::numbers).collect();
        sheet.numbers(json!({
            "time_unit": words.time,
            "space_unit": words.space,
            "shots": self.shots,
            "steadiness": self.steadiness,
            "basis": self.basis,
            "alpha": self.alpha,
            "axes": axes,
        }));
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        for axis in &self.axes {
            axis.variables(&units, &mut sheet);
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let charts = self.axes.iter().map(|axis| axis.charts(self));
        charts.flat_map(|charts| PlotRow::grid(2, charts)).collect()
    }
}

impl Increments {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }
}

/// Numbers of a scale with half of their intervals; `length` is the unit of scales, `cubed` that of the third moment.
fn columns<'u>(length: &'u str, cubed: &'u str) -> [Column<'u, ScaleMoments>; 10] {
    [
        ("scale", length, |m| m.scale),
        ("pairs", "", |m| m.pairs as f64),
        ("third", cubed, |m| m.third),
        ("third_half", cubed, |m| m.half[ORDERS]),
        ("flatness", "", |m| m.flatness),
        ("flatness_half", "", |m| m.flatness_half()),
        ("local_flatness", "", |m| m.local_flatness),
        ("local_flatness_half", "", |m| m.local_flatness_half()),
        ("skewness", "", |m| m.skewness),
        ("skewness_half", "", |m| m.half[ORDERS + 2]),
    ]
}

impl AxisIncrements {
    /// Its place in a sentence.
    fn along(&self) -> &'static str {
        self.axis.of(["along x", "in time"])
    }

    /// Of the scales.
    fn unit(&self, of: &Increments) -> String {
        let words = of.words();
        self.axis.of([words.space, words.time])
    }

    /// Whether large increments are rare and concentrated at small scales, in words.
    fn answer(&self, of: &Increments) -> String {
        let (along, unit) = (self.along(), self.unit(of));
        if !self.moves() {
            return format!("all increments {along} are 0");
        }
        let (Some(told), Some(ends)) = (self.is_intermittent(), self.local_ends()) else {
            let why = match of.basis {
                IntervalBasis::None => "one transient is one realisation",
                _ => "it takes 64 times, and three scales",
            };
            return format!("intermittency {along} cannot be told: {why}");
        };
        let [small, large] = ends.map(|m| {
            let flatness = with_half(m.local_flatness, m.local_flatness_half(), "");
            format!("{flatness} at {} {unit}", number(m.scale))
        });
        let verdict = match told {
            true => format!("intermittent {along}"),
            false => format!("no intermittency is shown {along}"),
        };
        format!("{verdict}: local flatness {small}, {large}")
    }

    fn third(&self, alpha: f64) -> String {
        let signs = self.third_signs(alpha);
        let [negative, positive] = [-1.0, 1.0].map(|of| {
            let scales = signs.iter().filter(|(_, sign)| *sign == of);
            scales.count()
        });
        let all = self.scales.len();
        format!("negative at {negative}, positive at {positive} of {all} scales, beyond chance")
    }

    fn exponents_in_words(fit: &ScalingExponents) -> String {
        let order = |p: usize| {
            let exponent = with_half(fit.exponents[p], fit.half[p], "");
            format!("{}: {exponent}", p + 1)
        };
        let orders = (0..ORDERS).map(order).collect::<Vec<_>>().join(", ");
        let (points, basis) = (fit.points, name_of(&fit.basis));
        format!("{orders}; over {points} scales, intervals by {basis}")
    }

    fn numbers(&self) -> serde_json::Value {
        let mut numbers = json!({
            "axis": self.axis,
            "growth": self.growth,
            "intermittent": self.is_intermittent(),
            "exponents": self.exponents,
        });
        for (name, _, of) in columns("", "") {
            numbers[name] = self.scales.iter().map(of).collect();
        }
        numbers["pairs"] = self.scales.iter().map(|m| m.pairs).collect();
        numbers
    }

    fn variables(&self, units: &Units, sheet: &mut Sheet) {
        let axes = [("space", &units.space), ("time", &units.time)];
        let (prefix, length) = self.axis.of(axes);
        let n = self.scales.len();
        let named = |name: &str| format!("{prefix}_{name}");
        let scale = named("scale");
        for (name, unit, of) in columns(length, &units.cubed()) {
            let values = self.scales.iter().map(of).collect::<Vec<_>>();
            sheet.line(&named(name), &scale, unit, values);
        }
        let axes = [(&scale[..], n), ("order", if n > 0 { ORDERS } else { 0 })];
        let mut of_orders = |name, of: fn(&ScaleMoments) -> &[f64]| {
            let values: Vec<f64> = self.scales.iter().flat_map(of).copied().collect();
            sheet.variable(&named(name), &axes, "", values);
        };
        of_orders("structure_half", |m| &m.half[..ORDERS]);
        of_orders("structure", |m| &m.structure);
        let histograms = self.histograms.iter();
        let scales: Vec<f64> = histograms.map(|h| self.scales[h.index].scale).collect();
        let (of_histogram, count) = (named("histogram_scale"), scales.len());
        sheet.line(&of_histogram, &of_histogram, length, scales);
        let Some(first) = self.histograms.first() else {
            return;
        };
        let edges = named("histogram_edges");
        sheet.line(&edges, &edges, "", first.edges.clone());
        let cells = named("histogram_cell");
        let axes = [(&of_histogram[..], count), (&cells, first.density.len())];
        let densities = self.histograms.iter().flat_map(|h| &h.density);
        let densities: Vec<f64> = densities.copied().collect();
        sheet.variable(&named("histogram_density"), &axes, "", densities);
    }

    /// Structure functions, flatness, skewness and histograms.
    fn charts(&self, of: &Increments) -> Vec<Chart> {
        let along = self.along();
        let scale_label = label(self.axis.of(["separation r", "lag τ"]), &self.unit(of));
        let chart = |title: &str, y_label: &str, series: Vec<Series>| Chart {
            log_x: self.scales.len() > 3,
            ..Chart::of(format!("{title}, {along}"), &scale_label, y_label, series)
        };
        let structure = (0..ORDERS).map(|p| {
            // The roots have the unit of the samples and one range.
            let root = 1.0 / (p + 1) as f64;
            let scales = self.scales.iter();
            let points = scales.map(|m| (m.scale, m.structure[p].powf(root)));
            Series::line(format!("p = {}", p + 1), p, points.collect())
        });
        let fits = self.exponents.iter();
        let laws = fits.flat_map(|fit| (0..ORDERS).filter_map(move |p| self.law(fit, p)));
        let structure = structure.chain(laws).collect();
        let root = label("⟨|d|ᵖ⟩^(1/p)", of.unit.as_deref().unwrap_or_default());
        let roots = chart("structure functions", &root, structure).logarithmic();
        let with_bars = |name, colour, of: fn(&ScaleMoments) -> [f64; 3]| {
            let points = self.scales.iter().map(of);
            Series::with_errors(name, colour, points).marked(Marker::Circle)
        };
        let flatness = vec![
            with_bars("all together", BLUE, |m| {
                [m.scale, m.flatness, m.flatness_half()]
            }),
            with_bars("local", VERMILLION, |m| {
                [m.scale, m.local_flatness, m.local_flatness_half()]
            }),
        ];
        let flat = chart("flatness", "flatness ⟨d⁴⟩/⟨d²⟩²", flatness);
        let flat = Chart {
            y: 0.0..flat.y.end.max(3.5),
            levels: vec![Level::new(3.0, "normal distribution")],
            ..flat
        };
        let (title, name) = ("third moment with its sign", "skewness ⟨d³⟩/⟨d²⟩^(3/2)");
        let skew = with_bars("", BLUE, |m| [m.scale, m.skewness, m.half[ORDERS + 2]]);
        let skew = chart(title, name, vec![skew]).about_zero();
        let histograms = self.histograms(of);
        [roots, flat, skew].into_iter().chain(histograms).collect()
    }

    /// The power law of an order over its band.
    fn law(&self, fit: &ScalingExponents, p: usize) -> Option<Series> {
        let in_band = |m: &&ScaleMoments| (fit.band[0]..=fit.band[1]).contains(&m.scale);
        let scales = self.scales.iter().filter(in_band);
        let logs = scales.map(|m| (m.scale.ln(), m.structure[p].ln() / (p + 1) as f64));
        let line = LineFit::through(&logs.collect::<Vec<_>>())?;
        let at = |scale: f64| (scale, (line.intercept + line.slope * scale.ln()).exp());
        let name = ["power laws over the band", ""][p.min(1)];
        Some(Series::line(name, BLACK, fit.band.map(at).to_vec()).with(Look::Dashed))
    }

    /// Densities above 0, and the normal one within five deviations.
    fn histograms(&self, of: &Increments) -> Option<Chart> {
        let (symbol, unit) = (self.axis.of(["r", "τ"]), self.unit(of));
        let edges = &self.histograms.first()?.edges;
        let centres = edges.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let series = self.histograms.iter().enumerate().map(|(i, histogram)| {
            let scale = self.scales[histogram.index].scale;
            let points = centres.clone().zip(histogram.density.iter().copied());
            let there = points.filter(|(_, density)| *density > 0.0);
            Series::line(format!("{symbol} = {scale:.4} {unit}"), i, there.collect())
        });
        let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let within = centres.clone().filter(|x| x.abs() < 5.0);
        let normal = within.map(|x| (x, density(x))).collect();
        let normal = Series::line("normal distribution", BLACK, normal).with(Look::Dashed);
        let title = format!("histograms of increments, {}", self.along());
        let x_label = "increment over its root mean square";
        let series = series.chain([normal]).collect();
        let chart = Chart::of(title, x_label, "probability density", series);
        Some(chart.logarithmic())
    }
}
