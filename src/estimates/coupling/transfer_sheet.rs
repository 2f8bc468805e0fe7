//! What a transfer between two sites says.

use serde_json::json;

use super::sheet::over_pairs;
use super::{OutputTransfer, PairTransfer, Transfer};
use crate::measure::cycles_per;
use crate::sheet::{
    BLUE, Chart, Colors, Column, Describe, GREEN, HeatChart, Level, Look, PlotRow, Series, Sheet,
    Units, VERMILLION, number, percent,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 5] = [
    [
        "Model",
        "Y(f) = L(f) X(f) + Σ Q(f₁, f₂) X(f₁) X(f₂) over f₁ + f₂ = f, differences included, by least squares over \
         realisations. The input is not taken for Gaussian.",
    ],
    [
        "Gained from pairs",
        "What the quadratic terms add to the power of a frequency between the two sites; what it gives to others \
         is negative. Chance is subtracted.",
    ],
    [
        "Passes f",
        "Power that the quadratic terms move from below f to above it; positive towards high frequency.",
    ],
    [
        "Not fitted",
        "Each fifth of the realisations is predicted from the others. A share below 0 means that the terms \
         predict nothing: the field has no such expansion, or the realisations are too few.",
    ],
    [
        "Weaker and stronger half",
        "The coefficients of an expansion do not depend on the amplitude. Fitted to the weaker half of the \
         realisations, they must explain the stronger half too.",
    ],
];

impl Describe for Transfer {
    /// Variables: of each output frequency (nf) `frequency`, `input`, `output`, `magnitude`, `magnitude_error`, `phase`,
    /// `linear`, `linear_error`, `gain`, `gain_error`, `residual`, `flux`, `flux_error`, `above`, `above_error`,
    /// `held_out_linear`, `held_out_quadratic`; of each pair (np) `pair_first`, `pair_second`, `pair_third`, `pair_re`,
    /// `pair_im`, `pair_gain`, `pair_gain_error`.
    fn describe(&self) -> Sheet<'_> {
        let shares = &self.shares;
        let [from, to] = [self.from, self.to].map(|site| number(self.space.at(site)));
        let title = format!("Transfer from site {} to site {}", self.from, self.to);
        let mut sheet = Sheet {
            about: format!("from {from} to {to}, {} samples later", self.lag),
            answer: self.in_words(),
            note: format!(
                "Bars are standard errors by {} resamplings of {} blocks of realisations.",
                self.resamplings, self.blocks
            ),
            ..Sheet::of("transfer", &title, &DEFINITIONS)
        };
        let fitted = [shares.linear, shares.quadratic, shares.residual];
        let [linear, quadratic, residual] = fitted.map(percent);
        let text =
            format!("linear {linear}, quadratic {quadratic}, residual {residual} of its power");
        sheet.fact("output", text);
        let [linear, quadratic] = [shares.held_out_linear, shares.held_out_of_rest].map(percent);
        let text = format!(
            "of what was not fitted, linear terms explain {linear}, quadratic ones {quadratic} of the rest"
        );
        sheet.fact("prediction", text);
        sheet.detail("findings", self.findings());
        if self.holds() {
            sheet.detail("passage", self.answer());
        }
        let rows = [("unknowns of a frequency", self.unknowns.to_string())];
        self.independence.describe(&mut sheet, self.segment, rows);
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "from": self.from,
            "from_position": self.space.at(self.from),
            "to": self.to,
            "to_position": self.space.at(self.to),
            "lag": self.lag,
            "unknowns": self.unknowns,
            "blocks": self.blocks,
            "resamplings": self.resamplings,
            "input": self.input(),
            "shares": shares,
            "holds": self.holds(),
            "passage": self.passage(),
            "outputs": self.outputs,
        }));
        self.variables(&mut sheet);
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        vec![
            PlotRow::of([self.gain_chart(), self.flux_chart()]),
            PlotRow::of([self.map()]).high(1.2),
            PlotRow::of([self.explained_chart()]),
        ]
    }
}

impl Transfer {
    /// What gained from what, in words.
    fn in_words(&self) -> String {
        if !self.holds() {
            return "no quadratic transfer is shown: it does not predict what was not fitted"
                .into();
        }
        let unit = self.frequency_unit();
        let share = |power: f64| percent(power / self.input());
        if let Some(at) = self.passage() {
            let towards = if at.flux > 0.0 { "higher" } else { "lower" };
            let [share, error] = [at.flux.abs(), at.flux_error].map(share);
            let frequency = number(at.frequency);
            return format!(
                "{share} ± {error} of the input's power moves past {frequency} {unit} to {towards} frequencies"
            );
        }
        let (gaining, df) = (self.gaining(), self.outputs[0].frequency);
        let Some(most) = gaining.first() else {
            return "no frequencies gain from others more than by chance".into();
        };
        let [share, error] = [most.gain * df, most.gain_error * df].map(share);
        let (count, all, frequency) = (gaining.len(), self.outputs.len(), number(most.frequency));
        format!(
            "{count} of {all} frequencies gain from others, {frequency} {unit} most: {share} ± {error} of the input's \
             power; which lose it is not resolved"
        )
    }

    fn warnings(&self, sheet: &mut Sheet) {
        let undetermined: usize = self.outputs.iter().map(|output| output.undetermined).sum();
        if undetermined > 0 {
            let message = format!(
                "{undetermined} terms are not determined: their inputs are 0 or vary together with others"
            );
            let advice =
                "keep to frequencies that the input has (--highest), or excite more of them";
            sheet.warn(message, advice);
        }
        if !self.holds() {
            sheet.warn(
                "quadratic terms do not predict this field; their gains mean nothing",
                "try more realisations, neighbouring sites, --lag; `cascade budget` if the chain is known",
            );
        }
    }

    fn variables(&self, sheet: &mut Sheet) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let cycles = &units.frequency[..];
        let density = &units.density(cycles, "")[..];
        let passed = &units.density("", "")[..];
        let of_outputs: [Column<OutputTransfer>; 17] = [
            ("frequency", cycles, |o| o.frequency),
            ("input", density, |o| o.input),
            ("output", density, |o| o.output),
            ("magnitude", "", |o| o.magnitude),
            ("magnitude_error", "", |o| o.magnitude_error),
            ("phase", "rad", |o| o.phase),
            ("linear", density, |o| o.linear),
            ("linear_error", density, |o| o.linear_error),
            ("gain", density, |o| o.gain),
            ("gain_error", density, |o| o.gain_error),
            ("residual", density, |o| o.residual),
            ("flux", passed, |o| o.flux),
            ("flux_error", passed, |o| o.flux_error),
            ("above", passed, |o| o.above),
            ("above_error", passed, |o| o.above_error),
            ("held_out_linear", "", |o| o.held_out_linear),
            ("held_out_quadratic", "", |o| o.held_out_quadratic),
        ];
        sheet.columns("frequency", &self.outputs, &of_outputs);
        let kernel = units.over_sample();
        let of_pairs: [Column<PairTransfer>; 7] = [
            ("pair_first", cycles, |p| p.first),
            ("pair_second", cycles, |p| p.second),
            ("pair_third", cycles, |p| p.third),
            ("pair_re", &kernel, |p| p.re),
            ("pair_im", &kernel, |p| p.im),
            ("pair_gain", density, |p| p.gain),
            ("pair_gain_error", density, |p| p.gain_error),
        ];
        sheet.columns("pair", &self.pairs, &of_pairs);
    }

    fn frequency_label(&self) -> String {
        label("frequency f", &self.frequency_unit())
    }

    fn frequency_unit(&self) -> String {
        cycles_per(&self.units().0)
    }

    /// A line with the bars of its errors, times a factor.
    fn with_errors(
        &self,
        (label, colour): (&str, usize),
        of: fn(&OutputTransfer) -> [f64; 2],
        factor: f64,
    ) -> Series {
        let outputs = self.outputs.iter();
        let bars = outputs.map(|o| (o.frequency, of(o).map(|value| value * factor)));
        let points = bars.clone().map(|(f, [value, _])| (f, value)).collect();
        Series {
            errors: bars.map(|(_, [_, error])| error).collect(),
            ..Series::line(label, colour, points)
        }
    }

    /// Gains, in shares of the power of the input, which need no unit.
    fn gain_chart(&self) -> Chart {
        let each = self.outputs[0].frequency / self.input();
        let linear = self.with_errors(("linear", BLUE), |o| [o.linear, o.linear_error], each);
        let name = ("from pairs", VERMILLION);
        let pairs = self.with_errors(name, |o| [o.gain, o.gain_error], each);
        self.around_zero("gained by each frequency", vec![linear, pairs])
    }

    fn flux_chart(&self) -> Chart {
        let factor = 1.0 / self.input();
        let flux = self.with_errors(("", VERMILLION), |o| [o.flux, o.flux_error], factor);
        self.around_zero("passes f towards higher frequencies", vec![flux])
    }

    /// Shares of the input, with the bars of their errors inside.
    fn around_zero(&self, title: &str, series: Vec<Series>) -> Chart {
        let ends = series.iter().flat_map(|series| {
            let bars = series.points.iter().zip(&series.errors);
            bars.flat_map(|((_, value), error)| [value - error, value + error])
        });
        let (low, high) = ends.fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        let (space, x_label) = (0.05 * (high - low), self.frequency_label());
        Chart {
            levels: vec![Level::zero()],
            y: low - space..high + space,
            ..Chart::of(title, x_label, "share of the input's power", series)
        }
    }

    fn explained_chart(&self) -> Chart {
        let points = |of: fn(&OutputTransfer) -> f64| -> Vec<(f64, f64)> {
            let outputs = self.outputs.iter();
            outputs.map(|o| (o.frequency, of(o))).collect()
        };
        let residual = points(|o| o.residual / o.output);
        Chart {
            levels: vec![Level::zero()],
            y: -0.25..1.0,
            ..Chart::of(
                "explained of realisations that were not fitted",
                self.frequency_label(),
                "share of the output's power",
                vec![
                    Series::line("linear", BLUE, points(|o| o.held_out_linear)),
                    Series::line("quadratic", VERMILLION, points(|o| o.held_out_quadratic)),
                    Series::line("residual", GREEN, residual).with(Look::Dashed),
                ],
            )
        }
    }

    /// What each pair brings to its sum or difference, over output and second frequency.
    fn map(&self) -> HeatChart {
        let df = self.outputs[0].frequency;
        let bin = |f: f64| (f / df).round() as isize;
        let each = df / self.input();
        let pairs = self.pairs.iter();
        let cells = pairs.map(|p| ([bin(p.third), bin(p.second)], p.gain * each));
        let unit = self.frequency_unit();
        let map = over_pairs(cells, self.outputs.len() as isize, (df, &unit));
        let sizes = map.values.iter().map(|v| v.abs());
        let largest = sizes.filter(|v| v.is_finite()).fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        HeatChart {
            title: "what each pair brings".into(),
            caption: "Which pairs of frequencies feed a third, and which take from it.".into(),
            x_label: label("output frequency f = f₁ + f₂", &unit),
            label: "gain, share of the input".into(),
            colors: Colors::Between(-largest..largest),
            ..map
        }
    }
}
