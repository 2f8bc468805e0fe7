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

use figures::{save_figure, style};
use wavecascade::plot::{Chart, FigureLayout, Look, Marker, Series, Weight};

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
struct Curve {
    program: &'static str,
    scheme: &'static str,
    label: &'static str,
    /// Index into the palette.
    colour: usize,
    mark: Marker,
}

// Of the palette; peers are dashed.
const BLUE: usize = 0;
const VERMILION: usize = 1;
const GREEN: usize = 2;
const PURPLE: usize = 3;
const ORANGE: usize = 4;
const SKY: usize = 5;
const BLACK: usize = 6;

#[rustfmt::skip]
const CURVES: [Curve; 12] = [
    Curve { program: "cascade", scheme: "nystrom", label: "Nyström 8(6)", colour: BLACK, mark: Marker::Circle },
    Curve { program: "cascade", scheme: "runge-kutta", label: "Runge-Kutta 8(5)", colour: BLUE, mark: Marker::Square },
    Curve { program: "cascade", scheme: "symplectic-6", label: "symplectic 6", colour: GREEN, mark: Marker::Triangle },
    Curve { program: "cascade", scheme: "symplectic-4", label: "symplectic 4", colour: SKY, mark: Marker::Circle },
    Curve { program: "cascade", scheme: "velocity-verlet", label: "velocity Verlet", colour: PURPLE, mark: Marker::Square },
    Curve { program: "odeint", scheme: "dopri5", label: "odeint dopri5", colour: VERMILION, mark: Marker::Circle },
    Curve { program: "odeint", scheme: "fehlberg78", label: "odeint fehlberg78", colour: ORANGE, mark: Marker::Square },
    Curve { program: "odeint", scheme: "SB3A", label: "odeint SB3A", colour: PURPLE, mark: Marker::Triangle },
    Curve { program: "diffrax", scheme: "Dopri8", label: "diffrax Dopri8", colour: BLUE, mark: Marker::Cross },
    Curve { program: "SciPy", scheme: "DOP853", label: "SciPy DOP853", colour: GREEN, mark: Marker::Cross },
    Curve { program: "numba", scheme: "velocity Verlet", label: "numba Verlet", colour: VERMILION, mark: Marker::Cross },
    Curve { program: "LAMMPS", scheme: "velocity Verlet", label: "LAMMPS Verlet", colour: BLACK, mark: Marker::Cross },
];

const KAPPAS: [f64; 4] = [1.0, 4.9272, 14.622, 1631.0];
const ERRORS: (f64, f64) = (1e-14, 1.0);

fn main() -> Result<(), Failure> {
    let root = figures::root();
    let path = newest(&root.join("benches/runs"))?;
    let rows = serde_json::from_str::<Record>(&std::fs::read_to_string(&path)?)?.rows;
    check(&rows)?;

    let out = root.join("figures/out");
    std::fs::create_dir_all(&out)?;
    save_figure(&sheet(&rows).figure("chain_work_precision", &style()))?;
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
fn front<'a>(rows: &'a [Row], kappa: f64, style: &Curve) -> Vec<&'a Row> {
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
        let known = CURVES
            .iter()
            .any(|s| s.program == row.program && s.scheme == row.scheme);
        assert!(known, "{} {} has no style", row.program, row.scheme);
    }
    for kappa in KAPPAS {
        let own = front(rows, kappa, &CURVES[0]);
        let deepest = own.last().ok_or("no rows of the default scheme")?.error;
        assert!(deepest < 1e-10, "kappa {kappa}: {deepest:e}");
        let mut ratios = BTreeMap::new();
        for error in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10] {
            for style in &CURVES[1..] {
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

fn sheet(rows: &[Row]) -> FigureLayout {
    let times = time_range(rows);
    let charts = KAPPAS.map(|kappa| chart(rows, kappa, times));
    FigureLayout {
        notes: vec![
            "Impacted dimer chains, 300 sites to time 295. One core; velocities at 64 times; error \
             against double-double arithmetic."
                .into(),
        ],
        ..FigureLayout::grid("Time against error on impacted dimer chains", 2, charts)
    }
}

/// Powers of ten around all times drawn.
fn time_range(rows: &[Row]) -> (f64, f64) {
    let times = rows.iter().map(|row| row.time_ms.log10());
    let (low, high) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
        (low.min(t), high.max(t))
    });
    (10f64.powf(low.floor()), 10f64.powf(high.ceil()))
}

fn chart(rows: &[Row], kappa: f64, times: (f64, f64)) -> Chart {
    let curve = |style: &Curve| {
        let points = front(rows, kappa, style);
        let points = points
            .iter()
            .map(|row| (row.error.max(ERRORS.0), row.time_ms));
        let look = match style.program {
            "cascade" => Look::Line,
            _ => Look::Dashed,
        };
        let weight = match (style.program, style.scheme) {
            ("cascade", "nystrom") => Weight::Bold,
            _ => Weight::Normal,
        };
        let series = Series::line(style.label, style.colour, points.collect());
        Series {
            weight,
            ..series.with(look).marked(style.mark)
        }
    };
    Chart {
        x: ERRORS.0..ERRORS.1,
        y: times.0..times.1,
        log_x: true,
        log_y: true,
        ..Chart::of(
            format!("κ = {kappa}"),
            "largest error of a velocity (impact velocity = 1)",
            "time of a run (ms)",
            CURVES.iter().map(curve).collect(),
        )
    }
}
