//! What other programs write is read as they meant it.
//!
//! `val_numpy_*`: bytes that NumPy 2.4.6 wrote on 2026-11-21 (`tests/input_formats/make.py`).

use std::path::Path;

use ndarray::{Array2, ShapeBuilder};
use ndarray_npy::write_npy;
use test_support::fields::reading;
use test_support::hostile::Folder;
use test_support::made::values;
use wavecascade::Field;
use wavecascade::field::{Layout, OpenOptions};

pub fn numpy_bytes(name: &str) -> Vec<u8> {
    let line = include_str!("../input_formats/numpy.txt")
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))
        .unwrap_or_else(|| panic!("no file {name}"));
    (0..line.len() / 2)
        .map(|i| u8::from_str_radix(&line[2 * i..2 * i + 2], 16).unwrap())
        .collect()
}

fn open(path: &Path) -> Field {
    Field::open(path, &OpenOptions::default()).unwrap()
}

fn site_major(field: &Field) -> Array2<f64> {
    let (n, m) = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; n * m];
    field.read_site_major(0..n, 0..m, &mut values);
    Array2::from_shape_vec((m, n), values).unwrap()
}

fn numpy_field(sample: &str) -> Array2<f64> {
    Array2::from_shape_fn((5, 3), |(n, j)| {
        let index = (3 * n + j) as f64;
        match sample.as_bytes()[0] {
            b'b' => index % 2.0,
            b'u' => index,
            _ => index - 7.0,
        }
    })
}

const SAMPLES: [&str; 12] = [
    "f8", "f4", "f2", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1",
];

#[test]
fn val_numpy_every_sample_type_byte_order_and_memory_order() {
    let folder = Folder::new();
    for sample in SAMPLES {
        for order in ["little", "big"] {
            for memory in ["C", "F"] {
                let name = format!("{sample}-{order}-{memory}");
                let path = folder.write("field.npy", numpy_bytes(&name));
                let expected = numpy_field(sample);
                let field = open(&path);
                assert_eq!(values(&field), expected, "{name}");
                assert_eq!(site_major(&field), expected.t(), "{name}");

                let options = reading(|it| it.layout = Some(Layout::SiteTime));
                let transposed = Field::open(&path, &options).unwrap();
                assert_eq!((transposed.n_times(), transposed.n_sites()), (3, 5));
                assert_eq!(values(&transposed), expected.t(), "{name}, site-time");
                assert_eq!(site_major(&transposed), expected, "{name}, site-time");
            }
        }
    }
}

#[test]
fn blocks_are_the_same_from_every_order() {
    let values = Array2::from_shape_fn((83, 37), |(n, j)| (100 * n + j) as f64);
    let folder = Folder::new();
    let path = folder.path().join("field.npy");
    let transposed = Array2::from_shape_fn((83, 37).f(), |at| values[at]);
    write_npy(&path, &transposed).unwrap();
    let mapped = open(&path);
    let fields = [
        Field::from_array(values.clone()),
        Field::from_array(transposed),
        mapped,
    ];
    for (times, sites) in [
        (0..83, 0..37),
        (1..2, 0..37),
        (5..80, 36..37),
        (9..74, 3..20),
        (4..4, 1..3),
    ] {
        let block = values.slice(ndarray::s![times.clone(), sites.clone()]);
        for field in &fields {
            let mut out = vec![f64::NAN; block.len()];
            field.read_time_major(times.clone(), sites.clone(), &mut out);
            assert!(out.iter().eq(block.iter()), "{times:?} {sites:?}");
            field.read_site_major(times.clone(), sites.clone(), &mut out);
            assert!(out.iter().eq(block.t().iter()), "{times:?} {sites:?}");
        }
    }
}

#[test]
fn an_array_that_is_a_view_of_another_keeps_its_values() {
    let wide = Array2::from_shape_fn((6, 10), |(n, j)| (10 * n + j) as f64);
    let part = wide.clone().slice_move(ndarray::s![1..5;-1, 2..9;3]);
    let expected = part.clone();
    assert_eq!(values(&Field::from_array(part)), expected);
    let rows = wide.clone().slice_move(ndarray::s![2..4, ..]);
    assert_eq!(
        values(&Field::from_array(rows)),
        wide.slice(ndarray::s![2..4, ..])
    );
}

#[test]
fn the_hash_is_that_of_the_bytes() {
    let folder = Folder::new();
    let bytes = numpy_bytes("f8-little-C");
    let path = folder.write("field.npy", &bytes);
    let expected = blake3::hash(&bytes).to_hex().to_string();
    assert_eq!(open(&path).content_hash, Some(expected));
    let options = reading(|it| it.hash = false);
    let unhashed = Field::open(&path, &options).unwrap();
    assert_eq!(unhashed.content_hash, None);
    // Read where it lies, and as text that was parsed.
    let text = b"1,-2.5\n3e-3,4\n5,600\n";
    let parsed = Field::open(folder.write("field.csv", text), &options).unwrap();
    for (field, bytes) in [(&unhashed, &bytes[..]), (&parsed, text)] {
        let expected = blake3::hash(bytes).to_hex().to_string();
        for in_use in [false, true] {
            let found = field.file_hash(in_use).unwrap();
            assert_eq!(found.as_ref(), Some(&expected), "in use: {in_use}");
        }
    }
    let made = Field::from_array(ndarray::array![[1.0, 2.0]]);
    assert_eq!(made.file_hash(true).unwrap(), None);
}
