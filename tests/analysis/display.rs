//! How fine maps within the display limits are; what limits hold and leave out are rows of `said.txt`.

use std::f64::consts::TAU;

use ndarray::{Array2, ArrayView2, s};
use wavecascade::analyze::{Map, Reduction, Request};
use wavecascade::arrays::LargeArray;
use wavecascade::{Field, analyze};

/// Waves at bin m of frequency and of wavenumber with energies q^m, m = 1 .. `waves`.
fn geometric((times, sites): (usize, usize), q: f64, waves: usize) -> Field {
    let value = |(n, j): (usize, usize)| {
        let phase = n as f64 / times as f64 - j as f64 / sites as f64;
        let wave = |m: usize| q.powf(0.5 * m as f64) * (TAU * m as f64 * phase).cos();
        (1..=waves).map(wave).sum()
    };
    Field::from_array(Array2::from_shape_fn((times, sites), value))
}

/// The first row (column) of an array that a map holds, from its first coordinate and step.
fn first(low: f64, origin: f64, step: f64) -> usize {
    ((low - origin) / step + 0.5).round() as usize
}

/// Compares every cell with the block of the array that it stands for.
fn compare(map: &Map, array: ArrayView2<f64>, (y, dy): (f64, f64), (x, dx): (f64, f64)) {
    let (Reduction::Max { rows, columns } | Reduction::Extreme { rows, columns }) = map.reduction;
    let (top, left) = (first(map.y.low, y, dy), first(map.x.low, x, dx));
    for ((i, j), &cell) in map.values.indexed_iter() {
        let (row, column) = (top + i * rows, left + j * columns);
        let block = array.slice(s![
            row..(row + rows).min(array.nrows()),
            column..(column + columns).min(array.ncols())
        ]);
        let least = block.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = block.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let is_least = matches!(map.reduction, Reduction::Extreme { .. }) && -least > largest;
        let expected = if is_least { least } else { largest };
        assert_eq!(cell, expected as f32, "{}: {i} {j}", map.label);
        if let Some([low, high]) = &map.range {
            assert_eq!((low[[i, j]], high[[i, j]]), (least as f32, largest as f32));
        }
    }
}

/// Long, wide and small: the whole and the part within the limits, against the arrays themselves.
#[test]
fn maps_and_their_details_are_what_blocks_of_the_arrays_give() {
    for shape in [(20_000, 70), (300, 700), (200, 40)] {
        let field = geometric(shape, 0.9, 30);
        let (analysis, mut spectra) = analyze(&field, &Request::default()).unwrap();
        let axes = &analysis.axes;
        let [df, dk] = [axes.frequency[1], axes.wavenumber[1]];
        let signed = (axes.wavenumber_signed[0], dk);
        let mut samples = vec![0.0; shape.0 * shape.1];
        field.read_time_major(0..shape.0, 0..shape.1, &mut samples);
        let samples = Array2::from_shape_vec(shape, samples).unwrap();
        spectra.insert(LargeArray::SAMPLES, samples);
        for (array, values) in spectra {
            let map = &analysis.maps[&array];
            let [y, x] = array.axes().map(|axis| match axis {
                "frequency" => (0.0, df),
                "wavenumber" => (0.0, dk),
                "wavenumber_signed" => signed,
                _ => (0.0, 1.0),
            });
            compare(map, values.view(), y, x);
            if let Some(detail) = &map.detail {
                compare(detail, values.view(), y, x);
            }
            if array.axes()[0] == "frequency" {
                let detail = map.detail.as_ref().unwrap();
                assert!(detail.y.high < 0.7 * map.y.high);
                assert!(detail.values.nrows() <= 400 && detail.values.ncols() <= 300);
            }
        }
    }
}
