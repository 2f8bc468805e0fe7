//! What structure functions say.

use serde_json::json;

use super::{
    AxisIncrements, ExponentBasis, FieldAxis, Increments, IntervalBasis, ScaleMoments,
    ScalingExponents,
};
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Table,
    Units, VERMILLION, extent, number, with_half,
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
        let percent = 100.0 * (1.0 - self.alpha);
        let basis = match self.basis {
            IntervalBasis::Shots => format!("over {} shots", self.shots),
            IntervalBasis::Parts => "over 16 parts of the record, taken as stationary".into(),
            IntervalBasis::None => "none: one transient is one realisation".into(),
        };
        let mut sheet = Sheet {
            name: "increments",
            version: 1,
            title: "Increments against scale".into(),
            about: format!("separations in {space_unit}, lags in {time_unit}"),
            answer: self.answer(),
            note: match self.basis {
                IntervalBasis::None => format!("Intervals: {basis}."),
                _ => format!("Bars: {percent} % intervals {basis}."),
            },
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        for axis in &self.axes {
            let name = axis.words()[0];
            sheet.fact(format!("flatness, {name}"), axis.flatness(self));
            sheet.fact(format!("third moment, {name}"), axis.third(self));
            if let Some(fit) = &axis.exponents {
                let words = axis.exponents_in_words(fit, self);
                sheet.fact(format!("exponents, {name}"), words);
                let relative = fit.relative.iter().zip(1..);
                let relative = relative.map(|(value, p)| format!("{p}: {}", number(*value)));
                let words = relative.collect::<Vec<_>>().join(", ");
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
            sheet.warn(
                format!(
                    "the record is a transient (steadiness {}), one realisation: no interval is stated",
                    number(self.steadiness)
                ),
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
        let rows = self.axes.iter();
        rows.flat_map(|axis| PlotRow::grid(2, axis.charts(self)))
            .collect()
    }
}

impl Increments {
    /// Whether large increments are rare and concentrated at small scales, in words.
    fn answer(&self) -> String {
        let still = self.axes.iter().find(|axis| !axis.moves());
        let still = still.map(|axis| axis.words()[2].to_owned());
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
        still
            .into_iter()
            .chain([verdict])
            .collect::<Vec<_>>()
            .join("; ")
    }
}

impl AxisIncrements {
    /// Name, place in a sentence, and that nothing differs along the axis.
    fn words(&self) -> [&'static str; 3] {
        match self.axis {
            FieldAxis::Space => {
                let same = "no motion between sites: their records are the same";
                ["x", "along x", same]
            }
            FieldAxis::Time => ["time", "in time", "nothing changes in time"],
        }
    }

    /// Of the scales.
    fn unit(&self, of: &Increments) -> String {
        match self.axis {
            FieldAxis::Space => of.units().1,
            FieldAxis::Time => of.units().0,
        }
    }

    /// The two scales with a number each.
    fn ends(
        &self,
        of: &Increments,
        ends: [&ScaleMoments; 2],
        value: [fn(&ScaleMoments) -> f64; 2],
    ) -> String {
        let unit = self.unit(of);
        let at = |m: &ScaleMoments| {
            let flatness = with_half(value[0](m), value[1](m), "");
            format!("{flatness} at {} {unit}", number(m.scale))
        };
        match ends[0].step == ends[1].step {
            true => at(ends[0]),
            false => format!("{}, {}", at(ends[0]), at(ends[1])),
        }
    }

    fn local_flatness(&self, of: &Increments) -> Option<String> {
        let value = [
            |m: &ScaleMoments| m.local_flatness,
            ScaleMoments::local_flatness_half,
        ];
        Some(self.ends(of, self.local_ends()?, value))
    }

    fn flatness(&self, of: &Increments) -> String {
        let (Some(first), Some(last), true) =
            (self.scales.first(), self.scales.last(), self.moves())
        else {
            return self.words()[2].into();
        };
        let value = [|m: &ScaleMoments| m.flatness, ScaleMoments::flatness_half];
        let all = self.ends(of, [first, last], value);
        match (self.local_flatness(of), self.growth) {
            (Some(local), Some([exponent, half])) => {
                let exponent = with_half(exponent, half, "");
                format!(
                    "{all}; local {local}, growing by the power {exponent} towards small scales"
                )
            }
            (Some(local), None) => format!("{all}; local {local}"),
            (None, _) => all,
        }
    }

    fn third(&self, of: &Increments) -> String {
        let (signs, unit) = (self.third_signs(of.alpha), self.unit(of));
        let of_sign = |(sign, name): (f64, &str)| {
            let scales = signs.iter().filter(|(_, s)| *s == sign);
            let scales: Vec<f64> = scales.map(|(x, _)| *x).collect();
            let (n, all) = (scales.len(), self.scales.len());
            let [first, last] = [scales.first()?, scales.last()?].map(|x| number(*x));
            Some(format!(
                "{name} at {n} of {all} scales from {first} to {last} {unit}"
            ))
        };
        let signs = [(-1.0, "negative"), (1.0, "positive")]
            .into_iter()
            .filter_map(of_sign);
        match signs.collect::<Vec<_>>().join("; ") {
            none if none.is_empty() => "its sign is not resolved at any scale".into(),
            words => words,
        }
    }

    fn exponents_in_words(&self, fit: &ScalingExponents, of: &Increments) -> String {
        let values = fit.exponents.iter().zip(&fit.half).zip(1..);
        let text: Vec<String> = values
            .map(|((value, half), p)| format!("{p}: {}", with_half(*value, *half, "")))
            .collect();
        let basis = match fit.basis {
            ExponentBasis::Shots => "over shots",
            ExponentBasis::Parts => "over 16 parts of the record",
            ExponentBasis::Regression => "of the regression",
        };
        let (text, points, unit) = (text.join(", "), fit.points, self.unit(of));
        let [from, to] = fit.band.map(number);
        format!("{text}; {points} scales from {from} to {to} {unit}, intervals {basis}")
    }

    fn numbers(&self) -> serde_json::Value {
        let all = |of: fn(&ScaleMoments) -> f64| self.scales.iter().map(of).collect::<Vec<f64>>();
        json!({
            "axis": self.axis,
            "scale": all(|m| m.scale),
            "pairs": self.scales.iter().map(|m| m.pairs).collect::<Vec<u64>>(),
            "flatness": all(|m| m.flatness),
            "flatness_half": all(ScaleMoments::flatness_half),
            "local_flatness": all(|m| m.local_flatness),
            "local_flatness_half": all(ScaleMoments::local_flatness_half),
            "growth": self.growth,
            "intermittent": self.is_intermittent(),
            "third": all(|m| m.third),
            "third_half": all(ScaleMoments::third_half),
            "exponents": self.exponents,
        })
    }

    fn variables(&self, units: &Units, sheet: &mut Sheet) {
        let (prefix, length) = match self.axis {
            FieldAxis::Space => ("space", &units.space),
            FieldAxis::Time => ("time", &units.time),
        };
        let n = self.scales.len();
        let named = |name: &str| format!("{prefix}_{name}");
        let scale = named("scale");
        let cubed = units.cubed();
        let lines: [Column<ScaleMoments>; 10] = [
            ("scale", length, |m| m.scale),
            ("pairs", "", |m| m.pairs as f64),
            ("third", &cubed, |m| m.third),
            ("third_half", &cubed, ScaleMoments::third_half),
            ("flatness", "", |m| m.flatness),
            ("flatness_half", "", ScaleMoments::flatness_half),
            ("local_flatness", "", |m| m.local_flatness),
            ("local_flatness_half", "", ScaleMoments::local_flatness_half),
            ("skewness", "", |m| m.skewness),
            ("skewness_half", "", ScaleMoments::skewness_half),
        ];
        for (name, unit, of) in lines {
            let values: Vec<f64> = self.scales.iter().map(of).collect();
            sheet.line(&named(name), &scale, unit, values);
        }
        let structure: Vec<f64> = self.scales.iter().flat_map(|m| m.structure).collect();
        let orders = structure.len() / n.max(1);
        let half = self.scales.iter().flat_map(|m| m.half[..orders].to_vec());
        let axes = [(&scale[..], n), ("order", orders)];
        sheet.variable(
            &named("structure_half"),
            &axes,
            "",
            half.collect::<Vec<f64>>(),
        );
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
        let unit = self.unit(of);
        let (scale_label, along) = match self.axis {
            FieldAxis::Space => (label("separation r", &unit), self.words()[1]),
            FieldAxis::Time => (label("lag τ", &unit), self.words()[1]),
        };
        let points = |of: &dyn Fn(&ScaleMoments) -> f64| -> Vec<(f64, f64)> {
            self.scales.iter().map(|m| (m.scale, of(m))).collect()
        };
        let log_x = self.scales.len() > 3;
        let structure = (0..6).map(|p| {
            // The roots have the unit of the samples and one range.
            let root = 1.0 / (p + 1) as f64;
            let points = points(&|m| m.structure[p].powf(root));
            Series::line(format!("p = {}", p + 1), p, points)
        });
        let mut structure: Vec<Series> = structure.collect();
        if let Some(fit) = &self.exponents {
            structure.extend((0..6).map(|p| self.law(fit, p)));
        }
        let values = structure.iter().flat_map(|s| &s.points).map(|p| p.1);
        let y = extent(values.filter(|v| *v > 0.0));
        let sample = of.unit.as_deref().unwrap_or_default();
        let roots = Chart {
            log_x,
            log_y: true,
            y: y.start / 1.2..1.2 * y.end,
            ..Chart::of(
                format!("structure functions, {along}"),
                &scale_label,
                label("⟨|d|ᵖ⟩^(1/p)", sample),
                structure,
            )
        };
        let ratio = |title: &str, axis: &str, normal: Level, series: Vec<Series>| Chart {
            log_x,
            levels: vec![normal],
            ..Chart::of(format!("{title}, {along}"), &scale_label, axis, series)
        };
        type Of = fn(&ScaleMoments) -> f64;
        let with_bars = |name, colour, of: Of, half: Of| {
            let known = self.scales.iter().filter(|m| of(m).is_finite());
            let bar = |half: f64| if half.is_finite() { half } else { 0.0 };
            let (points, errors) = known.map(|m| ((m.scale, of(m)), bar(half(m)))).unzip();
            let series = Series::line(name, colour, points).marked(Marker::Circle);
            Series { errors, ..series }
        };
        let flatness = vec![
            with_bars(
                "all together",
                BLUE,
                |m| m.flatness,
                ScaleMoments::flatness_half,
            ),
            with_bars(
                "local",
                VERMILLION,
                |m| m.local_flatness,
                ScaleMoments::local_flatness_half,
            ),
        ];
        let at = |at, label: &str| Level {
            at,
            label: label.into(),
        };
        let normal = at(3.0, "normal distribution");
        let mut flat = ratio("flatness", "flatness ⟨d⁴⟩/⟨d²⟩²", normal, flatness);
        flat.y = 0.0..flat.y.end.max(3.5);
        let skewness = vec![with_bars(
            "",
            BLUE,
            |m| m.skewness,
            ScaleMoments::skewness_half,
        )];
        let title = "third moment with its sign";
        let mut skew = ratio(title, "skewness ⟨d³⟩/⟨d²⟩^(3/2)", at(0.0, ""), skewness);
        let most = skew.y.start.abs().max(skew.y.end.abs()).max(0.1);
        skew.y = -most..most;
        let charts = [Some(roots), Some(flat), Some(skew), self.histograms(of)];
        charts.into_iter().flatten().collect()
    }

    /// The power law of an order over its band.
    fn law(&self, fit: &ScalingExponents, p: usize) -> Series {
        let in_band = |m: &&ScaleMoments| (fit.band[0]..=fit.band[1]).contains(&m.scale);
        let scales = self.scales.iter().filter(in_band);
        let logs: Vec<(f64, f64)> = scales
            .map(|m| (m.scale.ln(), m.structure[p].ln()))
            .collect();
        let n = logs.len() as f64;
        let sums = logs.iter();
        let (x, y) = sums.fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
        let at = |scale: f64| {
            let power = y + fit.exponents[p] * (scale.ln() - x);
            (scale, (power / (p + 1) as f64).exp())
        };
        let name = if p == 0 {
            "power laws over the band"
        } else {
            ""
        };
        Series::line(name, BLACK, fit.band.map(at).to_vec()).with(Look::Dashed)
    }

    fn histograms(&self, of: &Increments) -> Option<Chart> {
        let unit = self.unit(of);
        let symbol = match self.axis {
            FieldAxis::Space => "r",
            FieldAxis::Time => "τ",
        };
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
        let mut series: Vec<Series> = series.collect();
        let first = self.histograms.first()?;
        let normal = centres(&first.edges).into_iter().map(|x| {
            let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
            (x, density)
        });
        let normal = Series::line("normal distribution", BLACK, normal.collect());
        series.push(normal.with(Look::Dashed));
        let densities = self.histograms.iter().flat_map(|h| &h.density);
        let seen = extent(densities.copied().filter(|v| *v > 0.0));
        Some(Chart {
            log_y: true,
            x: -10.0..10.0,
            y: seen.start.max(DEEPEST) / 2.0..2.0 * seen.end.max(0.4),
            ..Chart::of(
                format!("histograms of increments, {}", self.words()[1]),
                "increment over its root mean square",
                "probability density",
                series,
            )
        })
    }
}
