//! What files state beside their samples: each meaning under its spellings, and contradictions refused.

use test_support::contains_all;
use test_support::fields::reading;
use test_support::hostile::{Folder, fault};
use test_support::made::values;
use test_support::netcdf::{NetCdf, Values, Variable};
use wavecascade::Field;
use wavecascade::field::OpenOptions;
use wavecascade::measure;

use crate::texts;

fn field(name: &str, bytes: impl AsRef<[u8]>) -> Field {
    let folder = Folder::new();
    let opened = Field::open(folder.write(name, bytes), &OpenOptions::default());
    opened.unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// CF conventions, 2.5.1, and the NetCDF user guide, appendix A: samples outside of the limits are gaps. Limits count in
/// packed numbers, unless they are of the type of the scale.
#[test]
fn val_definition_samples_outside_of_their_limits_are_gaps() {
    let file = |limits: &[(&'static str, f64)], is_packed: bool| {
        let numbers = vec![-3, 1, 2, -9, 5, 4];
        let variable =
            Variable::new("v", &[0, 1], Values::Short(numbers)).number("scale_factor", 0.5);
        let add = |it: Variable, (name, limit): &(&'static str, f64)| match is_packed {
            true => it.integer(name, *limit as i32),
            false => it.number(name, *limit),
        };
        NetCdf {
            dimensions: vec![("time", 3), ("x", 2)],
            variables: vec![limits.iter().fold(variable, add)],
        }
        .bytes()
    };
    for (names, is_packed) in [
        (["valid_min", "valid_max"], true),
        (["valid_min", "valid_max"], false),
        (["ValidMin", "Valid_Maximum"], false),
    ] {
        let limits = [-3.0, 4.0].map(|limit| if is_packed { limit } else { 0.5 * limit });
        let limits = [(names[0], limits[0]), (names[1], limits[1])];
        let found = values(&field("a.nc", file(&limits, is_packed)));
        let is_known: Vec<bool> = found.iter().map(|v| v.is_finite()).collect();
        assert_eq!(
            is_known,
            [true, true, true, false, false, true],
            "{names:?}"
        );
        assert_eq!((found[[0, 0]], found[[2, 1]]), (-1.5, 2.0));
    }
}

/// A step that is stated takes the place of two that differ, in words.
#[test]
fn regress_a_stated_step_overrules_in_words() {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/formats/tests/files");
    let mut segy = std::fs::read(format!("{data}/segy/ibm.sgy")).unwrap();
    segy[3216..3218].copy_from_slice(&4000u16.to_be_bytes());
    let said = fault("a.sgy", &segy).to_string();
    assert!(said.starts_with("expected one sample interval"), "{said}");
    let options = reading(|it| it.dt = measure::Measure::parse("1 ms"));
    let folder = Folder::new();
    let field = Field::open(folder.write("a.sgy", segy), &options).unwrap();
    assert_eq!(field.time.step, 0.001);
    let words = ["takes the place of", "4000 us", "2001 us"];
    contains_all(&texts(&field).join("; "), &words);
}

/// Frequency responses beside the numbers of their nodes: those are no record.
#[test]
fn regress_what_is_not_read_hides_behind_no_list() {
    let place = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/crates/formats/tests/files/uff/ascii.uff"
    );
    let text = std::fs::read_to_string(place).unwrap();
    let mut header = 6;
    let lines = text.lines().map(|line| {
        header = if line.trim() == "58" { 0 } else { header + 1 };
        // The first number of the sixth line behind that is the type of the function.
        match header {
            6 => format!("    4{}\n", &line[5..]),
            _ => format!("{line}\n"),
        }
    });
    let refused = fault("a.uff", lines.collect::<String>()).to_string();
    assert!(refused.contains("functions of type 4"), "{refused}");
}
