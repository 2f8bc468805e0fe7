//! What a comparison says: where measurement and run agree, and where they part.

use std::cmp::Ordering;

use serde_json::json;

use super::super::shown::{per_time, places, some_places, warn_of_horizon};
use super::{AtBody, Attenuated, Comparison, InBand, TOLD};
use crate::sheet::{
    BLUE, Chart, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Table, VERMILLION, number,
    percent, with_unit,
};
use crate::unit::label;

/// How the run is off.
const SIDES: [(f64, &str); 2] = [(-1.0, "early"), (1.0, "late")];

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
        let records = &self.overlay.records;
        let mut sheet = Sheet {
            name: "compare-field",
            version: 1,
            title: "Measurement and run".into(),
            about: format!(
                "{} of {} and of a run there",
                records.quantity.name(),
                some_places(records.quantity, &records.bodies, 12)
            ),
            answer: self.answer(),
            tables: vec![self.body_table(), self.band_table()],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.facts(&mut sheet);
        warn_of_horizon(&mut sheet, self.horizon, &records.units[0]);
        sheet.numbers(json!({
            "bodies": self.bodies,
            "bands": self.bands,
            "attenuation": self.attenuation,
            "moved": self.moved.as_ref().map(|both| both.each_ref().map(|moved| json!({
                "verdict": moved.verdict, "up": moved.up.share, "down": moved.down.share, "bound": moved.bound,
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

    /// Arrivals and largest values by body; what is left, spectra, records.
    fn pictures(&self) -> Vec<PlotRow> {
        let worst = self.overlay.worst(self.misfit.as_ref());
        let mut rows = self.overlay.pictures("run", Some(worst));
        if self.fronts().next().is_some() {
            rows.insert(0, PlotRow::of([self.arrival_chart(), self.peak_chart()]));
        }
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
        let is_tried = self.is_told() || self.misfit.is_some();
        match (&self.cause, self.worst()) {
            (Some(cause), _) => format!("measurement and run differ {}", cause.differs()),
            (None, worst) if is_tried => {
                format!("measurement and run differ: {worst}; no one number explains it")
            }
            (None, worst) => format!("measurement and run differ: {worst}"),
        }
    }

    /// Records at which the run is early (-1) or late (1), the one that is least so first.
    fn off(&self, sign: f64) -> Vec<&AtBody> {
        let off = self.bodies.iter();
        let mut off: Vec<&AtBody> = off
            .filter(|at| at.is_late && sign * at.late() > 0.0)
            .collect();
        off.sort_by(|a, b| (sign * a.late()).total_cmp(&(sign * b.late())));
        off
    }

    /// The first of what differs: by how much at most.
    fn worst(&self) -> String {
        let sides = SIDES.iter().filter_map(|(sign, word)| {
            let off = self.off(*sign);
            let most = off.last()?;
            let by = with_unit(most.late().abs(), &self.overlay.records.units[0]);
            Some(match off.len() {
                1 => format!("{by} {word} at {}", self.place(&off)),
                _ => format!("up to {by} {word}"),
            })
        });
        let sides: Vec<String> = sides.collect();
        if !sides.is_empty() {
            return format!("the run arrives {}", sides.join(" and "));
        }
        let other = self.bodies.iter().filter(|at| at.is_other);
        let off = |at: &&AtBody| (at.peak[1] / at.peak[0].max(0.0)).ln().abs();
        if let Some(most) = other.max_by(|a, b| off(a).total_cmp(&off(b))) {
            let (size, place) = (times(most.size()), self.place(&[most]));
            return format!("the run's largest value is {size} the measured at {place}");
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
        let pairs = self.overlay.residual.iter().zip(&self.overlay.run);
        let known = pairs.filter(|(left, _)| left.is_finite());
        let (left, run) = known.fold((0.0, 0.0), |(left, run), (r, p)| {
            (left + r * r, run + p * p)
        });
        left / run.max(f64::MIN_POSITIVE)
    }

    fn place(&self, at: &[&AtBody]) -> String {
        let quantity = self.overlay.records.quantity;
        let mut bodies: Vec<usize> = at.iter().map(|at| at.body).collect();
        bodies.sort_unstable();
        match bodies.len() == self.bodies.len() && bodies.len() > 1 {
            true => format!("all {}", places(quantity)),
            false => some_places(quantity, &bodies, 3),
        }
    }

    fn arrivals(&self) -> Option<String> {
        let shown = |by: f64| with_unit(by.abs(), &self.overlay.records.units[0]);
        let sides = SIDES.iter().filter_map(|(sign, word)| {
            let off = self.off(*sign);
            let (least, most) = off.first().zip(off.last())?;
            let error = TOLD * most.arrival_error.hypot(least.arrival_error);
            let mean = off.iter().map(|at| at.late()).sum::<f64>() / off.len() as f64;
            let place = self.place(&off);
            Some(match (most.late() - least.late()).abs() > error {
                false => format!("{} {word} at {place}", shown(mean)),
                true => format!(
                    "{word} at {place}, {} at {} to {} at {}",
                    number(least.late().abs()),
                    least.body,
                    shown(most.late()),
                    most.body
                ),
            })
        });
        let sides: Vec<String> = sides.collect();
        if !sides.is_empty() {
            return Some(format!("the run is {}", sides.join("; ")));
        }
        let bound = |at: &AtBody| at.late().abs() + 2.0 * at.arrival_error;
        let bound = self.fronts().map(bound).max_by(f64::total_cmp)?;
        Some(format!("agree within {}", shown(bound)))
    }

    /// The run's largest values over the measured ones, with their ends.
    fn sizes(&self) -> Option<String> {
        let mut told: Vec<&AtBody> = self.bodies.iter().filter(|at| at.is_other).collect();
        told.sort_by(|a, b| a.size()[0].total_cmp(&b.size()[0]));
        let Some((least, most)) = told.first().zip(told.last()) else {
            let off = |at: &AtBody| at.size().map(|end| (end - 1.0).abs());
            let most = self.fronts().flat_map(off).max_by(f64::total_cmp)?;
            return Some(match most > 1.0 {
                true => "cannot be told from noise".into(),
                false => format!("agree within {}", percent(most)),
            });
        };
        Some(match least.size()[1] < most.size()[0] {
            true => format!(
                "in the run {} the measured at {}, {} at {}",
                times(least.size()),
                self.place(&[least]),
                times(most.size()),
                most.body
            ),
            false => format!(
                "in the run {} the measured at {}",
                times([most.size()[0], least.size()[1]]),
                self.place(&told)
            ),
        })
    }

    /// Neighbouring bands that do alike: how, between which ratios, and where.
    fn groups(&self) -> Vec<(Ordering, [f64; 2], String)> {
        let told: Vec<(Ordering, &InBand)> = self
            .bands
            .iter()
            .filter_map(|band| Some((self.side(band)?, band)))
            .collect();
        let unit = per_time(&self.overlay.records.units[0]);
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
        let records = &self.overlay.records;
        for (name, text) in [
            ("arrivals", self.arrivals()),
            ("largest values", self.sizes()),
            ("energies", self.energies()),
        ] {
            if let Some(text) = text.filter(|_| !self.is_exact) {
                sheet.fact(name, text);
            }
        }
        if let (Some(misfit), None) = (&self.misfit, &self.cause) {
            let (left, place) = (percent(self.left), misfit.place(records));
            sheet.fact("left", format!("{left} of the energy, {place}"));
        }
        if let Some(both) = self.attenuation {
            let shown = |of: Attenuated| format!("{} ± {}", percent(of.rate), percent(of.error));
            let [measured, run] = both.map(shown);
            sheet.fact(
                "attenuation",
                format!("of largest values {measured} a body measured, {run} in the run"),
            );
        }
        if let Some(both) = &self.moved {
            let [measured, run] = both.each_ref().map(|moved| match moved.reason {
                Some(_) => "untold".into(),
                None => format!(
                    "{} up, {} down",
                    percent(moved.up.share),
                    percent(moved.down.share)
                ),
            });
            sheet.fact("moved", format!("{measured} measured; {run} in the run"));
        }
        let ends = span(self.bodies.iter().map(|at| at.noise)).unwrap_or([0.0; 2]);
        let (low, high) = (number(ends[0]), with_unit(ends[1], &records.units[1]));
        sheet.fact("noise", format!("{low} to {high} by record, at most"));
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
        let head = [
            "at",
            "arrival",
            "run late by",
            "largest",
            "measured",
            "energy left",
        ];
        Table::of("by record", &head, self.bodies.iter().map(row))
    }

    fn band_table(&self) -> Table {
        let unit = per_time(&self.overlay.records.units[0]);
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
        let ratio = "energy of the run over measured";
        let head = ["band", ratio, "correlation", "energy left"];
        Table::of("by frequency", &head, self.bands.iter().map(row))
    }

    fn variables<'a>(&'a self, sheet: &mut Sheet<'a>) {
        self.overlay.variables(sheet, "run");
        let [time, unit] = &self.overlay.records.units;
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

    /// A number of each body where it is known, with its error if it has one.
    fn over_bodies(
        &self,
        (name, colour, marker): (&str, usize, Marker),
        value: impl Fn(&AtBody) -> f64,
        error: Option<fn(&AtBody) -> f64>,
    ) -> Series {
        let known = || self.bodies.iter().filter(|at| value(at).is_finite());
        let points = known().map(|at| (at.body as f64, value(at))).collect();
        Series {
            errors: error.map_or(Vec::new(), |error| known().map(error).collect()),
            ..Series::line(name, colour, points).marked(marker)
        }
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

    fn arrival_chart(&self) -> Chart {
        let circles = ("", BLUE, Marker::Circle);
        let late = self.over_bodies(circles, AtBody::late, Some(|at| at.arrival_error));
        let ordinate = label("run late by", &self.overlay.records.units[0]);
        Chart {
            levels: vec![Level::zero()],
            ..self.by_body("arrival", ordinate, vec![late.with(Look::Dots)])
        }
    }

    fn peak_chart(&self) -> Chart {
        let (blue, red) = (
            ("measured", BLUE, Marker::Circle),
            ("run", VERMILLION, Marker::Square),
        );
        let measured = self.over_bodies(blue, |at| at.peak[0], Some(|at| at.peak_error));
        let run = self.over_bodies(red, |at| at.peak[1], None);
        let ordinate = label("largest value", &self.overlay.records.units[1]);
        self.by_body(
            "largest values",
            ordinate,
            vec![measured, run.with(Look::Dashed)],
        )
    }
}
