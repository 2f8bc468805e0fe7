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

#[test]
fn regress_several_shapes() {
    let container = opened("mixed.uff");
    // Part of a variable whose rows lie at uneven distances.
    let at = container.find("records/1").unwrap();
    let mut out = [0; 32];
    container.read(at, &[1..3, 4..6], &mut out).unwrap();
    let all = container.numbers(at).unwrap();
    let wanted = [all[17], all[18], all[30], all[31]].map(f64::to_ne_bytes);
    assert_eq!(out, wanted.concat()[..]);
}

#[test]
fn regress_nodes_of_data_set_2411() {
    let mut bytes = b"    -1\n  2411\n".to_vec();
    for (node, z) in [(3, "-1.0D-01"), (4, "2.5D+00")] {
        let line = format!(
            "{node:10}{:10}{:10}{:10}\n{:>25}{:>25}{z:>25}\n",
            0, 0, 1, "0.0D+00", "1.0D+00"
        );
        bytes.extend(line.bytes());
    }
    bytes.extend(b"    -1\n");
    bytes.extend(file("single.uff"));
    let container = open_bytes(bytes).unwrap();
    let records = container.find("records").unwrap();
    let z = container.find("z").unwrap();
    let coordinate = &container.variables[records].dimensions[0].coordinate;
    assert_eq!(*coordinate, Some(Coordinate::Listed(z)));
    assert_eq!(container.numbers(z).unwrap(), [-0.1, 2.5]);
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

/// Records of one unit are one variable, whatever the type of their numbers; what differs is named.
#[test]
fn val_definition_records_that_differ() {
    let record = |count| ascii(count, false, 1.0);
    let single = record(7).replacen("         4         7", "         2         7", 1);
    // Numbers of 13 columns.
    let single: String = single
        .split_inclusive('\n')
        .map(|line| match line.trim().parse::<f64>() {
            Ok(value) if line.contains('e') => format!("{value:13.5e}\n"),
            _ => line.to_owned(),
        })
        .collect();
    let mm = record(7).replacen("m/s ", "mm/s", 1);
    let labelled = record(7).replacen("   11    0    0    0 NONE", "   11    0    0    0 Vel.", 1);
    let text = [record(7), single, mm, labelled, record(6)].concat();
    let container = open_bytes(text.into_bytes()).unwrap();
    let at = container.find("records/1").unwrap();
    assert_eq!(container.variables[at].shape(), [3, 7]);
    let wanted = (0..7).map(|i| 7.0 + f64::from(i) / 8.0);
    assert!(
        wanted
            .cycle()
            .zip(container.numbers(at).unwrap())
            .all(|(a, b)| a == b)
    );
    let remarks = &container.remarks;
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert_eq!(remarks[0].variable, Some(at));
    let text = &remarks[0].text;
    for part in [
        "3 (\"name\") at node 7 (unit mm/s, not m/s); 5 (\"name\") at node 7 (number of values 6, not 7);",
        "a node that has one already: 2 (\"name\") at node 7; 4 (\"name\") at node 7;",
        "label than \"\" that are taken with the others: 4 (\"name\") at node 7: label \"Vel.\"",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

/// A record with other codes in its header: of the function, the direction, the abscissa, the ordinate.
fn coded([function, direction, abscissa, ordinate]: [i64; 4], node: i64) -> String {
    ascii(7, false, 1.0)
        .replacen("    1         0", &format!("{function:5}         0"), 1)
        .replacen("         7   3", &format!("{node:10}{direction:4}"), 1)
        .replacen("        17    0", &format!("{abscissa:10}    0"), 1)
        .replacen("        11    0", &format!("{ordinate:10}    0"), 1)
}

#[test]
fn val_definition_types_of_functions_and_ordinates() {
    let first = |codes| open_bytes(coded(codes, 7).into_bytes()).unwrap().variables[0].clone();
    for (ordinate, quantity) in [
        (8, Some("displacement")),
        (9, Some("force")),
        (11, Some("velocity")),
        (12, Some("acceleration")),
        (13, Some("force")),
        (0, None),
        (15, None),
    ] {
        let found = first([1, 3, 17, ordinate]);
        assert_eq!(
            found.attributes.text("standard_name"),
            quantity,
            "{ordinate}"
        );
        assert!(found.sample_type.number().is_some());
    }
    // A frequency response, spectra, a correlation, a response over frequency.
    for (function, abscissa) in [(4, 18), (2, 18), (9, 18), (7, 17), (1, 18), (0, 18)] {
        let found = first([function, 3, abscissa, 11]).sample_type;
        assert_eq!(found.number(), None, "{function} {abscissa}");
        assert!(
            found
                .way_out()
                .is_some_and(|way| way.contains("function type 1"))
        );
    }
}

/// One of twelve records that does not belong to the others is said.
#[test]
fn val_definition_one_record_of_twelve() {
    for (codes, node, said) in [
        ([1, 3, 17, 11], 5, None),
        (
            [4, 3, 17, 11],
            5,
            Some("5 (\"name\") at node 5 (function type 4, not 1)"),
        ),
        ([1, 3, 18, 11], 5, Some("type of the abscissa 18, not 17")),
        ([1, 3, 17, 12], 5, Some("data of type 12, not 11")),
        ([1, 2, 17, 11], 5, Some("direction 2, not 3")),
        ([1, -3, 17, 11], 5, Some("direction -3, not 3")),
        (
            [1, 3, 17, 11],
            4,
            Some("a node that has one already: 5 (\"name\") at node 4"),
        ),
    ] {
        let one = |i: i64| match i {
            5 => coded(codes, node),
            _ => coded([1, 3, 17, 11], i),
        };
        let text: String = (1..=12).map(one).collect();
        let container = open_bytes(text.into_bytes()).unwrap();
        let texts: Vec<&str> = container
            .remarks
            .iter()
            .map(|remark| &*remark.text)
            .collect();
        match said {
            None => assert!(texts.is_empty(), "{texts:?}"),
            Some(said) => assert!(texts.concat().contains(said), "{texts:?}"),
        }
    }
}

#[test]
fn val_definition_binary_records_of_several_types() {
    let [little, single] = ["little.uff", "single.uff"].map(file);
    let rows = |bytes: Vec<u8>| {
        let container = open_bytes(bytes).unwrap();
        let at = |path: &str| {
            container
                .find(path)
                .map(|at| container.numbers(at).unwrap())
        };
        at("records").unwrap()
    };
    let first = rows(little.clone());
    let in_ascii = rows(file("ascii.uff"));
    let both = rows([little, file("ascii.uff")].concat());
    assert_eq!(both, [first, in_ascii].concat());
    assert!(!rows(single).is_empty());
}

/// Only the stated number of values belongs to a record.
#[test]
fn regress_a_last_line_that_is_filled_up() {
    let whole = ascii(6, false, 1.0);
    let head: String = whole.split_inclusive('\n').take(13).collect();
    let numbers: Vec<f64> = (0..6).map(|i| 6.0 + f64::from(i) / 8.0).collect();
    let line = |values: &[f64]| -> String {
        let values = values.iter().map(|value| format!("{value:20.11e}"));
        values.collect::<String>() + "\n"
    };
    let filled = [&numbers[..], &[0.0, 99.0]].concat();
    let text = format!("{head}{}{}    -1\n", line(&filled[..4]), line(&filled[4..]));
    let container = open_bytes(text.into_bytes()).unwrap();
    assert_eq!(values(&container, "records"), numbers);
    // A line of its own is more than was stated.
    let lines = [&numbers[..4], &numbers[4..], &[1.0]].map(line).concat();
    let text = format!("{head}{lines}    -1\n");
    assert!(open_bytes(text.into_bytes()).is_err());
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
