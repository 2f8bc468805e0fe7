//! Tables as instruments and spreadsheets write them.
//!
//! The forms are those of the files of Tektronix, Keysight, Rigol, LeCroy, Siglent and PicoScope; numbers are
//! those of the text.

use test_support::changed;
use test_support::fields::reading;
use test_support::hostile::{Folder, fault};
use test_support::made::{axis_at as axis, values};
use wavecascade::Field;
use wavecascade::error::InputFault;
use wavecascade::field::{Axis, OpenOptions, Quantity, TimeColumn};

use crate::note;

fn table(name: &str, text: &str) -> Field {
    table_with(name, text, &OpenOptions::default())
}

fn table_with(name: &str, text: &str, options: &OpenOptions) -> Field {
    let folder = Folder::new();
    let path = folder.write(name, text);
    Field::open(path, options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn codes(field: &Field) -> Vec<&'static str> {
    field.notes.iter().map(|note| note.code).collect()
}

#[test]
fn val_definition_oscilloscopes() {
    let v = [[0.25, 2.0], [0.5, 1.0], [-0.125, 4.0]];
    let one = ndarray::array![[0.25], [0.5], [-0.125]];
    let both = ndarray::arr2(&v);
    let volt = Some("V");
    for (maker, text, time, unit, expected) in [
        (
            "Tektronix MSO",
            "Model,MSO4\nFirmware Version,1.0\n\nHorizontal Units,s\nSample Interval,1e-05\nRecord Length,3\n\
             Probe Attenuation,1,1\nVertical Units,V,V\n,,\nLabel,,\nTIME,CH1,CH2\n\
             -8.00e-03,0.25,2\n-7.99e-03,0.5,1\n-7.98e-03,-0.125,4\n",
            axis(-8e-3, 1e-5, Some("s")),
            volt,
            &both,
        ),
        (
            // Times of fewer digits than the interval has.
            "Tektronix DPO",
            "Model,DPO2014\nHorizontal Units,s\nSample Interval,4e-9\nVertical Units,V\nTIME,CH1\n\
             -1.00000e-03,0.25\n-1.00000e-03,0.5\n-0.99999e-03,-0.125\n",
            axis(-1e-3, 4e-9, Some("s")),
            volt,
            &one,
        ),
        (
            "Tektronix TDS",
            "Record Length,3.0e+00,,-0.000500000000,   0.25000,\n\
             Sample Interval,2.0e-05,Seconds,-0.000480000000,   0.50000,\nVertical Units,V,,-0.000460000000,  -0.12500,\n",
            axis(-5e-4, 2e-5, Some("s")),
            volt,
            &one,
        ),
        (
            "Keysight InfiniiVision",
            "x-axis,1,2\nsecond,Volt,Volt\n-1.0E-03,+0.25E+00,+2.0E+00\n+0.0E-03,+0.5E+00,+1.0E+00\n\
             +1.0E-03,-0.125E+00,+4.0E+00\n",
            axis(-1e-3, 1e-3, Some("s")),
            volt,
            &both,
        ),
        (
            "Keysight Infiniium",
            "Revision:,0\nType:,raw\nPoints:,3\nXInc:,5.0E-11\nXOrg:,-1.0E-09\nXUnits:,Second\nYUnits:,Volt\nData:,\n\
             0.25\n0.5\n-0.125\n",
            axis(-1e-9, 5e-11, Some("s")),
            volt,
            &one,
        ),
        (
            "Rigol DS1000Z",
            "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-6.0e-04,1.0e-06\n0,0.25,2.0,,\n1,0.5,1.0,,\n2,-0.125,4.0,,\n",
            axis(-6e-4, 1e-6, Some("s")),
            volt,
            &both,
        ),
        (
            "Rigol MSO5000",
            "CH1(V),CH2(V),t0 =-0.0005, tInc = 1e-06,\n0.25,2.0,,\n0.5,1.0,,\n-0.125,4.0,,\n",
            axis(-5e-4, 1e-6, Some("s")),
            volt,
            &both,
        ),
        (
            "Rigol DHO",
            "Time(s),CH1(V),CH2(V)\n-2e-3,0.25,2\n-1e-3,0.5,1\n0,-0.125,4\n",
            axis(-2e-3, 1e-3, Some("s")),
            volt,
            &both,
        ),
        (
            "LeCroy",
            "LECROYWS44Xs,1,Waveform\nSegments,1,SegmentSize,3\nSegment,TrigTime,TimeSinceSegment1\n\
             #1,03-Feb-2024 10:00:00,0\nTime,Ampl\n-1e-3,0.25\n0,0.5\n1e-3,-0.125\n",
            axis(-1e-3, 1e-3, None),
            None,
            &one,
        ),
        (
            "Siglent",
            "Record Length,Analog:3\nSample Interval,Analog:0.001\nVertical Units,CH1:V\nSecond,Volt\n\
             -0.001,0.25\n0.000,0.5\n0.001,-0.125\n",
            axis(-1e-3, 1e-3, Some("s")),
            volt,
            &one,
        ),
        (
            "PicoScope",
            "Time,Channel A,Channel B\n(us),(V),(V)\n\n-8.00000000,0.25000000,2.0\n-7.99000000,0.5,1.0\n-7.98000000,-0.125,4.0\n",
            axis(-8.0, 0.01, Some("us")),
            volt,
            &both,
        ),
        (
            "PicoScope, German",
            "Zeit;Kanal A;Kanal B\r\n(ms);(V);(V)\r\n\r\n-8,00000;0,2500;2,0000\r\n-7,99000;0,5000;1,0000\r\n-7,98000;-0,1250;4,0000\r\n",
            axis(-8.0, 0.01, Some("ms")),
            volt,
            &both,
        ),
    ] {
        let field = table("scope.csv", text);
        assert_eq!(values(&field), expected, "{maker}");
        let found = changed(field.time.clone(), |it| it.step = field.time.step);
        assert_eq!(found.origin, time.origin, "{maker}");
        assert_eq!(found.unit, time.unit, "{maker}");
        let error = found.step / time.step - 1.0;
        assert!(error.abs() < 1e-12, "{maker}: {}", found.step);
        assert_eq!(field.unit.as_deref(), unit, "{maker}");
        assert_eq!(field.space, Axis::index(), "{maker}");
    }
}

#[test]
fn val_definition_units_of_channels() {
    let field = table(
        "a.csv",
        "time (s),a (mm/s),b (mm/s)\n0,1,2\n0.5,3,4\n1,5,6\n",
    );
    assert_eq!(field.unit.as_deref(), Some("mm/s"));
    assert_eq!(field.quantity, Quantity::Velocity);
    let field = table("a.csv", "Time,A,B\n(ms),(V),(mV)\n0,1,2\n1,3,4\n2,5,6\n");
    assert_eq!(field.unit, None);
    let remark = note(&field, "remark").unwrap();
    assert!(remark.text.contains("V and mV"), "{remark:?}");
}

#[test]
fn val_definition_columns_that_count_rows() {
    let expected = ndarray::array![[5.0, 1.0], [2.0, 7.0], [3.0, 8.0]];
    for head in [
        ",time,a,b",
        "index,time,a,b",
        "Sample,time,a,b",
        "sample number,time,a,b",
        "Unnamed: 0,time,a,b",
        "#,time,a,b",
    ] {
        for first in [0, 1, 17] {
            let rows = ["0.00,5,1", "0.25,2,7", "0.50,3,8"];
            let rows = rows.iter().enumerate();
            let rows: String = rows
                .map(|(n, row)| format!("{},{row}\n", n + first))
                .collect();
            // Such a line of names would be a comment.
            let text = format!("{head}\n{rows}").replace("#,", "\"#\",");
            let field = table("a.csv", &text);
            assert_eq!(values(&field), expected, "{text}");
            assert_eq!(field.time, axis(0.0, 0.25, None));
            assert_eq!(codes(&field), ["counted-rows"], "{text}");
        }
    }
    // Without names, beside a stated column of times.
    let options = reading(|it| it.time_column = TimeColumn::Index(1));
    let field = table_with("a.csv", "0,0.00,5,1\n1,0.25,2,7\n2,0.50,3,8\n", &options);
    assert_eq!(values(&field), expected);
    // Samples that do not count by one, or whose name says what they are.
    for text in [
        "index,time,a\n0,0.0,5\n2,0.1,2\n4,0.2,3\n",
        "velocity,time,a\n0,0.0,5\n1,0.1,2\n2,0.2,3\n",
    ] {
        assert_eq!(table("a.csv", text).n_sites(), 2, "{text}");
    }
}

#[test]
fn val_definition_a_separator_behind_the_last_cell() {
    let expected = ndarray::array![[5.0, 1.0], [2.0, 7.0], [3.0, 8.0]];
    for text in [
        "time,a,b,\n0,5,1,\n1,2,7,\n2,3,8,\n",
        "time,a,b\n0,5,1,\n1,2,7,\n2,3,8,\n",
        "time,a,b,\n0,5,1\n1,2,7\n2,3,8\n",
        "time;a;b;;\n0;5;1;;\n1;2;7;;\n2;3;8;;\n",
        "5,1,\n2,7,\n3,8,\n",
    ] {
        assert_eq!(values(&table("a.csv", text)), expected, "{text}");
    }
    // A named column without a value is a gap, and so is a value that is missing.
    assert_eq!(table("a.csv", "a,b,c\n5,1,\n2,7,\n3,8,\n").n_sites(), 3);
    assert_eq!(table("a.csv", "5,1,\n2,7,1\n3,8,\n").n_sites(), 3);
    let refused = fault("a.csv", "time,a,b\n0,5,1,\n1,2,7,4\n");
    assert!(
        matches!(refused, InputFault::Ragged { line: 3, .. }),
        "{refused}"
    );
}

#[test]
fn val_definition_decimal_commas() {
    let expected = ndarray::array![[0.5, -2.25], [3e-3, 4.0], [1.0, -5.0]];
    for text in [
        "0,5;-2,25\n3,0e-3;4\n1;-5\n",
        "a;b\n0,5;-2,25\n3,0e-3;4\n1;-5\n",
        "0,5\t-2,25\n3,0e-3\t4\n1\t-5\n",
        "  0,5   -2,25\n3,0e-3 4\n1 -5\n",
    ] {
        let field = table("a.txt", text);
        assert_eq!(values(&field), expected, "{text}");
        assert_eq!(codes(&field), ["decimal-commas"]);
    }
    for (text, line) in [
        ("0,5,1,25\n0,05,1,5\n", 2),
        ("0,000000,1,000000\n0,010000,0,980785\n", 1),
        ("t,a\n0,00,1,5\n", 2),
    ] {
        let refused = fault("a.csv", text);
        let is_it =
            matches!(refused, InputFault::DecimalCommas { line: found, .. } if found == line);
        assert!(is_it, "{text}: {refused}");
    }
    // Within quotes as well.
    assert!(matches!(
        fault("a.csv", "t,a\n\"0,01\",\"1,5\"\n"),
        InputFault::DecimalCommas { line: 2, .. }
    ));
    assert!(matches!(
        fault("a.csv", "0,01E+00,1,00E+00\n"),
        InputFault::DecimalCommas { .. }
    ));
    // Whole numbers, numbers with points, and settings.
    for text in [
        "0,10,20\n30,0,5\n",
        "0,00.5\n1,0\n",
        "Start,10,05\nTIME,a\n0,1\n1,2\n2,3\n",
    ] {
        table("a.csv", text);
    }
}

/// A clock since 1970 in microseconds, whose decimals a double does not hold.
#[test]
fn val_definition_a_table_of_times_since_1970() {
    let rows = (0..50).map(|n| format!("1764158400.{n:06},{}\n", n % 7));
    let field = table(
        "a.csv",
        &format!("time (s),a\n{}", rows.collect::<String>()),
    );
    assert_eq!((field.time.step, codes(&field)), (1e-6, vec!["rounded"]));
}

/// What looks like a row of settings, but is a damaged row of numbers.
#[test]
fn regress_a_damaged_row_is_no_preamble() {
    for (text, line, found) in [
        ("time,v\nq.5,1.0\n0.1,2\n0.2,3\n", 2, "q.5"),
        ("a,b\nx1,2.0\n3,4\n", 2, "x1"),
        ("a,b\n1,2\nx1,2.0\n3,4\n", 3, "x1"),
    ] {
        let expected = InputFault::Cell {
            line,
            column: 1,
            found: found.into(),
        };
        assert_eq!(fault("a.csv", text), expected, "{text}");
    }
}

/// A step that is stated over the times of a table is said, unless it is theirs.
#[test]
fn val_construction_a_stated_step_over_the_times_of_a_file() {
    let rows: String = (0..20)
        .map(|n| format!("{},{},{}\n", f64::from(n) / 100.0, n % 3, n % 5))
        .collect();
    let text = format!("time,a,b\n{rows}");
    let read = |dt: Option<f64>| {
        let options = reading(|it| it.dt = dt.map(Into::into));
        let field = table_with("a.csv", &text, &options);
        let replaced = note(&field, "replaced");
        let replaced = replaced.map(|note| (note.is_doubtful, note.text.clone()));
        (field.time.step, replaced)
    };
    assert_eq!(read(Some(0.01)), (0.01, None));
    assert_eq!(read(None).1, None);
    let (step, replaced) = read(Some(0.002));
    let (is_doubtful, said) = replaced.unwrap();
    assert!(!is_doubtful, "{said}");
    assert!(said.contains("0.002"), "{said}");
    assert!(said.contains("0.01"), "{said}");
    assert_eq!(step, 0.002);
}

/// As `DataFrame(V, index=T, columns=X).to_csv()` writes it: an empty corner, positions, times.
#[test]
fn val_definition_positions_above_an_index() {
    for corner in ["", "nan"] {
        let text = format!("{corner},0.0,0.5,1.0\n0.0,1,2,3\n0.1,4,0,6\n0.2,2,8,5\n");
        let field = table("frame.csv", &text);
        let expected = ndarray::array![[1.0, 2.0, 3.0], [4.0, 0.0, 6.0], [2.0, 8.0, 5.0]];
        assert_eq!(values(&field), expected);
        assert!((field.time.step - 0.1).abs() < 1e-15 && field.space.step == 0.5);
    }
    // A first sample that is missing is none.
    let field = table("gap.csv", "nan,0.3,0.5,1.0\n4,5,6,7\n7,8,9,9\n");
    assert_eq!(field.n_times(), 3);
}

/// Each setting counts in its own unit, and a rate in hertz.
#[test]
fn val_definition_settings_have_units_of_their_own() {
    let ms = |origin: f64, step: f64| axis(origin, step, Some("ms"));
    let s = |origin: f64, step: f64| axis(origin, step, Some("s"));
    for (settings, time) in [
        ("Horizontal Units,ms\nSample Rate,1000", ms(0.0, 1.0)),
        ("Sample Rate,1000\nHorizontal Units,ms", ms(0.0, 1.0)),
        ("Horizontal Units,ms\nSample Interval,1 ms", ms(0.0, 1.0)),
        ("Horizontal Units,ms\nSample Interval,1", ms(0.0, 1.0)),
        ("Sample Interval,1,ms\nStart,0.005,s", s(0.005, 1e-3)),
        ("Start,5,ms\nSample Interval,0.001,s", s(0.005, 1e-3)),
        ("Start,5,ms\nSample Rate,1000,Hz", s(0.005, 1e-3)),
        ("Sample Rate,0.001,MHz\nName,a", s(0.0, 1e-3)),
        ("Sample Rate,1,kHz\nName,a", s(0.0, 1e-3)),
        ("Sample Rate (kHz),1\nName,a", s(0.0, 1e-3)),
        ("Sample Rate,1000 Sa/s\nName,a", s(0.0, 1e-3)),
        ("SampleRate,1 kSa/s\nName,a", s(0.0, 1e-3)),
        ("fs,1000\nName,a", s(0.0, 1e-3)),
    ] {
        let text = format!("{settings}\nx0,x1\n0.25,2\n0.5,1\n-0.125,4\n");
        let found = table("log.csv", &text).time;
        assert_eq!(found.unit, time.unit, "{settings}");
        assert!(
            (found.step / time.step - 1.0).abs() < 1e-12,
            "{settings}: {found:?}"
        );
        assert!(
            (found.origin - time.origin).abs() < 1e-12,
            "{settings}: {found:?}"
        );
    }
}
