//! Fields with gaps, faulty channels and noise, as a stranger analyses them.

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::{Place, text};

/// Six sites with noise above a tenth of the axis; one misses samples, one always does, one is dead.
fn place() -> Place {
    let place = Place::new();
    let source = noise(2048, 6);
    let mut values = Array2::from_shape_fn((2048, 6), |(n, j)| {
        let phase = 0.2 * n as f64 - 0.5 * j as f64;
        phase.sin() * (1.0 + 0.3 * (0.011 * n as f64).sin()) + 0.05 * source[[n, j]]
    });
    values.slice_mut(ndarray::s![300..700, 1]).fill(f64::NAN);
    values.slice_mut(ndarray::s![..;50, 4]).fill(f64::NAN);
    values.column_mut(2).fill(0.25);
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_gaps_faults_and_noise_are_named_and_left_out() {
    let place = place();
    let axes = ["--dt", "1ms", "--dx", "2mm"];
    let said = place.good(&[&["inspect", "field.npy", "--channels"][..], &axes].concat());
    for part in [
        "channels",
        "at 2 sites were not finite",
        "site 2 at 0.004 m is constant",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let with = |more: &[&str]| {
        let words = [
            &[
                "spectrum",
                "field.npy",
                "--segment",
                "256",
                "--figures",
                "none",
            ][..],
            &axes,
        ];
        let output = place.run(&[&words.concat()[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        [text(&output.stdout), text(&output.stderr)].concat()
    };
    let said = with(&["--gaps", "leave-out", "--subtract-noise"]);
    for part in [
        "2 of 6 sites lose segments",
        "below the noise and are 0",
        "in all 15 segments and are left out: 4",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let summary = place.json("field-spectrum/summary.json");
    assert_eq!(summary["segments_left"]["left"][1], 10);
    assert_eq!(summary["segments_left"]["left"][4], 0);
    assert_eq!(summary["noise"]["known"], 4);
    let clipped = &summary["noise"]["subtracted"]["clipped_bins"];
    assert!(
        clipped[0].as_u64().unwrap() > 10 && clipped[2] == 0,
        "{clipped}"
    );
    let path = place.path("field-spectrum/spectrum.npz");
    let mut archive = NpzReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let density: Array1<f64> = archive.by_name("noise").unwrap();
    assert!(
        (density[0] / (2e-3 * 0.0025) - 1.0).abs() < 0.2,
        "{density}"
    );
    let segments: Array1<f64> = archive.by_name("segments").unwrap();
    assert_eq!(segments.to_vec(), [15.0, 10.0, 15.0, 15.0, 0.0, 15.0]);

    let analyze = |more: &[&'static str]| -> Vec<&'static str> {
        let words = ["analyze", "field.npy", "--figures", "none", "--force"];
        [&words[..], &axes, more].concat()
    };
    let said = place.good(&analyze(&["--without-sites", "1,2,4"]));
    assert!(
        said.contains("3 sites are left out: 1, 2, 4 at 0.002, 0.004, 0.008 m"),
        "{said}"
    );
    let summary = place.json("field-cascade/summary.json");
    assert!(summary["direction"].is_null());
    place.good(&analyze(&["--without-sites", "1,2,4", "--subtract-noise"]));
    let summary = place.json("field-cascade/summary.json");
    assert_eq!(summary["noise"]["known"], 3);
    for (more, option) in [
        (
            &["--without-sites", "2", "--only", "spacetime"][..],
            "without-sites",
        ),
        (&["--gaps", "leave-out"], "gaps"),
    ] {
        let error = place.bad(2, &analyze(more));
        assert!(error.contains(option), "{error}");
    }
}
