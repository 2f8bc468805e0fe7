//! What a plan says: sensors, how long, how fast, and how well that determines the keys.

use ndarray::Array2;
use serde_json::json;

use super::super::shown::{per_time, places, some_places, with_unit};
use super::{Criterion, Planned, PlannedKey};
use crate::field::Quantity;
use crate::sheet::{
    Chart, Describe, Look, Mark, Marker, PALETTE, PlotRow, Series, Sheet, Table, listed, percent,
};
use crate::unit::label;

/// Keys and bodies that a sentence names, at most.
const NAMED: usize = 4;
const NAMED_BODIES: usize = 12;

/// Share of the run, or of its sampling, from which on more of it would tell more.
const END: f64 = 0.95;
const FAST: f64 = 0.7;

/// Error from which on a value is hardly known.
const HARDLY: f64 = 1.0;

const DEFINITIONS: [[&str; 2]; 4] = [
    [
        "error",
        "Half of the 95 % interval over the value, of a fit without bias at the values of the scene (Cramer and Rao). \
         Other keys that are free, the clock and gains, if so, are fitted with it.",
    ],
    [
        "duration",
        "From when on no error is more than 5 % above that of the whole run.",
    ],
    [
        "rate",
        "Slowest sampling, behind a filter at half of it, at which no error is more than 5 % above that at the rate of the \
         run: the noise has one density, and faster samples are not better ones.",
    ],
    [
        "information by body",
        "Share of each body in what all bodies know of a key, if the others were known.",
    ],
];

impl Describe for Planned {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            name: "plan",
            version: 1,
            title: "Planned measurement".into(),
            about: format!(
                "{} of {} {} for records of {} that determine {}",
                self.chosen.len(),
                self.candidates.len(),
                places(self.request.quantity),
                self.request.quantity.name(),
                listed(
                    &self
                        .keys
                        .iter()
                        .map(|key| key.name.clone())
                        .collect::<Vec<_>>()
                )
            ),
            answer: self.answer(),
            tables: vec![self.table()],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.facts(&mut sheet);
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "keys": self.keys,
            "bodies": self.chosen,
            "evenly_spaced": self.even,
            "criterion": self.request.criterion,
            "exact": self.is_exact,
            "duration": self.duration,
            "sampling_rate": self.rate,
            "noise": self.noise,
            "noise_share": self.noise_share,
            "undetermined": self.undetermined,
            "horizon": self.horizon,
            "runs": self.runs,
        }));
        self.variables(&mut sheet);
        sheet
    }

    /// Errors over the number of sensors, over the duration, over the rate; information over bodies.
    fn pictures(&self) -> Vec<PlotRow> {
        let charts = [
            self.number_chart(),
            self.body_chart(),
            self.time_chart(),
            self.rate_chart(),
        ];
        PlotRow::grid(2, charts)
    }
}

impl PlannedKey {
    /// An error in words.
    fn shown(&self, error: f64) -> String {
        match (error.is_nan(), self.value == 0.0) {
            (true, _) => "undetermined".into(),
            (false, true) => with_unit(error, &self.unit),
            (false, false) if error >= 0.1 => format!("{:.0} %", 100.0 * error),
            (false, false) => percent(error),
        }
    }
}

impl Planned {
    fn at(&self, time: f64) -> String {
        with_unit(time, &self.units[0])
    }

    fn answer(&self) -> String {
        let knows = if self.chosen.len() == 1 {
            "knows"
        } else {
            "know"
        };
        let of = |error: fn(&PlannedKey) -> f64| {
            let all = self
                .keys
                .iter()
                .take(NAMED)
                .map(|key| key.shown(error(key)));
            listed(&all.collect::<Vec<_>>())
        };
        let named = self.keys.iter().take(NAMED);
        let known: Vec<String> = named
            .map(|key| format!("{} to {}", key.name, key.shown(key.planned)))
            .collect();
        let known = known
            .iter()
            .map(|text| text.replace("to undetermined", "not at all"));
        let mut words = format!(
            "{} to {} {knows} {}: evenly spaced {}, all {} {}",
            some_places(self.request.quantity, &self.chosen, NAMED_BODIES),
            self.at(self.duration),
            listed(&known.collect::<Vec<_>>()),
            of(|key| key.even),
            self.candidates.len(),
            of(|key| key.all)
        );
        for direction in self.undetermined.iter().take(NAMED) {
            words += &format!("; {}", direction.words);
        }
        words
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        let evenly = some_places(self.request.quantity, &self.even, NAMED_BODIES);
        let how = match (self.is_exact, self.request.criterion) {
            (true, Criterion::Volume) => "the least volume of all choices",
            (true, Criterion::Worst) => "the least of the largest errors of all choices",
            (false, Criterion::Volume) => "the least volume by exchanges",
            (false, Criterion::Worst) => "the least of the largest errors by exchanges",
        };
        sheet.fact("choice", format!("{how}; evenly spaced are {evenly}"));
        let fastest = self.rates.last().copied().unwrap_or(0.0);
        let rate = |rate: f64| with_unit(rate, &per_time(&self.units[0]));
        sheet.fact(
            "duration",
            format!("{} of {}", self.at(self.duration), self.at(self.end())),
        );
        sheet.fact(
            "sampling",
            format!("{} of {}, behind a filter", rate(self.rate), rate(fastest)),
        );
        let noise = with_unit(self.noise, &self.units[1]);
        let share = percent(self.noise_share);
        sheet.fact(
            "noise",
            format!(
                "{noise} a sample at {}, {share} of the records",
                rate(fastest)
            ),
        );
        sheet.detail("runs", self.runs.to_string());
    }

    fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    fn warnings(&self, sheet: &mut Sheet<'_>) {
        if let Some(until) = self.horizon {
            sheet.warn(
                format!(
                    "the chain amplifies rounding: its runs agree until {}",
                    self.at(until)
                ),
                "later samples are left out: no fit can use them",
            );
        }
        if self.horizon.is_none() && self.duration > END * self.end() {
            sheet.warn(
                "errors still fall at the end of the run",
                "a later `end_time` tells more",
            );
        }
        if self
            .rates
            .last()
            .is_some_and(|fastest| self.rate > FAST * fastest)
        {
            sheet.warn(
                "the run is sampled no faster than needed",
                "more `samples`, or a higher `--rate`, show what faster sampling gains",
            );
        }
        if !self.undetermined.is_empty() {
            sheet.warn(
                "the sensors do not determine all that is free",
                "fix one key of each combination, or measure another quantity",
            );
        }
        let hardly: Vec<String> = self
            .keys
            .iter()
            .filter(|key| key.value != 0.0 && key.planned > HARDLY)
            .map(|key| key.name.clone())
            .collect();
        if !hardly.is_empty() {
            sheet.warn(
                format!(
                    "{} is known to no better than its own size",
                    listed(&hardly)
                ),
                "fix it, or lower the noise",
            );
        }
    }

    fn table(&self) -> Table {
        let row = |key: &PlannedKey| {
            let mut row = vec![key.name.clone(), with_unit(key.value, &key.unit)];
            row.extend([key.planned, key.even, key.all].map(|error| key.shown(error)));
            row
        };
        let all = format!("all {}", self.candidates.len());
        Table {
            title: "errors".into(),
            head: ["key", "scene", "planned", "evenly spaced", &all]
                .map(str::to_owned)
                .to_vec(),
            rows: self.keys.iter().map(row).collect(),
            is_fact: true,
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let [time, _] = &self.units;
        let count = self.by_number[0].nrows();
        let numbers: Vec<f64> = (1..=count).map(|n| n as f64).collect();
        sheet.line("sensors", "sensors", "", numbers);
        sheet.plane(
            "error_by_sensors",
            ["sensors", "key"],
            "",
            &self.by_number[0],
        );
        sheet.plane(
            "error_by_sensors_even",
            ["sensors", "key"],
            "",
            &self.by_number[1],
        );
        sheet.line("time", "time", time, &self.times);
        sheet.plane("error_by_time", ["time", "key"], "", &self.by_time);
        let rate = per_time(&self.units[0]);
        sheet.line("rate", "rate", &rate, &self.rates);
        sheet.plane("error_by_rate", ["rate", "key"], "", &self.by_rate);
        let bodies: Vec<f64> = self.candidates.iter().map(|body| *body as f64).collect();
        sheet.line("body", "body", "", bodies);
        sheet.plane("information", ["body", "key"], "", &self.information);
        sheet.columns(
            "key",
            &self.keys,
            &[
                ("value", "", |key: &PlannedKey| key.value),
                ("error", "", |key| key.planned),
                ("error_even", "", |key| key.even),
                ("error_all", "", |key| key.all),
            ],
        );
    }

    /// A line of each key, with its errors in percent.
    fn lines(&self, x: &[f64], errors: &Array2<f64>, suffix: &str) -> Vec<Series> {
        let of = |(k, key): (usize, &PlannedKey)| {
            // An error of a hundred times the value says nothing, and would hide the others.
            let shown = |error: &f64| {
                if *error > 1e2 {
                    f64::NAN
                } else {
                    100.0 * error
                }
            };
            let y: Vec<f64> = errors.column(k).iter().map(shown).collect();
            Series::of(format!("{}{suffix}", key.name), k % PALETTE.len(), x, &y)
        };
        self.keys.iter().enumerate().map(of).collect()
    }

    /// Errors over what more of costs more, with what is enough.
    fn error_chart(&self, title: &str, x_label: String, lines: Vec<Series>, enough: f64) -> Chart {
        let chart = Chart::of(title, x_label, "error (%)", lines);
        Chart {
            marks: vec![Mark {
                at: enough,
                label: "enough".into(),
            }],
            ..chart.logarithmic()
        }
    }

    fn number_chart(&self) -> Chart {
        let x: Vec<f64> = (1..=self.by_number[0].nrows()).map(|n| n as f64).collect();
        let planned = self.lines(&x, &self.by_number[0], "").into_iter();
        let spaced = self
            .lines(&x, &self.by_number[1], ", evenly spaced")
            .into_iter();
        let lines = planned.map(|line| line.marked(Marker::Circle));
        let lines = lines.chain(spaced.map(|line| line.with(Look::Dashed)));
        let x_label = format!("{} measured", places(self.request.quantity));
        let at = self.chosen.len() as f64;
        let mut chart = self.error_chart("number of sensors", x_label, lines.collect(), at);
        chart.marks[0].label = "plan".into();
        chart
    }

    fn time_chart(&self) -> Chart {
        let lines = self.lines(&self.times, &self.by_time, "");
        let x_label = label("measured until", &self.units[0]);
        self.error_chart("duration", x_label, lines, self.duration)
    }

    fn rate_chart(&self) -> Chart {
        let lines = self.lines(&self.rates, &self.by_rate, "");
        let x_label = label("rate", &per_time(&self.units[0]));
        Chart {
            log_x: true,
            ..self.error_chart("sampling", x_label, lines, self.rate)
        }
    }

    fn body_chart(&self) -> Chart {
        let bodies: Vec<f64> = self.candidates.iter().map(|body| *body as f64).collect();
        let of = |(k, key): (usize, &PlannedKey)| {
            let shares = self
                .information
                .column(k)
                .mapv(|share| 100.0 * share)
                .to_vec();
            Series::of(key.name.clone(), k % PALETTE.len(), &bodies, &shares).marked(Marker::Circle)
        };
        let place = match self.request.quantity {
            Quantity::Force => "contact",
            _ => "body",
        };
        let lines = self.keys.iter().enumerate().map(of).collect();
        let chosen = self.chosen.iter().map(|body| Mark {
            at: *body as f64,
            label: body.to_string(),
        });
        Chart {
            marks: chosen.collect(),
            ..Chart::of("information by body", place, "share (%)", lines)
        }
    }
}
