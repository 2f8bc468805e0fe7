//! What structure functions say.

use serde_json::json;

use super::{
    AxisIncrements, ExponentBasis, FieldAxis, Increments, IntervalBasis, ScaleMoments,
    ScalingExponents,
};
use crate::sheet::{
    BLACK, BLUE, Chart, Column, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Table,
    Units, extent, number, with_half,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 5] = [
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
        "⟨d⁴⟩/⟨d²⟩²: 3 for normal increments. Where it grows towards small scales, the field is \
         intermittent: large increments are rare and concentrated.",
    ],
    [
        "Third moment",
        "⟨d³⟩ with its sign. Negative along x where fronts steepen towards +x. In Burgers' equation and in \
         turbulence a negative one goes with transfer to small scales; elsewhere it states an asymmetry alone.",
    ],
    [
        "Exponent",
        "Slope of ln S_p against the logarithm of the scale over the stated band. The interval of the \
         regression holds deviations from a power law; only that over shots holds what another record would give.",
    ],
];

/// Largest exponent of ten between the ends of an axis of histograms.
const DEEPEST: f64 = 1e-7;

impl Describe for Increments {
    /// Variables of each axis, `space_` and `time_`: `scale`, `pairs` (n); `structure`, `structure_half` (n, 6), orders 1
    /// to 6; `third`, `flatness`, `skewness` (n) with their `_half`, half of the interval, NaN where none can be stated;
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
            let name = axis.name();
            sheet.fact(format!("flatness, {name}"), axis.flatness(self));
            sheet.fact(format!("third moment, {name}"), axis.third(self));
            if let Some(fit) = &axis.exponents {
                sheet.fact(
                    format!("exponents, {name}"),
                    axis.exponents_in_words(fit, self),
                );
            }
        }
        if self.axes.iter().all(|axis| axis.exponents.is_none()) {
            sheet.detail("exponents", "none: state a band with --band or --lag-band");
        }
        for axis in &self.axes {
            let pairs: u64 = axis.scales.iter().map(|m| m.pairs).sum();
            let text = format!("{} scales, {pairs} pairs of samples", axis.scales.len());
            sheet.detail(axis.name(), text);
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
        let exponents = self.axes.iter().filter_map(AxisIncrements::exponent_table);
        sheet.tables.extend(exponents);
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
        if self.basis == IntervalBasis::None {
            return "intermittency cannot be told: one transient is one realisation".into();
        }
        let ends = self.axes.iter().filter_map(|axis| {
            let ends = [axis.scales.first()?, axis.scales.last()?];
            Some((axis, ends, axis.is_intermittent()))
        });
        let ends: Vec<_> = ends.collect();
        let Some((axis, scales, is_intermittent)) = ends.iter().find(|end| end.2).or(ends.first())
        else {
            return "no increments".into();
        };
        let unit = axis.unit(self);
        let [small, large] = scales.map(|m| {
            let flatness = with_half(m.flatness, m.flatness_half(), "");
            format!("{flatness} at {} {unit}", number(m.scale))
        });
        let alike = ends.iter().filter(|end| end.2 == *is_intermittent);
        let along: Vec<&str> = alike.map(|end| end.0.along()).collect();
        match is_intermittent {
            true => format!(
                "intermittent {}: flatness {small}, {large}",
                along.join(" and ")
            ),
            false => format!("no intermittency is shown: flatness {small}, {large}"),
        }
    }
}

impl AxisIncrements {
    fn name(&self) -> &'static str {
        match self.axis {
            FieldAxis::Space => "x",
            FieldAxis::Time => "time",
        }
    }

    fn along(&self) -> &'static str {
        match self.axis {
            FieldAxis::Space => "along x",
            FieldAxis::Time => "in time",
        }
    }

    /// That of the scales.
    fn unit(&self, of: &Increments) -> String {
        let (time, space) = of.units();
        match self.axis {
            FieldAxis::Space => space,
            FieldAxis::Time => time,
        }
    }

    /// Whether the flatness grows towards small scales beyond its intervals.
    fn is_intermittent(&self) -> bool {
        let (Some(first), Some(last)) = (self.scales.first(), self.scales.last()) else {
            return false;
        };
        first.flatness - last.flatness > first.flatness_half() + last.flatness_half()
    }

    fn flatness(&self, of: &Increments) -> String {
        let (Some(first), Some(last)) = (self.scales.first(), self.scales.last()) else {
            return "no scale".into();
        };
        let unit = self.unit(of);
        let at = |m: &ScaleMoments| {
            let value = with_half(m.flatness, m.flatness_half(), "");
            format!("{value} at {} {unit}", number(m.scale))
        };
        let verdict = match self.is_intermittent() {
            true => "; it grows towards small scales, beyond the intervals",
            false => "",
        };
        match self.scales.len() {
            1 => at(first),
            _ => format!("{}, {}{verdict}", at(first), at(last)),
        }
    }

    fn third(&self, of: &Increments) -> String {
        let signs = self.third_signs(of.alpha);
        let unit = self.unit(of);
        let count = |sign: f64| {
            let scales = signs.iter().filter(|(_, s)| *s == sign);
            let scales: Vec<f64> = scales.map(|(x, _)| *x).collect();
            let (first, last) = (scales.first()?, scales.last()?);
            Some(format!(
                "at {} of {} scales from {} to {} {unit}",
                scales.len(),
                self.scales.len(),
                number(*first),
                number(*last)
            ))
        };
        match (count(-1.0), count(1.0)) {
            (None, None) => "its sign is not resolved at any scale".into(),
            (Some(negative), None) => format!("negative {negative}"),
            (None, Some(positive)) => format!("positive {positive}"),
            (Some(negative), Some(positive)) => {
                format!("negative {negative}; positive {positive}")
            }
        }
    }

    fn exponents_in_words(&self, fit: &ScalingExponents, of: &Increments) -> String {
        let values = fit.exponents.iter().zip(&fit.half).zip(1..);
        let text: Vec<String> = values
            .map(|((value, half), p)| format!("{p}: {}", with_half(*value, *half, "")))
            .collect();
        format!(
            "{}; {} scales from {} to {} {}, intervals {}",
            text.join(", "),
            fit.points,
            number(fit.band[0]),
            number(fit.band[1]),
            self.unit(of),
            basis_of(fit)
        )
    }

    /// A row an order.
    fn exponent_table(&self) -> Option<Table> {
        let fit = self.exponents.as_ref()?;
        let row = |p: usize| {
            vec![
                (p + 1).to_string(),
                number(fit.exponents[p]),
                format!("{} {}", number(fit.half[p]), basis_of(fit)),
                number(fit.relative[p]),
            ]
        };
        let head = ["order", "exponent", "half interval", "relative to order 3"];
        Some(Table {
            title: format!("Exponents {}", self.along()),
            head: head.map(str::to_owned).to_vec(),
            rows: (0..fit.exponents.len()).map(row).collect(),
            ..Table::default()
        })
    }

    fn numbers(&self) -> serde_json::Value {
        let all = |of: fn(&ScaleMoments) -> f64| self.scales.iter().map(of).collect::<Vec<f64>>();
        json!({
            "axis": self.axis,
            "scale": all(|m| m.scale),
            "pairs": self.scales.iter().map(|m| m.pairs).collect::<Vec<u64>>(),
            "flatness": all(|m| m.flatness),
            "flatness_half": all(ScaleMoments::flatness_half),
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
        let lines: [Column<ScaleMoments>; 8] = [
            ("scale", length, |m| m.scale),
            ("pairs", "", |m| m.pairs as f64),
            ("third", &cubed, |m| m.third),
            ("third_half", &cubed, ScaleMoments::third_half),
            ("flatness", "", |m| m.flatness),
            ("flatness_half", "", ScaleMoments::flatness_half),
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
            FieldAxis::Space => (label("separation r", &unit), self.along()),
            FieldAxis::Time => (label("lag τ", &unit), self.along()),
        };
        let points = |of: &dyn Fn(&ScaleMoments) -> f64| -> Vec<(f64, f64)> {
            self.scales.iter().map(|m| (m.scale, of(m))).collect()
        };
        let errors = |of: fn(&ScaleMoments) -> f64| -> Vec<f64> {
            let halves = self.scales.iter().map(of);
            halves
                .map(|half| if half.is_finite() { half } else { 0.0 })
                .collect()
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
        let normal = |at: f64, words: &str| {
            vec![Level {
                at,
                label: words.into(),
            }]
        };
        let flatness = Series {
            errors: errors(ScaleMoments::flatness_half),
            ..Series::line("", BLUE, points(&|m| m.flatness)).marked(Marker::Circle)
        };
        let mut flat = Chart {
            log_x,
            levels: normal(3.0, "normal distribution"),
            ..Chart::of(
                format!("flatness, {along}"),
                &scale_label,
                "flatness ⟨d⁴⟩/⟨d²⟩²",
                vec![flatness],
            )
        };
        flat.y = 0.0..flat.y.end.max(3.5);
        let skewness = Series {
            errors: errors(ScaleMoments::skewness_half),
            ..Series::line("", BLUE, points(&|m| m.skewness)).marked(Marker::Circle)
        };
        let mut skew = Chart {
            log_x,
            levels: normal(0.0, ""),
            ..Chart::of(
                format!("third moment with its sign, {along}"),
                &scale_label,
                "skewness ⟨d³⟩/⟨d²⟩^(3/2)",
                vec![skewness],
            )
        };
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
                format!("histograms of increments, {}", self.along()),
                "increment over its root mean square",
                "probability density",
                series,
            )
        })
    }
}

/// What the intervals of exponents rest on.
fn basis_of(fit: &ScalingExponents) -> &'static str {
    match fit.basis {
        ExponentBasis::Shots => "over shots",
        ExponentBasis::Regression => "of the regression",
    }
}
