//! What the figure scripts share: panels of curves as PNG, SVG and CSV, and the experiment's chain.

#![allow(dead_code, unused_imports)] // each script uses a part of it

use std::fmt::Write;
use std::path::{Path, PathBuf};

use cascade::chain::scene::{SceneSource, Setting, Setup};
pub use cascade::plot::{Curve, Panel, around};
use cascade::plot::{Format, draw_panels};

pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Rows of a CSV file at most, which keeps it below 300 kB.
const ROWS: usize = 5000;

/// Where pictures and tables go.
pub fn out() -> PathBuf {
    root().join("figures/out")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The scene of the experiment with keys of its own: `("angle", "18 deg")`.
pub fn experiment(keys: &[(&str, &str)]) -> Outcome<Setup> {
    let scene = SceneSource::read(&root().join("examples/scenes/quartz_experiment.toml"))?;
    let settings = keys.iter().map(|(key, text)| Setting {
        key: (*key).into(),
        text: (*text).into(),
        source: (*key).into(),
    });
    Ok(scene.with(settings).setup()?)
}

/// Draws the panels in rows of `columns` into `figures/out/<name>.png` and `.svg`, and writes their
/// curves into `<name>.csv`.
pub fn save(name: &str, columns: usize, panels: &[Panel]) -> Outcome<()> {
    for format in [Format::Png, Format::Svg] {
        let picture = draw_panels(name, columns, panels, format)?;
        write(&format!("{name}.{}", format.extension()), &picture)?;
    }
    write(&format!("{name}.csv"), &table(panels)?)
}

/// Writes `figures/out/<file>`, whole or not at all.
pub fn write(file: &str, bytes: &[u8]) -> Outcome<()> {
    let file = out().join(file);
    let part = file.with_extension("part");
    std::fs::write(&part, bytes)?;
    std::fs::rename(&part, &file)?;
    println!("{}", file.display());
    Ok(())
}

/// Lines with `#` that say what each panel shows, then a line a point; of dense curves every n-th.
fn table(panels: &[Panel]) -> Outcome<Vec<u8>> {
    let curves = || panels.iter().flat_map(|panel| &panel.curves);
    let points: usize = curves().map(|(_, points)| points.len()).sum();
    let every = points.div_ceil(ROWS).max(1);
    let mut text = String::new();
    for (panel, index) in panels.iter().zip(1..) {
        let Panel {
            title,
            x_label,
            y_label,
            ..
        } = panel;
        writeln!(text, "# panel {index}: {title}; x: {x_label}; y: {y_label}")?;
    }
    text.push_str("panel,curve,x,y\n");
    for (panel, index) in panels.iter().zip(1..) {
        for (curve, points) in &panel.curves {
            for (x, y) in points.iter().step_by(every) {
                writeln!(text, "{index},{},{x:.7},{y:.6e}", curve.replace(',', ""))?;
            }
        }
    }
    Ok(text.into_bytes())
}
