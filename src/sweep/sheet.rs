//! What a sweep found: the least and the largest force that comes through, and all measures against one of the keys.

use serde_json::json;

use super::axis::quantity;
use super::{Ensemble, Needs, Outcome, Outcomes, Request, Spread, SweptKey};
use crate::numeric::sorted;
use crate::sheet::{Chart, Describe, PlotRow, Series, Sheet, Table, number, terms};
use crate::unit::label;

/// Curves in a chart at most.
const CURVES: usize = 12;
/// Rows of the table at most.
const ROWS: usize = 200;
/// Ends of an axis of this ratio make it logarithmic.
const WIDE: f64 = 30.0;
/// The abscissa of values in order.
pub(crate) const ORDER: &str = "share of members (%)";

/// Abscissa and median, and the band there.
type Curve = Vec<((f64, f64), (f64, f64))>;

/// The members of a sweep that are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    pub request: Request,
    pub outcomes: Outcomes,
}

/// Name, column of the table, and unit in a scene of SI units.
type Measure = (&'static str, &'static str, &'static str);

const MEASURES: [Measure; 6] = [
    ("force, last contact", LAST, "N"),
    (
        "time of the force, last contact",
        "peak_force_last_time",
        "s",
    ),
    ("force, first contact", "peak_force_first", "N"),
    ("energy passed", "energy_passed_last", "J"),
    ("energy lost", "energy_lost", "J"),
    ("error of the velocities", ERROR, ""),
];
const LAST: &str = "peak_force_last";
const ERROR: &str = "error";

const DEFINITIONS: &str = "\
Ensemble: Members that differ in the seed alone. 5 to 95 %: what nine tenths of them lie between, by order statistics; \
spread: their standard deviation. Where a chain amplifies rounding, no digit of a member means anything, but these do.";

impl Describe for Swept {
    fn describe(&self) -> Sheet<'_> {
        let keys = self.request.vary.iter();
        let keys: Vec<&str> = keys.map(|axis| &*axis.key).collect();
        let ensembles = self.request.ensembles(&self.outcomes);
        let count = self.request.members();
        let title = format!("Sweep over {}", keys.join(", ").replace('_', " "));
        let mut sheet = Sheet {
            about: format!("{count} chains of one scene; all numbers are in table.csv"),
            answer: self.answer(),
            tables: vec![self.table()],
            ..Sheet::of("sweep", &title, "")
        };
        if let Some(why) = self.missing() {
            sheet.fact("no force", why);
        }
        for (&index, outcome) in &self.outcomes {
            if let Outcome::Failed(why) = outcome {
                let named = words(keys.iter().copied().zip(self.request.values(index)));
                sheet.warn(format!("{named} failed: {why}"), "");
            }
        }
        sheet.numbers(json!({
            "members": count,
            "known": self.outcomes.len(),
            "failed": sheet.warnings.len(),
        }));
        if !ensembles.is_empty() {
            sheet.tables.insert(0, self.table_of(&ensembles));
            sheet.numbers(json!({ "ensembles": ensembles }));
            sheet.definitions = terms(DEFINITIONS).collect();
        }
        sheet
    }

    /// A chart for each measure that some member has: medians with their bands against a key; of the seed alone, all
    /// values in order.
    fn pictures(&self) -> Vec<PlotRow> {
        let along = abscissa(&self.request.axes());
        PlotRow::grid(
            1,
            MEASURES.iter().filter_map(|measure| match &along {
                Some(along) => self.against(along, measure),
                None => self.in_order(measure),
            }),
        )
    }
}

/// Keys with their values.
fn words<'v>(pairs: impl Iterator<Item = (&'v str, &'v str)>) -> String {
    let words = pairs.map(|(key, value)| format!("{} {}", key.replace('_', " "), short(value)));
    words.collect::<Vec<_>>().join(", ")
}

impl Swept {
    /// `table.csv`: a row for each member.
    ///
    /// # Errors
    /// None for results of this library.
    pub fn csv(&self) -> Result<String, csv::Error> {
        super::table::of_members(&self.request, &self.outcomes)
    }

    /// Members that are done, each by itself.
    fn members(&self) -> Vec<Ensemble> {
        self.request.grouped(&self.outcomes, None)
    }

    /// The ensembles, or, without any, the members; and whether these are ensembles.
    fn points(&self) -> (Vec<Ensemble>, bool) {
        let ensembles = self.request.ensembles(&self.outcomes);
        match ensembles.is_empty() {
            true => (self.members(), false),
            false => (ensembles, true),
        }
    }

    /// A measure against a key, a curve for each combination of the other ones.
    fn against(&self, (along, axis): &(usize, String), measure: &Measure) -> Option<Chart> {
        let (points, is_ensemble) = self.points();
        let mut curves: Vec<(String, Curve)> = Vec::new();
        for point in &points {
            let Some((x, _)) = quantity(&point.values[*along]) else {
                continue;
            };
            let name = self.named(&point.values, Some(*along));
            // The line breaks where there is no value.
            let nothing = [f64::NAN; 3];
            let spread = point.of(measure.1);
            let [median, low, high] = spread.map_or(nothing, |it| [it.median, it.p05, it.p95]);
            let point = ((x, median), (low, high));
            match curves.iter_mut().find(|(known, _)| *known == name) {
                Some((_, points)) => points.push(point),
                None => curves.push((name, vec![point])),
            }
        }
        let every = curves.len().div_ceil(CURVES).max(1);
        let series = curves.into_iter().step_by(every).enumerate();
        let series = series.filter_map(|(n, (name, mut points))| {
            points.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
            let is_known = points.iter().any(|((_, median), _)| median.is_finite());
            let (points, ends) = points.into_iter().unzip();
            let name = match name.as_str() {
                "" if is_ensemble => "median",
                name => name,
            };
            let line = Series::line(name, n, points);
            is_known.then(|| match is_ensemble {
                true => line.with_band("5 to 95 %", ends),
                false => line,
            })
        });
        let title = match every {
            1 => measure.0.to_owned(),
            _ => format!("{}, one of every {every} combinations", measure.0),
        };
        Some(wide(self.chart(measure, title, axis, series.collect())?))
    }

    /// The values of all members of the one ensemble, in order.
    fn in_order(&self, measure: &Measure) -> Option<Chart> {
        self.points().1.then_some(())?;
        let members = self.members();
        let known = members.iter().filter_map(|it| it.of(measure.1));
        let points = in_order(known.map(|spread| spread.median));
        let series = (!points.is_empty()).then(|| Series::line("", 0, points));
        let title = format!("{}, in order", measure.0);
        self.chart(measure, title, ORDER, series.into_iter().collect())
    }

    /// A chart of a measure; `None` without a curve.
    fn chart(
        &self,
        measure: &Measure,
        title: String,
        abscissa: &str,
        series: Vec<Series>,
    ) -> Option<Chart> {
        if series.is_empty() {
            return None;
        }
        let chart = Chart::of(title, abscissa, self.label(measure), series);
        Some(match measure.1 {
            ERROR => chart.logarithmic(),
            _ => chart,
        })
    }

    /// The name of a measure with its unit.
    fn label(&self, (name, _, unit): &Measure) -> String {
        label(name, if self.request.is_si() { unit } else { "" })
    }

    /// The keys with these values, but one of them.
    fn named(&self, values: &[String], but: Option<usize>) -> String {
        let keys = self.request.axes().into_iter().map(|axis| &*axis.key);
        let pairs = keys.zip(values.iter().map(String::as_str)).enumerate();
        words(pairs.filter(|(i, _)| Some(*i) != but).map(|(_, pair)| pair))
    }

    /// Least and largest force that comes through, or medians of ensembles, and of how many members it is known.
    fn answer(&self) -> String {
        let (points, is_ensemble) = self.points();
        let unit = if self.request.is_si() { " N" } else { "" };
        let forces = points.iter();
        let forces = forces.filter_map(|point| Some((point, point.of(LAST)?)));
        let mut forces: Vec<(&Ensemble, &Spread)> = forces.collect();
        forces.sort_by(|a, b| a.1.median.total_cmp(&b.1.median));
        let at = |(point, spread): &(&Ensemble, &Spread)| {
            let mut words = format!("{}{unit}", number(spread.median));
            if is_ensemble {
                let [low, high] = [spread.p05, spread.p95].map(number);
                words += &format!(" ({low} to {high} in 90 % of {} members)", spread.members);
            }
            match self.named(&point.values, None).as_str() {
                "" => words,
                named => format!("{words} at {named}"),
            }
        };
        let count = self.request.members();
        let known: usize = forces.iter().map(|(_, spread)| spread.members).sum();
        let of = match count - known {
            0 => String::new(),
            _ => format!(", known in {known} of {count} members"),
        };
        let force = match is_ensemble {
            true => "median force at the last contact",
            false => "force at the last contact",
        };
        match forces.as_slice() {
            [] => format!("{force} known in none of {count} members"),
            [one] => format!("{force} {}{of}", at(one)),
            [least, .., most] => format!("{force} from {} to {}{of}", at(least), at(most)),
        }
    }

    /// How the measures of ensembles spread.
    fn table_of(&self, ensembles: &[Ensemble]) -> Table {
        let keys = self.request.axes().into_iter().map(|axis| &*axis.key);
        let head = ["measure", "members", "5 %", "median", "95 %", "spread"];
        let measures = MEASURES.map(|measure| (measure.1, self.label(&measure)));
        let rows = ensembles.iter().flat_map(|ensemble| {
            measures.iter().filter_map(move |(column, label)| {
                let spread = ensemble.of(column)?;
                let numbers = [spread.p05, spread.median, spread.p95, spread.deviation];
                let values = ensemble.values.iter().map(|value| short(value));
                let row = values.chain([label.clone(), spread.members.to_string()]);
                Some(row.chain(numbers.map(number)).collect())
            })
        });
        let title = format!("Ensembles; {} has every column", super::ENSEMBLES);
        let head: Vec<&str> = keys.chain(head).collect();
        let table = Table::of(title, &head, rows.take(ROWS));
        match ensembles.len() {
            1 => table.printed(),
            _ => table,
        }
    }

    /// Why members have no force, and what to state.
    fn missing(&self) -> Option<String> {
        let needing = |needs: Needs| {
            let done = self.outcomes.values().filter_map(Outcome::done);
            done.filter(|measures| measures.peak_force_last_needs == Some(needs))
                .count()
        };
        let reasons = [
            (needing(Needs::EndTime), "a later `--end-time`"),
            (needing(Needs::Samples), "more `--samples`"),
            (needing(Needs::Tolerance), "a smaller `--tolerance`"),
            (
                self.request.members() - self.outcomes.len(),
                "the other parts",
            ),
        ];
        let reasons = reasons.iter().filter(|(count, _)| *count > 0);
        let words: Vec<String> = reasons
            .map(|(count, what)| format!("{count} need {what}"))
            .collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// The measures of the members, in rows.
    fn table(&self) -> Table {
        let members = self.members();
        let labels = MEASURES.each_ref().map(|measure| self.label(measure));
        let keys = self.request.vary.iter().map(|axis| &*axis.key);
        let rows = members.iter().take(ROWS).map(|member| {
            let values = member.values.iter().map(|value| short(value));
            let measures = MEASURES.iter().map(|(_, column, _)| {
                let value = member.of(column).map(|spread| spread.median);
                value.map_or("-".into(), number)
            });
            values.chain(measures).collect()
        });
        let title = match members.len() {
            count if count > ROWS => format!("The first {ROWS} members; table.csv has all {count}"),
            _ => "Members".into(),
        };
        let head: Vec<&str> = keys.chain(labels.iter().map(String::as_str)).collect();
        Table::of(title, &head, rows)
    }
}

/// A value with the digits that a reader needs.
fn short(text: &str) -> String {
    match quantity(text) {
        Some((value, "")) => number(value),
        Some((value, unit)) => format!("{} {unit}", number(value)),
        None => text.to_owned(),
    }
}

/// Values in order, over the share of all that lie below them.
pub(crate) fn in_order(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let values = sorted(values);
    let count = values.len() as f64;
    let points = values.into_iter().enumerate();
    points
        .map(|(i, value)| (100.0 * (i as f64 + 0.5) / count, value))
        .collect()
}

/// A chart whose abscissa is logarithmic where it spans decades.
pub(crate) fn wide(chart: Chart) -> Chart {
    Chart {
        log_x: chart.x.start > 0.0 && chart.x.end > WIDE * chart.x.start,
        ..chart
    }
}

/// The key along the abscissa, the numeric one with most values: its index, and its name with its unit; `None` if none
/// has two.
fn abscissa(axes: &[&SweptKey]) -> Option<(usize, String)> {
    let numeric = axes.iter().enumerate().filter_map(|(index, axis)| {
        let (_, unit) = quantity(axis.values.first()?)?;
        let alike = |text: &String| quantity(text).is_some_and(|(_, other)| other == unit);
        let count = axis.values.len();
        (count > 1 && axis.values.iter().all(alike)).then_some((index, count, unit))
    });
    let most = |(index, count, _): &(usize, usize, &str)| (*count, std::cmp::Reverse(*index));
    let (index, _, unit) = numeric.max_by_key(most)?;
    Some((index, label(&axes[index].key.replace('_', " "), unit)))
}
