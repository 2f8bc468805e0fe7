//! What a comparison says: where measurement and run agree, and where they part.

use std::cmp::Ordering;

use serde_json::json;

use super::super::shown::{per_time, places, some_places, warn_of_horizon};
use super::{AtBody, Attenuated, Comparison, InBand, TOLD};
use crate::sheet::{
    BLUE, Cell, Chart, Describe, Level, Look, Marker, PlotRow, Series, Sheet, Table, VERMILLION,
    number, percent, with_unit,
};
use crate::unit::label;

/// On which side of the measurement the run is, and by how much where, in words.
type Told = (Ordering, String);

const DEFINITIONS: &str = "\
arrival: When half of the run's largest value is first reached; measured, that and the delay at which the run's \
front is most like the record. What is said to differ does so by four standard errors.
largest value: Of the run; measured, that times the factor by which the run's front fits the record. Differences \
below 1 % are not told.
energy: Squares of the records integrated over time, by octaves of frequency, all records together. Ratios are given \
between what they are if all that the run leaves is noise, and if none is.
correlation: Squared correlation of measurement and run over the records and frequencies of a band.";

impl Describe for Comparison {
    fn describe(&self) -> Sheet<'_> {
        let records = &self.overlay.records;
        let mut sheet = Sheet {
            about: format!(
                "{} of {} and of a run there",
                records.quantity.name(),
                some_places(records.quantity, &records.bodies, 12)
            ),
            answer: self.answer(),
            tables: vec![self.body_table(), self.band_table()],
            ..Sheet::of("compare-field", "Measurement and run", DEFINITIONS)
        };
        self.facts(&mut sheet);
        warn_of_horizon(&mut sheet, self.horizon, &records.units[0]);
        sheet.numbers(json!(self));
        sheet.numbers(json!({
            "moved": self.moved.as_ref().map(|both| both.each_ref().map(|moved| json!({
                "verdict": moved.verdict, "up": moved.up.share, "down": moved.down.share, "bound": moved.bound,
            }))),
            "agree": self.agrees(),
            "within": self.request.within,
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

/// What is told of a ratio between its ends.
fn of_ratio((side, ends, place): (Ordering, [f64; 2], String)) -> Told {
    let off = ends.map(|end| (end - 1.0).abs());
    let words = match side {
        Ordering::Equal => format!("agree within {} {place}", percent(off[0].max(off[1]))),
        _ => format!("in the run {} the measured {place}", times(ends)),
    };
    (side, words)
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
        self.misfit.is_none() && self.differs().is_none()
    }

    /// Records whose front noise does not hide.
    fn fronts(&self) -> impl Iterator<Item = &AtBody> {
        self.bodies.iter().filter(|at| at.arrival[0].is_finite())
    }

    fn answer(&self) -> String {
        if self.is_exact {
            return "measurement and run agree to the error of runs".into();
        }
        let differs = self.differs();
        if self.misfit.is_none() && differs.is_none() {
            let noise = percent(self.left_of_run().sqrt());
            let is_seen = self.told().iter().any(|(_, told)| !told.is_empty());
            let noise = format!("noise of {noise} of the signal");
            return match is_seen {
                true => format!("measurement and run agree: {noise} is all that is between them"),
                false => format!("measurement and run agree, but {noise} hides the run"),
            };
        }
        let is_told = self.bodies.iter().any(|at| at.is_late || at.is_other);
        let left = || format!("{} of the energy is left", percent(self.left));
        let how = match &self.cause {
            Some(cause) => format!(" {}", cause.differs()),
            None => format!(": {}", differs.unwrap_or_else(left)),
        };
        let tried = match self.cause.is_none() && (is_told || self.misfit.is_some()) {
            true => "; no one number explains it",
            false => "",
        };
        format!("measurement and run differ{how}{tried}")
    }

    /// The first of what differs.
    fn differs(&self) -> Option<String> {
        self.told().into_iter().find_map(|(name, told)| {
            let differ = told.into_iter().filter(|(side, _)| side.is_ne());
            let words: Vec<String> = differ.map(|(_, words)| words).collect();
            (!words.is_empty()).then(|| format!("{name} {}", words.join(" and ")))
        })
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

    /// Bodies at which numbers are below one, and those at which they are above: between which ends, and where.
    fn beside(
        &self,
        one: f64,
        ends: impl Fn(&AtBody) -> Option<[f64; 2]>,
    ) -> Vec<(Ordering, [f64; 2], String)> {
        let quantity = self.overlay.records.quantity;
        let on = |side: Ordering| {
            let told = self.bodies.iter().filter_map(|at| Some((at, ends(at)?)));
            let off: Vec<_> = told
                .filter(|(_, ends)| ends[0].total_cmp(&one) == side)
                .collect();
            let ends = span(off.iter().flat_map(|(_, ends)| *ends))?;
            let mut bodies: Vec<usize> = off.iter().map(|(at, _)| at.body).collect();
            bodies.sort_unstable();
            let place = match bodies.len() == self.bodies.len() && bodies.len() > 1 {
                true => format!("at all {}", places(quantity)),
                false => format!("at {}", some_places(quantity, &bodies, 3)),
            };
            Some((side, ends, place))
        };
        let sides = [Ordering::Less, Ordering::Greater];
        sides.into_iter().filter_map(on).collect()
    }

    fn arrivals(&self) -> Vec<Told> {
        let shown = |by: f64| with_unit(by, &self.overlay.records.units[0]);
        let late = self.beside(0.0, |at| at.is_late.then(|| [at.late(); 2]));
        let words = |(side, ends, place): (Ordering, [f64; 2], String)| {
            let [low, high] = ends.map(f64::abs);
            let (least, most) = (low.min(high), low.max(high));
            let by = match least < most {
                true => format!("{} to {}", number(least), shown(most)),
                false => shown(most),
            };
            let word = if side.is_lt() { "early" } else { "late" };
            (side, format!("in the run {word} {place}, by {by}"))
        };
        if late.is_empty() {
            let bounds = self
                .fronts()
                .map(|at| at.late().abs() + 2.0 * at.arrival_error);
            let bound = bounds.max_by(f64::total_cmp);
            let words = bound.map(|by| (Ordering::Equal, format!("agree within {}", shown(by))));
            return words.into_iter().collect();
        }
        late.into_iter().map(words).collect()
    }

    /// The run's largest values over the measured ones.
    fn sizes(&self) -> Vec<Told> {
        let other = self.beside(1.0, |at| at.is_other.then(|| at.size()));
        if other.is_empty() {
            let off = |at: &AtBody| at.size().map(|end| (end - 1.0).abs());
            let most = self.fronts().flat_map(off).max_by(f64::total_cmp);
            let words = most.map(|most| match most > 1.0 {
                true => "cannot be told from noise".into(),
                false => format!("agree within {}", percent(most)),
            });
            return words
                .map(|words| (Ordering::Equal, words))
                .into_iter()
                .collect();
        }
        other.into_iter().map(of_ratio).collect()
    }

    /// Neighbouring bands that do alike.
    fn energies(&self) -> Vec<Told> {
        let told = self.bands.iter();
        let told: Vec<(Ordering, &InBand)> = told
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
            of_ratio((group[0].0, span(ratios).unwrap_or([f64::NAN; 2]), place))
        };
        told.chunk_by(|a, b| a.0 == b.0).map(group).collect()
    }

    /// What is told of each kind; nothing where noise hides the run.
    fn told(&self) -> [(&'static str, Vec<Told>); 3] {
        [
            ("arrivals", self.arrivals()),
            ("largest values", self.sizes()),
            ("energies", self.energies()),
        ]
    }

    fn facts(&self, sheet: &mut Sheet<'_>) {
        let records = &self.overlay.records;
        for (name, told) in self.told() {
            let words: Vec<String> = told.into_iter().map(|(_, words)| words).collect();
            if !words.is_empty() && !self.is_exact {
                sheet.fact(name, words.join("; "));
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
        fn with_error(value: f64, error: f64) -> String {
            match value.is_finite() {
                true => format!("{} ± {}", number(value), number(error)),
                false => "below noise".into(),
            }
        }
        let columns: [(&str, Cell<AtBody>); 6] = [
            ("at", |at| Some(at.body.to_string())),
            ("arrival", |at| Some(number(at.arrival[1]))),
            ("run late by", |at| {
                Some(with_error(at.late(), at.arrival_error))
            }),
            ("largest", |at| Some(number(at.peak[1]))),
            ("measured", |at| Some(with_error(at.peak[0], at.peak_error))),
            ("energy left", |at| Some(percent(at.residual))),
        ];
        Table::of_columns("by record", &self.bodies, &columns)
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

    /// A number and its error, NaN for none, of each body where the number is known.
    fn over_bodies(
        &self,
        (name, colour, marker): (&str, usize, Marker),
        value: fn(&AtBody) -> [f64; 2],
    ) -> Series {
        let points = self.bodies.iter().map(|at| {
            let [value, error] = value(at);
            [at.body as f64, value, error]
        });
        let known = points.filter(|point| point[1].is_finite());
        Series::with_errors(name, colour, known).marked(marker)
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
        let late = self.over_bodies(circles, |at| [at.late(), at.arrival_error]);
        let ordinate = label("run late by", &self.overlay.records.units[0]);
        Chart {
            levels: vec![Level::zero()],
            ..self.by_body("arrival", ordinate, vec![late.with(Look::Dots)])
        }
    }

    fn peak_chart(&self) -> Chart {
        let circles = ("measured", BLUE, Marker::Circle);
        let measured = self.over_bodies(circles, |at| [at.peak[0], at.peak_error]);
        let squares = ("run", VERMILLION, Marker::Square);
        let run = self.over_bodies(squares, |at| [at.peak[1], f64::NAN]);
        let ordinate = label("largest value", &self.overlay.records.units[1]);
        let series = vec![measured, run.with(Look::Dashed)];
        self.by_body("largest values", ordinate, series)
    }
}
