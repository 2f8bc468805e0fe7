//! `cascade inspect`, and fields of other formats on the command line.

use std::fs;

use serde_json::Value;
use test_support::netcdf::{NetCdf, Values, Variable};
use test_support::place::Place;

/// A wave `v(x, y, time)` of 40 times, 2 heights and 6 sites, under its CF names.
fn scan(place: &Place) {
    let list =
        |count: usize, step: f64| Values::Double((0..count).map(|i| i as f64 * step).collect());
    let wave = (0..6 * 2 * 40).map(|i| {
        let (j, n) = (i / 80, i % 40);
        (-(f64::from(n) - 3.0 * f64::from(j) - 8.0).powi(2) / 9.0).exp()
    });
    let file = NetCdf {
        dimensions: vec![("x", 6), ("y", 2), ("time", 40)],
        variables: vec![
            Variable::new("x", &[0], list(6, 0.5)).text("units", "mm"),
            Variable::new("time", &[2], list(40, 1e-6)).text("units", "s"),
            Variable::new("v", &[0, 1, 2], Values::Double(wave.collect())).text("units", "m s-1"),
        ],
    };
    place.write("scan.nc", file.bytes());
}

#[test]
fn a_file_is_listed_with_what_is_missing_and_the_command() {
    let place = Place::new();
    scan(&place);
    let said = place.says("inspect scan.nc");
    for part in ["NetCDF-3", "x: 6, y: 2, time: 40", "m s-1", "--at y=#0"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let said = place.says("inspect scan.nc --at y=#1");
    for part in ["analyze scan.nc --at y=#1\n", "40 times", "6 sites"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let json: Value = serde_json::from_str(&place.says("inspect scan.nc --json")).unwrap();
    assert_eq!(json["variables"][2]["path"], "v");
    assert!(json["field"]["error"].as_str().unwrap().contains('y'));
    place.says("analyze scan.nc --at y=#1 --select time=:30us --out result -q");
    let field = &place.json("result/summary.json")["field"];
    assert_eq!(field["shape"], serde_json::json!([31, 6]));
}

#[test]
fn what_a_file_lacks_is_refused_with_advice() {
    let place = Place::new();
    scan(&place);
    let bytes = fs::read(place.path("scan.nc")).unwrap();
    place.write("cut.nc", &bytes[..bytes.len() / 2]);
    for (code, line, named) in [
        (1, "analyze scan.nc", "--at y="),
        (1, "analyze scan.nc --variable speed", "\"speed\""),
        (1, "analyze scan.nc --at z=1", "x: 6, y: 2, time: 40"),
        (1, "analyze scan.nc --at y=#5", "0 to 1"),
        (1, "inspect cut.nc", "cut.nc"),
        (1, "inspect absent.h5", "No such file"),
        (2, "analyze scan.nc --at y", "--at"),
        (2, "analyze scan.nc --select time=3", "--select"),
    ] {
        let said = test_support::made::in_one_line(&place.refuses(code, line));
        assert!(said.contains(named), "{line}: {said}");
    }
}
