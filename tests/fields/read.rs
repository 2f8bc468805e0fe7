//! Files and what is read of them, or why nothing is: a file a row of `read.txt`, which says what its columns are.
//!
//! Of the rows of instruments the forms are those that Tektronix, Keysight, Rigol, LeCroy, Siglent and PicoScope write; of those of
//! NumPy and pandas, what the named call writes. Numbers are those of the text.

use std::path::{Path, PathBuf};

use test_support::hostile::{Folder, npy, npz, unescaped};
use test_support::made::values;
use test_support::netcdf::netcdf;
use wavecascade::Field;
use wavecascade::field::{
    At, Axis, Delays, Header, Interpolation, Label, OpenOptions, ReadMode, Resample, Selection,
    TimeColumn, inspect,
};
use wavecascade::measure::Measure;
use zip::CompressionMethod;

/// Options as on the command line, a blank inside of a value as `~`.
pub fn options(words: &str) -> OpenOptions {
    let mut it = OpenOptions::default();
    for (key, value) in words.split(' ').filter_map(|word| word.split_once('=')) {
        let value = value.replace('~', " ");
        let text = Some(value.clone());
        match key {
            "dt" => it.dt = Measure::read(&value).ok(),
            "dx" => it.dx = Measure::read(&value).ok(),
            "x0" => it.x0 = Measure::read(&value).ok(),
            "variable" => it.variable = text,
            "time-unit" => it.time_unit = text,
            "space-unit" => it.space_unit = text,
            "unit" => it.unit = text,
            "time-dim" => it.time_dim = text,
            "space-dim" => it.space_dim = text,
            "at" => {
                let (dimension, label) = value.split_once('=').unwrap();
                let (dimension, label) = (dimension.into(), Label::parse(label).unwrap());
                it.at.push(At { dimension, label });
            }
            "select" => {
                let (dimension, range) = value.split_once('=').unwrap();
                let (from, to) = range.split_once(':').unwrap();
                let (from, to) = (Label::parse(from), Label::parse(to));
                let dimension = dimension.into();
                it.select.push(Selection {
                    dimension,
                    from,
                    to,
                });
            }
            "jitter" => it.jitter = value.parse().unwrap(),
            "memory" => it.memory = value.parse().ok(),
            "layout" => it.layout = serde_json::from_value(value.into()).unwrap(),
            "resample" => {
                let method = Interpolation::ALL.into_iter().find(|it| it.name() == value);
                it.resample = Resample::both(method.unwrap());
            }
            "delays" if value == "align" => it.delays = Delays::Align,
            "delays" if value == "ignore" => it.delays = Delays::Ignore,
            "read" if value == "copy" => it.read = ReadMode::Copy,
            "header" if value == "present" => it.header = Header::Present,
            "header" if value == "absent" => it.header = Header::Absent,
            "time-column" if value == "none" => it.time_column = TimeColumn::None,
            "time-column" => {
                let by_name = || TimeColumn::Name(value.clone());
                it.time_column = value.parse().map_or_else(|_| by_name(), TimeColumn::Index);
            }
            "sidecar" | "feature" => {}
            _ => panic!("{key}={value}"),
        }
    }
    it
}

/// An array as NumPy writes it, of this shape: a number, `"a text"`, `[a list]` or `<f4[a list]`, `FROM:STEP`, `%5` for the rests of
/// 0, 1, .., or `TYPE[from step count]` of integers.
fn array(shape: Option<&str>, value: &str) -> Vec<u8> {
    let number = |text: &str| text.parse::<f64>().unwrap();
    let count = || -> usize {
        shape
            .unwrap()
            .split(',')
            .map(|n| number(n) as usize)
            .product()
    };
    let list =
        |text: &str| -> Vec<f64> { text.trim_end_matches(']').split(' ').map(number).collect() };
    let doubles = |numbers: Vec<f64>| numbers.into_iter().flat_map(f64::to_le_bytes).collect();
    let (descr, length, bytes): (String, usize, Vec<u8>) =
        if let Some(text) = value.strip_prefix('"') {
            let letters: Vec<u32> = text.trim_end_matches('"').chars().map(u32::from).collect();
            let bytes = letters
                .iter()
                .flat_map(|letter| letter.to_le_bytes())
                .collect();
            (format!("<U{}", letters.len()), 0, bytes)
        } else if let Some(numbers) = value.strip_prefix('[') {
            let numbers = list(numbers);
            ("<f8".into(), numbers.len(), doubles(numbers))
        } else if let Some(numbers) = value.strip_prefix("<f4[") {
            let singles = list(numbers).into_iter().map(|v| v as f32);
            let bytes: Vec<u8> = singles.flat_map(f32::to_le_bytes).collect();
            ("<f4".into(), bytes.len() / 4, bytes)
        } else if let Some((descr, range)) = value.rsplit_once('[') {
            let range: Vec<&str> = range.trim_end_matches(']').split(' ').collect();
            let integer = |at: usize| range[at].parse::<i64>().unwrap();
            let integers = (0..integer(2)).map(|n| integer(0) + n * integer(1));
            let bytes = match descr.starts_with('>') {
                true => integers.flat_map(i64::to_be_bytes).collect(),
                false => integers.flat_map(i64::to_le_bytes).collect(),
            };
            (descr.into(), integer(2) as usize, bytes)
        } else if let Some((from, step)) = value.split_once(':') {
            let numbers = (0..count()).map(|i| number(from) + i as f64 * number(step));
            ("<f8".into(), 1, doubles(numbers.collect()))
        } else if let Some(rest) = value.strip_prefix('%') {
            let numbers = (0..count()).map(|i| (i % number(rest) as usize) as f64);
            ("<f8".into(), 1, doubles(numbers.collect()))
        } else {
            ("<f8".into(), 0, doubles(vec![number(value)]))
        };
    let shape = match (shape, length) {
        (Some(shape), _) if shape.contains(',') => format!("({})", shape.replace(',', ", ")),
        (Some(shape), _) => format!("({shape},)"),
        (None, 0) => "()".into(),
        (None, length) => format!("({length},)"),
    };
    npy(&descr, &shape, &bytes)
}

/// `NAME VALUE` or `NAME(SHAPE) VALUE` of an archive.
fn member(text: &str) -> (String, Vec<u8>) {
    let (name, value) = text.split_once(' ').unwrap();
    let (name, shape) = match name.trim_end_matches(')').split_once('(') {
        Some((name, shape)) => (name, Some(shape)),
        None => (name, None),
    };
    (format!("{name}.npy"), array(shape, value))
}

/// A path in the repository.
pub fn beside(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The bytes of a row's file, but for its edits.
fn made(text: &str) -> Vec<u8> {
    let (form, rest) = text.split_once(' ').unwrap_or((text, ""));
    match form {
        "nc" => netcdf(rest),
        "numpy" => super::formats::numpy_bytes(rest),
        "copy" => std::fs::read(beside(rest)).unwrap(),
        "npy" => {
            let parts: Vec<&str> = rest.splitn(3, ' ').collect();
            match parts[2].parse() {
                Ok(zeros) => npy(parts[0], &parts[1].replace(',', ", "), &vec![0; zeros]),
                Err(_) => array(Some(parts[1].trim_matches(['(', ')'])), parts[2]),
            }
        }
        "npz" | "deflated" => {
            let mut members: Vec<(String, Vec<u8>)> = rest.split("; ").map(member).collect();
            let has_field = rest
                .split("; ")
                .any(|it| it.split(' ').next().unwrap().contains(','));
            if !has_field {
                members.insert(0, member("v(6,2) %5"));
            }
            let all = members.iter().map(|(name, bytes)| (&name[..], &bytes[..]));
            let method = match form {
                "npz" => CompressionMethod::Stored,
                _ => CompressionMethod::Deflated,
            };
            npz(method, &all.collect::<Vec<_>>())
        }
        _ => unescaped(text),
    }
}

/// The file of a row, with its edits: other bytes from an offset on, a cut to a length, and what is left out before.
pub fn file(text: &str) -> Vec<u8> {
    let is_edit = |word: &&str| {
        ["@", "cut=", "from="]
            .iter()
            .any(|edit| word.starts_with(edit))
    };
    let mut words: Vec<&str> = text.split(' ').collect();
    let edits = words.iter().rev().take_while(|word| is_edit(word)).count();
    let edits = words.split_off(words.len() - edits);
    let mut bytes = made(&words.join(" "));
    for edit in edits {
        let (at, value) = edit.trim_start_matches('@').split_once('=').unwrap();
        match at {
            "cut" => bytes.truncate(value.parse().unwrap()),
            "from" => drop(bytes.drain(..value.parse::<usize>().unwrap())),
            at => {
                let at: usize = at.parse().unwrap();
                for i in 0..value.len() / 2 {
                    bytes[at + i] = u8::from_str_radix(&value[2 * i..2 * i + 2], 16).unwrap();
                }
            }
        }
    }
    bytes
}

/// Origin, step and unit, to rounding.
fn is_axis(axis: &Axis, expected: &str) -> bool {
    let parts: Vec<&str> = expected.split(' ').collect();
    let [origin, step] = [0, 1].map(|i| parts[i].parse::<f64>().unwrap());
    let unit = Some(parts[2]).filter(|unit| *unit != "-");
    (axis.origin - origin).abs() <= 1e-12 * origin.abs().max(1e-3)
        && (axis.step / step - 1.0).abs() < 1e-12
        && axis.unit.as_deref() == unit
}

/// Whether a field is what is expected of it, `KEY VALUE`.
pub fn holds(field: &Field, expected: &str) -> bool {
    let (key, value) = expected.split_once(' ').unwrap();
    let unit = field.unit.as_deref().unwrap_or("-");
    let numbers =
        |text: &str| -> Vec<f64> { text.split(' ').map(|v| v.parse().unwrap()).collect() };
    let mut notes = field.notes.iter();
    match key {
        "shape" => value == format!("{} {}", field.n_times(), field.n_sites()),
        "v" => {
            let rows = values(field);
            let rows = rows.outer_iter().map(|row| row.to_vec());
            let theirs: Vec<Vec<f64>> = value.split(" / ").map(numbers).collect();
            // Gaps are NaN on both sides.
            format!("{:?}", rows.collect::<Vec<_>>()) == format!("{theirs:?}")
        }
        "sample" => {
            let expected = numbers(value);
            values(field)[[expected[0] as usize, expected[1] as usize]] == expected[2]
        }
        "time" => is_axis(&field.time, value),
        "space" => is_axis(&field.space, value),
        "unit" => unit == value,
        "quantity" => field.quantity.name() == value,
        "hash" => field
            .content_hash
            .as_deref()
            .is_some_and(|hash| hash.starts_with(value)),
        "codes" => {
            notes.map(|note| note.code).collect::<Vec<_>>().join(" ") == value.replace("none", "")
        }
        "silent" => notes.all(|note| note.code != value),
        "says" => notes.any(|note| note.text.contains(value)),
        "doubts" => notes.any(|note| note.is_doubtful && note.text.contains(value)),
        _ => panic!("{key} of {expected}"),
    }
}

/// Blocks of sites are those of times, turned.
fn is_read_alike(field: &Field) -> bool {
    let all = values(field);
    let (times, sites) = (all.nrows().div_ceil(2)..all.nrows(), 0..all.ncols());
    let mut turned = vec![0.0; times.len() * sites.len()];
    field.read_site_major(times.clone(), sites, &mut turned);
    let bits = |v: &f64| v.to_bits();
    let block = all.slice(ndarray::s![times, ..]);
    turned.iter().map(bits).eq(block.t().iter().map(bits))
}

#[test]
fn val_definition_files_and_what_is_read_of_them() {
    let mut wrong = Vec::new();
    let rows = include_str!("read.txt").lines();
    let mut before = "";
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let parts: Vec<&str> = row.split(" | ").collect();
        let (name, words) = parts[0].split_once(' ').unwrap_or((parts[0], ""));
        before = if parts[1] == "\"" { before } else { parts[1] };
        if words.contains("feature=zarr") != cfg!(feature = "zarr") && words.contains("feature=") {
            continue;
        }
        let folder = Folder::new();
        let path = match before.strip_prefix("where ") {
            Some(path) => beside(path),
            None => folder.write(name, file(before)),
        };
        if let Some((_, sidecar)) = words.split_once("sidecar=") {
            folder.write(
                &format!("{name}.toml"),
                unescaped(&sidecar.replace('~', " ")),
            );
        }
        let options = options(words);
        let opened = Field::open(&path, &options);
        let listed = inspect(&path, &options);
        let is_right = |expected: &&str| match (&opened, expected.split_once(' ').unwrap()) {
            (_, ("lists", count)) => listed
                .as_ref()
                .is_ok_and(|it| it.variables.len().to_string() == count),
            (Err(error), ("refused", words)) => error.to_string().contains(words),
            (Ok(field), _) => holds(field, expected),
            _ => false,
        };
        let missed = parts[2].split(" ; ").find(|one| !is_right(one));
        let is_listed_alike =
            listed.is_ok_and(|it| it.field.is_ok() == opened.is_ok()) || opened.is_err();
        let is_whole = opened.as_ref().map_or(true, is_read_alike);
        if missed.is_some() || !is_listed_alike || !is_whole {
            let found = opened.map(|field| (field.time, field.space, field.unit, field.notes));
            wrong.push(format!("{row}\nnot {missed:?}: {found:?}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
