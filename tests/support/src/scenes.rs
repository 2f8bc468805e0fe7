//! Chains of scenes, tables of them, and how far apart numbers are.

use std::borrow::Borrow;
use std::path::PathBuf;

use ndarray::ArrayView1;
use serde_json::Value;
use wavecascade::chain::scene::{SceneSource, Setup};
use wavecascade::chain::{Run, Simulation};
use wavecascade::observer::Silent;

/// Rows of a table: `|` parts cells, `#` begins a comment, `\n` in a cell begins a line.
pub fn rows<const N: usize>(table: &str) -> impl Iterator<Item = [String; N]> {
    let rows = table.lines();
    let rows = rows.filter(|row| !row.is_empty() && !row.starts_with('#'));
    rows.map(|row| {
        let cells = row.split('|').map(|cell| cell.trim().replace("\\n", "\n"));
        let cells: Result<[String; N], _> = cells.collect::<Vec<_>>().try_into();
        cells.unwrap_or_else(|cells| panic!("{cells:?}"))
    })
}

/// The numbers of a text of words.
pub fn parsed(text: &str) -> Vec<f64> {
    let words = text.split_whitespace();
    words.map(|word| word.parse().expect(word)).collect()
}

pub fn setup(text: &str) -> Setup {
    let setup = SceneSource::new(None, text).setup();
    setup.unwrap_or_else(|error| panic!("{text}: {error}"))
}

pub fn simulation(text: &str) -> Simulation {
    setup(text).simulation
}

pub fn run(text: &str) -> Run {
    simulation(text).run(&Silent).unwrap()
}

/// The velocities at the last sample.
pub fn last(run: &Run) -> ArrayView1<'_, f64> {
    run.velocity.row(run.velocity.nrows() - 1)
}

/// The largest magnitude; NaN, if there is one.
pub fn largest<T: Borrow<f64>>(values: impl IntoIterator<Item = T>) -> f64 {
    let values = values.into_iter().map(|value| *value.borrow());
    values.fold(0.0, |most: f64, value: f64| {
        match value.abs() > most || value.is_nan() {
            true => value.abs(),
            false => most,
        }
    })
}

/// The largest difference of as many numbers.
pub fn apart<A: Borrow<f64>, B: Borrow<f64>>(
    a: impl IntoIterator<Item = A>,
    b: impl IntoIterator<Item = B>,
) -> f64 {
    let a: Vec<f64> = a.into_iter().map(|value| *value.borrow()).collect();
    let b: Vec<f64> = b.into_iter().map(|value| *value.borrow()).collect();
    assert_eq!(a.len(), b.len());
    largest(a.iter().zip(&b).map(|(a, b)| a - b))
}

/// The path of a file of `tests/data`.
pub fn data_file(name: &str) -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    root.join("../data").join(name)
}

/// What a file of `tests/data` holds.
pub fn data(name: &str) -> Value {
    let text = std::fs::read_to_string(data_file(name)).unwrap();
    serde_json::from_str(&text).unwrap()
}

pub fn numbers(list: &Value) -> Vec<f64> {
    let list = list.as_array().unwrap().iter();
    list.map(|value| value.as_f64().unwrap()).collect()
}

/// Keys of a scene of so many bodies, unless they say how many.
pub fn sized(keys: &str, sites: usize) -> String {
    match keys.contains("sites =") {
        true => keys.to_owned(),
        false => format!("sites = {sites}\n{keys}"),
    }
}

/// Slope of the line through points `(x, y)`, by least squares.
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let products = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
    products / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

/// Asserts that a number is a known one to within an error.
#[track_caller]
pub fn near(found: f64, known: f64, most: f64, case: impl std::fmt::Debug) {
    let off = (found - known).abs();
    assert!(off <= most, "{case:?}: {found} is {off:e} off {known}");
}

/// Asserts that a number is in a range.
#[track_caller]
pub fn within(
    found: f64,
    range: impl std::ops::RangeBounds<f64> + std::fmt::Debug,
    case: impl std::fmt::Debug,
) {
    assert!(
        range.contains(&found),
        "{case:?}: {found:e}, not in {range:?}"
    );
}
