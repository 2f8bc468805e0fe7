//! The pulse at the wall against a key of the scene.

use serde_json::json;

use super::super::{Computed, Measured, Transmission, TransmissionCurve, TransmissionPoint};
use super::{FORCE, field_charts, laid_over, named, places, points, records};
use crate::chain::scene::Units;
use crate::sheet::{Chart, Look, Mark, Series, Sheet, Table, number};
use crate::sweep::wide;
use crate::unit::label;

/// What stands before the numbers of a pulse, behind the keys.
const ROW: [(&str, &str); 5] = [
    ("largest_over_smallest_coefficient", "/stiffness_ratio"),
    ("relative_force", "/relative_force"),
    ("relative_force_error", "/relative_force_error"),
    ("time_of_flight", "/time_of_flight/value"),
    ("mean_speed", "/mean_speed"),
];

impl Transmission {
    pub(super) fn describe(&self) -> Sheet<'_> {
        let key = self.key.replace('_', " ");
        let tables = self.curves.iter().map(|curve| self.points(&key, curve));
        let mut sheet = Sheet {
            version: 2,
            about: "The pulse at the wall behind a struck chain".into(),
            answer: self.answer(&key),
            records: self.records(),
            tables: tables.collect(),
            ..Sheet::of(
                "transmission",
                &format!("Transmission against {key}"),
                "force: The largest force on the wall, over that of the homogeneous chain.",
            )
        };
        for curve in &self.curves {
            curve.facts(&key, &mut sheet);
        }
        sheet.numbers(json!(self));
        sheet
    }

    /// The least and the largest of all curves, in words.
    fn answer(&self, key: &str) -> String {
        let all = self.curves.iter().flat_map(TransmissionCurve::all);
        let force = |(point, _): &(&TransmissionPoint, _)| point.relative_force;
        let mut all: Vec<_> = all.collect();
        all.sort_by(|a, b| force(a).total_cmp(&force(b)));
        let at = |(point, extreme): &(&TransmissionPoint, Option<(_, f64)>)| {
            let error = extreme.map(|(_, error)| format!(" +- {}", number(error)));
            number(point.value) + &error.unwrap_or_default()
        };
        match (all.first(), all.last()) {
            (Some(least), Some(most)) => {
                let [low, high] = [least, most].map(|end| number(force(end)));
                let low = format!("{} ({low} of the homogeneous chain's)", at(least));
                format!(
                    "force at the wall least at {key} {low}, largest at {} ({high})",
                    at(most)
                )
            }
            _ => "nothing comes through at any value".into(),
        }
    }

    fn points(&self, key: &str, curve: &TransmissionCurve) -> Table {
        let units = match self.units {
            Units::Si => ["time of flight (s)", "mean speed (m/s)"],
            Units::None => ["time of flight", "mean speed"],
        };
        let head = [key, "ratio", "force", units[0], units[1], ""];
        let mut all: Vec<_> = curve.all().collect();
        all.sort_by(|a, b| a.0.value.total_cmp(&b.0.value));
        let rows = all.into_iter().map(|(point, extreme)| {
            vec![
                number(point.value),
                number(point.stiffness_ratio),
                format!("{:.6}", point.relative_force),
                number(point.time_of_flight.value),
                number(point.mean_speed),
                extreme.map_or(String::new(), |(kind, _)| kind.to_owned()),
            ]
        });
        Table::of(named(&curve.settings), &head, rows)
    }

    /// One row for each value of the key and for each extremum: the other keys, the kind of row, the key, and the force
    /// at the wall.
    fn records(&self) -> Table {
        let others = self.curves.first().map_or(&[][..], |curve| &curve.settings);
        let others = others.iter().enumerate();
        let others: Vec<(&str, String)> = others
            .map(|(i, (key, _))| (&**key, format!("/settings/{i}/1")))
            .collect();
        let mut columns: Vec<(&str, &str)> = others.iter().map(|(key, at)| (*key, &**at)).collect();
        columns.extend([("row", "/row"), (&*self.key, "/value")]);
        columns.push(("value_error", "/value_error"));
        columns.extend(ROW);
        let rows = self.curves.iter().flat_map(|curve| {
            curve.all().map(|(point, extreme)| {
                let (kind, error) = extreme.unwrap_or(("value", 0.0));
                let mut object = json!(point);
                object["settings"] = json!(curve.settings);
                object["row"] = json!(kind);
                object["value_error"] = json!(error);
                object
            })
        });
        records(&columns, rows)
    }

    /// Of the first curve.
    pub(super) fn computed_points(&self) -> Option<Computed> {
        let all = &self.curves.first()?.points;
        Some(Computed {
            forces: points(all, |p| Some((p.value, p.relative_force))),
            velocities: points(all, |p| Some((p.value, p.pulse.peak_velocity.value))),
            arrivals: points(all, |p| Some((p.value, p.pulse.velocity_rise_time?.value))),
        })
    }

    /// Force on the wall, time of flight and mean speed against the key, with the extremes as dots and the localized
    /// ratios as marks.
    pub(super) fn charts(&self, measured: &Measured) -> Vec<Chart> {
        let key = match (self.key.ends_with("angle"), self.key.replace('_', " ")) {
            (true, key) => label(&key, "degrees"),
            (false, key) => key,
        };
        let lines = |value: fn(&TransmissionPoint) -> f64| -> Vec<Series> {
            let curves = self.curves.iter().enumerate();
            let series = curves.map(|(i, curve)| {
                let points = points(&curve.points, |p| Some((p.value, value(p))));
                Series::line(named(&curve.settings), i, points)
            });
            series.collect()
        };
        let mut forces = lines(|p| p.relative_force);
        for (i, curve) in self.curves.iter().enumerate() {
            let extremes = curve.extremes.iter().map(|e| &e.point);
            let dots: Vec<(f64, f64)> = extremes.map(|p| (p.value, p.relative_force)).collect();
            // The curve passes through the extrema located between its values.
            forces[i].points.extend(&dots);
            forces[i].points.sort_by(|a, b| a.0.total_cmp(&b.0));
            forces.push(Series::line("", i, dots).with(Look::Dots));
        }
        forces.extend(laid_over(&measured.forces));
        let [time, speed] = match self.units {
            Units::Si => ["s", "m/s"],
            Units::None => ["", "bodies per unit of time"],
        };
        let flights = lines(|p| p.time_of_flight.value);
        let speeds = lines(|p| p.mean_speed);
        let [time, speed] =
            [("time", time), ("speed", speed)].map(|(name, unit)| label(name, unit));
        let mut charts = vec![
            Chart::of("peak force on the wall", &key, FORCE, forces),
            Chart::of("time of flight to the wall", &key, time, flights),
            Chart::of("mean speed", &key, speed, speeds),
        ];
        if let Some(computed) = self.computed_points() {
            charts.extend(field_charts(&key, self.units, &computed, measured));
        }
        let marks = self
            .curves
            .first()
            .map_or(&[][..], |curve| &curve.localized);
        let marks = marks.iter();
        let marks = marks.map(|mark| Mark::new(mark.value, format!("n = {}", mark.order)));
        let marks: Vec<Mark> = marks.collect();
        let is_angle = self.key.ends_with("angle");
        let charts = charts.into_iter().map(|chart| Chart {
            marks: marks.clone(),
            ..if is_angle { chart } else { wide(chart) }
        });
        charts.collect()
    }
}

impl TransmissionCurve {
    /// Points, and extremes with their kind and the error of their value.
    fn all(&self) -> impl Iterator<Item = (&TransmissionPoint, Option<(&'static str, f64)>)> {
        let extremes = self.extremes.iter().map(|extreme| {
            let kind = ["minimum", "maximum"][usize::from(extreme.is_maximum)];
            (&extreme.point, Some((kind, extreme.value_error)))
        });
        let points = self.points.iter().map(|point| (point, None));
        points.chain(extremes)
    }

    /// Its extremes and marks.
    fn facts(&self, key: &str, sheet: &mut Sheet) {
        let settings = named(&self.settings);
        let all = self.all().map(|(point, _)| point);
        let least = all.min_by(|a, b| a.relative_force.total_cmp(&b.relative_force));
        if let Some(least) = least.filter(|_| !settings.is_empty()) {
            let (force, at) = (number(least.relative_force), number(least.value));
            let text = format!("least {force} of the force, at {key} {at}");
            sheet.fact(settings, text);
        }
        if !self.unresolved.is_empty() {
            let between = self.unresolved.iter();
            let between = between.map(|ends| format!("{} to {}", number(ends[0]), number(ends[1])));
            let between = between.collect::<Vec<_>>().join(", ");
            sheet.fact("further extremes", format!("may lie at {key} {between}"));
        }
        let marks = self.localized.iter();
        let marks = marks.map(|mark| format!("{} (order {})", number(mark.value), mark.order));
        let marks: Vec<String> = marks.collect();
        if !marks.is_empty() {
            sheet.fact("localized waves", format!("at {key} {}", marks.join(", ")));
        }
        if !self.nothing_at.is_empty() {
            sheet.fact("no force", format!("at {key} {}", places(&self.nothing_at)));
        }
    }
}
