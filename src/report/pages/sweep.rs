//! The page of a sweep: its measures against one of the varied keys.

use maud::html as markup;

use crate::plot::Style;
use crate::report::page::{self, Chart, CurveGroup, Page, Picture, Series, number};
use crate::sweep::{Measures, Outcome, Outcomes, Request, SweptKey, quantity};

/// Curves in a chart at most.
const CURVES: usize = 12;
/// Rows of the table on the page at most.
const ROWS: usize = 200;

/// A measure of a member's run.
struct Measure {
    title: &'static str,
    quantity: &'static str,
    /// Its unit in a scene of SI units.
    unit: &'static str,
    log: bool,
    of: fn(&Measures) -> Option<f64>,
}

const MEASURES: [Measure; 6] = [
    Measure {
        title: "Largest force at the last contact",
        quantity: "force",
        unit: "N",
        log: false,
        of: |m| m.peak_force_last,
    },
    Measure {
        title: "When the force at the last contact is largest",
        quantity: "time",
        unit: "s",
        log: false,
        of: |m| m.peak_force_last_time,
    },
    Measure {
        title: "Largest force at the first contact",
        quantity: "force",
        unit: "N",
        log: false,
        of: |m| m.peak_force_first,
    },
    Measure {
        title: "Energy passed through the last contact between sites",
        quantity: "energy",
        unit: "J",
        log: false,
        of: |m| m.energy_passed_last,
    },
    Measure {
        title: "Energy lost",
        quantity: "energy",
        unit: "J",
        log: false,
        of: |m| m.energy_lost.filter(|lost| *lost != 0.0),
    },
    Measure {
        title: "Estimated error of the velocities",
        quantity: "error",
        unit: "m/s",
        log: true,
        of: |m| m.error,
    },
];

/// A member's values of all keys as text, and its measures.
struct Member<'a> {
    values: Vec<&'a str>,
    measures: &'a Measures,
}

/// The page of a sweep whose members are known.
pub fn sweep_html(request: &Request, outcomes: &Outcomes) -> String {
    let si = request.is_si();
    let (mut members, mut failed) = (Vec::new(), Vec::new());
    for (&index, outcome) in outcomes {
        let values = request.values(index);
        match outcome {
            Outcome::Done(measures) => members.push(Member { values, measures }),
            Outcome::Failed(why) => {
                failed.push((
                    format!("{} failed: {why}", named(request, &values, None)),
                    None,
                ));
            }
        }
    }
    let keys: Vec<&str> = request.vary.iter().map(|axis| &*axis.key).collect();
    let force = |member: &&Member| member.measures.peak_force_last;
    let with_force = members.iter().filter(|member| force(member).is_some());
    let by_force = |a: &&Member, b: &&Member| {
        let (a, b) = (force(a).unwrap_or(0.0), force(b).unwrap_or(0.0));
        a.total_cmp(&b)
    };
    let told = |word: &str, member: Option<&Member>| {
        let member = member?;
        let at = named(request, &member.values, None);
        let force = with_unit_behind(number(force(&member)?), si, "N");
        Some((word.to_owned(), format!("{force} at {at}")))
    };
    let extremes = [
        told("least", with_force.clone().min_by(by_force)),
        told("largest", with_force.max_by(by_force)),
    ];
    let page = Page {
        title: format!("Sweep over {}", keys.join(", ").replace('_', " ")),
        sentence: format!(
            "{} chains of one scene; all numbers are in table.csv",
            outcomes.len()
        ),
        answers: page::answers(
            "Which chain passes least force to its last contact, which most?",
            extremes.into_iter().flatten().collect(),
        ),
        warnings: page::warnings(&failed),
        rows: pictures(request, si, &members),
        rest: markup! { (page::numbers(table(request, si, &members))) },
        style: Style::default(),
    };
    page.html()
}

/// The members' values, but for those of one key.
fn named(request: &Request, values: &[&str], but: Option<usize>) -> String {
    let named = request.vary.iter().zip(values).enumerate();
    let named = named.filter(|(n, _)| Some(*n) != but);
    let words =
        named.map(|(_, (axis, value))| format!("{} {}", axis.key.replace('_', " "), short(value)));
    words.collect::<Vec<_>>().join(", ")
}

/// A value with the digits that a reader needs.
fn short(text: &str) -> String {
    match quantity(text) {
        Some((value, "")) => number(value),
        Some((value, unit)) => format!("{} {unit}", number(value)),
        None => text.to_owned(),
    }
}

/// The key along the abscissa: its index, its values as numbers, and their unit.
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
        let most = |(index, axis, _): &(usize, &SweptKey, &str)| {
            (axis.values.len(), std::cmp::Reverse(*index))
        };
        let (index, axis, unit) = numeric.max_by_key(most)?;
        Some(Abscissa {
            index,
            values: &axis.values,
            label: with_unit(&axis.key.replace('_', " "), unit),
        })
    }

    fn at(&self, member: &Member) -> Option<f64> {
        Some(quantity(member.values[self.index])?.0)
    }

    fn is_wide(&self) -> bool {
        let values = self
            .values
            .iter()
            .filter_map(|text| Some(quantity(text)?.0));
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        low > 0.0 && high > WIDE * low
    }
}

fn with_unit(name: &str, unit: &str) -> String {
    match unit {
        "" => name.to_owned(),
        unit => format!("{name} ({unit})"),
    }
}

/// A number of a scene, with its unit if the scene is in SI.
fn with_unit_behind(number: String, si: bool, unit: &str) -> String {
    match si {
        true => format!("{number} {unit}"),
        false => number,
    }
}

/// A chart for each measure that some member has.
fn pictures(request: &Request, si: bool, members: &[Member]) -> Vec<Vec<Picture>> {
    let Some(along) = Abscissa::of(request) else {
        return Vec::new();
    };
    // Members that differ in nothing but the abscissa make a curve.
    let mut curves: Vec<(String, Vec<&Member>)> = Vec::new();
    for member in members {
        let name = named(request, &member.values, Some(along.index));
        match curves.iter_mut().find(|(known, _)| *known == name) {
            Some((_, of)) => of.push(member),
            None => curves.push((name, vec![member])),
        }
    }
    let every = curves.len().div_ceil(CURVES).max(1);
    let caption = match every {
        1 => String::new(),
        _ => format!(
            "One of every {every} of the {} combinations of the other keys.",
            curves.len()
        ),
    };
    let charts = MEASURES.iter().enumerate().filter_map(|(n, measure)| {
        let shown = curves.iter().step_by(every);
        let series = shown.filter_map(|(name, members)| {
            let mut points: Vec<(f64, f64)> = members
                .iter()
                .filter_map(|member| Some((along.at(member)?, (measure.of)(member.measures)?)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (!points.is_empty()).then(|| Series::points(name, &points))
        });
        let unit = if si { measure.unit } else { "" };
        let chart = Chart::new(with_unit(measure.quantity, unit), series.collect());
        let chart = if measure.log { chart.log() } else { chart };
        chart.has_values().then(|| {
            let heading = (&*format!("measure-{}", n + 1), measure.title);
            let axis = (along.label.as_str(), None);
            let group = CurveGroup::new(heading, caption.as_str(), axis, &[], vec![chart]);
            vec![group.on_log_axis(along.is_wide()).into()]
        })
    });
    charts.collect()
}

/// Ends of an axis of this ratio make it logarithmic.
const WIDE: f64 = 30.0;

/// The measures of the members, in rows.
fn table(request: &Request, si: bool, members: &[Member]) -> maud::Markup {
    let measured = [
        "force, last contact",
        "its time",
        "force, first contact",
        "energy passed",
        "energy lost",
        "error",
    ];
    let unit = |measure: &Measure| if si { measure.unit } else { "" };
    let measured = measured.iter().zip(&MEASURES);
    let measured = measured.map(|(name, measure)| with_unit(name, unit(measure)));
    let keys = request.vary.iter().map(|axis| axis.key.clone());
    let head: Vec<String> = keys.chain(measured).collect();
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let optional = |value: Option<f64>| value.map_or("–".into(), number);
    let rows: Vec<Vec<String>> = members
        .iter()
        .take(ROWS)
        .map(|member| {
            let values = member.values.iter().map(|value| short(value));
            let measures = MEASURES
                .iter()
                .map(|measure| optional((measure.of)(member.measures)));
            values.chain(measures).collect()
        })
        .collect();
    let title = match members.len() > ROWS {
        true => format!(
            "The first {ROWS} members; table.csv has all {}",
            members.len()
        ),
        false => "Members".into(),
    };
    page::grid(&title, &head, &rows)
}
