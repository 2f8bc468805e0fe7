//! Fields as `cascade analyze` takes them: sizes, axes and cuts, and what is read back.

use ndarray::Array2;
use serde_json::{Value, json};
use test_support::contains_none;
use test_support::place::Place;
use test_support::pulse;

fn summary(place: &Place, options: &str) -> Value {
    let said = place.says(&format!("analyze wave.npy --json --force {options}"));
    serde_json::from_str(&said).unwrap()
}

#[test]
fn intervals_may_be_open_and_the_wave_is_cut_where_it_arrives() {
    let place = pulse::place();
    for (options, shape) in [
        ("--times :", [96, 12]),
        ("--times 0.5:", [46, 12]),
        ("--times=-1:0.1", [11, 12]),
        ("--times 0.1:9e99", [86, 12]),
        // At site 11 the pulse first exceeds 1 % of its peak, 0.91, at s = -16: in row 30.
        ("--until-arrival", [30, 12]),
    ] {
        let summary = summary(&place, &format!("{options} --figures none"));
        assert_eq!(summary["field"]["shape"], json!(shape), "{options:?}");
    }
}

#[test]
fn fields_of_a_few_samples_and_of_zeros_are_analysed() {
    let place = Place::new();
    let noise = |(i, j): (usize, usize)| (1.0 + i as f64 * 1.7 + j as f64 * 2.3).sin();
    let mut fields =
        [(1, 1), (1, 5), (5, 1), (2, 2)].map(|shape| Array2::from_shape_fn(shape, noise));
    fields[3].fill(0.0);
    for field in fields {
        place.save("small.npy", &field);
        let said = place.says("analyze small.npy --force --out out");
        let json = place.read("out/summary.json");
        for text in [said, json] {
            contains_none(&text, &["NaN", "Infinity"]);
        }
    }
    assert!(place.json("out/summary.json")["direction"]["undirected"].is_null());
}

#[test]
fn arrays_read_back_with_their_axes() {
    let place = pulse::place();
    place.says("analyze wave.npy --figures none --scaling density");
    let npz = "wave-cascade/spectra.npz";
    let frequency = place.array::<f64>(npz, "frequency");
    let spectrum = place.array::<f64>(npz, "temporal_spectrum");
    assert_eq!((spectrum.shape(), frequency.len()), (&[49, 12][..], 49));
    let df = frequency[[1]] - frequency[[0]];
    for (site, record) in pulse::wave(96, 12).columns().into_iter().enumerate() {
        let mean_square = record.iter().map(|v| v * v).sum::<f64>() / 96.0;
        let sum: f64 = (0..49).map(|m| spectrum[[m, site]]).sum();
        assert!((sum * df / mean_square - 1.0).abs() < 1e-13);
    }
}
