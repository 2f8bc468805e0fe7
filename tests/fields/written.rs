//! Fields that the program writes, read back: the same bits, axes and units.

use ndarray::Array2;
use test_support::fields::reading;
use test_support::made::{axis, open, values};
use test_support::place::Place;
use wavecascade::arrays::Precision;
use wavecascade::field::{Axis, Quantity};
use wavecascade::report::FieldFile;
use wavecascade::{Error, Field};

const FORMATS: [&str; 4] = ["nc", "npz", "npy", "csv"];

/// Samples of many sizes, with a gap, a negative zero and an infinity.
fn samples(times: usize, sites: usize) -> Array2<f64> {
    Array2::from_shape_fn((times, sites), |(n, j)| match (n * sites + j) % 97 {
        13 => f64::NAN,
        29 => -0.0,
        31 => f64::INFINITY,
        // What NetCDF leaves in floats that were never written.
        37 => 9.969_209_968_386_869e36,
        k => (k as f64 - 40.0) * 10f64.powi((n % 41) as i32 - 20) / 3.0,
    })
}

fn assert_same_samples(found: &Field, expected: &Array2<f64>, what: &str) {
    let found = values(found);
    assert_eq!(found.dim(), expected.dim(), "{what}");
    for (index, (a, b)) in found.iter().zip(expected).enumerate() {
        let is_same = a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
        assert!(is_same, "{what}, sample {index}: {a:e} instead of {b:e}");
    }
}

/// An archive holds coordinates alone, from which a step is known up to rounding.
fn assert_same_axis(found: &Axis, expected: &Axis, format: &str) {
    let is_exact = format != "npz";
    let deviation = (found.step / expected.step - 1.0).abs();
    let bound = if is_exact { 0.0 } else { 1e-12 };
    assert!(deviation <= bound, "{format}: {found:?}, {expected:?}");
    assert_eq!(found.origin, expected.origin, "{format}");
    assert_eq!(found.unit, expected.unit, "{format}");
}

#[test]
fn regress_what_is_written_is_read_back() {
    let place = Place::new();
    let counted = axis(0.0, 1.0, None);
    let cases = [
        ((1, 1), counted.clone(), counted.clone(), None),
        (
            (13, 29),
            axis(-0.3, 1.0 / 3.0, None),
            counted.clone(),
            Some("m/s"),
        ),
        (
            (31, 7),
            axis(5.0, 0.01, Some("ms")),
            axis(-2.5, 1.0 / 7.0, Some("mm")),
            Some("\u{b5}m/s"),
        ),
        (
            (9, 5000),
            axis(0.0, 1e-5, Some("s")),
            axis(0.0, 0.002, Some("m")),
            Some("(m/s)\u{b7}\u{221a}Hz"),
        ),
    ];
    for (n, ((times, sites), time, space, unit)) in cases.into_iter().enumerate() {
        for quantity in [Quantity::Velocity, Quantity::StrainRate] {
            let expected = samples(times, sites);
            let mut field = Field::from_array(expected.clone());
            (field.time, field.space) = (time.clone(), space.clone());
            (field.quantity, field.unit) = (quantity, unit.map(str::to_owned));
            field.name = "sp\u{e9}cimen \u{3b1}".into();
            field.dispersion = Some("c*abs(k); c=340".into());
            for format in FORMATS {
                let name = format!("{n}-{}.{format}", quantity.name());
                FieldFile::write(&place.path(&name), false, &field).unwrap();
                let found = open(&place, &name);
                assert_same_samples(&found, &expected, &name);
                assert_same_axis(&found.time, &time, format);
                assert_same_axis(&found.space, &space, format);
                assert_eq!(found.unit.as_deref(), unit, "{name}");
                assert_eq!(found.quantity, quantity, "{name}");
                assert_eq!(found.dispersion, field.dispersion, "{name}");
                assert_eq!(found.precision(), Precision::F64, "{name}");
                // Strain rates in a unit of velocity are doubted.
                let is_doubted = found.notes.iter().any(|note| note.is_doubtful);
                assert!(!is_doubted || quantity == Quantity::StrainRate, "{name}");
            }
        }
    }
}

/// Larger than a block, with contiguous profiles and with contiguous records.
#[test]
fn regress_blocks_of_both_orders_are_written_in_their_place() {
    let place = Place::new();
    for (times, sites) in [(1500, 1100), (5, 300_000), (300_000, 5)] {
        let expected = samples(times, sites);
        for values in [
            expected.clone(),
            expected
                .t()
                .as_standard_layout()
                .into_owned()
                .reversed_axes(),
        ] {
            let field = Field::from_array(values);
            for format in FORMATS {
                let name = format!("blocks.{format}");
                FieldFile::write(&place.path(&name), true, &field).unwrap();
                let what = format!("{name} {times} x {sites}");
                assert_same_samples(&open(&place, &name), &expected, &what);
            }
        }
    }
}

/// In either byte order; a table has only digits, which give the same numbers.
#[test]
fn regress_single_precision_stays() {
    let place = Place::new();
    let singles = samples(40, 30).mapv(|v| v as f32);
    place.save("little.npy", &singles);
    let mut big = std::fs::read(place.path("little.npy")).unwrap();
    let start = big.len() - 40 * 30 * 4;
    let order = big.windows(3).position(|text| text == b"<f4").unwrap();
    big[order] = b'>';
    big[start..].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    place.write("big.npy", big);
    let expected = singles.mapv(f64::from);
    for from in ["little.npy", "big.npy"] {
        let field = open(&place, from);
        assert_eq!(field.precision(), Precision::F32);
        for format in FORMATS {
            let name = format!("out.{format}");
            FieldFile::write(&place.path(&name), true, &field).unwrap();
            let found = open(&place, &name);
            assert_same_samples(&found, &expected, &name);
            if format != "csv" {
                assert_eq!(found.precision(), Precision::F32, "{name}");
            }
        }
    }
    let length = |name| std::fs::metadata(place.path(name)).unwrap().len();
    let length = length("out.nc");
    assert!(length < 4096 + 40 * 30 * 4 + 256, "{length}");
}

/// The sidecar of the file that a field was made of is not its own.
#[test]
fn regress_a_sidecar_of_another_file_is_left_alone() {
    let place = Place::new();
    let mut field = Field::from_array(samples(8, 8));
    field.time = axis(3.0, 0.25, Some("s"));
    place.write("a.toml", "layout = \"site-time\"\nt0 = 7.0\n");
    for format in ["nc", "npz"] {
        let name = format!("a.{format}");
        FieldFile::write(&place.path(&name), false, &field).unwrap();
        let found = open(&place, &name);
        assert_same_axis(&found.time, &field.time, format);
        assert_same_samples(&found, &samples(8, 8), &name);
        // One with its whole name is.
        place.write(format!("{name}.toml"), "t0 = 7.0\n");
        assert_eq!(open(&place, &name).time.origin, 7.0);
    }
    let refused = FieldFile::write(&place.path("a.npy"), false, &field);
    assert!(matches!(refused, Err(Error::OutputInUse { .. })));
}

#[test]
fn only_fields_of_this_program_are_replaced() {
    let place = Place::new();
    let field = Field::from_array(samples(4, 4));
    place.write("foreign.nc", test_support::netcdf::netcdf(""));
    place.write("thesis.nc", "mine");
    for name in ["foreign.nc", "thesis.nc"] {
        let before = std::fs::read(place.path(name)).unwrap();
        let refused = FieldFile::write(&place.path(name), true, &field);
        assert!(matches!(refused, Err(Error::OutputInUse { .. })), "{name}");
        assert_eq!(std::fs::read(place.path(name)).unwrap(), before);
    }
    for format in FORMATS {
        let path = place.path(format!("own.{format}"));
        FieldFile::write(&path, false, &field).unwrap();
        let again = FieldFile::write(&path, false, &field);
        assert!(matches!(again, Err(Error::Exists { .. })), "{format}");
        FieldFile::write(&path, true, &field).unwrap();
    }
    for name in ["field.h5", "field.nc4", "field.mat"] {
        let refused = FieldFile::check(&place.path(name), false);
        assert!(matches!(refused, Err(Error::Request { .. })), "{name}");
    }
    let options = reading(|it| it.variable = Some("velocity".into()));
    assert!(Field::open(place.path("own.nc"), &options).is_ok());
}

/// The samples of a field that all have one value, and its step of time.
fn constant(value: f64) -> Field {
    let mut field = Field::from_array(Array2::from_elem((40, 30), value));
    field.time = axis(0.0, value * 1e-3, Some("s"));
    field
}

/// Several writers at once, again and again; then what `check` says of those that succeeded and of the field that is
/// there.
fn race(formats: &[&str], replace: bool, rounds: usize, check: impl Fn(&[Result<(), Error>], f64)) {
    const WRITERS: usize = 4;
    let place = Place::new();
    for format in formats {
        for round in 0..rounds {
            let path = place.path(format!("{round}.{format}"));
            if replace {
                FieldFile::write(&path, false, &constant(9.0)).unwrap();
            }
            let start = std::sync::Barrier::new(WRITERS);
            let results: Vec<Result<(), Error>> = std::thread::scope(|scope| {
                let writers: Vec<_> = (1..=WRITERS)
                    .map(|number| {
                        let (path, start) = (&path, &start);
                        scope.spawn(move || {
                            let field = constant(number as f64);
                            start.wait();
                            FieldFile::write(path, replace, &field)
                        })
                    })
                    .collect();
                let joined = writers.into_iter().map(|writer| writer.join().unwrap());
                joined.collect()
            });
            let found = open(&place, &format!("{round}.{format}"));
            let samples = values(&found);
            let value = samples[[0, 0]];
            assert!(samples.iter().all(|v| *v == value), "{format}");
            // The axes are those of the samples.
            let step = found.time.step / 1e-3;
            assert!(
                (step / value - 1.0).abs() < 1e-9,
                "{format}: {step} for {value}"
            );
            check(&results, value);
        }
    }
}

/// Of several runs that write one new file, or a pair, one has it and the others say that it is there.
#[test]
fn regress_a_new_field_is_written_by_one_of_several() {
    race(&FORMATS, false, 20, |results, value| {
        let done: Vec<usize> = (0..results.len()).filter(|&n| results[n].is_ok()).collect();
        assert_eq!(done.len(), 1, "{results:?}");
        assert_eq!(value, (done[0] + 1) as f64);
        let others = results.iter().filter_map(|result| result.as_ref().err());
        for error in others {
            assert!(matches!(error, Error::Exists { .. }), "{error}");
        }
    });
}

/// Replaced at once by several, a field has samples and axes of one of them.
#[test]
fn regress_a_replaced_field_is_of_one_of_several() {
    race(&["npy", "csv"], true, 40, |results, value| {
        assert!(results.iter().all(Result::is_ok), "{results:?}");
        assert_ne!(value, 9.0);
    });
}
