//! Force on the sensor against the first angle, with maps of the velocity: Figure 8 of the paper.
//!
//! Equation: as Figure 7; `max_t F_40(t)` of the sensor's contact over the same at (90, 90) degrees.
//! Command: `cargo run --release -p figures --bin fig08_force_transmission`; 17 s of processor time.
//! Shows: above, the transmitted force with its extremes located by further runs (dots) and the
//! angles of localized waves (uprights), for four sensors, for the other order of angles, and for a
//! cylinder as striker, since the paper leaves these open. Below, velocity over site and time at 90, 18
//! and 8 degrees.
//! Asserts: at 90 degrees, where the force is relative to itself, less than 1e-3 of the energy that
//! passes contact 3 fails to pass contact 30; the first minimum below, at 15.9 to 16.5 degrees, has more than 40 % lost; from there to 8 degrees
//! the force rises by 0.20 to 0.35; where maxima are, and by how much they stand out, as below.
//! Differs: the paper says "about 18" degrees for the minimum; it is at 15.9 to 16.5 whatever is left
//! open, with 53 % lost (0.465), and 51 % are lost at 18. Near 8 degrees the force has risen again, to
//! 0.67 to 0.78, but its maximum lies between 5.1 and 6.3 degrees, where it stands out from the next
//! minimum by 0.001 to 0.012: a rise is robust, a maximum "at about 8" is not. With a sensor touched
//! as one more cylinder would be, whose contact stiffens with the angle, a maximum stands out, by
//! 0.12 at 6.5 degrees, and 39 % are lost at 18. Between 53 and 81 degrees a little more force comes
//! through than at 90 (1.0001 to 1.027 times).

use std::fmt::Write;

use ndarray::Array2;
use wavecascade::attenuation::{
    Sense, TransmissionCurve, TransmissionExtremum, TransmissionRequest, pulses,
};
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;
use wavecascade::plot::{Chart, Colors, FigureLayout, Look, Mark, PlotRow, Series};

use figures::{Outcome, experiment, experiment_scene, save_figure, style, write};

const ANGLES: &str = "angle=2,3,4,5,6,7,8,9,10,12,14,16,18,20,23,26,30,35,40,50,60,70,80,90";

/// A sensor whose contact turns with the angles.
const CYLINDER: &str = "sensor touched as a cylinder";

type Variant = (&'static str, &'static [(&'static str, &'static str)]);

/// What the paper leaves open.
const VARIANTS: [Variant; 6] = [
    ("sensor's cap rounded at 20 mm", &[]),
    ("cap rounded at 5 mm", &[("wall_radius", "5 mm")]),
    ("cap nearly flat", &[("wall_radius", "1 m")]),
    (CYLINDER, &[]),
    ("other angle first", &[]),
    ("struck by a cylinder", &[("striker_mass", "10.08 g")]),
];

fn main() -> Outcome<()> {
    let mut curves = Vec::new();
    for (name, keys) in VARIANTS {
        let mut keys = keys.to_vec();
        let over = match name {
            "other angle first" => {
                keys.push(("angle", "90 deg"));
                ANGLES.replacen("angle", "second_angle", 1)
            }
            _ => ANGLES.to_owned(),
        };
        let scene = match name {
            CYLINDER => without_sensor()?,
            _ => experiment_scene(&keys)?,
        };
        let request = TransmissionRequest::new(scene, over);
        let found = request.run(None, &Silent)?;
        let curve = found.curves.into_iter().next().ok_or("no curve")?;
        tell(name, &curve);
        curves.push((name, curve));
    }
    for (name, curve) in &curves {
        check(name, curve);
    }
    complete()?;
    table(&curves)?;
    let chart = transmitted(&curves);
    let maps = [90, 18, 8].into_iter().map(map);
    let maps: Vec<Chart> = maps.collect::<Outcome<_>>()?;
    let sheet = FigureLayout {
        rows: vec![PlotRow::of([chart]), PlotRow::of(maps)],
        ..FigureLayout::default()
    };
    save_figure(&sheet.figure("fig08_force_transmission", &style()))
}

/// At 90 degrees, where forces are relative to themselves: the part of the energy that is left behind
/// between two contacts before any reflection.
fn complete() -> Outcome<()> {
    let setup = experiment(&[("angle", "90 deg"), ("samples", "2"), ("end_time", "auto")])?;
    let found = pulses(&setup.simulation, Sense::Chain, &Silent)?;
    let passed = |n: usize| found.pulses[n].energy_passed.value;
    let lost = 1.0 - passed(30) / passed(3);
    println!("at 90 degrees {lost:.1e} of the energy is lost from contact 3 to contact 30");
    assert!((0.0..1e-3).contains(&lost), "{lost}");
    Ok(())
}

/// The scene of the experiment without the keys of its sensor.
fn without_sensor() -> Outcome<SceneSource> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../examples/scenes/quartz_experiment.toml"
    );
    let text = std::fs::read_to_string(path)?;
    let lines = text.lines().filter(|line| !line.starts_with("wall_"));
    Ok(SceneSource::new(None, lines.collect::<Vec<_>>().join("\n")))
}

/// The minimum of a curve at the largest angle.
fn first_minimum(curve: &TransmissionCurve) -> Option<&TransmissionExtremum> {
    let minima = curve.extremes.iter().filter(|e| !e.is_maximum);
    minima.max_by(|a, b| a.point.value.total_cmp(&b.point.value))
}

fn force(curve: &TransmissionCurve, angle: f64) -> f64 {
    let point = curve.points.iter().find(|p| p.value == angle);
    point.map_or(f64::NAN, |p| p.relative_force)
}

fn tell(name: &str, curve: &TransmissionCurve) {
    println!(
        "{name}: {:.4} at 18 degrees, {:.4} at 8",
        force(curve, 18.0),
        force(curve, 8.0)
    );
    for TransmissionExtremum {
        is_maximum,
        value_error,
        point,
    } in &curve.extremes
    {
        let kind = if *is_maximum { "maximum" } else { "minimum" };
        println!(
            "  {kind} {:.6} at {:.4} +- {value_error:.0e} degrees",
            point.relative_force, point.value
        );
    }
}

fn check(name: &str, curve: &TransmissionCurve) {
    let minimum = first_minimum(curve).map(|e| e.point);
    let minimum = minimum.unwrap_or_else(|| panic!("{name}: no minimum"));
    let (angle, least) = (minimum.value, minimum.relative_force);
    assert!((15.8..16.6).contains(&angle), "{name}: {angle}");
    assert!((0.40..0.60).contains(&least), "{name}: {least}");
    let risen = force(curve, 8.0) - least;
    assert!((0.20..0.35).contains(&risen), "{name}: {risen}");
    let below = |is_maximum: bool| {
        let all = curve.extremes.iter().map(|e| (e.is_maximum, e.point));
        all.filter(move |(kind, p)| *kind == is_maximum && p.value < angle - 1e-6)
            .map(|(_, p)| p)
            .next_back()
    };
    // How far the last maximum before it stands out from the last minimum there, where there are any.
    let out = below(true).zip(below(false));
    let out = out.map(|(top, hollow)| (top.value, top.relative_force - hollow.relative_force));
    match (name, out) {
        ("other angle first", None) => {}
        (CYLINDER, Some((at, by))) => {
            assert!((at - 6.49).abs() < 0.02 && (by - 0.116).abs() < 0.002)
        }
        (_, Some((at, by))) => {
            assert!(
                (5.0..6.4).contains(&at) && (5e-4..0.013).contains(&by),
                "{name}: {at} {by}"
            );
        }
        (_, None) => panic!("{name}: no maximum"),
    }
    if name == VARIANTS[0].0 {
        assert!((angle - 16.27).abs() < 0.02 && (least - 0.4653).abs() < 5e-4);
    }
}

fn table(curves: &[(&str, TransmissionCurve)]) -> Outcome<()> {
    let mut text = String::from("variant,row,first_angle_degrees,relative_force,peak_force_n\n");
    for (name, curve) in curves {
        let extremes = curve.extremes.iter().map(|e| match e.is_maximum {
            true => ("maximum", e.point),
            false => ("minimum", e.point),
        });
        for (row, p) in curve.points.iter().map(|p| ("value", *p)).chain(extremes) {
            let (angle, force) = (p.value, p.relative_force);
            writeln!(
                text,
                "{name},{row},{angle:.5},{force:.9},{:.9}",
                p.peak_force.value
            )?;
        }
    }
    write("fig08_force_transmission.csv", text.as_bytes())
}

fn transmitted(curves: &[(&str, TransmissionCurve)]) -> Chart {
    let mut series = Vec::new();
    for (i, (name, curve)) in curves.iter().enumerate() {
        let points = |points: &mut dyn Iterator<Item = (f64, f64)>| points.collect::<Vec<_>>();
        let all = curve.points.iter().map(|p| (p.value, p.relative_force));
        let extremes = curve
            .extremes
            .iter()
            .map(|e| (e.point.value, e.point.relative_force));
        let mut joined: Vec<(f64, f64)> = all.chain(extremes.clone()).collect();
        joined.sort_by(|a, b| a.0.total_cmp(&b.0));
        let look = if i == 0 { Look::Line } else { Look::Dashed };
        series.push(Series::line(*name, i, joined).with(look));
        series.push(Series::line("", i, points(&mut extremes.clone())).with(Look::Dots));
    }
    let marks = curves[0].1.localized.iter().map(|mark| Mark {
        at: mark.value,
        label: format!("n = {}", mark.order),
    });
    Chart {
        x: 0.0..92.0,
        marks: marks.collect(),
        ..Chart::of(
            "force on the sensor behind 40 cylinders",
            "first angle (degrees)",
            "force / that at 90 degrees",
            series,
        )
    }
}

/// Velocity over site and time at an angle.
fn map(angle: i32) -> Outcome<Chart> {
    let text = format!("{angle} deg");
    let setup = experiment(&[("angle", &text), ("samples", "97"), ("end_time", "1.2 ms")])?;
    let speed = setup.simulation.velocity[0];
    let run = setup.simulation.run(&Silent)?;
    let velocity: Array2<f64> = run.velocity.mapv(|v| v / speed);
    let largest = 0.8;
    Ok(Chart {
        title: format!("{angle}°"),
        x_label: "cylinder".into(),
        y_label: "time (ms)".into(),
        label: "velocity / that of the impact".into(),
        x: -0.5..40.5,
        y: 0.0..1.2,
        values: velocity,
        colors: Colors::Between(-largest..largest),
        ..Chart::default()
    })
}
