//! What a design says: by how much the measure has changed, against random tries, and the values.

use serde_json::json;

use super::{Design, DesignKey, Designed, Judge};
use crate::chain::scene::Units;
use crate::numeric::sorted;
use crate::sheet::{
    BLUE, Chart, Describe, Level, Look, PlotRow, Series, Sheet, Table, VERMILLION, listed, number,
    percent, with_unit,
};
use crate::unit::label;

/// Keys that the terminal names.
const NAMED: usize = 4;
/// Gains below this share are none.
const LEAST_GAIN: f64 = 1e-6;

const DEFINITIONS: &str = "\
    random tries: As many designs, drawn evenly within the bounds: what a search must beat.";

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
        if !self.after.members.is_empty() {
            let [after, before] = [&self.after, &self.before].map(spread);
            let before = before.map_or_else(String::new, |before| format!("; before {before}"));
            sheet.fact("tolerances", after.unwrap_or_default() + &before);
        }
        let at_bounds: Vec<String> = self.at_bounds().map(str::to_owned).take(NAMED).collect();
        if !at_bounds.is_empty() {
            sheet.fact(
                "at bounds",
                format!("{}: wider ones may do better", listed(&at_bounds)),
            );
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
        sheet.line("search", "try", &unit, &self.search[..]);
        sheet.line("random", "random_try", &unit, &self.random[..]);
        let (time, force) = self.pulse_units();
        for (when, design) in [("before", &self.before), ("after", &self.after)] {
            let named = |name: &str| format!("{name}_{when}");
            let along = named("time");
            sheet.line(&along, &along, time, &design.time[..]);
            sheet.line(&named("force"), &along, force, &design.force[..]);
            sheet.line(&named("value"), "key", "", &design.values[..]);
            if !design.members.is_empty() {
                sheet.line(&named("members"), "member", &unit, &design.members[..]);
            }
        }
        sheet
    }

    /// The course of the search; the pulse before and after.
    fn pictures(&self) -> Vec<PlotRow> {
        PlotRow::grid(2, [self.course(), self.pulses()])
    }
}

fn last(course: &[f64]) -> f64 {
    course.last().copied().unwrap_or(f64::NAN)
}

/// 0, 1, .. tries.
fn tries(course: &[f64]) -> Vec<f64> {
    (0..course.len()).map(|i| i as f64).collect()
}

/// Ends and median of the members; `None` without.
fn spread(design: &Design) -> Option<String> {
    let sorted = sorted(design.members.iter().copied());
    let last = sorted.len().checked_sub(1)?;
    let [low, middle, high] = [0, last.div_ceil(2), last].map(|at| number(sorted[at]));
    Some(format!("{low} to {high}, median {middle}"))
}

impl Designed {
    fn unit(&self) -> String {
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
        with_unit(value, &self.unit())
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
        let (verb, side) = if after < before {
            ("falls", "less")
        } else {
            ("rises", "more")
        };
        let is_better = (after < before) != self.request.is_most;
        let change = match (is_better, before == 0.0) {
            // Only limits make the best design a worse one.
            (false, _) => "which the limits take".to_owned(),
            (true, true) => "the scene has none".to_owned(),
            (true, false) => format!("{} {side}", percent(self.change().abs())),
        };
        let found = match self.is_random {
            true => "a random try found it, the search did not".to_owned(),
            false => {
                let reached = self.shown(last(&self.random));
                format!("as many random tries reach {reached}")
            }
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
            let before = match before.is_nan() {
                true => "not stated".into(),
                false => number(before),
            };
            vec![name, before, number(after), bounds]
        });
        let table = Table::of("Values", &["key", "scene", "design", "bounds"], rows);
        match self.keys.len() <= NAMED {
            true => table.printed(),
            false => table,
        }
    }

    /// Of the measure.
    fn label(&self) -> String {
        label(&self.request.aim.name().replace('_', " "), &self.unit())
    }

    fn course(&self) -> Chart {
        let line = |name, colour, course: &[f64]| Series::of(name, colour, &tries(course), course);
        let mut chart = Chart::of(
            "Best so far",
            "tries",
            self.label(),
            vec![
                line("search", BLUE, &self.search),
                line("random", VERMILLION, &self.random).with(Look::Dashed),
            ],
        );
        let at = self.judged[0];
        if at.is_finite() {
            chart.y.end = chart.y.end.max(1.05 * at);
            chart.levels.push(Level {
                at,
                label: "scene".into(),
            });
        }
        chart
    }

    fn pulses(&self) -> Chart {
        let (time, force) = self.pulse_units();
        Chart::of(
            "Force of the last contact",
            label("time", time),
            label("force", force),
            vec![
                Series::of("scene", VERMILLION, &self.before.time, &self.before.force)
                    .with(Look::Dashed),
                Series::of("design", BLUE, &self.after.time, &self.after.force),
            ],
        )
    }
}
