//! What files state beside their samples: each meaning under its spellings, and contradictions refused.

use test_support::hostile::{Folder, fault, npy, npy_f64, npz};
use test_support::made::values;
use test_support::netcdf::{NetCdf, Values, Variable};
use wavecascade::Field;
use wavecascade::error::InputFault;
use wavecascade::field::OpenOptions;
use wavecascade::measure;
use zip::CompressionMethod;

use crate::{note, texts};

fn field(name: &str, bytes: impl AsRef<[u8]>) -> Field {
    let folder = Folder::new();
    let opened = Field::open(folder.write(name, bytes), &OpenOptions::default());
    opened.unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn number(number: f64) -> Vec<u8> {
    npy_f64("()", [number])
}

fn text(text: &str) -> Vec<u8> {
    let bytes: Vec<u8> = text
        .chars()
        .flat_map(|c| u32::from(c).to_le_bytes())
        .collect();
    npy(&format!("<U{}", text.chars().count()), "()", &bytes)
}

/// An archive of `v(6, 2)` and what stands beside it.
fn beside(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let samples = npy_f64("(6, 2)", (0..12).map(|i| f64::from(i % 5)));
    let names: Vec<String> = members
        .iter()
        .map(|(name, _)| format!("{name}.npy"))
        .collect();
    let members = names
        .iter()
        .zip(members)
        .map(|(name, (_, bytes))| (name.as_str(), &bytes[..]));
    let all: Vec<(&str, &[u8])> = std::iter::once(("v.npy", &samples[..]))
        .chain(members)
        .collect();
    npz(CompressionMethod::Stored, &all)
}

#[test]
fn val_definition_rates_steps_and_units_under_their_names() {
    for (name, value, unit, step) in [
        ("SamplingRate", 2000.0, "", 5e-4),
        ("OutputDataRate", 500.0, "", 2e-3),
        ("DELTA", 0.004, "Seconds", 0.004),
        ("SampleInterval", 4.0, "ms", 0.004),
        ("fs", 2.0, "kHz", 5e-4),
        ("rate", 2.0, "kSa/s", 5e-4),
        ("fs_kHz", 2.0, "", 5e-4),
        ("time_step", 500.0, "usec.", 5e-4),
    ] {
        let ending = format!("{name}_unit");
        let all = [(name, number(value)), (ending.as_str(), text(unit))];
        let found = field("a.npz", beside(&all[..if unit.is_empty() { 1 } else { 2 }])).time;
        let unit = found
            .unit
            .as_deref()
            .and_then(measure::size::<measure::Time>);
        let error = found.step * unit.unwrap() / step - 1.0;
        assert!(error.abs() < 1e-12, "{name}: {found:?}");
    }
    for name in ["unit", "Units", "v_Unit", "velocity_unit"] {
        let found = field("a.npz", beside(&[(name, text("mm/s"))]));
        assert_eq!(found.unit.as_deref(), Some("mm/s"), "{name}");
    }
    let times = || npy_f64("(6,)", (0..6).map(|n| f64::from(n) * 0.5));
    for (name, unit) in [("t_unit", "sec."), ("T_Units", "Seconds")] {
        let found = field("a.npz", beside(&[("t", times()), (name, text(unit))])).time;
        assert_eq!(
            (found.step, found.unit.as_deref()),
            (0.5, Some("s")),
            "{name}"
        );
    }
}

#[test]
fn val_definition_scales_by_channel() {
    let list = |numbers: &[f64]| npy_f64(&format!("({},)", numbers.len()), numbers.iter().copied());
    for (name, offset) in [
        ("scale_factor", "add_offset"),
        ("scale", "add_offset"),
        ("v_scale", "offset"),
        ("slope", "intercept"),
        ("v_Slope", "v_intercept"),
    ] {
        let all = [(name, list(&[2.0, 10.0])), (offset, list(&[0.0, 1.0]))];
        let found = values(&field("a.npz", beside(&all)));
        let expected = |(n, j): (usize, usize)| {
            let stored = ((2 * n + j) % 5) as f64;
            [2.0, 10.0][j] * stored + [0.0, 1.0][j]
        };
        assert_eq!(
            found,
            ndarray::Array2::from_shape_fn((6, 2), expected),
            "{name}"
        );
    }
    let refused = fault("a.npz", beside(&[("scale_factor", list(&[1.0, 2.0, 3.0]))]));
    assert!(
        matches!(refused, InputFault::Factors { found: 3, .. }),
        "{refused}"
    );
    let unused = field("a.npz", beside(&[("gain", list(&[1.0, 2.0]))]));
    assert!(note(&unused, "unused").is_some_and(|note| note.is_doubtful));
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

/// `numpy.savez(path, v=v, time=times)` with `datetime64` and `timedelta64`, and integers since 1970.
#[test]
fn val_numpy_dates_and_spans_of_time() {
    const START: i64 = 1_764_158_400;
    for (descr, start, step, dt) in [
        ("<M8[ns]", START * 1_000_000_000, 1_000_000, 1e-3),
        ("<M8[ms]", START * 1_000, 2, 2e-3),
        ("<M8[10us]", START * 100_000, 25, 2.5e-4),
        ("<m8[us]", 0, 500, 5e-4),
        ("<i8", START * 1_000_000_000, 1_000_000, 1e-3),
        (">i8", START * 1_000, 2, 2e-3),
    ] {
        let counts = (0..6).map(|n| start + n * step);
        let bytes: Vec<u8> = match descr.starts_with('>') {
            true => counts.flat_map(i64::to_be_bytes).collect(),
            false => counts.flat_map(i64::to_le_bytes).collect(),
        };
        let field = field("a.npz", beside(&[("time", npy(descr, "(6,)", &bytes))]));
        let unit = field.time.unit.as_deref();
        let size = if unit == Some("us") { 1e-6 } else { 1.0 };
        assert!(
            (field.time.step * size / dt - 1.0).abs() < 1e-9,
            "{descr}: {:?}",
            field.time
        );
        assert!(unit.is_some(), "{descr}");
        let is_dated = note(&field, "start").is_some();
        assert_eq!(is_dated, start > 0, "{descr}");
    }
}

#[test]
fn val_definition_clocks_of_tables() {
    let table = |head: &str, row: &dyn Fn(u32) -> String| {
        let rows: String = (0..20).map(|n| row(n) + "\n").collect();
        field("a.csv", format!("{head}{rows}"))
    };
    let sample = |n: u32| format!("{},{}", n * 7 % 11, n * 3 % 5);
    let iso = |n: u32| format!("2025-11-26T12:00:00.{n:03}Z,{}", sample(n));
    for (found, step, unit, sites) in [
        (
            table("timestamp,a,b\n", &|n| {
                format!("1764000000.{n:03},{}", sample(n))
            }),
            1e-3,
            "s",
            2,
        ),
        (
            table("Timestamp (ms),a,b\n", &|n| format!("{n}.5,{}", sample(n))),
            1.0,
            "ms",
            2,
        ),
        (table("timestamp,a,b\n", &iso), 1e-3, "s", 2),
        (table("", &iso), 1e-3, "s", 2),
        (
            table("Time (s),a,Time (s),b\n", &|n| {
                format!("{n},3,{n},{}", n % 3)
            }),
            1.0,
            "s",
            2,
        ),
        (
            table("time_ms,time_s,a\n", &|n| format!("{n},0.{n:03},{}", n % 3)),
            1.0,
            "ms",
            1,
        ),
    ] {
        assert!(
            (found.time.step / step - 1.0).abs() < 1e-9,
            "{:?}",
            found.time
        );
        assert_eq!(
            (found.time.unit.as_deref(), found.n_sites()),
            (Some(unit), sites)
        );
    }
    for (clock, zone) in [
        ("UTC", " UTC"),
        ("Date Time", "+0100"),
        ("Zeitstempel", "-03"),
        ("t", "z"),
        ("epoch", "+05:30"),
    ] {
        let row = |n: u32| format!("2025-11-26 12:00:00.{n:03}{zone},{}", sample(n));
        let found = table(&format!("{clock},a,b\n"), &row).time;
        assert_eq!(
            (found.unit.as_deref(), found.step),
            (Some("s"), 1e-3),
            "{zone}"
        );
    }
    for head in [
        "Time 1,a,Time 2,b",
        "time_1,a,time_2,b",
        "Time,a,Time.1,b",
        "t_CH1 (s),CH1,t_CH2 (s),CH2",
        "Time - A,A,Time - B,B",
        "p1.time,p1,p2.time,p2",
    ] {
        let row = |n: u32| format!("{n},{},{n},{}", n * 7 % 11, n % 5);
        assert_eq!(table(&format!("{head}\n"), &row).n_sites(), 2, "{head}");
    }
    let rows: String = (0..50)
        .map(|n| format!("{:.2},{},{}\n", f64::from(n) * 1e-3, n * 7 % 11, n % 5))
        .collect();
    let coarse = fault("a.csv", rows);
    assert!(matches!(coarse, InputFault::FirstColumn { .. }), "{coarse}");
}

/// Settings of a logger that stand in comments.
#[test]
fn val_definition_settings_in_comments() {
    let rows: String = (0..20)
        .map(|n| format!("{},{}\n", n * 7 % 11, n % 5))
        .collect();
    for (comment, step) in [
        ("Sampling Rate: 2 kHz", 5e-4),
        ("dt = 4e-3", 4e-3),
        ("Sample interval\t250 us", 2.5e-4),
    ] {
        let found = field(
            "a.csv",
            format!("# logger 7\n# {comment}\n# Start: 12:30:00\n{rows}"),
        )
        .time;
        assert_eq!((found.step, found.origin), (step, 0.0), "{comment}");
    }
}

/// A step that is stated takes the place of any other one, and of two that differ, in words.
#[test]
fn regress_a_stated_step_overrules_in_words() {
    let mut segy = {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/formats/tests/files");
        std::fs::read(format!("{data}/segy/ibm.sgy")).unwrap()
    };
    segy[3216..3218].copy_from_slice(&4000u16.to_be_bytes());
    let contradiction = fault("a.sgy", &segy).to_string();
    assert!(
        contradiction.starts_with("expected one sample interval, found"),
        "{contradiction}"
    );
    for (name, bytes, replaced) in [
        ("a.sgy", segy, ["4000 us", "2001 us"]),
        (
            "a.npz",
            beside(&[("fs", number(500.0)), ("dt", number(0.004))]),
            ["500", "0.004"],
        ),
    ] {
        let options = OpenOptions {
            dt: measure::Measure::parse("1 ms"),
            ..OpenOptions::default()
        };
        let folder = Folder::new();
        let field = Field::open(folder.write(name, bytes), &options).unwrap();
        assert_eq!(
            (field.time.step, field.time.unit.as_deref()),
            (0.001, Some("s")),
            "{name}"
        );
        let said = texts(&field).join("; ");
        let all_said = replaced.iter().all(|one| said.contains(one));
        assert!(
            said.contains("takes the place of") && all_said,
            "{name}: {said}"
        );
    }
}

#[test]
fn regress_two_statements_that_differ_are_refused() {
    let rows = |head: &str, row: fn(i32) -> String| {
        let rows: String = (0..20).map(row).collect();
        format!("{head}\n{rows}").into_bytes()
    };
    let times = || npy_f64("(6,)", (0..6).map(|n| f64::from(n) * 0.5));
    for (name, bytes) in [
        (
            "a.npz",
            beside(&[("fs", number(1000.0)), ("dt", number(0.002))]),
        ),
        (
            "a.npz",
            beside(&[("fs", number(1000.0)), ("SamplingRate", number(500.0))]),
        ),
        (
            "a.npz",
            beside(&[("t", times()), ("t_unit", text("s")), ("fs", number(4.0))]),
        ),
        (
            "a.npz",
            beside(&[("time_s", times()), ("time_ms", times())]),
        ),
        (
            "a.npz",
            beside(&[("unit", text("m/s")), ("v_units", text("mm/s"))]),
        ),
        (
            "a.npz",
            beside(&[("scale", number(1.0)), ("scale_factor", number(2.0))]),
        ),
        (
            "a.csv",
            rows("Time,a,Time,b", |n| format!("{n},{},{},1\n", n % 3, 2 * n)),
        ),
        (
            "a.csv",
            rows("Sample Interval,2e-3\nName,x\nTime (s),a", |n| {
                format!("0.{n:03},{}\n", n % 3)
            }),
        ),
    ] {
        let refused = fault(name, bytes);
        assert!(
            matches!(refused, InputFault::Contradiction { .. }),
            "{refused}"
        );
    }
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
