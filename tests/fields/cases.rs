//! Small files beside the repository on which readers fell short, and what is right for them.

use std::path::Path;

use ndarray::Array2;
use test_support::changed;
use test_support::fields::reading;
use test_support::made::{axis, values};
use test_support::place::Place;
use wavecascade::Field;
use wavecascade::field::{At, Axis, Label, OpenOptions, Quantity, ReadMode};

use crate::{note, texts};

fn beside(name: &str) -> Field {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/input_formats");
    Field::open(folder.join(name), &OpenOptions::default()).unwrap()
}

/// What `beside.py` wrote with h5py and SciPy.
#[test]
fn val_peer_rates_and_units_beside_the_samples() {
    let expected = Array2::from_shape_fn((6, 2), |(n, j)| (2 * n + j) as f64);
    for (name, unit) in [
        ("beside.h5", Some("mm")),
        ("beside.mat", None),
        ("beside73.mat", None),
    ] {
        let field = beside(name);
        assert_eq!(values(&field), expected, "{name}");
        assert_eq!(field.time, axis(1e-5, Some("s")), "{name}");
        let space = Axis {
            origin: 0.0,
            step: 0.5,
            unit: unit.map(String::from),
        };
        assert_eq!(field.space, space, "{name}");
        assert_eq!(field.unit.as_deref(), Some("mm/s"));
        assert_eq!(field.quantity, Quantity::Velocity);
        let said: Vec<&str> = texts(&field);
        let said = said.join("\n");
        assert!(said.contains("fs` = 100000 is the sampling rate"), "{said}");
        assert!(said.contains("unit` = \"mm/s\" is the unit"), "{said}");
    }
    // What is stated comes first.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/input_formats");
    let options = OpenOptions {
        dt: Some(2.0.into()),
        unit: Some("m/s".into()),
        ..OpenOptions::default()
    };
    let field = Field::open(folder.join("beside.h5"), &options).unwrap();
    assert_eq!((field.time.step, field.unit.as_deref()), (2.0, Some("m/s")));
}

fn at(dimension: &str, label: &str) -> OpenOptions {
    OpenOptions {
        at: vec![At {
            dimension: dimension.into(),
            label: Label::parse(label).unwrap(),
        }],
        ..OpenOptions::default()
    }
}

#[test]
fn val_definition_a_slice_of_three_dimensions() {
    use ndarray::{Array3, Axis as D, ShapeBuilder};
    let place = Place::new();
    let of = |(n, h, j): (usize, usize, usize)| (100 * n + 10 * h + j) as f64;
    let rows = Array3::from_shape_fn((5, 3, 4), of);
    let columns = Array3::from_shape_fn((5, 3, 4).f(), of);
    for array in [&rows, &columns] {
        ndarray_npy::write_npy(place.path("a.npy"), array).unwrap();
        for (dimension, label, kept) in [
            ("y", "2", array.index_axis(D(1), 2)),
            ("y", "#1", array.index_axis(D(1), 1)),
            ("1", "#0", array.index_axis(D(1), 0)),
            ("x", "3", array.index_axis(D(2), 3)),
        ] {
            for read in [ReadMode::Map, ReadMode::Copy] {
                let options = changed(at(dimension, label), |it| it.read = read);
                let field = Field::open(place.path("a.npy"), &options).unwrap();
                assert_eq!(values(&field), kept, "{dimension}={label}");
                let mut out = vec![0.0; 2 * kept.ncols()];
                field.read_site_major(1..3, 0..kept.ncols(), &mut out);
                let expected = kept.slice(ndarray::s![1..3, ..]);
                assert!(out.iter().eq(expected.t().iter()), "{dimension}={label}");
            }
        }
        let fault = |options: &OpenOptions| match Field::open(place.path("a.npy"), options) {
            Err(wavecascade::Error::Input { fault, .. }) => fault,
            other => panic!("{other:?}"),
        };
        let further = fault(&OpenOptions::default()).to_string();
        assert!(further.contains("also along"), "{further}");
        for (dimension, label) in [("y", "3"), ("y", "1 mm"), ("z", "0"), ("time", "0")] {
            fault(&at(dimension, label));
        }
    }
    // Dimensions of one index need no label.
    let single = Array3::from_shape_fn((5, 1, 4), |(n, _, j)| (10 * n + j) as f64);
    ndarray_npy::write_npy(place.path("b.npy"), &single).unwrap();
    let field = Field::open(place.path("b.npy"), &OpenOptions::default()).unwrap();
    assert_eq!(values(&field), single.index_axis(D(1), 0));
}

#[test]
fn regress_what_a_reader_doubts_is_a_warning() {
    let place = Place::new();
    let frame = |step: usize| {
        let atoms = (0..4).map(|i| format!("{} {} {}\n", i + 1, 2 * i + 1, (step + i) % 3));
        format!(
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 1\n0 1\n\
             ITEM: ATOMS id x vx\n{}",
            atoms.collect::<String>()
        )
    };
    let frames: String = (0..9).map(frame).collect();
    place.write("a.lammpstrj", frames);
    let options = reading(|it| it.variable = Some("vx".into()));
    let field = Field::open(place.path("a.lammpstrj"), &options).unwrap();
    let doubt = note(&field, "remark").unwrap();
    assert!(doubt.is_doubtful, "{doubt:?}");
    assert!(doubt.text.contains("image flags"), "{doubt:?}");
}
