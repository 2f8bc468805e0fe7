//! What structure functions say.

use serde_json::json;

use super::moments::ORDERS;
use super::{
    AxisIncrements, ExponentBasis, Increments, IntervalBasis, ScaleMoments, ScalingExponents,
};
use crate::sheet::{
    BLACK, BLUE, Chart, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Table, Units,
    VERMILLION, extent, number, with_half,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 6] = [
    [
        "Increment",
        "Difference of two samples a separation r apart along x, towards +x, or a lag τ apart in time.",
    ],
    [
        "Structure function",
        "Mean of |increment| to the power p, over all pairs of samples. Charts show its p-th root.",
    ],
    [
        "Flatness",
        "⟨d⁴⟩/⟨d²⟩²: 3 for normal increments of one level, more where levels of sites or times differ.",
    ],
    [
        "Local flatness",
        "That of increments in units of their level at each site, or pair of sites, and in each of 16 parts of the times: \
         3 for normal increments of any levels. Where it is above 3 and grows towards small scales, the field is \
         intermittent: large increments are rare and concentrated.",
    ],
    [
        "Third moment",
        "⟨d³⟩ with its sign. Negative along x where fronts steepen towards +x. In Burgers' equation and in \
         turbulence a negative one goes with transfer to small scales; elsewhere it states an asymmetry alone.",
    ],
    [
        "Exponent",
        "Slope of ln S_p against the logarithm of the scale over the stated band. The interval over \
         shots or parts holds what another record would give, that of the regression deviations from a power law alone.",
    ],
];

/// Largest exponent of ten between the ends of an axis of histograms.
const DEEPEST: f64 = 1e-7;

impl Describe for Increments {
    /// Variables of each axis, `space_` and `time_`: `scale`, `pairs` (n); `structure`, `structure_half` (n, 6), orders 1
    /// to 6; `third`, `flatness`, `local_flatness`, `skewness` (n) with their `_half`, half of the interval, NaN where none can be stated;
    /// `histogram_scale` (h), `histogram_edges` (cells + 1), `histogram_density` (h, cells).
    fn describe(&self) -> Sheet<'_> {
        let (time_unit, space_unit) = self.units();
        let basis = match self.basis {
            IntervalBasis::Shots => format!("over {} shots", self.shots),
            IntervalBasis::Parts => "over 16 parts of the record, taken as stationary".into(),
            IntervalBasis::None => "none: one transient is one realisation".into(),
        };
        let mut sheet = Sheet {
            about: format!("separations in {space_unit}, lags in {time_unit}"),
            answer: self.answer(),
            note: match self.basis {
                IntervalBasis::None => format!("Intervals: {basis}."),
                _ => format!("Bars: {} % intervals {basis}.", 100.0 * (1.0 - self.alpha)),
            },
            ..Sheet::of("increments", "Increments against scale", &DEFINITIONS)
        };
        for axis in &self.axes {
            let name = axis.words()[0];
            sheet.fact(format!("flatness, {name}"), axis.flatness(self));
            sheet.fact(format!("third moment, {name}"), axis.third(self));
            if let Some(fit) = &axis.exponents {
                let words = axis.exponents_in_words(fit, self);
                sheet.fact(format!("exponents, {name}"), words);
                let words = by_order(fit.relative.map(number));
                sheet.detail(format!("exponents relative to order 3, {name}"), words);
            }
        }
        if self.axes.iter().all(|axis| axis.exponents.is_none()) {
            sheet.detail("exponents", "none: state a band with --band or --lag-band");
        }
        for axis in &self.axes {
            let pairs: u64 = axis.scales.iter().map(|m| m.pairs).sum();
            let text = format!("{} scales, {pairs} pairs of samples", axis.scales.len());
            sheet.detail(axis.words()[0], text);
        }
        if self.basis == IntervalBasis::None {
            let steadiness = number(self.steadiness);
            sheet.warn(
                format!("the record is a transient (steadiness {steadiness}), one realisation: no interval is stated"),
                "name several records of the same sites, one a shot",
            );
        }
        let rows = [
            ("shots", self.shots.to_string()),
            ("steadiness", number(self.steadiness)),
            ("intervals", basis),
        ];
        sheet.tables.push(Table::of_values("Averages", rows));
        let axes: Vec<_> = self.axes.iter().map(AxisIncrements::numbers).collect();
        sheet.numbers(json!({
            "time_unit": time_unit,
            "space_unit": space_unit,
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

/// `1: 0.33, 2: 0.66`, of the orders 1 to 6.
fn by_order(words: [String; ORDERS]) -> String {
    let words = words.iter().zip(1..);
    let words: Vec<String> = words.map(|(word, p)| format!("{p}: {word}")).collect();
    words.join(", ")
}

impl Increments {
    /// Whether large increments are rare and concentrated at small scales, in words.
    fn answer(&self) -> String {
        let still = self.axes.iter().find(|axis| !axis.moves());
        let still = still.map(|axis| format!("{}; ", axis.words()[2]));
        if !self.axes.iter().any(AxisIncrements::moves) {
            return "nothing moves".into();
        }
        let told = |told: bool| {
            let of = self.axes.iter().filter(move |axis| axis.moves());
            let of = of.filter(|axis| axis.is_intermittent() == Some(told));
            let along: Vec<&str> = of.clone().map(|axis| axis.words()[1]).collect();
            let flatness: Vec<String> = of.filter_map(|axis| axis.local_flatness(self)).collect();
            let (start, with) = match told {
                true => ("intermittent", " and "),
                false => ("no intermittency is shown", " or "),
            };
            let (along, flatness) = (along.join(with), flatness.join("; "));
            (!along.is_empty()).then(|| format!("{start} {along}: local flatness {flatness}"))
        };
        let untold = match self.basis {
            IntervalBasis::None => "one transient is one realisation",
            _ => "it takes 64 times, and three scales",
        };
        let verdict = told(true).or_else(|| told(false));
        let verdict = verdict.unwrap_or_else(|| format!("intermittency cannot be told: {untold}"));
        format!("{}{verdict}", still.unwrap_or_default())
    }
}

/// Names of the arrays of [`ScaleMoments::numbers`].
const NUMBERS: [&str; 4] = ["third", "flatness", "local_flatness", "skewness"];
const FLATNESS: usize = 1;
const LOCAL: usize = 2;
const SKEWNESS: usize = 3;

impl AxisIncrements {
    /// Name, place in a sentence, and that nothing differs along the axis.
    fn words(&self) -> [&'static str; 3] {
        let same = "no motion between sites: their records are the same";
        self.axis.of([
            ["x", "along x", same],
            ["time", "in time", "nothing changes in time"],
        ])
    }

    /// Of the scales.
    fn unit(&self, of: &Increments) -> String {
        let (time, space) = of.units();
        self.axis.of([space, time])
    }

    /// A number at two scales.
    fn ends(&self, of: &Increments, ends: [&ScaleMoments; 2], number_of: usize) -> String {
        let unit = self.unit(of);
        let at = |m: &ScaleMoments| {
            let [value, half] = m.numbers()[number_of];
            let value = with_half(value, half, "");
            format!("{value} at {} {unit}", number(m.scale))
        };
        match ends[0].step == ends[1].step {
            true => at(ends[0]),
            false => ends.map(at).join(", "),
        }
    }

    fn local_flatness(&self, of: &Increments) -> Option<String> {
        Some(self.ends(of, self.local_ends()?, LOCAL))
    }

    fn flatness(&self, of: &Increments) -> String {
        let (Some(first), Some(last), true) =
            (self.scales.first(), self.scales.last(), self.moves())
        else {
            return self.words()[2].into();
        };
        let all = self.ends(of, [first, last], FLATNESS);
        let Some(local) = self.local_flatness(of) else {
            return all;
        };
        let growing = self.growth.map(|[exponent, half]| {
            let exponent = with_half(exponent, half, "");
            format!(", growing by the power {exponent} towards small scales")
        });
        format!("{all}; local {local}{}", growing.unwrap_or_default())
    }

    fn third(&self, of: &Increments) -> String {
        let (signs, unit) = (self.third_signs(of.alpha), self.unit(of));
        let of_sign = |(sign, name): (f64, &str)| {
            let scales = signs.iter().filter(|(_, s)| *s == sign);
            let scales: Vec<f64> = scales.map(|(x, _)| *x).collect();
            let (n, all) = (scales.len(), self.scales.len());
            let [first, last] = [scales.first()?, scales.last()?].map(|x| number(*x));
            let scales = format!("{n} of {all} scales from {first} to {last}");
            Some(format!("{name} at {scales} {unit}"))
        };
        let signs = [(-1.0, "negative"), (1.0, "positive")];
        let words: Vec<String> = signs.into_iter().filter_map(of_sign).collect();
        match words.is_empty() {
            true => "its sign is not resolved at any scale".into(),
            false => words.join("; "),
        }
    }

    fn exponents_in_words(&self, fit: &ScalingExponents, of: &Increments) -> String {
        let values = std::array::from_fn(|p| with_half(fit.exponents[p], fit.half[p], ""));
        let basis = match fit.basis {
            ExponentBasis::Shots => "over shots",
            ExponentBasis::Parts => "over 16 parts of the record",
            ExponentBasis::Regression => "of the regression",
        };
        let (text, points, unit) = (by_order(values), fit.points, self.unit(of));
        let [from, to] = fit.band.map(number);
        format!("{text}; {points} scales from {from} to {to} {unit}, intervals {basis}")
    }

    fn numbers(&self) -> serde_json::Value {
        let mut numbers = json!({
            "axis": self.axis,
            "scale": self.scales.iter().map(|m| m.scale).collect::<Vec<f64>>(),
            "pairs": self.scales.iter().map(|m| m.pairs).collect::<Vec<u64>>(),
            "growth": self.growth,
            "intermittent": self.is_intermittent(),
            "exponents": self.exponents,
        });
        // Skewness is in the archive alone.
        for (_, name, values) in self.lines().filter(|line| line.0 != SKEWNESS) {
            numbers[name] = json!(values);
        }
        numbers
    }

    /// Each number of all scales, and half of its interval.
    fn lines(&self) -> impl Iterator<Item = (usize, String, Vec<f64>)> {
        let each = (0..NUMBERS.len()).flat_map(|number| [(number, 0), (number, 1)]);
        each.map(|(number, part)| {
            let values = self.scales.iter().map(|m| m.numbers()[number][part]);
            let name = format!("{}{}", NUMBERS[number], ["", "_half"][part]);
            (number, name, values.collect())
        })
    }

    fn variables(&self, units: &Units, sheet: &mut Sheet) {
        let axes = [("space", &units.space), ("time", &units.time)];
        let (prefix, length) = self.axis.of(axes);
        let n = self.scales.len();
        let named = |name: &str| format!("{prefix}_{name}");
        let of_all = |of: fn(&ScaleMoments) -> f64| self.scales.iter().map(of).collect::<Vec<_>>();
        let scale = named("scale");
        sheet.line(&scale, &scale, length, of_all(|m| m.scale));
        sheet.line(&named("pairs"), &scale, "", of_all(|m| m.pairs as f64));
        let cubed = units.cubed();
        for (number, name, values) in self.lines() {
            let unit = [&cubed, "", "", ""][number];
            sheet.line(&named(&name), &scale, unit, values);
        }
        let structure: Vec<f64> = self.scales.iter().flat_map(|m| m.structure).collect();
        let orders = structure.len() / n.max(1);
        let half = self.scales.iter().flat_map(|m| m.half[..orders].to_vec());
        let half: Vec<f64> = half.collect();
        let axes = [(&scale[..], n), ("order", orders)];
        sheet.variable(&named("structure_half"), &axes, "", half);
        sheet.variable(&named("structure"), &axes, "", structure);
        let scales = self.histograms.iter().map(|h| self.scales[h.index].scale);
        let scales: Vec<f64> = scales.collect();
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
        let along = self.words()[1];
        let scale_label = label(self.axis.of(["separation r", "lag τ"]), &self.unit(of));
        let log_x = self.scales.len() > 3;
        let structure = (0..6).map(|p| {
            // The roots have the unit of the samples and one range.
            let root = 1.0 / (p + 1) as f64;
            let scales = self.scales.iter();
            let points = scales.map(|m| (m.scale, m.structure[p].powf(root)));
            Series::line(format!("p = {}", p + 1), p, points.collect())
        });
        let fits = self.exponents.iter();
        let laws = fits.flat_map(|fit| (0..6).map(move |p| self.law(fit, p)));
        let structure: Vec<Series> = structure.chain(laws).collect();
        let values = structure.iter().flat_map(|s| &s.points).map(|p| p.1);
        let y = extent(values.filter(|v| *v > 0.0));
        let title = format!("structure functions, {along}");
        let root = label("⟨|d|ᵖ⟩^(1/p)", of.unit.as_deref().unwrap_or_default());
        let roots = Chart {
            log_x,
            log_y: true,
            y: y.start / 1.2..1.2 * y.end,
            ..Chart::of(title, &scale_label, root, structure)
        };
        let ratio = |title: &str, axis: &str, normal: Level, series: Vec<Series>| Chart {
            log_x,
            levels: vec![normal],
            ..Chart::of(format!("{title}, {along}"), &scale_label, axis, series)
        };
        let with_bars = |name, colour, number: usize| {
            let points = self.scales.iter().map(|m| (m.scale, m.numbers()[number]));
            let known = points.filter(|(_, [value, _])| value.is_finite());
            let points = known.map(|(scale, [value, half])| [scale, value, half]);
            Series::with_errors(name, colour, points).marked(Marker::Circle)
        };
        let flatness = vec![
            with_bars("all together", BLUE, FLATNESS),
            with_bars("local", VERMILLION, LOCAL),
        ];
        let normal = Level::new(3.0, "normal distribution");
        let mut flat = ratio("flatness", "flatness ⟨d⁴⟩/⟨d²⟩²", normal, flatness);
        flat.y = 0.0..flat.y.end.max(3.5);
        let skewness = vec![with_bars("", BLUE, SKEWNESS)];
        let title = "third moment with its sign";
        let mut skew = ratio(title, "skewness ⟨d³⟩/⟨d²⟩^(3/2)", Level::zero(), skewness);
        let most = skew.y.start.abs().max(skew.y.end.abs()).max(0.1);
        skew.y = -most..most;
        let mut charts = vec![roots, flat, skew];
        charts.extend(self.histograms(of));
        charts
    }

    /// The power law of an order over its band.
    fn law(&self, fit: &ScalingExponents, p: usize) -> Series {
        let in_band = |m: &&ScaleMoments| (fit.band[0]..=fit.band[1]).contains(&m.scale);
        let scales = self.scales.iter().filter(in_band);
        let logs = scales.map(|m| (m.scale.ln(), m.structure[p].ln()));
        let n = logs.clone().count() as f64;
        let (x, y) = logs.fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let at = |scale: f64| {
            let power = y + fit.exponents[p] * (scale.ln() - x);
            (scale, (power / (p + 1) as f64).exp())
        };
        let name = ["power laws over the band", ""][p.min(1)];
        Series::line(name, BLACK, fit.band.map(at).to_vec()).with(Look::Dashed)
    }

    fn histograms(&self, of: &Increments) -> Option<Chart> {
        let (symbol, unit) = (self.axis.of(["r", "τ"]), self.unit(of));
        let centres = |edges: &[f64]| -> Vec<f64> {
            let pairs = edges.windows(2);
            pairs.map(|pair| 0.5 * (pair[0] + pair[1])).collect()
        };
        let series = self.histograms.iter().enumerate().map(|(i, histogram)| {
            let scale = self.scales[histogram.index].scale;
            let points = centres(&histogram.edges).into_iter();
            let points = points.zip(histogram.density.iter().copied());
            let there = points.filter(|(_, density)| *density > 0.0);
            Series::line(format!("{symbol} = {scale:.4} {unit}"), i, there.collect())
        });
        let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let first = centres(&self.histograms.first()?.edges).into_iter();
        let normal = first.map(|x| (x, density(x))).collect();
        let normal = Series::line("normal distribution", BLACK, normal).with(Look::Dashed);
        let series = series.chain([normal]).collect();
        let densities = self.histograms.iter().flat_map(|h| &h.density);
        let seen = extent(densities.copied().filter(|v| *v > 0.0));
        let title = format!("histograms of increments, {}", self.words()[1]);
        let x_label = "increment over its root mean square";
        Some(Chart {
            log_y: true,
            x: -10.0..10.0,
            y: seen.start.max(DEEPEST) / 2.0..2.0 * seen.end.max(0.4),
            ..Chart::of(title, x_label, "probability density", series)
        })
    }
}
