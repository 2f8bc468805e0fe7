//! What the figure scripts share: panels of curves as PNG, SVG and CSV, and the experiment's chain.

use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use ndarray::{ArrayView2, Axis};
use wavecascade::analyze::{Map, MapAxis, Reduction};
use wavecascade::chain::scene::{SceneSource, Setting, Setup};
use wavecascade::plot::{Chart, Figure, FigureLayout, Format, Series, Style};

pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Rows of a CSV file at most, which keeps it below 300 kB.
const ROWS: usize = 5000;
/// Cells in a CSV file of maps at most, likewise.
const CELLS: usize = 9000;

/// A curve by its name, which may be empty, and its points.
pub type Curve = (&'static str, Vec<(f64, f64)>);

/// Curves on one pair of axes, which are drawn and written as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    pub title: String,
    pub x_label: &'static str,
    pub y_label: &'static str,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub curves: Vec<Curve>,
}

impl Panel {
    fn chart(&self) -> Chart {
        let curves = self.curves.iter().enumerate();
        let series = curves.map(|(i, (label, points))| Series::line(*label, i, points.clone()));
        Chart {
            x: self.x.clone(),
            y: self.y.clone(),
            ..Chart::of(&self.title, self.x_label, self.y_label, series.collect())
        }
    }
}

/// A range that holds 0 and all values of the curves.
pub fn around(curves: &[Curve]) -> Range<f64> {
    let points = curves.iter().flat_map(|(_, points)| points);
    wavecascade::plot::around(points.map(|point| point.1))
}

/// The style of all figures here, whose titles are in the README.
pub fn style() -> Style {
    Style {
        headings: false,
        ..Style::screen()
    }
}

/// Where pictures and tables go.
pub fn out() -> PathBuf {
    root().join("figures/out")
}

/// The folder of the repository.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The scene of the experiment with keys of its own: `("angle", "18 deg")`.
pub fn experiment(keys: &[(&str, &str)]) -> Outcome<Setup> {
    Ok(experiment_scene(keys)?.setup()?)
}

/// Draws the panels in rows of `columns` into `figures/out/<name>.png` and `.svg`, and writes their
/// curves into `<name>.csv`.
pub fn save(name: &'static str, columns: usize, panels: &[Panel]) -> Outcome<()> {
    save_as(name, columns, panels, |_, chart| chart)
}

/// The same with changes to the chart of each panel, by its place.
pub fn save_as(
    name: &'static str,
    columns: usize,
    panels: &[Panel],
    change: impl Fn(usize, Chart) -> Chart,
) -> Outcome<()> {
    let charts = panels.iter().map(Panel::chart).enumerate();
    let charts: Vec<Chart> = charts.map(|(i, chart)| change(i, chart)).collect();
    save_charts(name, columns, &charts)?;
    write(&format!("{name}.csv"), &table(panels)?)
}

/// The scene of the experiment, for commands that vary it.
pub fn experiment_scene(keys: &[(&str, &str)]) -> Outcome<SceneSource> {
    let scene = SceneSource::read(&root().join("examples/scenes/quartz_experiment.toml"))?;
    Ok(scene.with(settings(keys)))
}

fn settings<'a>(keys: &'a [(&str, &str)]) -> impl Iterator<Item = Setting> + 'a {
    keys.iter()
        .map(|(key, text)| Setting::new(key, *text, *key))
}

/// Draws charts in rows of `columns` into `figures/out/<name>.png` and `.svg`, with a letter each. Names of
/// curves stand above the first of the charts below each other that have them.
pub fn save_charts(name: &'static str, columns: usize, charts: &[Chart]) -> Outcome<()> {
    let names =
        |chart: &Chart| -> Vec<String> { chart.series.iter().map(|s| s.label.clone()).collect() };
    let drawn = charts
        .iter()
        .zip('a'..)
        .enumerate()
        .map(|(i, (chart, letter))| {
            let mut chart = chart.clone();
            if i >= columns && names(&chart) == names(&charts[i - columns]) {
                chart
                    .series
                    .iter_mut()
                    .for_each(|series| series.label.clear());
            }
            if charts.len() > 1 {
                chart.title = format!("({letter}) {}", chart.title);
            }
            chart
        });
    let mut layout = FigureLayout::grid(name, columns, drawn);
    if layout.rows.len() > 2 {
        layout.rows = layout.rows.into_iter().map(|row| row.high(0.7)).collect();
    }
    save_figure(&layout.figure(name, &style()))
}

/// Draws a figure into `figures/out/<name>.png` and `.svg`.
pub fn save_figure(figure: &Figure) -> Outcome<()> {
    for format in [Format::Png, Format::Svg] {
        let file = format!("{}.{}", figure.name(), format.extension());
        write(&file, &figure.encode(format)?)?;
    }
    Ok(())
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

/// Prints what was found, and asserts that it is what is expected, to `within`.
pub fn expect<const N: usize>(
    title: &str,
    names: [&str; N],
    found: [f64; N],
    expected: [f64; N],
    within: f64,
) {
    println!("{title}");
    for ((name, value), expected) in names.iter().zip(found).zip(expected) {
        println!("  {value:8.4}  {name}");
        let off = (value - expected).abs();
        assert!(off < within, "{name}: {value}, not {expected} to {within}");
    }
}

/// An axis of cells whose middles are the values, evenly spaced.
pub fn cells<'a>(label: &'a str, values: &[f64]) -> (&'a str, f64, f64) {
    let half = 0.5 * (values[1] - values[0]);
    (label, values[0] - half, values[values.len() - 1] + half)
}

/// A map of `values` (row 0 at the bottom) between the ends of its axes, in the units of its labels.
pub fn map(label: &str, values: ArrayView2<f64>, [x, y]: [(&str, f64, f64); 2]) -> Map {
    let axis = |(label, low, high): (&str, f64, f64)| MapAxis {
        label: label.into(),
        low,
        high,
    };
    Map {
        values: values.mapv(|value| value as f32),
        x: axis(x),
        y: axis(y),
        reduction: Reduction::Extreme {
            rows: 1,
            columns: 1,
        },
        range: None,
        label: label.into(),
        detail: None,
    }
}

/// Writes a grid of maps as `figures/out/<name>.png` and `.svg`, and the maps as `<name>.csv`.
pub fn save_maps(figure: &Figure, maps: &[(&str, &Map)]) -> Outcome<()> {
    let name = figure.name();
    save_figure(figure)?;
    let mut text = String::new();
    for ((title, map), index) in maps.iter().zip(1..) {
        let [x, y] = [&map.x.label, &map.y.label];
        writeln!(
            text,
            "# map {index}: {title}; x: {x}; y: {y}; value: {}",
            map.label
        )?;
    }
    text.push_str(
        "# a line a cell: of the samples in it, the one of largest magnitude\nmap,x,y,value\n",
    );
    let most = ((CELLS / maps.len().max(1)) as f64).sqrt() as usize;
    for ((_, map), index) in maps.iter().zip(1..) {
        let size = |length: usize| length.div_ceil(most).max(1);
        let block = [size(map.values.nrows()), size(map.values.ncols())];
        let at = |axis: &MapAxis, share: f64| axis.low + (axis.high - axis.low) * share;
        for (i, rows) in map.values.axis_chunks_iter(Axis(0), block[0]).enumerate() {
            for (j, cell) in rows.axis_chunks_iter(Axis(1), block[1]).enumerate() {
                let middle = |i: usize, axis: usize| {
                    let first = (i * block[axis]) as f64;
                    (first + 0.5 * cell.len_of(Axis(axis)) as f64)
                        / map.values.len_of(Axis(axis)) as f64
                };
                let value = cell
                    .iter()
                    .fold(0.0f32, |m, v| if v.abs() > m.abs() { *v } else { m });
                let (x, y) = (at(&map.x, middle(j, 1)), at(&map.y, middle(i, 0)));
                writeln!(text, "{index},{x:.5},{y:.5},{value:.3e}")?;
            }
        }
    }
    write(&format!("{name}.csv"), text.as_bytes())
}
