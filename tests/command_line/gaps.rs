//! Fields with gaps, faulty channels and noise, as a stranger analyses them.

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// Six sites with noise above a tenth of the axis; one misses samples, one always does, one is dead.
#[test]
fn regress_gaps_faults_and_noise_are_named_and_left_out() {
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
    let said = place.says("inspect field.npy --channels --dt 1ms --dx 2mm");
    let named = said.contains("2 of 6 sites were not finite")
        && said.contains("site 2 at 0.004 m: constant");
    assert!(named, "{said}");
    let line = "spectrum field.npy --segment 256 --figures none --dt 1ms --dx 2mm --gaps leave-out \
                --subtract-noise";
    let output = place.run(&line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let summary = place.json("field-spectrum/summary.json");
    assert_eq!(summary["segments_left"]["left"][1], 10);
    assert_eq!(summary["segments_left"]["left"][4], 0);
    assert_eq!(summary["noise"]["known"], 4);
    let clipped = &summary["noise"]["subtracted"]["clipped_bins"];
    assert!(clipped[0].as_u64().unwrap() > 10, "{clipped}");
    assert_eq!(clipped[2], 0);
    let array = |name: &str| place.array::<f64>("field-spectrum/spectrum.npz", name);
    let density = array("noise")[0];
    assert!((density / (2e-3 * 0.0025) - 1.0).abs() < 0.2, "{density}");
    let segments = array("segments").into_raw_vec_and_offset().0;
    assert_eq!(segments, [15.0, 10.0, 15.0, 15.0, 0.0, 15.0]);
    let analyze = "analyze field.npy --figures none --gaps leave-out";
    place.refuses_for(2, analyze, "gaps");
}
