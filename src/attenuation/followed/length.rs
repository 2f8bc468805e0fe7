//! The pulse against the number of bodies before it.

use serde_json::json;

use super::super::curve::compared;
use super::super::{
    Attenuation, AttenuationCurve, AttenuationLaw, Computed, ContactKind, CurveRow, Fits, Measured,
    Reach, Sense, Stop, StopCause,
};
use super::{FORCE, field_charts, laid_over, points, records};
use crate::chain::scene::Units;
use crate::sheet::{Cell, Chart, Look, Series, Sheet, Table, name_of, number, percent, with_unit};
use crate::unit::label;

/// What stands before the numbers of a pulse.
const ROW: [(&str, &str); 8] = [
    ("chain", "/chain"),
    ("sense", "/sense"),
    ("bodies", "/bodies"),
    ("contact_kind", "/kind"),
    ("relative_force", "/relative_force"),
    ("relative_velocity", "/relative_velocity"),
    ("relative_energy", "/relative_energy"),
    ("high_band_share", "/high_share"),
];

const DEFINITIONS: &str = "\
force: The largest force of the pulse, over that in the same place of the homogeneous chain.
one long chain, wall: At the contacts of one chain that the pulse runs along; or on the wall behind chains of every length.
energy: Passed through the contact by the pulse, over that of the homogeneous chain.
high: Share of the energy passed that lies above the band edge.
width: Of the force at half of its largest value.
law: Fitted to the forces in the compared contacts, with 95 % intervals: a level, an exponential, a power law, or an \
exponential that settles.";

impl Attenuation {
    pub(super) fn describe(&self) -> Sheet<'_> {
        let mut sheet = Sheet {
            version: 2,
            about: format!(
                "The pulse of a struck chain followed over {} bodies, {} contacts compared",
                self.length,
                name_of(&self.kind)
            ),
            answer: self.answer(),
            note: "Dashed: the law that fits best.".into(),
            records: self.records(),
            tables: vec![self.last_points()],
            ..Sheet::of("attenuation", "Attenuation against length", DEFINITIONS)
        };
        for curve in &self.curves {
            let name = format!("{}, {}", curve.name, curve.sense.name());
            if let Some(stop) = &curve.stop {
                sheet.fact(&name, stop_words(stop));
            }
            if let (Some(reach), Some(target)) = (&curve.reach, self.target) {
                sheet.fact(&name, reach_words(reach, target));
            }
            if let Some(fits) = &curve.fits {
                sheet.detail(&name, law_words(fits));
            }
        }
        sheet.numbers(json!(self));
        sheet
    }

    /// What the first chain that attenuates lets through, or the length that reaches the target.
    fn answer(&self) -> String {
        let curves = &self.curves;
        if let Some(target) = self.target {
            let shortest = |reach: &Reach| match reach {
                Reach::Within { bodies } => (0, *bodies),
                Reach::Beyond { bodies } => (1, *bodies),
                Reach::Never { .. } => (2, 0),
            };
            let all = curves.iter();
            let all = all.filter_map(|curve| Some((curve, curve.reach.as_ref()?)));
            if let Some((curve, reach)) = all.min_by_key(|(_, reach)| shortest(reach)) {
                let what = reach_words(reach, target);
                return format!("{} ({}): {what}", curve.name, curve.sense.name());
            }
        }
        let forces = curves.iter().filter_map(|curve| {
            let known = curve.rows.iter().rev();
            let (bodies, force) = known
                .filter_map(|row| Some((row.bodies, row.relative_force?)))
                .next()?;
            Some((curve, bodies, force))
        });
        match forces.min_by(|a, b| a.2.total_cmp(&b.2)) {
            Some((curve, bodies, force)) => {
                let (name, sense, force) = (&curve.name, curve.sense.name(), percent(force));
                let what = format!("{force} of the force of the homogeneous chain");
                format!("{name} has {what} after {bodies} bodies ({sense})")
            }
            None => "no chain has a pulse".into(),
        }
    }

    /// Each curve at its last point.
    fn last_points(&self) -> Table {
        fn last(curve: &AttenuationCurve, value: Value) -> Option<String> {
            Some(format!("{:.4}", value(curve.rows.last()?)?))
        }
        fn width(curve: &AttenuationCurve) -> Option<String> {
            let unit = if curve.units == Units::Si { "s" } else { "" };
            Some(with_unit(curve.rows.last()?.pulse.width.value, unit))
        }
        let columns: [(&str, Cell<AttenuationCurve>); 8] = [
            ("chain", |curve| Some(curve.name.clone())),
            ("sense", |curve| Some(curve.sense.name().into())),
            ("ratio", |curve| {
                Some(format!("{:.4}", curve.stiffness_ratio))
            }),
            ("bodies", |curve| {
                Some(curve.rows.last()?.bodies.to_string())
            }),
            ("force", |curve| last(curve, |row| row.relative_force)),
            ("energy", |curve| last(curve, |row| row.relative_energy)),
            ("width", width),
            ("high", |curve| last(curve, |row| row.high_share)),
        ];
        Table::of_columns("Curves at their last point", &self.curves, &columns).printed()
    }

    /// One row for each point of a curve.
    fn records(&self) -> Table {
        let rows = self.curves.iter().flat_map(|curve| {
            curve.rows.iter().map(|row| {
                let mut object = json!(row);
                object["chain"] = json!(curve.name);
                object["sense"] = json!(curve.sense);
                object
            })
        });
        records(&ROW, rows)
    }

    /// Of the first curve; forces in the contacts that are fitted.
    pub(super) fn computed_points(&self) -> Option<Computed> {
        let rows = &self.curves.first()?.rows;
        let over = |value: Value| points(rows, |row| Some((row.bodies as f64, value(row)?)));
        Some(Computed {
            forces: compared(self.kind, rows),
            velocities: over(|row| Some(row.pulse.peak_velocity.value)),
            arrivals: over(|row| Some(row.pulse.velocity_rise_time?.value)),
        })
    }

    /// Force, energy, share of the high band and width against length, for every chain: forces in the contacts that are
    /// compared, with the chosen laws dashed.
    pub(super) fn charts(&self, measured: &Measured) -> Vec<Chart> {
        let bodies = "bodies before the contact";
        let mut charts = Vec::new();
        for sense in [Sense::Chain, Sense::Wall] {
            let mut series = self.series(sense, |row| row.relative_force);
            if series.is_empty() {
                continue;
            }
            let curves = self.curves.iter().filter(|c| c.sense == sense);
            for (i, curve) in curves.enumerate() {
                let Some(fits) = &curve.fits else { continue };
                let points = series[i].points.iter().filter(|p| p.0 > 0.0);
                let law = points.map(|p| (p.0, fits.chosen().at(p.0))).collect();
                series.push(Series::line("", i, law).with(Look::Dashed));
            }
            series.extend(laid_over(&measured.forces));
            let kind = name_of(&self.kind);
            let title = match sense {
                Sense::Chain => format!("peak force in one long chain, {kind} contacts"),
                Sense::Wall => "peak force on the wall".into(),
            };
            charts.push(Chart::of(title, bodies, FORCE, series));
        }
        let is_si = self.curves.first().map(|c| c.units) == Some(Units::Si);
        let mut along = |title: &str, label: &str, value: Value| {
            let series = self.series(Sense::Chain, value);
            if series.iter().any(|s| !s.points.is_empty()) {
                charts.push(Chart::of(title, bodies, label, series));
            }
        };
        let passed = "energy passed in one long chain";
        let energy = "energy / that of the homogeneous chain";
        along(passed, energy, |row| row.relative_energy);
        let above = "share of the energy passed above the band edge";
        along(above, "share", |row| row.high_share);
        let width = label("width", if is_si { "s" } else { "" });
        let half = "width of the pulse at half its peak";
        along(half, &width, |row| Some(row.pulse.width.value));
        if let (Some(first), Some(computed)) = (self.curves.first(), self.computed_points()) {
            charts.extend(field_charts("site", first.units, &computed, measured));
        }
        charts
    }

    /// A quantity against length, of every chain in this sense.
    fn series(&self, sense: Sense, value: Value) -> Vec<Series> {
        let like = |row: &&CurveRow| row.kind == self.kind || row.kind == ContactKind::Other;
        let curves = self.curves.iter().filter(|c| c.sense == sense);
        let series = curves.enumerate().map(|(i, curve)| {
            let rows = curve.rows.iter().filter(like);
            let points = rows.filter_map(|row| Some((row.bodies as f64, value(row)?)));
            Series::line(&curve.name, i, points.collect())
        });
        series.collect()
    }
}

/// The drawn quantity of a row.
type Value = fn(&CurveRow) -> Option<f64>;

/// Where and why a curve ends.
fn stop_words(stop: &Stop) -> String {
    let why = match stop.cause {
        StopCause::Reflection => "a reflection would enter there before the pulse is whole",
        StopCause::Faded => "the pulse has faded before the end of the chain",
        StopCause::Failed => "its run failed",
    };
    format!("stops at {} bodies: {why}", stop.bodies)
}

/// The chosen law with its parameters and their intervals.
fn law_words(fits: &Fits) -> String {
    let chosen = fits.chosen();
    let parameters = chosen.parameters.iter().map(|p| {
        let (value, low, high) = (number(p.value), number(p.low), number(p.high));
        format!("{} = {value} ({low} to {high})", p.name)
    });
    let parameters: Vec<String> = parameters.collect();
    format!("{}: {}", law_name(chosen.law), parameters.join(", "))
}

fn law_name(law: AttenuationLaw) -> &'static str {
    match law {
        AttenuationLaw::Level => "c",
        AttenuationLaw::Exponential => "a exp(-r n)",
        AttenuationLaw::PowerLaw => "a n^-p",
        AttenuationLaw::Plateau => "c + a exp(-r n)",
    }
}

/// The length that reaches a target, or why there is none.
fn reach_words(reach: &Reach, target: f64) -> String {
    match reach {
        Reach::Within { bodies } => format!("at {target} or below from {bodies} bodies on"),
        Reach::Beyond { bodies } => format!("{target} is not reached within {bodies} bodies"),
        Reach::Never { law, settles_at } => format!(
            "not at {target} by the law so far: {} settles at {}",
            law_name(*law),
            number(*settles_at)
        ),
    }
}
