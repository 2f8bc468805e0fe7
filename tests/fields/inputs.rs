//! Files as people write them are read as they meant them, or asked about.
//!
//! `val_numpy_*`: the text or the arrays are those of the NumPy call that is named.

use std::fs;

use ndarray::Array2;
use ndarray_npy::NpzWriter;
use test_support::contains_all;
use test_support::fields::reading;
use test_support::made::{axis, fault, open, pulse, savetxt, savez, steps, values};
use test_support::place::Place;
use wavecascade::Field;
use wavecascade::error::{CoordinateKind, InputFault};
use wavecascade::field::{Axis, Layout, OpenOptions, TimeColumn};

use crate::texts;

#[test]
fn val_numpy_savetxt_with_a_header() {
    let place = Place::new();
    let field = pulse(40, 2);
    // header="time,x0,x1"; "# " comes before it unless comments='' is given.
    for header in [
        "# time,x0,x1\n",
        "time,x0,x1\n",
        "# time x0 x1\n",
        "time x0 x1\n",
        "# run 7\n# time\tx0\tx1\n",
        "# t (s), left, right\n",
    ] {
        for delimiter in [" ", ",", "\t"] {
            place.write("a.txt", savetxt(header, delimiter, &field, 1e-5));
            let read = open(&place, "a.txt");
            assert_eq!(values(&read), field, "{header:?} {delimiter:?}");
            let unit = header.contains("(s)").then_some("s");
            assert_eq!(read.time, axis(1e-5, unit), "{header:?} {delimiter:?}");
            assert_eq!(read.notes, []);
        }
    }
    // Positions as names.
    let text = savetxt("# time,0.5,0.75\n", ",", &field, 1e-5);
    place.write("a.txt", text);
    let space = open(&place, "a.txt").space;
    assert_eq!((space.origin, space.step), (0.5, 0.25));
}

#[test]
fn val_numpy_savetxt_without_a_header() {
    let place = Place::new();
    let field = pulse(40, 2);
    for header in ["", "# a comment\n", "clock,x0,x1\n", "# 1,2,3\n"] {
        place.write("a.csv", savetxt(header, ",", &field, 2.5e-4));
        let read = open(&place, "a.csv");
        assert_eq!(values(&read), field, "{header:?}");
        assert_eq!(read.time, axis(2.5e-4, None));
        let said = "the first column holds the times, since it rises evenly by 0.00025";
        assert_eq!(texts(&read), [said]);
        let options = reading(|it| it.time_column = TimeColumn::None);
        let all = Field::open(place.path("a.csv"), &options).unwrap();
        assert_eq!((all.n_sites(), all.notes.len()), (3, 0));
    }
}

#[test]
fn what_may_be_a_time_column_is_asked_about() {
    let place = Place::new();
    for (table, reason) in [
        // Both columns rise evenly.
        ("0,1\n1,2\n2,3\n", "rises evenly, and so does another"),
        // Times of which one is missing.
        ("0,1\n1,5\n2,1\n3,5\n4,1\n5,5\n7,1\n8,5\n", "rises unevenly"),
    ] {
        place.write("a.csv", table);
        let coordinates = CoordinateKind::Times;
        let found = fault(&place, "a.csv", &OpenOptions::default());
        let expected = InputFault::FirstColumn {
            coordinates,
            reason,
        };
        assert_eq!(found, expected);
    }
    // Samples that do not rise, or too few of them to tell.
    for table in [
        "0,1\n1,2\n",
        "3,1\n2,5\n1,2\n",
        "1\n2\n3\n",
        "1,2\n2,5\n3.5,1\n",
    ] {
        place.write("a.csv", table);
        let field = open(&place, "a.csv");
        assert_eq!(field.time, Axis::index(), "{table}");
        assert_eq!(field.notes, [], "{table}");
    }
    // Rows that are sites begin with their positions.
    let text = "0,1,5,2\n0.5,3,1,1\n1,2,2,7\n";
    place.write("a.csv", text);
    let options = reading(|it| it.layout = Some(Layout::SiteTime));
    let field = Field::open(place.path("a.csv"), &options).unwrap();
    assert_eq!((field.n_times(), field.n_sites()), (3, 3));
    assert_eq!(field.space, axis(0.5, None));
    place.write("a.csv", format!("x_mm,0,2,4\n{text}"));
    let field = Field::open(place.path("a.csv"), &options).unwrap();
    assert_eq!(field.space, axis(0.5, Some("mm")));
    assert_eq!(field.time, axis(2.0, None));
}

#[test]
fn val_numpy_savez_with_short_names() {
    let place = Place::new();
    let field = pulse(40, 3);
    // numpy.savez(path, v=v, t=t, x=x), v as (time, site) and as (site, time).
    for turned in [false, true] {
        let stored = if turned {
            field.t().to_owned()
        } else {
            field.clone()
        };
        for names in [["v", "t", "x"], ["V", "T", "X"], ["data", "t", "x"]] {
            let axes = [(names[1], steps(40, 1e-5)), (names[2], steps(3, 0.002))];
            savez(&place, "a.npz", (names[0], &stored), &axes);
            let read = open(&place, "a.npz");
            assert_eq!(values(&read), field, "{names:?}");
            assert_eq!(read.time, axis(1e-5, None));
            assert_eq!(read.space, axis(0.002, None));
            let [v, t, x] = names;
            let said = format!("variable `{v}` is the field, `{t}` its times, `{x}` its sites");
            assert_eq!(texts(&read), [&said]);
        }
    }
    // Single precision: the step that was meant.
    let times: Vec<f32> = (0..40).map(|n| n as f32 * 1e-5).collect();
    savez(&place, "a.npz", ("v", &field), &[("t", times)]);
    assert_eq!(open(&place, "a.npz").time, axis(1e-5, None));
    // What has the name but not the length is no coordinate of it.
    savez(&place, "a.npz", ("v", &field), &[("t", steps(7, 1.0))]);
    let found = fault(&place, "a.npz", &OpenOptions::default()).to_string();
    contains_all(&found, &["\"t\"", "expected 40"]);
    // A second array of two dimensions does not hide the field.
    let mut archive = NpzWriter::new(fs::File::create(place.path("a.npz")).unwrap());
    archive.add_array("u", &(&field * 2.0)).unwrap();
    archive.add_array("v", &field).unwrap();
    archive.finish().unwrap();
    assert_eq!(values(&open(&place, "a.npz")), field);
}

#[test]
fn a_wide_array_is_asked_about() {
    let place = Place::new();
    place.save("wide.npy", &pulse(80, 10).t().to_owned());
    place.save("narrow.npy", &pulse(80, 79));
    assert_eq!(open(&place, "narrow.npy").notes, []);
    let said = &open(&place, "wide.npy").notes[0].text;
    contains_all(said, &["10 times of 80 sites", "80 times of 10 sites"]);
    for layout in [Layout::SiteTime, Layout::TimeSite] {
        let options = reading(|it| it.layout = Some(layout));
        let field = Field::open(place.path("wide.npy"), &options).unwrap();
        assert_eq!(field.notes, []);
    }
    let output = place.run(&["analyze", "wide.npy", "--figures", "none"]);
    assert!(output.status.success(), "{output:?}");
    let summary = place.json("wide-cascade/summary.json");
    assert_eq!(summary["moved"], serde_json::Value::Null);
    let said = summary["answer"].as_str().unwrap();
    contains_all(said, &["`--layout time-site` reads 10 times of 80 sites"]);
    let first = &summary["warnings"][0];
    assert_eq!(first["code"], "wide-array");
    // Coordinates settle it, numpy.savez(path, v=v, t=t).
    savez(
        &place,
        "a.npz",
        ("v", &pulse(80, 10).t().to_owned()),
        &[("t", steps(80, 1.0))],
    );
    assert_eq!(values(&open(&place, "a.npz")), pulse(80, 10));
    savez(
        &place,
        "a.npz",
        ("v", &pulse(10, 80)),
        &[("t", steps(10, 1.0))],
    );
    assert!(
        !open(&place, "a.npz")
            .notes
            .iter()
            .any(|note| note.is_doubtful)
    );
}

#[test]
fn an_array_whose_first_site_holds_times_is_asked_about() {
    let place = Place::new();
    // numpy.save(path, numpy.column_stack([t, v]))
    let with_times = Array2::from_shape_fn((40, 4), |(n, j)| match j {
        0 => n as f64 * 1e-4,
        j => pulse(40, 3)[[n, j - 1]],
    });
    place.save("a.npy", &with_times);
    assert_eq!(open(&place, "a.npy").notes[0].code, "rising-site");
}
