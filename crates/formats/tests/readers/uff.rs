//! Universal files against pyuff (`make_uff.py`).

use serde_json::Value as Json;
use std::sync::Arc;
use wavecascade_formats::{Container, Coordinate, Format, Options, Result, open};

use super::common::{self, values};

fn file(name: &str) -> Vec<u8> {
    common::file("uff", name)
}

fn expected() -> serde_json::Map<String, Json> {
    serde_json::from_slice(&file("expected.json")).unwrap()
}

fn open_bytes(bytes: Vec<u8>) -> Result<Container> {
    assert_eq!(Format::detect("data", &bytes), Some(Format::Uff));
    open(Format::Uff, Arc::new(bytes), &Options::default())
}

fn opened(name: &str) -> Container {
    open_bytes(file(name)).unwrap()
}

fn numbers(json: &Json) -> Vec<f64> {
    let values = json.as_array().unwrap();
    values.iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn val_pyuff_functions() {
    for (name, functions) in expected() {
        let container = opened(&name);
        let is_record = |path: &str| path.starts_with("/records");
        let mut rows: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for (at, variable) in container.variables.iter().enumerate() {
            if !is_record(&variable.path) || variable.sample_type.number().is_none() {
                continue;
            }
            let abscissa = &variable.dimensions[1];
            let x: Vec<f64> = match abscissa.coordinate.as_ref().unwrap() {
                Coordinate::Even { origin, step, .. } => (0..abscissa.len)
                    .map(|i| origin + i as f64 * step)
                    .collect(),
                Coordinate::Listed(at) => container.numbers(*at).unwrap(),
            };
            assert_eq!(variable.attributes.text("units"), Some("m/s"));
            let all = container.numbers(at).unwrap();
            rows.extend(all.chunks(x.len()).map(|row| (row.to_vec(), x.clone())));
        }
        let functions = functions.as_array().unwrap();
        assert_eq!(rows.len(), functions.len(), "{name}");
        for (row, function) in rows.iter().zip(functions) {
            assert_eq!(row.0, numbers(&function["data"]), "{name}");
            assert_eq!(row.1, numbers(&function["x"]), "{name}");
        }
    }
}

/// A data set 58 in ASCII with even or uneven abscissas.
fn ascii(count: usize, uneven: bool, first: f64) -> String {
    let mut text = format!(
        "    -1\n    58\nname\nNONE\nNONE\nNONE\nNONE\n{:5}{:10}{:5}{:10} {:<10}{:10}{:4} {:<10}{:10}{:4}\n",
        1, 0, 0, 0, "NONE", 7, 3, "NONE", 1, 3
    );
    let even = usize::from(!uneven);
    text += &format!(
        "{:10}{count:10}{even:10}{:13.5e}{:13.5e}{:13.5e}\n",
        4, 0.0, 1.0, 0.0
    );
    for (kind, unit) in [(17, "s"), (11, "m/s"), (0, "NONE"), (0, "NONE")] {
        text += &format!("{kind:10}{:5}{:5}{:5} {:<20} {unit:<20}\n", 0, 0, 0, "NONE");
    }
    for i in 0..count {
        if uneven {
            text += &format!("{:13.4e}", first * (i * i + 1) as f64);
        }
        text += &format!("{:20.11e}\n", count as f64 + i as f64 / 8.0);
    }
    text + "    -1\n"
}

/// Shapes in any order: functions of one are one variable, in the order of the file.
#[test]
fn regress_functions_of_many_shapes() {
    const SHAPES: usize = 200;
    let shapes = |uneven: bool| (1..=SHAPES).map(move |count| ascii(count, uneven, 1.0));
    let mut text: String = (0..2)
        .flat_map(|_| shapes(false).chain(shapes(true)))
        .collect();
    // Zeros of both signs are one abscissa; another scale is another one.
    text += &(ascii(3, true, -0.0) + &ascii(3, true, 0.0) + &ascii(3, true, 2.0));
    let container = open_bytes(text.into_bytes()).unwrap();
    let records: Vec<_> = container
        .variables
        .iter()
        .filter(|v| v.path.starts_with("/records/"))
        .collect();
    let shapes: Vec<Vec<u64>> = records.iter().map(|v| v.shape()).collect();
    let each = (1..=SHAPES as u64).map(|count| vec![2, count]);
    let mut expected: Vec<Vec<u64>> = each.clone().chain(each).collect();
    expected.extend([vec![2, 3], vec![1, 3]]);
    assert_eq!(shapes, expected);
    assert_eq!(
        values(&container, "/records/3"),
        [3.0, 3.125, 3.25, 3.0, 3.125, 3.25]
    );
    let last = format!("/abscissa/{}", 2 * SHAPES + 2);
    assert_eq!(values(&container, &last), [2.0, 4.0, 10.0]);
}
