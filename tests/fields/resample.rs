//! Samples at uneven coordinates.
//!
//! `val_scipy_*`: `data/interpolation.json`, made by `data/interpolation.py` with SciPy 1.17.1 on 2026-11-25.
//! `val_closed_form_*`: sines, whose interpolated amplitudes are known.

use ndarray::Array2;
use serde_json::Value;
use test_support::changed;
use test_support::fields::reading;
use test_support::made::{fault, savez, values};
use test_support::netcdf::netcdf;
use test_support::place::Place;
use wavecascade::Field;
use wavecascade::error::InputFault;
use wavecascade::field::{Interpolation, OpenOptions, Resample};

pub fn reference() -> Value {
    serde_json::from_str(include_str!("../data/interpolation.json")).unwrap()
}

pub fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.map(|one| one.as_f64().unwrap()).collect()
}

pub fn by(method: Interpolation) -> OpenOptions {
    reading(|it| it.resample = Resample::both(method))
}

/// The index of the sample that is farthest from its place, and by how much of a step.
fn resampled(field: &Field) -> Option<(usize, f64)> {
    let said = field.notes.iter().find(|note| note.code == "resampled")?;
    let (_, said) = said.text.split_once("even time coordinates")?;
    let (_, said) = said.split_once("index ")?;
    let mut words = said.split(' ');
    Some((words.next()?.parse().ok()?, words.nth(1)?.parse().ok()?))
}

/// Numbers as `netcdf` reads them.
fn listed(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|v| format!("{v:e}")).collect();
    format!("[{}]", numbers.join(","))
}

/// The file under three formats: times uneven, two sites of which the second is twice the first.
fn save_times(place: &Place, nodes: &[f64], samples: &[f64]) -> [&'static str; 3] {
    let field = Array2::from_shape_fn((nodes.len(), 2), |(n, j)| samples[n] * (1 + j) as f64);
    savez(place, "v.npz", ("v", &field), &[("t", nodes.to_vec())]);
    let rows = field.rows().into_iter().zip(nodes);
    let rows: String = rows
        .map(|(row, t)| format!("{t:.17e},{:.17e},{:.17e}\n", row[0], row[1]))
        .collect();
    place.write("v.csv", format!("time,a,b\n{rows}"));
    let file = format!(
        "time={} site=2; time(time) f8 {} units=s; v(time,site) f8 {}",
        nodes.len(),
        listed(nodes),
        listed(&field.into_iter().collect::<Vec<_>>())
    );
    place.write("v.nc", netcdf(&file));
    ["v.npz", "v.csv", "v.nc"]
}

#[test]
fn val_scipy_times_and_sites_are_resampled() {
    let mut worst: f64 = 0.0;
    for case in reference()["resampled"].as_array().unwrap() {
        let (nodes, samples) = (numbers(&case["nodes"]), numbers(&case["values"]));
        if nodes.len() < 3 {
            continue;
        }
        let place = Place::new();
        for method in Interpolation::ALL {
            let expected = numbers(&case[method.name()]);
            for name in save_times(&place, &nodes, &samples) {
                let field = Field::open(place.path(name), &by(method)).unwrap();
                let found = values(&field);
                let step = (nodes[nodes.len() - 1] - nodes[0]) / (nodes.len() - 1) as f64;
                assert_eq!(field.time.origin, nodes[0], "{name}");
                assert_eq!(field.time.step, step, "{name}");
                for (row, expected) in found.rows().into_iter().zip(&expected) {
                    worst = worst.max((row[0] - expected).abs());
                    assert_eq!(row[1], 2.0 * row[0]);
                }
                let (index, share) = resampled(&field).unwrap();
                let shift = (nodes[index] - nodes[0]) / step - index as f64;
                // Two digits are said.
                assert!((share - shift).abs() <= 0.051 * shift.abs());
                // What is refused without a method.
                match fault(&place, name, &OpenOptions::default()) {
                    InputFault::UnevenAxis { axis, .. } => assert_eq!(axis, "time"),
                    other => assert!(other.to_string().starts_with("line "), "{other}"),
                }
            }
            let both = [&samples[..], &samples].concat();
            let file = format!(
                "time=2 x={}; x(x) f8 {} units=mm; v(time,x) f8 {}",
                nodes.len(),
                listed(&nodes),
                listed(&both)
            );
            place.write("x.nc", netcdf(&file));
            let along = |time, space| reading(|it| it.resample = Resample { time, space });
            let field = Field::open(place.path("x.nc"), &along(None, Some(method))).unwrap();
            for row in values(&field).rows() {
                for (found, expected) in row.iter().zip(&expected) {
                    worst = worst.max((found - expected).abs());
                }
            }
            let found = fault(&place, "x.nc", &along(Some(method), None));
            assert!(matches!(
                found,
                InputFault::UnevenAxis { axis: "space", .. }
            ));
        }
    }
    assert!(worst < 4e-15 && worst > 0.0, "{worst:e}");
}

#[test]
fn val_identity_memory_does_not_change_a_bit() {
    let place = Place::new();
    let nodes: Vec<f64> = (0..3000u32)
        .map(|i| f64::from(i) + 0.3 * f64::from(i * i % 7) / 7.0)
        .collect();
    let field = Array2::from_shape_fn((3000, 9), |(n, j)| ((n * (j + 2)) as f64).sin());
    savez(&place, "v.npz", ("v", &field), &[("t", nodes)]);
    let open = |memory| {
        let options = changed(by(Interpolation::Cubic), |it| it.memory = memory);
        Field::open(place.path("v.npz"), &options)
    };
    let whole = values(&open(None).unwrap());
    // The field of 216 kB goes to a scratch file, a record at a time.
    assert_eq!(values(&open(Some(100_000)).unwrap()), whole);
    let error = open(Some(10_000)).unwrap_err().to_string();
    assert!(error.contains("46.88 KiB"), "{error}");
}

#[test]
fn val_definition_gaps_stay_gaps_of_their_own_length() {
    let place = Place::new();
    // Even but for the last step.
    let mut nodes: Vec<f64> = (0..40).map(f64::from).collect();
    nodes[39] = 40.5;
    let parabola = |t: f64| 0.25 * t * t - 3.0 * t + 1.0;
    let mut field = Array2::from_shape_fn((40, 2), |(n, _)| parabola(nodes[n]));
    field[[20, 0]] = f64::NAN;
    savez(&place, "v.npz", ("v", &field), &[("t", nodes)]);
    for method in [Interpolation::Linear, Interpolation::Cubic] {
        let field = Field::open(place.path("v.npz"), &by(method)).unwrap();
        let found = values(&field);
        let gaps = |j: usize| {
            (0..40)
                .filter(|&n| found[[n, j]].is_nan())
                .collect::<Vec<_>>()
        };
        // One place lies in each of the two steps beside the gap.
        assert_eq!((gaps(0), gaps(1)), (vec![19, 20], vec![]), "{method:?}");
        if method == Interpolation::Cubic {
            let exact = (0..40)
                .filter(|&n| n != 19 && n != 20)
                .all(|n| (found[[n, 0]] - parabola(field.time.at(n))).abs() < 1e-11);
            assert!(exact);
        }
    }
}

/// A sine at half the Nyquist frequency, half a step off its samples.
#[test]
fn val_closed_form_what_amplitudes_lose() {
    const N: usize = 400;
    let place = Place::new();
    // Steps of 1, but 1.5 in the middle: far from it and behind, places lie half a step before the nodes.
    let mut nodes: Vec<f64> = (0..N).map(|n| n as f64).collect();
    nodes.push(N as f64 + 0.5);
    let step = nodes[N] / N as f64;
    let omega = std::f64::consts::FRAC_PI_2;
    let field = Array2::from_shape_fn((N + 1, 2), |(n, j)| match j {
        0 => (omega * nodes[n]).cos(),
        _ => (omega * nodes[n]).sin(),
    });
    savez(&place, "v.npz", ("v", &field), &[("t", nodes.clone())]);
    for method in Interpolation::ALL {
        let field = Field::open(place.path("v.npz"), &by(method)).unwrap();
        let found = values(&field);
        let mut worst: f64 = 0.0;
        for n in 20..N - 20 {
            let place = n as f64 * step;
            let fraction = place - place.floor();
            let expected = method.error(fraction);
            let error = match method {
                Interpolation::Nearest => {
                    let (a, b) = (omega * place).sin_cos();
                    (found[[n, 0]] - b).hypot(found[[n, 1]] - a)
                }
                _ => 1.0 - found[[n, 0]].hypot(found[[n, 1]]),
            };
            worst = worst.max((error - expected).abs());
        }
        assert!(worst < 1e-9, "{method:?}: {worst:e}");
    }
    let error = Interpolation::ALL.map(|method| (method.error(0.5) * 1e4).round());
    assert_eq!(error, [7654.0, 2929.0, 277.0]);
}
