//! What a transfer between two sites says.

use serde_json::json;

use super::sheet::over_pairs;
use super::{OutputTransfer, PairTransfer, Transfer};
use crate::sheet::{
    BLUE, Chart, Colors, Column, Describe, GREEN, Look, PlotRow, Role, Series, Sheet, Table, Units,
    VERMILLION, number, percent,
};
use crate::unit::label;

const DEFINITIONS: &str = "\
    Model: Y(f) = L(f) X(f) + Σ Q(f₁, f₂) X(f₁) X(f₂) over f₁ + f₂ = f, differences included, by least squares over realisations.
    Gained from pairs: What the quadratic terms add to the power of a frequency between the two sites, less chance.
    Passes f: Power that the quadratic terms move from below f to above it; positive towards high frequency.
    Not fitted: Each fifth of the realisations is predicted from the others. A share below 0 means that the terms predict nothing.
    Weaker and stronger half: Fitted to the weaker half of the realisations, an expansion must explain the stronger half too.";

impl Describe for Transfer {
    /// Variables: of each output frequency (nf) `frequency`, `input`, `output`, `magnitude`, `magnitude_error`, `phase`,
    /// `linear`, `linear_error`, `gain`, `gain_error`, `residual`, `flux`, `flux_error`, `above`, `above_error`,
    /// `held_out_linear`, `held_out_quadratic`; of each pair (np) `pair_first`, `pair_second`, `pair_third`, `pair_re`,
    /// `pair_im`, `pair_gain`, `pair_gain_error`.
    fn describe(&self) -> Sheet<'_> {
        let shares = &self.shares;
        let title = format!("Transfer from site {} to site {}", self.from, self.to);
        let mut sheet = Sheet {
            about: format!("linear and quadratic terms, {} samples later", self.lag),
            answer: self.answer(),
            note: format!(
                "Bars are standard errors by {} resamplings of {} blocks of realisations.",
                self.resamplings, self.blocks
            ),
            ..Sheet::of("transfer", &title, DEFINITIONS)
        };
        let of_rest = percent(shares.held_out_of_rest);
        let stronger = shares.stronger_half_of_rest;
        let stronger = stronger.map_or("not tested".into(), percent);
        let explained = [
            ("linear terms", percent(shares.linear)),
            ("quadratic terms", percent(shares.quadratic)),
            ("residual", percent(shares.residual)),
            ("not fitted: linear", percent(shares.held_out_linear)),
            ("not fitted: quadratic, of the rest", of_rest),
            ("stronger half: quadratic, of the rest", stronger),
        ];
        let explained = Table::of_values("Explained of the output's power", explained);
        sheet.tables.push(explained.printed());
        self.independence.describe(&mut sheet, self.segment);
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
        let [gains, flux, explained] = self.charts();
        vec![
            PlotRow::of([gains, flux]),
            PlotRow::of([self.map()]).high(1.2),
            PlotRow::of([explained]),
        ]
    }
}

impl Transfer {
    fn words(&self) -> Units {
        Units::in_words(&self.time, &self.space, self.unit.as_deref())
    }

    /// Whether power passes from low to high frequency, in words.
    fn answer(&self) -> String {
        if !self.holds() {
            return "no quadratic transfer is shown: it does not predict what was not fitted"
                .into();
        }
        let unit = self.words().frequency;
        let with_error = |power: f64, error: f64| {
            let [share, error] = [power, error].map(|power| percent(power / self.input()));
            format!("{share} ± {error} of the input's power")
        };
        if let Some(at) = self.passage() {
            let towards = if at.flux > 0.0 { "higher" } else { "lower" };
            let share = with_error(at.flux.abs(), at.flux_error);
            let frequency = number(at.frequency);
            return format!("{share} moves past {frequency} {unit} to {towards} frequencies");
        }
        let (gaining, df) = (self.gaining(), self.outputs[0].frequency);
        let Some(most) = gaining.first() else {
            return "no frequencies gain from others more than by chance".into();
        };
        let share = with_error(most.gain * df, most.gain_error * df);
        let (count, all, frequency) = (gaining.len(), self.outputs.len(), number(most.frequency));
        format!(
            "{count} of {all} frequencies gain from others, {frequency} {unit} most: {share}; which lose it is not resolved"
        )
    }

    fn variables(&self, sheet: &mut Sheet) {
        let units = Units::of(&self.time, &self.space, self.unit.as_deref());
        let cycles = &units.frequency[..];
        let density = &units.density(&[cycles], "")[..];
        let passed = &units.density(&[], "")[..];
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

    /// What each frequency gains, what passes it, and what is explained there of realisations that were not fitted.
    fn charts(&self) -> [Chart; 3] {
        let (df, input) = (self.outputs[0].frequency, self.input());
        let chart = |title: &str, y_label: &str, series: Vec<Series>| {
            Chart::of(title, self.words().label(Role::Frequency), y_label, series).about_zero()
        };
        // Shares of the power of the input need no unit.
        let with_errors = |name, colour, of: &dyn Fn(&OutputTransfer) -> [f64; 2]| {
            let points = self.outputs.iter().map(|o| {
                let [value, error] = of(o).map(|power| power / input);
                [o.frequency, value, error]
            });
            Series::with_errors(name, colour, points)
        };
        let linear = with_errors("linear", BLUE, &|o| [o.linear * df, o.linear_error * df]);
        let pairs = with_errors("from pairs", VERMILLION, &|o| {
            [o.gain * df, o.gain_error * df]
        });
        let flux = with_errors("", VERMILLION, &|o| [o.flux, o.flux_error]);
        let share = |name, colour, of: fn(&OutputTransfer) -> f64| {
            let points = self.outputs.iter().map(|o| (o.frequency, of(o)));
            Series::line(name, colour, points.collect())
        };
        let explained = vec![
            share("linear", BLUE, |o| o.held_out_linear),
            share("quadratic", VERMILLION, |o| o.held_out_quadratic),
            share("residual", GREEN, |o| o.residual / o.output).with(Look::Dashed),
        ];
        let of_input = "share of the input's power";
        let title = "explained of realisations that were not fitted";
        [
            chart("gained by each frequency", of_input, vec![linear, pairs]),
            chart("passes f towards higher frequencies", of_input, vec![flux]),
            Chart {
                y: -0.25..1.0,
                ..chart(title, "share of the output's power", explained)
            },
        ]
    }

    /// What each pair brings to its sum or difference, over output and second frequency.
    fn map(&self) -> Chart {
        let df = self.outputs[0].frequency;
        let bin = |f: f64| (f / df).round() as isize;
        let each = df / self.input();
        let pairs = self.pairs.iter();
        let cells = pairs.map(|p| ([bin(p.third), bin(p.second)], p.gain * each));
        let map = over_pairs(cells, self.outputs.len() as isize, df);
        let sizes = map.values.iter().map(|v| v.abs());
        let largest = sizes.fold(f64::MIN_POSITIVE, f64::max);
        let unit = self.words().frequency;
        Chart {
            title: "what each pair brings".into(),
            caption: "Which pairs of frequencies feed a third, and which take from it.".into(),
            x_label: label("output frequency f = f₁ + f₂", &unit),
            y_label: label("frequency f₂", &unit),
            label: "gain, share of the input".into(),
            colors: Colors::Between(-largest..largest),
            ..map
        }
    }
}
