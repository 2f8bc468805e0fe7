//! `cascade filter` as a stranger meets it.

use std::fs;

use ndarray::Array2;
use test_support::place::Place;
use wavecascade::Field;
use wavecascade::field::OpenOptions;

fn read(place: &Place, name: &str) -> (Field, Array2<f64>) {
    let field = Field::open(place.path(name), &OpenOptions::default()).unwrap();
    let (times, sites) = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; times * sites];
    field.read_time_major(0..times, 0..sites, &mut values);
    let values = Array2::from_shape_vec((times, sites), values).unwrap();
    (field, values)
}

/// Waves towards +x, towards -x and nowhere are together the field, as are bands side by side; axes
/// and units stay.
#[test]
fn val_parts_are_together_the_field() {
    let place = Place::new();
    place.good(&[
        "simulate",
        "--sites",
        "40",
        "--material",
        "steel",
        "--shape",
        "sphere",
        "--radius",
        "9.5mm",
        "--striker-velocity",
        "1",
        "--samples",
        "300",
        "--out",
        "run.npz",
        "--quiet",
    ]);
    let (run, whole) = read(&place, "run.npz");
    let scale = whole.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let sum = |parts: &[&[&str]]| {
        let mut sum = Array2::zeros(whole.dim());
        for (i, part) in parts.iter().enumerate() {
            let name = format!("part{i}.npz");
            let words = [
                &["filter", "run.npz", "--force", "--quiet", "--out", &name][..],
                part,
            ]
            .concat();
            place.good(&words);
            let (field, values) = read(&place, &name);
            assert_eq!(
                (field.unit.as_deref(), field.time.unit.as_deref()),
                (Some("m/s"), Some("s"))
            );
            assert!((field.time.step / run.time.step - 1.0).abs() < 1e-12);
            assert!((field.space.step / run.space.step - 1.0).abs() < 1e-12);
            sum += &values;
        }
        let off = (&sum - &whole).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        off / scale
    };
    for parts in [
        &[
            &["--towards", "plus-x"][..],
            &["--towards", "minus-x"],
            &["--towards", "nowhere"],
        ][..],
        &[&["--frequency", ":10000"], &["--frequency", "10000.0001:"]],
        &[
            &["--wavenumber", "0:50", "--pad"],
            &["--wavenumber", "50.0001:", "--pad"],
        ],
    ] {
        let off = sum(parts);
        println!("{off:e}");
        assert!(off < 2e-15, "{parts:?}: {off:e}");
    }
    // An impact at site 0 runs towards +x.
    let said = place.good(&[
        "filter",
        "run.npz",
        "--towards",
        "plus-x",
        "--pad",
        "--out",
        "plus.npz",
    ]);
    let share = said.split_once(" %").unwrap().0.rsplit(' ').next().unwrap();
    let share: f64 = share.parse().unwrap();
    assert!((85.0..100.0).contains(&share), "{said}");
    let said = place.good(&[
        "filter", "run.npz", "--speed", "1:", "--json", "--out", "fast.npz",
    ]);
    assert!(said.contains("energy_after"), "{said}");
}

#[test]
fn what_cannot_be_is_said() {
    let place = Place::new();
    fs::write(place.path("field.csv"), "1,2,3\n4,nan,6\n2,8,9\n").unwrap();
    fs::write(place.path("good.csv"), "1,2,3\n4,5,6\n2,8,9\n").unwrap();
    fs::write(place.path("thesis.npz"), "mine").unwrap();
    for (words, code, named) in [
        (&["filter", "good.csv"][..], 2, "--frequency"),
        (
            &["filter", "good.csv", "--frequency", "3:1"],
            2,
            "--frequency",
        ),
        (&["filter", "good.csv", "--speed=-2:1"], 2, "speed"),
        (&["filter", "field.csv", "--frequency", "0:1"], 1, "finite"),
        (
            &[
                "filter",
                "good.csv",
                "--frequency",
                "0:1",
                "--out",
                "thesis.npz",
                "--force",
            ],
            2,
            "thesis.npz",
        ),
        (&["filter", "none.npy", "--frequency", "0:1"], 1, "none.npy"),
    ] {
        let output = place.run(words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        assert!(said.contains(named), "{words:?}: {said}");
    }
    assert_eq!(place.names().len(), 3, "nothing was written");
    place.good(&["filter", "good.csv", "--frequency", "0:1"]);
    let again = place.run(&["filter", "good.csv", "--frequency", "0:1"]);
    assert_eq!(
        again.status.code(),
        Some(2),
        "what is there is not overwritten"
    );
}
