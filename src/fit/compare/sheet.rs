//! What a comparison says: where measurement and run agree, and where they part.

use serde_json::json;

use super::super::shown::{per_time, places, record_charts, residual_map, some_places, with_unit};
use super::{AtBody, Attenuated, Comparison, InBand, TOLD};
use crate::sheet::{
    BLUE, Chart, Describe, Level, Look, Marker, Plot, PlotRow, Series, Sheet, Table, VERMILLION,
    listed, number, percent,
};
use crate::unit::label;

const DEFINITIONS: [[&str; 2]; 4] = [
    [
        "arrival",
        "When half of the run's largest value is first reached; measured, that and the delay at which the run's front is most \
         like the record. What is said to differ does so by four standard errors.",
    ],
    [
        "largest value",
        "Of the run; measured, that times the factor by which the run's front fits the record. Differences below 1 % are not \
         told.",
    ],
    [
        "energy",
        "Squares of the records integrated over time, by octaves of frequency, all records together. Ratios are given \
         between what they are if all that the run leaves is noise, and if none is.",
    ],
    [
        "correlation",
        "Squared correlation of measurement and run over the records and frequencies of a band.",
    ],
];

/// How a band does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Same,
    Less,
    More,
}

impl Describe for Comparison {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            name: "compare-field",
            version: 1,
            title: "Measurement and run".into(),
            about: format!(
                "{} of {} and of a run there",
                self.records.quantity.name(),
                some_places(self.records.quantity, &self.records.bodies, 12)
            ),
            answer: self.answer(),
            tables: vec![self.body_table(), self.band_table()],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.facts(&mut sheet);
        if let Some(until) = self.horizon {
            sheet.warn(
                format!(
                    "the chain amplifies rounding: its runs agree until {}, and later samples are left out",
                    with_unit(until, &self.records.units[0])
                ),
                "compare statistics of an ensemble (`cascade sweep`)",
            );
        }
        sheet.numbers(json!({
            "bodies": self.bodies,
            "bands": self.bands,
            "attenuation": self.attenuation,
            "moved": self.moved.as_ref().map(|both| both.each_ref().map(|moved| json!({
                "verdict": moved.verdict, "up": moved.up, "down": moved.down, "bound": moved.bound,
            }))),
            "agree": self.agrees(),
            "misfit": self.misfit,
            "cause": self.cause,
            "left": self.left,
            "exact": self.is_exact,
            "within": self.request.within,
            "horizon": self.horizon,
        }));
        self.variables(&mut sheet);
        sheet
    }

    /// Records, what is left, energies and correlation by band, arrivals and largest values by body.
    fn pictures(&self) -> Vec<PlotRow> {
        let mut rows = PlotRow::grid(
            2,
            record_charts(&self.records, &self.measured, ("run", &self.run)),
        );
        rows.push(PlotRow::of([
            Plot::from(residual_map(&self.records, &self.residual, "run")),
            Plot::from(self.band_chart()),
        ]));
        rows.push(PlotRow::of([self.arrival_chart(), self.peak_chart()]));
        rows
    }
}

impl AtBody {
    /// By how much the run is late.
    fn late(&self) -> f64 {
        self.arrival[1] - self.arrival[0]
    }

    /// The run's largest value over the measured one: its least and its largest value.
    fn size(&self) -> [f64; 2] {
        let ends = [1.0, -1.0].map(|side| self.peak[0] + side * TOLD * self.peak_error);
        ends.map(|end| {
            if end > 0.0 {
                self.peak[1] / end
            } else {
                f64::INFINITY
            }
        })
    }
}

/// The least and the largest of numbers.
fn span(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |ends, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// A ratio between its ends in words: `1.9 to 2.1 times`, `1.20 times`, `more than 3.1 times`.
fn times([low, high]: [f64; 2]) -> String {
    match high / low {
        _ if high.is_infinite() => format!("more than {low:.2} times"),
        wide if wide > 1.02 => format!("{low:.2} to {high:.2} times"),
        _ => format!("{:.3} times", (low * high).sqrt()),
    }
}

impl Comparison {
    fn side(&self, band: &InBand) -> Option<Side> {
        let [low, high] = band.ratio;
        match (low.is_nan(), self.request.within) {
            (true, _) => None,
            (_, within) if high < 1.0 - within => Some(Side::Less),
            (_, within) if low > 1.0 + within => Some(Side::More),
            _ => high.is_finite().then_some(Side::Same),
        }
    }

    /// Whether nothing is told to differ.
    pub fn agrees(&self) -> bool {
        let parts = |band: &InBand| !matches!(self.side(band), None | Some(Side::Same));
        self.misfit.is_none()
            && !self.bodies.iter().any(|at| at.is_late || at.is_other)
            && !self.bands.iter().any(parts)
    }

    fn answer(&self) -> String {
        if self.is_exact {
            return "measurement and run agree to the error of runs".into();
        }
        let noise = |left: f64| format!("noise of {} of the signal", percent(left.sqrt()));
        let mut parts = vec![self.arrivals(), self.sizes(), self.energies()];
        parts.retain(|part| !part.is_empty());
        if self.agrees() {
            // Of measured energy that is all noise the signal is what the run has.
            let size = (self.left / (1.0 - self.left).max(1e-3)).min(self.left_of_run());
            return match parts.is_empty() {
                true => format!("measurement and run agree: {} hides the run", noise(size)),
                false => format!(
                    "measurement and run agree but for {}: {}",
                    noise(size),
                    parts.join("; ")
                ),
            };
        }
        match (&self.cause, &self.misfit) {
            (Some(cause), _) => {
                let names = [std::slice::from_ref(&cause.name), &cause.rivals].concat();
                parts.push(match (names.len(), cause.held.is_nan()) {
                    (1, true) => format!("{} explains it", cause.name),
                    (1, false) => format!(
                        "{} ({} to {}) explains it",
                        cause.name,
                        number(cause.held),
                        number(cause.free)
                    ),
                    _ => format!("a change of one of these explains it: {}", listed(&names)),
                });
            }
            (None, Some(misfit)) => parts.push(format!(
                "{} of the energy is left, {}",
                percent(self.left),
                misfit.place(&self.records)
            )),
            _ => {}
        }
        format!("measurement and run differ: {}", parts.join("; "))
    }

    /// Energy of the difference over that of the run.
    fn left_of_run(&self) -> f64 {
        let sum = |of: fn(f64, f64) -> f64| -> f64 {
            let pairs = self.measured.iter().zip(&self.run);
            pairs
                .filter(|(y, _)| y.is_finite())
                .map(|(y, p)| of(*y, *p))
                .sum()
        };
        sum(|y, p| (y - p) * (y - p)) / sum(|_, p| p * p).max(f64::MIN_POSITIVE)
    }

    fn place(&self, bodies: &[usize]) -> String {
        match bodies.len() == self.bodies.len() && bodies.len() > 1 {
            true => format!("all {}", places(self.records.quantity)),
            false => some_places(self.records.quantity, bodies, 3),
        }
    }

    fn arrivals(&self) -> String {
        let unit = &self.records.units[0];
        let told: Vec<&AtBody> = self.bodies.iter().filter(|at| at.is_late).collect();
        let there = self.bodies.iter().filter(|at| at.arrival[0].is_finite());
        if told.is_empty() {
            let bound = |at: &AtBody| at.late().abs() + 2.0 * at.arrival_error;
            let bound = there.map(bound).fold(f64::NAN, f64::max);
            return match bound.is_nan() {
                true => String::new(),
                false => format!("arrivals agree within {}", with_unit(bound, unit)),
            };
        }
        let side = |is_early: bool, word: &str| {
            let some = told.iter().filter(|at| (at.late() < 0.0) == is_early);
            let some: Vec<(f64, f64, usize)> = some
                .map(|at| (at.late().abs(), at.arrival_error, at.body))
                .collect();
            let [least, most] = [
                some.iter().min_by(|a, b| a.0.total_cmp(&b.0))?,
                some.iter().max_by(|a, b| a.0.total_cmp(&b.0))?,
            ];
            let bodies: Vec<usize> = some.iter().map(|at| at.2).collect();
            let mean = some.iter().map(|at| at.0).sum::<f64>() / some.len() as f64;
            Some(match most.0 - least.0 > TOLD * most.1.hypot(least.1) {
                false => format!(
                    "{} {word} at {}",
                    with_unit(mean, unit),
                    self.place(&bodies)
                ),
                true => format!(
                    "{word} at {}, by {} at {} to {} at {}",
                    self.place(&bodies),
                    number(least.0),
                    least.2,
                    with_unit(most.0, unit),
                    most.2
                ),
            })
        };
        let both = [side(true, "early"), side(false, "late")];
        let both: Vec<String> = both.into_iter().flatten().collect();
        format!("the run arrives {}", both.join(", "))
    }

    /// Fronts of another size.
    fn sizes(&self) -> String {
        let told: Vec<&AtBody> = self.bodies.iter().filter(|at| at.is_other).collect();
        let bodies: Vec<usize> = told.iter().map(|at| at.body).collect();
        let order = |a: &&&AtBody, b: &&&AtBody| a.size()[0].total_cmp(&b.size()[0]);
        let ends = told.iter().min_by(order).zip(told.iter().max_by(order));
        let Some((least, most)) = ends else {
            return String::new();
        };
        let place = self.place(&bodies);
        match least.size()[1] < most.size()[0] {
            true => format!(
                "the run's fronts are {} (at {}) to {} (at {}) as large as measured",
                times(least.size()),
                least.body,
                times(most.size()),
                most.body
            ),
            false => {
                let size = [most.size()[0], least.size()[1]];
                format!(
                    "the run's front is {} as large as measured at {place}",
                    times(size)
                )
            }
        }
    }

    /// Neighbouring bands that do alike, in words.
    fn energies(&self) -> String {
        let mut groups: Vec<(Side, Vec<&InBand>)> = Vec::new();
        for band in &self.bands {
            match (self.side(band), groups.last_mut()) {
                (None, _) => {}
                (Some(side), Some((last, bands))) if *last == side => bands.push(band),
                (Some(side), _) => groups.push((side, vec![band])),
            }
        }
        let unit = per_time(&self.records.units[0]);
        let words = groups.iter().map(|(side, bands)| {
            let (from, to) = (bands[0].from, bands[bands.len() - 1].to);
            let [low, high] = [from, to].map(|f| with_unit(f, &unit));
            let is_last = self.bands.last().is_some_and(|last| last.to <= to);
            let place = match (from > 0.0, is_last) {
                (false, true) => "at all frequencies".into(),
                (false, false) => format!("below {high}"),
                (true, true) => format!("above {low}"),
                (true, false) => format!("between {low} and {high}"),
            };
            let ends = bands
                .iter()
                .fold([f64::INFINITY, 0.0], |[low, high], band| {
                    [f64::min(low, band.ratio[0]), f64::max(high, band.ratio[1])]
                });
            match side {
                Side::Same => {
                    let off = ends.map(|end| (end - 1.0).abs());
                    format!(
                        "energies agree within {} {place}",
                        percent(off[0].max(off[1]))
                    )
                }
                _ => format!("the run has {} the energy {place}", times(ends)),
            }
        });
        words.collect::<Vec<_>>().join(", ")
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        if let Some([measured, run]) = self.attenuation {
            let shown = |of: Attenuated| format!("{} ± {}", percent(of.rate), percent(of.error));
            sheet.fact(
                "attenuation",
                format!(
                    "of largest values {} a body measured, {} in the run",
                    shown(measured),
                    shown(run)
                ),
            );
        }
        if let Some(both) = &self.moved {
            let shown = both.each_ref().map(|moved| match moved.reason {
                Some(_) => "untold".into(),
                None => format!("{} up, {} down", percent(moved.up), percent(moved.down)),
            });
            sheet.fact(
                "moved",
                format!("{} measured; {} in the run", shown[0], shown[1]),
            );
        }
        let seen = self.bands.iter().filter(|band| !band.ratio[0].is_nan());
        if let Some(ends) = span(seen.map(|band| band.correlation)) {
            let [low, high] = ends.map(|correlation| format!("{correlation:.3}"));
            let by_band = match low == high {
                true => low,
                false => format!("{low} to {high} by band"),
            };
            sheet.fact("correlation", by_band);
        }
        let ends = span(self.bodies.iter().map(|at| at.noise)).unwrap_or([0.0; 2]);
        let high = with_unit(ends[1], &self.records.units[1]);
        sheet.fact(
            "noise",
            format!("{} to {high} by record, at most", number(ends[0])),
        );
    }

    fn body_table(&self) -> Table {
        let row = |at: &AtBody| {
            let with_error = |value: f64, error: f64| match value.is_finite() {
                true => format!("{} ± {}", number(value), number(error)),
                false => "below noise".into(),
            };
            vec![
                at.body.to_string(),
                number(at.arrival[1]),
                with_error(at.late(), at.arrival_error),
                number(at.peak[1]),
                with_error(at.peak[0], at.peak_error),
                percent(at.residual),
            ]
        };
        Table {
            title: "by record".into(),
            head: [
                "at",
                "arrival",
                "run late by",
                "largest",
                "measured",
                "energy left",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows: self.bodies.iter().map(row).collect(),
            is_fact: false,
        }
    }

    fn band_table(&self) -> Table {
        let unit = per_time(&self.records.units[0]);
        let row = |band: &InBand| {
            vec![
                format!("{} to {}", number(band.from), with_unit(band.to, &unit)),
                match band.ratio[0].is_nan() {
                    true => "below noise".into(),
                    false => times(band.ratio),
                },
                format!("{:.3}", band.correlation),
                percent(band.residual),
            ]
        };
        Table {
            title: "by frequency".into(),
            head: [
                "band",
                "energy of the run over measured",
                "correlation",
                "energy left",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows: self.bands.iter().map(row).collect(),
            is_fact: false,
        }
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        let [time, unit] = &self.records.units;
        sheet.line("time", "time", time, &self.records.times);
        let bodies: Vec<f64> = self.bodies.iter().map(|at| at.body as f64).collect();
        sheet.line("body", "body", "", bodies);
        sheet.plane("measured", ["time", "body"], unit, &self.measured);
        sheet.plane("run", ["time", "body"], unit, &self.run);
        sheet.plane("residual", ["time", "body"], unit, &self.residual);
        sheet.columns(
            "body",
            &self.bodies,
            &[
                ("arrival_measured", time, |at: &AtBody| at.arrival[0]),
                ("arrival_run", time, |at| at.arrival[1]),
                ("arrival_error", time, |at| at.arrival_error),
                ("peak_measured", unit, |at| at.peak[0]),
                ("peak_run", unit, |at| at.peak[1]),
                ("peak_error", unit, |at| at.peak_error),
                ("noise", unit, |at| at.noise),
                ("residual_by_body", "", |at| at.residual),
            ],
        );
        let frequency = per_time(time);
        sheet.columns(
            "band",
            &self.bands,
            &[
                ("band_from", &frequency, |band: &InBand| band.from),
                ("band_to", &frequency, |band| band.to),
                ("energy_ratio_low", "", |band| band.ratio[0]),
                ("energy_ratio_high", "", |band| band.ratio[1]),
                ("correlation", "", |band| band.correlation),
                ("residual_by_band", "", |band| band.residual),
            ],
        );
    }

    fn band_chart(&self) -> Chart {
        let seen = || self.bands.iter().filter(|band| band.ratio[1].is_finite());
        let middle = |band: &InBand| 0.5 * (band.from + band.to);
        let ratio = Series {
            errors: seen()
                .map(|band| 0.5 * (band.ratio[1] - band.ratio[0]))
                .collect(),
            ..Series::line(
                "energy of the run over the measured",
                BLUE,
                seen()
                    .map(|band| (middle(band), 0.5 * (band.ratio[0] + band.ratio[1])))
                    .collect(),
            )
            .marked(Marker::Circle)
        };
        let correlated = self
            .bands
            .iter()
            .map(|band| (middle(band), band.correlation));
        let correlation = Series::line("correlation", VERMILLION, correlated.collect())
            .with(Look::Dashed)
            .marked(Marker::Square);
        let unit = per_time(&self.records.units[0]);
        let chart = Chart::of(
            "by frequency",
            label("frequency f", &unit),
            "ratio",
            vec![ratio, correlation],
        );
        let ends = span(self.bands.iter().map(middle));
        Chart {
            log_x: self.bands.len() > 1,
            x: ends.map_or(chart.x.clone(), |[low, high]| 0.8 * low..1.25 * high),
            levels: vec![Level {
                at: 1.0,
                label: String::new(),
            }],
            ..chart
        }
    }

    fn at_bodies(&self, of: impl Fn(&AtBody) -> f64) -> Vec<(f64, f64)> {
        let points = self.bodies.iter().map(|at| (at.body as f64, of(at)));
        points.filter(|(_, value)| value.is_finite()).collect()
    }

    fn arrival_chart(&self) -> Chart {
        let errors = self.at_bodies(|at| at.arrival_error);
        let late = Series {
            errors: errors.iter().map(|(_, error)| *error).collect(),
            ..Series::line("", BLUE, self.at_bodies(AtBody::late))
                .with(Look::Dots)
                .marked(Marker::Circle)
        };
        let ordinate = label("run late by", &self.records.units[0]);
        Chart {
            levels: vec![Level::zero()],
            ..Chart::of("arrival", "body", ordinate, vec![late])
        }
    }

    fn peak_chart(&self) -> Chart {
        let errors = self.bodies.iter().filter(|at| at.peak[0].is_finite());
        let measured = Series {
            errors: errors.map(|at| at.peak_error).collect(),
            ..Series::line("measured", BLUE, self.at_bodies(|at| at.peak[0]))
        };
        let run = Series::line("run", VERMILLION, self.at_bodies(|at| at.peak[1]));
        let ordinate = label("largest value", &self.records.units[1]);
        Chart::of(
            "largest values",
            "body",
            ordinate,
            vec![
                measured.marked(Marker::Circle),
                run.with(Look::Dashed).marked(Marker::Square),
            ],
        )
    }
}
