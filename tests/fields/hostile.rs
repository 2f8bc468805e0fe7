//! Damaged, lying and misplaced files are refused with the fault they have, without a panic,
//! without a large allocation, and in bounded time.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use test_support::fields::reading;
use test_support::hostile::{Folder, fault, npy, npy_f64, npy_with_header, npz, refusal};
use wavecascade::field::{Header, OpenOptions};
use wavecascade::{Error, Field};
use zip::CompressionMethod;

/// The file that is refused when this one is opened, and why.
fn refused_at(path: &Path) -> (PathBuf, String) {
    match Field::open(path, &OpenOptions::default()) {
        Err(Error::Input { path, fault }) => (path, fault.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_not_a_file() {
    let folder = Folder::new();
    let (_, said) = refused_at(folder.path());
    assert_eq!(said, "expected a file, found a directory");
    let missing = folder.path().join("missing.npy");
    let error = Field::open(&missing, &OpenOptions::default()).unwrap_err();
    assert!(matches!(&error, Error::Read { path, .. } if *path == missing));
    refused(b"", "expected samples, found an empty file");
}

#[cfg(unix)]
#[test]
fn a_pipe_does_not_hang() {
    let folder = Folder::new();
    for name in ["field.npy", "other.toml"] {
        let path = folder.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
    }
    folder.write("other.npy", npy_f64("(2, 1)", [1.0, 2.0]));
    for name in ["field.npy", "other.npy"] {
        let (_, said) = refused_at(&folder.path().join(name));
        assert_eq!(said, "expected a file, found a pipe");
    }
}

/// That an array is refused with these words.
fn refused(bytes: impl AsRef<[u8]>, words: &str) {
    let said = fault("field.npy", bytes).to_string();
    assert!(said.contains(words), "{said}, not {words}");
}

#[test]
fn npy_header_that_is_endless() {
    let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
    bytes.extend(u32::MAX.to_le_bytes());
    bytes.extend(b"{'descr'");
    refused(bytes, "found 4294967295");
    let deep = "[".repeat(60_000);
    for (text, words) in [
        (format!("{{'descr': {deep}"), "structured type"),
        (format!("{{'descr': '<f8', 'shape': {deep}"), "header, byte"),
        (
            format!("{{'descr': '<f8', 'shape': ({}", "(".repeat(60_000)),
            "header, byte",
        ),
        ("{".repeat(60_000), "header, byte"),
    ] {
        refused(npy_with_header(&text, b""), words);
    }
}

#[test]
fn npy_header_fault_says_where() {
    let text = "{'descr': '<f8', 'fortran_order': Maybe, 'shape': (1, 1)}";
    let at = 10 + text.find("Maybe").unwrap();
    let words = format!("byte {at}: expected True or False, found \"Maybe, 'shape': (1, 1)}}\"");
    refused(npy_with_header(text, b""), &words);
}

#[test]
fn npy_lengths_that_lie() {
    let terabytes = npy("<f8", "(1000000, 1000000)", &[0; 64]);
    let whole = npy_f64("(4, 2)", (0..8).map(f64::from));
    let cut = |expected, found| format!("expected {expected} bytes, found {found}: the file is");
    let (found, length) = (terabytes.len(), whole.len());
    refused(&terabytes, &cut(found - 64 + 8_000_000_000_000, found));
    refused(&whole[..length - 1], &cut(length, length - 1));
    refused([&whole[..], b"\n"].concat(), "1 bytes behind the array");
}

#[test]
fn sidecars_that_mislead() {
    let folder = Folder::new();
    let path = folder.write("field.npy", npy_f64("(2, 1)", [1.0, 2.0]));
    let replaced = folder.write("field.toml", "dt = 0.5\n\ndx = 0\n");
    let expected = "line 3: dx: expected a finite number above 0, found 0";
    assert_eq!(refused_at(&path), (replaced.clone(), expected.to_owned()));
    folder.write("field.npy.toml", "dt = 0.5\n");
    let (at, said) = refused_at(&path);
    assert_eq!(at, path);
    assert!(said.starts_with("expected one sidecar, found"), "{said}");
    std::fs::remove_file(&replaced).unwrap();
    assert!(Field::open(&path, &OpenOptions::default()).is_ok());
    folder.write("field.npy.toml", "#".repeat(70_000));
    let expected = "expected at most 65536 bytes of settings, found 70000";
    assert_eq!(refused_at(&path).1, expected);
    folder.write("field.npy.toml", b"unit = \"\xff\"\n");
    assert!(Field::open(&path, &OpenOptions::default()).is_err());
}

#[test]
fn stated_steps_that_are_no_step() {
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = reading(|it| it.dt = Some(dt.into()));
        let error = Field::open("field.npy", &options).unwrap_err();
        assert!(matches!(error, Error::Request { option: "dt", .. }));
    }
}

#[test]
fn a_table_stays_within_the_memory_allowed() {
    let options = reading(|it| (it.memory, it.header) = (Some(7_999), Header::Absent));
    let text = "1,2,3,4\n".repeat(250);
    assert!(matches!(
        refusal("field.csv", text, &options),
        Error::Memory { allowed: 7_999, .. }
    ));
    let endless = format!("1,2\n\"{}", "0".repeat(40 << 20));
    let said = fault("field.csv", endless).to_string();
    assert_eq!(
        said,
        "line 2: expected a row of at most 16777216 bytes, found a longer one"
    );
}

fn valid_files() -> Vec<(&'static str, Vec<u8>)> {
    let field = npy_f64("(12, 5)", (0..60).map(|i| f64::from(i).sin()));
    let time = npy_f64("(12,)", (0..12).map(f64::from));
    let members: &[(&str, &[u8])] = &[("velocity.npy", &field), ("time.npy", &time)];
    let table: String = (0..12).map(|n| format!("{n},{n}.5,nan,,-1e3\n")).collect();
    vec![
        ("field.npy", field.clone()),
        ("stored.npz", npz(CompressionMethod::Stored, members)),
        ("deflated.npz", npz(CompressionMethod::Deflated, members)),
        ("table.csv", format!("time,a,b,\"c\",d\n{table}").into()),
        (
            "blank.txt",
            format!("# x\n{}", table.replace(",,", ",0,").replace(',', "  ")).into(),
        ),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn mutated_files_are_read_or_refused(
        which in 0usize..5,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        keep in prop::option::of(any::<prop::sample::Index>()),
        insert in prop::option::of((any::<prop::sample::Index>(), prop::collection::vec(any::<u8>(), 1..9))),
    ) {
        let (name, mut bytes) = valid_files().swap_remove(which);
        for (at, byte) in &edits {
            let at = at.index(bytes.len());
            bytes[at] = *byte;
        }
        if let Some((at, extra)) = insert {
            let at = at.index(bytes.len());
            bytes.splice(at..at, extra);
        }
        if let Some(keep) = keep {
            bytes.truncate(keep.index(bytes.len()));
        }
        let folder = Folder::new();
        let path = folder.write(name, bytes);
        match Field::open(&path, &OpenOptions::default()) {
            Ok(field) => {
                let mut out = vec![0.0; field.n_times() * field.n_sites()];
                field.read_site_major(0..field.n_times(), 0..field.n_sites(), &mut out);
            }
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
            }
        }
    }
}
