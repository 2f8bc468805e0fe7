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

/// Abscissa and median, and the band there.
type Curve = Vec<((f64, f64), (f64, f64))>;

/// The members of a sweep that are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    pub request: Request,
    pub outcomes: Outcomes,
}

/// A measure of a member's run.
struct Measure {
    /// Of its chart.
    title: &'static str,
    /// Of its column, and of that in the file.
    name: &'static str,
    column: &'static str,
    quantity: &'static str,
    /// Its unit in a scene of SI units.
    unit: &'static str,
    log: bool,
}

const MEASURES: [Measure; 6] = [
    Measure {
        title: "Largest force at the last contact",
        name: "force, last contact",
        column: "peak_force_last",
        quantity: "force",
        unit: "N",
        log: false,
    },
    Measure {
        title: "When the force at the last contact is largest",
        name: "its time",
        column: "peak_force_last_time",
        quantity: "time",
        unit: "s",
        log: false,
    },
    Measure {
        title: "Largest force at the first contact",
        name: "force, first contact",
        column: "peak_force_first",
        quantity: "force",
        unit: "N",
        log: false,
    },
    Measure {
        title: "Energy passed through the last contact between sites",
        name: "energy passed",
        column: "energy_passed_last",
        quantity: "energy",
        unit: "J",
        log: false,
    },
    Measure {
        title: "Energy lost",
        name: "energy lost",
        column: "energy_lost",
        quantity: "energy",
        unit: "J",
        log: false,
    },
    Measure {
        title: "Estimated error of the velocities",
        name: "error",
        column: "error",
        quantity: "error",
        unit: "m/s",
        log: true,
    },
];

const DEFINITIONS: &str = "\
Ensemble: Members that differ in the seed alone. 5 to 95 %: what nine tenths of them lie between, by order statistics; \
spread: their standard deviation. Where a chain amplifies rounding, no digit of a member means anything, but these do.";

impl Describe for Swept {
    fn describe(&self) -> Sheet<'_> {
        let keys = self.request.vary.iter();
        let keys: Vec<&str> = keys.map(|axis| &*axis.key).collect();
        let ensembles = self.request.ensembles(&self.outcomes);
        let mut sheet = Sheet {
            name: "sweep",
            version: 1,
            title: format!("Sweep over {}", keys.join(", ").replace('_', " ")),
            about: format!(
                "{} chains of one scene; all numbers are in table.csv",
                self.count()
            ),
            answer: self.answer(),
            tables: vec![self.table()],
            ..Sheet::default()
        };
        if let Some(why) = self.missing() {
            sheet.fact("no force", why);
        }
        for (&index, outcome) in &self.outcomes {
            if let Outcome::Failed(why) = outcome {
                let values = self.request.values(index).into_iter();
                let named = words(&keys, values);
                sheet.warn(format!("{named} failed: {why}"), "");
            }
        }
        sheet.numbers(json!({
            "members": self.count(),
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
        let axes = self.request.axes();
        let (points, is_ensemble) = self.points();
        let charts = MEASURES.iter().filter_map(|measure| {
            let Some(along) = Abscissa::of(&axes) else {
                return is_ensemble.then(|| self.in_order(measure)).flatten();
            };
            // Points that differ in nothing but the abscissa make a curve.
            let mut curves: Vec<(String, Curve)> = Vec::new();
            for point in &points {
                let Some((x, _)) = quantity(&point.values[along.index]) else {
                    continue;
                };
                let rest = axes.iter().zip(&point.values).enumerate();
                let rest = rest.filter(|(i, _)| *i != along.index);
                let (keys, values): (Vec<&str>, Vec<&str>) = rest
                    .map(|(_, (axis, value))| (&*axis.key, &**value))
                    .unzip();
                let name = words(&keys, values.into_iter());
                // The line breaks where there is no value.
                let [median, p05, p95] = point.of(measure.column).map_or([f64::NAN; 3], |spread| {
                    [spread.median, spread.p05, spread.p95]
                });
                let point = ((x, median), (p05, p95));
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
                1 => measure.title.to_owned(),
                _ => format!("{}, one of every {every} combinations", measure.title),
            };
            let chart = self.chart(measure, title, &along.label, series.collect())?;
            Some(wide(chart))
        });
        PlotRow::grid(1, charts)
    }
}

impl Measure {
    /// A name of it with its unit.
    fn label(&self, name: &str, is_si: bool) -> String {
        label(name, if is_si { self.unit } else { "" })
    }
}

/// Keys with their values.
fn words<'v>(keys: &[&str], values: impl Iterator<Item = &'v str>) -> String {
    let words = keys.iter().zip(values);
    let words = words.map(|(key, value)| format!("{} {}", key.replace('_', " "), short(value)));
    words.collect::<Vec<_>>().join(", ")
}

impl Swept {
    /// Members in all.
    fn count(&self) -> usize {
        let keys = self.request.vary.iter();
        keys.map(|axis| axis.values.len()).product()
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

    /// A chart of a measure; `None` without a curve.
    fn chart(
        &self,
        measure: &Measure,
        title: String,
        abscissa: &str,
        series: Vec<Series>,
    ) -> Option<Chart> {
        let ordinate = measure.label(measure.quantity, self.request.is_si());
        let chart = (!series.is_empty()).then(|| Chart::of(title, abscissa, ordinate, series))?;
        Some(match measure.log {
            true => chart.logarithmic(),
            false => chart,
        })
    }

    /// Least and largest force that comes through, or medians of ensembles, and of how many members it is known.
    fn answer(&self) -> String {
        let (points, is_ensemble) = self.points();
        let unit = if self.request.is_si() { " N" } else { "" };
        let keys: Vec<&str> = self.request.axes().iter().map(|axis| &*axis.key).collect();
        let forces = points.iter();
        let forces = forces.filter_map(|point| Some((point, point.of("peak_force_last")?)));
        let mut forces: Vec<(&Ensemble, &Spread)> = forces.collect();
        forces.sort_by(|a, b| a.1.median.total_cmp(&b.1.median));
        let at = |(point, spread): &(&Ensemble, &Spread)| {
            let mut words_of = format!("{}{unit}", number(spread.median));
            if is_ensemble {
                let [low, high] = [spread.p05, spread.p95].map(number);
                words_of += &format!(" ({low} to {high} in 90 % of {} members)", spread.members);
            }
            match &*words(&keys, point.values.iter().map(String::as_str)) {
                "" => words_of,
                named => format!("{words_of} at {named}"),
            }
        };
        let count = self.count();
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
        let is_si = self.request.is_si();
        let keys = self.request.axes().into_iter().map(|axis| &*axis.key);
        let head = ["measure", "members", "5 %", "median", "95 %", "spread"];
        let rows = ensembles.iter().flat_map(|ensemble| {
            MEASURES.iter().filter_map(move |measure| {
                let spread = ensemble.of(measure.column)?;
                let numbers = [spread.p05, spread.median, spread.p95, spread.deviation];
                let values = ensemble.values.iter().map(|value| short(value));
                let name = measure.label(measure.name, is_si);
                let row = values.chain([name, spread.members.to_string()]);
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

    /// The values of all members, in order.
    fn in_order(&self, measure: &Measure) -> Option<Chart> {
        let members = self.members();
        let values = members
            .iter()
            .filter_map(|member| Some(member.of(measure.column)?.median));
        let values = sorted(values);
        let share = |i: usize| 100.0 * (i as f64 + 0.5) / values.len() as f64;
        let points: Vec<(f64, f64)> = (0..values.len()).map(|i| (share(i), values[i])).collect();
        let series = (!points.is_empty()).then(|| Series::line("", 0, points));
        let title = format!("{}, in order", measure.title);
        self.chart(
            measure,
            title,
            "share of members (%)",
            series.into_iter().collect(),
        )
    }

    /// Why members have no force, and what to state.
    fn missing(&self) -> Option<String> {
        let needing = |needs: Needs| {
            let done = self.outcomes.values().filter_map(Outcome::done);
            done.filter(|measures| measures.peak_force_last_needs == Some(needs))
                .count()
        };
        let reasons = [
            (
                needing(Needs::EndTime),
                "the run ends before it; a later `--end-time` mends that",
            ),
            (
                needing(Needs::Samples),
                "samples are too far apart; more `--samples` mend that",
            ),
            (
                needing(Needs::Tolerance),
                "its error is above 1 %; a smaller `--tolerance` may mend that",
            ),
            (self.count() - self.outcomes.len(), "it is not computed yet"),
        ];
        let reasons = reasons.iter().filter(|(count, _)| *count > 0);
        let words: Vec<String> = reasons
            .map(|(count, why)| format!("in {count} {why}"))
            .collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    /// The measures of the members, in rows.
    fn table(&self) -> Table {
        let members = self.members();
        let is_si = self.request.is_si();
        let measured = MEASURES.iter();
        let measured = measured.map(|measure| measure.label(measure.name, is_si));
        let keys = self.request.vary.iter().map(|axis| &*axis.key);
        let rows = members.iter().take(ROWS).map(|member| {
            let values = member.values.iter().map(|value| short(value));
            let measures = MEASURES.iter().map(|measure| {
                let value = member.of(measure.column).map(|spread| spread.median);
                value.map_or("-".into(), number)
            });
            values.chain(measures).collect()
        });
        let title = match members.len() > ROWS {
            true => format!(
                "The first {ROWS} members; table.csv has all {}",
                members.len()
            ),
            false => "Members".into(),
        };
        let measured: Vec<String> = measured.collect();
        let head: Vec<&str> = keys.chain(measured.iter().map(String::as_str)).collect();
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

/// A chart whose abscissa is logarithmic where it spans decades.
pub(crate) fn wide(chart: Chart) -> Chart {
    Chart {
        log_x: chart.x.start > 0.0 && chart.x.end > WIDE * chart.x.start,
        ..chart
    }
}

/// The key along the abscissa: its index, and its name with its unit.
struct Abscissa {
    index: usize,
    label: String,
}

impl Abscissa {
    /// The numeric key with most values; `None` if none has two.
    fn of(axes: &[&SweptKey]) -> Option<Abscissa> {
        let numeric = axes.iter().enumerate().filter_map(|(index, axis)| {
            let (_, unit) = quantity(axis.values.first()?)?;
            let alike = |text: &String| quantity(text).is_some_and(|(_, other)| other == unit);
            let count = axis.values.len();
            (count > 1 && axis.values.iter().all(alike)).then_some((index, count, unit))
        });
        let most = |(index, count, _): &(usize, usize, &str)| (*count, std::cmp::Reverse(*index));
        let (index, _, unit) = numeric.max_by_key(most)?;
        Some(Abscissa {
            index,
            label: label(&axes[index].key.replace('_', " "), unit),
        })
    }
}
