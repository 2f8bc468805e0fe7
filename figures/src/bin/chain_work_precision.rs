//! Time against error on impacted dimer chains: every scheme of `cascade`, and its peers.
//!
//! Problem: 300 unit masses, Hertz contacts of coefficients 1, kappa, 1, ..., site 0 at velocity 1,
//! to time 295; velocities at 64 times, one core.
//! Data: the newest `benches/runs/*/chain.json`, which `python3 benches/peers/chain/run.py` writes;
//! nothing is timed here.
//! Command: `cargo run --release -p figures --bin chain_work_precision`; under a second.
//! Shows: for each program and scheme the settings that no other one of it beats in both time and
//! error, at four stiffness ratios; all of them are in the CSV file.
//! Asserts: at every kappa the default scheme reaches an error of 1e-10, no peer is as quick at
//! errors from 1e-4 down, and no other scheme from 1e-6 down.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use wavecascade::plot::plotters::prelude::*;
use wavecascade::plot::plotters::style::text_anchor::{HPos, Pos, VPos};
use wavecascade::plot::{Area, Canvas, Format, px, sans};

type Failure = Box<dyn std::error::Error>;

#[derive(serde::Deserialize)]
struct Record {
    rows: Vec<Row>,
}

#[derive(serde::Deserialize, Clone)]
struct Row {
    program: String,
    scheme: String,
    kappa: f64,
    setting: String,
    error: f64,
    time_ms: f64,
    wall_ms: f64,
}

/// A program's scheme, how it is drawn, and where.
struct Style {
    program: &'static str,
    scheme: &'static str,
    label: &'static str,
    colour: RGBColor,
    mark: Mark,
}

#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Triangle,
    Cross,
}

// Colours of M. Okabe and K. Ito, told apart with any colour vision; peers are dashed.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const SKY: RGBColor = RGBColor(86, 180, 233);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const GREY: RGBColor = RGBColor(120, 120, 120);

#[rustfmt::skip]
const STYLES: [Style; 12] = [
    Style { program: "cascade", scheme: "nystrom", label: "Nyström 8(6)", colour: BLACK, mark: Mark::Circle },
    Style { program: "cascade", scheme: "runge-kutta", label: "Runge-Kutta 8(5)", colour: BLUE, mark: Mark::Square },
    Style { program: "cascade", scheme: "symplectic-6", label: "symplectic 6", colour: GREEN, mark: Mark::Triangle },
    Style { program: "cascade", scheme: "symplectic-4", label: "symplectic 4", colour: SKY, mark: Mark::Circle },
    Style { program: "cascade", scheme: "velocity-verlet", label: "velocity Verlet", colour: GREY, mark: Mark::Square },
    Style { program: "odeint", scheme: "dopri5", label: "odeint dopri5", colour: VERMILION, mark: Mark::Circle },
    Style { program: "odeint", scheme: "fehlberg78", label: "odeint fehlberg78", colour: ORANGE, mark: Mark::Square },
    Style { program: "odeint", scheme: "SB3A", label: "odeint SB3A", colour: PURPLE, mark: Mark::Triangle },
    Style { program: "diffrax", scheme: "Dopri8", label: "diffrax Dopri8", colour: BLUE, mark: Mark::Cross },
    Style { program: "SciPy", scheme: "DOP853", label: "SciPy DOP853", colour: GREEN, mark: Mark::Cross },
    Style { program: "numba", scheme: "velocity Verlet", label: "numba Verlet", colour: VERMILION, mark: Mark::Cross },
    Style { program: "LAMMPS", scheme: "velocity Verlet", label: "LAMMPS Verlet", colour: GREY, mark: Mark::Cross },
];

const KAPPAS: [f64; 4] = [1.0, 4.9272, 14.622, 1631.0];
const SIZE: (u32, u32) = (1180, 900);
const LEGEND: f64 = 220.0;
const ERRORS: (f64, f64) = (1e-14, 1.0);

fn main() -> Result<(), Failure> {
    let root = figures::root();
    let path = newest(&root.join("benches/runs"))?;
    let rows = serde_json::from_str::<Record>(&std::fs::read_to_string(&path)?)?.rows;
    check(&rows)?;

    let out = root.join("figures/out");
    std::fs::create_dir_all(&out)?;
    for (format, extension) in [(Format::Png, "png"), (Format::Svg, "svg")] {
        write(&out, extension, &draw(&rows, format)?)?;
    }
    write(&out, "csv", table(&rows).as_bytes())?;
    println!("drawn from {}", path.display());
    Ok(())
}

fn newest(runs: &Path) -> Result<PathBuf, Failure> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(runs)? {
        let path = entry?.path().join("chain.json");
        if path.exists() {
            found.push(path);
        }
    }
    let missing = "no benches/runs/*/chain.json: run benches/peers/chain/run.py";
    found.into_iter().max().ok_or_else(|| missing.into())
}

fn write(out: &Path, extension: &str, bytes: &[u8]) -> Result<(), Failure> {
    let path = out.join(format!("chain_work_precision.{extension}"));
    let part = path.with_extension("tmp");
    std::fs::write(&part, bytes)?;
    std::fs::rename(&part, &path)?;
    println!("{}", path.display());
    Ok(())
}

fn table(rows: &[Row]) -> String {
    let mut text = String::from("program,scheme,kappa,setting,error,time_ms,wall_ms\n");
    for row in rows {
        text += &format!(
            "{},{},{},{},{:.4e},{:.5},{:.5}\n",
            row.program, row.scheme, row.kappa, row.setting, row.error, row.time_ms, row.wall_ms
        );
    }
    text
}

/// The settings of a scheme that no other one of it beats in both time and error, errors falling.
fn front<'a>(rows: &'a [Row], kappa: f64, style: &Style) -> Vec<&'a Row> {
    let mut of: Vec<&Row> = rows
        .iter()
        .filter(|r| r.kappa == kappa && r.program == style.program && r.scheme == style.scheme)
        .collect();
    of.sort_by(|a, b| a.time_ms.total_cmp(&b.time_ms));
    let mut best = f64::INFINITY;
    of.retain(|row| {
        let better = row.error < best;
        best = best.min(row.error);
        better
    });
    of
}

/// The least time at which an error is reached.
fn least(front: &[&Row], error: f64) -> f64 {
    let reached = front.iter().find(|row| row.error <= error);
    reached.map_or(f64::INFINITY, |row| row.time_ms)
}

fn check(rows: &[Row]) -> Result<(), Failure> {
    for row in rows {
        let known = STYLES
            .iter()
            .any(|s| s.program == row.program && s.scheme == row.scheme);
        assert!(known, "{} {} has no style", row.program, row.scheme);
    }
    for kappa in KAPPAS {
        let own = front(rows, kappa, &STYLES[0]);
        let deepest = own.last().ok_or("no rows of the default scheme")?.error;
        assert!(deepest < 1e-10, "kappa {kappa}: {deepest:e}");
        let mut ratios = BTreeMap::new();
        for error in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10] {
            for style in &STYLES[1..] {
                let peer = style.program != "cascade";
                let ratio = least(&front(rows, kappa, style), error) / least(&own, error);
                let quickest = ratio > 1.0 || (!peer && error > 1e-6);
                assert!(quickest, "kappa {kappa}, {}: {ratio}", style.label);
                if peer && ratio.is_finite() {
                    let least = ratios.entry(style.label).or_insert(ratio);
                    *least = ratio.min(*least);
                }
            }
        }
        println!("kappa {kappa}: least factor at errors from 1e-4 down: {ratios:.1?}");
    }
    Ok(())
}

fn draw(rows: &[Row], format: Format) -> Result<Vec<u8>, Failure> {
    let title = "Time against error on impacted dimer chains";
    let canvas = Canvas::new(title, SIZE.0, SIZE.1, format)?;
    let area = canvas.area();
    let caption = "Impacted dimer chains, 300 sites to time 295: time against error";
    let heading = |size| TextStyle::from(sans(size)).color(&BLACK);
    area.draw(&Text::new(caption, at(24.0, 18.0), heading(19.0)))?;
    let (panels, legend) = area
        .margin(px(48.0), px(8.0), px(10.0), px(10.0))
        .split_horizontally(px(f64::from(SIZE.0) - LEGEND - 20.0));
    let times = time_range(rows);
    for (panel, kappa) in panels.split_evenly((2, 2)).iter().zip(KAPPAS) {
        draw_panel(panel, rows, kappa, times)?;
    }
    draw_legend(&legend)?;
    Ok(canvas.encode()?)
}

/// Powers of ten around all times drawn.
fn time_range(rows: &[Row]) -> (f64, f64) {
    let times = rows.iter().map(|row| row.time_ms.log10());
    let (low, high) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
        (low.min(t), high.max(t))
    });
    (10f64.powf(low.floor()), 10f64.powf(high.ceil()))
}

fn at(x: f64, y: f64) -> (i32, i32) {
    (px(x) as i32, px(y) as i32)
}

fn power_of_ten(value: &f64) -> String {
    let exponent = value.log10().round() as i32;
    let raised = exponent.to_string().replace('-', "⁻");
    let raised: String = raised
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
            None => c,
        })
        .collect();
    format!("10{raised}")
}

fn draw_panel(panel: &Area, rows: &[Row], kappa: f64, times: (f64, f64)) -> Result<(), Failure> {
    let mut chart = ChartBuilder::on(panel)
        .margin(px(10.0))
        .caption(format!("κ = {kappa}"), sans(17.0))
        .x_label_area_size(px(48.0))
        .y_label_area_size(px(66.0))
        .build_cartesian_2d(
            (ERRORS.0..ERRORS.1).log_scale(),
            (times.0..times.1).log_scale(),
        )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(228, 228, 228).stroke_width(px(1.0)))
        .axis_style(BLACK.stroke_width(px(1.2)))
        .label_style(sans(13.0))
        .axis_desc_style(sans(14.0))
        .set_all_tick_mark_size(px(5.0))
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&power_of_ten)
        .y_label_formatter(&power_of_ten)
        .x_desc("largest error of a velocity (impact velocity = 1)")
        .y_desc("time of a run (ms)")
        .draw()?;
    // The default scheme last, over the others.
    for style in STYLES.iter().rev() {
        let points: Vec<(f64, f64)> = front(rows, kappa, style)
            .iter()
            .map(|row| (row.error.max(ERRORS.0), row.time_ms))
            .collect();
        let stroke = stroke(style);
        if style.program == "cascade" {
            chart.draw_series(LineSeries::new(points.clone(), stroke))?;
        } else {
            let dash = DashedLineSeries::new(points.clone(), px(5.0), px(3.5), stroke);
            chart.draw_series(dash)?;
        }
        for point in points {
            let place = EmptyElement::at(point);
            match style.mark {
                Mark::Circle => chart.draw_series([place + circle((0, 0), style)])?,
                Mark::Square => chart.draw_series([place + square((0, 0), style)])?,
                Mark::Triangle => chart.draw_series([place + triangle((0, 0), style)])?,
                Mark::Cross => chart.draw_series([place + cross((0, 0), style)])?,
            };
        }
    }
    Ok(())
}

fn stroke(style: &Style) -> ShapeStyle {
    let width = match (style.program, style.scheme) {
        ("cascade", "nystrom") => 3.0,
        ("cascade", _) => 1.8,
        _ => 1.4,
    };
    style.colour.stroke_width(px(width))
}

fn circle(place: (i32, i32), style: &Style) -> Circle<(i32, i32), u32> {
    Circle::new(place, px(3.8), style.colour.filled())
}

fn square((x, y): (i32, i32), style: &Style) -> Rectangle<(i32, i32)> {
    let half = px(3.3) as i32;
    Rectangle::new(
        [(x - half, y - half), (x + half, y + half)],
        style.colour.filled(),
    )
}

fn triangle(place: (i32, i32), style: &Style) -> TriangleMarker<(i32, i32), u32> {
    TriangleMarker::new(place, px(4.6), style.colour.filled())
}

fn cross(place: (i32, i32), style: &Style) -> Cross<(i32, i32), u32> {
    Cross::new(place, px(3.4), style.colour.stroke_width(px(1.6)))
}

fn draw_legend(area: &Area) -> Result<(), Failure> {
    let text = |size| {
        TextStyle::from(sans(size))
            .color(&BLACK)
            .pos(Pos::new(HPos::Left, VPos::Center))
    };
    let mut y = 30.0;
    for (heading, own) in [("cascade", true), ("peers", false)] {
        area.draw(&Text::new(heading, at(8.0, y), text(15.0)))?;
        y += 26.0;
        for style in STYLES.iter().filter(|s| (s.program == "cascade") == own) {
            let ends = [at(10.0, y), at(52.0, y)];
            if own {
                area.draw(&PathElement::new(ends, stroke(style)))?;
            } else {
                for dash in 0..5 {
                    let x = 10.0 + 8.5 * f64::from(dash);
                    area.draw(&PathElement::new([at(x, y), at(x + 5.0, y)], stroke(style)))?;
                }
            }
            let middle = at(31.0, y);
            match style.mark {
                Mark::Circle => area.draw(&circle(middle, style))?,
                Mark::Square => area.draw(&square(middle, style))?,
                Mark::Triangle => area.draw(&triangle(middle, style))?,
                Mark::Cross => area.draw(&cross(middle, style))?,
            }
            area.draw(&Text::new(style.label, at(62.0, y), text(13.5)))?;
            y += 24.0;
        }
        y += 18.0;
    }
    for line in [
        "One core; velocities at",
        "64 times; error against",
        "double-double arithmetic.",
    ] {
        area.draw(&Text::new(line, at(8.0, y), text(12.5)))?;
        y += 18.0;
    }
    Ok(())
}
