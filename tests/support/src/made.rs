//! Files as NumPy writes them, and what is read of them.

use std::fs;

use ndarray::{Array1, Array2};
use ndarray_npy::{NpzWriter, WritableElement};
use wavecascade::error::InputFault;
use wavecascade::field::{Axis, OpenOptions};
use wavecascade::{Error, Field};

use super::place::Place;

pub fn open(place: &Place, name: &str) -> Field {
    Field::open(place.path(name), &OpenOptions::default()).unwrap()
}

pub fn fault(place: &Place, name: &str, options: &OpenOptions) -> InputFault {
    match Field::open(place.path(name), options) {
        Err(Error::Input { fault, .. }) => fault,
        other => panic!("{other:?}"),
    }
}

pub fn values(field: &Field) -> Array2<f64> {
    let shape = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; shape.0 * shape.1];
    field.read_time_major(0..shape.0, 0..shape.1, &mut values);
    Array2::from_shape_vec(shape, values).unwrap()
}

pub fn in_one_line(said: &str) -> String {
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn axis(origin: f64, step: f64, unit: Option<&str>) -> Axis {
    Axis {
        origin,
        step,
        unit: unit.map(String::from),
    }
}

/// A pulse, without a site that rises.
pub fn pulse(times: usize, sites: usize) -> Array2<f64> {
    Array2::from_shape_fn((times, sites), |(n, j)| {
        let s = n as f64 - 2.0 * j as f64 - 12.0;
        (-(s / 4.0).powi(2)).exp() * (0.9 * s).sin()
    })
}

pub fn savez<T: WritableElement + Clone>(
    place: &Place,
    name: &str,
    field: (&str, &Array2<f64>),
    axes: &[(&str, Vec<T>)],
) {
    let mut archive = NpzWriter::new(fs::File::create(place.path(name)).unwrap());
    archive.add_array(field.0, field.1).unwrap();
    for (axis, values) in axes {
        archive
            .add_array(*axis, &Array1::from(values.clone()))
            .unwrap();
    }
    archive.finish().unwrap();
}

pub fn steps(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * step).collect()
}
