//! Estimates against what others find in the same records: a comparison a row of `peers.txt`.

use std::f64::consts::TAU;

use ndarray::Array2;
use serde_json::Value;
use test_support::estimate::{flat, seen};
use test_support::fields::{Congruential, stepped};
use test_support::worst;
use wavecascade::Field;

pub const DT: f64 = 0.25;
pub const DX: f64 = 0.5;

pub fn field(values: Array2<f64>) -> Field {
    stepped(values, DT, DX)
}

fn uniforms(seed: u64, count: usize) -> Vec<f64> {
    let mut random = Congruential(seed);
    (0..count).map(|_| random.uniform()).collect()
}

pub fn data(name: &str) -> Value {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");
    let text = std::fs::read_to_string(format!("{folder}/{name}")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// `NAME TIMES SITES`: records that the scripts under `data` make too.
pub fn record(words: &str) -> Field {
    let mut words = words.split(' ');
    let name = words.next().unwrap();
    let [times, sites] = [0; 2].map(|_| words.next().unwrap().parse::<usize>().unwrap());
    let each: Vec<Vec<f64>> = (1..5).map(|seed| uniforms(seed, 1003)).collect();
    let (a, b, common) = (&each[0], &each[1], uniforms(7, 1003));
    let [by_one, by_five] = [1, 5].map(|seed| uniforms(seed, times * sites));
    let gaps = data("gaps.json");
    let is_missing = |n: usize, j: usize| {
        let missing = gaps["missing"][j].as_array().unwrap();
        missing.iter().any(|place| place.as_u64() == Some(n as u64))
    };
    let (mut steep, mut walk) = (vec![0.0; 1003], vec![0.0; 1003]);
    for n in 4..1003 {
        let before = &steep[n - 4..n];
        steep[n] = b[n - 4] + 2.7607 * before[3] - 3.8106 * before[2] + 2.6535 * before[1]
            - 0.9238 * before[0];
    }
    for n in 0..1003 {
        walk[n] = a[..=n].iter().sum();
    }
    let values = Array2::from_shape_fn((times, sites), |(n, j)| {
        let (t, x) = (n as f64, j as f64);
        match (name, j) {
            ("noises", 0) => a[n],
            ("noises", 1) => steep[204 + n],
            ("noises", _) => each[2][n] + 0.7 * (TAU * 0.1225 * t + 0.3).cos(),
            ("follower", 0) => a[n + 3],
            ("follower", 1) => a[n] + 0.5 * b[n],
            ("follower", _) => b[n],
            ("squares", 0) => a[n] + 0.5 * a[n] * a[n],
            ("squares", _) => a[(n + times - 1) % times].powi(2) + 0.3 * b[n],
            ("gaps", _) if is_missing(n, j) => f64::NAN,
            ("gaps", _) => each[j][n] + common[n],
            ("waves", _) => {
                let back = 0.7 * (0.4 * DX * x + TAU * 1.1 * DT * t).cos() * (1.0 + 0.1 * DX * x);
                (0.9 * DX * x - TAU * 0.4 * DT * t).cos() + back + by_one[n * sites + j]
            }
            ("plane", _) => by_five[n * sites + j],
            ("steep", _) => 1e3 * (0.9 * t - 1.1 * x).cos() + by_five[n * sites + j],
            ("walk", _) => walk[j],
            _ => panic!("{name}"),
        }
    });
    field(values)
}

/// What they have for an array of ours, NaN where nothing. A column that they leave out is NaN in ours too.
fn expected(file: &Value, place: &str, ours: &Array2<f64>) -> Array2<f64> {
    if let Ok(number) = place.parse() {
        return Array2::from_elem(ours.dim(), number);
    }
    let place = format!("/{place}");
    let at = |place: &str| flat(file.pointer(place).unwrap_or(&Value::Null));
    let Some((list, _)) = place.split_once("/*") else {
        return Array2::from_shape_vec(ours.dim(), at(&place)).unwrap();
    };
    let count = file.pointer(list).unwrap().as_array().unwrap().len();
    let columns = (0..count).map(|j| at(&place.replace('*', &j.to_string())));
    if ours.ncols() == 1 {
        return Array2::from_shape_vec(ours.dim(), columns.flatten().collect()).unwrap();
    }
    let mut all = Array2::from_elem(ours.dim(), f64::NAN);
    assert_eq!(count, ours.ncols());
    for (j, theirs) in columns.enumerate() {
        if theirs.len() == 1 {
            assert!(ours.column(j).iter().all(|v| v.is_nan()), "{place}, {j}");
            continue;
        }
        all.column_mut(j).assign(&ndarray::Array1::from(theirs));
    }
    all
}

/// The rows of a section of a table, in their cells.
pub fn rows<'t>(table: &'t str, section: &str) -> impl Iterator<Item = Vec<&'t str>> {
    let (_, rest) = table.split_once(&format!("[{section}]\n")).unwrap();
    let rows = rest.lines().take_while(|line| !line.is_empty());
    let rows = rows.filter(|line| !line.starts_with('#'));
    rows.map(|row| row.split(" | ").collect())
}

/// Compares what the rows of a section of `peers.txt` name.
#[track_caller]
pub fn compare(section: &str) {
    for row in rows(include_str!("peers.txt"), section) {
        let &[file, made, words, name, place, how] = &row[..] else {
            panic!("{row:?}");
        };
        let file = data(file);
        let ours = seen(words, [&record(made)]).unwrap().array(name);
        let theirs = expected(&file, place, &ours);
        let of_phase = place.replace("biphase", "bicoherence");
        let weight = expected(&file, &of_phase.replace("phase", "coherence"), &ours);
        let (how, tolerance) = how.rsplit_once(' ').unwrap();
        let (which, how) = how.rsplit_once(' ').unwrap_or(("all", how));
        let last = ours.nrows() - 1;
        let cells = theirs.indexed_iter().filter(|((m, _), b)| {
            let is_end = *m == 0 || *m == last;
            !(b.is_nan() || is_end && which != "all")
        });
        let all = cells.clone().count();
        let cells = cells.filter(|(cell, _)| which != "stated" || !ours[*cell].is_nan());
        assert!(10 * cells.clone().count() >= 9 * all && all > 0, "{row:?}");
        let errors = cells.map(|(cell, b)| {
            let off = (ours[cell] - b).abs();
            let known = theirs.column(cell.1).into_iter().filter(|b| !b.is_nan());
            match how {
                "relative" | "median" => off / b.abs(),
                "largest" => off / worst(known.map(|b| b.abs())),
                "peak" => off / worst(theirs.iter().filter(|b| !b.is_nan()).map(|b| b.abs())),
                "absolute" => off,
                // The phase of nothing is rounding.
                "angle" if weight[cell] > 1e-3 => (off / 2.0).sin().abs(),
                "angle" => 0.0,
                other => panic!("{other}"),
            }
        });
        let mut errors: Vec<f64> = errors.collect();
        errors.sort_by(f64::total_cmp);
        let place_of = if how == "median" { 2 } else { 1 };
        let error = errors[(errors.len() - 1) / place_of];
        assert!(error < tolerance.parse().unwrap(), "{row:?}: {error:e}");
    }
}
