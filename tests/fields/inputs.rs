//! Files as people write them are read as they meant them, or asked about.
//!
//! `val_numpy_*`: the text or the arrays are those of the NumPy call that is named.

use std::fs;

use ndarray::Array2;
use ndarray_npy::NpzWriter;
use test_support::contains_all;
use test_support::fields::reading;
use test_support::made::{axis, fault, open, pulse, savez, steps, values};
use test_support::place::Place;
use wavecascade::Field;
use wavecascade::field::{Layout, OpenOptions};

use crate::texts;

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
