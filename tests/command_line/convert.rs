//! `cascade convert`, and NetCDF files of `analyze`, `filter` and `simulate`.

use std::fs;

use ndarray::Array2;
use test_support::made::{open, pulse, savez, steps, values};
use test_support::place::Place;
use wavecascade_formats::{Container, Format, Options};

fn container(place: &Place, name: &str) -> Container {
    let bytes = fs::read(place.path(name)).unwrap();
    let format = Format::detect(name, &bytes).unwrap();
    wavecascade_formats::open(format, std::sync::Arc::new(bytes), &Options::default()).unwrap()
}

/// Every array of the archive is in the NetCDF file, bit for bit, with named dimensions and long names.
fn are_the_same(place: &Place, base: &str, stem: &str, is_single: bool) -> Container {
    place.says(&format!("{base} --out zip"));
    place.says(&format!("{base} --out nc --format netcdf"));
    let found = container(place, &format!("nc/{stem}.nc"));
    let archive = format!("zip/{stem}.npz");
    let names = place.arrays(&archive);
    assert!(names.len() >= 30, "{names:?}");
    assert_eq!(names.len(), found.variables.len());
    for name in &names {
        let expected = match is_single {
            true => place.array::<f32>(&archive, name).mapv(f64::from),
            false => place.array::<f64>(&archive, name),
        };
        let i = found.find(name).unwrap_or_else(|| panic!("{name}"));
        let (numbers, variable) = (found.numbers(i).unwrap(), &found.variables[i]);
        let bits = |v: &f64| v.to_bits();
        assert!(
            numbers.iter().map(bits).eq(expected.iter().map(bits)),
            "{name}"
        );
        let shape: Vec<usize> = variable.shape().iter().map(|&len| len as usize).collect();
        assert_eq!(shape, expected.shape(), "{name}");
        // Branches of dispersion curves only count.
        let has_coordinate = |d: &wavecascade_formats::Dimension| {
            d.coordinate.is_some() || d.name.as_deref() == Some("dispersion_branch")
        };
        assert!(variable.dimensions.iter().all(has_coordinate), "{name}");
        assert!(variable.attributes.text("long_name").is_some(), "{name}");
    }
    let summary = place.json("nc/summary.json");
    for name in ["program", "version", "input", "input_blake3"] {
        let stated = summary["provenance"][name].as_str();
        assert_eq!(found.attributes.text(name), stated, "{name}");
    }
    let script = place.read("nc/plot.py");
    assert!(
        script.contains(".nc") && !script.contains(".npz"),
        "{script}"
    );
    found
}

#[test]
fn regress_results_are_the_same_in_both_formats() {
    let place = Place::new();
    place.says(
        "simulate -q --out dis.npz --stiffness-ratio 2.398 --sites 40 --end-time 38 --samples 257",
    );
    let base = "budget dis.npz --from-samples --figures none --quiet --force";
    let found = are_the_same(&place, base, "budget", false);
    let summary = place.json("nc/summary.json");
    for (name, expected) in [
        ("closure_wavenumber", &summary["closure"]["wavenumber"]),
        ("wavenumber_band_edge", &summary["wavenumber"]["band_edge"]),
    ] {
        assert_eq!(found.attributes.number(name), expected.as_f64());
    }
    place.save("a.npy", &pulse(257, 48));
    for precision in ["f64", "f32"] {
        let base = format!(
            "analyze a.npy --dt 10us --dx 2mm --unit m/s --figures none --force --precision {precision} \
             --short-time-times 1e-3,2e-3 --dispersion 200*abs(k) --band-edge-frequency 2e4 --scaling density"
        );
        let found = are_the_same(&place, &base, "spectra", precision == "f32");
        let units = |name: &str| {
            let attributes = &found.variables[found.find(name).unwrap()].attributes;
            attributes.text("units").map(str::to_owned)
        };
        for (name, unit) in [
            ("time", "s"),
            ("frequency", "Hz"),
            ("wavenumber_signed", "rad/m"),
            ("frequency_centroid", "Hz"),
            ("frequency_entropy", "1"),
            ("spacetime_spectrum", "(m/s)\u{b2}/(Hz \u{b7} rad/m)"),
            ("short_time_spectrum", "(m/s)\u{b2}/Hz"),
        ] {
            assert_eq!(units(name).as_deref(), Some(unit), "{name}");
        }
        assert_eq!(found.attributes.text("scaling"), Some("density"));
        assert!(found.attributes.number("parseval_time").is_some());
    }
}

/// A field that has to be decoded and is larger than the memory allowed.
#[test]
fn regress_memory_is_kept_to() {
    let place = Place::new();
    let wide = Array2::from_shape_fn((600, 500), |(n, j)| ((n * 7 + j * 3) % 101) as f64);
    savez(&place, "a.npz", ("v", &wide), &[("t", steps(600, 0.5))]);
    place.says("convert a.npz b.nc --memory 64MB --quiet");
    assert_eq!(values(&open(&place, "b.nc")), wide);
    let said = place.refuses(2, "convert a.npz c.nc --read copy --memory 1MB");
    assert!(said.contains("memory") || said.contains("MiB"), "{said}");
}
