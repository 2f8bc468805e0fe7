//! What a sweep found: the least and the largest force that comes through, and all measures against one of the keys.

use serde_json::json;

use super::axis::quantity;
use super::ensemble::SEED;
use super::{Ensemble, Measures, Needs, Outcome, Outcomes, Request, SweptKey};
use crate::sheet::{Chart, Describe, PlotRow, Series, Sheet, Table, number};
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
    of: fn(&Measures) -> Option<f64>,
}

const MEASURES: [Measure; 6] = [
    Measure {
        title: "Largest force at the last contact",
        name: "force, last contact",
        column: "peak_force_last",
        quantity: "force",
        unit: "N",
        log: false,
        of: |m| m.peak_force_last,
    },
    Measure {
        title: "When the force at the last contact is largest",
        name: "its time",
        column: "peak_force_last_time",
        quantity: "time",
        unit: "s",
        log: false,
        of: |m| m.peak_force_last_time,
    },
    Measure {
        title: "Largest force at the first contact",
        name: "force, first contact",
        column: "peak_force_first",
        quantity: "force",
        unit: "N",
        log: false,
        of: |m| m.peak_force_first,
    },
    Measure {
        title: "Energy passed through the last contact between sites",
        name: "energy passed",
        column: "energy_passed_last",
        quantity: "energy",
        unit: "J",
        log: false,
        of: |m| m.energy_passed_last,
    },
    Measure {
        title: "Energy lost",
        name: "energy lost",
        column: "energy_lost",
        quantity: "energy",
        unit: "J",
        log: false,
        of: |m| m.energy_lost.filter(|lost| *lost != 0.0),
    },
    Measure {
        title: "Estimated error of the velocities",
        name: "error",
        column: "error",
        quantity: "error",
        unit: "m/s",
        log: true,
        of: |m| m.error,
    },
];

const DEFINITIONS: [[&str; 2]; 1] = [[
    "Ensemble",
    "Members that differ in the seed alone. 5 to 95 %: what nine tenths of them lie between, by order statistics; spread: \
     their standard deviation. Where a chain amplifies rounding, no digit of a member means anything, but these do.",
]];

/// A member's values of all keys as text, and its measures.
struct Member<'a> {
    values: Vec<&'a str>,
    measures: &'a Measures,
}

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
            answer: match ensembles.as_slice() {
                [] => self.answer(),
                ensembles => self.answer_of(ensembles),
            },
            tables: vec![self.table()],
            ..Sheet::default()
        };
        if let Some(why) = self.missing() {
            sheet.fact("not known", why);
        }
        for (&index, outcome) in &self.outcomes {
            if let Outcome::Failed(why) = outcome {
                let values = self.request.values(index);
                sheet.warn(format!("{} failed: {why}", self.named(&values, None)), "");
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
            sheet.definitions = DEFINITIONS.to_vec();
        }
        sheet
    }

    /// A chart for each measure that some member has.
    fn pictures(&self) -> Vec<PlotRow> {
        if self.request.seed().is_some() {
            return self.bands();
        }
        let Some(along) = Abscissa::of(&self.request) else {
            return Vec::new();
        };
        let members = self.members();
        // Members that differ in nothing but the abscissa make a curve.
        let mut curves: Vec<(String, Vec<&Member>)> = Vec::new();
        for member in &members {
            let name = self.named(&member.values, Some(along.index));
            match curves.iter_mut().find(|(known, _)| *known == name) {
                Some((_, of)) => of.push(member),
                None => curves.push((name, vec![member])),
            }
        }
        let every = curves.len().div_ceil(CURVES).max(1);
        let charts = MEASURES.iter().filter_map(|measure| {
            let shown = curves.iter().step_by(every).enumerate();
            let series = shown.filter_map(|(n, (name, members))| {
                let points = members.iter();
                // The line breaks where a member has no value.
                let value = |member: &Member| (measure.of)(member.measures).unwrap_or(f64::NAN);
                let points = points.filter_map(|member| Some((along.at(member)?, value(member))));
                let mut points: Vec<(f64, f64)> = points.collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let is_known = points.iter().any(|(_, value)| value.is_finite());
                is_known.then(|| Series::line(name, n, points))
            });
            let title = match every {
                1 => measure.title.to_owned(),
                _ => format!("{}, one of every {every} combinations", measure.title),
            };
            self.chart((measure, title), &along, series.collect())
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
fn words<'k>(pairs: impl Iterator<Item = (&'k str, &'k str)>) -> String {
    let words = pairs.map(|(key, value)| format!("{} {}", key.replace('_', " "), short(value)));
    words.collect::<Vec<_>>().join(", ")
}

impl Swept {
    /// Members in all.
    fn count(&self) -> usize {
        let keys = self.request.vary.iter();
        keys.map(|axis| axis.values.len()).product()
    }

    fn members(&self) -> Vec<Member<'_>> {
        let done = self.outcomes.iter().filter_map(|(&index, outcome)| {
            let Outcome::Done(measures) = outcome else {
                return None;
            };
            Some(Member {
                values: self.request.values(index),
                measures,
            })
        });
        done.collect()
    }

    /// The members' values, but for those of one key.
    fn named(&self, values: &[&str], but: Option<usize>) -> String {
        let named = self.request.vary.iter().zip(values).enumerate();
        let named = named.filter(|(n, _)| Some(*n) != but);
        words(named.map(|(_, (axis, value))| (&*axis.key, *value)))
    }

    /// A measure against a key; `None` without a curve.
    fn chart(
        &self,
        (measure, title): (&Measure, String),
        along: &Abscissa,
        series: Vec<Series>,
    ) -> Option<Chart> {
        let ordinate = measure.label(measure.quantity, self.request.is_si());
        (!series.is_empty()).then(|| {
            let chart = Chart {
                log_x: along.is_wide(),
                ..Chart::of(title, &along.label, ordinate, series)
            };
            if measure.log {
                chart.logarithmic()
            } else {
                chart
            }
        })
    }

    /// The keys of ensembles.
    fn keys(&self) -> impl Iterator<Item = &SweptKey> {
        self.request.vary.iter().filter(|axis| axis.key != SEED)
    }

    /// Least and largest force that comes through, and of how many members it is known.
    fn answer(&self) -> String {
        let (count, known) = (self.count(), self.outcomes.len());
        let members = self.members();
        let unit = if self.request.is_si() { " N" } else { "" };
        let forces = members.iter();
        let mut forces: Vec<(&Member, f64)> = forces
            .filter_map(|member| Some((member, member.measures.peak_force_last?)))
            .collect();
        forces.sort_by(|a, b| a.1.total_cmp(&b.1));
        let of = match count - forces.len() {
            0 => String::new(),
            _ => format!(", known in {} of {count} members", forces.len()),
        };
        let at = |(member, force): &(&Member, f64)| {
            format!(
                "{}{unit} at {}",
                number(*force),
                self.named(&member.values, None)
            )
        };
        match forces.as_slice() {
            [] if known == 0 => format!("none of {count} members has a value yet"),
            [] => {
                format!("the largest force at the last contact is known in none of {count} members")
            }
            [one] => format!("force at the last contact {}{of}", at(one)),
            [least, .., most] => format!(
                "force at the last contact from {} to {}{of}",
                at(least),
                at(most)
            ),
        }
    }

    /// How the measures of ensembles spread.
    fn table_of(&self, ensembles: &[Ensemble]) -> Table {
        let is_si = self.request.is_si();
        let keys = self.keys().map(|axis| axis.key.clone());
        let head = ["measure", "members", "5 %", "median", "95 %", "spread"].map(str::to_owned);
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
        Table {
            title: format!("Ensembles; {} has every column", super::ENSEMBLES),
            head: keys.chain(head).collect(),
            rows: rows.take(ROWS).collect(),
            is_fact: ensembles.len() == 1,
        }
    }

    /// Median and band of the force that comes through: of one ensemble, or of those of least and largest median.
    fn answer_of(&self, ensembles: &[Ensemble]) -> String {
        let unit = if self.request.is_si() { " N" } else { "" };
        let forces = ensembles.iter();
        let mut forces: Vec<_> = forces
            .filter_map(|ensemble| Some((ensemble, ensemble.of("peak_force_last")?)))
            .collect();
        forces.sort_by(|a, b| a.1.median.total_cmp(&b.1.median));
        let at = |(ensemble, spread): &(&Ensemble, &super::Spread)| {
            let values = ensemble.values.iter().map(String::as_str);
            let place = match &*words(self.keys().map(|axis| &*axis.key).zip(values)) {
                "" => String::new(),
                named => format!(" at {named}"),
            };
            format!(
                "{}{unit} ({} to {} in 90 % of {} members){place}",
                number(spread.median),
                number(spread.p05),
                number(spread.p95),
                spread.members
            )
        };
        match forces.as_slice() {
            [] => "the largest force at the last contact is known in no member".into(),
            [one] => format!("median force at the last contact {}", at(one)),
            [least, .., most] => format!(
                "median force at the last contact from {} to {}",
                at(least),
                at(most)
            ),
        }
    }

    /// Medians with their bands against a key, or, of the seed alone, all values in order.
    fn bands(&self) -> Vec<PlotRow> {
        let ensembles = self.request.ensembles(&self.outcomes);
        let keys: Vec<&SweptKey> = self.keys().collect();
        let along = Abscissa::of(&self.request).and_then(|along| {
            let key = &self.request.vary[along.index].key;
            let place = keys.iter().position(|axis| axis.key == *key)?;
            Some((along, place))
        });
        let charts = MEASURES.iter().filter_map(|measure| {
            let Some((along, place)) = &along else {
                return self.in_order(measure);
            };
            let mut curves: Vec<(String, Curve)> = Vec::new();
            for ensemble in &ensembles {
                let x = quantity(&ensemble.values[*place]).map(|(x, _)| x);
                let Some((x, spread)) = x.zip(ensemble.of(measure.column)) else {
                    continue;
                };
                let rest = keys.iter().zip(&ensemble.values).enumerate();
                let rest = rest.filter(|(i, _)| i != place);
                let name = words(rest.map(|(_, (axis, value))| (&*axis.key, &**value)));
                let point = ((x, spread.median), (spread.p05, spread.p95));
                match curves.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, points)) => points.push(point),
                    None => curves.push((name, vec![point])),
                }
            }
            let series = curves.into_iter().take(CURVES).enumerate();
            let series = series.map(|(n, (name, mut points))| {
                points.sort_by(|a, b| a.0.0.total_cmp(&b.0.0));
                let (points, ends) = points.into_iter().unzip();
                let line = if name.is_empty() { "median" } else { &name };
                Series::line(line, n, points).with_band("5 to 95 %", ends)
            });
            self.chart((measure, measure.title.into()), along, series.collect())
        });
        PlotRow::grid(1, charts)
    }

    /// The values of all members, in order.
    fn in_order(&self, measure: &Measure) -> Option<Chart> {
        let members = self.members();
        let values = members.iter().filter_map(|m| (measure.of)(m.measures));
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let share = |i: usize| 100.0 * (i as f64 + 0.5) / values.len() as f64;
        let points: Vec<(f64, f64)> = (0..values.len()).map(|i| (share(i), values[i])).collect();
        let ordinate = measure.label(measure.quantity, self.request.is_si());
        (!points.is_empty()).then(|| {
            Chart::of(
                format!("{}, in order", measure.title),
                "share of members (%)",
                ordinate,
                vec![Series::line("", 0, points)],
            )
        })
    }

    /// Why members have no force, and what to state.
    fn missing(&self) -> Option<String> {
        let members = self.members();
        let needing = |needs: Needs| {
            let needing = |member: &&Member| member.measures.peak_force_last_needs == Some(needs);
            members.iter().filter(needing).count()
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
        let keys = self.request.vary.iter().map(|axis| axis.key.clone());
        let optional = |value: Option<f64>| value.map_or("-".into(), number);
        let rows = members.iter().take(ROWS).map(|member| {
            let values = member.values.iter().map(|value| short(value));
            let measures = MEASURES.iter();
            let measures = measures.map(|measure| optional((measure.of)(member.measures)));
            values.chain(measures).collect()
        });
        Table {
            title: match members.len() > ROWS {
                true => format!(
                    "The first {ROWS} members; table.csv has all {}",
                    members.len()
                ),
                false => "Members".into(),
            },
            head: keys.chain(measured).collect(),
            rows: rows.collect(),
            is_fact: false,
        }
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

/// The key along the abscissa: its index, its values as numbers, and its name with their unit.
struct Abscissa<'a> {
    index: usize,
    values: &'a [String],
    label: String,
}

impl<'a> Abscissa<'a> {
    /// The numeric key with most values; `None` if none has two.
    fn of(request: &'a Request) -> Option<Abscissa<'a>> {
        let axes = request.vary.iter().enumerate();
        let numeric = axes.filter_map(|(index, axis)| {
            let (_, unit) = quantity(axis.values.first()?)?;
            let alike = |text: &String| quantity(text).is_some_and(|(_, other)| other == unit);
            (axis.values.len() > 1 && axis.values.iter().all(alike)).then_some((index, axis, unit))
        });
        // The seed says nothing about an ensemble.
        let most = |(index, axis, _): &(usize, &SweptKey, &str)| {
            (
                axis.key != SEED,
                axis.values.len(),
                std::cmp::Reverse(*index),
            )
        };
        let (index, axis, unit) = numeric.max_by_key(most)?;
        Some(Abscissa {
            index,
            values: &axis.values,
            label: label(&axis.key.replace('_', " "), unit),
        })
    }

    fn at(&self, member: &Member) -> Option<f64> {
        Some(quantity(member.values[self.index])?.0)
    }

    fn is_wide(&self) -> bool {
        let values = self.values.iter();
        let values = values.filter_map(|text| Some(quantity(text)?.0));
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        low > 0.0 && high > WIDE * low
    }
}
