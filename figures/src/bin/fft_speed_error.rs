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

use figures::{Outcome, save_figure, style, write};
use wavecascade::plot::{Chart, FigureLayout, Look, Series};

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
    let charts = panels.iter().map(|(case, points)| chart(case, points));
    let title = "Time against error of transforms of all columns";
    let sheet = FigureLayout::grid(title, 2, charts);
    save_figure(&sheet.figure("fft_speed_error", &style()))
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

fn chart(case: &str, points: &Points) -> Chart {
    let errors = match case.ends_with("f64") {
        true => 1.8e-16..1.3e-15,
        false => 9e-8..3.6e-7,
    };
    let times = || points.values().map(|p| p.1);
    let longest = times().fold(0.0, f64::max);
    let least = times().fold(f64::INFINITY, f64::min);
    let libraries = LIBRARIES.iter().enumerate().rev();
    let series = libraries.map(|(colour, (label, names))| {
        let points = names.iter().map(|name| points[name]).collect();
        Series::line(*label, colour, points).with(Look::Dots)
    });
    Chart {
        x: errors,
        y: 0.7 * least..1.4 * longest,
        log_x: true,
        log_y: true,
        ..Chart::of(
            case.replace('x', " × "),
            "relative error",
            "time (ms)",
            series.collect(),
        )
    }
}
