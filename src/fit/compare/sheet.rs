//! What a comparison says: where measurement and run agree, and where they part.

use std::cmp::Ordering;

use serde_json::json;

use super::super::shown::{
    per_time, places, record_charts, residual_map, some_places, spectrum_chart, with_unit,
};
use super::{AtBody, Attenuated, Comparison, InBand, TOLD};
use crate::sheet::{
    BLUE, Chart, Describe, GREEN, Level, Look, Marker, Plot, PlotRow, Series, Sheet, Table,
    VERMILLION, number, percent,
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

    /// Arrivals and largest values by body, what is left, spectra, records.
    fn pictures(&self) -> Vec<PlotRow> {
        let residual = residual_map(&self.records, &self.residual, "run");
        let spectra = spectrum_chart(
            &self.records,
            [
                ("measured", BLUE, &self.measured),
                ("run", VERMILLION, &self.run),
                ("what is left", GREEN, &self.residual),
            ],
        );
        let mut rows = vec![PlotRow::of([Plot::from(residual), Plot::from(spectra)])];
        if self.fronts().next().is_some() {
            rows.insert(0, PlotRow::of([self.arrival_chart(), self.peak_chart()]));
        }
        rows.extend(PlotRow::grid(
            2,
            record_charts(&self.records, &self.measured, ("run", &self.run)),
        ));
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
    /// Whether the run's energy in a band is less or more than measured, or neither; `None` where noise hides it.
    fn side(&self, band: &InBand) -> Option<Ordering> {
        let [low, high] = band.ratio;
        let within = self.request.within;
        match low.is_nan() {
            true => None,
            _ if high < 1.0 - within => Some(Ordering::Less),
            _ if low > 1.0 + within => Some(Ordering::Greater),
            _ => high.is_finite().then_some(Ordering::Equal),
        }
    }

    /// Whether nothing is told to differ.
    pub fn agrees(&self) -> bool {
        let is_same = |band: &InBand| self.side(band).is_none_or(Ordering::is_eq);
        self.misfit.is_none() && !self.is_told() && self.bands.iter().all(is_same)
    }

    fn is_told(&self) -> bool {
        self.bodies.iter().any(|at| at.is_late || at.is_other)
    }

    /// Records whose front noise does not hide.
    fn fronts(&self) -> impl Iterator<Item = &AtBody> {
        self.bodies.iter().filter(|at| at.arrival[0].is_finite())
    }

    fn answer(&self) -> String {
        if self.is_exact {
            return "measurement and run agree to the error of runs".into();
        }
        if self.agrees() {
            // Of measured energy that is all noise the signal is what the run has.
            let size = (self.left / (1.0 - self.left).max(1e-3)).min(self.left_of_run());
            let noise = format!("noise of {} of the signal", percent(size.sqrt()));
            let is_seen = self.fronts().next().is_some() || !self.groups().is_empty();
            return match is_seen {
                true => format!("measurement and run agree: {noise} is all that is between them"),
                false => format!("measurement and run agree, but {noise} hides the run"),
            };
        }
        let worst = self.worst();
        match &self.cause {
            Some(cause) => format!("measurement and run differ {}", cause.differs()),
            None if self.is_told() || self.misfit.is_some() => {
                format!("measurement and run differ: {worst}; no one number explains it")
            }
            None => format!("measurement and run differ: {worst}"),
        }
    }

    /// The first of what differs: by how much at most.
    fn worst(&self) -> String {
        let late = self.bodies.iter().filter(|at| at.is_late);
        let (early, late): (Vec<&AtBody>, Vec<&AtBody>) = late.partition(|at| at.late() < 0.0);
        let most = |of: Vec<&AtBody>, word: &str| {
            let most = of
                .iter()
                .max_by(|a, b| a.late().abs().total_cmp(&b.late().abs()))?;
            let by = with_unit(most.late().abs(), &self.records.units[0]);
            Some(match of.len() {
                1 => format!("{by} {word} at {}", self.place(&[most.body])),
                _ => format!("up to {by} {word}"),
            })
        };
        let sides: Vec<String> = [most(early, "early"), most(late, "late")]
            .into_iter()
            .flatten()
            .collect();
        if !sides.is_empty() {
            return format!("the run arrives {}", sides.join(" and "));
        }
        let other = self.bodies.iter().filter(|at| at.is_other);
        let off = |at: &&AtBody| (at.peak[1] / at.peak[0].max(0.0)).ln().abs();
        if let Some(most) = other.max_by(|a, b| off(a).total_cmp(&off(b))) {
            let size = times(most.size());
            return format!(
                "the run's largest value is {size} the measured at {}",
                self.place(&[most.body])
            );
        }
        let differ = self.groups().into_iter().filter(|(side, ..)| side.is_ne());
        let off = |ends: &[f64; 2]| (ends[0] * ends[1]).ln().abs();
        match differ.max_by(|a, b| off(&a.1).total_cmp(&off(&b.1))) {
            Some((_, ends, place)) => format!("the run has {} the energy {place}", times(ends)),
            None => format!("{} of the energy is left", percent(self.left)),
        }
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

    fn arrivals(&self) -> Option<String> {
        let unit = &self.records.units[0];
        if !self.bodies.iter().any(|at| at.is_late) {
            let bound = |at: &AtBody| at.late().abs() + 2.0 * at.arrival_error;
            let bound = self.fronts().map(bound).max_by(f64::total_cmp)?;
            return Some(format!("agree within {}", with_unit(bound, unit)));
        }
        let side = |sign: f64, word: &str| {
            let by = |at: &AtBody| sign * at.late();
            let told = self.bodies.iter().filter(|at| at.is_late && by(at) > 0.0);
            let told: Vec<&AtBody> = told.collect();
            let order = |a: &&&AtBody, b: &&&AtBody| by(a).total_cmp(&by(b));
            let (least, most) = told.iter().min_by(order).zip(told.iter().max_by(order))?;
            let bodies: Vec<usize> = told.iter().map(|at| at.body).collect();
            let place = self.place(&bodies);
            let mean = told.iter().map(|at| by(at)).sum::<f64>() / told.len() as f64;
            let error = TOLD * most.arrival_error.hypot(least.arrival_error);
            Some(match by(most) - by(least) > error {
                false => format!("{} {word} at {place}", with_unit(mean, unit)),
                true => format!(
                    "{word} at {place}, {} at {} to {} at {}",
                    number(by(least)),
                    least.body,
                    with_unit(by(most), unit),
                    most.body
                ),
            })
        };
        let both = [side(-1.0, "early"), side(1.0, "late")];
        let both: Vec<String> = both.into_iter().flatten().collect();
        Some(format!("the run is {}", both.join("; ")))
    }

    /// The run's largest values over the measured ones, with their ends.
    fn sizes(&self) -> Option<String> {
        let told: Vec<&AtBody> = self.bodies.iter().filter(|at| at.is_other).collect();
        let order = |a: &&&AtBody, b: &&&AtBody| a.size()[0].total_cmp(&b.size()[0]);
        let ends = told.iter().min_by(order).zip(told.iter().max_by(order));
        let Some((least, most)) = ends else {
            let bound = |at: &AtBody| at.size().map(|end| (end - 1.0).abs());
            let bounds = self.fronts().flat_map(bound);
            return Some(format!(
                "agree within {}",
                percent(bounds.max_by(f64::total_cmp)?)
            ));
        };
        let bodies: Vec<usize> = told.iter().map(|at| at.body).collect();
        Some(match least.size()[1] < most.size()[0] {
            true => format!(
                "in the run {} the measured at {}, {} at {}",
                times(least.size()),
                self.place(&[least.body]),
                times(most.size()),
                most.body
            ),
            false => {
                let size = [most.size()[0], least.size()[1]];
                format!(
                    "in the run {} the measured at {}",
                    times(size),
                    self.place(&bodies)
                )
            }
        })
    }

    /// Neighbouring bands that do alike: how, between which ratios, and where.
    fn groups(&self) -> Vec<(Ordering, [f64; 2], String)> {
        let told: Vec<(Ordering, &InBand)> = self
            .bands
            .iter()
            .filter_map(|band| Some((self.side(band)?, band)))
            .collect();
        let unit = per_time(&self.records.units[0]);
        let group = |group: &[(Ordering, &InBand)]| {
            let (from, to) = (group[0].1.from, group[group.len() - 1].1.to);
            let [low, high] = [from, to].map(|f| with_unit(f, &unit));
            let is_last = self.bands.last().is_some_and(|last| last.to <= to);
            let place = match (from > 0.0, is_last) {
                (false, true) => "at all frequencies".into(),
                (false, false) => format!("below {high}"),
                (true, true) => format!("above {low}"),
                (true, false) => format!("between {low} and {high}"),
            };
            let ratios = group.iter().flat_map(|(_, band)| band.ratio);
            (group[0].0, span(ratios).unwrap_or([f64::NAN; 2]), place)
        };
        told.chunk_by(|a, b| a.0 == b.0).map(group).collect()
    }

    fn energies(&self) -> Option<String> {
        let words = self.groups().into_iter().map(|(side, ends, place)| {
            let off = ends.map(|end| (end - 1.0).abs());
            match side {
                Ordering::Equal => format!("agree within {} {place}", percent(off[0].max(off[1]))),
                _ => format!("in the run {} the measured {place}", times(ends)),
            }
        });
        let words: Vec<String> = words.collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        if !self.is_exact {
            let all = [
                ("arrivals", self.arrivals()),
                ("largest values", self.sizes()),
                ("energies", self.energies()),
            ];
            for (name, text) in all {
                text.into_iter().for_each(|text| sheet.fact(name, text));
            }
        }
        if let (Some(misfit), None) = (&self.misfit, &self.cause) {
            let place = misfit.place(&self.records);
            sheet.fact(
                "left",
                format!("{} of the energy, {place}", percent(self.left)),
            );
        }
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
            let [measured, run] = both.each_ref().map(|moved| match moved.reason {
                Some(_) => "untold".into(),
                None => format!("{} up, {} down", percent(moved.up), percent(moved.down)),
            });
            sheet.fact("moved", format!("{measured} measured; {run} in the run"));
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

    /// A chart over the bodies, with room at its ends.
    fn by_body(&self, title: &str, ordinate: String, series: Vec<Series>) -> Chart {
        let chart = Chart::of(title, "body", ordinate, series);
        let room = 0.03 * (chart.x.end - chart.x.start);
        Chart {
            x: chart.x.start - room..chart.x.end + room,
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
            ..self.by_body("arrival", ordinate, vec![late])
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
        let series = vec![
            measured.marked(Marker::Circle),
            run.with(Look::Dashed).marked(Marker::Square),
        ];
        self.by_body("largest values", ordinate, series)
    }
}
