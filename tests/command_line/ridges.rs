//! `cascade ridges` as a stranger runs it.

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// Waves of speed 2 both ways, at 60 frequencies, in noise.
fn place() -> Place {
    let place = Place::new();
    let random = noise(1024, 48);
    let values = Array2::from_shape_fn((1024, 48), |(n, j)| {
        let wave = |m: usize| {
            let f = 0.05 + 0.002 * m as f64;
            let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
            let phase = 7.3 * (m * m) as f64;
            (std::f64::consts::TAU * f * (n as f64 - sign * j as f64 / 2.0) + phase).cos()
        };
        (0..200).map(wave).sum::<f64>() + random[[n, j]]
    });
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_a_speed_is_found_fitted_and_written() {
    let place = place();
    let words = ["ridges", "field.npy", "--dt", "1ms", "--dx", "1m"];
    let fit = ["--fit", "c*abs(k); c=1", "--figures", "png"];
    let text = place.good(&[&words[..], &fit].concat());
    assert!(text.contains("c*abs(k): c = "), "{text}");
    // An existing result is replaced on request.
    place.good(&[&words[..], &fit, &["--force"]].concat());
    let summary = place.json("field-ridges/summary.json");
    assert_eq!(summary["schema"], "cascade.ridges/1");
    let speed = &summary["fits"][0]["parameters"][0];
    let [value, error] = ["value", "error"].map(|of| speed[of].as_f64().unwrap());
    assert!((value - 2000.0).abs() < 4.0 * error, "{speed}");
    assert!(error < 10.0, "{speed}");
    let table = place.read("field-ridges/ridges.csv");
    let k = place.array::<f64>("field-ridges/ridges.npz", "wavenumber");
    assert_eq!(table.lines().count(), k.len() + 1);
    assert!(k.iter().any(|k| *k > 0.5) && k.iter().any(|k| *k < -0.5));
    place.has("field-ridges", "report.html figures/ridges.png");
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    for (words, named) in [
        (&["--fit", "c*q; c=1"][..], "--fit"),
        (&["--fit", "monatomic:m=1"], "--fit"),
        (&["--fit", "b*c*abs(k); b=1, c=1"], "--fit"),
        (&["--segment", "2000"], "--segment"),
        (&["--points", "2"], "--points"),
        (&["--overlap", "50%"], "--segment"),
    ] {
        let words = [&["ridges", "field.npy"], words].concat();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
    }
}
