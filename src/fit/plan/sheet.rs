//! What a plan says: sensors, how long, how fast, and how well that determines the keys.

use ndarray::Array2;
use serde_json::json;

use super::super::shown::{per_time, place, places, some_places, warn_of_horizon};
use super::{Criterion, Planned, PlannedKey};
use crate::sheet::{
    Chart, Describe, Look, Mark, Marker, PALETTE, PlotRow, Series, Sheet, Table, listed, percent,
    with_unit,
};
use crate::unit::label;

/// Keys and bodies that a sentence names, at most.
const NAMED: usize = 4;
const NAMED_BODIES: usize = 12;

/// Share of the run, or of its sampling, from which on more of it would tell more.
const END: f64 = 0.95;
const FAST: f64 = 0.7;

const DEFINITIONS: &str = "\
error: Half of the 95 % interval over the value, of a fit without bias at the values of the scene (Cramer and Rao). \
Other keys that are free, the clock and gains, if so, are fitted with it.
duration: From when on no error is more than 5 % above that of the whole run.
rate: Slowest sampling, behind a filter at half of it, at which no error is more than 5 % above that at the rate of \
the run: the noise has one density, and faster samples are not better ones.
information by body: Share of each body in what all bodies know of a key, if the others were known.";

impl Describe for Planned {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            about: format!(
                "{} of {} {} for records of {} that determine {}",
                self.chosen.len(),
                self.candidates.len(),
                places(self.request.quantity),
                self.request.quantity.name(),
                names(&self.keys)
            ),
            answer: self.answer(),
            tables: vec![self.table()],
            ..Sheet::of("plan", "Planned measurement", DEFINITIONS)
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
        let [number, body] = [self.number_chart(), self.body_chart()];
        PlotRow::grid(2, [number, body, self.time_chart(), self.rate_chart()])
    }
}

fn names<'a>(keys: impl IntoIterator<Item = &'a PlannedKey>) -> String {
    let names: Vec<String> = keys.into_iter().map(|key| key.name.clone()).collect();
    listed(&names)
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
        let named = || self.keys.iter().take(NAMED);
        let of = |error: fn(&PlannedKey) -> f64| {
            let all = named().map(|key| key.shown(error(key)));
            listed(&all.collect::<Vec<_>>())
        };
        let known = named().map(|key| match key.planned.is_nan() {
            true => format!("{} not at all", key.name),
            false => format!("{} to {}", key.name, key.shown(key.planned)),
        });
        let knows = if self.chosen.len() == 1 {
            "knows"
        } else {
            "know"
        };
        let answer = format!(
            "{} to {} {} {}: evenly spaced {}, all {} {}",
            some_places(self.request.quantity, &self.chosen, NAMED_BODIES),
            self.at(self.duration),
            knows,
            listed(&known.collect::<Vec<_>>()),
            of(|key| key.even),
            self.candidates.len(),
            of(|key| key.all)
        );
        let open = self.undetermined.iter().take(NAMED);
        let open = open.map(|open| &*open.words);
        let parts: Vec<&str> = [&*answer].into_iter().chain(open).collect();
        parts.join("; ")
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        let evenly = some_places(self.request.quantity, &self.even, NAMED_BODIES);
        let least = match self.request.criterion {
            Criterion::Volume => "the least volume",
            Criterion::Worst => "the least of the largest errors",
        };
        let how = match self.is_exact {
            true => "of all choices",
            false => "by exchanges",
        };
        let choice = format!("{least} {how}; evenly spaced are {evenly}");
        sheet.fact("choice", choice);
        let [enough, all] = [self.duration, self.end()].map(|time| self.at(time));
        sheet.fact("duration", format!("{enough} of {all}"));
        let [rate, fastest] =
            [self.rate, self.fastest()].map(|rate| with_unit(rate, &self.per_time()));
        sheet.fact("sampling", format!("{rate} of {fastest}, behind a filter"));
        let noise = with_unit(self.noise, &self.units[1]);
        let share = percent(self.noise_share);
        let noise = format!("{noise} a sample at {fastest}, {share} of the records");
        sheet.fact("noise", noise);
        sheet.detail("runs", self.runs.to_string());
    }

    fn per_time(&self) -> String {
        per_time(&self.units[0])
    }

    fn fastest(&self) -> f64 {
        self.rates.last().copied().unwrap_or(0.0)
    }

    fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    fn warnings(&self, sheet: &mut Sheet<'_>) {
        warn_of_horizon(sheet, self.horizon, &self.units[0]);
        if self.horizon.is_none() && self.duration > END * self.end() {
            let text = "errors still fall at the end of the run";
            sheet.warn(text, "a later `end_time` tells more");
        }
        if self.rate > FAST * self.fastest() {
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
    }

    fn table(&self) -> Table {
        let row = |key: &PlannedKey| {
            let errors = [key.planned, key.even, key.all].map(|error| key.shown(error));
            let own = [key.name.clone(), with_unit(key.value, &key.unit)];
            own.into_iter().chain(errors).collect()
        };
        let all = format!("all {}", self.candidates.len());
        let head = ["key", "scene", "planned", "evenly spaced", &all];
        Table::of("errors", &head, self.keys.iter().map(row)).printed()
    }

    fn bodies(&self) -> Vec<f64> {
        self.candidates.iter().map(|body| *body as f64).collect()
    }

    /// 1, 2, .. sensors.
    fn numbers(&self) -> Vec<f64> {
        (1..=self.by_number[0].nrows()).map(|n| n as f64).collect()
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let [number, even] = &self.by_number;
        sheet.line("sensors", "sensors", "", self.numbers());
        sheet.line("time", "time", &self.units[0], &self.times);
        sheet.line("rate", "rate", &self.per_time(), &self.rates);
        sheet.line("body", "body", "", self.bodies());
        for (name, dimension, errors) in [
            ("error_by_sensors", "sensors", number),
            ("error_by_sensors_even", "sensors", even),
            ("error_by_time", "time", &self.by_time),
            ("error_by_rate", "rate", &self.by_rate),
            ("information", "body", &self.information),
        ] {
            sheet.plane(name, [dimension, "key"], "", errors);
        }
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

    /// A line of each key in percent, of shares that say something: one of a hundred would hide the others.
    fn lines(&self, x: &[f64], shares: &Array2<f64>, suffix: &str) -> Vec<Series> {
        let shown = |share: &f64| {
            if *share > 1e2 {
                f64::NAN
            } else {
                100.0 * share
            }
        };
        let of = |(k, key): (usize, &PlannedKey)| {
            let y: Vec<f64> = shares.column(k).iter().map(shown).collect();
            Series::of(format!("{}{suffix}", key.name), k % PALETTE.len(), x, &y)
        };
        self.keys.iter().enumerate().map(of).collect()
    }

    /// Errors over what more of costs more, with what is enough.
    fn error_chart(
        &self,
        title: &str,
        x_label: String,
        lines: Vec<Series>,
        (at, label): (f64, &str),
    ) -> Chart {
        Chart {
            marks: vec![Mark::new(at, label)],
            ..Chart::of(title, x_label, "error (%)", lines).logarithmic()
        }
    }

    fn number_chart(&self) -> Chart {
        let (x, [planned, even]) = (self.numbers(), &self.by_number);
        let planned = self.lines(&x, planned, "").into_iter();
        let lines = planned.map(|line| line.marked(Marker::Circle));
        let even = self.lines(&x, even, ", evenly spaced").into_iter();
        let lines = lines.chain(even.map(|line| line.with(Look::Dashed)));
        let x_label = format!("{} measured", places(self.request.quantity));
        let plan = (self.chosen.len() as f64, "plan");
        self.error_chart("number of sensors", x_label, lines.collect(), plan)
    }

    fn time_chart(&self) -> Chart {
        let lines = self.lines(&self.times, &self.by_time, "");
        let x_label = label("measured until", &self.units[0]);
        self.error_chart("duration", x_label, lines, (self.duration, "enough"))
    }

    fn rate_chart(&self) -> Chart {
        let lines = self.lines(&self.rates, &self.by_rate, "");
        let x_label = label("rate", &self.per_time());
        Chart {
            log_x: true,
            ..self.error_chart("sampling", x_label, lines, (self.rate, "enough"))
        }
    }

    fn body_chart(&self) -> Chart {
        let lines = self.lines(&self.bodies(), &self.information, "");
        let lines = lines.into_iter().map(|line| line.marked(Marker::Circle));
        let lines = lines.collect();
        let chosen = self.chosen.iter();
        let chosen = chosen.map(|body| Mark::new(*body as f64, body.to_string()));
        let place = place(self.request.quantity);
        Chart {
            marks: chosen.collect(),
            ..Chart::of("information by body", place, "share (%)", lines)
        }
    }
}
