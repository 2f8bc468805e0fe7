//! What a design says: by how much the measure has changed, against random tries, and the values.

use serde_json::json;

use super::{Design, DesignKey, Designed, Judge};
use crate::chain::scene::Units;
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Chart, Describe, GREEN, Level, Look, PlotRow, Series, Sheet, Table, VERMILLION, number,
    percent, with_unit,
};
use crate::sweep::{ORDER, in_order};
use crate::unit::label;

/// Keys that the terminal names.
const NAMED: usize = 4;
/// Part of the tries at the end, in which a search that has settled gains less than a share.
const LAST: f64 = 0.2;
const SETTLED: f64 = 0.01;
/// Gains below this share are none.
const LEAST_GAIN: f64 = 1e-6;

const DEFINITIONS: &str = "\
random tries: As many designs, drawn evenly within the bounds: what a search must beat.
judged value: Without tolerances the measure; with them that of the worst design within, or their mean, as asked.";

impl Describe for Designed {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            about: format!(
                "{} made {} by {} key{}, in {} tries by {} and as many at random",
                self.request.aim.words(),
                self.wanted(),
                self.keys.len(),
                if self.keys.len() == 1 { "" } else { "s" },
                self.search.len() - 1,
                self.method
            ),
            answer: self.answer(),
            tables: vec![self.table()],
            ..Sheet::of("design", "Designed chain", DEFINITIONS)
        };
        let unit = self.unit();
        let [search, random] = [&self.search, &self.random].map(|course| self.shown(last(course)));
        let text = format!("{}: {search}; random tries {random}", self.method);
        sheet.fact("search", text);
        if !self.after.members.is_empty() {
            let [after, before] = [&self.after, &self.before].map(spread);
            sheet.fact("tolerances", format!("{after}; before {before}"));
        }
        let at_bounds: Vec<&str> = self.at_bounds().collect();
        if !at_bounds.is_empty() {
            let named = at_bounds[..NAMED.min(at_bounds.len())].join(", ");
            let more = match at_bounds.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let text = format!("{named}{more}: wider ones may do better");
            sheet.fact("at bounds", text);
        }
        self.warnings(&mut sheet);
        sheet.numbers(json!({
            "measure": self.request.aim.name(),
            "wanted": self.wanted(),
            "unit": unit,
            "before": self.before.measure,
            "after": self.after.measure,
            "judged_before": self.judged[0],
            "judged_after": self.judged[1],
            "random": last(&self.random),
            "found_by": if self.is_random { "random tries" } else { "search" },
            "method": self.method,
            "tries": self.search.len() - 1,
            "untold": self.untold,
            "beyond_limits": self.beyond,
            "judge": (!self.after.members.is_empty()).then_some(self.request.judge),
            "values": self.values().map(|(key, before, after)| json!({
                "name": key.name, "unit": key.unit, "before": before, "after": after,
                "low": key.bounds[0], "high": key.bounds[1],
            })).collect::<Vec<_>>(),
            "scene": self.scene,
        }));
        sheet.line("try", "try", "", tries(&self.search));
        sheet.line("search", "try", unit, &self.search[..]);
        sheet.line("random", "random_try", unit, &self.random[..]);
        let (time, force) = self.pulse_units();
        for (when, design) in [("before", &self.before), ("after", &self.after)] {
            let named = |name: &str| format!("{name}_{when}");
            let along = named("time");
            sheet.line(&along, &along, time, &design.time[..]);
            sheet.line(&named("force"), &along, force, &design.force[..]);
            sheet.line(&named("value"), "key", "", &design.values[..]);
            if !design.members.is_empty() {
                sheet.line(&named("members"), "member", unit, &design.members[..]);
            }
        }
        sheet
    }

    /// The course of the search; the pulse before and after; values within their bounds; members in order.
    fn pictures(&self) -> Vec<PlotRow> {
        let mut charts = vec![self.course(), self.pulses()];
        if self.keys.len() > 1 {
            charts.push(self.values_chart());
        }
        if !self.after.members.is_empty() {
            charts.push(self.members_chart());
        }
        PlotRow::grid(2, charts)
    }
}

fn last(course: &[f64]) -> f64 {
    course.last().copied().unwrap_or(f64::NAN)
}

/// 0, 1, .. tries.
fn tries(course: &[f64]) -> Vec<f64> {
    (0..course.len()).map(|i| i as f64).collect()
}

/// Ends and median of the members.
fn spread(design: &Design) -> String {
    let sorted = sorted(design.members.iter().copied());
    let at = |share: f64| ((sorted.len() - 1) as f64 * share).round() as usize;
    let [low, middle, high] = [0.0, 0.5, 1.0].map(|share| number(sorted[at(share)]));
    format!("{low} to {high}, median {middle}")
}

impl Designed {
    fn unit(&self) -> &'static str {
        self.request.aim.unit(self.units)
    }

    fn wanted(&self) -> &'static str {
        match self.request.is_most {
            true => "largest",
            false => "least",
        }
    }

    /// A value with the unit.
    fn shown(&self, value: f64) -> String {
        with_unit(value, self.unit())
    }

    fn pulse_units(&self) -> (&'static str, &'static str) {
        match self.units {
            Units::Si => ("s", "N"),
            Units::None => ("", ""),
        }
    }

    /// Relative change of the judged value.
    fn change(&self) -> f64 {
        let [before, after] = self.judged;
        (after - before) / before.abs()
    }

    fn answer(&self) -> String {
        let [before, after] = self.judged;
        let words = self.request.aim.words();
        let what = match (self.after.members.is_empty(), self.request.judge) {
            (true, _) => words,
            (false, Judge::Worst) => format!("the worst of {words}"),
            (false, Judge::Mean) => format!("the mean of {words}"),
        };
        if self.change().abs() <= LEAST_GAIN {
            let stays = self.shown(before);
            return format!("no design does better than the scene: {what} stays {stays}");
        }
        let share = percent(self.change().abs());
        let change = match before.is_nan() || before == 0.0 {
            true => "the scene exceeds a limit".to_owned(),
            false if after < before => format!("{share} less"),
            false => format!("{share} more"),
        };
        let verb = match after < before || before.is_nan() {
            true => "falls",
            false => "rises",
        };
        let reached = self.shown(last(&self.random));
        let found = match self.is_random {
            true => "a random try found it, the search did not".to_owned(),
            false => format!("as many random tries reach {reached}"),
        };
        let (before, after) = (number(before), self.shown(after));
        format!("{what} {verb} from {before} to {after}, {change}; {found}")
    }

    /// Keys with their values in the scene and in the design.
    fn values(&self) -> impl Iterator<Item = (&DesignKey, f64, f64)> {
        let values = self.before.values.iter().zip(&self.after.values);
        let all = self.keys.iter().zip(values);
        all.map(|(key, (before, after))| (key, *before, *after))
    }

    fn at_bounds(&self) -> impl Iterator<Item = &str> {
        let is_at = |(key, _, value): &(&DesignKey, f64, f64)| {
            let [low, high] = key.bounds;
            let near = (value - low).abs().min((value - high).abs());
            key.listed == 0 && near < 1e-3 * (high - low)
        };
        self.values().filter(is_at).map(|(key, ..)| &*key.name)
    }

    fn warnings(&self, sheet: &mut Sheet) {
        let n = self.search.len();
        let begin = self.search[((1.0 - LAST) * n as f64) as usize];
        let gained = ((begin - last(&self.search)) / last(&self.search)).abs();
        if !self.is_random && self.keys.len() > 1 && gained > SETTLED {
            let gained = percent(gained);
            let text = format!("the search still gains {gained} in its last fifth");
            sheet.warn(text, "allow more `--tries`");
        }
        if self.is_random {
            sheet.warn(
                "random tries found a better design than the search",
                "allow more `--tries`, or narrow the bounds",
            );
        }
        if self.untold > 0 {
            let text = format!("the runs of {} tries do not tell the measure", self.untold);
            sheet.warn(text, "a later `end_time` or more `samples` may show it");
        }
        if self.after.error.is_some_and(|error| error > 0.01) {
            sheet.warn(
                "the chain found amplifies rounding: its run is not the only one",
                "judge it by `cascade sweep --members`",
            );
        }
    }

    fn table(&self) -> Table {
        let rows = self.values().map(|(key, before, after)| {
            let [low, high] = key.bounds.map(number);
            let bounds = match key.listed {
                0 => format!("{low} to {high}"),
                n => format!("{n} values, {low} to {high}"),
            };
            let name = label(&key.name, &key.unit);
            vec![name, number(before), number(after), bounds]
        });
        let table = Table::of("Values", &["key", "scene", "design", "bounds"], rows);
        match self.keys.len() <= NAMED {
            true => table.printed(),
            false => table,
        }
    }

    /// Of the measure.
    fn label(&self) -> String {
        label(&self.request.aim.name().replace('_', " "), self.unit())
    }

    fn course(&self) -> Chart {
        let line = |name, colour, course: &[f64]| Series::of(name, colour, &tries(course), course);
        let series = vec![
            line("search", BLUE, &self.search),
            line("random", VERMILLION, &self.random).with(Look::Dashed),
        ];
        let mut chart = Chart::of("Best so far", "tries", self.label(), series);
        let at = self.judged[0];
        if at.is_finite() {
            chart.y.end = chart.y.end.max(1.05 * at);
            chart.levels.push(Level::new(at, "scene"));
        }
        chart
    }

    fn pulses(&self) -> Chart {
        let (time, force) = self.pulse_units();
        let of = |name, colour, of: &Design| Series::of(name, colour, &of.time, &of.force);
        let series = vec![
            of("scene", VERMILLION, &self.before).with(Look::Dashed),
            of("design", BLUE, &self.after),
        ];
        let title = "Force of the last contact";
        Chart::of(title, label("time", time), label("force", force), series)
    }

    /// Values along a list that is free as a whole; of different keys, their places between the bounds.
    fn values_chart(&self) -> Chart {
        let list = |key: &DesignKey| key.name.split('[').next().unwrap_or_default().to_owned();
        let (first, unit) = (list(&self.keys[0]), &self.keys[0].unit);
        let mut keys = self.keys.iter();
        let is_one = keys.all(|key| list(key) == first && key.unit == *unit);
        let of = |values: &[f64]| -> Vec<(f64, f64)> {
            let place = |(key, value): (&DesignKey, &f64)| match is_one {
                true => *value,
                false => (value - key.bounds[0]) / (key.bounds[1] - key.bounds[0]),
            };
            let places = self.keys.iter().zip(values).map(place);
            places.enumerate().map(|(i, v)| (i as f64, v)).collect()
        };
        let (abscissa, ordinate) = match is_one {
            true => ("entry", label(&first.replace('_', " "), unit)),
            false => (
                "key, by its row in the table",
                "share of the way from bound to bound".into(),
            ),
        };
        let series = vec![
            Series::line("scene", VERMILLION, of(&self.before.values)).with(Look::Dashed),
            Series::line("design", BLUE, of(&self.after.values)),
        ];
        Chart::of("Values", abscissa, ordinate, series)
    }

    fn members_chart(&self) -> Chart {
        let of = |design: &Design| in_order(design.members.iter().copied());
        let series = vec![
            Series::line("scene", VERMILLION, of(&self.before)).with(Look::Dashed),
            Series::line("design", GREEN, of(&self.after)),
        ];
        let title = "Within the tolerances, in order";
        Chart::of(title, ORDER, self.label(), series)
    }
}
