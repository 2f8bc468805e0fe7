//! Attenuation against length and transmission against a key, as charts.

use super::Figure;
use super::layout::FigureLayout;
use super::style::Style;
use crate::attenuation::{
    Attenuation, ContactKind, CurveRow, MeasuredPoint, Pulse, Sense, Transmission,
};
use crate::chain::scene::Units;
use crate::sheet::Mark;
use crate::sheet::{Chart, Look, Series};
use crate::unit::label;

/// Ends of an axis of a ratio above which it is logarithmic.
const WIDE: f64 = 30.0;

/// The drawn quantity of a row.
type Value<'a> = &'a dyn Fn(&CurveRow) -> Option<f64>;

/// Measured points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Overlay<'a> {
    Nothing,
    /// Relative forces over bodies.
    Forces(&'a [MeasuredPoint]),
    /// Of a field: largest velocities, and when they are half of that before it.
    Field([&'a [MeasuredPoint]; 2]),
}

/// Force, energy, share of the high band and width against length, for every chain: forces in the
/// contacts that are compared, with the chosen laws dashed.
pub fn attenuation(attenuation: &Attenuation, overlay: Overlay, style: &Style) -> Figure {
    let charts = attenuation_charts(attenuation, overlay);
    FigureLayout::grid("Attenuation against length", 2, charts).figure("attenuation", style)
}

pub(crate) fn attenuation_charts(attenuation: &Attenuation, overlay: Overlay) -> Vec<Chart> {
    let kind = attenuation.kind;
    let like = |row: &&CurveRow| row.kind == kind || row.kind == ContactKind::Other;
    let si = attenuation.curves.first().map(|c| c.units) == Some(Units::Si);
    let of = |sense: Sense, value: Value| -> Vec<Series> {
        let curves = attenuation.curves.iter().filter(|c| c.sense == sense);
        curves
            .enumerate()
            .map(|(i, curve)| {
                let rows = curve.rows.iter().filter(like);
                let points = rows.filter_map(|row| Some((row.bodies as f64, value(row)?)));
                Series::line(&curve.name, i, points.collect())
            })
            .collect()
    };
    let bodies = "bodies before the contact";
    let mut charts = Vec::new();
    for sense in [Sense::Chain, Sense::Wall] {
        let mut series = of(sense, &|row| row.relative_force);
        if series.is_empty() {
            continue;
        }
        let mut laws = "";
        let curves = attenuation.curves.iter().filter(|c| c.sense == sense);
        for (i, curve) in curves.enumerate() {
            let Some(fits) = &curve.fits else { continue };
            let law = series[i]
                .points
                .iter()
                .map(|p| (p.0, fits.chosen().at(p.0)));
            let law = law.filter(|p| p.0 > 0.0).collect();
            series.push(Series::line("", i, law).with(Look::Dashed));
            laws = " (dashed: fitted law)";
        }
        if let Overlay::Forces(points) = overlay {
            series.extend(laid_over(points));
        }
        let title = match sense {
            Sense::Chain => {
                format!(
                    "peak force in one long chain, {} contacts{laws}",
                    kind.name()
                )
            }
            Sense::Wall => format!("peak force on the wall{laws}"),
        };
        let force = "force / that of the homogeneous chain";
        charts.push(Chart::of(title, bodies, force, series));
    }
    let others: [(&str, String, Value); 3] = [
        (
            "energy passed in one long chain",
            "energy / that of the homogeneous chain".into(),
            &|row| row.relative_energy,
        ),
        (
            "share of the energy passed above the band edge",
            "share".into(),
            &|row| row.high_share,
        ),
        (
            "width of the pulse at half its peak",
            label("width", if si { "s" } else { "" }),
            &|row| Some(row.pulse.width.value),
        ),
    ];
    for (title, label, value) in others {
        let series = of(Sense::Chain, value);
        if series.iter().any(|s| !s.points.is_empty()) {
            charts.push(Chart::of(title, bodies, label, series));
        }
    }
    if let Overlay::Field(points) = overlay
        && let Some(first) = attenuation.curves.first()
    {
        let computed = [first.velocities(), first.arrivals()];
        charts.extend(field_charts(
            "site",
            &first.name,
            first.units,
            computed,
            points,
        ));
    }
    charts
}

/// Force on the wall, time of flight and mean speed against the key, with the extremes as dots and
/// the localized ratios as marks.
pub fn transmission(transmission: &Transmission, overlay: Overlay, style: &Style) -> Figure {
    let charts = transmission_charts(transmission, overlay);
    let columns = if charts.len() > 1 { 2 } else { 1 };
    FigureLayout::grid("Transmission", columns, charts).figure("transmission", style)
}

pub(crate) fn transmission_charts(transmission: &Transmission, overlay: Overlay) -> Vec<Chart> {
    let si = transmission.units == Units::Si;
    let key = match (transmission.key.as_str(), si) {
        ("angle" | "second_angle", _) => {
            format!("{} (degrees)", transmission.key.replace('_', " "))
        }
        (key, _) => key.replace('_', " "),
    };
    let points = |value: &dyn Fn(&crate::attenuation::TransmissionPoint) -> f64| -> Vec<Series> {
        let curves = transmission.curves.iter().enumerate();
        curves
            .map(|(i, curve)| {
                let label: Vec<String> = curve
                    .settings
                    .iter()
                    .map(|(key, text)| format!("{} {text}", key.replace('_', " ")))
                    .collect();
                let points = curve.points.iter().map(|p| (p.value, value(p)));
                Series::line(label.join(", "), i, points.collect())
            })
            .collect()
    };
    let mut forces = points(&|p| p.relative_force);
    for (i, curve) in transmission.curves.iter().enumerate() {
        let extremes = curve.extremes.iter().map(|e| &e.point);
        let dots: Vec<(f64, f64)> = extremes.map(|p| (p.value, p.relative_force)).collect();
        // The curve passes through the extrema located between its values.
        forces[i].points.extend(&dots);
        forces[i].points.sort_by(|a, b| a.0.total_cmp(&b.0));
        forces.push(Series::line("", i, dots).with(Look::Dots));
    }
    if let Overlay::Forces(points) = overlay {
        forces.extend(laid_over(points));
    }
    let [time, speed] = match si {
        true => ["s", "m/s"],
        false => ["", "bodies per unit of time"],
    };
    let mut charts: Vec<Chart> = [
        (
            "peak force on the wall",
            "force / that of the homogeneous chain".to_owned(),
            forces,
        ),
        (
            "time of flight to the wall",
            label("time", time),
            points(&|p| p.time_of_flight.value),
        ),
        (
            "mean speed",
            label("speed", speed),
            points(&|p| p.mean_speed),
        ),
    ]
    .into_iter()
    .map(|(title, label, series)| Chart::of(title, &key, label, series))
    .collect();
    if let Overlay::Field(measured) = overlay
        && let Some(first) = transmission.curves.first()
    {
        let last = |value: &dyn Fn(&Pulse) -> Option<f64>| -> Vec<(f64, f64)> {
            let points = first.points.iter();
            points
                .filter_map(|p| Some((p.value, value(&p.pulse)?)))
                .collect()
        };
        let computed = [
            last(&|p| Some(p.peak_velocity.value)),
            last(&|p| p.velocity_rise_time.map(|t| t.value)),
        ];
        charts.extend(field_charts(
            &key,
            "last body",
            transmission.units,
            computed,
            measured,
        ));
    }
    let marks = transmission.curves.first().map(|curve| &curve.localized);
    let is_angle = transmission.key.ends_with("angle");
    for chart in &mut charts {
        chart.log_x = !is_angle && chart.x.start > 0.0 && chart.x.end > WIDE * chart.x.start;
        chart.marks = marks
            .into_iter()
            .flatten()
            .map(|mark| Mark {
                at: mark.value,
                label: format!("n = {}", mark.order),
            })
            .collect();
    }
    charts
}

/// Largest velocities and arrivals, computed and measured.
fn field_charts(
    x_label: &str,
    name: &str,
    units: Units,
    computed: [Vec<(f64, f64)>; 2],
    measured: [&[MeasuredPoint]; 2],
) -> Vec<Chart> {
    let labels = match units {
        Units::Si => ["velocity (m/s)", "time (s)"],
        Units::None => ["velocity", "time"],
    };
    let titles = ["largest velocity", "arrival: half of the largest velocity"];
    let all = titles.into_iter().zip(labels).zip(computed).zip(measured);
    all.map(|(((title, label), computed), measured)| {
        let mut series = vec![Series::line(name, 0, computed)];
        series.extend(laid_over(measured));
        Chart::of(title, x_label, label, series)
    })
    .collect()
}

fn laid_over(measured: &[MeasuredPoint]) -> Option<Series> {
    let points: Vec<(f64, f64)> = measured.iter().map(|p| (p.at, p.value)).collect();
    if points.is_empty() {
        return None;
    }
    let errors = measured.iter().map(|p| p.error.unwrap_or(0.0)).collect();
    Some(Series {
        errors,
        ..Series::line("measured", 6, points).with(Look::Dots)
    })
}
