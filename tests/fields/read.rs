//! Files and what is read of them, or why nothing is: a file a row of `read.txt`.
//!
//! Of the rows of instruments the forms are those that Tektronix, Keysight, Rigol, LeCroy, Siglent and PicoScope write; of those of
//! NumPy and pandas, what the named call writes. Numbers are those of the text.

use test_support::hostile::{Folder, npy, npy_f64, npz};
use wavecascade::Field;
use wavecascade::field::{Axis, Header, Layout, OpenOptions, TimeColumn};
use wavecascade::measure::Measure;
use zip::CompressionMethod;

/// Options as on the command line, a blank inside of a value as `~`.
fn options(words: &str) -> OpenOptions {
    let mut options = OpenOptions::default();
    for (key, value) in words.split(' ').filter_map(|word| word.split_once('=')) {
        match key {
            "dt" => {
                let number = value.parse::<f64>().map(Measure::from).ok();
                options.dt = number.or_else(|| Measure::parse(&value.replace('~', " ")));
            }
            "variable" => options.variable = Some(value.into()),
            "time-unit" => options.time_unit = Some(value.into()),
            "layout" if value == "site-time" => options.layout = Some(Layout::SiteTime),
            "header" if value == "present" => options.header = Header::Present,
            "time-column" if value == "none" => options.time_column = TimeColumn::None,
            "time-column" => {
                let by_name = || TimeColumn::Name(value.into());
                options.time_column = value.parse().map_or_else(|_| by_name(), TimeColumn::Index);
            }
            _ => panic!("{key}={value}"),
        }
    }
    options
}

/// A text with its escapes: `\n`, `\r`, `\t`, and `\xHH` for a byte.
fn unescaped(text: &str) -> Vec<u8> {
    let mut parts = text.split('\\');
    let mut bytes = parts.next().unwrap().as_bytes().to_vec();
    for part in parts {
        let (byte, rest) = match part.as_bytes()[0] {
            b'n' => (b'\n', &part[1..]),
            b'r' => (b'\r', &part[1..]),
            b't' => (b'\t', &part[1..]),
            _ => (u8::from_str_radix(&part[1..3], 16).unwrap(), &part[3..]),
        };
        bytes.push(byte);
        bytes.extend(rest.as_bytes());
    }
    bytes
}

/// `NAME VALUE`, an array as NumPy writes it: a number, `"a text"`, `[a list]` or `TYPE[from step count]`.
fn member(text: &str) -> (String, Vec<u8>) {
    let (name, value) = text.split_once(' ').unwrap();
    let list = |text: &str| -> Vec<f64> {
        let numbers = text.trim_end_matches(']').split(' ');
        numbers.map(|number| number.parse().unwrap()).collect()
    };
    let bytes = match (value.strip_prefix('"'), value.rsplit_once('[')) {
        (Some(text), _) => {
            let text = text.trim_end_matches('"');
            let letters = text.chars().flat_map(|c| u32::from(c).to_le_bytes());
            let descr = format!("<U{}", text.chars().count());
            npy(&descr, "()", &letters.collect::<Vec<u8>>())
        }
        (_, Some(("", numbers))) => {
            let numbers = list(numbers);
            npy_f64(&format!("({},)", numbers.len()), numbers)
        }
        (_, Some((descr, range))) => {
            let numbers: Vec<i64> = list(range).iter().map(|number| *number as i64).collect();
            let counts = (0..numbers[2]).map(|n| numbers[0] + n * numbers[1]);
            let bytes: Vec<u8> = match descr.starts_with('>') {
                true => counts.flat_map(i64::to_be_bytes).collect(),
                false => counts.flat_map(i64::to_le_bytes).collect(),
            };
            npy(descr, &format!("({},)", numbers[2]), &bytes)
        }
        _ => npy_f64("()", [value.parse().unwrap()]),
    };
    (format!("{name}.npy"), bytes)
}

/// The file of a row: text, `npy TYPE SHAPE` with as many zero bytes, or `npz` with `v(6, 2)` and what stands beside it.
fn file(text: &str) -> Vec<u8> {
    if let Some(members) = text.strip_prefix("npz ") {
        let samples = npy_f64("(6, 2)", (0..12).map(|i| f64::from(i % 5)));
        let mut all = vec![("v.npy".to_owned(), samples)];
        all.extend(members.split("; ").map(member));
        let all: Vec<(&str, &[u8])> = all
            .iter()
            .map(|(name, bytes)| (&name[..], &bytes[..]))
            .collect();
        return npz(CompressionMethod::Stored, &all);
    }
    if let Some(name) = text.strip_prefix("numpy ") {
        return super::formats::numpy_bytes(name);
    }
    match text
        .strip_prefix("npy ")
        .map(|it| it.split(' ').collect::<Vec<_>>())
    {
        Some(parts) => npy(
            parts[0],
            &parts[1].replace(',', ", "),
            &vec![0; parts[2].parse().unwrap()],
        ),
        None => unescaped(text),
    }
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
fn holds(field: &Field, expected: &str) -> bool {
    let (key, value) = expected.split_once(' ').unwrap();
    let unit = field.unit.as_deref().unwrap_or("-");
    let mut notes = field.notes.iter();
    match key {
        "shape" => value == format!("{} {}", field.n_times(), field.n_sites()),
        "v" => {
            let rows = test_support::made::values(field);
            let rows = rows.outer_iter().map(|row| row.to_vec());
            let theirs = value
                .split(" / ")
                .map(|row| row.split(' ').map(|v| v.parse().unwrap()));
            let theirs: Vec<Vec<f64>> = theirs.map(Iterator::collect).collect();
            // Gaps are NaN on both sides.
            format!("{:?}", rows.collect::<Vec<_>>()) == format!("{theirs:?}")
        }
        "time" => is_axis(&field.time, value),
        "space" => is_axis(&field.space, value),
        "unit" => unit == value,
        "quantity" => format!("{:?}", field.quantity).to_lowercase() == value,
        "codes" => {
            notes.map(|note| note.code).collect::<Vec<_>>().join(" ") == value.replace("none", "")
        }
        "says" => notes.any(|note| note.text.contains(value)),
        "doubts" => notes.any(|note| note.is_doubtful && note.text.contains(value)),
        _ => panic!("{key} of {expected}"),
    }
}

#[test]
fn val_definition_files_and_what_is_read_of_them() {
    let folder = Folder::new();
    let mut wrong = Vec::new();
    let rows = include_str!("read.txt").lines();
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let parts: Vec<&str> = row.split(" | ").collect();
        let (name, words) = parts[0].split_once(' ').unwrap_or((parts[0], ""));
        let opened = Field::open(folder.write(name, file(parts[1])), &options(words));
        let is_right = |expected: &str| match (&opened, expected.strip_prefix("refused ")) {
            (Ok(field), None) => holds(field, expected),
            (Err(error), Some(words)) => error.to_string().contains(words),
            _ => false,
        };
        if let Some(missed) = parts[2].split(" ; ").find(|one| !is_right(one)) {
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
