//! Fields in files of named arrays, and in arrays of three dimensions.

use std::fs;

use ndarray::{Array2, Array3, ShapeBuilder};
use test_support::made::{open, values};
use test_support::netcdf::netcdf;
use test_support::place::Place;
use wavecascade::field::{OpenOptions, inspect};
use wavecascade::{Error, Field};

use crate::read::{beside, options};

/// Any two dimensions are times and sites, the third is taken at one index: from either order of samples, decoded or in place, in
/// memory or in a scratch file.
#[test]
fn val_identity_any_two_dimensions_are_times_and_sites() {
    let shape = (60, 4, 700);
    let of = |(n, h, j): (usize, usize, usize)| {
        f64::from(((n * shape.1 + h) * shape.2 + j) as u16 as i16)
    };
    let place = Place::new();
    let rows = Array3::from_shape_fn(shape, of);
    ndarray_npy::write_npy(place.path("rows.npy"), &rows).unwrap();
    let columns = Array3::from_shape_fn(shape.f(), of);
    ndarray_npy::write_npy(place.path("columns.npy"), &columns).unwrap();
    let lengths = format!("time={} y={} x={}", shape.0, shape.1, shape.2);
    place.write("a.nc", netcdf(&format!("{lengths}; v(time,y,x) i2 0:1")));
    let expected = rows.mapv(|v| v as i64 as i16);
    assert_eq!(expected.mapv(f64::from), rows);
    let axes = ["time", "y", "x"];
    for name in ["rows.npy", "columns.npy", "a.nc"] {
        for (times, sites) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            let at = 3 - times - sites;
            let kept = rows.index_axis(ndarray::Axis(at), 2);
            let kept = if times < sites {
                kept
            } else {
                kept.reversed_axes()
            };
            let named = |axis: usize| match (name, axis) {
                ("a.nc", axis) => axes[axis].to_owned(),
                (_, axis) => axis.to_string(),
            };
            for more in ["", " read=copy", " memory=2000000"] {
                let words = format!(
                    "time-dim={} space-dim={} at={}=#2{more}",
                    named(times),
                    named(sites),
                    named(at)
                );
                let field = Field::open(place.path(name), &options(&words));
                let field = field.unwrap_or_else(|error| panic!("{name} {words}: {error}"));
                assert_eq!(values(&field), kept, "{name} {words}");
                let mut block = vec![0.0; 2 * kept.ncols()];
                field.read_site_major(1..3, 0..kept.ncols(), &mut block);
                let expected = kept.slice(ndarray::s![1..3, ..]);
                assert!(block.iter().eq(expected.t().iter()), "{name} {words}");
            }
        }
    }
    for words in ["", "at=y=4", "at=y=1~mm", "at=z=0", "at=time=0"] {
        let refused = Field::open(place.path("rows.npy"), &options(words));
        assert!(matches!(refused, Err(Error::Input { .. })), "{words}");
    }
    // Dimensions of one index need no label.
    let single = Array3::from_shape_fn((5, 1, 4), |(n, _, j)| (10 * n + j) as f64);
    ndarray_npy::write_npy(place.path("b.npy"), &single).unwrap();
    let expected = Array2::from_shape_fn((5, 4), |(n, j)| (10 * n + j) as f64);
    assert_eq!(values(&open(&place, "b.npy")), expected);
}

#[cfg(feature = "zarr")]
#[test]
fn val_peer_xarray_stores_are_directories() {
    let hashes = [2, 3].map(|version| {
        let path = beside(&format!(
            "crates/formats/tests/files/zarr/xarray{version}.zarr"
        ));
        let field = Field::open(&path, &OpenOptions::default()).unwrap();
        assert!(field.file_state().is_none());
        let found = inspect(&path, &OpenOptions::default()).unwrap();
        assert_eq!(found.format, "a Zarr store");
        let packed = Field::open(&path, &options("variable=packed")).unwrap();
        for (packed, value) in values(&packed).iter().zip(values(&field)) {
            assert!((packed - value).abs() <= 5.1e-4 || packed.is_nan() && value.is_nan());
        }
        field.content_hash.unwrap()
    });
    assert_eq!(hashes[0].len(), 64);
    assert_ne!(hashes[0], hashes[1]);
}

#[test]
fn every_file_of_a_peer_is_listed_and_read_or_asked_about() {
    let mut read = 0;
    for folder in [
        "hdf5", "lammps", "mat", "miniseed", "netcdf3", "segy", "tdms", "uff",
    ] {
        for entry in fs::read_dir(beside("crates/formats/tests/files").join(folder)).unwrap() {
            let path = entry.unwrap().path();
            // Those with gaps, or in which atoms are lost, are refused as a whole.
            let name = path.file_name().unwrap().to_str().unwrap();
            if name.ends_with(".json")
                || ["gap.", "overlap.", "lost."]
                    .iter()
                    .any(|of| name.starts_with(of))
            {
                continue;
            }
            let found = inspect(&path, &OpenOptions::default()).unwrap();
            assert!(!found.variables.is_empty(), "{name}");
            match found.field {
                Ok(field) => {
                    let _all = values(&field);
                    read += 1;
                }
                Err(Error::Input { .. }) => (),
                Err(error) => panic!("{name}: {error}"),
            }
        }
    }
    assert!(read >= 12, "{read}");
}
