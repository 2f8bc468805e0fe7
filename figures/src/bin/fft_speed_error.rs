//! Time against relative error of transforms of all columns: `cascade`, and other libraries.
//!
//! Equation: bins `V[m] = sum over n of v[n] exp(-2 pi i m n / N)`, m = 0..=N/2, of each column of
//! a (time, site) array of uniform noise; error `rms(found - V) / rms(V)` against 80-bit arithmetic.
//! Data: `columns_1.json` and `columns_errors.json` of `benches/runs/2026-11-23-amd-epyc`, which
//! `benches/peers/columns.py` writes without and with `--errors`; nothing is timed here.
//! Command: `cargo run --release -p figures --bin fft_speed_error`; under a second.
//! Shows: a panel for each shape (rows x columns) and precision, medians of nine alternating runs on
//! one core of an AMD EPYC with AVX-512; lower left is better.
//! Asserts: in every panel `cascade` is the fastest, by 1.9 times at least (by 1.3 in the record with AVX2,
//! `benches/runs/2026-11-22-amd-epyc-avx2`). Its error is below FFTW's, at most 1.07 of
//! the least of all, and in `f64` at least 1.35 times less than `realfft`'s and `rustfft`'s (in `f32`
//! they are even, but for primes). FFTW's error depends on the plan it measures: at 4096 points in
//! `f64` runs gave 2.23e-16 to 2.45e-16, where `cascade` has 2.27e-16.
//! Differs: the paper times nothing. Errors are of plans made later than those that were timed.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;

use figures::{Outcome, write};
use wavecascade::plot::plotters::prelude::*;
use wavecascade::plot::plotters::style::text_anchor::{HPos, Pos, VPos};
use wavecascade::plot::{Area, Canvas, Format, PALETTE, px, sans};

const RECORD: &str = "benches/runs/2026-11-23-amd-epyc";
const SHAPES: [&str; 6] = [
    "4096x300",
    "16384x300",
    "65536x1000",
    "65536x1024",
    "10007x300",
    "9973x301",
];
/// Libraries by their names in the figure and in the record, each with a colour of its own.
const LIBRARIES: [(&str, &[&str]); 7] = [
    ("ducc0", &["ducc0"]),
    ("FFTW", &["FFTW"]),
    ("MKL", &["MKL"]),
    ("SciPy", &["scipy"]),
    (
        "realfft, by 8 columns and by 1",
        &["realfft, 8 columns", "realfft, 1 column"],
    ),
    ("rustfft, two-for-one", &["rustfft, two-for-one"]),
    ("cascade", &["cascade"]),
];

/// By shape and precision, then by library: the times of its runs (ms), or its error.
type Record<T> = BTreeMap<String, BTreeMap<String, T>>;

fn main() -> Outcome<()> {
    let times: Record<Vec<f64>> = read("columns_1.json")?;
    let errors: Record<f64> = read("columns_errors.json")?;
    let mut text = String::from("rows,columns,type,library,time_ms,relative_error\n");
    let mut panels = Vec::new();
    for precision in ["f64", "f32"] {
        for shape in SHAPES {
            let case = format!("{shape} {precision}");
            let points = points(&times[&case], &errors[&case])?;
            check(&case, &points);
            let (rows, columns) = shape.split_once('x').ok_or("a shape of the record")?;
            for (name, (error, time)) in &points {
                let name = name.replace(',', "");
                writeln!(
                    text,
                    "{rows},{columns},{precision},{name},{time:.5},{error:.4e}"
                )?;
            }
            panels.push((case, points));
        }
    }
    write("fft_speed_error.csv", text.as_bytes())?;
    for format in [Format::Png, Format::Svg] {
        write(
            &format!("fft_speed_error.{}", format.extension()),
            &draw(&panels, format)?,
        )?;
    }
    Ok(())
}

fn read<T: serde::de::DeserializeOwned>(file: &str) -> Outcome<Record<T>> {
    let path = figures::root().join(RECORD).join(file);
    Ok(serde_json::from_str(&std::fs::read_to_string(path)?)?)
}

/// Relative error and median time (ms) of each library, by its name in the record.
type Points<'a> = BTreeMap<&'a str, (f64, f64)>;

fn points<'a>(
    times: &'a BTreeMap<String, Vec<f64>>,
    errors: &BTreeMap<String, f64>,
) -> Outcome<Points<'a>> {
    let known = |name: &str| LIBRARIES.iter().any(|(_, names)| names.contains(&name));
    let mut points = Points::new();
    for (name, times) in times {
        assert!(known(name), "{name} has no colour");
        let mut times = times.clone();
        times.sort_by(f64::total_cmp);
        let error = errors.get(name).ok_or("an error of each library")?;
        points.insert(name, (*error, times[times.len() / 2]));
    }
    Ok(points)
}

fn check(case: &str, points: &Points) {
    let (error, time) = points["cascade"];
    let others = || points.iter().filter(|(name, _)| **name != "cascade");
    let fastest = others().map(|(_, p)| p.1).fold(f64::INFINITY, f64::min);
    let best = others().map(|(_, p)| p.0).fold(f64::INFINITY, f64::min);
    let fftw = points["FFTW"].0;
    println!(
        "{case}: best other {:.2} times as long; error {error:.2e}, {:.3} of FFTW's, {:.3} of the least other",
        fastest / time,
        error / fftw,
        error / best
    );
    assert!(fastest > 1.9 * time, "{case}");
    let double = case.ends_with("f64");
    assert!(error < fftw, "{case}: FFTW");
    for name in [
        "realfft, 8 columns",
        "realfft, 1 column",
        "rustfft, two-for-one",
    ] {
        assert!(!double || 1.35 * error < points[name].0, "{case}: {name}");
    }
    assert!(error < 1.07 * best, "{case}");
}

fn draw(panels: &[(String, Points)], format: Format) -> Outcome<Vec<u8>> {
    let title = "Time against error of transforms of all columns";
    let canvas = Canvas::new(title, 1410, 1500, format)?;
    let (legend, rest) = canvas.area().split_vertically(px(44.0));
    draw_legend(&legend)?;
    for (area, (case, points)) in rest.split_evenly((4, 3)).iter().zip(panels) {
        draw_panel(area, case, points)?;
    }
    Ok(canvas.encode()?)
}

fn draw_legend(area: &Area) -> Outcome<()> {
    let text = TextStyle::from(sans(16.0)).pos(Pos::new(HPos::Left, VPos::Center));
    let mut x = 60.0;
    let y = px(26.0) as i32;
    for (colour, (label, _)) in LIBRARIES.iter().enumerate().rev() {
        area.draw(&dot((px(x) as i32, y), colour))?;
        let place = (px(x + 12.0) as i32, y);
        area.draw(&Text::new(*label, place, text.clone()))?;
        x += 56.0 + 7.8 * label.len() as f64;
    }
    Ok(())
}

fn dot<C>(place: C, colour: usize) -> Circle<C, u32> {
    Circle::new(place, px(5.0), PALETTE[colour].filled())
}

fn draw_panel(area: &Area, case: &str, points: &Points) -> Outcome<()> {
    let errors = match case.ends_with("f64") {
        true => 1.8e-16..1.3e-15,
        false => 9e-8..3.6e-7,
    };
    let times = || points.values().map(|p| p.1);
    let longest = times().fold(0.0, f64::max);
    let least = times().fold(f64::INFINITY, f64::min);
    let times = 0.7 * least..1.4 * longest;
    let mut chart = ChartBuilder::on(area)
        .margin(px(12.0))
        .caption(case.replace('x', " x "), sans(17.0))
        .x_label_area_size(px(48.0))
        .y_label_area_size(px(72.0))
        .build_cartesian_2d(
            errors.clone().log_scale().with_key_points(ticks(errors)),
            times.clone().log_scale().with_key_points(ticks(times)),
        )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xe6, 0xe6, 0xe6))
        .label_style(sans(14.0))
        .axis_desc_style(sans(15.0))
        .set_all_tick_mark_size(px(4.0))
        .x_labels(10)
        .y_labels(10)
        .x_label_formatter(&|v| format!("{v:.0e}"))
        .y_label_formatter(&|v| format!("{v:.0}"))
        .x_desc("relative error")
        .y_desc("time (ms)")
        .draw()?;
    for (colour, (_, names)) in LIBRARIES.iter().enumerate() {
        chart.draw_series(names.iter().map(|name| dot(points[name], colour)))?;
    }
    Ok(())
}

/// 1, 2, 3 and 5 times powers of ten, within a range.
fn ticks(range: Range<f64>) -> Vec<f64> {
    let powers = range.start.log10().floor() as i32..=range.end.log10().floor() as i32;
    powers
        .flat_map(|power| [1.0, 2.0, 3.0, 5.0].map(|digit| digit * 10f64.powi(power)))
        .filter(|tick| range.contains(tick))
        .collect()
}
