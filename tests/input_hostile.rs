//! Damaged, lying and misplaced files are refused with the fault they have, without a panic,
//! without a large allocation, and in bounded time.

use std::io::{Cursor, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use cascade::field::{FileKind, Header, InputFault, Layout, OpenOptions, TimeColumn};
use cascade::{Error, Field};
use proptest::prelude::*;
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, DateTime};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn refusal(name: &str, bytes: impl AsRef<[u8]>, options: &OpenOptions) -> Error {
    let folder = Folder::new();
    let path = folder.write(name, bytes);
    let started = Instant::now();
    let error = Field::open(&path, options).expect_err("the file is refused");
    assert!(started.elapsed() < Duration::from_secs(5));
    assert!(error.advice().is_some(), "{error}");
    error
}

fn fault(name: &str, bytes: impl AsRef<[u8]>) -> InputFault {
    fault_with(name, bytes, &OpenOptions::default())
}

fn fault_with(name: &str, bytes: impl AsRef<[u8]>, options: &OpenOptions) -> InputFault {
    match refusal(name, bytes, options) {
        Error::Input { fault, .. } => fault,
        other => panic!("{other}"),
    }
}

fn npy_with_header(text: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    npy_with_header(&text, data)
}

fn npy_f64(shape: &str, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    let data: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    npy("<f8", shape, &data)
}

fn npz(method: CompressionMethod, members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .last_modified_time(DateTime::default());
    for (name, bytes) in members {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn member_fault(fault: InputFault) -> (String, InputFault) {
    match fault {
        InputFault::Member { member, fault } => (member, *fault),
        other => panic!("{other}"),
    }
}

const BOTH: [CompressionMethod; 2] = [CompressionMethod::Stored, CompressionMethod::Deflated];

#[test]
fn what_is_not_a_file() {
    let folder = Folder::new();
    let error = Field::open(folder.0.path(), &OpenOptions::default()).unwrap_err();
    let Error::Input { fault, .. } = error else {
        panic!("{error}");
    };
    assert_eq!(
        fault,
        InputFault::NotAFile {
            found: FileKind::Directory
        }
    );
    let missing = folder.0.path().join("missing.npy");
    let error = Field::open(&missing, &OpenOptions::default()).unwrap_err();
    assert!(matches!(&error, Error::Read { path, .. } if *path == missing));
    assert!(error.advice().is_some());
    assert_eq!(fault_of_empty(), InputFault::Empty);
}

fn fault_of_empty() -> InputFault {
    fault("field.npy", b"")
}

#[cfg(unix)]
#[test]
fn a_pipe_does_not_hang() {
    let folder = Folder::new();
    for name in ["field.npy", "other.toml"] {
        let path = folder.0.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
    }
    folder.write("other.npy", npy_f64("(2, 1)", [1.0, 2.0]));
    for name in ["field.npy", "other.npy"] {
        let error = Field::open(folder.0.path().join(name), &OpenOptions::default()).unwrap_err();
        let Error::Input { fault, .. } = error else {
            panic!("{error}");
        };
        let found = FileKind::Pipe;
        assert_eq!(fault, InputFault::NotAFile { found });
    }
}

#[test]
fn other_formats_are_named() {
    let found = |name, bytes: &[u8]| match fault(name, bytes) {
        InputFault::UnknownFormat { found } => found,
        other => panic!("{other}"),
    };
    assert_eq!(found("field.npy", b"\x89HDF\r\n\x1a\nxxxx"), "an HDF5 file");
    assert_eq!(found("field.csv", b"\x1f\x8bxxxx"), "a gzip file");
    assert_eq!(found("field.dat", b"1 2 3"), "the extension \"dat\"");
    assert_eq!(found("field", b"1 2 3"), "the extension \"\"");
}

#[test]
fn npy_magic_and_version() {
    let bytes = fault("field.npy", b"\x93NUMPX\x01\x00");
    assert_eq!(
        bytes,
        InputFault::NpyMagic {
            found: b"\x93NUMPX".to_vec()
        }
    );
    for (major, minor) in [(0, 0), (1, 1), (4, 0), (255, 255)] {
        let mut bytes = npy_f64("(1, 1)", [0.0]);
        bytes[6..8].copy_from_slice(&[major, minor]);
        let expected = InputFault::NpyVersion { major, minor };
        assert_eq!(fault("field.npy", bytes), expected);
    }
}

#[test]
fn npy_header_that_is_cut_or_endless() {
    for len in 6..20 {
        let bytes = &npy_f64("(1, 1)", [0.0])[..len];
        let InputFault::Truncated { found, .. } = fault("field.npy", bytes) else {
            panic!("{len}");
        };
        assert_eq!(found, len as u64);
    }
    let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
    bytes.extend(u32::MAX.to_le_bytes());
    bytes.extend(b"{'descr'");
    assert_eq!(
        fault("field.npy", bytes),
        InputFault::NpyHeaderLength {
            found: u64::from(u32::MAX),
            limit: 65_536
        }
    );
}

#[test]
fn npy_header_with_deep_nesting() {
    let deep = "[".repeat(60_000);
    for text in [
        format!("{{'descr': {deep}"),
        format!("{{'descr': '<f8', 'shape': {deep}"),
        format!("{{'descr': '<f8', 'shape': ({}", "(".repeat(60_000)),
        "{".repeat(60_000),
    ] {
        let fault = fault("field.npy", npy_with_header(&text, b""));
        assert!(
            matches!(
                fault,
                InputFault::NpyHeader { .. } | InputFault::StructuredType { .. }
            ),
            "{fault}"
        );
    }
}

#[test]
fn npy_header_fault_says_where() {
    let text = "{'descr': '<f8', 'fortran_order': Maybe, 'shape': (1, 1)}";
    assert_eq!(
        fault("field.npy", npy_with_header(text, b"")),
        InputFault::NpyHeader {
            at: 10 + text.find("Maybe").unwrap(),
            expected: "True or False",
            found: "Maybe, 'shape': (1, 1)}".into()
        }
    );
}

#[test]
fn npy_types_that_are_no_samples() {
    assert_eq!(
        fault("field.npy", npy("|O", "(2, 2)", b"\x80\x04")),
        InputFault::PickledObjects
    );
    let record = "{'descr': [('a', '<f8'), ('b', '<i4')], 'fortran_order': False, 'shape': (2,)}";
    assert!(matches!(
        fault("field.npy", npy_with_header(record, b"")),
        InputFault::StructuredType { descr } if descr.starts_with("[('a', '<f8')")
    ));
    let descr = "|V16".to_owned();
    assert_eq!(
        fault("field.npy", npy("|V16", "(2, 2)", b"")),
        InputFault::StructuredType { descr }
    );
    let descr = "<c16".to_owned();
    assert_eq!(
        fault("field.npy", npy("<c16", "(1, 1)", &[0; 16])),
        InputFault::ComplexType { descr }
    );
    for descr in ["<f16", "<U4", "<M8[ns]", "<f", "", "<", "<i3", "f88"] {
        let expected = InputFault::SampleType {
            descr: descr.into(),
        };
        assert_eq!(fault("field.npy", npy(descr, "(1, 1)", &[0; 16])), expected);
    }
}

#[test]
fn npy_shapes_that_are_no_field() {
    let eight = [0; 64];
    let shape_of = |shape: &str| fault("field.npy", npy("<f8", shape, &eight));
    assert_eq!(shape_of("()"), InputFault::Dimensions { shape: vec![] });
    let shape = vec![2, 2, 2];
    assert_eq!(shape_of("(2, 2, 2)"), InputFault::Dimensions { shape });
    for shape in [vec![0, 8], vec![8, 0], vec![0, u64::MAX]] {
        let text = format!("({}, {})", shape[0], shape[1]);
        assert_eq!(shape_of(&text), InputFault::NoSamples { shape });
    }
    assert_eq!(shape_of("(0,)"), InputFault::NoSamples { shape: vec![0] });
}

#[test]
fn npy_lengths_that_lie() {
    let data = [0; 64];
    for shape in [
        "(4294967296, 4294967296)",
        "(18446744073709551615, 2)",
        "(99999999999999999999999999, 1)",
        "(1152921504606846976,)",
    ] {
        let fault = fault("field.npy", npy("<f8", shape, &data));
        assert!(
            matches!(
                fault,
                InputFault::TooLarge {
                    sample_bytes: 8,
                    ..
                }
            ),
            "{shape}: {fault}"
        );
    }
    let terabytes = npy("<f8", "(1000000, 1000000)", &data);
    let found = terabytes.len() as u64;
    let expected = found - 64 + 8_000_000_000_000;
    assert_eq!(
        fault("field.npy", terabytes),
        InputFault::Truncated { expected, found }
    );
    let whole = npy_f64("(4, 2)", (0..8).map(f64::from));
    let expected = whole.len() as u64;
    assert_eq!(
        fault("field.npy", &whole[..whole.len() - 1]),
        InputFault::Truncated {
            expected,
            found: expected - 1
        }
    );
    let longer = [&whole[..], b"\n"].concat();
    assert_eq!(
        fault("field.npy", longer),
        InputFault::TrailingBytes {
            expected,
            found: expected + 1
        }
    );
}

#[test]
fn npz_that_is_damaged() {
    let field = npy_f64("(4, 2)", (0..8).map(f64::from));
    for method in BOTH {
        let whole = npz(method, &[("velocity.npy", &field)]);
        for len in [30, whole.len() / 2, whole.len() - 1] {
            let fault = fault("field.npz", &whole[..len]);
            assert!(matches!(fault, InputFault::Archive { .. }), "{fault}");
        }
    }
    let fault = fault("field.npz", b"not an archive");
    assert!(matches!(fault, InputFault::Archive { .. }), "{fault}");
}

#[test]
fn npz_whose_directory_is_absurd() {
    let mut end = b"PK\x05\x06".to_vec();
    end.extend([0; 4]);
    end.extend([0xfe; 12]);
    end.extend([0; 2]);
    let fault_of = |bytes: &[u8]| {
        let fault = fault("field.npz", bytes);
        assert!(matches!(fault, InputFault::Archive { .. }), "{fault}");
    };
    fault_of(&end);
    fault_of(&[&b"PK\x03\x04"[..], &[0; 1000], &end].concat());
    fault_of(&[&b"PK\x03\x04"[..], &end.repeat(3000)].concat());
    let empty = npz(CompressionMethod::Stored, &[]);
    assert_eq!(
        fault("field.npz", empty),
        InputFault::WhichMember { members: vec![] }
    );
}

#[test]
fn npz_bytes_that_changed() {
    let field = npy_f64("(40, 2)", (0..80).map(f64::from));
    let mut stored = npz(CompressionMethod::Stored, &[("velocity.npy", &field)]);
    let at = stored.windows(8).position(|w| w == 7f64.to_le_bytes());
    stored[at.unwrap() + 3] ^= 1;
    let (member, fault_of_stored) = member_fault(fault("field.npz", stored));
    assert_eq!(member, "velocity");
    assert!(matches!(fault_of_stored, InputFault::Checksum { .. }));

    let whole = npz(CompressionMethod::Deflated, &[("velocity.npy", &field)]);
    let mut faults = 0;
    for at in 200..240 {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        let (_, fault) = member_fault(fault("field.npz", bytes));
        assert!(
            matches!(
                fault,
                InputFault::Checksum { .. }
                    | InputFault::Deflate { .. }
                    | InputFault::InflatedSize { .. }
            ),
            "{fault}"
        );
        faults += 1;
    }
    assert_eq!(faults, 40);
}

#[test]
fn npz_member_that_is_not_what_its_header_says() {
    let short = npy_f64("(4, 2)", (0..7).map(f64::from));
    let long = npy_f64("(4, 2)", (0..9).map(f64::from));
    let terabytes = npy_f64("(1000000, 1000000)", (0..8).map(f64::from));
    for (bytes, is_short) in [(&short, true), (&long, false), (&terabytes, true)] {
        let stored = npz(CompressionMethod::Stored, &[("a.npy", bytes)]);
        let (_, fault_of_stored) = member_fault(fault("field.npz", stored));
        match fault_of_stored {
            InputFault::Truncated { .. } => assert!(is_short),
            InputFault::TrailingBytes { .. } => assert!(!is_short),
            other => panic!("{other}"),
        }
        let deflated = npz(CompressionMethod::Deflated, &[("a.npy", bytes)]);
        let (_, fault) = member_fault(fault("field.npz", deflated));
        let InputFault::InflatedSize { expected, found } = fault else {
            panic!("{fault}");
        };
        assert_eq!(expected > found, is_short);
    }
}

#[test]
fn npz_bomb_stays_within_its_header_and_the_memory_allowed() {
    let header = npy("<f8", "(4, 2)", &[]);
    let bomb = [&header[..], &vec![0; 64 << 20]].concat();
    let archive = npz(CompressionMethod::Deflated, &[("velocity.npy", &bomb)]);
    let (_, fault_of_bomb) = member_fault(fault("field.npz", &archive));
    let expected = header.len() as u64 + 64;
    assert!(matches!(
        fault_of_bomb,
        InputFault::InflatedSize { expected: e, .. } if e == expected
    ));

    let mut lying = archive.clone();
    let size = (bomb.len() as u32).to_le_bytes();
    while let Some(at) = lying.windows(4).position(|window| window == size) {
        lying[at..at + 4].copy_from_slice(&(expected as u32).to_le_bytes());
    }
    let (_, fault) = member_fault(fault("field.npz", lying));
    assert!(
        matches!(&fault, InputFault::Deflate { reason } if reason.contains("larger")),
        "{fault}"
    );

    let large = npy("<f8", "(1024, 1024)", &vec![0; 8 << 20]);
    let archive = npz(CompressionMethod::Deflated, &[("velocity.npy", &large)]);
    let options = OpenOptions {
        memory: Some(1 << 20),
        ..OpenOptions::default()
    };
    match refusal("field.npz", archive, &options) {
        Error::Memory {
            needed, allowed, ..
        } => assert_eq!((needed, allowed), (large.len() as u64, 1 << 20)),
        other => panic!("{other}"),
    }
}

#[test]
fn npz_members_are_listed_where_the_choice_is_open() {
    let matrix = npy_f64("(2, 1)", [0.0, 1.0]);
    let record = npy_f64("(2,)", [0.0, 1.0]);
    let members: &[(&str, &[u8])] = &[
        ("a.npy", &matrix),
        ("b.npy", &matrix),
        ("t.npy", &record),
        ("note.txt", b"hello"),
        ("torn.npy", &matrix[..9]),
    ];
    for method in BOTH {
        let archive = npz(method, members);
        let InputFault::WhichMember { members } = fault("field.npz", &archive) else {
            panic!();
        };
        let listed: Vec<_> = members
            .iter()
            .map(|member| (member.name.as_str(), member.shape.as_deref()))
            .collect();
        let expected: [(&str, Option<&[u64]>); 4] = [
            ("a", Some(&[2, 1])),
            ("b", Some(&[2, 1])),
            ("t", Some(&[2])),
            ("torn", None),
        ];
        assert_eq!(listed, expected);

        let options = OpenOptions {
            member: Some("c".into()),
            ..OpenOptions::default()
        };
        let fault = fault_with("field.npz", &archive, &options);
        assert!(matches!(
            fault,
            InputFault::NoSuchMember { name, members } if name == "c" && members.len() == 4
        ));
    }
}

#[test]
fn npz_coordinates_that_do_not_fit() {
    let field = npy_f64("(3, 2)", (0..6).map(f64::from));
    let with_time = |time: &[u8]| {
        npz(
            CompressionMethod::Stored,
            &[("velocity.npy", &field), ("time.npy", time)],
        )
    };
    let (member, fault_of_length) =
        member_fault(fault("run.npz", with_time(&npy_f64("(2,)", [0.0, 1.0]))));
    assert_eq!(member, "time");
    assert_eq!(
        fault_of_length,
        InputFault::AxisLength {
            axis: "time",
            expected: 3,
            found: 2
        }
    );
    let uneven = with_time(&npy_f64("(3,)", [0.0, 1.0, 2.5]));
    let (_, fault) = member_fault(fault("run.npz", &uneven));
    let expected = InputFault::UnevenAxis {
        axis: "time",
        index: 1,
        expected: 1.5,
        found: 1.0,
    };
    assert_eq!(fault, expected);

    let folder = Folder::new();
    let options = OpenOptions {
        dt: Some(1.25),
        ..OpenOptions::default()
    };
    let field = Field::open(folder.write("run.npz", uneven), &options).unwrap();
    assert_eq!((field.time.origin, field.time.step), (0.0, 1.25));
}

#[test]
fn tables_that_are_no_table() {
    assert_eq!(fault("field.csv", "# nothing\n"), InputFault::NoRows);
    assert_eq!(fault("field.csv", "\n\n\n"), InputFault::NoRows);
    assert_eq!(fault("field.csv", "time,v0,v1\n"), InputFault::NoRows);
    assert_eq!(fault("field.csv", "time\n0\n1\n"), InputFault::NoColumns);
    let utf16: Vec<u8> = "1,2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let marked = [b"\xff\xfe", &utf16[..]].concat();
    let found = "UTF-16";
    assert_eq!(fault("field.csv", marked), InputFault::Encoding { found });
    let found = "binary data";
    assert_eq!(fault("field.csv", utf16), InputFault::Encoding { found });
}

#[test]
fn tables_with_a_bad_row_or_cell() {
    for (text, line, found) in [("1,2\n3,4\n\n5\n", 4, 1), ("a,b\n1,2,3\n", 2, 3)] {
        let expected = 2;
        assert_eq!(
            fault("field.csv", text),
            InputFault::Ragged {
                line,
                expected,
                found
            }
        );
    }
    for (text, line, column, found) in [
        ("1,2\n3,4x\n", 2, 2, "4x"),
        ("1.0x,2\n3,4\n", 1, 1, "1.0x"),
        ("# c\ntime,v\n0,1\n,2\n", 4, 1, ""),
        ("1;2\n3;4,5\n5;6\n", 2, 2, "4,5"),
        ("1,2\r\n3,4\r\n5,6\r\n7,8x\r\n", 4, 2, "8x"),
        ("1 2\r\n# c\r\n 3   4a \r\n", 3, 2, "4a"),
    ] {
        let result = fault("field.csv", text);
        let found = found.to_owned();
        let expected = InputFault::Cell {
            line,
            column,
            found,
        };
        assert_eq!(result, expected, "{text}");
    }
}

#[test]
fn tables_whose_times_skip() {
    let text = "time_s,v0\n0.0,1\n0.1,2\n0.2,3\n0.4,4\n0.5,5\n";
    let InputFault::UnevenTimes {
        line,
        expected,
        found,
    } = fault("field.csv", text)
    else {
        panic!();
    };
    assert_eq!(line, 5);
    assert!((expected - 0.1).abs() < 1e-12 && (found - 0.2).abs() < 1e-12);
}

#[test]
fn table_columns_that_are_not_there() {
    let asked_for = |time_column, text: &str| {
        let options = OpenOptions {
            time_column,
            ..OpenOptions::default()
        };
        match fault_with("field.csv", text, &options) {
            InputFault::NoSuchColumn { asked, columns } => (asked, columns),
            other => panic!("{other}"),
        }
    };
    let columns = vec!["a".to_owned(), "b".to_owned()];
    let by_name = asked_for(TimeColumn::Name("when".into()), "a,b\n1,2\n");
    assert_eq!(by_name, ("\"when\"".into(), columns));
    let columns = vec!["0".to_owned(), "1".to_owned()];
    let by_index = asked_for(TimeColumn::Index(2), "1,2\n3,4\n");
    assert_eq!(by_index, ("2".into(), columns));

    let options = OpenOptions {
        time_column: TimeColumn::Index(0),
        layout: Some(Layout::SiteTime),
        ..OpenOptions::default()
    };
    let folder = Folder::new();
    let error = Field::open(folder.write("field.csv", "1,2\n3,4\n"), &options).unwrap_err();
    assert!(matches!(
        error,
        Error::Request {
            option: "time-column",
            ..
        }
    ));
}

#[test]
fn a_table_stays_within_the_memory_allowed() {
    let options = OpenOptions {
        memory: Some(7_999),
        header: Header::Absent,
        ..OpenOptions::default()
    };
    let text = "1,2,3,4\n".repeat(250);
    assert!(matches!(
        refusal("field.csv", text, &options),
        Error::Memory { allowed: 7_999, .. }
    ));
    let endless = format!("1,2\n\"{}", "0".repeat(40 << 20));
    assert_eq!(
        fault("field.csv", endless),
        InputFault::RowLength {
            line: 2,
            limit: 16 << 20
        }
    );
}

#[test]
fn sidecars_that_mislead() {
    let folder = Folder::new();
    let path = folder.write("field.npy", npy_f64("(2, 1)", [1.0, 2.0]));
    let refused = || match Field::open(&path, &OpenOptions::default()) {
        Err(Error::Input { path, fault }) => (path, fault),
        other => panic!("{other:?}"),
    };
    let replaced = folder.write("field.toml", "dt = 0.5\n\ndx = 0\n");
    let (at, fault) = refused();
    assert_eq!(at, replaced);
    assert_eq!(
        fault,
        InputFault::Sidecar {
            line: Some(3),
            key: Some("dx".into()),
            reason: "expected a finite number above 0, found 0".into()
        }
    );
    folder.write("field.npy.toml", "dt = 0.5\n");
    let (at, fault) = refused();
    assert_eq!(at, path);
    assert!(matches!(fault, InputFault::TwoSidecars { .. }));
    std::fs::remove_file(&replaced).unwrap();
    assert!(Field::open(&path, &OpenOptions::default()).is_ok());
    folder.write("field.npy.toml", "#".repeat(70_000));
    assert!(matches!(refused().1, InputFault::SidecarLength { .. }));
    folder.write("field.npy.toml", b"unit = \"\xff\"\n");
    assert!(Field::open(&path, &OpenOptions::default()).is_err());
}

#[test]
fn stated_steps_that_are_no_step() {
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = OpenOptions {
            dt: Some(dt),
            ..OpenOptions::default()
        };
        let error = Field::open("field.npy", &options).unwrap_err();
        assert!(matches!(error, Error::Request { option: "dt", .. }));
    }
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
        let started = Instant::now();
        match Field::open(&path, &OpenOptions::default()) {
            Ok(field) => {
                let mut out = vec![0.0; field.n_times() * field.n_sites()];
                field.read_site_major(0..field.n_times(), 0..field.n_sites(), &mut out);
            }
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
                let _ = error.advice();
            }
        }
        prop_assert!(started.elapsed() < Duration::from_secs(2));
    }
}
