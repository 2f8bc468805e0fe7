//! The summary of a run, on one screen.

use std::fmt::Write;

use cascade::analyze::{Analysis, BandEdge, LargeArray, Moments, Plan};

/// What a person wants to know first.
pub fn summary(analysis: &Analysis) -> String {
    let axes = &analysis.axes;
    let mut text = String::new();
    let time_unit = axes.time.unit.as_deref().unwrap_or("samples");
    let space_unit = axes.space.unit.as_deref().unwrap_or("sites");
    let (frequency_unit, wavenumber_unit) = (axes.frequency_unit(), axes.wavenumber_unit());
    line(
        &mut text,
        "field",
        &format!(
            "{}: {} times x {} sites, dt {} {time_unit}, dx {} {space_unit}",
            analysis.name, axes.n_times, axes.n_sites, axes.time.step, axes.space.step
        ),
    );
    if let Some(moments) = &analysis.along_space {
        along(&mut text, "frequency along x", moments, &frequency_unit);
        edge(&mut text, analysis.frequency_edge, &frequency_unit, "site");
        shares(&mut text, moments, "first site", "last site");
    }
    if let Some(moments) = &analysis.along_time {
        along(&mut text, "wavenumber along t", moments, &wavenumber_unit);
        edge(
            &mut text,
            analysis.wavenumber_edge,
            &wavenumber_unit,
            "time",
        );
        shares(&mut text, moments, "first time", "last time");
    }
    if let Some(d) = analysis.direction {
        line(
            &mut text,
            "direction",
            &format!(
                "{} towards +x, {} towards -x, {} undirected",
                percent(d.toward_plus_x),
                percent(d.toward_minus_x),
                percent(d.undirected)
            ),
        );
    }
    let residual = |r: Option<f64>| r.map_or("-".into(), |r| format!("{r:.1e}"));
    let p = analysis.parseval;
    line(
        &mut text,
        "Parseval residual",
        &format!(
            "time {}, space {}, space-time {}",
            residual(p.time),
            residual(p.space),
            residual(p.spacetime)
        ),
    );
    if let Some(check) = analysis.accuracy.spot_check {
        line(
            &mut text,
            "transform error",
            &format!(
                "{check:.1e} of the root mean square ({} amplitudes against direct sums)",
                analysis.accuracy.spot_checks
            ),
        );
    }
    let seconds: f64 = analysis.timings.iter().map(|t| t.seconds).sum();
    let transforms: u64 = analysis.timings.iter().map(|t| t.transforms).sum();
    line(
        &mut text,
        "time",
        &format!("{seconds:.3} s for {transforms} transforms"),
    );
    for warning in &analysis.warnings {
        line(&mut text, "warning", &warning.message());
        line(&mut text, "", warning.advice());
    }
    text
}

/// What a plan would do.
pub fn plan(plan: &Plan) -> String {
    let mut text = String::new();
    for stage in &plan.stages {
        line(
            &mut text,
            stage.stage,
            &format!(
                "{} transforms of length {}, {} read, {} written",
                stage.transforms,
                stage.length,
                size(stage.bytes_read),
                size(stage.bytes_written)
            ),
        );
    }
    for (array, (rows, columns)) in &plan.arrays {
        let axes = match array {
            LargeArray::TemporalSpectrum => "frequency x site",
            LargeArray::SpatialSpectrum | LargeArray::KineticFluxSurrogate => "time x wavenumber",
            LargeArray::SpacetimeSpectrum => "frequency x wavenumber",
        };
        line(
            &mut text,
            "array",
            &format!("{} {rows} x {columns} ({axes})", array.name()),
        );
    }
    let blocks = plan.blocks();
    line(
        &mut text,
        "blocks",
        &format!(
            "{} sites, {} times, {} frequencies at once",
            blocks.sites, blocks.times, blocks.frequencies
        ),
    );
    let scratch = match plan.scratch_file {
        0 => String::new(),
        bytes => format!(", and a scratch file of {}", size(bytes)),
    };
    line(
        &mut text,
        "memory",
        &format!(
            "{} of {} allowed{scratch}",
            size(plan.memory_needed),
            size(plan.memory_allowed)
        ),
    );
    line(&mut text, "threads", &plan.threads.to_string());
    text
}

fn along(text: &mut String, name: &str, moments: &Moments, unit: &str) {
    let ends = |values: &[f64]| match (values.first(), values.last()) {
        (Some(&a), Some(&b)) => format!("{} -> {}", number(a), number(b)),
        _ => "-".into(),
    };
    let value = format!(
        "centroid {}, 90 % below {} {unit}, entropy {}",
        ends(&moments.centroid),
        ends(&moments.quantile_90),
        ends(&moments.entropy)
    );
    line(text, name, &value);
}

fn edge(text: &mut String, edge: Option<BandEdge>, unit: &str, row: &str) {
    let value = match edge {
        None => return,
        Some(BandEdge::Given { value }) => format!("at {} {unit}, as given", number(value)),
        Some(BandEdge::Reference { value, at, .. }) => format!(
            "at {} {unit}: 90 % of the energy at {row} {at} lies below",
            number(value)
        ),
        Some(BandEdge::Undefined) => "undefined: no energy".into(),
    };
    line(text, "  band edge", &value);
}

fn shares(text: &mut String, moments: &Moments, first: &str, last: &str) {
    let of = |share: Option<&f64>| share.map_or("-".into(), |&s| percent(s));
    let value = format!(
        "{} at the {first}, {} at the {last}",
        of(moments.high_share.first()),
        of(moments.high_share.last())
    );
    line(text, "  high band", &value);
}

fn line(text: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{name:<19}{value}");
}

fn number(x: f64) -> String {
    if x.is_nan() {
        return "undefined".into();
    }
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let digits = (3 - x.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.3e}")
    }
}

fn percent(share: f64) -> String {
    if share.is_nan() {
        "undefined".into()
    } else {
        format!("{:.2} %", 100.0 * share)
    }
}

fn size(bytes: u64) -> String {
    indicatif::HumanBytes(bytes).to_string()
}
