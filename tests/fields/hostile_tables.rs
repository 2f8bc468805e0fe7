//! Tables of text that are no tables, or not all of one.

use test_support::fields::reading;
use test_support::hostile::{Folder, fault, fault_with, refusal};
use wavecascade::error::InputFault;
use wavecascade::field::{Header, Layout, OpenOptions, TimeColumn};
use wavecascade::{Error, Field};

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
fn val_a_last_comment_without_a_line_end_is_no_row() {
    let folder = Folder::new();
    for (name, comment) in [
        ("plain.csv", "1,2\n3,4\n# end"),
        ("hash.csv", "1,2\n3,4\n#"),
        ("numbers.csv", "1,2\n3,4\n#5,6"),
        ("blanks.csv", "1 2\n3 4\n  # end"),
        ("return.csv", "1,2\r\n3,4\r\n# end"),
        ("none.csv", "1,2\n3,4"),
        ("quoted.csv", "1,2\n3,\"4\""),
    ] {
        let path = folder.write(name, comment);
        let field = Field::open(path, &OpenOptions::default()).unwrap();
        assert_eq!((field.n_times(), field.n_sites()), (2, 2), "{name}");
        let mut values = [0.0; 4];
        field.read_time_major(0..2, 0..2, &mut values);
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0], "{name}");
    }
    assert_eq!(fault("field.csv", "# only"), InputFault::NoRows);
}

#[test]
fn regress_a_damaged_first_value_of_one_column_is_no_name() {
    for first in ["1.0x", "q.250", "-0.5.0", "1..0", "\u{b1}.25"] {
        let expected = InputFault::Cell {
            line: 1,
            column: 1,
            found: first.to_owned(),
        };
        assert_eq!(fault("field.csv", format!("{first}\n2\n3\n")), expected);
    }
    let folder = Folder::new();
    for name in ["v", "v1", "(m/s)", "velocity (m/s)"] {
        let path = folder.write("field.csv", format!("{name}\n2\n3\n"));
        let field = Field::open(path, &OpenOptions::default()).unwrap();
        assert_eq!(field.n_times(), 2, "{name}");
    }
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
        ("1.0;2\n3;4,5\n5;6\n", 2, 2, "4,5"),
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
        let options = reading(|it| it.time_column = time_column);
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
    let options = reading(|it| (it.memory, it.header) = (Some(7_999), Header::Absent));
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
